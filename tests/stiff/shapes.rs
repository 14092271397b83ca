//! Scenes made by code.

use emlt::scene::{Camera, Material, Scene};
use glam::{Affine3A, Vec3};

/// Lambertian, and emitting where `emission` is not black.
pub fn matt(albedo: Vec3, emission: Vec3) -> Material {
    Material { base_color: albedo, metallic: 0.0, specular: 0.0, emission, ..Material::default() }
}

/// At `eye`, upright, looking at `target`; `degrees` from the film's lower edge to its upper one.
pub fn camera(eye: Vec3, target: Vec3, degrees: f32) -> Camera {
    let plain = Camera {
        name: "main".into(),
        world_from_camera: Affine3A::IDENTITY,
        vertical_fov: degrees.to_radians(),
        orthographic_height: None,
        lens: None,
        aspect: None,
    };
    plain.looking(eye, target).expect("not straight up or down")
}

/// The same, straight down from `eye`, its upper edge towards -z.
pub fn camera_down(eye: Vec3, degrees: f32) -> Camera {
    let down = camera(eye, eye - Vec3::Z, degrees);
    let turn = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    Camera { world_from_camera: Affine3A::from_translation(eye) * turn, ..down }
}

/// A triangle with a normal of its own at each corner.
pub fn triangle(scene: &mut Scene, corners: [Vec3; 3], normals: [Vec3; 3], material: u32) {
    let first = scene.positions.len() as u32;
    scene.positions.extend(corners);
    scene.normals.extend(normals);
    scene.triangles.push([first, first + 1, first + 2]);
    scene.triangle_materials.push(material);
}

/// A flat one.
pub fn facet(scene: &mut Scene, corners: [Vec3; 3], material: u32) {
    let [a, b, c] = corners;
    triangle(scene, corners, [(b - a).cross(c - a).normalize(); 3], material);
}

/// A parallelogram whose front is that of across x up.
pub fn quad(scene: &mut Scene, corner: Vec3, across: Vec3, up: Vec3, material: u32) {
    facet(scene, [corner, corner + across, corner + across + up], material);
    facet(scene, [corner, corner + across + up, corner + up], material);
}

/// A box, its front outside or inside.
pub fn cuboid(scene: &mut Scene, low: Vec3, high: Vec3, inside: bool, material: u32) {
    for axis in 0..3 {
        let [n, a, b] = [0, 1, 2].map(|i| (high - low) * Vec3::AXES[(axis + i) % 3]);
        let [near, far] = if inside { [(a, b), (b, a)] } else { [(b, a), (a, b)] };
        quad(scene, low, near.0, near.1, material);
        quad(scene, low + n, far.0, far.1, material);
    }
}

/// A ball of 2 * rows^2 quadrilaterals of flat facets.
pub fn ball(scene: &mut Scene, centre: Vec3, radius: f32, rows: u32, material: u32) {
    use std::f32::consts::PI;
    let point = |row: u32, column: u32| {
        let (theta, phi) = (row as f32 * PI / rows as f32, (column % (2 * rows)) as f32 * PI / rows as f32);
        centre + radius * Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
    };
    for row in 0..rows {
        for column in 0..2 * rows {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| point(row + i, column + j));
            if row + 1 < rows {
                facet(scene, [a, b, c], material);
            }
            if row > 0 {
                facet(scene, [a, c, d], material);
            }
        }
    }
}
