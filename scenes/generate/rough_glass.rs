//! Three solids of rough glass before a striped screen: how far each blurs the stripes tells its roughness.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{block, icosphere, quad, rounded_box};
use glam::{Quat, Vec3};

pub fn build() -> Document {
    let mut scene = Document::default();
    let table = scene.material(Material::lambert("table", [0.46, 0.42, 0.38]));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.92, 0.80], 16.0));
    let inks = [[0.78, 0.16, 0.10], [0.80, 0.74, 0.62], [0.08, 0.36, 0.42], [0.84, 0.58, 0.12]]
        .map(|rgb| scene.material(Material::lambert("stripe", rgb)));

    scene.object("table", &quad(Vec3::new(-2.4, 0.0, -1.0), Vec3::Z * 3.6, Vec3::X * 4.8), table);
    let mut stripes: [Mesh; 4] = Default::default();
    let width = 0.12;
    for i in 0..40u32 {
        let x = width * (i as f32 - 20.0);
        stripes[i as usize % 4].append(&quad(Vec3::new(x, -0.05, -0.9), Vec3::X * width, Vec3::Y * 2.0));
    }
    for (i, (mesh, ink)) in stripes.iter().zip(inks).enumerate() {
        scene.object(&format!("stripes {i}"), mesh, ink);
    }
    // Above and a little in front.
    let panel = quad(Vec3::new(-0.45, 0.0, -0.35), Vec3::X * 0.9, Vec3::Z * 0.7);
    scene.object("lamp", &panel.moved(Quat::from_rotation_x(0.35), Vec3::new(0.5, 2.1, 0.5)), lamp);
    let edge = scene.material(Material::lambert("edge", [0.20, 0.18, 0.30]));
    scene.object("side", &block([-2.3, -2.2], [-0.1, 1.95], [-1.0, 2.6]), edge);

    let clear = scene.material(Material::rough_glass("rough glass 0.25", [1.0; 3], 1.5, 0.25));
    let rose = scene.material(Material::rough_glass("rough rose glass 0.5", [0.98, 0.72, 0.74], 1.5, 0.5));
    let sea = scene.material(Material::rough_glass("rough sea glass 0.25", [0.70, 0.95, 0.90], 1.5, 0.25));
    scene.object("ball", &icosphere(5).scaled(0.32).at(-0.68, 0.3205, 0.05).closed(), clear);
    let cube = rounded_box(Vec3::new(0.25, 0.27, 0.25), 0.02, 4).turned(28.0);
    scene.object("block", &cube.at(0.04, 0.2705, -0.10), rose);
    // Flat facets: shading and geometric normals agree exactly.
    let gem = icosphere(1).scaled(0.30).moved(Quat::from_rotation_z(0.3), Vec3::new(0.70, 0.302, 0.10));
    scene.object("gem", &gem.faceted().closed(), sea);
    scene.camera("main", Vec3::new(0.0, 0.86, 2.5), Vec3::new(0.0, 0.32, -0.1), 36.0);
    scene
}
