//! Log ratios of the kernels that change types: there and back they cancel (METHOD.md 4.1, A1).

use emlt::ensemble::cuts::CutEntry;
use emlt::kernels::{Kernel, guided_bidirectional};

use crate::bench::{Bench, HALF, Record, context};
use crate::{SPECULAR_SCENE, STRUCTURAL};

/// Share of proposals whose forward and backward log ratios do not cancel to 1e-3, and how many were looked at, at least
/// `wanted`. The way back looks up the same guide, or wrongly another.
pub fn asymmetric_share(bench: &mut Bench, kernel: &Kernel, another_guide: bool, wanted: usize) -> (f64, usize) {
    let (mut bad, mut all, mut pass) = (0usize, 0usize, 1);
    while all < wanted {
        bench.keep_origins();
        let (uniform, list) = bench.cut_list(HALF, pass);
        bench.passes(kernel, &["probe"], uniform, pass..pass + 1);
        let forward = bench.lens_records(list.entries.len() as u32);
        let back: Vec<_> = list.entries.iter().zip(&forward).filter(|(_, f)| f.possible).collect();
        // From a point of the sky or a Dirac nothing that lies behind mirrors is drawn: such ways there are rejected.
        let (back, rejected): (Vec<_>, Vec<_>) = back.into_iter().partition(|(_, f)| f.log_ratio > -1e29);
        let features = bench.features;
        assert!(rejected.is_empty() || features.sky || features.mixed, "{} ways back cannot be drawn", rejected.len());
        let words = |(i, (entry, _)): (usize, &(&CutEntry, &Record))| {
            let guide = if another_guide { back[(i + 1) % back.len()].0.guide } else { entry.guide };
            CutEntry { cut: entry.cut.reversed(), guide, ..**entry }.words()
        };
        let words: Vec<u32> = back.iter().enumerate().flat_map(words).collect();
        bench.run.set_lists(&words);
        let uniform = bench.cut_uniform(back.len());
        bench.passes(kernel, &["probe", "probe_back"], uniform, pass..pass + 1);
        let backward = bench.lens_records(back.len() as u32);
        for ((_, f), b) in back.iter().zip(&backward) {
            all += 1;
            bad += usize::from(!(b.possible && (f.log_ratio + b.log_ratio).abs() < 1e-3));
        }
        pass += 1;
    }
    (bad as f64 / all as f64, all)
}

/// Says and checks it of kernels.
pub fn check_symmetry(bench: &mut Bench, name: &str, kernels: &[&Kernel], wanted: usize) {
    bench.publish_guides();
    for kernel in kernels {
        let (share, n) = asymmetric_share(bench, kernel, false, wanted);
        println!("{name}, {}: {share:.2e} of {n} proposals asymmetric", kernel.name);
        assert!(share < 1e-3, "{}: {share}", kernel.name);
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
