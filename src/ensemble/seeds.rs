//! Which candidates the chains start from.

use rayon::prelude::*;

use super::bootstrap::{CANDIDATE_PASS, Start};
use crate::reference::rng;

/// What is kept of a candidate that carries light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    /// Its number among all candidates.
    pub(super) index: u32,
    /// log(I / density).
    pub(super) log_weight: f32,
    pub(super) pixel: [f32; 2],
    /// Its type.
    pub(super) key: [u32; 4],
}

/// Subsets by which the start's rounds are shifted against each other: no factor in common with any number of subsets, 2 to 16.
const GROUPS_A_ROUND: u32 = 11;

impl Start {
    /// Seeds of both halves: candidates drawn with probability proportional to weight by systematic resampling along a
    /// Hilbert curve over the film. Every half of every group draws from candidates of its own (METHOD.md 1.3 c), every so
    /// many of the list, whose rounds are sorted by strategy: each has its share of all strategies.
    /// With the seeds comes whether that could not be done: where hardly any candidates carry light, groups share them.
    pub(super) fn choose(&self, lit: &[Lit], weights: &[f64], round: u32) -> (Vec<u32>, bool) {
        let side = self.film[0].max(self.film[1]).next_power_of_two();
        let seeds = self.groups.group_paths();
        // In the order of paths: the groups of the first half, then those of the second.
        let mut pools: Vec<Vec<(u64, u32)>> = vec![Vec::new(); 2 * self.groups.count() as usize];
        let count = pools.len();
        for (place, Lit { index, pixel, .. }) in (0..).zip(lit) {
            let [x, y] = pixel.map(|p| p.max(0.0) as u32);
            let along = hilbert_index(side, x.min(side - 1), y.min(side - 1));
            // Strategies of few candidates a round give them to others every time.
            let turn = *index / round.max(1) * GROUPS_A_ROUND;
            pools[(*index + turn) as usize % count].push((along, place));
        }
        pools.par_iter_mut().for_each(|pool| pool.sort_unstable());
        let mut chosen = Vec::with_capacity(self.groups.paths() as usize);
        let mut shared = false;
        for (subset, mut pool) in (0..).zip(pools) {
            if pool.is_empty() {
                shared = true;
                pool = (0..lit.len() as u32).map(|place| (0, place)).collect();
            }
            let total: f64 = pool.iter().map(|(_, i)| weights[*i as usize]).sum();
            let offset = rng::uniform(rng::random_words(self.seed, subset, CANDIDATE_PASS, u32::MAX - 1)[0]);
            let mut member = 0;
            let mut below = 0.0;
            for n in 0..seeds {
                let target = (f64::from(n) + offset) / f64::from(seeds) * total;
                while member + 1 < pool.len() && below + weights[pool[member].1 as usize] <= target {
                    below += weights[pool[member].1 as usize];
                    member += 1;
                }
                chosen.push(lit[pool[member].1 as usize].index);
            }
        }
        (chosen, shared)
    }
}

/// Position along the Hilbert curve that fills a square of `side` (a power of two) pixels.
fn hilbert_index(side: u32, mut x: u32, mut y: u32) -> u64 {
    let mut index = 0u64;
    let mut s = side / 2;
    while s > 0 {
        let (rx, ry) = (u32::from(x & s > 0), u32::from(y & s > 0));
        index += u64::from(s) * u64::from(s) * u64::from((3 * rx) ^ ry);
        if ry == 0 {
            if rx == 1 {
                (x, y) = (side - 1 - x, side - 1 - y);
            }
            std::mem::swap(&mut x, &mut y);
        }
        s /= 2;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hilbert_curve_visits_neighbours() {
        let side = 16;
        let mut at: Vec<(u64, u32, u32)> =
            (0..side * side).map(|i| (hilbert_index(side, i % side, i / side), i % side, i / side)).collect();
        at.sort_unstable();
        for (n, pair) in at.windows(2).enumerate() {
            assert_eq!(pair[0].0, n as u64);
            assert_eq!(pair[0].1.abs_diff(pair[1].1) + pair[0].2.abs_diff(pair[1].2), 1);
        }
    }
}
