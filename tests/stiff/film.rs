//! Item 13: a film that counts in integers neither overflows nor stalls.

use emlt::gpu::context::Context;
use emlt::gpu::layout::{FILM_SCALE, PassUniform, ROW_COLOUR};
use emlt::gpu::run::Buffer;
use emlt::methods::{Method, Settings};
use emlt::scene::Scene;
use glam::{Vec3, vec3};

use super::bench::Bench;
use super::furnaces::{EDGES, box_furnace};
use super::renders::{render, settings};
use super::shapes::{camera, matt, quad};

const PATHS: u32 = 1 << 15;

/// The pixel's channels, in the film's units.
fn units(bench: &mut Bench) -> [u64; 3] {
    bench.run.read(Buffer::Output, 0..24).unwrap().try_into().unwrap()
}

/// Splats every path `passes` times with `weight`, all in the one pixel.
fn splat(bench: &mut Bench, passes: std::ops::Range<u32>, weight: f32) {
    let paths: Vec<u32> = (0..PATHS).collect();
    bench.list(&paths, 0, &[]);
    for pass_index in passes {
        let uniform = PassUniform { pass_index, weight, ..bench.uniform(paths.len()) };
        bench.pass("rest", &[], uniform);
    }
}

/// As much as 2^30 mutations put in one pixel carries over the counters' low words a million times and loses nothing; and
/// weights of half a unit still arrive there, on average. A sum in f32 would have stalled at 2^24.
#[test]
fn a_billion_splats_in_one_pixel() {
    const WEIGHT: f64 = 512.0;
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut bench = Bench::new(&context, &box_furnace(), [1, 1], EDGES, PATHS);
    // Luminance is 1 each; the colours of all paths together.
    let colours: Vec<[f64; 3]> =
        (bench.row(ROW_COLOUR).iter()).map(|row| [0, 1, 2].map(|c| f64::from(f32::from_bits(row[c])))).collect();
    let sum = [0, 1, 2].map(|c| colours.iter().map(|colour| colour[c]).sum::<f64>() * FILM_SCALE);
    let light = 0.2126 * sum[0] + 0.7152 * sum[1] + 0.0722 * sum[2];
    assert!((light / FILM_SCALE / f64::from(PATHS) - 1.0).abs() < 1e-6);
    splat(&mut bench, 0..64, WEIGHT as f32);
    let full = units(&mut bench);
    for (c, units) in full.iter().enumerate() {
        let expected = 64.0 * WEIGHT * sum[c];
        let off = *units as f64 / expected - 1.0;
        println!("channel {c}: {units} units, off by {off:.1e}");
        assert!(off.abs() < 1e-9, "channel {c}: {units} units, {expected} expected");
        assert!(units >> 32 > 100_000, "the low word must have wrapped");
    }
    // Rounding to whole units at random: variance p (1 - p) a splat, at most 1/4.
    let small = 0.5 / FILM_SCALE;
    splat(&mut bench, 64..96, small as f32);
    for (c, (after, before)) in units(&mut bench).iter().zip(full).enumerate() {
        let (added, expected) = ((after - before) as f64, 32.0 * small * sum[c]);
        let deviation = (0.25 * 32.0 * f64::from(PATHS)).sqrt();
        println!("channel {c}: {added} units of weights below one, {expected:.0} expected, +- {deviation:.0}");
        assert!((added - expected).abs() < 5.0 * deviation, "channel {c}: {added}, {expected} expected");
    }
}

/// Path tracing sums in f32 with the rounding kept (Kahan 1965), which drivers must not optimise away: 4096 samples of one
/// and the same value have that mean. A plain sum is off by 4e-5 here, and stalls at 2^24 of them.
#[test]
fn a_long_path_tracing_does_not_drift() {
    const SAMPLES: u32 = 1 << 12;
    let glow = vec3(0.1, 0.7, 1.3);
    let mut scene = Scene {
        name: "glow".into(),
        materials: vec![matt(Vec3::ZERO, glow)],
        cameras: vec![camera(Vec3::Z, Vec3::ZERO, 50.0)],
        ..Scene::default()
    };
    quad(&mut scene, vec3(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y, 0);
    let settings = Settings { max_depth: EDGES, ..settings(Method::Pt, [4, 4], SAMPLES) };
    let image = render(&scene, &settings).image;
    let off = |p: &[f32; 3]| (Vec3::from(*p).as_dvec3() / glow.as_dvec3() - 1.0).abs().max_element();
    let worst = image.pixels.iter().map(off).fold(0.0, f64::max);
    println!("{SAMPLES} samples of one value: mean off by {worst:.1e}");
    assert!(worst < 2e-7, "{worst}");
}
