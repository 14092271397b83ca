//! More triangles than one buffer need hold.

use emlt::methods::Method::{Mlt, Pt};
use emlt::scene::features::SPLIT_TRIANGLES;
use emlt::scene::{Features, Scene};
use glam::Vec3;

use super::renders::{render, scene, settings};

/// The ball over its plane, the plane cut into `n` by `n` squares.
fn ball_over(n: u32) -> Scene {
    let mut scene = scene("tests/scenes/sphere_over_plane.glb");
    let plane = scene.materials.iter().position(|m| m.name == "plane").unwrap() as u32;
    let kept: Vec<usize> = (0..scene.triangles.len()).filter(|t| scene.triangle_materials[*t] != plane).collect();
    scene.triangles = kept.iter().map(|t| scene.triangles[*t]).collect();
    scene.triangle_materials = kept.iter().map(|t| scene.triangle_materials[*t]).collect();
    let first = scene.positions.len() as u32;
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: u32| 20.0 * k as f32 / n as f32 - 10.0;
            scene.positions.push(Vec3::new(at(j), 0.0, at(i)));
            scene.normals.push(Vec3::Y);
        }
    }
    for square in 0..n * n {
        let a = first + square / n * (n + 1) + square % n;
        let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
        scene.triangles.extend([[a, c, b], [b, c, d]]);
        scene.triangle_materials.extend([plane; 2]);
    }
    scene
}

/// 2.88 million triangles, whose edges have buffers of their own, are the plane that 2 are. A false alarm has a probability
/// below 1e-5, by the errors that both renders state.
#[test]
#[ignore = "takes half a minute and a gigabyte; ./run test --long"]
fn long_millions_of_triangles_are_the_plane_they_cut() {
    let (few, many) = (ball_over(1), ball_over(1200));
    assert!(many.triangles.len() > SPLIT_TRIANGLES && Features::of(&many).split && !Features::of(&few).split);
    for method in [Pt, Mlt] {
        let mean = |scene| render(scene, &settings(method, [32, 24], 512)).statistics.error.unwrap();
        let (a, b) = (mean(&few), mean(&many));
        let error = a.film_error.hypot(b.film_error);
        let z = (b.film - a.film) / error;
        println!("{}: {} by few, {} by many, z {z:.2}", method.name(), a.film, b.film);
        assert!(z.abs() < 5.0 && error < 0.02 * a.film, "{}: z {z}, error {error}", method.name());
    }
}
