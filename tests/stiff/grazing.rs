//! Item 2: a plane seen at a tenth of a degree, under a sky of radiance 1: its radiance is its albedo, from wherever it is
//! seen.

use emlt::film::Image;
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::scene::Scene;
use emlt::scene::light::Environment;
use glam::{Vec3, vec3};

use super::comparison::{Power, Truth, check};
use super::furnaces::{ALBEDO, EDGES};
use super::renders::{replicates, settings};
use super::shapes::{camera, matt, quad};

#[test]
fn grazing_angles() {
    let [width, height] = [16, 12];
    // From 0.07 to 0.13 degrees below the horizon: the plane is seen over 0.9 to 1.7 of its length of 2.
    let (eye, tangent) = (vec3(0.0, 2e-3, 1.0), 0.1f32.to_radians().tan());
    let mut scene = Scene {
        name: "grazing angles".into(),
        materials: vec![matt(ALBEDO, Vec3::ZERO)],
        cameras: vec![camera(eye, eye - vec3(0.0, tangent, 1.0), 0.06)],
        // A map, so that the shaders are those of the sun's tests.
        environment: Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] }),
        ..Scene::default()
    };
    quad(&mut scene, vec3(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X, 0);
    let pixels = vec![ALBEDO.to_array(); (width * height) as usize];
    let truth = Truth { image: Image { width, height, pixels }, variance: None, tile: 4 };
    for (method, samples, film, tile) in [(Pt, 256, 0.006, 0.025), (Mlt, 500, 0.02, 0.2), (Emlt, 500, 0.02, 0.2)] {
        let settings = Settings { max_depth: EDGES, candidates: 1 << 16, ..settings(method, [width, height], samples) };
        let images = replicates(&scene, &settings, 12);
        check(&format!("grazing angles by {}", method.name()), &images, &truth, Power { film, tile });
    }
}
