//! The classic coloured box: a red and a green wall, an area lamp, a tall metal block, a glass ball.
//! The lamp is large so that plain path tracing resolves the ball's caustic within minutes.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{icosphere, quad, rounded_box};
use glam::Vec3;

const HALF_WIDTH: f32 = 1.3;
const HEIGHT: f32 = 1.95;
const HALF_DEPTH: f32 = 1.0;

pub fn build() -> Document {
    let mut scene = Document::default();
    let white = scene.material(Material::lambert("white", [0.73, 0.71, 0.68]));
    let red = scene.material(Material::lambert("red", [0.63, 0.065, 0.05]));
    let green = scene.material(Material::lambert("green", [0.14, 0.45, 0.091]));
    let metal = scene.material(Material::metal("brushed gold", [0.95, 0.72, 0.42], 0.4));
    let glass = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.86, 0.68], 12.0));

    let (w, h, d) = (HALF_WIDTH, HEIGHT, HALF_DEPTH);
    let (across, up, deep) = (Vec3::X * 2.0 * w, Vec3::Y * h, Vec3::Z * 2.0 * d);
    let shell = Mesh::joined(&[
        quad(Vec3::new(-w, 0.0, -d), deep, across),
        quad(Vec3::new(-w, h, -d), across, deep),
        quad(Vec3::new(-w, 0.0, -d), across, up),
    ]);
    scene.object("floor, ceiling and back", &shell, white);
    scene.object("left wall", &quad(Vec3::new(-w, 0.0, -d), up, deep), red);
    scene.object("right wall", &quad(Vec3::new(w, 0.0, -d), deep, up), green);

    let (lw, ld) = (0.45, 0.32);
    let panel = quad(Vec3::new(-lw, h - 0.005, -ld), Vec3::X * 2.0 * lw, Vec3::Z * 2.0 * ld);
    scene.object("lamp", &panel, lamp);

    let block = rounded_box(Vec3::new(0.29, 0.6, 0.29), 0.02, 3).turned(40.0);
    scene.object("tall block", &block.at(-0.52, 0.6, -0.36), metal);
    let plinth = rounded_box(Vec3::new(0.34, 0.16, 0.34), 0.015, 3).turned(-17.0);
    scene.object("plinth", &plinth.at(0.52, 0.16, 0.12), white);
    let ball = icosphere(4).scaled(0.33).at(0.52, 0.32 + 0.331, 0.12);
    scene.object("ball", &ball.closed(), glass);

    scene.camera("main", Vec3::new(0.0, 0.975, 4.2), Vec3::new(0.0, 0.975, 0.0), 33.2);
    scene
}
