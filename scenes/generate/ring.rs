//! A polished ring under a glass dome: the heart of light that the ring throws on the cloth is seen through the dome,
//! and the light came in through it (paths light, glass, mirror, diffuse, glass, camera).
//! The lamp is as small as keeps the heart's edges clear and as large as a path tracer needs to hit it by chance.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{Profile, block, icosphere, lathe, quad, rod};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Around the ring. Fine enough that the walls' shading and geometric normals part by less than a degree: what a
/// renderer does where they put a direction on different sides must not show.
const SEGMENTS: u32 = 208;

pub fn build() -> Document {
    let mut scene = Document::default();
    let table = scene.material(Material::lambert("table", [0.16, 0.36, 0.42]));
    let cloth = scene.material(Material::lambert("cloth", [0.72, 0.40, 0.16]));
    let wall = scene.material(Material::lambert("wall", [0.50, 0.46, 0.55]));
    let side = scene.material(Material::lambert("side wall", [0.62, 0.20, 0.16]));
    let marble = scene.material(Material::lambert("marble", [0.15, 0.50, 0.24]));
    let polished = scene.material(Material::metal("polished", [1.0; 3], 0.0));
    let glass = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.88, 0.70], 150.0));

    let floor = quad(Vec3::new(-1.6, 0.0, -1.3), Vec3::Z * 3.2, Vec3::X * 3.2);
    scene.object("table", &floor, table);
    scene.object("wall", &block([-1.7, 1.7], [-0.1, 1.6], [-1.4, -1.3]), wall);
    scene.object("side wall", &block([-1.7, -1.6], [-0.1, 1.6], [-1.35, 1.9]), side);

    // A round of cloth, hardly thicker than nothing, that the ring lies on.
    let top = 0.004;
    let rim = 0.60;
    scene.object("cloth", &rod(&[[0.0, -0.001, 0.0, rim], [0.0, top, 0.0, rim]], 96), cloth);
    scene.object("ring", &band(0.35, 0.40, 0.21).at(0.0, top + 0.0005, 0.0).closed(), polished);
    scene.object("dome", &lathe(&shell(0.56, 0.012), 96).at(0.0, top + 0.0005, 0.0).closed(), glass);
    for (i, [x, z]) in [[-0.72, 0.16], [-0.62, 0.42]].into_iter().enumerate() {
        scene.object(&format!("marble {i}"), &icosphere(3).scaled(0.09).at(x, 0.09, z), marble);
    }

    // 20 cm square, out of the picture to the right, facing the ring.
    let from = Vec3::new(0.95, 0.98, -0.72);
    let half = 0.1;
    let square = quad(Vec3::new(-half, -half, 0.0), Vec3::X * 2.0 * half, Vec3::Y * 2.0 * half);
    let turn = Quat::from_rotation_arc(Vec3::Z, (Vec3::new(0.0, 0.05, 0.0) - from).normalize());
    scene.object("lamp", &square.moved(turn, from), lamp);

    scene.camera("main", Vec3::new(0.0, 1.50, 1.42), Vec3::new(-0.04, 0.09, 0.0), 37.0);
    scene
}

/// A ring standing on y = 0: walls upright, all four edges rounded.
fn band(inner: f32, outer: f32, height: f32) -> Mesh {
    let radius = 0.012;
    let mut section = Profile::new();
    // Counter-clockwise around the section, from the lower outer corner; the cloth hides most of the lower ones.
    let corners = [
        (outer - radius, radius, 3),
        (outer - radius, height - radius, 8),
        (inner + radius, height - radius, 8),
        (inner + radius, radius, 3),
    ];
    for (i, (x, y, steps)) in corners.into_iter().enumerate() {
        for k in 0..=steps {
            let normal = Vec2::from_angle(TAU * 0.25 * (i as f32 - 1.0 + k as f32 / steps as f32));
            section.push((Vec2::new(x, y) + radius * normal, normal));
        }
    }
    let mut mesh = Mesh::default();
    for &(p, n) in &section {
        for s in 0..SEGMENTS {
            let (sin, cos) = (s as f32 / SEGMENTS as f32 * TAU).sin_cos();
            mesh.vertex(Vec3::new(p.x * cos, p.y, -p.x * sin), Vec3::new(n.x * cos, n.y, -n.x * sin).normalize());
        }
    }
    let rows = section.len() as u32;
    let at = |r: u32, s: u32| r % rows * SEGMENTS + s % SEGMENTS;
    for r in 0..rows {
        for s in 0..SEGMENTS {
            mesh.triangles.push([at(r, s), at(r, s + 1), at(r + 1, s + 1)]);
            mesh.triangles.push([at(r, s), at(r + 1, s + 1), at(r + 1, s)]);
        }
    }
    mesh
}

/// A hollow half ball on y = 0, of the given outer radius and thickness: from the inner pole down, round the rim, and up
/// outside.
fn shell(radius: f32, thickness: f32) -> Profile {
    let (steps, half) = (24, 0.5 * thickness);
    let arc = |k: u32| Vec2::from_angle(TAU * 0.25 * k as f32 / steps as f32);
    let up = Vec2::Y * half;
    let mut profile: Profile = (0..steps).rev().map(|k| ((radius - thickness) * arc(k) + up, -arc(k))).collect();
    profile.insert(0, (Vec2::new(0.0, radius - thickness + half), Vec2::NEG_Y));
    let edge = |k: u32| Vec2::from_angle(TAU * 0.5 * (1.0 + k as f32 / 8.0));
    profile.extend((1..8).map(|k| (Vec2::new(radius - half, half) + half * edge(k), edge(k))));
    profile.extend((0..steps).map(|k| (radius * arc(k) + up, arc(k))));
    profile.push((Vec2::new(0.0, radius + half), Vec2::Y));
    profile
}
