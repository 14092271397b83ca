//! White glass in a uniform sky is nowhere brighter than the sky, and hardly darker while its surface is not very rough:
//! one bounce between microfacets is all that GGX keeps.

use emlt::film::Image;
use emlt::methods::{Method, Settings};
use emlt::scene::{Camera, Material, Scene};
use glam::{Affine3A, Vec3};

use super::renders::{render, settings};

/// A ball of flat facets, so that shading and geometric normals agree, all around it a sky of radiance 1.
fn ball(alpha: f32) -> Scene {
    const ROWS: u32 = 24;
    let point = |row: u32, column: u32| {
        let (theta, phi) =
            (row as f32 * std::f32::consts::PI / ROWS as f32, column as f32 * std::f32::consts::PI / ROWS as f32);
        Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
    };
    let mut scene = Scene {
        name: format!("ball of alpha {alpha}"),
        cameras: vec![Camera {
            name: "main".into(),
            world_from_camera: Affine3A::from_translation(4.0 * Vec3::Z),
            vertical_fov: 0.4,
            orthographic_height: None,
            lens: None,
            aspect: None,
        }],
        materials: vec![Material {
            metallic: 0.0,
            roughness: alpha.sqrt(),
            transmission: 1.0,
            thin: false,
            ..Material::default()
        }],
        sky: Some(Vec3::ONE),
        ..Scene::default()
    };
    for row in 0..ROWS {
        for column in 0..2 * ROWS {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| point(row + i, (column + j) % (2 * ROWS)));
            for corners in [[a, b, c], [a, c, d]] {
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                if normal.length() > 1e-6 {
                    let first = scene.positions.len() as u32;
                    scene.positions.extend(corners);
                    scene.normals.extend([normal.normalize(); 3]);
                    scene.triangles.push([first, first + 1, first + 2]);
                    scene.triangle_materials.push(0);
                }
            }
        }
    }
    scene
}

/// Film means, each with its standard error, of small pictures that the ball fills to nearly its rim.
fn mean(alpha: f32) -> (f64, f64) {
    let settings = Settings { max_depth: 24, ..settings(Method::Pt, [32, 32], 128) };
    let outcome = render(&ball(alpha), &settings);
    let n = outcome.image.pixels.len() as f64;
    let total = |image: &Image| image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let variance: f64 = outcome.channels[1].values.iter().map(|v| f64::from(*v)).sum();
    (total(&outcome.image) / n, variance.sqrt() / n)
}

#[test]
fn glass_in_a_white_sky() {
    for (alpha, least) in [(0.0, 0.995), (0.01, 0.99), (0.1, 0.95), (0.3, 0.75), (0.8, 0.4)] {
        let (mean, error) = mean(alpha);
        println!("ball of alpha {alpha}: {mean:.4} +- {error:.4}");
        // 4.5 standard errors: false alarms below 1e-5.
        assert!(mean < 1.0 + 4.5 * error + 1e-5 && mean > least, "alpha {alpha}: {mean} +- {error}");
    }
}
