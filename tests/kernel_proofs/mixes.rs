//! Stationarity (METHOD.md 4.4, S1) of whole mixes, as they are run: half-sweeps of both halves in turn, lists, rests,
//! guides that evolve. All chains of both halves count, each from a bidirectional candidate with its weight; guides then
//! depend on the chains they guide, which shows by the inverse of their number, 8,192 a group.

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, CANDIDATE_PASS, MAPS_ROWS, Start};
use emlt::ensemble::groups::{Groups, MOST_GROUPS};
use emlt::ensemble::guidance::Guidance;
use emlt::ensemble::mix::{HALF_SWEEP, Mix};
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::photons::has_photons;
use emlt::ensemble::sweep::{Build, Ensemble, list_words};
use emlt::gpu::context::Context;
use emlt::gpu::layout::{COUNTER_WORDS, chain_rows};
use emlt::gpu::run::{Buffer, PASS_SLOTS, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::kernels::{Kernel, guided_bidirectional};
use emlt::methods::{Method, default_mix, default_two_stage};
use emlt::reference::rng;
use emlt::scene::{Features, Scene};

use crate::bench::{FILM, HALF, MAX_EDGES, PATHS, SEED, context};
use crate::stationarity::{PLACE_ROWS, Paired, Place, place};
use crate::{GLOSSY, SCENE, SPECULAR_SCENE, Z_LIMIT, rooms, scene_of};

/// Mutations of every path after which it is looked at: the first, a few, a half-sweep, three and a few.
const STEPS: [u32; 4] = [1, 4, HALF_SWEEP, 64];
/// Candidates of a round: where a third of them carries light, nothing is left over.
const CANDIDATES: u32 = 360_000;

fn places(run: &mut Run, half: usize) -> Vec<Place> {
    let range = |row: usize| {
        let start = 16 * (row as u64 * u64::from(PATHS) + half as u64 * u64::from(HALF));
        start..start + 16 * u64::from(HALF)
    };
    let rows: Vec<[u32; 4]> = run.read_ranges(Buffer::Chains, &PLACE_ROWS.map(range)).unwrap();
    let n = HALF as usize;
    (0..n).map(|i| place([rows[i], rows[n + i], rows[2 * n + i]])).collect()
}

/// A mix as it is run.
struct Mixed {
    name: &'static str,
    kernels: Vec<(&'static Kernel, f64)>,
    /// Exponent of a two-stage target.
    two_stage: Option<f64>,
    /// Whether the start, and so the independence kernel, has maps where the scene has anything for them.
    sought: bool,
}

impl Mixed {
    fn of(method: Method) -> Self {
        let sought = method == Method::Emlt;
        Self { name: method.name(), kernels: default_mix(method), two_stage: default_two_stage(method), sought }
    }
}

/// Chains of one mix, by steps, from as many rounds as make `chains` of them.
fn move_chains(context: &Context, scene: &Scene, mixed: &Mixed, chains: usize) -> Vec<Paired> {
    let camera = scene.camera(None).unwrap();
    let data = SceneData::new(scene, camera, FILM[0], FILM[1]).unwrap();
    let features = Features::of(scene).seen_by(scene, camera);
    let mix = Mix::new(&mixed.kernels, features);
    let groups = Groups::new(PATHS, MOST_GROUPS);
    let rows = chain_rows(MAX_EDGES) as u64 * u64::from(PATHS);
    let sought = mixed.sought && has_photons(features);
    let sizes = Sizes {
        chains: 16 * (rows + if sought { MAPS_ROWS } else { 0 }),
        lists: 4 * list_words(PATHS, BATCH),
        output: BATCH_BYTES.max(u64::from(16 * FILM[0] * FILM[1] * groups.count())),
        counters: (4 * COUNTER_WORDS * (mix.kernels().len() + 1)) as u64,
    };
    let mut run = Run::new(context, &data, sizes).unwrap();
    let mut paired: Vec<Paired> = STEPS.iter().map(|_| Paired::new()).collect();
    for seed in 6001.. {
        let start = Start {
            features,
            direct: Direct::Mcmc,
            maps_row: sought.then_some(rows as u32),
            max_edges: MAX_EDGES,
            two_stage: mixed.two_stage,
            candidates: 1 << 15,
            seed,
            groups,
            stride: PATHS,
            film: FILM,
        };
        let mut starting = start.begin(&run);
        while start.step(&mut run, &mut starting).unwrap() {}
        let given = starting.given();
        assert_eq!(given.photons.is_some(), sought, "a map of photons");
        assert_eq!(given.sightings.is_some(), sought, "a map of sightings");
        let bootstrap = start.finish(&mut run, starting).unwrap().unwrap();
        let start = Start { seed: seed + 1_000_000, ..start };
        let (candidates, by) =
            start.candidates(&mut run, &bootstrap.strategies, given, CANDIDATES, CANDIDATE_PASS).unwrap();
        let mut chosen: Vec<u32> = (0..CANDIDATES).filter(|i| candidates[*i as usize].weight() > 0.0).collect();
        // Candidates come by strategy; every group is to have its share of all.
        chosen.sort_by_key(|i| rng::random_words(SEED, *i, seed, 0));
        chosen.truncate(PATHS as usize);
        let lit = chosen.len();
        assert!(lit > PATHS as usize / 4, "{lit} candidates carry light");
        // The rest are copies that only guide.
        let chosen: Vec<u32> = chosen.iter().copied().cycle().take(PATHS as usize).collect();
        start.fill(&mut run, given, &by, &chosen).unwrap();
        // I / density, over w of the two-stage target.
        let weights: Vec<f64> = chosen[..lit]
            .iter()
            .map(|i| &candidates[*i as usize])
            .map(|c| c.weight() / bootstrap.pixel_weights.as_ref().map_or(1.0, |w| w.at(c.pixel)))
            .collect();
        let weight = |path: usize| weights.get(path).copied().unwrap_or(0.0);
        run.clear(Buffer::Output);
        let build = Build {
            features,
            direct: Direct::Mcmc,
            sought,
            given,
            max_edges: MAX_EDGES,
            maps: false,
            two_stage: mixed.two_stage.is_some(),
            guidance: Guidance::default(),
            seed,
            groups,
        };
        let mut ensemble = Ensemble::new(&mut run, build, mix.clone(), bootstrap).unwrap();
        let before = [0, 1].map(|half| places(&mut run, half));
        let mut made = [0; 2];
        let mut half = 0;
        while made[1] < STEPS[3] {
            let structural = !ensemble.perturbs();
            ensemble.step(&mut run, PASS_SLOTS).unwrap();
            let whole = ensemble.is_whole();
            if structural {
                made[half] += 1;
            } else if whole {
                made[half] = made[half].next_multiple_of(HALF_SWEEP);
            }
            if let Some(n) = STEPS.iter().position(|steps| *steps == made[half]).filter(|_| structural || whole) {
                let first = half * HALF as usize;
                paired[n].chains += (first..first + HALF as usize).filter(|path| *path < lit).count();
                for (i, (before, after)) in before[half].iter().zip(&places(&mut run, half)).enumerate() {
                    paired[n].add(before, after, weight(first + i));
                }
            }
            half = if whole { 1 - half } else { half };
        }
        if paired[0].chains >= chains {
            break;
        }
    }
    paired
}

/// Largest |z| of all bins and steps.
fn check(context: &Context, scene: &Scene, mixed: &Mixed, chains: usize) -> f64 {
    let mut worst = 0.0f64;
    for (steps, paired) in STEPS.iter().zip(move_chains(context, scene, mixed, chains)) {
        let z = paired.verdict();
        println!(
            "{}, mix of {}, {steps} steps of {} chains: worst |z| {:.2} in {} bins, chi2 / dof {:.2}",
            scene.name, mixed.name, z.chains, z.worst, z.bins, z.chi2
        );
        worst = worst.max(z.worst);
    }
    worst
}

/// The number of places is left out, as in the twin of the kernel alone.
static WITHOUT_PLACES: Kernel = Kernel { flags: &["segment", "guided", "twin_places"], ..guided_bidirectional::KERNEL };

/// A bin's error probability is 1e-6, all together of a million chains below 3e-3.
fn check_default(context: &Context, scene: &Scene, method: Method, chains: usize) {
    let z = check(context, scene, &Mixed::of(method), chains);
    assert!(z < Z_LIMIT, "{}, {}: |z| = {z}", scene.name, method.name());
}

#[test]
fn the_mix_of_mlt_leaves_the_target_alone() {
    check_default(&context(), &scene_of(SCENE), Method::Mlt, 1_000_000);
}

#[test]
fn the_mix_of_emlt_leaves_the_target_alone() {
    check_default(&context(), &scene_of(SCENE), Method::Emlt, 1_000_000);
}

/// With maps of photons and of sightings, which the independence kernel proposes by and paths are weighed by.
#[test]
fn the_mix_of_emlt_with_maps_leaves_the_target_alone() {
    let scene = scene_of(SPECULAR_SCENE);
    assert!(has_photons(Features::of(&scene)));
    check_default(&context(), &scene, Method::Emlt, 300_000);
}

#[test]
fn a_mix_with_a_broken_kernel_is_caught() {
    let mut broken = Mixed { name: "a twin", ..Mixed::of(Method::Emlt) };
    // As often as mlt makes such mutations.
    broken.kernels[1] = (&WITHOUT_PLACES, 0.15);
    let z = check(&context(), &scene_of(SCENE), &broken, 300_000);
    assert!(z > Z_LIMIT, "a mix with a broken kernel passes: |z| = {z}");
}

/// The long form: ten million.
#[test]
#[ignore = "takes an hour on a processor, minutes on a GPU; ./run test --long"]
fn long_mixes_leave_the_target_alone() {
    let context = context();
    for scene in [SCENE, SPECULAR_SCENE, GLOSSY].map(scene_of) {
        for method in [Method::Mlt, Method::Emlt] {
            check_default(&context, &scene, method, 10_000_000);
        }
    }
}

/// On textures, and under lights of every kind: two million.
#[test]
#[ignore = "takes tens of minutes on a processor, minutes on a GPU; ./run test --long"]
fn long_mixes_on_textures_and_under_all_lights_leave_the_target_alone() {
    let context = context();
    for scene in [rooms::polished_room(), rooms::glazed_room()] {
        for method in [Method::Mlt, Method::Emlt] {
            check_default(&context, &scene, method, 2_000_000);
        }
    }
}
