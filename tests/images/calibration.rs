//! The comparison itself on made-up replicates: how often it raises the alarm where nothing is wrong.

use emlt::film::Image;
use emlt::reference::rng;
use emlt::report::student::two_sided;

use super::comparison::{Comparison, Truth};

/// As many replicates as Metropolis renders have.
const REPLICATES: u32 = 12;

/// Endless standard normal numbers (Box and Muller 1958), another sequence for each `seed`.
fn normals(seed: u32) -> impl Iterator<Item = f64> {
    (0..).flat_map(move |i| {
        let words = rng::random_words(seed, i, 0, 0);
        let radius = (-2.0 * rng::uniform(words[0]).ln()).sqrt();
        let angle = std::f64::consts::TAU * rng::uniform(words[1]);
        [radius * angle.cos(), radius * angle.sin()]
    })
}

/// Shares of p below each limit, over the limit, among 2 million t of replicates of a law of mean 0.
fn excess<const N: usize>(limits: [f64; N], seed: u32, law: impl Fn(f64) -> f64) -> [f64; N] {
    const TRIALS: u32 = 2_000_000;
    let n = f64::from(REPLICATES);
    let mut counts = [0u32; N];
    let mut numbers = normals(seed).map(law);
    for _ in 0..TRIALS {
        let values: [f64; REPLICATES as usize] = std::array::from_fn(|_| numbers.next().expect("endless"));
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let p = two_sided(mean / (variance / n).sqrt(), REPLICATES - 1);
        limits.iter().zip(&mut counts).for_each(|(limit, count)| *count += u32::from(p < *limit));
    }
    std::array::from_fn(|i| f64::from(counts[i]) / f64::from(TRIALS) / limits[i])
}

#[test]
fn p_is_exact_for_normal_replicates() {
    let found = excess([1e-2, 1e-3, 1e-4], 1, |z| z);
    println!("normal: p occurs {found:.3?} times as often as it says");
    // Five standard errors of the counts, which expect 20,000, 2,000 and 200.
    for (share, expected) in found.iter().zip([2e4f64, 2e3, 2e2]) {
        assert!((share - 1.0).abs() < 5.0 / expected.sqrt(), "{found:?}");
    }
}

/// Tiles of real renders have a skewness of 0.2 on average, one in ten more than 0.9. Log-normal replicates of
/// skewness 0.95 raise alarms at the comparisons' limit of 8e-8 several times as often as p says: a comparison in which
/// every tile were like that would have a false alarm with probability 4e-4 or less instead of 3e-5.
#[test]
fn p_is_of_the_right_order_for_skewed_replicates() {
    let sigma: f64 = 0.3;
    let law = |z: f64| (sigma * z).exp() - (0.5 * sigma * sigma).exp();
    let found = excess([1e-2, 1e-4, 1e-6], 2, law);
    println!("log-normal: p occurs {found:.2?} times as often as it says");
    assert!(found.iter().all(|share| *share < 14.0), "{found:?}");
}

/// The whole comparison, with a noisy truth and bins at three scales: at most 5 % of p below 5 %, and not far fewer.
/// Truths five times as noisy as stated raise the alarm.
#[test]
fn comparisons_without_bias_pass() {
    const TRIALS: u32 = 800;
    const SIZE: [u32; 2] = [48, 24];
    let count = 3 * (SIZE[0] * SIZE[1]) as usize;
    let constant = |value: f32| Image { width: SIZE[0], height: SIZE[1], pixels: vec![[value; 3]; count / 3] };
    // The truth is a quarter as noisy as the mean of the replicates.
    let (noise, truth_noise) = (0.1, 0.1 / (16.0 * f64::from(REPLICATES)).sqrt());
    let alarms = |first_seed: u32, understated: f64| {
        let alarm = |trial: u32| {
            let mut numbers = normals(first_seed + trial);
            let mut image = |noise: f64| {
                let mut pixel = || (1.0 + noise * numbers.next().expect("endless")) as f32;
                let mut image = constant(0.0);
                image.pixels.iter_mut().flatten().for_each(|value| *value = pixel());
                image
            };
            let replicates: Vec<Image> = (0..REPLICATES).map(|_| image(noise)).collect();
            let variance = Some(constant(truth_noise.powi(2) as f32));
            Comparison::new(&replicates, &Truth { image: image(understated * truth_noise), variance, tile: 8 }).p()
        };
        (0..TRIALS).filter(|trial| alarm(*trial) < 0.05).count() as f64 / f64::from(TRIALS)
    };
    let (stated, understated) = (alarms(1000, 1.0), alarms(5000, 5.0));
    println!(
        "p below 5 %: {:.2} % of comparisons, {:.2} % with an understated noise",
        100.0 * stated,
        100.0 * understated
    );
    // Five standard errors above 5 %.
    assert!(stated < 0.05 + 5.0 * (0.05 * 0.95 / f64::from(TRIALS)).sqrt(), "{stated}");
    assert!(stated > 0.01, "the comparison is blind: {stated}");
    assert!(understated > 0.2, "{understated}");
}
