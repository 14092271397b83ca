//! Log ratios of the kernels that change types: there and back they cancel (METHOD.md 4.1, A1).

use emlt::ensemble::cuts::CutEntry;
use emlt::kernels::{Kernel, guided_bidirectional};

use crate::bench::{Bench, HALF, context};
use crate::{SPECULAR_SCENE, STRUCTURAL, say_symmetric};

/// Proposals whose log ratios there and back do not cancel to 1e-3, how many were looked at, at least `wanted`, and those
/// whose way back cannot be drawn. `list` sets a pass's list, and `back` tells the words of an entry's way back, from the
/// entry and the next one.
pub fn compared<E: Copy>(
    bench: &mut Bench,
    kernel: &Kernel,
    wanted: usize,
    list: impl Fn(&mut Bench, u32) -> Vec<E>,
    back: impl Fn(E, E) -> [u32; 4],
) -> [usize; 3] {
    let ([mut bad, mut all, mut rejected], mut pass) = ([0; 3], 1);
    while all < wanted {
        bench.keep_origins();
        let entries = list(bench, pass);
        let uniform = bench.cut_uniform(entries.len());
        bench.passes(kernel, &["probe"], uniform, pass..pass + 1);
        let forward = bench.lens_records(entries.len() as u32);
        let possible = entries.into_iter().zip(&forward).filter(|(_, f)| f.possible);
        let (there, lost): (Vec<_>, Vec<_>) = possible.partition(|(_, f)| f.log_ratio > -1e29);
        let next = there.iter().cycle().skip(1);
        let words: Vec<u32> = there.iter().zip(next).flat_map(|((entry, _), (next, _))| back(*entry, *next)).collect();
        bench.run.set_lists(&words);
        let uniform = bench.cut_uniform(there.len());
        bench.passes(kernel, &["probe", "probe_back"], uniform, pass..pass + 1);
        for ((_, f), b) in there.iter().zip(&bench.lens_records(there.len() as u32)) {
            bad += usize::from(!(b.possible && (f.log_ratio + b.log_ratio).abs() < 1e-3));
        }
        all += there.len();
        rejected += lost.len();
        pass += 1;
    }
    [bad, all, rejected]
}

/// Share of asymmetric proposals, and how many were looked at. The way back looks up the same guide, or wrongly another.
fn asymmetric_share(bench: &mut Bench, kernel: &Kernel, another_guide: bool, wanted: usize) -> (f64, usize) {
    let back = |entry: CutEntry, next: CutEntry| {
        let guide = if another_guide { next.guide } else { entry.guide };
        CutEntry { cut: entry.cut.reversed(), guide, ..entry }.words()
    };
    let list = |bench: &mut Bench, pass| bench.cut_list(HALF, pass).1.entries;
    let [bad, all, rejected] = compared(bench, kernel, wanted, list, back);
    // From a point of the sky or a Dirac nothing that lies behind mirrors is drawn: such ways there are rejected.
    let features = bench.features;
    assert!(rejected == 0 || features.sky || features.mixed, "{rejected} ways back cannot be drawn");
    (bad as f64 / all as f64, all)
}

/// Says and checks it of kernels.
#[track_caller]
pub fn check_symmetry(bench: &mut Bench, name: &str, kernels: &[&Kernel], wanted: usize) {
    bench.publish_guides();
    for kernel in kernels {
        say_symmetric(name, kernel, asymmetric_share(bench, kernel, false, wanted));
    }
}

/// METHOD.md 4.1 A1 for the bidirectional mutations: y, taken whatever its ratio, is proposed the way back by the
/// reversed cut with the same guide.
#[test]
fn bidirectional_log_ratios_are_antisymmetric() {
    let context = context();
    let mut bench = Bench::new(&context, SPECULAR_SCENE);
    check_symmetry(&mut bench, SPECULAR_SCENE, &STRUCTURAL, 1_000_000);
    let (share, n) = asymmetric_share(&mut bench, &guided_bidirectional::KERNEL, true, 50_000);
    println!("twin, another guide on the way back: {share:.2e} of {n} proposals asymmetric");
    assert!(share > 0.05, "the twin with another guide on the way back passes: {share}");
}
