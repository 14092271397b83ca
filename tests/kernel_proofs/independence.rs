//! The independence kernel: its log ratios (METHOD.md 4.1, A1), and what its proposals estimate (4.3, D2).

use emlt::gpu::layout::PassUniform;
use emlt::methods::{Budget, Method, Settings, Silent, render_on};
use emlt::scene::LUMINANCE;
use glam::DVec3;

use crate::bench::{Bench, COLUMNS, FILM, HALF, MAX_EDGES, context};
use crate::{GLOSSY, SCENE, WEIGH, Z_LIMIT, scene_of};

/// METHOD.md 4.1 A1 for the independence kernel. Its log ratio is log w(y) - log w(x), w(y) as the proposal was made and
/// w(x) as the state is weighed; there and back they cancel if both ways give every path the same w: a million paths.
#[test]
fn independence_log_ratios_are_antisymmetric() {
    let context = context();
    for scene in [SCENE, GLOSSY] {
        check_ratios(&mut Bench::new(&context, scene), 1_000_000);
    }
}

#[track_caller]
pub fn check_ratios(bench: &mut Bench, wanted: usize) {
    let (mut bad, mut all) = (0usize, 0usize);
    for seed in 2001.. {
        let (candidates, strategies) = bench.candidates(1 << 17, seed);
        let lit: Vec<u32> = (0..candidates.len() as u32).filter(|i| candidates[*i as usize].weight() > 0.0).collect();
        for chunk in lit.chunks(HALF as usize) {
            let entries: Vec<u32> = (0..chunk.len() as u32).flat_map(|path| [path, 0]).collect();
            let uniform = PassUniform { stride: COLUMNS, entries: chunk.len() as u32, ..Default::default() };
            bench.fill(seed, &strategies, chunk);
            bench.run.set_lists(&entries);
            bench.passes(&WEIGH, &[], uniform, 0..1);
            let weighed = bench.records(chunk.len() as u32);
            let made = chunk.iter().map(|&i| candidates[i as usize].log_weight);
            // Counted this way round, what is no number counts as bad.
            bad += chunk.len() - weighed.iter().zip(made).filter(|(r, made)| (r[0] - made).abs() < 1e-3).count();
            all += chunk.len();
        }
        if all >= wanted {
            break;
        }
    }
    println!("independence: {bad} of {all} paths weighed otherwise than made");
    assert!((bad as f64) < 1e-3 * all as f64, "{bad} of {all}");
}

/// Side of a tile in pixels.
const TILE: u32 = 8;
const TILES: usize = ((FILM[0] / TILE) * (FILM[1] / TILE)) as usize;

fn tile(x: u32, y: u32) -> usize {
    (y / TILE * (FILM[0] / TILE) + x / TILE) as usize
}

/// Means by tiles: sums and sums of squares of so many samples.
struct Means {
    sums: Vec<[f64; 2]>,
    count: f64,
}

impl Means {
    fn new() -> Self {
        Self { sums: vec![[0.0; 2]; TILES], count: 0.0 }
    }

    fn add(&mut self, tile: usize, value: f64) {
        self.sums[tile][0] += value;
        self.sums[tile][1] += value * value;
    }

    /// Mean and its variance.
    fn of(&self, tile: usize) -> [f64; 2] {
        let [mean, squares] = self.sums[tile].map(|sum| sum / self.count);
        [mean, (squares - mean * mean) / (self.count - 1.0)]
    }
}

/// The mean of W h over proposals is what the light in a tile, by paths of at most so many edges, comes to: path tracing
/// knows it. A bin's error probability is 1e-6 by the normal law, 1e-4 by Student's of 24 renders: all together below 1e-2
/// for another seed. The twin never draws one of the strategies whose densities it counts.
#[test]
fn independent_proposals_estimate_what_path_tracing_finds() {
    const RENDERS: u32 = 24;
    let context = context();
    let scene = scene_of(SCENE);
    let mut bench = Bench::new(&context, SCENE);
    let proposals: Vec<_> = (5001..5009).map(|seed| bench.candidates(1 << 17, seed)).collect();
    for longest in [3, MAX_EDGES] {
        let mut traced = Means::new();
        for seed in 1..=RENDERS {
            let [width, height] = FILM;
            let budget = Budget::SamplesPerPixel(16);
            let settings =
                Settings { method: Method::Pt, width, height, budget, seed, max_depth: longest, ..Settings::default() };
            let image = render_on(&context, &scene, &settings, &mut Silent).unwrap_or_else(|e| panic!("{e}")).image;
            let mut light = [0.0; TILES];
            for (i, pixel) in (0..).zip(&image.pixels) {
                let [r, g, b] = pixel.map(f64::from);
                light[tile(i % width, i / width)] += DVec3::new(r, g, b).dot(LUMINANCE) / f64::from(width * height);
            }
            (0..TILES).for_each(|tile| traced.add(tile, light[tile]));
            traced.count += 1.0;
        }
        for twin in [false, true] {
            let mut made = Means::new();
            for (candidate, [_, light_vertices]) in proposals.iter().flat_map(|(made, by)| made.iter().zip(by)) {
                made.count += 1.0;
                let key = candidate.key().filter(|key| key.edges() <= longest && candidate.weight() > 0.0);
                if key.is_some() && !(twin && *light_vertices == 1) {
                    let [x, y] = [0, 1].map(|i| (candidate.pixel[i] as u32).min(FILM[i] - 1));
                    made.add(tile(x, y), candidate.weight());
                }
            }
            let z: Vec<f64> = (0..TILES)
                .map(|tile| {
                    let [[a, v], [b, w]] = [made.of(tile), traced.of(tile)];
                    (a - b) / (v + w).sqrt()
                })
                .collect();
            let worst = z.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
            let chi2 = z.iter().map(|z| z * z).sum::<f64>() / TILES as f64;
            let [a, b] = [&made, &traced].map(|m| (0..TILES).map(|tile| m.of(tile)[0]).sum::<f64>());
            println!(
                "independence, at most {longest} edges, twin {twin}: worst |z| {worst:.2} in {TILES} tiles, chi2 / dof {chi2:.2}, film {:.4} of the traced one",
                a / b
            );
            assert_eq!(worst < Z_LIMIT, !twin, "at most {longest} edges, twin {twin}: |z| = {worst}");
        }
    }
}
