//! A room lit through a slit three centimetres wide: a blade of light across coloured things.
//! The lamp is a panel in the chamber next door, high up, so that the blade comes down to the floor.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{block, icosphere, quad, rounded_box};
use glam::Vec3;

const LEFT: f32 = -1.5;
const RIGHT: f32 = 1.5;
const BACK: f32 = -1.7;
const FRONT: f32 = 1.9;
const CEILING: f32 = 2.1;
// The partition is thin against its slit, so that light gets through at a slant.
const PARTITION: f32 = 0.02;
const SLIT: f32 = 0.03;
const SLIT_AT: f32 = -0.75;
const SLIT_TOP: f32 = 1.95;
const WALL: f32 = 0.1;
/// The far wall of the chamber.
const FAR: f32 = LEFT - 1.3;

pub fn build() -> Document {
    let mut scene = Document::default();
    let plaster = scene.material(Material::lambert("plaster", [0.74, 0.70, 0.64]));
    let blue = scene.material(Material::lambert("blue wall", [0.18, 0.33, 0.62]));
    let chamber = scene.material(Material::lambert("chamber", [0.82, 0.76, 0.66]));
    let boards = scene.material(Material::lambert("boards", [0.55, 0.38, 0.24]));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.85, 0.62], 700.0));

    let tall = [-WALL, CEILING + WALL];
    let deep = [BACK - WALL, FRONT + WALL];
    let wide = [FAR - WALL, RIGHT + WALL];
    let (slit_back, slit_front) = (SLIT_AT - 0.5 * SLIT, SLIT_AT + 0.5 * SLIT);
    let partition = [LEFT - PARTITION, LEFT];
    // Solid overlapping blocks, so that light has no other way in.
    let walls = Mesh::joined(&[
        block(partition, tall, [deep[0], slit_back]),
        block(partition, tall, [slit_front, deep[1]]),
        block(partition, [SLIT_TOP, tall[1]], [slit_back - 0.01, slit_front + 0.01]),
        block([LEFT - 0.01, wide[1]], tall, [deep[0], BACK]),
        block([LEFT - 0.01, wide[1]], tall, [FRONT, deep[1]]),
        block([LEFT - 0.01, wide[1]], [CEILING, tall[1]], deep),
    ]);
    scene.object("walls", &walls, plaster);
    scene.object("right wall", &block([RIGHT, wide[1]], tall, deep), blue);
    let beyond = Mesh::joined(&[
        block([FAR - WALL, FAR], tall, deep),
        block([FAR - WALL, LEFT - 0.01], tall, [deep[0], BACK]),
        block([FAR - WALL, LEFT - 0.01], tall, [0.3, 0.4]),
        block([FAR - WALL, LEFT - 0.01], [CEILING, tall[1]], deep),
    ]);
    scene.object("chamber", &beyond, chamber);
    scene.object("floor", &block(wide, [-WALL, 0.0], deep), boards);
    // As high as the slit is, so that the blade reaches from floor to ceiling.
    let panel = quad(Vec3::new(FAR + 0.02, 1.15, -1.20), Vec3::Y * 0.8, Vec3::Z * 0.6);
    scene.object("lamp", &panel, lamp);

    things(&mut scene);
    scene.camera("main", Vec3::new(0.15, 1.28, 1.85), Vec3::new(0.08, 0.60, -0.7), 48.0);
    scene
}

/// In the blade, half in it, and beside it.
fn things(scene: &mut Document) {
    let red = scene.material(Material::lambert("red", [0.72, 0.12, 0.08]));
    let green = scene.material(Material::lambert("green", [0.16, 0.48, 0.20]));
    let yellow = scene.material(Material::lambert("yellow", [0.82, 0.62, 0.12]));
    let gold = scene.material(Material::metal("gold", [0.98, 0.76, 0.42], 0.3));
    let stand = rounded_box(Vec3::new(0.18, 0.26, 0.18), 0.015, 3).turned(20.0);
    scene.object("stand", &stand.at(-0.50, 0.26, -0.80), green);
    scene.object("ball", &icosphere(4).scaled(0.20).at(-0.50, 0.52 + 0.20, -0.80), red);
    let globe = icosphere(4).scaled(0.30);
    scene.object("gold ball", &globe.at(0.40, 0.30, -0.30), gold);
    let block = rounded_box(Vec3::new(0.16, 0.45, 0.16), 0.015, 3).turned(-28.0);
    scene.object("pillar", &block.at(0.98, 0.45, -0.85), yellow);
    let die = rounded_box(Vec3::splat(0.13), 0.02, 3).turned(35.0);
    scene.object("die", &die.at(-0.30, 0.13, 0.12), yellow);
}
