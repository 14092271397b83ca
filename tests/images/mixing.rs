//! What a render says of how its chains mix, for chains that do and chains that do not.

use emlt::ensemble::mix::HALF_SWEEP;
use emlt::ensemble::mixing::MixingStatistics;
use emlt::kernels::{Kernel, independence, lens};
use emlt::methods::{Method, Outcome, Settings};

use super::renders::{render, scene, settings};

fn told(outcome: &Outcome) -> (MixingStatistics, Vec<String>) {
    let mixing = outcome.statistics.mixing.clone().expect("chains have moved");
    println!("{mixing:?}, {:?}", outcome.statistics.notes);
    (mixing, outcome.statistics.notes.clone())
}

/// Chains that move well are not spoken of.
#[test]
fn chains_that_mix_are_not_blamed() {
    let settings = settings(Method::Emlt, [64, 48], 500);
    let (mixing, notes) = told(&render(&scene("scenes/cornell.glb"), &settings));
    assert!(mixing.effective.unwrap() > 2.0 * f64::from(mixing.paths));
    assert!(mixing.r_hat.unwrap().iter().all(|r_hat| *r_hat < 1.01));
    assert!(mixing.still < 0.005 && notes.is_empty(), "{notes:?}");
}

/// Nothing but independent proposals, few of which are accepted, from a start of few candidates: some paths never move,
/// and every group stays where it started.
#[test]
fn chains_that_do_not_move_are_caught() {
    static NOTHING: Kernel = Kernel { name: "nothing", applies: |_, _| false, ..lens::KERNEL };
    let kernels: Vec<(&'static Kernel, f64)> = vec![(&independence::KERNEL, 0.05), (&NOTHING, 1.0)];
    // 10 half-sweeps of either half.
    let film = [256, 192];
    let spp = 10 * HALF_SWEEP * 2048 / (film[0] * film[1]);
    let settings = Settings { kernels: Some(kernels), candidates: 1 << 10, ..settings(Method::Emlt, film, spp) };
    let (mixing, notes) = told(&render(&scene("scenes/ajar.glb"), &settings));
    assert_eq!(mixing.mutations, 200.0);
    assert_eq!(mixing.longest_wait, 200, "a path that has never moved waits from the first mutation on");
    assert_eq!(mixing.memory, None);
    assert!(mixing.effective.unwrap() < 1.5 * f64::from(mixing.paths));
    assert!(mixing.r_hat.unwrap()[0] > 1.05);
    let said = |words: &str| notes.iter().any(|note| note.contains(words));
    assert!(mixing.still > 0.5 && said("of the paths have not moved"), "{notes:?}");
    assert!(said("groups of paths do not agree") && said("put 24 times the film's mean"), "{notes:?}");
}
