//! The crossover, which moves paths of both halves: its log ratios cancel with those of the way back, it keeps the law
//! of pairs, and what it stores is what the target says (METHOD.md 3.6b, 4.1, 4.4).

use std::collections::HashMap;

use emlt::ensemble::crossings::{Pair, PairList, Partners, crossings, log_cut};
use emlt::ensemble::pool::{Pool, TypeKey};
use emlt::gpu::layout::{PassUniform, ROW_KEY, ROW_PIXEL, ROW_VERTICES};
use emlt::gpu::run::Dispatch;
use emlt::gpu::shader::Variant;
use emlt::reference::rng;

use crate::bench::{Bench, COLUMNS, FILM, HALF, MAX_EDGES, SEED, context};
use crate::{GLOSSY, SCENE, SPECULAR_SCENE, WEIGH, Z_LIMIT};

/// Pairs of the first `count` paths with the next `count`.
pub fn pair_list(bench: &mut Bench, count: u32, pass_index: u32, shift: u32) -> PairList {
    let [x, v] = [0, count].map(|first| Pool::build(&bench.keys(first, count), first));
    let random = |path, dimension| rng::random_words(SEED, path, pass_index, dimension);
    PairList::draw([Partners { halves: [&x, &v], first: [0, count], shift }], random, 1..=MAX_EDGES)
}

/// Evaluates `pairs` and decides on them with further flags.
pub fn cross(bench: &mut Bench, pairs: &[Pair], flags: &[&'static str], pass_index: u32) {
    let words: Vec<u32> = pairs.iter().flat_map(|pair| pair.words()).collect();
    bench.run.set_lists(&words);
    let count = pairs.len() as u32;
    let dispatch = |pass, flags, entries| Dispatch {
        variant: Variant { pass, features: bench.features, max_edges: MAX_EDGES, flags },
        uniform: PassUniform {
            seed: SEED,
            stride: COLUMNS,
            group_paths: COLUMNS,
            pass_index,
            entries,
            ..Default::default()
        },
    };
    let dispatches = [dispatch("crossover", vec![], 2 * count), dispatch("exchange", flags.to_vec(), count)];
    bench.run.submit(&dispatches).unwrap();
}

/// One crossover of every path that can have one; returns those.
pub fn cross_once(bench: &mut Bench, pass_index: u32) -> Vec<u32> {
    let list = pair_list(bench, HALF, pass_index, 7919 * pass_index);
    cross(bench, &list.pairs, &[], pass_index);
    list.pairs.iter().flat_map(|pair| pair.paths).collect()
}

/// Ways to get P(cut) wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cut {
    Correct,
    /// The number of cuts of (x, v) alone.
    OneSided,
    LeftOut,
}

/// `pair` with its log P(cut) as `cut` has it; `keys` are the types of its paths.
fn with_cut(pair: Pair, cut: Cut, keys: [TypeKey; 2]) -> Pair {
    let log_cut = match cut {
        Cut::Correct => log_cut(keys, pair.crossing, 1..=MAX_EDGES) as f32,
        Cut::OneSided => (crossings(keys, 1..=MAX_EDGES).count() as f32).ln(),
        Cut::LeftOut => 0.0,
    };
    Pair { log_cut, ..pair }
}

/// Passes at most in which paths are exchanged: where hardly any two have parts to exchange, so many have to do.
const MOST_PASSES: u32 = 256;

/// Share of the exchanges, made wherever they are possible, whose log ratios there and back do not cancel to 1e-3, and
/// how many there were. What is exchanged twice has to be as it was, bit for bit.
fn asymmetric_share(bench: &mut Bench, cut: Cut, wanted: usize) -> (f64, usize) {
    let (mut bad, mut all) = (0usize, 0usize);
    for pass in 1..=MOST_PASSES {
        let before = (pass == 1).then(|| all_rows(bench));
        // Partners differ from pass to pass.
        let list = pair_list(bench, HALF, pass, 7919 * pass);
        let keys = bench.keys(0, 2 * HALF);
        let types = |keys: &[TypeKey], pair: &Pair| pair.paths.map(|path| keys[path as usize]);
        let pairs: Vec<Pair> = list.pairs.iter().map(|pair| with_cut(*pair, cut, types(&keys, pair))).collect();
        cross(bench, &pairs, &["probe"], pass);
        let forward = bench.lens_records(pairs.len() as u32);
        let keys_after = bench.keys(0, 2 * HALF);
        let there: Vec<_> = pairs.iter().zip(&forward).filter(|(_, record)| record.possible).collect();
        let back = |(pair, _): &(&Pair, _)| {
            assert_eq!(types(&keys_after, pair), pair.crossing.exchanged(types(&keys, pair)));
            let back = Pair { crossing: pair.crossing.reversed(), ..**pair };
            with_cut(back, cut, types(&keys_after, pair))
        };
        let back: Vec<Pair> = there.iter().map(back).collect();
        cross(bench, &back, &["probe"], pass);
        let backward = bench.lens_records(back.len() as u32);
        for ((_, f), b) in there.iter().zip(&backward) {
            all += 1;
            bad += usize::from(!(b.possible && (f.log_ratio + b.log_ratio).abs() < 1e-3));
        }
        if let Some(before) = before {
            let after = all_rows(bench);
            let changed = (0..2 * HALF as usize).filter(|path| before[*path] != after[*path]).count();
            // An edge that was traced may be blocked as a connection, by a hair; such a pair stays.
            let stay = backward.iter().filter(|b| !b.possible).count();
            assert!(changed <= 2 * stay && stay * 1000 <= there.len(), "{changed} paths changed, {stay} pairs stay");
        }
        if all >= wanted {
            break;
        }
    }
    (bad as f64 / all as f64, all)
}

/// Type, pixel and vertices of every path, as words.
fn all_rows(bench: &mut Bench) -> Vec<Vec<u32>> {
    let keys = bench.keys(0, 2 * HALF);
    let mut words: Vec<Vec<u32>> = keys.iter().map(|key| key.words().to_vec()).collect();
    for (path, row) in bench.rows(ROW_PIXEL, 0, 2 * HALF).iter().enumerate() {
        words[path].extend(&row[..2]);
    }
    for vertex in 0..MAX_EDGES as usize {
        for row in [2 * vertex, 2 * vertex + 1] {
            for (path, row) in bench.rows(ROW_VERTICES + row, 0, 2 * HALF).iter().enumerate() {
                if vertex < keys[path].edges() as usize {
                    words[path].extend(&row[..3]);
                }
            }
        }
    }
    words
}

/// All of this for a scene, from as many exchanges and rounds of candidates.
#[track_caller]
pub fn check_all(bench: &mut Bench, name: &str, exchanges: usize, rounds: u32) {
    check_ratios(bench, name, exchanges);
    check_factors(bench, name);
    if rounds > 0 {
        // Where hardly any two paths have parts to exchange, no bin has the terms that it takes.
        let z = check_stationarity(bench, name, &[], Cut::Correct, rounds);
        assert!(z < Z_LIMIT, "{name}: |z| = {z}");
    }
}

/// METHOD.md 4.1 A1.
#[track_caller]
fn check_ratios(bench: &mut Bench, scene: &str, exchanges: usize) {
    let (share, n) = asymmetric_share(bench, Cut::Correct, exchanges);
    println!("{scene}, crossover: {share:.2e} of {n} exchanges asymmetric");
    assert!(n >= 1000 && share < 1e-3, "{share} of {n}");
}

/// METHOD.md 4.1 A2: after crossovers, what is cached of every path of both halves agrees with the master f.
#[track_caller]
fn check_factors(bench: &mut Bench, scene: &str) {
    let types = bench.keys(0, 2 * HALF);
    let mut moved = 0;
    for pass in 1..=MOST_PASSES {
        let list = pair_list(bench, HALF, pass, 7919 * pass);
        cross(bench, &list.pairs, &[], pass);
        moved = types.iter().zip(bench.keys(0, 2 * HALF)).filter(|(before, after)| *before != after).count();
        if pass >= 4 && moved > 1000 {
            break;
        }
    }
    let word = |rows: Vec<[u32; 4]>| -> Vec<f32> { rows.iter().map(|row| f32::from_bits(row[2])).collect() };
    let made = word(bench.rows(ROW_KEY, 0, 2 * HALF));
    let light = word(bench.rows(ROW_PIXEL, 0, 2 * HALF));
    let entries: Vec<u32> = (0..2 * HALF).flat_map(|path| [path, 0]).collect();
    bench.run.set_lists(&entries);
    let all = PassUniform { seed: SEED, stride: COLUMNS, entries: 2 * HALF, ..Default::default() };
    bench.passes(&WEIGH, &[], all, 0..1);
    let weighed = word(bench.rows(ROW_PIXEL, 0, 2 * HALF));
    let mut bad = [0usize; 4];
    for (i, r) in bench.records(2 * HALF).iter().enumerate() {
        // Counted this way round, what is no number counts as bad.
        let differs = |a: f32, b: f32| 1 - usize::from((a - b).abs() < 1e-3);
        let pairs = [(r[0], made[i]), (r[1], r[3]), (r[2], 0.0), (light[i], weighed[i])];
        bad.iter_mut().zip(pairs).for_each(|(bad, (a, b))| *bad += differs(a, b));
    }
    println!("{scene}: {moved} of {} types changed; {bad:?} differ in w, C, colour, C of the light's side", 2 * HALF);
    assert!(bad.iter().all(|b| (*b as f64) < 1e-3 * f64::from(2 * HALF)), "{bad:?}");
    // Most exchanges are among paths of one type.
    assert!(moved > 100, "{moved}");
}

#[test]
fn crossovers_cancel_and_store_what_they_say() {
    let context = context();
    for scene in [SPECULAR_SCENE, GLOSSY] {
        let mut bench = Bench::new(&context, scene);
        check_all(&mut bench, scene, if scene == GLOSSY { 100_000 } else { 20_000 }, 0);
        if scene == GLOSSY {
            let (share, n) = asymmetric_share(&mut bench, Cut::OneSided, 10_000);
            println!("twin, cuts counted one way alone: {share:.2e} of {n} asymmetric");
            assert!(share > 0.05, "the twin that counts one way passes: {share}");
        }
    }
}

/// What a paired test over both paths found. Each is drawn from the bidirectional density with its weight, so
/// E[W_x W_v (h(x_t, v_t) - h(x_0, v_0))] = 0 for every h. Pixels stay: h is the type, the length by tile, and where the
/// second vertex from the camera lies, by length.
struct Verdict {
    pairs: usize,
    worst: f64,
    bins: usize,
    chi2: f64,
}

fn bins_of(bench: &mut Bench, count: u32) -> Vec<[u64; 4]> {
    let keys = bench.keys(0, count);
    let mut bins: Vec<[u64; 4]> = Vec::new();
    for (row, key) in bench.rows(ROW_PIXEL, 0, count).iter().zip(&keys) {
        let [x, y] = [0, 1].map(|i| (f32::from_bits(row[i]) as u64).min(u64::from(FILM[i]) - 1));
        let length = u64::from(key.edges());
        let tile = (y / 16) << 16 | (x / 16) << 8;
        bins.push([key.bits() as u64, 1 << 60 | tile | length, 2 << 60 | length, 3 << 60 | length]);
    }
    for vertex in 0..MAX_EDGES {
        for (path, row) in bench.rows(ROW_VERTICES + 2 * vertex as usize + 1, 0, count).iter().enumerate() {
            if vertex + 2 == keys[path].edges() {
                let cell = [0, 1, 2].map(|i| ((f32::from_bits(row[i]) + 1.0) * 2.0).clamp(0.0, 3.0) as u64);
                bins[path][2] |= 1 << 40 | cell[0] << 8 | cell[1] << 16 | cell[2] << 24;
            }
        }
    }
    bins
}

fn worst_z(bench: &mut Bench, flags: &[&'static str], cut: Cut, rounds: u32) -> Verdict {
    const STEPS: u32 = 16;
    // Sum, sum of squares, pairs.
    let mut sums: HashMap<u64, (f64, f64, u32)> = HashMap::new();
    let mut verdict = Verdict { pairs: 0, worst: 0.0, bins: 0, chi2: 0.0 };
    for seed in 1001..1001 + rounds {
        let (candidates, strategies) = bench.candidates(1 << 17, seed);
        let mut lit: Vec<u32> =
            (0..candidates.len() as u32).filter(|i| candidates[*i as usize].weight() > 0.0).collect();
        // Candidates come by strategy; the two of a pair must not tell each other's.
        lit.sort_by_key(|i| rng::random_words(SEED, *i, seed, 0));
        for (chunk_number, chunk) in lit.chunks(2 * HALF as usize).enumerate() {
            let half = chunk.len() as u32 / 2;
            let chunk = &chunk[..2 * half as usize];
            bench.fill(seed, &strategies, chunk);
            let before = bins_of(bench, 2 * half);
            // Partners stay: the weight of a pair is that of its paths alone.
            let first = seed * 1024 + chunk_number as u32 * 64;
            for pass in first..first + STEPS {
                let mut list = pair_list(bench, half, pass, 0);
                if cut == Cut::LeftOut {
                    list.pairs.iter_mut().for_each(|pair| pair.log_cut = 0.0);
                }
                cross(bench, &list.pairs, flags, pass);
            }
            let after = bins_of(bench, 2 * half);
            verdict.pairs += half as usize;
            for i in 0..half as usize {
                let [x, v] = [i, i + half as usize];
                let weight = |path: usize| candidates[chunk[path] as usize].weight();
                let mut net: HashMap<u64, f64> = HashMap::new();
                for path in [x, v] {
                    for (from, to) in before[path].iter().zip(&after[path]) {
                        *net.entry(*from).or_default() -= 1.0;
                        *net.entry(*to).or_default() += 1.0;
                    }
                }
                let w = weight(x) * weight(v);
                for (bin, change) in net.into_iter().filter(|(_, change)| *change != 0.0) {
                    let sum = sums.entry(bin).or_default();
                    *sum = (sum.0 + change * w, sum.1 + (change * w).powi(2), sum.2 + 1);
                }
            }
        }
    }
    // The normal law needs a few hundred terms in a bin.
    for (sum, squares, _) in sums.values().filter(|(_, _, touched)| *touched >= 300) {
        let z = sum / squares.sqrt();
        verdict.worst = verdict.worst.max(z.abs());
        verdict.chi2 += z * z;
        verdict.bins += 1;
    }
    verdict.chi2 /= verdict.bins.max(1) as f64;
    verdict
}

/// METHOD.md 4.4 S1 over pairs, and twins that it must catch.
#[test]
fn crossovers_leave_the_target_of_pairs_alone() {
    let context = context();
    let mut bench = Bench::new(&context, SCENE);
    for (flags, cut, rounds, exact) in
        [(&[][..], Cut::Correct, 5, true), (&["twin_one_sided"], Cut::Correct, 5, false), (&[], Cut::LeftOut, 3, false)]
    {
        let z = check_stationarity(&mut bench, SCENE, flags, cut, rounds);
        assert_eq!(z < Z_LIMIT, exact, "{flags:?} {cut:?}: |z| = {z}");
    }
}

fn check_stationarity(bench: &mut Bench, scene: &str, flags: &[&'static str], cut: Cut, rounds: u32) -> f64 {
    let z = worst_z(bench, flags, cut, rounds);
    println!(
        "{scene}, crossover {flags:?}, P(cut) {cut:?}: {} pairs, worst |z| {:.2} in {} bins, chi2 / dof {:.2}",
        z.pairs, z.worst, z.bins, z.chi2
    );
    z.worst
}

/// The long form: a million exchanges and millions of pairs a scene.
#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_crossovers_cancel_and_leave_the_target_of_pairs_alone() {
    let context = context();
    for scene in [SCENE, SPECULAR_SCENE, GLOSSY] {
        check_all(&mut Bench::new(&context, scene), scene, 1_000_000, 64);
    }
}
