//! Shading normals that lean by up to 70 degrees (item 16), also seen by a camera of 170 degrees (item 18), against path
//! tracing.

use emlt::film::Image;
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::{Outcome, Settings};
use emlt::reference::rng;
use emlt::scene::{Material, Scene};
use glam::{Vec3, vec3};

use super::comparison::{Power, Truth, check};
use super::furnaces::EDGES;
use super::renders::{render, replicates, settings};
use super::shapes::{camera, matt, quad, triangle};

const FILM: [u32; 2] = [24, 18];

/// A parallelogram in `n` x `n` parts, at whose corners normals lean at random, by up to `most` degrees.
fn bent(scene: &mut Scene, corner: Vec3, across: Vec3, up: Vec3, n: u32, most: f32, material: u32) {
    let normal = across.cross(up).normalize();
    let first = scene.positions.len() as u32;
    let lean = |i: u32, j: u32| {
        let words = rng::random_words(11, first, i, j);
        let [u, v] = [words[0], words[1]].map(|word| rng::uniform(word) as f32);
        let (angle, phi) = (most.to_radians() * u.sqrt(), std::f32::consts::TAU * v);
        let aside = phi.cos() * across.normalize() + phi.sin() * normal.cross(across.normalize());
        angle.cos() * normal + angle.sin() * aside
    };
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
            let place = corner + i as f32 / n as f32 * across + j as f32 / n as f32 * up;
            (place, lean(i, j))
        });
        for [a, b, c] in [[a, b, c], [a, c, d]] {
            triangle(scene, [a.0, b.0, c.0], [a.1, b.1, c.1], material);
        }
    }
}

/// A closed room of bumpy walls with a lamp and a bumpy mirror.
pub fn room(degrees: f32) -> Scene {
    let mirror = Material { base_color: vec3(0.95, 0.9, 0.8), roughness: 0.0, ..Material::default() };
    let mut scene = Scene {
        name: format!("bent normals at {degrees} degrees"),
        materials: vec![
            matt(vec3(0.7, 0.7, 0.6), Vec3::ZERO),
            matt(vec3(0.7, 0.3, 0.2), Vec3::ZERO),
            matt(vec3(0.2, 0.3, 0.6), Vec3::ZERO),
            mirror,
            matt(Vec3::ZERO, vec3(9.0, 8.0, 6.0)),
        ],
        cameras: vec![camera(vec3(0.1, 1.0, 0.9), vec3(-0.1, 0.8, -0.5), degrees)],
        ..Scene::default()
    };
    let (x, y, z) = (2.0 * Vec3::X, 2.0 * Vec3::Y, 2.0 * Vec3::Z);
    let corner = vec3(-1.0, 0.0, -1.0);
    bent(&mut scene, corner, z, x, 6, 70.0, 0);
    bent(&mut scene, corner + y, x, z, 6, 70.0, 0);
    bent(&mut scene, corner, x, y, 6, 70.0, 0);
    bent(&mut scene, corner + z, y, x, 6, 70.0, 0);
    bent(&mut scene, corner, y, z, 6, 70.0, 1);
    bent(&mut scene, corner + x, z, y, 6, 70.0, 2);
    bent(&mut scene, vec3(-0.7, 0.1, -0.9), 0.9 * Vec3::X, vec3(0.0, 1.0, 0.2), 4, 20.0, 3);
    quad(&mut scene, vec3(-0.3, 1.95, -0.3), 0.8 * Vec3::X, 0.8 * Vec3::Z, 4);
    scene
}

fn check_room(degrees: f32) {
    let scene = room(degrees);
    let Outcome { image, channels, .. } = render(&scene, &Settings { max_depth: EDGES, ..settings(Pt, FILM, 768) });
    let pixels = (0..image.pixels.len()).map(|i| [0, 1, 2].map(|c| channels[c].values[i])).collect();
    let truth = Truth { variance: Some(Image { pixels, ..image }), image, tile: 6 };
    for method in [Mlt, Emlt] {
        let settings = Settings { max_depth: EDGES, candidates: 1 << 17, ..settings(method, FILM, 250) };
        let name = format!("{} by {}", scene.name, method.name());
        check(&name, &replicates(&scene, &settings, 12), &truth, Power { film: 0.1, tile: 0.3 });
    }
}

#[test]
#[ignore = "the wide camera sees as much; ./run test --long"]
fn long_bent_normals() {
    check_room(60.0);
}

#[test]
fn bent_normals_by_a_wide_camera() {
    check_room(170.0);
}
