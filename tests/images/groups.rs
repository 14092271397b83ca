//! Groups are independent: whatever happens to the paths of one, those of the others move as they would have.

use std::path::Path;

use emlt::ensemble::bootstrap::{BATCH, BATCH_BYTES, Given, Start};
use emlt::ensemble::build::Build;
use emlt::ensemble::groups::Groups;
use emlt::ensemble::guidance::Guidance;
use emlt::ensemble::mix::Mix;
use emlt::ensemble::path_traced::Direct;
use emlt::ensemble::sweep::{Ensemble, list_words};
use emlt::gpu::context::Context;
use emlt::gpu::layout::{chain_rows, counter_bytes, row_guide};
use emlt::gpu::run::{Buffer, Run, Sizes};
use emlt::gpu::scene::SceneData;
use emlt::scene::Features;
use emlt::scene::import::import;

const FILM: [u32; 2] = [16, 12];
const MAX_EDGES: u32 = 8;
const PATHS: u32 = 1024;
const COUNT: u32 = 8;
/// The group whose start is changed.
const CHANGED: u32 = 3;
/// Every kernel that looks at other paths, beside those that make it reach everywhere.
const MIX: &str = "independence=0.05,guided-bidirectional=0.15,guided-light-subpath=0.1,crossover=0.1,lens=1,guided-lens=1,jump=1,difference=1,multi-chain=1,guided-multi-chain=1,guided-caustic=1";

/// What four sweeps of both halves leave: the states of all paths, and every layer of the film.
struct Left {
    /// Per path its rows.
    states: Vec<Vec<[u32; 4]>>,
    layers: Vec<Vec<u8>>,
}

/// Renders with the paths of one group (of [`COUNT`]) begun elsewhere if `changed`; the ensemble is split as `groups`.
fn render(context: &Context, groups: Groups, changed: bool) -> Left {
    let scene = import(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/coloured_box.glb")).unwrap();
    let data = SceneData::new(&scene, scene.camera(None).unwrap(), FILM[0], FILM[1]).unwrap();
    let features = Features::of(&scene);
    let mix = Mix::new(&Mix::parse(MIX).unwrap(), features);
    assert_eq!(mix.kernels().len(), 11);
    let layer = 24 * u64::from(FILM[0] * FILM[1]);
    let sizes = Sizes {
        chains: 16 * chain_rows(MAX_EDGES) as u64 * u64::from(PATHS),
        lists: 4 * list_words(PATHS, BATCH),
        output: BATCH_BYTES.max(layer * u64::from(COUNT)),
        counters: counter_bytes(mix.kernels().len()),
    };
    let mut run = Run::new(context, &data, sizes).unwrap();
    let start = Start {
        features,
        direct: Direct::Mcmc,
        maps_row: None,
        max_edges: MAX_EDGES,
        two_stage: None,
        candidates: 1 << 15,
        seed: 1,
        groups: Groups::new(PATHS, COUNT),
        stride: PATHS,
        film: FILM,
    };
    let bootstrap = start.run(&mut run).unwrap().unwrap();
    if changed {
        swap_halves(&mut run, start.groups);
    }
    run.clear(Buffer::Output);
    run.clear(Buffer::Counters);
    let build = Build {
        features,
        direct: Direct::Mcmc,
        sought: false,
        given: Given::default(),
        max_edges: MAX_EDGES,
        maps: false,
        two_stage: false,
        guidance: Guidance::default(),
        seed: 1,
        groups,
    };
    let mut ensemble = Ensemble::new(&mut run, build, mix, bootstrap).unwrap();
    for _ in 0..8 {
        ensemble.step(&mut run, usize::MAX).unwrap();
        while !ensemble.is_whole() {
            ensemble.step(&mut run, usize::MAX).unwrap();
        }
    }
    let rows: Vec<Vec<[u32; 4]>> = (0..row_guide(MAX_EDGES)).map(|row| read_row(&mut run, row)).collect();
    let states = (0..PATHS as usize).map(|path| rows.iter().map(|row| row[path]).collect()).collect();
    let layers = (0..u64::from(groups.count()))
        .map(|group| run.read(Buffer::Output, group * layer..(group + 1) * layer).unwrap())
        .collect();
    Left { states, layers }
}

fn read_row(run: &mut Run, row: usize) -> Vec<[u32; 4]> {
    let bytes = 16 * u64::from(PATHS);
    run.read(Buffer::Chains, row as u64 * bytes..(row as u64 + 1) * bytes).unwrap()
}

/// Exchanges the halves of the changed group.
fn swap_halves(run: &mut Run, groups: Groups) {
    for row in 0..row_guide(MAX_EDGES) {
        let mut columns = read_row(run, row);
        for i in 0..groups.group_paths() {
            let [a, b] = [0, 1].map(|half| (groups.first(half, CHANGED) + i) as usize);
            columns.swap(a, b);
        }
        run.set_chains(16 * row as u64 * u64::from(PATHS), bytemuck::cast_slice(&columns));
    }
}

/// Share of the other groups' paths that another start of the changed group leaves where they would have gone.
fn unmoved(left: [&Left; 2]) -> f64 {
    let groups = Groups::new(PATHS, COUNT);
    let others: Vec<usize> = (0..PATHS).filter(|path| groups.of_path(*path) != CHANGED).map(|p| p as usize).collect();
    let same = others.iter().filter(|path| left[0].states[**path] == left[1].states[**path]).count();
    same as f64 / others.len() as f64
}

#[test]
fn groups_do_not_know_of_each_other() {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let [whole, changed] = [false, true].map(|changed| render(&context, Groups::new(PATHS, COUNT), changed));
    assert_eq!(unmoved([&whole, &changed]), 1.0);
    for group in 0..COUNT as usize {
        let same = whole.layers[group] == changed.layers[group];
        assert_eq!(same, group != CHANGED as usize, "layer of group {group}");
    }
    // The twin: guides, partners and medians from the whole of the other half.
    let [whole, changed] = [false, true].map(|changed| render(&context, Groups::new(PATHS, 1), changed));
    let share = unmoved([&whole, &changed]);
    println!(
        "one ensemble in place of eight: {:.1} % of the other paths are where they would have been",
        100.0 * share
    );
    assert!(share < 0.5, "{share}");
}
