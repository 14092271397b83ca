//! The closed furnace (tests/scenes/furnace.glb): walls of emission e and albedo rho all around.
//!
//! A path of k edges that ends on a wall carries e rho^(k - 1), whatever the room's shape. So with at most k edges every
//! pixel is e (1 - rho^k) / (1 - rho) (METHOD.md 4.5, F1).

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, CANDIDATE_PASS, CANDIDATES, Given, Mean, Start};
use emlt::ensemble::groups::Groups;
use emlt::ensemble::strategies::Strategies;
use emlt::ensemble::sweep::list_words;
use emlt::film::Image;
use emlt::gpu::context::Context;
use emlt::gpu::layout::chain_rows;
use emlt::gpu::run::{Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::methods::{Direct, Method, Settings};
use emlt::report::student::two_sided;
use emlt::scene::Features;

use super::comparison::{self, LEVEL, Power, Truth};
use super::renders::{changed, render, scene, settings};

pub(super) const SCENE: &str = "tests/scenes/furnace.glb";
const EMISSION: [f64; 3] = [0.5, 1.0, 0.25];
const ALBEDO: [f64; 3] = [0.6, 0.5, 0.3];
const LONGEST: u32 = 12;
const FILM: [u32; 2] = [16, 12];

/// Radiance everywhere with at most `edges` edges.
pub(super) fn radiance(edges: u32) -> [f64; 3] {
    [0, 1, 2].map(|c| EMISSION[c] * (1.0 - ALBEDO[c].powi(edges as i32)) / (1.0 - ALBEDO[c]))
}

/// The limits of edges. Shaders are compiled for each anew, which takes longer than the renders, so not all are tried;
/// b below is of every length.
const LIMITS: [u32; 4] = [1, 2, 5, LONGEST];

/// Three renders for each of the limits, each over its closed form. They are replicates of one image: all should be 1 but
/// for noise, whatever their limit.
fn check(method: Method, direct: Direct, samples_per_pixel: u32, power: Power) {
    let scene = scene(SCENE);
    let normalised = |edges: u32, seed: u32| {
        let settings = Settings { max_depth: edges, seed, direct, ..settings(method, FILM, samples_per_pixel) };
        let truth = radiance(edges);
        changed(&render(&scene, &settings).image, |_, _, p| [0, 1, 2].map(|c| (f64::from(p[c]) / truth[c]) as f32))
    };
    let images: Vec<Image> = (0..12).map(|i| normalised(LIMITS[i % LIMITS.len()], 1 + i as u32)).collect();
    let truth = Truth { image: changed(&images[0], |_, _, _| [1.0; 3]), variance: None, tile: 4 };
    comparison::check(&format!("furnace {} {direct:?}", method.name()), &images, &truth, power);
}

#[test]
fn furnace_by_pt() {
    check(Method::Pt, Direct::Mcmc, 256, Power { film: 0.003, tile: 0.006 });
}

#[test]
fn furnace_by_mlt() {
    check(Method::Mlt, Direct::Mcmc, 2000, Power { film: 0.02, tile: 0.08 });
}

#[test]
fn furnace_by_emlt() {
    check(Method::Emlt, Direct::Mcmc, 2000, Power { film: 0.02, tile: 0.08 });
}

/// With at most 2 edges there is nothing for chains to do.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_furnace_with_direct_light_apart() {
    check(Method::Emlt, Direct::Pt, 2000, Power { film: 0.005, tile: 0.04 });
}

/// b of every path length is the luminance of e rho^(k - 1): the bidirectional candidates from which mlt and emlt take b
/// and their start, length by length.
#[test]
fn furnace_by_path_length() {
    let scene = scene(SCENE);
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let data = SceneData::new(&scene, scene.camera(None).unwrap(), FILM[0], FILM[1]).unwrap();
    let paths = 2;
    let sizes = Sizes {
        chains: 16 * chain_rows(LONGEST) as u64 * u64::from(paths),
        lists: 4 * list_words(paths, BATCH),
        output: BATCH_BYTES,
        counters: 256,
    };
    let mut run = Run::new(&context, &data, sizes).unwrap();
    let features = Features::of(&scene);
    let start = Start {
        features,
        direct: Direct::Mcmc,
        maps_row: None,
        max_edges: LONGEST,
        two_stage: None,
        candidates: CANDIDATES,
        seed: 1,
        groups: Groups::new(paths, 1),
        stride: paths,
        film: FILM,
    };
    let strategies = Strategies::uniform(1..=LONGEST, false, false);
    let (candidates, list) =
        start.candidates(&mut run, &strategies, Given::default(), CANDIDATES, CANDIDATE_PASS).unwrap();
    let mut worst = f64::INFINITY;
    for edges in 1..=LONGEST {
        let mut weights = Mean::default();
        // Every wall is a light, so a walk ends after one edge.
        let made = |l: &[u32; 2]| l[0] == edges || (edges == 1 && l[0] == 0);
        candidates.iter().zip(&list).filter(|(_, l)| made(l)).for_each(|(c, _)| weights.add(c.weight()));
        // The number of candidates of each length is fixed (systematic sampling), so it adds no noise.
        let share = weights.count / f64::from(CANDIDATES);
        let (b, standard_error) = (share * weights.mean(), share * weights.standard_error());
        let term = |c: usize| EMISSION[c] * ALBEDO[c].powi(edges as i32 - 1);
        let truth = 0.2126 * term(0) + 0.7152 * term(1) + 0.0722 * term(2);
        let z = (b - truth) / standard_error;
        println!("furnace, {edges} edges: b {:.6} +- {:.2} %, z {z:.2}", b, 100.0 * standard_error / truth);
        worst = worst.min(two_sided(z, 1000));
        // What the test can see: 2 % at any length.
        assert!(two_sided(0.02 * truth / standard_error, 1000) * f64::from(LONGEST) < LEVEL, "{edges} edges");
    }
    assert!(worst * f64::from(LONGEST) > LEVEL, "p {worst}");
}
