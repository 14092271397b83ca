//! Everything that is proven of kernels, on one scene, by every kernel that can be used there.

use emlt::kernels::{Kernel, bidirectional, guided_lens};
use emlt::scene::{Features, Scene};

use crate::bench::{Bench, context};
use crate::{
    FEWER, RARE, STRUCTURAL, check_factors, check_stationarity_on, check_still, check_symmetry, crossover,
    independence, structural, subpath,
};

/// Where no material is specular.
pub const WITHOUT_MIRRORS: [&str; 10] = [
    "independence",
    "bidirectional",
    "guided-bidirectional",
    "lens",
    "guided-lens",
    "walk",
    "kept-lens",
    "difference",
    "jump",
    "crossover",
];

/// Where mirrors and glass light what is seen and are seen: all there are, in the order of `emlt::kernels::ALL`.
pub const ALL: [&str; 18] = [
    "independence",
    "bidirectional",
    "guided-bidirectional",
    "lens",
    "multi-chain",
    "caustic",
    "guided-lens",
    "walk",
    "kept-lens",
    "difference",
    "jump",
    "guided-multi-chain",
    "guided-caustic",
    "crossover",
    "lens-subpath",
    "light-subpath",
    "guided-light-subpath",
    "manifold",
];

/// How closely is looked.
pub struct Effort {
    /// Candidates out of which kernels get paths that they apply to: of these there are to be so many that one that passes
    /// through a corner, where little is left of f32, does not count for much.
    pub starts: u32,
    /// Proposals of every kernel whose log ratios are compared with those of the way back, and exchanges likewise.
    pub proposals: usize,
    pub exchanges: usize,
}

pub const SHORT: Effort = Effort { starts: 1 << 18, proposals: 100_000, exchanges: 20_000 };
pub const LONG: Effort = Effort { starts: 1 << 20, proposals: 1_000_000, exchanges: 1_000_000 };

/// Kept factors, and log ratios of the kernels that keep the type, which it returns. `expected` are all that move paths
/// there, so that none is left out unnoticed.
#[track_caller]
pub fn check_perturbations(bench: &mut Bench, name: &str, expected: &[&str], effort: &Effort) -> Vec<&'static Kernel> {
    bench.make_starts(effort.starts);
    let usable = bench.usable();
    assert_eq!(usable.iter().map(|kernel| kernel.name).collect::<Vec<_>>(), expected, "{name}");
    check_factors(bench);
    let perturbations: Vec<_> = usable.into_iter().filter(|kernel| kernel.family.keeps_types()).collect();
    check_symmetry(bench, name, &perturbations, effort.proposals);
    perturbations
}

/// Log ratios of the other kernels but crossovers.
#[track_caller]
pub fn check_others(bench: &mut Bench, name: &str, effort: &Effort) {
    structural::check_symmetry(bench, name, &STRUCTURAL, effort.proposals);
    if bench.features.mirror {
        subpath::check_symmetry(bench, name, effort.proposals);
    }
    independence::check_ratios(bench, effort.proposals);
}

/// The long form, with twins.
pub fn prove(name: &str, scene: &Scene, expected: &[&str]) {
    let context = context();
    let mut bench = Bench::of(&context, scene);
    let perturbations = check_perturbations(&mut Bench::of(&context, scene), name, expected, &LONG);
    for kernel in &perturbations {
        bench.refresh();
        check_still(&mut bench, name, kernel);
    }
    check_others(&mut bench, name, &LONG);
    // Few paths are lit through mirrors, or seen in them by what is.
    let (plain, through_mirrors): (Vec<&Kernel>, Vec<&Kernel>) =
        perturbations.into_iter().partition(|kernel| (kernel.useless)(Features::default()).is_none());
    let twins = [(&guided_lens::KERNEL, "twin_one_sided", 90_000)];
    check_stationarity_on(&mut bench, name, &plain, &twins, &FEWER);
    check_stationarity_on(&mut bench, name, &through_mirrors, &[], &RARE);
    let twins = [(&bidirectional::KERNEL, "twin_places", 1_000_000)];
    check_stationarity_on(&mut bench, name, &STRUCTURAL, &twins, &FEWER);
    if bench.features.mirror {
        check_stationarity_on(&mut bench, name, &subpath::KERNELS, &[], &FEWER);
    }
    // What crossovers find stored is to be as it was made.
    crossover::check_all(&mut Bench::of(&context, scene), name, LONG.exchanges, 6);
}
