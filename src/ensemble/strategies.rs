//! The probabilities with which the independence kernel draws a path's edges and its light-side vertices.
//!
//! Some strategies leave the edges open: a walk goes from the camera until it meets a light, or has taken as many edges
//! as it may. Light that only such paths can find (through glass, from a diffuse surface, through glass) comes at any
//! length from one walk, where strategies of fixed length would find each length apart, and so rarely that a start misses
//! most of them. Most walks find nothing, and long ones cost the most: how far they may go is drawn beforehand.

use std::ops::RangeInclusive;

use crate::gpu::layout::{strategy_columns, strategy_words};

/// Share of probability that stays spread evenly, so that no strategy's paths can be missed.
const DEFENSIVE_SHARE: f64 = 0.1;

/// The strategy that walks from the camera to the first light over at most `edges` edges; it has 0 where others have
/// their number of edges.
pub const fn walk(edges: u32) -> [u32; 2] {
    [0, edges]
}

/// The strategy that seeks a lamp through specular vertices alone, from where the map of sightings says, over as many edges as
/// there may be.
pub const SEEK: [u32; 2] = [0, 0];

/// Step between the limits of walks.
const WALK_STEP: u32 = 4;
/// Edges of the shortest path that is not direct light.
pub const INDIRECT_EDGES: u32 = 3;
/// Share of all walks before anything is known.
const WALK_SHARE: f64 = 0.25;
/// Share of seeks, likewise.
const SEEK_SHARE: f64 = 0.0625;

/// P(edges k, light-side vertices s) for the walks, k in a run's range of edges and s = 0 .. k, fixed before the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Strategies {
    /// The most edges.
    longest: u32,
    /// Pairs (k, s) that can make a path, with their probabilities.
    entries: Vec<([u32; 2], f64)>,
    /// Running sums of the probabilities.
    cumulative: Vec<f64>,
}

impl Strategies {
    /// A quarter for walks, which find any length; then every length of `edges` alike, and every split of it. Under a
    /// sky, light subpaths are not traced: s is 0 or 1. Of all, `seeks` are given their share where there are any.
    pub fn uniform(edges: RangeInclusive<u32>, sky: bool, seeks: bool) -> Self {
        let longest = *edges.end();
        let limits: Vec<u32> = (1..longest).filter(|n| n.is_multiple_of(WALK_STEP)).chain([longest]).collect();
        let seek_share = if seeks { SEEK_SHARE } else { 0.0 };
        let share = (1.0 - seek_share) * WALK_SHARE / limits.len() as f64;
        let mut entries: Vec<_> = seeks.then_some((SEEK, seek_share)).into_iter().collect();
        entries.extend(limits.into_iter().map(|n| (walk(n), share)));
        let lengths = f64::from(longest - edges.start() + 1);
        for k in edges {
            // A sky does not connect to the pinhole (s = k = 1): its directions would all be delta events there.
            let last = if sky { (k - 1).min(1) } else { k };
            for s in 0..=last {
                entries.push(([k, s], (1.0 - seek_share) * (1.0 - WALK_SHARE) / (lengths * f64::from(last + 1))));
            }
        }
        Self::from_entries(longest, entries)
    }

    /// Nothing but seeks.
    pub fn seeks(longest: u32) -> Self {
        Self::from_entries(longest, vec![(SEEK, 1.0)])
    }

    fn from_entries(longest: u32, entries: Vec<([u32; 2], f64)>) -> Self {
        let mut sum = 0.0;
        let cumulative = entries
            .iter()
            .map(|(_, p)| {
                sum += p;
                sum
            })
            .collect();
        Self { longest, entries, cumulative }
    }

    /// Probabilities proportional to p sqrt(E[W^2] / rays) as pilot samples (strategy, weight, rays waited for) show it: the
    /// allocation of least variance at equal cost (Neyman 1934), with a defensive share spread as in `even`. Strategies
    /// overlap, so that one adaptation is a step towards the best allocation and not yet there.
    pub fn adapted(&self, pilot: impl Iterator<Item = ([u32; 2], f64, f64)>, even: &Self) -> Self {
        assert!(self.entries.iter().map(|e| e.0).eq(even.entries.iter().map(|e| e.0)), "strategies of another kind");
        let mut sums = vec![[0.0f64; 3]; self.entries.len()];
        for (strategy, weight, rays) in pilot {
            let i = self.position(strategy);
            sums[i][0] += 1.0;
            sums[i][1] += weight * weight;
            sums[i][2] += rays;
        }
        let wanted: Vec<f64> = self
            .entries
            .iter()
            .zip(&sums)
            .map(|((_, p), [n, w2, rays])| {
                let n = n.max(1.0);
                p * (w2 / n / (rays / n).max(1.0)).sqrt()
            })
            .collect();
        let total: f64 = wanted.iter().sum();
        if total <= 0.0 {
            return self.clone();
        }
        let entries = self
            .entries
            .iter()
            .zip(&wanted)
            .zip(&even.entries)
            .map(|(((s, _), w), (_, even))| (*s, (1.0 - DEFENSIVE_SHARE) * w / total + DEFENSIVE_SHARE * even))
            .collect();
        Self::from_entries(self.longest, entries)
    }

    fn position(&self, strategy: [u32; 2]) -> usize {
        self.entries.partition_point(|(s, _)| *s < strategy)
    }

    /// The strategy at a uniform in [0, 1).
    pub fn pick(&self, u: f64) -> [u32; 2] {
        let target = u * self.cumulative[self.cumulative.len() - 1];
        let i = self.cumulative.partition_point(|c| *c <= target);
        self.entries[i.min(self.entries.len() - 1)].0
    }

    /// `count` strategies at (i + offset) / count: each is expected as often as its probability says.
    pub fn systematic(&self, count: u32, offset: f64) -> Vec<[u32; 2]> {
        (0..count).map(|i| self.systematic_at(i, count, offset)).collect()
    }

    /// Number `i` of these.
    pub fn systematic_at(&self, i: u32, count: u32, offset: f64) -> [u32; 2] {
        self.pick((f64::from(i) + offset) / f64::from(count))
    }

    /// log P as the shaders read it; what cannot be drawn is -1e30. Row 0, column k is for walks that may take k edges, column 0
    /// for seeks.
    pub fn log_table(&self) -> Vec<f32> {
        let columns = strategy_columns(self.longest);
        let mut table = vec![-1e30f32; strategy_words(self.longest)];
        let total = self.cumulative[self.cumulative.len() - 1];
        let walks = self.entries.iter().filter(|([k, _], _)| *k == 0);
        for (edges, entry) in table.iter_mut().enumerate().take(columns).skip(1) {
            let far_enough = walks.clone().filter(|([_, limit], _)| *limit as usize >= edges);
            *entry = (far_enough.map(|(_, p)| p).sum::<f64>() / total).ln().max(-1e30) as f32;
        }
        // Of walks the limit is no index, and a limit of 0 edges free for seeks.
        for ([k, s], p) in self.entries.iter().filter(|([k, s], _)| *k > 0 || [*k, *s] == SEEK) {
            table[*k as usize * columns + *s as usize] = (p / total).ln() as f32;
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systematic_drawing_follows_the_probabilities() {
        let strategies = Strategies::uniform(1..=12, false, false);
        let list = strategies.systematic(1 << 16, 0.37);
        assert!(list.is_sorted());
        for ([k, s], p) in &strategies.entries {
            let n = list.iter().filter(|x| **x == [*k, *s]).count() as f64;
            assert!((n - p * 65536.0).abs() <= 1.0, "{k} {s}: {n}");
        }
    }

    #[test]
    fn shorter_paths_than_asked_for_come_from_the_walk_alone() {
        for (sky, splits) in [(false, 4.0 + 5.0 + 6.0), (true, 3.0 * 2.0)] {
            let strategies = Strategies::uniform(INDIRECT_EDGES..=5, sky, false);
            assert!((strategies.cumulative.last().unwrap() - 1.0).abs() < 1e-12);
            assert_eq!(strategies.entries.len() as f64, 2.0 + splits);
            let list = strategies.systematic(4096, 0.5);
            assert!(list.iter().all(|s| s[0] == 0 || (3..=5).contains(&s[0])), "{list:?}");
            let table = strategies.log_table();
            let columns = strategy_columns(5);
            assert!(table[columns..3 * columns].iter().all(|p| *p == -1e30));
            assert!(table[3 * columns] > -1e29);
            // Two limits of walks, 4 and 5, share the quarter.
            for (edges, share) in [(1, 0.25f32), (4, 0.25), (5, 0.125)] {
                assert!((table[edges].exp() - share).abs() < 1e-6, "{edges}: {}", table[edges]);
            }
        }
    }

    #[test]
    fn seeks_have_their_share_beside_all_others() {
        let strategies = Strategies::uniform(1..=6, false, true);
        assert!((strategies.cumulative.last().unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(strategies.pick(0.0), SEEK);
        let table = strategies.log_table();
        assert!((f64::from(table[0].exp()) - SEEK_SHARE).abs() < 1e-6);
        // Two limits of walks, 4 and 6, share a quarter of the rest.
        assert!((f64::from(table[6].exp()) - (1.0 - SEEK_SHARE) * WALK_SHARE / 2.0).abs() < 1e-6);
        assert_eq!(Strategies::uniform(1..=6, false, false).log_table()[0], -1e30);
        assert_eq!(Strategies::seeks(6).log_table()[0], 0.0);
    }

    #[test]
    fn adaptation_keeps_every_strategy_and_sums_to_one() {
        let start = Strategies::uniform(1..=6, false, true);
        let pilot = start.systematic(4096, 0.5).into_iter().map(|s| (s, f64::from(u8::from(s == [3, 1])), 4.0));
        let adapted = start.adapted(pilot, &start);
        assert!((adapted.cumulative.last().unwrap() - 1.0).abs() < 1e-12);
        assert!(adapted.entries.iter().all(|(_, p)| *p > 0.0));
        let best = adapted.entries.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert_eq!(best.0, [3, 1]);
    }
}
