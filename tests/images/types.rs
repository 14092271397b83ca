//! How light is shared among types of paths: chains against the bidirectional estimate of their own start, and the
//! sentences on types that have not converged.

use emlt::ensemble::bootstrap::CANDIDATES;
use emlt::kernels::{Kernel, guided_bidirectional, guided_lens, independence, lens};
use emlt::methods::{Method, Settings};

use super::renders::{render, scene, settings};

/// Largest deviation that a correct mix shows in one of some twenty types with a probability below 1e-3.
const Z_LIMIT: f64 = 4.3;

/// Largest |z| among types of 0.2 % and more, and their number, from the means over `seeds` renders of cornell.
fn worst_type(method: Method, kernels: Option<Vec<(&'static Kernel, f64)>>, seeds: u32) -> (f64, usize, String) {
    let scene = scene("scenes/cornell.glb");
    let base = Settings { ensemble: 16384, candidates: CANDIDATES, kernels, ..settings(method, [64, 48], 500) };
    let mut sums: std::collections::BTreeMap<String, [f64; 3]> = Default::default();
    for seed in 1..=seeds {
        for t in render(&scene, &Settings { seed, ..base.clone() }).statistics.types {
            let sum = sums.entry(t.name).or_default();
            sum[0] += t.start / f64::from(seeds);
            sum[1] += t.chains / f64::from(seeds);
            sum[2] += (t.start_error.powi(2) + t.chains_error.powi(2)) / f64::from(seeds).powi(2);
        }
    }
    let large = sums.into_iter().filter(|(_, [start, chains, _])| start.max(*chains) >= 0.002);
    let z: Vec<(f64, String)> = large.map(|(name, [a, b, v])| (((b - a) / v.sqrt()).abs(), name)).collect();
    let count = z.len();
    let (worst, name) = z.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    println!("{}: worst |z| {worst:.2} of {count} types ({name})", method.name());
    (worst, count, name)
}

#[test]
fn types_by_mlt() {
    let (worst, count, name) = worst_type(Method::Mlt, None, 3);
    assert!(worst < Z_LIMIT && count >= 12, "{name}: |z| = {worst} of {count}");
}

#[test]
fn types_by_emlt() {
    let (worst, count, name) = worst_type(Method::Emlt, None, 3);
    assert!(worst < Z_LIMIT && count >= 12, "{name}: |z| = {worst} of {count}");
}

/// The same comparison catches a mutation that forgets how many cuts lead back.
#[test]
fn types_by_a_broken_mix_are_caught() {
    static BROKEN: Kernel = Kernel { flags: &["segment", "guided", "twin_places"], ..guided_bidirectional::KERNEL };
    let mix: Vec<(&'static Kernel, f64)> =
        vec![(&independence::KERNEL, 0.05), (&BROKEN, 0.3), (&lens::KERNEL, 1.0), (&guided_lens::KERNEL, 1.0)];
    let (worst, _, name) = worst_type(Method::Emlt, Some(mix), 1);
    assert!(worst > Z_LIMIT, "a broken mix passes: |z| = {worst} ({name})");
}

/// Light through water, seen through water, from a lamp of millimetres: the start of mlt finds none. The render has to say so.
#[test]
fn a_pool_under_a_small_lamp_says_what_it_lacks() {
    let settings = Settings { candidates: CANDIDATES, ..settings(Method::Mlt, [64, 48], 40) };
    let notes = render(&scene("scenes/pool.glb"), &settings).statistics.notes;
    assert!(notes.iter().any(|n| n.starts_with("paths L S D S E have not converged: only")), "{notes:?}");
}

/// By emlt's map of photons it is found: as much light as under a wide lamp of the same power, which Mitsuba can render (its
/// film's mean luminance is known to 0.6 %; tests/references/README.md). Of that more than a quarter is L S D S E.
#[test]
fn a_pool_under_a_small_lamp_is_lit() {
    const WIDE_LAMP: f64 = 0.1453;
    let settings = Settings { candidates: CANDIDATES, ..settings(Method::Emlt, [64, 48], 40) };
    let statistics = render(&scene("scenes/pool.glb"), &settings).statistics;
    let (b, error) = statistics.b.unwrap();
    println!("b {b:.4} +- {error:.4} under 4 mm, {WIDE_LAMP} under 60 mm");
    assert!(error < 0.03 * b && (b - WIDE_LAMP).abs() < 4.0 * error + 0.01 * WIDE_LAMP, "{b} +- {error}");
    let caustic = statistics.types.iter().find(|t| t.name == "L S D S E").unwrap();
    assert!(caustic.start > 0.25 && caustic.candidates > 500, "{caustic:?}");
    assert!(!statistics.notes.iter().any(|n| n.contains("only hitting a light")), "{:?}", statistics.notes);
}
