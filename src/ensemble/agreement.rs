//! Whether groups of chains agree: nested R-hat (Margossian et al. 2024), for many chains that are short.
//!
//! R-hat^2 = 1 + B / W, B the variance of the groups' means over all states since the start, W the mean over groups of what
//! is inside: variance of the chains' means and mean variance within a chain. Groups here are the ensemble's own: each
//! starts from its own part of the candidates, by their weight, and not from one point as in the paper. Where candidates
//! tell light well, groups agree from the start on; where a few heavy ones stand for much of the light, groups differ
//! until their chains have forgotten. What no group has found, none can disagree on.

use super::groups::Groups;

/// Groups agree up to here (METHOD.md 5.10).
const AGREES: f64 = 1.02;
/// What chance exceeds one time in a thousand, in standard deviations of a normal law.
const UNLIKELY: f64 = 3.09;

/// Sums of one chain: of a quantity and its square.
type Sums = [f64; 2];

/// A quantity of every chain of an ensemble, over its observations.
#[derive(Debug, Clone)]
pub struct Agreement {
    groups: Groups,
    chains: Vec<Sums>,
    /// Observations of either half.
    observations: [u64; 2],
}

impl Agreement {
    pub fn new(groups: Groups) -> Self {
        Self { groups, chains: vec![Sums::default(); groups.paths() as usize], observations: [0; 2] }
    }

    /// Adds an observation of every path of a half.
    pub fn observe(&mut self, half: usize, values: impl Iterator<Item = f64>) {
        self.observations[half] += 1;
        for ([sum, squares], value) in self.chains[self.groups.first_of_half(half) as usize..].iter_mut().zip(values) {
            *sum += value;
            *squares += value * value;
        }
    }

    /// None with one group, and before every path was observed.
    pub fn r_hat(&self) -> Option<f64> {
        let count = self.groups.count();
        if count < 2 || self.observations.contains(&0) {
            return None;
        }
        let group = |group: u32| -> Vec<(f64, f64)> {
            let halves = (0..2).flat_map(|half| {
                let first = self.groups.first(half, group) as usize;
                let chains = &self.chains[first..first + self.groups.group_paths() as usize];
                chains.iter().map(move |sums| mean_and_variance(*sums, self.observations[half] as f64))
            });
            halves.collect()
        };
        let (mut means, mut inside) = (Sums::default(), 0.0);
        for chains in (0..count).map(group) {
            let n = chains.len() as f64;
            let sums = chains.iter().fold(Sums::default(), |s, (mean, _)| [s[0] + mean, s[1] + mean * mean]);
            let (mean, between_chains) = mean_and_variance(sums, n);
            inside += between_chains + chains.iter().map(|(_, variance)| variance).sum::<f64>() / n;
            means = [means[0] + mean, means[1] + mean * mean];
        }
        let (_, between_groups) = mean_and_variance(means, f64::from(count));
        let inside = inside / f64::from(count);
        // A quantity that is the same everywhere is agreed on.
        Some(if between_groups > 0.0 { (1.0 + between_groups / inside).sqrt() } else { 1.0 })
    }

    /// Up to where groups agree: [`AGREES`], or where groups of few paths scatter by more, what groups of independent
    /// paths that do not move exceed one time in a thousand.
    pub fn limit(&self) -> f64 {
        let (count, paths) = (f64::from(self.groups.count()), f64::from(2 * self.groups.group_paths()));
        // Quantile of F (Paulson 1942) between groups and within them.
        let [d, c] = [count - 1.0, count * (paths - 1.0)].map(|degrees| 2.0 / (9.0 * degrees.max(1.0)));
        let [b, a] = [1.0 - d, 1.0 - c];
        let spread = (a * a * d + b * b * c - UNLIKELY * UNLIKELY * c * d).max(0.0).sqrt();
        let chance = ((a * b + UNLIKELY * spread) / (a * a - UNLIKELY * UNLIKELY * c)).powi(3);
        AGREES.max((1.0 + chance / paths).sqrt())
    }
}

/// Of `n` values with these sums: mean, and unbiased variance (0 for one value).
fn mean_and_variance([sum, squares]: Sums, n: f64) -> (f64, f64) {
    let mean = sum / n;
    let rounding = 1e-12 * squares;
    let scatter = squares - n * mean * mean;
    (mean, if n > 1.0 && scatter > rounding { scatter / (n - 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::rng;

    const PATHS: u32 = 4096;

    fn uniform(path: u32, step: u32) -> f64 {
        rng::uniform(rng::random_words(5, path, step, 0)[0])
    }

    /// R-hat of `steps` observations of every path, each by its group, path and step.
    fn r_hat(steps: u32, value: impl Fn(u32, u32, u32) -> f64) -> (f64, f64) {
        let groups = Groups::new(PATHS, 8);
        let mut agreement = Agreement::new(groups);
        for step in 0..steps {
            for half in 0..2 {
                let first = groups.first_of_half(half);
                let paths = first..first + groups.half_paths();
                agreement.observe(half, paths.map(|path| value(groups.of_path(path), path, step)));
            }
        }
        (agreement.r_hat().unwrap(), agreement.limit())
    }

    #[test]
    fn groups_alike_agree_and_shifted_ones_do_not() {
        // Chains that move, chains that begin in their law and never move, and a quantity that is the same everywhere.
        for (steps, still) in [(50, false), (1, false), (50, true)] {
            let (r_hat, limit) = r_hat(steps, |_, path, step| 7.0 + uniform(path, if still { 0 } else { step }));
            println!("{steps} steps: {r_hat}, limit {limit}");
            assert!((1.0..limit).contains(&r_hat) && limit == 1.02, "{r_hat}");
        }
        assert_eq!(r_hat(3, |_, _, _| 0.1).0, 1.0);
        // A group that is shifted by one standard deviation of 8 groups: B = 1/8 of the variance.
        let shift = (1.0f64 / 12.0).sqrt();
        let (r_hat, _) = r_hat(50, |group, path, step| uniform(path, step) + if group == 3 { shift } else { 0.0 });
        assert!((r_hat - (1.0f64 + 1.0 / 8.0).sqrt()).abs() < 5e-3, "{r_hat}");
    }

    /// By hand: two groups of two chains with two observations each.
    #[test]
    fn a_small_case_is_as_the_paper_has_it() {
        let groups = Groups::new(4, 2);
        let mut agreement = Agreement::new(groups);
        assert_eq!(agreement.r_hat(), None);
        // First half: groups 0 and 1 have a path each; then the second half.
        for (half, values) in [(0, [1.0, 5.0]), (1, [3.0, 9.0]), (0, [3.0, 7.0]), (1, [3.0, 11.0])] {
            agreement.observe(half, values.into_iter());
        }
        // Chains' means 2, 3 and 6, 10 with variances 2, 0 and 2, 2; groups' means 2.5 and 8.
        let (between, inside) = (5.5f64 * 5.5 / 2.0, ((0.5 + 1.0) + (8.0 + 2.0)) / 2.0);
        assert!((agreement.r_hat().unwrap() - (1.0 + between / inside).sqrt()).abs() < 1e-12);
    }

    /// Groups of few paths scatter by chance, and are not blamed for it; the limit is right for one time in a thousand.
    #[test]
    fn few_paths_are_not_blamed() {
        let groups = Groups::new(64, 8);
        let mut above = 0;
        for trial in 0..20_000 {
            let mut agreement = Agreement::new(groups);
            (0..2)
                .for_each(|half| agreement.observe(half, (0..32).map(|path| uniform(32 * half as u32 + path, trial))));
            above += u32::from(agreement.r_hat().unwrap() > agreement.limit());
        }
        // 20 are expected of normal values; uniform ones have lighter tails.
        println!("{above} of 20,000 above the limit");
        assert!((2..45).contains(&above), "{above}");
        assert_eq!(Agreement::new(Groups::new(64, 1)).r_hat(), None);
    }
}
