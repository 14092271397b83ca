//! A corridor between two mirrors that face each other: long chains of reflections, and things repeated in them.
//! The mirrors are flat and reflect all light, the rest is opaque and diffuse: a reflection is the same in any renderer,
//! and what is left to go wrong is the counting of edges.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{block, cuboid, icosphere, quad, rounded_box};
use glam::Vec3;

const HALF: f32 = 0.85;
const BACK: f32 = -3.6;
const FRONT: f32 = 2.4;
const CEILING: f32 = 1.9;

pub fn build() -> Document {
    let mut scene = Document::default();
    let mirror = scene.material(Material::metal("mirror", [1.0; 3], 0.0));
    let cream = scene.material(Material::lambert("cream", [0.70, 0.60, 0.42]));
    let teal = scene.material(Material::lambert("teal", [0.08, 0.33, 0.36]));
    let ceiling = scene.material(Material::lambert("ceiling", [0.52, 0.58, 0.70]));
    let back = scene.material(Material::lambert("end wall", [0.62, 0.24, 0.14]));
    let front = scene.material(Material::lambert("near wall", [0.40, 0.44, 0.24]));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.84, 0.62], 14.0));

    // The walls themselves: quads whose edges reach into floor, ceiling and ends.
    let (low, tall) = (-0.05, Vec3::Y * (CEILING + 0.1));
    let deep = Vec3::Z * (FRONT - BACK + 0.1);
    let walls = Mesh::joined(&[
        quad(Vec3::new(-HALF, low, BACK - 0.05), tall, deep),
        quad(Vec3::new(HALF, low, BACK - 0.05), deep, tall),
    ]);
    scene.object("mirrors", &walls, mirror);
    let out = HALF + 0.1;
    scene.object("ceiling", &block([-out, out], [CEILING, CEILING + 0.1], [BACK - 0.1, FRONT + 0.1]), ceiling);
    scene.object("end wall", &block([-out, out], [-0.1, CEILING + 0.1], [BACK - 0.1, BACK]), back);
    scene.object("near wall", &block([-out, out], [-0.1, CEILING + 0.1], [FRONT, FRONT + 0.1]), front);
    let mut squares = [Mesh::default(), Mesh::default()];
    let side = 2.0 * HALF / 4.0;
    let rows = ((FRONT - BACK) / side).ceil() as u32;
    for row in 0..rows {
        for column in 0..4 {
            let (x, z) = (-HALF + side * column as f32, BACK + side * row as f32);
            squares[(row + column) as usize % 2].append(&quad(Vec3::new(x, 0.0, z), Vec3::Z * side, Vec3::X * side));
        }
    }
    for (i, (squares, colour)) in squares.iter().zip([cream, teal]).enumerate() {
        scene.object(&format!("floor {i}"), squares, colour);
    }
    // A lantern that shines to all sides, so that the mirrors show it as a row of lights.
    let lantern = cuboid(Vec3::new(-0.13, 1.38, -0.93), Vec3::new(0.13, 1.64, -0.67));
    scene.object("lamp", &lantern, lamp);
    let cord = scene.material(Material::lambert("cord", [0.12, 0.11, 0.10]));
    let cap = Mesh::joined(&[
        block([-0.15, 0.15], [1.64, 1.66], [-0.95, -0.65]),
        block([-0.012, 0.012], [1.655, CEILING + 0.01], [-0.812, -0.788]),
    ]);
    scene.object("cord", &cap, cord);

    let red = scene.material(Material::lambert("red", [0.74, 0.10, 0.08]));
    let yellow = scene.material(Material::lambert("yellow", [0.85, 0.62, 0.10]));
    let blue = scene.material(Material::lambert("blue", [0.12, 0.24, 0.66]));
    scene.object("ball", &icosphere(4).scaled(0.22).at(-0.38, 0.22, -0.35), red);
    let block = rounded_box(Vec3::new(0.15, 0.34, 0.15), 0.015, 3).turned(24.0);
    scene.object("pillar", &block.at(0.34, 0.34, -1.15), yellow);
    let die = rounded_box(Vec3::splat(0.13), 0.02, 3).turned(-33.0);
    scene.object("die", &die.at(0.22, 0.13, 0.25), blue);
    scene.camera("main", Vec3::new(0.66, 1.22, 0.85), Vec3::new(-0.85, 0.86, 0.10), 54.0);
    scene
}
