//! What many lights cost: a hall under 100 and under 10,000 emissive triangles of the same area and power, and under the
//! 10,000 of which 100 emit (the same geometry, so the difference to all is that of choosing among lights alone). Printed are
//! million samples a second (mutations of mlt and emlt), and the relative error a pixel against longer renders of the same
//! scene. The scenes take turns, so that their ratios hold on a busy machine too.
//!
//!     cargo bench --bench many_lights -- [--spp 64] [--rounds 5] [--method pt]

mod shared;

use clap::Parser;
use emlt::film::metrics;
use emlt::gpu::context::Context;
use emlt::methods::{Budget, Method, Outcome, Settings, Silent, render_on};
use emlt::scene::{Camera, Material, Scene};
use glam::{Affine3A, Vec3, vec3};

#[derive(Parser)]
struct Arguments {
    /// Samples per pixel of 96x72
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Turns of each scene
    #[arg(long, default_value_t = 5)]
    rounds: u32,
    #[arg(long, value_enum, default_value_t = Method::Pt)]
    method: Method,
}

fn main() {
    shared::main(run);
}

fn run(arguments: &Arguments) -> emlt::Result<()> {
    let context = Context::open(None)?;
    let render = |scene: &Scene, method, spp, seed| -> emlt::Result<Outcome> {
        let budget = Budget::SamplesPerPixel(spp);
        let settings = Settings { method, width: 96, height: 72, budget, max_depth: 5, seed, ..Settings::default() };
        render_on(&context, scene, &settings, &mut Silent)
    };
    let scenes = [("100", hall([10, 5], 1)), ("100 of 10,000", hall([100, 50], 100)), ("10,000", hall([100, 50], 1))];
    let mut references = Vec::new();
    for (_, scene) in &scenes {
        references.push(render(scene, Method::Pt, 32 * arguments.spp, 1000)?.image);
    }
    let mut rates = vec![Vec::new(); scenes.len()];
    let mut errors = vec![0.0; scenes.len()];
    for round in 0..arguments.rounds {
        for (n, (_, scene)) in scenes.iter().enumerate() {
            let outcome = render(scene, arguments.method, arguments.spp, 1 + round)?;
            rates[n].push(1e-6 * outcome.statistics.samples as f64 / outcome.statistics.render_s);
            errors[n] += metrics::compare(&outcome.image, &references[n], None)?.rel_mse / f64::from(arguments.rounds);
        }
    }
    println!("{} at 96x72, {} per pixel, {} turns", arguments.method.name(), arguments.spp, arguments.rounds);
    println!("emissive triangles  million/s  to the first row      to the second row     error a pixel");
    for (n, (name, _)) in scenes.iter().enumerate() {
        let mean = rates[n].iter().sum::<f64>() / rates[n].len() as f64;
        let [first, second] = [0, 1].map(|other| ratio(&rates[n], &rates[other]));
        println!("{name:<18} {mean:>10.3}  {first:<20}  {second:<20}  {:>8.2} %", 100.0 * errors[n].sqrt());
    }
    Ok(())
}

/// Median of the turns' ratios, and the stretch that holds half of them.
fn ratio(a: &[f64], b: &[f64]) -> String {
    let mut ratios: Vec<f64> = a.iter().zip(b).map(|(a, b)| a / b).collect();
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios[(share * (ratios.len() - 1) as f64).round() as usize];
    format!("{:.2} ({:.2} to {:.2})", at(0.5), at(0.25), at(0.75))
}

/// A hall of 20 by 10 m with pillars, under square lamps in a grid, 2 m2 of them in all; one in `every` emits, with
/// `every` times the radiance.
fn hall([columns, rows]: [u32; 2], every: u32) -> Scene {
    let matt = |name: &str, color| Material {
        name: name.into(),
        base_color: color,
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    };
    let mut scene = Scene {
        name: "hall".into(),
        materials: vec![
            matt("walls", vec3(0.7, 0.65, 0.6)),
            Material { emission: every as f32 * vec3(30.0, 27.0, 22.0), ..matt("lamp", Vec3::ZERO) },
            matt("dark lamp", Vec3::ZERO),
        ],
        cameras: vec![Camera {
            name: "main".into(),
            // No lamp is in view: small ones would fill few pixels, and those with noise.
            world_from_camera: Affine3A::from_translation(vec3(0.0, 3.0, 4.8)) * Affine3A::from_rotation_x(-0.62),
            vertical_fov: 1.0,
            orthographic_height: None,
            lens: None,
            aspect: None,
        }],
        ..Scene::default()
    };
    let (low, size) = (vec3(-10.0, 0.0, -5.0), vec3(20.0, 5.0, 10.0));
    let [x, y, z] = [size.x * Vec3::X, size.y * Vec3::Y, size.z * Vec3::Z];
    for [corner, a, b] in [[low, z, x], [low + y, x, z], [low, y, z], [low + x, z, y], [low, x, y], [low + z, y, x]] {
        quad(&mut scene, corner, a, b, 0);
    }
    for i in 0..8 {
        let at = vec3(-8.0 + 4.0 * (i % 4) as f32, 0.0, -3.5 + 4.0 * (i / 4) as f32);
        for [a, b, offset] in [[Vec3::X, Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::Y, Vec3::X]] {
            quad(&mut scene, at + 0.5 * offset, 0.5 * a, 5.0 * b, 0);
            quad(&mut scene, at, 0.5 * a, 5.0 * b, 0);
        }
    }
    let side = (2.0 / (columns * rows) as f32).sqrt();
    for i in 0..columns * rows {
        let (u, v) = (((i % columns) as f32 + 0.5) / columns as f32, ((i / columns) as f32 + 0.5) / rows as f32);
        let centre = low + vec3(u * size.x, 4.9, v * size.z);
        let corner = centre - 0.5 * side * vec3(1.0, 0.0, 1.0);
        // Spread over rows and columns.
        let material = if (i * 37 + i / columns) % every == 0 { 1 } else { 2 };
        quad(&mut scene, corner, side * Vec3::X, side * Vec3::Z, material);
    }
    scene
}

/// Two triangles, their front where the cross product of `a` and `b` points.
fn quad(scene: &mut Scene, corner: Vec3, a: Vec3, b: Vec3, material: u32) {
    let first = scene.positions.len() as u32;
    let normal = a.cross(b).normalize();
    for position in [corner, corner + a, corner + a + b, corner + b] {
        scene.positions.push(position);
        scene.normals.push(normal);
    }
    for triangle in [[0, 1, 2], [0, 2, 3]] {
        scene.triangles.push(triangle.map(|i| first + i));
        scene.triangle_materials.push(material);
    }
}
