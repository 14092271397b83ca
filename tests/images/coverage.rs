//! What renders say of their own error, against closed forms: of 95 % intervals over many short renders, the share that
//! holds the truth.

use emlt::film::Image;
use emlt::film::cells::{TILE, Tiling};
use emlt::film::uncertainty::{Estimate, Y};
use emlt::methods::{Direct, Method, Settings};
use emlt::scene::Scene;

use super::renders::{render, scene, settings};
use super::{furnace, sphere};

/// Renders of each method.
const RENDERS: u32 = 200;
/// Probability with which an interval may miss.
const MISSING: f64 = 0.05;
/// What the share of intervals that hold the truth must lie between.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.92..=0.97;

/// Hits among intervals.
#[derive(Default)]
struct Hits {
    hits: u32,
    count: u32,
}

impl Hits {
    fn add(&mut self, estimate: &Estimate, truth: f64) {
        self.add_within(estimate.mean - truth, estimate.half_width(MISSING));
    }

    fn add_within(&mut self, difference: f64, half_width: f64) {
        self.hits += u32::from(difference.abs() <= half_width);
        self.count += 1;
    }

    fn share(&self) -> f64 {
        f64::from(self.hits) / f64::from(self.count)
    }

    /// Whether the share lies within the limits; says by how much the number of renders alone makes it uncertain.
    #[track_caller]
    fn check(&self, name: &str, renders: u32) {
        let error = (MISSING * (1.0 - MISSING) / f64::from(renders)).sqrt();
        println!(
            "{name}: {:.1} % of {} intervals hold the truth (of {renders} renders: +- {:.1} %)",
            100.0 * self.share(),
            self.count,
            100.0 * error
        );
        assert!(COVERAGE.contains(&self.share()), "{name}: {}", self.share());
    }
}

/// Mean of every tile of the truth, in R, G, B and luminance.
fn tiles(image: &Image) -> Vec<[f64; 4]> {
    let tiling = Tiling::of(image.width, image.height);
    let mut means = vec![[0.0; 4]; tiling.count()];
    for (i, [r, g, b]) in image.pixels.iter().map(|p| p.map(f64::from)).enumerate() {
        let add = [r, g, b, 0.2126 * r + 0.7152 * g + 0.0722 * b];
        means[tiling.tile(i)].iter_mut().zip(add).for_each(|(sum, v)| *sum += v);
    }
    means.iter_mut().zip(tiling.pixels()).for_each(|(mean, n)| mean.iter_mut().for_each(|v| *v /= n));
    means
}

fn check(name: &str, (scene, truth): (Scene, Image), options: Settings, samples_per_pixel: u32) {
    let tile_truth = tiles(&truth);
    let film_truth = [0, 1, 2, 3].map(|c| {
        let tiling = Tiling::of(truth.width, truth.height);
        tile_truth.iter().zip(tiling.pixels()).map(|(tile, n)| n * tile[c]).sum::<f64>() / truth.pixels.len() as f64
    });
    // Little of everything: there are many renders.
    let Settings { method, direct, max_depth, .. } = options;
    let film = [truth.width, truth.height];
    let settings =
        Settings { direct, max_depth, ensemble: 512, candidates: 1 << 14, ..settings(method, film, samples_per_pixel) };
    let (mut film, mut luminance, mut tiles, mut naive) =
        (Hits::default(), Hits::default(), Hits::default(), Hits::default());
    for seed in 1..=RENDERS {
        let outcome = render(&scene, &Settings { seed, ..settings.clone() });
        let uncertainty = outcome.uncertainty.unwrap();
        luminance.add(&uncertainty.film[Y], film_truth[Y]);
        for (estimate, truth) in uncertainty.film.iter().zip(film_truth).take(Y) {
            film.add(estimate, truth);
        }
        let tiling = Tiling::of(truth.width, truth.height);
        let mut pixels = vec![[0.0; 3]; tiling.count()];
        for (i, error) in uncertainty.pixels.pixels.iter().enumerate() {
            pixels[tiling.tile(i)].iter_mut().zip(error).for_each(|(sum, e)| *sum += f64::from(*e).powi(2));
        }
        for ((tile, truth), pixels) in uncertainty.tiles.iter().zip(&tile_truth).zip(pixels) {
            for c in 0..Y {
                tiles.add(&tile[c], truth[c]);
                let n = f64::from(TILE * TILE);
                naive.add_within(tile[c].mean - truth[c], 1.96 * pixels[c].sqrt() / n);
            }
        }
    }
    luminance.check(&format!("{name}, film's luminance"), RENDERS);
    film.check(&format!("{name}, film"), RENDERS);
    tiles.check(&format!("{name}, tiles"), RENDERS);
    println!("{name}, tiles by pixels taken as independent: {:.1} %", 100.0 * naive.share());
    if method != Method::Pt && direct == Direct::Mcmc {
        // The twin: neighbours share paths, and what pixels say of themselves is not enough.
        assert!(naive.share() < *COVERAGE.start(), "{}", naive.share());
    }
}

/// The plane alone scatters.
fn sphere() -> (Scene, Image) {
    let scene = scene(sphere::SCENE);
    let truth = sphere::truth(&scene);
    (scene, truth)
}

fn furnace(edges: u32) -> (Scene, Image) {
    let pixels = vec![furnace::radiance(edges).map(|v| v as f32); 24 * 16];
    (scene(furnace::SCENE), Image { width: 24, height: 16, pixels })
}

#[test]
fn intervals_of_emlt_hold_the_truth() {
    check("emlt", sphere(), Settings { method: Method::Emlt, max_depth: 3, ..Settings::default() }, 64);
}

#[test]
fn intervals_of_mlt_over_direct_light_hold_the_truth() {
    let options = Settings { method: Method::Mlt, direct: Direct::Pt, max_depth: 6, ..Settings::default() };
    check("mlt, direct light apart", furnace(6), options, 32);
}

#[test]
fn intervals_of_pt_hold_the_truth() {
    check("pt", sphere(), Settings { method: Method::Pt, max_depth: 3, ..Settings::default() }, 16);
}
