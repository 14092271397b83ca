//! METHOD.md 4.1 A4: log ratios of the device against those of the same shaders in double precision, proposal by proposal.
//!
//! The device proposes y and leaves it where the way back would find it; in double precision the kernel then proposes the
//! same y: camera and light sides trace the way to it again, the structural kernels read it.

use std::thread;

use emlt::gpu::layout::{PassUniform, chain_rows, row_guide};
use emlt::gpu::shader::{Variant, compose};
use emlt::kernels::{Family, Kernel, crossover, guided_caustic, guided_lens, guided_multi_chain, lens, manifold};
use emlt::scene::{Environment, Scene};

use glam::{Affine3A, Vec3};

use crate::bench::{Bench, COLUMNS, Guides, HALF, MAX_EDGES, PATHS, context};
use crate::crossover::{cross, pair_list};
use crate::double::Double;
use crate::{
    GLOSSY, LAYERED, PERTURBATIONS, SCENE, SPECULAR_SCENE, STRUCTURAL, TEXTURED, WEIGH, rooms, scene_of, subpath,
};

/// METHOD.md: the median difference, the one that all but a thousandth keep, and that share.
const MEDIAN: f64 = 1e-4;
const LARGE: f64 = 1e-2;
const SHARE: f64 = 1e-3;

/// One proposal: its log ratio by the device and in double precision, and the type of its path.
struct Pair {
    single: f64,
    double: f64,
    name: String,
}

impl Pair {
    fn difference(&self) -> f64 {
        (self.single - self.double).abs()
    }
}

/// All chains of the device, as words.
fn snapshot(bench: &mut Bench) -> Vec<u32> {
    (0..chain_rows(MAX_EDGES)).flat_map(|row| bench.rows(row, 0, COLUMNS).concat()).collect()
}

/// A pass of `kernel` in double precision over these chains.
fn pass_in_double(
    bench: &Bench,
    kernel: &Kernel,
    flags: &[&'static str],
    uniform: PassUniform,
    chains: &[u32],
) -> Double {
    let flags = kernel.flags.iter().chain(flags).copied().collect();
    let variant = Variant { pass: kernel.pass, features: bench.features, max_edges: MAX_EDGES, flags };
    let module = naga::front::wgsl::parse_str(&compose(&variant).unwrap()).unwrap_or_else(|e| panic!("{e}"));
    let uniform = PassUniform { group_stride: 1, ..uniform };
    Double::new(module, |group, binding| match (group, binding) {
        (0, 0) => bytemuck::cast_slice(bytemuck::bytes_of(&bench.data.uniform)).to_vec(),
        (0, 1) => bytemuck::cast_slice(&bench.data.nodes).to_vec(),
        (0, 2) => bytemuck::cast_slice(&bench.data.triangles).to_vec(),
        (0, 3) => bytemuck::cast_slice(&bench.data.shading).to_vec(),
        (0, 4) => bytemuck::cast_slice(&bench.data.tables).to_vec(),
        (0, 5) => bench.data.corners.clone(),
        (0, 6) => bench.data.texels.clone(),
        (1, 0) => bytemuck::cast_slice(bytemuck::bytes_of(&uniform)).to_vec(),
        (1, 1) => chains.to_vec(),
        (1, 2) => bench.lists.clone(),
        (1, 5) => bytemuck::cast_slice(&bench.bootstrap.strategies.log_table()[..]).to_vec(),
        _ => Vec::new(),
    })
}

/// `f` of every one of `entries`, on all processors, in order.
fn each<T: Send>(double: &Double, entries: &[u32], f: impl Fn(&mut Double, u32) -> T + Sync) -> Vec<T> {
    let threads = thread::available_parallelism().map_or(1, |n| n.get());
    let f = &f;
    thread::scope(|scope| {
        let parts: Vec<_> = entries
            .chunks(entries.len().div_ceil(threads).max(1))
            .map(|part| {
                let mut double = double.another();
                scope.spawn(move || part.iter().map(|entry| f(&mut double, *entry)).collect::<Vec<T>>())
            })
            .collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    })
}

/// About `wanted` proposals of `kernel`, evenly out of all entries: as double precision traces them, with further flags;
/// and as it evaluates C of x and of the device's own y, which is all of an unguided perturbation's ratio.
fn proposals(bench: &mut Bench, kernel: &Kernel, twin: &[&'static str], wanted: usize) -> [Vec<Pair>; 2] {
    let structural = !kernel.family.keeps_types();
    // From the same random numbers again the second structural kernel would often propose the path as it is.
    let pass = if structural && kernel.guided { 2 } else { 1 };
    let (uniform, paths) = if structural {
        bench.structural_list(kernel, HALF, pass)
    } else {
        bench.fill_with(kernel);
        bench.list(kernel, HALF, Guides::Other)
    };
    let keys = bench.keys(0, HALF);
    let mut chains = snapshot(bench);
    bench.passes(kernel, &["probe"], uniform, pass..pass + 1);
    let records = bench.lens_records(paths.len() as u32);
    for row in 0..row_guide(MAX_EDGES) {
        let moved = bench.rows(row, 0, HALF).concat();
        let at = 4 * (row * COLUMNS as usize + PATHS as usize);
        chains[at..at + moved.len()].copy_from_slice(&moved);
    }
    // Under a sky some bidirectional proposals have no way back: then y is not left anywhere.
    let is_possible = |i: &u32| records[*i as usize].possible && records[*i as usize].log_ratio > -1e29;
    let possible: Vec<u32> = (0..paths.len() as u32).filter(is_possible).collect();
    let every = (possible.len() / wanted).max(1);
    let entries: Vec<u32> = possible.into_iter().step_by(every).collect();
    let flags: Vec<&'static str> = ["probe", "probe_back"].into_iter().chain(twin.iter().copied()).collect();
    let double = pass_in_double(bench, kernel, &flags, PassUniform { pass_index: pass, ..uniform }, &chains);
    let all = uniform.entries;
    let ratios = each(&double, &entries, |double, entry| {
        double.run(entry, all);
        double.record[0]
    });
    // Entry i of `weigh` is column i: x, and behind all paths y.
    bench.lists = (0..COLUMNS).flat_map(|column| [column, 0]).collect();
    let weigh = PassUniform { stride: COLUMNS, entries: COLUMNS, ..Default::default() };
    let double = pass_in_double(bench, &WEIGH, &[], weigh, &chains);
    let side = if kernel.family == Family::LightSide { 3 } else { 2 };
    let gains = each(&double, &entries, |double, entry| {
        let path = paths[entry as usize];
        let [x, y] = [path, path + PATHS].map(|column| {
            double.run(column, COLUMNS);
            double.evaluations[0][side]
        });
        y - x
    });
    let pair = |(entry, double): (&u32, f64)| Pair {
        single: f64::from(records[*entry as usize].log_ratio),
        double,
        name: keys[paths[*entry as usize] as usize].string(),
    };
    [ratios, gains].map(|of| entries.iter().zip(of).map(pair).collect())
}

/// The independence kernel's log w of states, as the device weighs them and as they come out in double precision.
fn weights(bench: &mut Bench, wanted: usize) -> Vec<Pair> {
    bench.lists = (0..HALF).flat_map(|path| [path, 0]).collect();
    let lists = bench.lists.clone();
    bench.run.set_lists(&lists);
    let uniform = PassUniform { stride: COLUMNS, entries: HALF, ..Default::default() };
    let chains = snapshot(bench);
    let keys = bench.keys(0, HALF);
    bench.passes(&WEIGH, &[], uniform, 0..1);
    let weighed = bench.records(HALF);
    let entries: Vec<u32> = (0..HALF).step_by(HALF as usize / wanted).collect();
    let double = pass_in_double(bench, &WEIGH, &[], uniform, &chains);
    let log_w = each(&double, &entries, |double, entry| {
        double.run(entry, HALF);
        let [log_i, log_density, ..] = double.evaluations[0];
        log_i - log_density
    });
    let pair = |(entry, log_w): (&u32, f64)| Pair {
        single: f64::from(weighed[*entry as usize][0]),
        double: log_w,
        name: keys[*entry as usize].string(),
    };
    entries.iter().zip(log_w).map(pair).collect()
}

/// Crossovers: the log ratio of both gains and the cut, as the device decides by it; the twin leaves out that of v.
fn exchanges(bench: &mut Bench, one_sided: bool, wanted: usize) -> Vec<Pair> {
    const PASS: u32 = 1;
    let pairs = pair_list(bench, HALF, PASS, 7919).pairs;
    let (chains, keys) = (snapshot(bench), bench.keys(0, HALF));
    bench.lists = pairs.iter().flat_map(|pair| pair.words()).collect();
    cross(bench, &pairs, &["probe"], PASS);
    let count = pairs.len() as u32;
    let records = bench.lens_records(count);
    let possible: Vec<u32> = (0..count).filter(|i| records[*i as usize].possible).collect();
    let entries: Vec<u32> = possible.iter().copied().step_by((possible.len() / wanted).max(1)).collect();
    let uniform = PassUniform { pass_index: PASS, ..bench.cut_uniform(2 * count as usize) };
    let double = pass_in_double(bench, &crossover::KERNEL, &[], uniform, &chains);
    let ratios = each(&double, &entries, |double, entry| {
        let mut gain = |entry: u32| {
            double.run(entry, 2 * count);
            // What is hidden in double precision has none.
            double.evaluations.get(1).map_or(f64::NAN, |after| after[0] - double.evaluations[0][0])
        };
        let gains = [gain(entry), gain(entry + count)];
        let both = if one_sided { gains[0] } else { gains[0] + gains[1] };
        both + f64::from(pairs[entry as usize].log_cut)
    });
    let pair = |(entry, double): (&u32, f64)| Pair {
        single: f64::from(records[*entry as usize].log_ratio),
        double,
        name: keys[pairs[*entry as usize].paths[0] as usize].string(),
    };
    entries.iter().zip(ratios).map(pair).collect()
}

/// Says how far apart the two are, and lists what differs by much: median, share of large differences.
fn summary(what: &str, pairs: &mut [Pair]) -> (f64, f64) {
    // What is no number differs most.
    pairs.sort_by(|a, b| b.difference().total_cmp(&a.difference()));
    let n = pairs.len();
    let median = pairs[n / 2].difference();
    let large = pairs.iter().filter(|pair| pair.difference().is_nan() || pair.difference() >= LARGE).count();
    let thousandth = pairs[n / 1000].difference();
    println!("{what}: {n} proposals, median {median:.1e}, 99.9 % within {thousandth:.1e}, {large} above {LARGE}");
    for pair in pairs.iter().take(large.min(5)) {
        println!("    {}: {:.4} by the device, {:.4} in double precision", pair.name, pair.single, pair.double);
    }
    (median, large as f64 / n as f64)
}

/// A scene turned so that no wall stands straight. The frame in which a narrow lobe's half-vector is told
/// (`basis_of`) turns over where a normal's z changes its sign, and on a straight wall z is nothing but rounding.
fn turned(mut scene: Scene) -> Scene {
    let turn = Affine3A::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    for point in scene.positions.iter_mut().chain(&mut scene.normals) {
        *point = turn.transform_vector3(*point);
    }
    for tangent in &mut scene.tangents {
        *tangent = turn.transform_vector3(tangent.truncate()).extend(tangent.w);
    }
    for camera in &mut scene.cameras {
        camera.world_from_camera = turn * camera.world_from_camera;
    }
    scene
}

/// The room with metal and glass without its ceiling, under an even sky or a map of one.
pub fn under_a_sky(map: bool) -> Scene {
    let mut scene = scene_of(GLOSSY);
    let top = scene.positions.iter().fold(f32::MIN, |top, p| top.max(p.y));
    let up = |triangle: &[u32; 3]| triangle.iter().all(|i| scene.positions[*i as usize].y > top - 1e-3);
    let kept: Vec<usize> = (0..scene.triangles.len()).filter(|i| !up(&scene.triangles[*i])).collect();
    scene.triangles = kept.iter().map(|i| scene.triangles[*i]).collect();
    scene.triangle_materials = kept.iter().map(|i| scene.triangle_materials[*i]).collect();
    if map {
        let pixels = (0..32).map(|i| [0.2 + 0.1 * (i % 5) as f32, 0.5, 1.0 - 0.02 * i as f32]).collect();
        scene.set_environment(Environment { width: 8, height: 4, pixels });
    } else {
        scene.sky = Some(Vec3::new(0.4, 0.6, 0.9));
    }
    scene
}

/// What METHOD.md asks of one comparison; says where it is not kept.
fn kept(what: &str, pairs: &mut [Pair]) -> bool {
    let (median, large) = summary(what, pairs);
    median < MEDIAN && large < SHARE
}

/// Perturbations, weights and crossovers of a scene, structural kernels of it as it stands; says what does not agree.
fn check(name: &str, scene: Scene, kernels: &[&Kernel], structural: &[&Kernel], wanted: usize) {
    let context = context();
    let mut broken = Vec::new();
    let mut expect = |what: String, mut pairs: Vec<Pair>| {
        if !kept(&what, &mut pairs) {
            broken.push(what);
        }
    };
    if !structural.is_empty() {
        let mut bench = Bench::of(&context, &scene);
        bench.publish_guides();
        for kernel in structural {
            let [pairs, _] = proposals(&mut bench, kernel, &[], wanted);
            expect(format!("{name}, {}", kernel.name), pairs);
        }
    }
    let scene = turned(scene);
    let mut bench = Bench::of(&context, &scene);
    for kernel in kernels {
        let [traced, evaluated] = proposals(&mut bench, kernel, &[], wanted);
        expect(format!("{name}, {}", kernel.name), traced);
        // The manifold's ratio has a determinant besides.
        if !kernel.guided && kernel.name != manifold::KERNEL.name {
            expect(format!("{name}, {}, at the device's own y", kernel.name), evaluated);
        }
    }
    let mut bench = Bench::of(&context, &scene);
    let pairs = weights(&mut bench, wanted);
    expect(format!("{name}, log w"), pairs);
    let pairs = exchanges(&mut bench, false, wanted);
    expect(format!("{name}, crossover"), pairs);
    assert!(broken.is_empty(), "{broken:?}");
}

fn check_all(wanted: usize) {
    for (name, kernels) in PERTURBATIONS {
        let structural = if name == SPECULAR_SCENE { [&STRUCTURAL[..], &subpath::KERNELS].concat() } else { vec![] };
        check(name, scene_of(name), kernels, &structural, wanted);
    }
}

/// Textures, layers, skies, and lights of every kind through glass; there every kernel evaluates the same.
fn check_features(wanted: usize) {
    let kernels: [&Kernel; 2] = [&lens::KERNEL, &guided_lens::KERNEL];
    check(TEXTURED, scene_of(TEXTURED), &kernels, &STRUCTURAL[1..], wanted);
    let [lens_subpath, light_subpath, _] = subpath::KERNELS;
    let structural = [STRUCTURAL[1], lens_subpath, light_subpath];
    check(LAYERED, scene_of(LAYERED), &[&lens::KERNEL, &guided_caustic::KERNEL], &structural, wanted);
    check("an even sky", under_a_sky(false), &kernels, &STRUCTURAL[1..], wanted);
    check("a map of a sky", under_a_sky(true), &kernels, &STRUCTURAL[1..], wanted);
    let glazed = [&lens::KERNEL, &guided_caustic::KERNEL, &guided_multi_chain::KERNEL];
    check("glazed room", rooms::glazed_room(), &glazed, &STRUCTURAL[1..], wanted);
}

#[test]
fn log_ratios_of_further_features_are_those_of_double_precision() {
    check_features(250);
}

/// The twin leaves the reverse density out in double precision: the comparison must see it.
#[test]
fn log_ratios_are_those_of_double_precision() {
    check_all(1000);
    let context = context();
    for (scene, kernel) in [(SCENE, &guided_lens::KERNEL), (SPECULAR_SCENE, &guided_caustic::KERNEL)] {
        let mut bench = Bench::new(&context, scene);
        let [mut pairs, _] = proposals(&mut bench, kernel, &["twin_one_sided"], 200);
        let (median, _) = summary("twin_one_sided", &mut pairs);
        assert!(median > MEDIAN, "the twin of {} passes: {median}", kernel.name);
    }
    let mut bench = Bench::new(&context, SCENE);
    let (median, _) = summary("twin, crossover of x alone", &mut exchanges(&mut bench, true, 200));
    assert!(median > MEDIAN, "the twin of the crossover passes: {median}");
}

/// The long form: ten times as many. Then the stability cases: where walls stand straight, half-vectors of narrow lobes
/// come out in another frame, and double precision goes elsewhere; C of the device's own y is right there too.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_log_ratios_are_those_of_double_precision() {
    const PROPOSALS: usize = 10_000;
    check_all(PROPOSALS);
    check_features(PROPOSALS);
    let context = context();
    let mut bench = Bench::new(&context, GLOSSY);
    for kernel in PERTURBATIONS[2].1.iter().filter(|kernel| !kernel.guided) {
        let [mut traced, mut evaluated] = proposals(&mut bench, kernel, &[], PROPOSALS);
        summary(&format!("straight walls, {}", kernel.name), &mut traced);
        assert!(kept(&format!("straight walls, {}, at the device's own y", kernel.name), &mut evaluated));
    }
}
