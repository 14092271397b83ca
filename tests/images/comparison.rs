//! Replicate renders against a truth, by Student's t in every bin of [`tiles`](super::tiles).
//!
//! The variance of a Metropolis render is not known from the render itself: its samples are correlated. Independent
//! replicates show it. With the mean x and the variance s^2 of R replicates, and a truth m of variance v,
//! t = (x - m) / sqrt(s^2 / R + v) exceeds a limit at most as often as Student's law with R - 1 degrees of freedom has it
//! (Mickey and Brown 1966; Welch's estimated degrees of freedom come nearer to it, but err on either side).
//! The bins are not independent and need not be: the limit is Bonferroni's.

use emlt::film::Image;
use emlt::report::student::{critical, two_sided};

use super::renders::changed;
use super::tiles::{Bin, Scale, bins};

/// Probability that one comparison raises a false alarm.
pub const LEVEL: f64 = 3e-5;
/// Relative standard error put under every truth: sums of floats over many samples are no better.
const ROUNDING: f64 = 1e-6;

/// What the images should be.
pub struct Truth {
    pub image: Image,
    /// Variance of its pixels; none where it is exact.
    pub variance: Option<Image>,
    /// Side of the tiles, in pixels.
    pub tile: u32,
}

/// Relative biases that a comparison has to catch: of the whole film by the film's bins, and of a tile by that tile
/// alone, in at least half of all tiles.
pub struct Power {
    pub film: f64,
    pub tile: f64,
}

/// One bin's mean against the truth's.
pub struct Deviation {
    bin: Bin,
    truth: f64,
    difference: f64,
    standard_error: f64,
    dof: u32,
    /// Probability of as large a deviation by chance.
    p: f64,
}

impl Deviation {
    fn new(bin: Bin, replicates: &[Image], truth: &Truth) -> Self {
        let values: Vec<f64> = replicates.iter().map(|image| bin.mean(image)).collect();
        let expected = bin.mean(&truth.image);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let scatter = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        let noise = truth.variance.as_ref().map_or(0.0, |v| bin.variance(v));
        let sum = scatter + noise + (ROUNDING * expected).powi(2);
        let dof = replicates.len() as u32 - 1;
        let (difference, standard_error) = (mean - expected, sum.sqrt());
        let p = two_sided(difference / standard_error, dof);
        Self { bin, truth: expected, difference, standard_error, dof, p }
    }

    fn t(&self) -> f64 {
        self.difference / self.standard_error
    }
}

pub struct Comparison {
    /// In order of p.
    deviations: Vec<Deviation>,
}

impl Comparison {
    pub fn new(replicates: &[Image], truth: &Truth) -> Self {
        let bins = bins(truth.image.width, truth.image.height, truth.tile);
        let mut deviations: Vec<_> = bins.into_iter().map(|bin| Deviation::new(bin, replicates, truth)).collect();
        deviations.sort_by(|a, b| a.p.total_cmp(&b.p));
        Self { deviations }
    }

    fn of(&self, scale: Scale) -> impl Iterator<Item = &Deviation> {
        self.deviations.iter().filter(move |d| d.bin.scale == scale)
    }

    /// Probability that the worst bin is as bad by chance (Bonferroni).
    pub fn p(&self) -> f64 {
        self.deviations[0].p * self.deviations.len() as f64
    }

    /// Whether no bin deviates by more than chance allows.
    pub fn passes(&self) -> bool {
        self.p() > LEVEL
    }

    /// Share of a scale's bins that raise the alarm.
    pub fn alarms(&self, scale: Scale) -> f64 {
        let limit = LEVEL / self.deviations.len() as f64;
        self.of(scale).filter(|d| d.p < limit).count() as f64 / self.of(scale).count() as f64
    }

    /// Median over a scale's bins of the relative bias at which t reaches its limit.
    fn resolution(&self, scale: Scale) -> f64 {
        let limit = LEVEL / self.deviations.len() as f64;
        let mut biases: Vec<f64> =
            self.of(scale).map(|d| critical(limit, d.dof) * d.standard_error / d.truth).collect();
        biases.sort_by(f64::total_cmp);
        biases[biases.len() / 2]
    }

    /// What whoever reads the test's output wants to know.
    pub fn report(&self, name: &str) -> String {
        let worst = &self.deviations[0];
        // The mean of t^2 over its expectation dof / (dof - 2): near 1, like a chi^2 over its degrees of freedom.
        let squares: f64 = self.of(Scale::Tile).map(|d| d.t().powi(2) * (1.0 - 2.0 / f64::from(d.dof))).sum();
        let film: Vec<String> = self.of(Scale::Film).map(|d| format!("{:.1}", d.t())).collect();
        format!(
            "{name}: worst t {:.2} ({} dof), {:+.2} % in {}; p {:.1e} of {} bins; tiles' chi2 {:.2}; film's t {}; \
             limits {:.1} % of a tile, {:.2} % of the film",
            worst.t(),
            worst.dof,
            100.0 * worst.difference / worst.truth,
            worst.bin,
            self.p(),
            self.deviations.len(),
            squares / self.of(Scale::Tile).count() as f64,
            film.join(" "),
            100.0 * self.resolution(Scale::Tile),
            100.0 * self.resolution(Scale::Film),
        )
    }
}

/// Fails if the replicates deviate from the truth, or if a deviation of the stated size would have passed.
#[track_caller]
pub fn check(name: &str, replicates: &[Image], truth: &Truth, power: Power) {
    let report = Comparison::new(replicates, truth).report(name);
    println!("{report}");
    assert!(Comparison::new(replicates, truth).passes(), "{report}");
    let caught = |scale, bias: f64| {
        let scaled = |image| changed(image, |_, _, p| p.map(|v| v * (1.0 + bias) as f32));
        Comparison::new(&replicates.iter().map(scaled).collect::<Vec<_>>(), truth).alarms(scale)
    };
    for sign in [-1.0, 1.0] {
        let (film, tiles) = (caught(Scale::Film, sign * power.film), caught(Scale::Tile, sign * power.tile));
        assert!(film > 0.0, "a bias of {} of the film passes: {report}", sign * power.film);
        assert!(tiles >= 0.5, "a bias of {} passes but in {tiles} of the tiles: {report}", sign * power.tile);
    }
}
