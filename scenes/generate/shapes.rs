//! Solids and surfaces, all closed and outward unless they say otherwise.

use crate::mesh::Mesh;
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// A parallelogram that faces `u x v`.
pub fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.polygon(&[corner, corner + u, corner + u + v, corner + v]);
    mesh
}

/// A box from `low` to `high` with flat faces.
pub fn cuboid(low: Vec3, high: Vec3) -> Mesh {
    let d = high - low;
    let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
    let mut mesh = Mesh::default();
    for (corner, u, v) in [(low, y, x), (low, z, y), (low, x, z), (high, -x, -y), (high, -y, -z), (high, -z, -x)] {
        mesh.append(&quad(corner, u, v));
    }
    mesh
}

/// Shorthand for a box by its ranges along x, y and z.
pub fn block(x: [f32; 2], y: [f32; 2], z: [f32; 2]) -> Mesh {
    cuboid(Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1]))
}

/// A box about the origin whose edges and corners are rounded with `radius`, in `steps` per quarter.
pub fn rounded_box(half: Vec3, radius: f32, steps: u32) -> Mesh {
    let inner = half - Vec3::splat(radius);
    // Along each axis: the rounded end, then the flat middle, then the other end. tan spaces the arc evenly.
    let ticks = |axis: usize| -> Vec<f32> {
        let arc = |k: u32| radius * (k as f32 / steps as f32 * TAU / 8.0).tan();
        let end = (0..=steps).map(|k| inner[axis] + arc(k));
        let start = (0..=steps).rev().map(|k| -inner[axis] - arc(k));
        start.chain(end).collect()
    };
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (us, vs) = (ticks(a), ticks(b));
        for side in [-1.0, 1.0] {
            let first = mesh.positions.len() as u32;
            for &u in &us {
                for &v in &vs {
                    let mut p = Vec3::ZERO;
                    p[axis] = side * half[axis];
                    p[a] = u;
                    p[b] = v;
                    let core = p.clamp(-inner, inner);
                    let normal = (p - core).normalize();
                    mesh.vertex(core + radius * normal, normal);
                }
            }
            grid(&mut mesh, first, us.len(), vs.len(), side < 0.0);
        }
    }
    mesh
}

/// Triangles over a grid of vertices, row by row; `flip` turns the side that faces out.
fn grid(mesh: &mut Mesh, first: u32, rows: usize, columns: usize, flip: bool) {
    for r in 0..rows as u32 - 1 {
        for c in 0..columns as u32 - 1 {
            let at = |dr: u32, dc: u32| first + (r + dr) * columns as u32 + c + dc;
            for [i, j, k] in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                mesh.triangles.push(if flip { [i, k, j] } else { [i, j, k] });
            }
        }
    }
}

/// A unit sphere: an icosahedron split `levels` times (20 * 4^levels triangles).
pub fn icosphere(levels: u32) -> Mesh {
    let t = (1.0 + 5f32.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        points.push(Vec3::new(a, b, 0.0));
    }
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        points.push(Vec3::new(0.0, a, b));
    }
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        points.push(Vec3::new(b, 0.0, a));
    }
    points.iter_mut().for_each(|p| *p = p.normalize());
    let mut triangles = hull_triangles(&points);
    for _ in 0..levels {
        let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                points.push((points[i as usize] + points[j as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { normals: points.clone(), positions: points, triangles }
}

/// The triangles of a convex hull in general position: every triple with all other points behind it.
/// Cubic times linear, for a few dozen points.
pub fn hull_triangles(points: &[Vec3]) -> Vec<[u32; 3]> {
    let n = points.len();
    let wide = |i: usize| points[i].as_dvec3();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let normal = (wide(j) - wide(i)).cross(wide(k) - wide(i));
                let others = (0..n).filter(|&m| m != i && m != j && m != k);
                let sides: Vec<f64> = others.map(|m| normal.dot(wide(m) - wide(i))).collect();
                if sides.iter().all(|&s| s < 0.0) {
                    triangles.push([i as u32, j as u32, k as u32]);
                } else if sides.iter().all(|&s| s > 0.0) {
                    triangles.push([i as u32, k as u32, j as u32]);
                }
            }
        }
    }
    triangles
}

/// A profile for [`lathe`]: points (radius, height) with the normal that each has.
pub type Profile = Vec<(Vec2, Vec2)>;

/// A smooth profile (Catmull-Rom) through `points`, `steps` per span; it runs counter-clockwise
/// around the solid's half section: outwards along the bottom, up the side, inwards along the top.
pub fn smooth_profile(points: &[[f32; 2]], steps: u32) -> Profile {
    let p: Vec<Vec2> = points.iter().map(|&p| Vec2::from(p)).collect();
    let n = p.len();
    // Mirrored in the axis beyond both ends, so that the poles come out level.
    let get = |i: isize| -> Vec2 {
        let mirror = |q: Vec2| Vec2::new(-q.x, q.y);
        match i {
            -1 => mirror(p[1]),
            i if i as usize >= n => mirror(p[n - 2]),
            i => p[i as usize],
        }
    };
    let mut profile = Profile::new();
    for i in 0..n as isize - 1 {
        let [a, b, c, d] = [get(i - 1), get(i), get(i + 1), get(i + 2)];
        // Centripetal knots (Barry and Goldman 1988): no overshoot where the points' distances differ.
        let [k0, k1, k2] = [(b - a), (c - b), (d - c)].map(|e| e.length().sqrt());
        let m0 = k1 * ((b - a) / k0 - (c - a) / (k0 + k1)) + (c - b);
        let m1 = k1 * ((d - c) / k2 - (d - b) / (k1 + k2)) + (c - b);
        let last = if i == n as isize - 2 { steps } else { steps - 1 };
        for s in 0..=last {
            let t = s as f32 / steps as f32;
            let (t2, t3) = (t * t, t * t * t);
            let position =
                (2.0 * t3 - 3.0 * t2 + 1.0) * b + (t3 - 2.0 * t2 + t) * m0 + (3.0 * t2 - 2.0 * t3) * c + (t3 - t2) * m1;
            let tangent = (6.0 * t2 - 6.0 * t) * (b - c) + (3.0 * t2 - 4.0 * t + 1.0) * m0 + (3.0 * t2 - 2.0 * t) * m1;
            let normal = Vec2::new(tangent.y, -tangent.x).normalize();
            profile.push((position.max(Vec2::new(0.0, f32::NEG_INFINITY)), normal));
        }
    }
    profile
}

/// A solid of revolution about +y. The profile starts and ends on the axis.
pub fn lathe(profile: &Profile, segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let (bottom, top) = (profile[0].0, profile[profile.len() - 1].0);
    let ring = &profile[1..profile.len() - 1];
    let south = mesh.vertex(Vec3::new(0.0, bottom.y, 0.0), Vec3::Y * profile[0].1.y.signum());
    let end_normal = profile[profile.len() - 1].1.y.signum();
    let north = mesh.vertex(Vec3::new(0.0, top.y, 0.0), Vec3::Y * end_normal);
    let first = mesh.positions.len() as u32;
    for &(p, n) in ring {
        for s in 0..segments {
            let (sin, cos) = (s as f32 / segments as f32 * TAU).sin_cos();
            let around = |q: Vec2| Vec3::new(q.x * cos, q.y, -q.x * sin);
            mesh.vertex(around(p), around(n).normalize());
        }
    }
    let at = |r: usize, s: u32| first + r as u32 * segments + s % segments;
    for s in 0..segments {
        mesh.triangles.push([south, at(0, s + 1), at(0, s)]);
        for r in 0..ring.len() - 1 {
            mesh.triangles.push([at(r, s), at(r, s + 1), at(r + 1, s + 1)]);
            mesh.triangles.push([at(r, s), at(r + 1, s + 1), at(r + 1, s)]);
        }
        mesh.triangles.push([north, at(ring.len() - 1, s), at(ring.len() - 1, s + 1)]);
    }
    mesh
}

/// Catmull-Rom through points of x, y, z and a radius; the ends are kept.
pub fn spline(points: &[[f32; 4]], steps: u32) -> Vec<[f32; 4]> {
    let at = |i: isize| Vec4::from(points[i.clamp(0, points.len() as isize - 1) as usize]);
    let mut out = Vec::new();
    for i in 0..points.len() as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for s in 0..steps {
            let t = s as f32 / steps as f32;
            let (t2, t3) = (t * t, t * t * t);
            let cubic =
                2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t2 + (3.0 * b - a - 3.0 * c + d) * t3;
            out.push((0.5 * cubic).to_array());
        }
    }
    out.push(points[points.len() - 1]);
    out
}

/// A rod along `path` (x, y, z, radius) with flat ends.
pub fn rod(path: &[[f32; 4]], segments: u32) -> Mesh {
    let point = |i: usize| Vec3::from_slice(&path[i]);
    let n = path.len();
    let tangent = |i: usize| (point((i + 1).min(n - 1)) - point(i.saturating_sub(1))).normalize();
    let mut mesh = Mesh::default();
    let mut side = tangent(0).any_orthonormal_vector();
    for (i, ball) in path.iter().enumerate() {
        // Carried along with the least twist.
        side = (side - side.dot(tangent(i)) * tangent(i)).normalize();
        let other = tangent(i).cross(side);
        for s in 0..segments {
            let (sin, cos) = (s as f32 / segments as f32 * TAU).sin_cos();
            let normal = cos * side + sin * other;
            mesh.vertex(point(i) + ball[3] * normal, normal);
        }
    }
    let at = |i: usize, s: u32| i as u32 * segments + s % segments;
    for i in 0..n - 1 {
        for s in 0..segments {
            mesh.triangles.push([at(i, s), at(i, s + 1), at(i + 1, s + 1)]);
            mesh.triangles.push([at(i, s), at(i + 1, s + 1), at(i + 1, s)]);
        }
    }
    let ring = |i: usize| (0..segments).map(move |s| at(i, s) as usize).collect::<Vec<_>>();
    let corners = |ids: Vec<usize>| ids.iter().map(|&id| mesh.positions[id]).collect::<Vec<_>>();
    let (mut start, end) = (corners(ring(0)), corners(ring(n - 1)));
    start.reverse();
    mesh.polygon(&start);
    mesh.polygon(&end);
    mesh
}

/// An ellipsoid about the origin.
pub fn ellipsoid(radii: Vec3, levels: u32) -> Mesh {
    let mut mesh = icosphere(levels);
    mesh.normals.iter_mut().for_each(|n| *n = (*n / radii).normalize());
    mesh.positions.iter_mut().for_each(|p| *p *= radii);
    mesh
}
