//! A primitive's triangles put into the world: transformed, without the flat ones, with a normal at every vertex.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::mesh::Triangles;
use crate::scene::Scene;

/// Largest coordinate: squares of distances stay finite in f32.
const MAX_COORDINATE: f32 = 1e18;

/// Adds a primitive's triangles and the vertices they use to `scene`; returns how many were dropped for want of an area.
pub fn add_triangles(
    scene: &mut Scene,
    triangles: &Triangles,
    material: u32,
    world_from_mesh: DAffine3,
) -> Result<u64, String> {
    let mut dropped = 0;
    let world_from_normal = normal_matrix(world_from_mesh.matrix3);
    let mirrored = world_from_mesh.matrix3.determinant() < 0.0;
    // Scene vertex of each smooth vertex of the primitive that is in use.
    let mut added: HashMap<u32, u32> = HashMap::new();
    for &[a, b, c] in &triangles.corners {
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        let mut positions = [Vec3::ZERO; 3];
        for (vertex, position) in corners.iter().zip(&mut positions) {
            *position = world_from_mesh.transform_point3(triangles.positions.at(*vertex)).as_vec3();
            if !position.is_finite() || position.abs().max_element() > MAX_COORDINATE {
                return Err(format!(
                    "the position of vertex {vertex} is not finite or too large: export the file again"
                ));
            }
        }
        let Some(face_normal) = face_normal(positions) else {
            dropped += 1;
            continue;
        };
        let triangle = std::array::from_fn(|i| {
            if let Some(&vertex) = added.get(&corners[i]) {
                return vertex;
            }
            let new = scene.positions.len() as u32;
            let smooth = triangles
                .normals
                .as_ref()
                .and_then(|normals| unit(normals.at(corners[i])).and_then(|normal| unit(world_from_normal * normal)));
            // Without a normal of its own the corner is flat, so that faces do not share it.
            if smooth.is_some() {
                added.insert(corners[i], new);
            }
            scene.positions.push(positions[i]);
            scene.normals.push(smooth.unwrap_or(face_normal).as_vec3());
            new
        });
        scene.triangles.push(triangle);
        scene.triangle_materials.push(material);
    }
    Ok(dropped)
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
