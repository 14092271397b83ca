//! Closed smooth meshes of signed distance functions, by surface nets (Gibson 1998).
//! Glass needs one closed skin, which a union of overlapping parts would not be.

use crate::mesh::Mesh;
use glam::{UVec3, Vec3};
use std::collections::BTreeMap;

/// The zero set of `distance` (negative inside) within the box, from cells of size `cell`.
pub fn surface(low: Vec3, high: Vec3, cell: f32, distance: impl Fn(Vec3) -> f32) -> Mesh {
    let size = ((high - low) / cell).ceil().as_uvec3() + UVec3::ONE;
    let index = |c: UVec3| ((c.z * size.y + c.y) * size.x + c.x) as usize;
    let place = |c: UVec3| low + cell * c.as_vec3();
    let mut values = Vec::with_capacity((size.x * size.y * size.z) as usize);
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                values.push(distance(place(UVec3::new(x, y, z))));
            }
        }
    }
    let inside = |c: UVec3| values[index(c)] < 0.0;

    let mut mesh = Mesh::default();
    let mut vertex_of: BTreeMap<usize, u32> = BTreeMap::new();
    let mut net = |cell_at: UVec3, mesh: &mut Mesh| -> u32 {
        *vertex_of.entry(index(cell_at)).or_insert_with(|| {
            let start = crossing_mean(cell_at, &place, &|c| values[index(c)]);
            let (position, normal) = project(start, cell, &distance);
            mesh.vertex(position, normal)
        })
    };
    for z in 1..size.z - 1 {
        for y in 1..size.y - 1 {
            for x in 1..size.x - 1 {
                let at = UVec3::new(x, y, z);
                for axis in 0..3 {
                    let step = UVec3::AXES[axis];
                    if inside(at) == inside(at + step) {
                        continue;
                    }
                    let (a, b) = (UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]);
                    // The four cells around this grid edge, counter-clockwise about +axis.
                    let mut ring = [at - a - b, at - b, at, at - a].map(|cell_at| net(cell_at, &mut mesh));
                    if !inside(at) {
                        ring.reverse();
                    }
                    let corner = |i: usize| mesh.positions[ring[i] as usize];
                    let [p, q, r, s] = ring;
                    if corner(0).distance(corner(2)) <= corner(1).distance(corner(3)) {
                        mesh.triangles.extend([[p, q, r], [p, r, s]]);
                    } else {
                        mesh.triangles.extend([[q, r, s], [q, s, p]]);
                    }
                }
            }
        }
    }
    mesh
}

/// The mean of the points where the cell's edges cross the surface.
fn crossing_mean(at: UVec3, place: &impl Fn(UVec3) -> Vec3, value: &impl Fn(UVec3) -> f32) -> Vec3 {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for axis in 0..3 {
        let (a, b) = (UVec3::AXES[(axis + 1) % 3], UVec3::AXES[(axis + 2) % 3]);
        for base in [at, at + a, at + b, at + a + b] {
            let end = base + UVec3::AXES[axis];
            let (v0, v1) = (value(base), value(end));
            if (v0 < 0.0) != (v1 < 0.0) {
                sum += place(base).lerp(place(end), v0 / (v0 - v1));
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Newton's steps along the gradient onto the surface; no further than half a cell, to keep the order.
fn project(start: Vec3, cell: f32, distance: &impl Fn(Vec3) -> f32) -> (Vec3, Vec3) {
    let gradient = |p: Vec3| {
        let h = 0.1 * cell;
        let along = |e: Vec3| (distance(p + h * e) - distance(p - h * e)) / (2.0 * h);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
    };
    let mut p = start;
    for _ in 0..4 {
        let g = gradient(p);
        p -= distance(p) * g / g.length_squared().max(1e-6);
        p = start + (p - start).clamp_length_max(0.5 * cell);
    }
    (p, gradient(p).normalize())
}

/// Smooth minimum (polynomial): the fillet between two parts is about `fillet` wide.
pub fn blend(a: f32, b: f32, fillet: f32) -> f32 {
    let h = (fillet - (a - b).abs()).max(0.0) / fillet;
    a.min(b) - 0.25 * h * h * fillet
}

/// Distance to a chain of balls that changes its radius between the points (x, y, z, radius).
pub fn chain(p: Vec3, points: &[[f32; 4]]) -> f32 {
    let distance = |pair: &[[f32; 4]]| {
        let (a, b) = (Vec3::from_slice(&pair[0]), Vec3::from_slice(&pair[1]));
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, t)) - (pair[0][3] + t * (pair[1][3] - pair[0][3]))
    };
    points.windows(2).map(distance).fold(f32::INFINITY, f32::min)
}

/// Distance (near the surface) to an ellipsoid about `centre`.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = (p - centre) / radii;
    let k = q.length();
    k * (k - 1.0) / (q / radii).length().max(1e-6)
}
