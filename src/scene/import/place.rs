//! A primitive's triangles put into the world: transformed, without the flat ones, with a normal at every vertex.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};
use gltf::json::accessor::Type;

use super::mesh::Triangles;
use super::tangents::{self, Corner};
use crate::scene::Scene;

/// Largest coordinate: squares of distances stay finite in f32.
const MAX_COORDINATE: f32 = 1e18;

/// A triangle in the world: what is at its corners.
struct Face {
    vertices: [u32; 3],
    positions: [Vec3; 3],
    /// Of the vertices themselves, where they have any.
    normals: [Option<DVec3>; 3],
    normal: DVec3,
}

/// Adds a primitive's triangles and the vertices they use to `scene`; returns how many were dropped for want of an area.
pub fn add_triangles(
    scene: &mut Scene,
    triangles: &Triangles,
    material: u32,
    world_from_mesh: DAffine3,
) -> Result<u64, String> {
    let world_from_normal = normal_matrix(world_from_mesh.matrix3);
    let mirrored = world_from_mesh.matrix3.determinant() < 0.0;
    let mut faces = Vec::with_capacity(triangles.corners.len());
    for &[a, b, c] in &triangles.corners {
        let vertices = if mirrored { [a, c, b] } else { [a, b, c] };
        let mut positions = [Vec3::ZERO; 3];
        for (vertex, position) in vertices.iter().zip(&mut positions) {
            *position = world_from_mesh.transform_point3(triangles.positions.at(*vertex)).as_vec3();
            if !position.is_finite() || position.abs().max_element() > MAX_COORDINATE {
                return Err(format!(
                    "the position of vertex {vertex} is not finite or too large: export the file again"
                ));
            }
        }
        let Some(normal) = face_normal(positions) else { continue };
        let normals = vertices.map(|vertex| {
            let smooth = triangles.normals.as_ref().and_then(|normals| unit(normals.at(vertex)));
            smooth.and_then(|normal| unit(world_from_normal * normal))
        });
        faces.push(Face { vertices, positions, normals, normal });
    }
    if scene.materials[material as usize].is_plain() && scene.materials[material as usize].is_masked_out() {
        return Ok(0);
    }
    let mapped = scene.materials[material as usize].tangent_slot().is_some();
    let tangents = if mapped { tangents_of(scene, triangles, material, &faces, world_from_mesh) } else { Vec::new() };
    // Scene vertex of each smooth vertex of the primitive that is in use, by the sign of its bitangent.
    let mut added: HashMap<(u32, bool), u32> = HashMap::new();
    for (n, face) in faces.iter().enumerate() {
        let triangle = std::array::from_fn(|i| {
            let tangent = tangents.get(n).map(|corners: &[DVec4; 3]| corners[i]);
            let key = (face.vertices[i], tangent.is_some_and(|t| t.w < 0.0));
            if let Some(&vertex) = added.get(&key) {
                return vertex;
            }
            let new = scene.positions.len() as u32;
            // Without a normal of its own the corner is flat, so that faces do not share it.
            if face.normals[i].is_some() {
                added.insert(key, new);
            }
            scene.positions.push(face.positions[i]);
            scene.normals.push(face.normals[i].unwrap_or(face.normal).as_vec3());
            add_attributes(scene, triangles, material, face.vertices[i], tangent);
            new
        });
        scene.triangles.push(triangle);
        scene.triangle_materials.push(material);
    }
    Ok((triangles.corners.len() - faces.len()) as u64)
}

/// Texture coordinates, tangent and colour of the vertex that was added last, as far as its material needs them.
fn add_attributes(scene: &mut Scene, triangles: &Triangles, material: u32, vertex: u32, tangent: Option<DVec4>) {
    let (material, before) = (&scene.materials[material as usize], scene.positions.len() - 1);
    if material.textures.all().next().is_some() {
        scene.coordinates.resize(before, [Vec2::ZERO; 2]);
        scene.coordinates.push([0, 1].map(|slot| coordinates(triangles, slot, vertex).as_vec2()));
    }
    if let Some(tangent) = tangent {
        scene.tangents.resize(before, Vec4::ZERO);
        scene.tangents.push(tangent.as_vec4());
    }
    if material.vertex_colored {
        let color = triangles.colors.as_ref().map_or(DVec4::ONE, |(colors, kind)| match kind {
            Type::Vec3 => DVec3::from_array(colors.vector(vertex.into())).extend(1.0),
            _ => DVec4::from_array(colors.vector(vertex.into())),
        });
        scene.colors.resize(before, Vec4::ONE);
        // NaN becomes 0.
        scene.colors.push(color.as_vec4().max(Vec4::ZERO).min(Vec4::ONE));
    }
}

/// Of a slot that the primitive has no coordinates for: zero.
fn coordinates(triangles: &Triangles, slot: usize, vertex: u32) -> DVec2 {
    let at = triangles.coordinates[slot].as_ref().map(|data| DVec2::from_array(data.vector(vertex.into())));
    at.filter(|at| at.is_finite()).unwrap_or(DVec2::ZERO)
}

/// Unit tangent and sign of the bitangent at every corner, for the normal texture: the file's, or made.
fn tangents_of(
    scene: &Scene,
    triangles: &Triangles,
    material: u32,
    faces: &[Face],
    world_from_mesh: DAffine3,
) -> Vec<[DVec4; 3]> {
    let normal = |face: &Face, i: usize| face.normals[i].unwrap_or(face.normal);
    if let Some(tangents) = &triangles.tangents {
        let mirror = if world_from_mesh.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let of_corner = |face: &Face, i: usize| {
            let [x, y, z, w] = tangents.vector(face.vertices[i].into());
            let normal = normal(face, i);
            let along = world_from_mesh.matrix3 * DVec3::new(x, y, z);
            let along = along.reject_from_normalized(normal).try_normalize();
            let sign = if w < 0.0 { -mirror } else { mirror };
            along.unwrap_or_else(|| normal.any_orthonormal_vector()).extend(sign)
        };
        return faces.iter().map(|face| std::array::from_fn(|i| of_corner(face, i))).collect();
    }
    let slot = scene.materials[material as usize].tangent_slot().unwrap_or(0);
    let corners = |face: &Face| {
        std::array::from_fn(|i| Corner {
            position: face.positions[i].as_dvec3(),
            normal: normal(face, i),
            coordinates: coordinates(triangles, slot, face.vertices[i]),
        })
    };
    tangents::of(&faces.iter().map(corners).collect::<Vec<_>>())
}

/// What takes normals along with `m`: its inverse transposed up to a positive factor, and no division if it is singular.
fn normal_matrix(m: DMat3) -> DMat3 {
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    sign * DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// `v` at length 1; None for a vector of next to no length, or none that is finite.
fn unit(v: DVec3) -> Option<DVec3> {
    v.try_normalize()
}

/// Unit normal of a counter-clockwise triangle; None where f32 arithmetic could not tell it from a line or a point.
fn face_normal([a, b, c]: [Vec3; 3]) -> Option<DVec3> {
    let [a, b, c] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
    let cross = (b - a).cross(c - a);
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    let thinnest = f64::max(1e-9 * longest, 1e-18);
    (cross.length() > thinnest).then(|| cross.normalize())
}
