//! Splinters of glass on a pale ground under one small bright lamp: caustics, and little else.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{hull_triangles, quad};
use glam::{Quat, Vec2, Vec3};

/// Chosen by eye.
const SEED: u64 = 20;

/// Where the ground ends and the wall begins to rise (z).
const BEND: f32 = -1.9;

pub fn build() -> Document {
    let mut scene = Document::default();
    let slate = scene.material(Material::lambert("slate", [0.10, 0.115, 0.14]));
    let ground = scene.material(Material::lambert("ground", [0.60, 0.58, 0.55]));
    let tints = [
        ("clear", [1.0, 1.0, 1.0]),
        ("amber", [1.0, 0.89, 0.64]),
        ("sea", [0.74, 0.95, 0.97]),
        ("rose", [1.0, 0.76, 0.78]),
    ]
    .map(|(name, tint)| scene.material(Material::glass(name, tint, 1.5)));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.93, 0.82], 230.0));
    let panel = scene.material(Material::lamp("soft panel", [0.55, 0.75, 1.0], 1.2));

    let floor = quad(Vec3::new(-9.0, 0.0, BEND), Vec3::Z * (9.0 - BEND), Vec3::X * 18.0);
    scene.object("ground", &floor, ground);
    scene.object("backdrop", &backdrop(), slate);
    let half = 0.25;
    let square = quad(Vec3::new(-half, 0.0, -half), Vec3::X * 2.0 * half, Vec3::Z * 2.0 * half);
    let tilt = Quat::from_rotation_x(0.30) * Quat::from_rotation_z(0.25);
    scene.object("lamp", &square.moved(tilt, Vec3::new(-0.9, 3.6, -1.1)), lamp);
    // A dim panel out of view that only gives the facets something to reflect.
    let side = quad(Vec3::new(3.4, 0.3, 1.6), Vec3::Y * 2.0, Vec3::new(-0.6, 0.0, 2.6));
    scene.object("soft panel", &side, panel);

    let mut random = Random(SEED);
    let mut add = |mesh: Mesh, tint: usize| {
        let name = format!("shard {}", scene.objects());
        scene.object(&name, &mesh.closed(), tints[tint]);
    };
    // A cluster of leaning splinters: angle around the centre, distance, height, width, lean outwards, tint.
    for [angle, away, height, width, lean, tint] in [
        [0.0, 0.02, 1.15, 0.23, 0.04, 0.0],
        [0.9, 0.26, 0.85, 0.17, 0.24, 2.0],
        [2.1, 0.28, 0.95, 0.16, 0.22, 1.0],
        [3.2, 0.27, 0.70, 0.17, 0.35, 3.0],
        [4.2, 0.25, 0.62, 0.15, 0.38, 0.0],
        [5.3, 0.27, 0.78, 0.17, 0.30, 0.0],
    ] {
        let outwards = Vec3::new(f32::cos(angle), 0.0, f32::sin(angle));
        let tip = Quat::from_axis_angle(Vec3::Y.cross(outwards), lean);
        let foot = outwards * away;
        add(rest(splinter(&mut random, height, width).moved(tip, foot)), tint as usize);
    }
    // Chips that lie around it: position and tint.
    for [x, z, tint] in [
        [-1.05, 0.30, 1.0],
        [-0.62, 0.78, 0.0],
        [0.22, 0.95, 2.0],
        [0.85, 0.62, 0.0],
        [1.22, 0.05, 3.0],
        [0.90, -0.55, 0.0],
        [-0.85, -0.50, 2.0],
        [-1.45, -0.20, 0.0],
    ] {
        let chip = splinter(&mut random, 0.42, 0.12);
        let lying = Quat::from_rotation_arc(Vec3::Y, random.direction() * Vec3::new(1.0, 0.25, 1.0));
        let lying = lying.normalize();
        add(rest(chip.moved(lying, Vec3::new(x, 0.0, z))), tint as usize);
    }
    // Splinters in the air.
    for [x, y, z, tint] in [
        [-0.95, 0.95, 0.10, 0.0],
        [-0.60, 1.30, -0.15, 3.0],
        [0.80, 1.18, 0.10, 1.0],
        [1.12, 0.85, 0.15, 0.0],
        [0.32, 1.42, -0.2, 2.0],
    ] {
        let turn = Quat::from_rotation_arc(Vec3::Y, random.direction());
        let middle = Vec3::new(0.0, -0.17, 0.0);
        let shard = splinter(&mut random, 0.34, 0.10).moved(Quat::IDENTITY, middle);
        add(shard.moved(turn, Vec3::new(x, y, z)), tint as usize);
    }
    scene.camera("main", Vec3::new(0.25, 1.75, 4.3), Vec3::new(0.03, 0.55, 0.0), 32.0);
    scene
}

/// A splinter along +y from the origin: the hull of a few slanted polygons and two tips, all facets flat.
fn splinter(random: &mut Random, height: f32, radius: f32) -> Mesh {
    let sides = 5;
    let flat = random.between(0.55, 1.0);
    let phase = random.between(0.0, std::f32::consts::TAU);
    let mut points = vec![
        Vec3::new(random.between(-0.4, 0.4) * radius, 0.0, random.between(-0.4, 0.4) * radius),
        Vec3::new(random.between(-0.5, 0.5) * radius, height, random.between(-0.5, 0.5) * radius),
    ];
    for (level, width) in [(0.08, 0.72), (0.62, 1.0)] {
        for s in 0..sides {
            let angle = phase + (s as f32 + random.between(-0.3, 0.3)) / sides as f32 * std::f32::consts::TAU;
            let r = radius * width * random.between(0.85, 1.1);
            let y = height * (level + random.between(-0.07, 0.12));
            points.push(Vec3::new(r * angle.cos(), y, flat * r * angle.sin()));
        }
    }
    let triangles = hull_triangles(&points);
    Mesh { normals: vec![Vec3::Y; points.len()], positions: points, triangles }.faceted()
}

/// Set down so that the lowest point is just above the ground.
fn rest(mesh: Mesh) -> Mesh {
    let lowest = mesh.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    mesh.at(0.0, 0.001 - lowest, 0.0)
}

/// A dark wall that rises from the ground in a quarter circle, smooth in the bend.
fn backdrop() -> Mesh {
    let (half_width, radius, top) = (9.0, 1.2, 6.0);
    let steps = 24;
    let centre = Vec2::new(BEND, radius);
    let mut section: Vec<(Vec2, Vec2)> = (0..=steps)
        .map(|k| {
            let normal = Vec2::from_angle(std::f32::consts::FRAC_PI_2 * (1.0 - k as f32 / steps as f32));
            (centre - radius * normal, normal)
        })
        .collect();
    section.push((Vec2::new(BEND - radius, top), Vec2::X));
    let mut mesh = Mesh::default();
    for &(p, n) in &section {
        for x in [-half_width, half_width] {
            mesh.vertex(Vec3::new(x, p.y, p.x), Vec3::new(0.0, n.y, n.x));
        }
    }
    for i in 0..section.len() as u32 - 1 {
        let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}
