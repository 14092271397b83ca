//! Proofs that the kernels on the device are exact (METHOD.md section 4), on coloured scenes with metal and glass, smooth
//! and rough; for each, a deliberately broken twin that the same test must catch.

#[path = "kernel_proofs/arithmetic.rs"]
mod arithmetic;
#[path = "kernel_proofs/bench.rs"]
mod bench;
#[path = "kernel_proofs/cameras.rs"]
mod cameras;
#[path = "common/changed_sources.rs"]
mod changed_sources;
#[path = "kernel_proofs/corrections.rs"]
mod corrections;
#[path = "kernel_proofs/crossover.rs"]
mod crossover;
#[path = "kernel_proofs/culling.rs"]
mod culling;
#[path = "kernel_proofs/double.rs"]
mod double;
#[path = "kernel_proofs/estimator.rs"]
mod estimator;
#[path = "kernel_proofs/everything.rs"]
mod everything;
#[path = "kernel_proofs/features.rs"]
mod features;
#[path = "kernel_proofs/independence.rs"]
mod independence;
#[path = "kernel_proofs/invariance.rs"]
mod invariance;
#[path = "kernel_proofs/manifold.rs"]
mod manifold_proofs;
#[path = "kernel_proofs/memory.rs"]
mod memory;
#[path = "kernel_proofs/mixes.rs"]
mod mixes;
#[path = "kernel_proofs/precision.rs"]
mod precision;
#[path = "kernel_proofs/room.rs"]
mod room;
#[path = "textures/room.rs"]
#[allow(dead_code)]
mod rooms;
#[path = "kernel_proofs/stationarity.rs"]
mod stationarity;
#[path = "kernel_proofs/structural.rs"]
mod structural;
#[path = "kernel_proofs/subpath.rs"]
mod subpath;
#[path = "kernel_proofs/sums.rs"]
mod sums;
#[path = "kernel_proofs/waits.rs"]
mod waits;

use bench::{Bench, Guides, HALF, context};
use emlt::gpu::layout::{PassUniform, ROW_KEY, ROW_VERTICES, row_guide, unpack_position};
use emlt::gpu::shader::Variant;
use emlt::kernels::{
    Family, Kernel, bidirectional, caustic, difference, guided_bidirectional, guided_caustic, guided_lens,
    guided_multi_chain, jump, kept_lens, lens, manifold, multi_chain, walk_lens,
};
use emlt::scene::Scene;
use invariance::{FEWER, LOOKS, RARE, Z_LIMIT, check_long, check_stationarity, check_stationarity_on};

const SCENE: &str = "coloured_box.glb";
/// All light starts inside glass, and a mirror's shading normals lean: the scene of the kernels that need specular
/// vertices, and of METHOD.md's corrections C1 to C3.
const SPECULAR_SCENE: &str = "lamp_in_glass.glb";
/// The same room with metal and glass whose lobes are treated as specular, and such as are not.
const GLOSSY: &str = "glossy_box.glb";

/// The room with textures of every filter and wrap.
const TEXTURED: &str = "textured_box.glb";

/// The room with clear coats, sheen and brushed metal.
const LAYERED: &str = "layered_box.glb";

/// The scenes of the proofs with the kernels that keep the type and are proven there.
const PERTURBATIONS: [(&str, &[&Kernel]); 3] = [
    (
        SCENE,
        &[
            &lens::KERNEL,
            &guided_lens::KERNEL,
            &walk_lens::KERNEL,
            &kept_lens::KERNEL,
            &difference::KERNEL,
            &jump::KERNEL,
        ],
    ),
    (
        SPECULAR_SCENE,
        &[
            &lens::KERNEL,
            &multi_chain::KERNEL,
            &guided_multi_chain::KERNEL,
            &manifold::KERNEL,
            &caustic::KERNEL,
            &guided_caustic::KERNEL,
        ],
    ),
    (
        GLOSSY,
        &[
            &lens::KERNEL,
            &guided_lens::KERNEL,
            &multi_chain::KERNEL,
            &guided_multi_chain::KERNEL,
            &manifold::KERNEL,
            &caustic::KERNEL,
            &guided_caustic::KERNEL,
        ],
    ),
];

/// Those that may change it, but for the independence kernel and the crossover, which have proofs of their own.
const STRUCTURAL: [&Kernel; 2] = [&bidirectional::KERNEL, &guided_bidirectional::KERNEL];

/// A pass that proves run as if it were a kernel.
const WEIGH: Kernel = Kernel {
    name: "weigh",
    about: "",
    pass: "weigh",
    flags: &["probe"],
    family: Family::Structural,
    applies: |_, _| true,
    useless: |_| None,
    guided: false,
};

/// Share of proposals whose forward and backward log ratios do not cancel to 1e-3, and how many were looked at, at least
/// `wanted`.
fn asymmetric_share(
    bench: &mut Bench,
    kernel: &Kernel,
    flags: &[&'static str],
    guides: Guides,
    wanted: usize,
) -> (f64, usize) {
    let (mut bad, mut all) = (0usize, 0usize);
    let mut pass = 1;
    bench.fill_with(kernel);
    let mut listed = bench.list(kernel, HALF, guides);
    while all < wanted {
        bench.keep_origins();
        let with = |extra: &'static str| -> Vec<&'static str> {
            flags.iter().copied().chain(["probe"]).chain((extra != "probe").then_some(extra)).collect()
        };
        let records = ["probe", "probe_back"].map(|way| {
            let (uniform, paths) = &listed;
            bench.passes(kernel, &with(way), *uniform, pass..pass + 1);
            let records = bench.lens_records(paths.len() as u32);
            // The other half stays, and types do.
            if guides == Guides::Own {
                listed = bench.list(kernel, HALF, guides);
            }
            records
        });
        let [forward, backward] = &records;
        for (f, b) in forward.iter().zip(backward).filter(|(f, _)| f.possible) {
            all += 1;
            let cancels = b.possible && (f.log_ratio + b.log_ratio).abs() < 1e-3;
            bad += usize::from(!cancels);
        }
        pass += 1;
    }
    (bad as f64 / all as f64, all)
}

/// Says and checks it of kernels.
#[track_caller]
fn check_symmetry(bench: &mut Bench, name: &str, kernels: &[&Kernel], wanted: usize) {
    for kernel in kernels {
        say_symmetric(name, kernel, asymmetric_share(bench, kernel, &[], Guides::Other, wanted));
    }
}

/// Says what share of so many proposals is asymmetric, and checks it.
#[track_caller]
fn say_symmetric(name: &str, kernel: &Kernel, (share, n): (f64, usize)) {
    println!("{name}, {}: {share:.2e} of {n} proposals asymmetric", kernel.name);
    assert!(share < 1e-3, "{}: {share}", kernel.name);
}

/// METHOD.md 4.1 A1 on a million proposals a kernel.
#[test]
fn log_ratios_are_antisymmetric() {
    let context = context();
    for (scene, kernels) in PERTURBATIONS {
        check_symmetry(&mut Bench::new(&context, scene), scene, kernels, 1_000_000);
    }
    let mut bench = Bench::new(&context, SCENE);
    // Two twins that this test has to catch: the ID advanced between the look-ups, and guides from the own half,
    // which have moved by the time of the way back.
    let (share, _) = asymmetric_share(&mut bench, &guided_lens::KERNEL, &["twin_id"], Guides::Other, 100_000);
    println!("twin, id advanced between the look-ups: {share:.3} asymmetric");
    assert!(share > 0.05, "the twin with an advanced id passes: {share}");
    let (share, _) = asymmetric_share(&mut bench, &guided_lens::KERNEL, &[], Guides::Own, 100_000);
    println!("twin, guides from the own half: {share:.3} asymmetric");
    assert!(share > 0.05, "the twin with guides from the own half passes: {share}");
}

/// A scene of tests/scenes.
fn scene_of(name: &str) -> Scene {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(name);
    emlt::scene::import::import(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// Guides are what their paths are, but for the rounding of the packing: half a unit of 1/511.5.
#[test]
fn guides_are_published_as_they_are() {
    let context = context();
    let mut bench = Bench::new(&context, SCENE);
    bench.list(&guided_lens::KERNEL, HALF, Guides::Other);
    let order = bench.guides.order.clone();
    let keys = bench.keys(HALF, HALF);
    let mut looked_at = 0;
    for vertex in 0..bench::MAX_EDGES as usize {
        let positions = bench.rows(ROW_VERTICES + 2 * vertex + 1, HALF, HALF);
        let words = bench.rows(row_guide(bench::MAX_EDGES) + (1 + vertex) / 4, HALF, HALF);
        for (place, &path) in order.iter().enumerate() {
            let path = (path - HALF) as usize;
            if vertex < keys[path].edges() as usize {
                let told = unpack_position(words[place][(1 + vertex) % 4]);
                for (told, bits) in told.iter().zip(positions[path]) {
                    assert!((told - f64::from(f32::from_bits(bits))).abs() < 1.01 * 0.5 / 511.5);
                }
                looked_at += 1;
            }
        }
    }
    assert!(looked_at > 2 * HALF, "only {looked_at} vertices");
}

/// A step of length zero proposes the same path: log ratio 0 (METHOD.md section 6, item 8).
#[test]
fn a_step_of_zero_is_the_identity() {
    let context = context();
    for (scene, kernels) in PERTURBATIONS {
        let mut bench = Bench::new(&context, scene);
        for kernel in kernels {
            bench.refresh();
            check_still(&mut bench, scene, kernel);
        }
    }
}

/// Says and checks it of the paths there are, and of those kernels that have a step.
#[track_caller]
fn check_still(bench: &mut Bench, name: &str, kernel: &Kernel) {
    // Independent proposals have no zero step.
    if kernel.name == jump::KERNEL.name {
        return;
    }
    let (uniform, paths) = bench.list(kernel, HALF, Guides::Other);
    bench.passes(kernel, &["probe", "probe_still"], uniform, 1..2);
    let records = bench.lens_records(paths.len() as u32);
    let cannot = bench.ends_at_a_dirac(kernel);
    assert!(paths.iter().zip(&records).all(|(path, r)| !(cannot[*path as usize] && r.possible)), "{}", kernel.name);
    let can: Vec<_> = paths.iter().zip(&records).filter(|(path, _)| !cannot[**path as usize]).collect();
    let resting = can.iter().filter(|(_, r)| !r.possible).count();
    let bad = can.iter().filter(|(_, r)| r.possible && (r.log_ratio.is_nan() || r.log_ratio.abs() > 1e-3)).count();
    let n = can.len();
    println!("{name}, {}: of {n} paths {bad} not reproduced by a step of zero, {resting} rest", kernel.name);
    // To rest keeps balance. Paths with short edges at narrow lobes do, three where a scene has few; and where normals are
    // mapped, whose changes are not known, those with a chain to be solved over them.
    let few = 1e-3 * n as f64;
    let most_resting = match bench.features {
        features if features.normal_mapped && kernel.name == manifold::KERNEL.name => 0.9 * n as f64,
        features if features.narrow => few.max(3.0),
        _ => few,
    };
    let fits = bad as f64 <= few && resting as f64 <= most_resting;
    assert!(n > 0 && fits, "{}: {bad}, {resting}", kernel.name);
}

/// METHOD.md 4.1 A2: the factors that kernels keep agree with the master f, for start paths and after perturbations,
/// and w of a stored path is the w it was generated with.
#[test]
fn kernels_factors_agree_with_the_target() {
    let context = context();
    for scene in [SPECULAR_SCENE, GLOSSY] {
        check_factors(&mut Bench::new(&context, scene));
    }
}

#[track_caller]
fn check_factors(bench: &mut Bench) {
    let worst = factor_defects(bench);
    assert!(worst < 1e-3, "{worst}");
}

/// The largest share of paths of which w, C or the colour differ.
fn factor_defects(bench: &mut Bench) -> f64 {
    let mut worst = 0usize;
    let entries: Vec<u32> = (0..HALF).flat_map(|path| [path, 0]).collect();
    let all = PassUniform { seed: 77, stride: bench::COLUMNS, entries: HALF, ..Default::default() };
    for steps in [0u32, 8] {
        let moving = [&guided_caustic::KERNEL, &guided_lens::KERNEL, &guided_multi_chain::KERNEL, &manifold::KERNEL];
        let features = bench.features;
        let moving = moving.iter().filter(|kernel| (kernel.useless)(features).is_none());
        for (n, kernel) in moving.enumerate() {
            let (uniform, _) = bench.list(kernel, HALF, Guides::Other);
            let first = 1 + 100 * n as u32;
            bench.passes(kernel, &[], uniform, first..first + steps);
        }
        let made: Vec<f32> = bench.rows(ROW_KEY, 0, HALF).iter().map(|r| f32::from_bits(r[2])).collect();
        bench.run.set_lists(&entries);
        bench.passes(&WEIGH, &[], all, 0..1);
        let records = bench.records(HALF);
        let mut bad = [0usize; 3];
        for (r, made) in records.iter().zip(&made) {
            if steps == 0 {
                bad[0] += usize::from((r[0] - made).abs() > 1e-3);
            }
            bad[1] += usize::from((r[1] - r[3]).abs() > 1e-3);
            bad[2] += usize::from(r[2] > 1e-3);
        }
        println!(
            "after {steps} steps of every guided kernel and the manifold: {bad:?} of {HALF} differ in w, C, colour"
        );
        worst = bad.into_iter().fold(worst, usize::max);
    }
    worst as f64 / f64::from(HALF)
}

/// A variant that no one uses would hide a misspelt flag.
#[test]
fn twins_are_compiled_from_the_same_source() {
    for flags in [vec!["guided"], vec!["guided", "twin_id"], vec!["guided", "twin_one_sided"]] {
        let variant = Variant { pass: "camera_side", features: Default::default(), max_edges: 4, flags };
        assert!(emlt::gpu::shader::compose(&variant).is_ok());
    }
}
