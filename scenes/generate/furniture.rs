//! What stands and hangs in the room of `ajar`.

use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{cuboid, quad, rod, rounded_box, spline};
use glam::Vec3;

/// A table on four tapered legs; its top is at `height`, centred on the origin.
pub fn table(half_x: f32, half_z: f32, height: f32) -> Mesh {
    let top = rounded_box(Vec3::new(half_x, 0.018, half_z), 0.008, 3).at(0.0, height - 0.018, 0.0);
    let (ax, az) = (half_x - 0.10, half_z - 0.10);
    let apron = [
        cuboid(Vec3::new(-ax, height - 0.12, -az - 0.01), Vec3::new(ax, height - 0.03, -az + 0.01)),
        cuboid(Vec3::new(-ax, height - 0.12, az - 0.01), Vec3::new(ax, height - 0.03, az + 0.01)),
        cuboid(Vec3::new(-ax - 0.01, height - 0.12, -az), Vec3::new(-ax + 0.01, height - 0.03, az)),
        cuboid(Vec3::new(ax - 0.01, height - 0.12, -az), Vec3::new(ax + 0.01, height - 0.03, az)),
    ];
    let mut parts = vec![top];
    parts.extend(apron);
    for (x, z) in [(-ax, -az), (ax, -az), (ax, az), (-ax, az)] {
        parts.push(rod(&[[x, 0.001, z, 0.018], [x, height - 0.03, z, 0.032]], 24));
    }
    Mesh::joined(&parts)
}

/// A door leaf hinged on the y axis, from x = 0 to `width`, its front at z = 0, with sunk panels;
/// then its two lever handles.
pub fn door(width: f32, height: f32) -> (Mesh, Mesh) {
    let thick = 0.042;
    // Slightly past the hinge, into the frame, so that no light slips through there.
    let core = cuboid(Vec3::new(-0.012, 0.005, 0.010 - thick), Vec3::new(width, height, -0.010));
    let mut parts = vec![core];
    let (stile, middle) = (0.115, 0.95);
    for (low, high) in [(-0.012, -0.0), (-thick, 0.012 - thick)] {
        let rail = |x0: f32, x1: f32, y0: f32, y1: f32| cuboid(Vec3::new(x0, y0, low), Vec3::new(x1, y1, high));
        parts.push(rail(-0.012, stile, 0.006, height - 0.001));
        parts.push(rail(width - stile, width + 0.001, 0.006, height - 0.001));
        parts.push(rail(stile - 0.001, width - stile + 0.001, 0.007, 0.22));
        parts.push(rail(stile - 0.001, width - stile + 0.001, height - 0.13, height - 0.002));
        parts.push(rail(stile - 0.001, width - stile + 0.001, middle - 0.08, middle + 0.08));
        parts.push(rail(0.5 * width - 0.05, 0.5 * width + 0.05, middle + 0.079, height - 0.129));
    }
    let lever = |side: f32| {
        let z = if side > 0.0 { 0.0 } else { -thick };
        let (x, y) = (width - 0.06, 1.0);
        let plate = rounded_box(Vec3::new(0.02, 0.09, 0.004), 0.003, 2).at(x, y - 0.02, z);
        let path = spline(
            &[
                [x, y, z, 0.009],
                [x, y, z + side * 0.040, 0.009],
                [x - 0.015, y, z + side * 0.055, 0.009],
                [x - 0.060, y, z + side * 0.056, 0.009],
                [x - 0.125, y - 0.006, z + side * 0.050, 0.008],
            ],
            6,
        );
        Mesh::joined(&[plate, rod(&path, 16)])
    };
    (Mesh::joined(&parts), Mesh::joined(&[lever(1.0), lever(-1.0)]))
}

/// A frame of four bars in the plane z = 0, centred, hung so that it touches z = 0 from in front.
pub fn picture_frame(half_x: f32, half_y: f32) -> Mesh {
    let bar = 0.022;
    let lying = rounded_box(Vec3::new(half_x + 2.0 * bar, bar, 0.014), 0.006, 2);
    let standing = rounded_box(Vec3::new(bar, half_y + 0.002, 0.013), 0.006, 2);
    Mesh::joined(&[
        lying.clone().at(0.0, half_y + bar, 0.012),
        lying.at(0.0, -half_y - bar, 0.012),
        standing.clone().at(half_x + bar, 0.0, 0.012),
        standing.at(-half_x - bar, 0.0, 0.012),
    ])
}

/// A landscape out of paper cuts: one mesh per colour, from the back (the sky) to the front.
pub fn picture(half_x: f32, half_y: f32) -> [Mesh; 4] {
    let sky = quad(Vec3::new(-half_x, -half_y, 0.004), Vec3::X * 2.0 * half_x, Vec3::Y * 2.0 * half_y);
    let hills = |z: f32, base: f32, rise: f32, phase: f32| {
        let mut mesh = Mesh::default();
        let n = 20;
        let top = |i: u32| {
            let t = i as f32 / n as f32;
            let y = base + rise * (phase + 5.0 * t).sin() + 0.4 * rise * (2.3 * phase + 11.0 * t).sin();
            Vec3::new(half_x * (2.0 * t - 1.0), y * half_y, z)
        };
        for i in 0..n {
            let foot = |p: Vec3| Vec3::new(p.x, -half_y, z);
            let (a, b) = (top(i), top(i + 1));
            mesh.polygon(&[foot(a), foot(b), b, a]);
        }
        mesh
    };
    let n = 24;
    let rim: Vec<Vec3> = (0..n)
        .map(|i| {
            let (sin, cos) = (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
            Vec3::new(0.35 * half_x + 0.055 * cos, 0.42 * half_y + 0.055 * sin, 0.0045)
        })
        .collect();
    let mut sun = Mesh::default();
    sun.polygon(&rim);
    [sky, sun, hills(0.005, 0.05, 0.18, 0.6), hills(0.0055, -0.45, 0.15, 2.4)]
}

/// An open bookcase with its back to the plane x = 0, towards -x, from z = 0 to `width`; then its
/// books, one mesh per colour.
pub fn bookcase(width: f32, height: f32, shelves: u32, random: &mut Random) -> (Mesh, [Mesh; 5]) {
    let (depth, board) = (0.26, 0.022);
    let slab = |low: [f32; 3], high: [f32; 3]| cuboid(Vec3::from(low), Vec3::from(high));
    let mut parts = vec![
        slab([-depth, 0.001, -board], [-0.001, height, 0.0]),
        slab([-depth, 0.001, width], [-0.001, height, width + board]),
        slab([-0.012, 0.05, -0.001], [-0.002, height - 0.001, width + 0.001]),
    ];
    let mut books: [Mesh; 5] = Default::default();
    let pitch = (height - 0.06 - board) / shelves as f32;
    for s in 0..=shelves {
        let y = 0.06 + s as f32 * pitch;
        let front = 0.002 - depth;
        parts.push(slab([front, y, -0.001], [-0.005, y + board - 0.001, width + 0.001]));
        if s == shelves {
            break;
        }
        let mut z = 0.01;
        let filled = width * random.between(0.72, 0.99);
        while z < filled - 0.05 {
            let thick = random.between(0.018, 0.045);
            let tall = pitch * random.between(0.58, 0.86);
            let deep = random.between(0.15, 0.21);
            let colour = (random.unit() * 5.0) as usize;
            let low = [-0.02 - deep, y + board, z];
            books[colour].append(&slab(low, [-0.02, y + board + tall, z + thick]));
            z += thick + random.between(0.001, 0.003);
        }
    }
    (Mesh::joined(&parts), books)
}
