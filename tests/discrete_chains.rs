//! Exact proofs of the selection logic in finite worlds (METHOD.md 4.2): whole transition matrices built from the
//! production pool and the reference mathematics, so that invariance is a statement of linear algebra. Every
//! broken twin must be seen to fail by a stated margin: histograms of long runs are blind to most of them (4.6).

mod discrete {
    mod crossover;
    pub mod kernels;
    pub mod world;
}

use discrete::kernels::{Moves, Twin, independence, lens, mutation};
use discrete::world::{Guides, World, guide_sets};
use emlt::ensemble::pool::{Pool, TypeKey};

/// What rounding may do to a right kernel.
const EXACT: f64 = 1e-12;
/// M, below, at and above the size of a half.
const GUIDE_COUNTS: [u32; 3] = [1, 2, 4];

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Calls `visit` for every half, M and id; ids near the wrap of u32 included.
fn for_every_half(world: &World, mut visit: impl FnMut(&Guides, u32)) {
    for set in guide_sets(world) {
        for wanted in GUIDE_COUNTS {
            let guides = Guides::new(world, &set, wanted);
            for id in (0..6).chain(u32::MAX - 2..=u32::MAX) {
                visit(&guides, id);
            }
        }
    }
}

/// Worst max|pi K - pi| and worst antisymmetry defect over every half and id.
fn frozen_defect(world: &World, twin: Twin) -> (f64, f64) {
    let target = world.target();
    let (mut worst, mut antisymmetry) = (0.0f64, 0.0f64);
    for_every_half(world, |guides, id| {
        let moves = mutation(guides, id, twin);
        worst = worst.max(largest_difference(&moves.apply(&target), &target));
        antisymmetry = antisymmetry.max(moves.antisymmetry);
    });
    (worst, antisymmetry)
}

#[test]
fn every_frozen_half_and_id_keeps_the_target() {
    let world = World::large();
    // The cases that matter do occur: no node, back to the length, a node of one path, more paths than M.
    let mut cases = [0; 4];
    for_every_half(&world, |guides, _| {
        for &key in &world.types {
            let (own, found) = (guides.pool.type_node(key), guides.pool.node(key));
            cases[0] += usize::from(found.is_none());
            cases[1] += usize::from(own.is_none() && found.is_some());
            cases[2] += usize::from(own.is_some_and(|node| node.count == 1));
            cases[3] += usize::from(found.is_some_and(|node| node.count > guides.wanted));
        }
    });
    println!("no node, backtracked, one path, more than M: {cases:?}");
    assert!(cases.iter().all(|&count| count > 100));

    let (defect, antisymmetry) = frozen_defect(&world, Twin::Correct);
    println!("correct: {defect:.1e}, antisymmetry {antisymmetry:.1e}");
    assert!(defect < EXACT && antisymmetry < 1e-10);
}

#[test]
fn broken_ratios_and_borders_do_not_keep_it() {
    let world = World::large();
    println!("{:<28} {:>10} {:>14}", "twin", "defect", "antisymmetry");
    // Twin, bound that its defect must exceed, whether the antisymmetry test sees it too.
    let twins = [
        (Twin::ReverseLeftOut, 1e-3, true),
        (Twin::ShapeOfX, 1e-3, false),
        (Twin::AlphaOfX, 1e-4, true),
        (Twin::AreaDropped, 1e-4, false),
        (Twin::Redraw, 1e-4, false),
        (Twin::Clamp, 1e-4, false),
        (Twin::ReverseId, 1e-4, true),
        (Twin::ReverseBacktracksEarlier, 1e-4, true),
        (Twin::SignFixed, 1e-4, true),
    ];
    let found = twins.map(|(twin, ..)| {
        let (defect, antisymmetry) = frozen_defect(&world, twin);
        println!("{:<28} {defect:>10.1e} {antisymmetry:>14.1e}", format!("{twin:?}"));
        (defect, antisymmetry)
    });
    for ((twin, bound, seen), (defect, antisymmetry)) in twins.into_iter().zip(found) {
        assert!(defect > bound, "{twin:?} passes with a defect of {defect:e}");
        assert_eq!(antisymmetry > 1e-3, seen, "{twin:?}: antisymmetry {antisymmetry:e}");
    }
}

/// When the id of a chain moves on.
#[derive(Debug, Clone, Copy)]
enum Increment {
    /// Once a mutation, whatever happens: our rule (METHOD.md 3.2).
    EachMutation,
    OnAcceptance,
    /// Once if the first ray already missed, else twice: "every look-up" read literally.
    EachLookUp,
}

/// Ids modulo this: a multiple of every node size, so that the ring closes.
const IDS: usize = 60;

/// The law of (x, id) after one mutation; `law[id][x]`.
fn joint_step(moves: &[Moves], law: &[Vec<f64>], increment: Increment) -> Vec<Vec<f64>> {
    let mut after = vec![vec![0.0; law[0].len()]; IDS];
    for id in 0..IDS {
        let (on_failure, on_rejection, on_acceptance) = match increment {
            Increment::EachMutation => (1, 1, 1),
            Increment::OnAcceptance => (0, 0, 1),
            Increment::EachLookUp => (1, 2, 2),
        };
        for (x, &mass) in law[id].iter().enumerate() {
            let kernel = &moves[id];
            let rejected = 1.0 - kernel.acceptance(x) - kernel.failed[x];
            after[(id + on_failure) % IDS][x] += mass * kernel.failed[x];
            after[(id + on_rejection) % IDS][x] += mass * rejected;
            let to = &mut after[(id + on_acceptance) % IDS];
            to.iter_mut().zip(&kernel.accepted[x]).for_each(|(to, p)| *to += mass * p);
        }
    }
    after
}

/// The id as part of the chain: worst defect of pi times uniform (scaled to one id), and worst total variation
/// between pi and the law of x after many mutations of the same frozen half.
fn id_process(world: &World, increment: Increment, mutations: usize) -> (f64, f64) {
    let target = world.target();
    let start = vec![target.iter().map(|p| p / IDS as f64).collect::<Vec<f64>>(); IDS];
    let (mut worst, mut variation) = (0.0f64, 0.0f64);
    // Random halves of 3, 4 and 6 guides.
    let sets = guide_sets(world);
    for (set, wanted) in [(6, 1), (7, 1), (18, 2), (19, 1), (42, 2), (43, 4)] {
        let guides = Guides::new(world, &sets[set], wanted);
        let moves: Vec<Moves> = (0..IDS as u32).map(|id| mutation(&guides, id, Twin::Correct)).collect();
        let mut law = joint_step(&moves, &start, increment);
        let defect = |id: usize| largest_difference(&law[id], &start[id]) * IDS as f64;
        worst = (0..IDS).map(defect).fold(worst, f64::max);
        for _ in 0..mutations {
            law = joint_step(&moves, &law, increment);
        }
        let of_x = |x: usize| law.iter().map(|of_id| of_id[x]).sum::<f64>();
        let apart: f64 = target.iter().enumerate().map(|(x, p)| (of_x(x) - p).abs()).sum();
        variation = variation.max(0.5 * apart);
    }
    (worst, variation)
}

#[test]
fn one_increment_a_mutation_keeps_the_joint_law_of_path_and_id() {
    let world = World::large();
    let (defect, variation) = id_process(&world, Increment::EachMutation, 400);
    println!("EachMutation: {defect:.1e}, total variation in the end {variation:.1e}");
    assert!(defect < EXACT && variation < EXACT);
    for (increment, bound, apart) in [(Increment::OnAcceptance, 1e-3, 1e-3), (Increment::EachLookUp, 1e-3, 1e-5)] {
        let (defect, variation) = id_process(&world, increment, 400);
        println!("{increment:?}: {defect:.1e}, total variation in the end {variation:.1e}");
        assert!(defect > bound && variation > apart, "{increment:?} passes");
    }
}

/// Kernels of the small world for every pair of guides: `pairs[y1 * 8 + y2][id]`.
fn pair_kernels(world: &World, wanted: u32) -> Vec<[Moves; 2]> {
    let n = world.states.len();
    let guided = |pair: usize| {
        let guides = Guides::new(world, &[pair / n, pair % n], wanted);
        [0, 1].map(|id| mutation(&guides, id, Twin::Correct))
    };
    (0..n * n).map(guided).collect()
}

/// pi x pi x ...
fn product(laws: &[&[f64]]) -> Vec<f64> {
    laws.iter().fold(vec![1.0], |joint, law| joint.iter().flat_map(|p| law.iter().map(move |q| p * q)).collect())
}

/// `moving` pairs step guided by `frozen` ones, the two chains with different ids. `law[moving][frozen]` flat.
fn update_half(kernels: &[[Moves; 2]], law: &[f64], n: usize) -> Vec<f64> {
    let mut after = vec![0.0; law.len()];
    for (frozen, [first, second]) in kernels.iter().enumerate() {
        let at = |moving: usize| moving * n * n + frozen;
        for moving in 0..n * n {
            let step = product(&[&first.row(moving / n), &second.row(moving % n)]);
            for (to, p) in step.iter().enumerate() {
                after[at(to)] += law[at(moving)] * p;
            }
        }
    }
    after
}

fn swap_halves(law: &[f64], pairs: usize) -> Vec<f64> {
    (0..law.len()).map(|at| law[at % pairs * pairs + at / pairs]).collect()
}

#[test]
fn alternating_halves_keep_the_product_of_targets() {
    let world = World::small();
    let (n, target) = (world.states.len(), world.target());
    let pairs = n * n;
    let joint = product(&[&target[..]; 4]);
    for wanted in [1, 2] {
        let kernels = pair_kernels(&world, wanted);

        let x_moved = update_half(&kernels, &joint, n);
        let both_moved = update_half(&kernels, &swap_halves(&x_moved, pairs), n);
        let defect = largest_relative_difference(&swap_halves(&both_moved, pairs), &joint);
        println!("alternating halves, M = {wanted}: relative {defect:.1e}");
        assert!(defect < EXACT);

        // Both halves from the old states: x guided by the old y, and y by the old x.
        let mut at_once = vec![0.0; joint.len()];
        for (from, mass) in joint.iter().enumerate() {
            let (x, y) = (from / pairs, from % pairs);
            let [x1, x2] = &kernels[y];
            let [y1, y2] = &kernels[x];
            let x_step = product(&[&x1.row(x / n), &x2.row(x % n)]);
            let y_step = product(&[&y1.row(y / n), &y2.row(y % n)]);
            for (to, p) in x_step.iter().enumerate() {
                let row = &mut at_once[to * pairs..][..pairs];
                row.iter_mut().zip(&y_step).for_each(|(to, q)| *to += mass * p * q);
            }
        }
        let relative = largest_relative_difference(&at_once, &joint);
        println!("both halves at once, M = {wanted}: relative {relative:.1e}");
        assert!(relative > 0.01, "both halves at once pass with {relative:e}");
    }
}

/// Largest change relative to what should be there: joint laws of many states have small probabilities.
fn largest_relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let relative = a.iter().zip(b).filter(|&(_, b)| *b > 0.0).map(|(a, b)| (a / b - 1.0).abs());
    relative.fold(0.0, f64::max)
}

#[test]
fn guides_from_the_own_half_do_not_keep_it() {
    // Three chains, each guided by all three as they stand, all moved at once.
    let world = World::small();
    let (n, target) = (world.states.len(), world.target());
    let joint = product(&[&target[..]; 3]);
    let mut after = vec![0.0; joint.len()];
    for (from, mass) in joint.iter().enumerate() {
        let states = [from / (n * n), from / n % n, from % n];
        let guides = Guides::new(&world, &states, 2);
        let step = |chain: usize| mutation(&guides, chain as u32, Twin::Correct).row(states[chain]);
        let step = product(&[&step(0), &step(1), &step(2)]);
        after.iter_mut().zip(&step).for_each(|(to, p)| *to += mass * p);
    }
    let marginal = |x: usize| after[x * n * n..][..n * n].iter().sum::<f64>();
    let first: Vec<f64> = (0..n).map(marginal).collect();
    let (relative, of_one) = (largest_relative_difference(&after, &joint), largest_difference(&first, &target));
    println!("guides from the own half: relative {relative:.1e}, law of one chain {of_one:.1e}");
    assert!(relative > 0.01 && of_one > 1e-3);
}

/// The image of one sweep at stationarity: one structural mutation of every chain, then passes of a kernel that
/// applies to some types only. Idle chains get weight `idle_credit` a pass (METHOD.md C6a).
fn sweep_image(world: &World, guides: &Guides, idle_credit: f64) -> (Vec<f64>, f64) {
    const PASSES: u32 = 4;
    let applicable = |key: TypeKey| key.edges() == 3 && key.is_diffuse(1);
    let target = world.target();
    let mut law = independence(world).apply(&target);
    let mut image = law.clone();
    for pass in 0..PASSES {
        let moves = lens(guides, pass, Twin::Correct);
        let mut after = vec![0.0; law.len()];
        for (x, &mass) in law.iter().enumerate() {
            // The lists the renderer would dispatch, for a half of this one path.
            let half = Pool::build(&[world.states[x].key], 0);
            let list = half.dispatch_list(applicable, &guides.pool);
            if list.idle.is_empty() {
                for (y, p) in moves.row(x).into_iter().enumerate() {
                    after[y] += mass * p;
                    image[y] += mass * p;
                }
            } else {
                after[x] += mass;
                image[x] += mass * idle_credit;
            }
        }
        law = after;
    }
    let splatted: f64 = image.iter().sum();
    image.iter_mut().for_each(|value| *value /= splatted);
    (image, largest_difference(&law, &target))
}

#[test]
fn idle_chains_must_be_credited() {
    let world = World::large();
    let target = world.target();
    let guides = Guides::new(&world, &guide_sets(&world)[30], 2);
    for (credit, biased) in [(1.0, false), (0.0, true)] {
        let (image, chain_defect) = sweep_image(&world, &guides, credit);
        let of_type =
            |law: &[f64]| -> Vec<f64> { law.chunks(world.pixels()).map(|states| states.iter().sum()).collect() };
        let bias = largest_difference(&image, &target);
        println!("idle credit {credit}: image bias {bias:.1e}, chain law off by {chain_defect:.1e}");
        println!("  light by type {:.3?}, true {:.3?}", of_type(&image), of_type(&target));
        // The chains are right either way: only the image tells.
        assert!(chain_defect < EXACT);
        assert!(if biased { bias > 0.01 } else { bias < EXACT }, "bias {bias:e}");
    }
}
