//! How long a quantity of the chains remembers: its integrated autocorrelation time, from many chains at once.
//!
//! Autocovariances are pooled over chains around the mean that they have in common, which is right for chains of any
//! length (globally centred: Agarwal and Vats 2022); around each chain's own mean, chains shorter than their memory would
//! seem to forget. They are cut off by Sokal's window (Sokal 1997), for ensembles as in Foreman-Mackey et al. (2013).
//!
//! Lags are those of a multiple-tau correlator (Ramirez et al. 2010): every lag up to [`LAGS`], then half as many for every
//! doubling, from every other observation. So what is kept grows with the logarithm of a render's length alone, and what
//! is looked at when is fixed in advance.

use std::collections::VecDeque;

/// Lags of the first level, in observations; further levels have the upper half of them, twice as far apart each.
const LAGS: usize = 32;
/// Sokal's window ends at the first lag that is so many times the autocorrelation time within it.
const WINDOW: f64 = 5.0;

/// Sums over pairs of observations of the same chain a lag apart.
#[derive(Debug, Clone, Copy, Default)]
struct Pairs {
    count: f64,
    earlier: f64,
    later: f64,
    products: f64,
}

impl Pairs {
    fn add(&mut self, earlier: &[f32], later: &[f32]) {
        for (a, b) in earlier.iter().zip(later).map(|(a, b)| (f64::from(*a), f64::from(*b))) {
            self.earlier += a;
            self.later += b;
            self.products += a * b;
        }
        self.count += earlier.len() as f64;
    }

    fn covariance(&self) -> f64 {
        let n = self.count.max(1.0);
        self.products / n - self.earlier / n * (self.later / n)
    }
}

/// Observations of one set of chains, the newest first: of level l the last [`LAGS`] of every 2^l-th.
#[derive(Debug, Clone, Default)]
struct History {
    observations: u64,
    levels: Vec<VecDeque<Vec<f32>>>,
}

/// What chains remember, in observations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// Integrated autocorrelation time, 1 for independent observations; none where chains are too short to tell.
    pub time: Option<f64>,
    /// Effective observations a chain: how many independent ones have a mean of the same scatter. A chain that begins
    /// with the law of the target and never moves is worth 1.
    pub effective: f64,
}

/// Autocovariances of a quantity of chains, which may come in several sets that are observed in turn.
#[derive(Debug, Clone)]
pub struct Autocorrelation {
    sets: Vec<History>,
    /// Lag 0, then the lags of every level.
    variance: Pairs,
    levels: Vec<[Pairs; LAGS]>,
}

impl Autocorrelation {
    pub fn new(sets: usize) -> Self {
        Self { sets: vec![History::default(); sets], variance: Pairs::default(), levels: Vec::new() }
    }

    /// Adds one observation of every chain of a set, always in the same order.
    pub fn observe(&mut self, set: usize, values: &[f32]) {
        let History { observations, levels } = &mut self.sets[set];
        self.variance.add(values, values);
        for level in (0..).take_while(|level| observations.is_multiple_of(1 << level)) {
            if level == levels.len() {
                match level.checked_sub(1).map(|below| &levels[below]) {
                    None => levels.push(VecDeque::new()),
                    // The first time that every other observation of the level below, this one included, makes half a
                    // level, while the first of all is still among them.
                    Some(below) if below.len() == LAGS - 1 => {
                        let every_other = below.iter().step_by(2).cloned().collect();
                        levels.push(every_other);
                        break;
                    }
                    Some(_) => break,
                }
            }
            if level == self.levels.len() {
                self.levels.push([Pairs::default(); LAGS]);
            }
            let nearest = if level == 0 { 0 } else { LAGS / 2 };
            let ring = &mut levels[level];
            for (pairs, earlier) in self.levels[level].iter_mut().zip(ring.iter()).skip(nearest) {
                pairs.add(earlier, values);
            }
            ring.push_front(values.to_vec());
            ring.truncate(LAGS);
        }
        *observations += 1;
    }

    /// Lags, in observations, with the correlation at each; shortest first.
    fn correlations(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let variance = self.variance.covariance();
        let of_level = move |(level, pairs): (usize, &[Pairs; LAGS])| {
            let of_lag = move |(i, pairs): (usize, Pairs)| (((i + 1) << level) as f64, pairs.covariance() / variance);
            (*pairs).into_iter().enumerate().filter(|(_, pairs)| pairs.count > 0.0).map(of_lag)
        };
        self.levels.iter().enumerate().flat_map(of_level)
    }

    /// None without observations, or where all are alike.
    pub fn memory(&self) -> Option<Memory> {
        let length = self.sets.iter().map(|set| set.observations as f64).sum::<f64>() / self.sets.len().max(1) as f64;
        let variance = self.variance.covariance();
        // What is left of a difference of squares is rounding.
        if self.variance.count == 0.0 || variance <= 1e-12 * self.variance.products / self.variance.count {
            return None;
        }
        // Sums of the correlation, and of the same times 1 - lag / length as in the mean of a chain, straight between lags.
        let mut sums = [0.0; 2];
        let mut before = (0.0, [1.0; 2]);
        let mut time = None;
        for (lag, correlation) in self.correlations() {
            let terms = [correlation, correlation * (1.0 - lag / length).max(0.0)];
            let steps: f64 = lag - before.0;
            for (sum, (term, first)) in sums.iter_mut().zip(terms.into_iter().zip(before.1)) {
                *sum += steps * first + (term - first) * (steps + 1.0) / 2.0;
            }
            before = (lag, terms);
            let within = (1.0 + 2.0 * sums[0]).max(1.0);
            if lag >= WINDOW * within {
                time = Some(within);
                break;
            }
        }
        Some(Memory { time, effective: (length / (1.0 + 2.0 * sums[1]).max(1.0)).clamp(1.0, length.max(1.0)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::rng;

    /// A normal number for every (chain, step).
    fn normal(chain: u32, step: u32) -> f64 {
        let words = rng::random_words(11, chain, step, 0);
        let [u, v] = [words[0], words[1]].map(rng::uniform);
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Chains x' = phi x + noise, of variance 1, that begin in their law; in two sets, of which the second is half an
    /// observation behind.
    fn autoregressive(phi: f64, chains: u32, length: u32) -> Autocorrelation {
        let mut all = Autocorrelation::new(2);
        let mut states: Vec<f64> = (0..chains).map(|chain| normal(chain, 0)).collect();
        for step in 1..=length {
            for (set, half) in states.chunks(chains as usize / 2).enumerate() {
                let values: Vec<f32> = half.iter().map(|x| 5.0 + 3.0 * *x as f32).collect();
                all.observe(set, &values);
            }
            for (chain, x) in (0..).zip(&mut states) {
                *x = phi * *x + (1.0 - phi * phi).sqrt() * normal(chain, step);
            }
        }
        all
    }

    /// length / (1 + 2 SUM (1 - k / length) phi^k)
    fn effective(phi: f64, length: u32) -> f64 {
        let n = f64::from(length);
        let sum: f64 = (1..length).map(|k| (1.0 - f64::from(k) / n) * phi.powi(k as i32)).sum();
        n / (1.0 + 2.0 * sum)
    }

    /// The autocorrelation time of such chains is (1 + phi) / (1 - phi).
    #[test]
    fn memory_of_autoregressive_chains_is_known() {
        // Windows of 5 times leave out exp(-5 / 2 * ..) of the sum: at most 8 parts in a thousand.
        for (phi, chains, length, within) in
            [(0.0, 200, 200, 0.02), (0.5, 200, 400, 0.03), (0.9, 400, 600, 0.05), (0.98, 400, 3000, 0.1)]
        {
            let memory = autoregressive(phi, chains, length).memory().unwrap();
            let time = (1.0 + phi) / (1.0 - phi);
            println!("phi {phi}: {memory:?}, in truth {time} and {}", effective(phi, length));
            assert!((memory.time.unwrap() / time - 1.0).abs() < within, "{phi}: {memory:?}, not {time}");
            assert!((memory.effective / effective(phi, length) - 1.0).abs() < within, "{phi}: {memory:?}");
        }
    }

    /// Chains that are shorter than their memory do not pretend to have forgotten.
    #[test]
    fn short_chains_are_worth_what_they_are() {
        for (phi, length) in [(0.98, 20), (0.999, 100)] {
            let memory = autoregressive(phi, 2000, length).memory().unwrap();
            assert_eq!(memory.time, None, "{phi}");
            assert!((memory.effective / effective(phi, length) - 1.0).abs() < 0.1, "{phi}: {memory:?}");
        }
        let mut still = Autocorrelation::new(1);
        (0..50).for_each(|_| still.observe(0, &[1.0, 2.0, 4.0]));
        let memory = still.memory().unwrap();
        assert!(memory.time.is_none() && (1.0..1.01).contains(&memory.effective), "{memory:?}");
        let mut alike = Autocorrelation::new(1);
        (0..50).for_each(|_| alike.observe(0, &[0.1; 7]));
        assert_eq!((alike.memory(), Autocorrelation::new(2).memory()), (None, None));
    }

    /// Every pair of observations that a level is to see is in its sums, from the very first on.
    #[test]
    fn no_pair_is_lost() {
        let mut all = Autocorrelation::new(1);
        let length = 1000;
        (0..length).for_each(|step| all.observe(0, &[normal(1, step) as f32]));
        assert_eq!(all.levels.len(), 6);
        for (level, lags) in all.levels.iter().enumerate() {
            for (i, pairs) in lags.iter().enumerate() {
                let [spacing, lag] = [1, i as u32 + 1].map(|n| n << level);
                let covered = level == 0 || i >= LAGS / 2;
                let expected = if covered { length.saturating_sub(lag).div_ceil(spacing) } else { 0 };
                assert_eq!(pairs.count, f64::from(expected), "level {level}, lag {lag}");
            }
        }
    }
}
