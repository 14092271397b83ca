//! Item 8: chains of up to 56 reflections, in a square tube of perfect mirrors.

use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::kernels::{Kernel, lens, multi_chain};
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::scene::{Features, Material, Scene};
use glam::{Vec3, vec3};

use super::bench::Bench;
use super::comparison::{Power, Truth, check};
use super::renders::{render, replicates, settings};
use super::shapes::{camera, matt, quad};

/// 58 edges are needed.
const LONGEST: u32 = 60;
const RADIANCE: Vec3 = vec3(0.9, 1.3, 0.4);
/// A tube of width 2 `half` before a luminous end, which reflects `albedo` of the light; seen from its middle, and behind the
/// camera open, or with a mirror too. The end is 2 away: a ray that rises by s a unit of length is reflected s / `half` times.
fn tube(half: f32, albedo: Vec3, closed: bool) -> Scene {
    let eye = vec3(0.2, 0.4, 0.0);
    let mirror = Material { base_color: Vec3::ONE, roughness: 0.0, ..Material::default() };
    let mut scene = Scene {
        name: "tube".into(),
        materials: vec![mirror, matt(albedo, RADIANCE)],
        cameras: vec![camera(half * eye, half * eye - Vec3::Z, 2.0 * 0.7f32.atan().to_degrees())],
        ..Scene::default()
    };
    let corner = vec3(-half, -half, -2.0);
    let (x, y, z) = (2.0 * half * Vec3::X, 2.0 * half * Vec3::Y, 2.1 * Vec3::Z);
    quad(&mut scene, corner, z, x, 0);
    quad(&mut scene, corner + y, x, z, 0);
    quad(&mut scene, corner, y, z, 0);
    quad(&mut scene, corner + x, z, y, 0);
    quad(&mut scene, corner, x, y, 1);
    if closed {
        quad(&mut scene, corner + z, y, x, 0);
    }
    scene
}

/// Every pixel has the end's radiance; the film's corners see it by 56 reflections.
#[test]
fn fifty_six_reflections() {
    let scene = tube(0.025, Vec3::ZERO, false);
    let [width, height] = [12, 12];
    let pixels = vec![RADIANCE.to_array(); (width * height) as usize];
    let truth = Truth { image: Image { width, height, pixels }, variance: None, tile: 4 };
    // What shorter paths leave out: two fifths of the film.
    let short = render(&scene, &Settings { max_depth: 32, ..settings(Pt, [width, height], 1) }).image;
    let black = short.pixels.iter().filter(|p| **p == [0.0; 3]).count();
    assert!(black * 3 > short.pixels.len(), "{black} black pixels");
    for (method, samples, film, tile) in [(Pt, 16, 1e-3, 1e-3), (Mlt, 300, 0.05, 0.2), (Emlt, 300, 0.05, 0.2)] {
        let settings =
            Settings { max_depth: LONGEST, candidates: 1 << 15, ..settings(method, [width, height], samples) };
        let images = replicates(&scene, &settings, 12);
        check(&format!("tube by {}", method.name()), &images, &truth, Power { film, tile });
    }
}

/// Steps of size zero reproduce every path, however long its chains: log ratio 0, and so accepted for certain.
#[test]
fn a_step_of_zero_reproduces_long_chains() {
    const PATHS: u32 = 4096;
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let scene = tube(0.05, Vec3::splat(0.7), true);
    let features = Features::of(&scene);
    for kernel in [&lens::KERNEL, &multi_chain::KERNEL] as [&Kernel; 2] {
        let mut bench = Bench::new(&context, &scene, [24, 24], LONGEST, PATHS);
        let keys = bench.keys();
        let paths: Vec<u32> = (0..PATHS).filter(|path| (kernel.applies)(keys[*path as usize], features)).collect();
        bench.list(&paths, 0, &[]);
        let flags: Vec<&'static str> = kernel.flags.iter().copied().chain(["probe", "probe_still"]).collect();
        let uniform = bench.uniform(paths.len());
        bench.pass(kernel.pass, &flags, uniform);
        let records = bench.records(paths.len());
        let edges = |path: u32| keys[path as usize].edges();
        let long = paths.iter().filter(|path| edges(**path) >= 20).count();
        let bad: Vec<(u32, f32)> = (paths.iter().zip(&records))
            .filter(|(_, r)| !(r[3] > -1e29 && r[0].abs() < 1e-3))
            .map(|(path, r)| (edges(*path), r[0]))
            .collect();
        let worst = records.iter().filter(|r| r[3] > -1e29).map(|r| r[0].abs()).fold(0.0, f32::max);
        println!(
            "{}: {} of {} paths not reproduced by a step of zero, {long} of 20 edges and more; largest log ratio {worst:.1e}",
            kernel.name,
            bad.len(),
            paths.len()
        );
        assert!(long > 50, "only {long} long paths");
        assert!(bad.len() as f64 <= 2e-3 * paths.len() as f64, "{}: {bad:?}", kernel.name);
    }
}
