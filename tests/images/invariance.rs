//! What is chosen freely must not show in the image: guides a look-up, alpha, what similarity compares, the ensemble's
//! size, the kernels' weights and with them the perturbations of a half-sweep. (The roughness threshold: threshold.rs.)

use emlt::ensemble::guidance::Guidance;
use emlt::film::Image;
use emlt::kernels::{caustic, guided_bidirectional, guided_lens, independence, lens, multi_chain};
use emlt::methods::Method::Emlt;
use emlt::methods::Settings;
use emlt::report::student::two_sided;

use super::comparison::LEVEL;
use super::mitsuba::COLOURED_BOX;
use super::renders::{changed, replicates, scene, settings};
use super::tiles::bins;

/// Renders of each choice.
const REPLICATES: u32 = 4;

/// Least probability over all choices and bins, Bonferroni's factor in it: each choice's mean against the others', by the
/// variance within choices.
fn least_probability(groups: &[Vec<Image>]) -> f64 {
    let bins = bins(groups[0][0].width, groups[0][0].height, 12);
    let (v, n) = (groups.len() as f64, f64::from(REPLICATES));
    let dof = (v * (n - 1.0)) as u32;
    let mut least = 1.0f64;
    for bin in &bins {
        let values: Vec<Vec<f64>> = groups.iter().map(|g| g.iter().map(|image| bin.mean(image)).collect()).collect();
        let means: Vec<f64> = values.iter().map(|g| g.iter().sum::<f64>() / n).collect();
        let within: f64 = values.iter().zip(&means).flat_map(|(g, m)| g.iter().map(move |x| (x - m).powi(2))).sum();
        let variance = within / f64::from(dof);
        for m in &means {
            let others = (means.iter().sum::<f64>() - m) / (v - 1.0);
            let t = (m - others) / (variance / n * (1.0 + 1.0 / (v - 1.0))).sqrt();
            least = least.min(two_sided(t, dof));
        }
    }
    least * bins.len() as f64 * v
}

#[test]
fn free_choices_do_not_show() {
    let base = Settings { candidates: 1 << 17, ..settings(Emlt, [48, 36], 120) };
    let guidance = |guidance| Settings { guidance, ..base.clone() };
    let structural = vec![
        (&independence::KERNEL, 0.25),
        (&guided_bidirectional::KERNEL, 0.4),
        (&lens::KERNEL, 0.2),
        (&multi_chain::KERNEL, 1.0),
        (&caustic::KERNEL, 3.0),
        (&guided_lens::KERNEL, 2.0),
    ];
    let choices = [
        base.clone(),
        guidance(Guidance { guides: 1, ..Default::default() }),
        guidance(Guidance { guides: 32, ..Default::default() }),
        guidance(Guidance { alpha: [0.05; 2], ..Default::default() }),
        guidance(Guidance { alpha: [0.9; 2], ..Default::default() }),
        guidance(Guidance { normals: true, ..Default::default() }),
        Settings { ensemble: 256, ..base.clone() },
        Settings { ensemble: 8192, ..base.clone() },
        Settings { kernels: Some(structural), ..base.clone() },
    ];
    let scene = scene(COLOURED_BOX);
    let mut groups: Vec<Vec<Image>> = choices
        .iter()
        .enumerate()
        // Seeds of their own for every choice, or their starts would be the same.
        .map(|(i, choice)| replicates(&scene, &Settings { seed: 100 * i as u32, ..choice.clone() }, REPLICATES))
        .collect();
    let p = least_probability(&groups);
    println!("free choices: p {p:.1e}");
    assert!(p > LEVEL, "some choice shows: p {p}");
    // What the test can see: one choice 4 % brighter than the others.
    groups[3] = groups[3].iter().map(|image| changed(image, |_, _, p| p.map(|v| 1.04 * v))).collect();
    let p = least_probability(&groups);
    println!("one choice 4 % brighter: p {p:.1e}");
    assert!(p < LEVEL, "a choice that shows passes: p {p}");
}
