//! What the host does beside the device: what is seen of the chains once in each half-sweep, after its first mutation,
//! and what can be drawn before its time.

use std::mem;

use rayon::prelude::*;

use super::Ensemble;
use crate::Result;
use crate::ensemble::mixing::{MixingStatistics, Seen};
use crate::ensemble::runs::merged;
use crate::gpu::layout::{ROW_PIXEL, ROW_VERTICES};
use crate::gpu::run::Run;
use crate::reference::rng;

/// Dimension block from which the host draws the independence kernel's strategy.
const DIMENSION_STRATEGY: u32 = 0xffff;

/// Host work that nothing on the device waits for.
#[derive(Default)]
pub(super) struct Chores {
    /// Of b and of the target's integral, by group and path.
    pub(super) samples: Vec<Vec<[f64; 2]>>,
    pub(super) seen: Vec<Seen>,
    /// Strategies of the independence mutation that is pass so-and-so.
    pub(super) drawn: Option<(u32, Vec<[u32; 2]>)>,
}

impl Ensemble {
    /// Looks at a half. Log I is that of the states as they are: the pass `weigh` has just made it, or the independence
    /// kernel with the state.
    pub(super) fn look(&self, run: &mut Run, half: usize) -> Result<Vec<Seen>> {
        self.look_at_keys(run, half, &[ROW_PIXEL, ROW_VERTICES], |keys, rows| {
            let (pixels, vertices) = rows.split_at(keys.len());
            let seen = |i: usize| Seen {
                key: keys.get(i).expect("the half was grouped by its keys"),
                log_i: f32::from_bits(vertices[i][3]),
                waited: pixels[i][3],
            };
            (0..keys.len()).into_par_iter().map(seen).collect()
        })
    }

    /// What nothing on the device waits for, while it perturbs `half`: sums, and the other half's next strategies.
    pub(super) fn do_chores(&mut self, half: usize) {
        // One after another, so that rounding does not depend on threads.
        for [of_b, of_target] in self.chores.samples.drain(..).flatten() {
            self.b.add(of_b);
            self.target.add(of_target);
        }
        self.mixing.observe(half, &mem::take(&mut self.chores.seen));
        self.chores.drawn = Some((self.pass_index, self.draw_strategies(1 - half)));
    }

    /// The strategies of a half's next independence mutation by path, sorted. They are drawn here, from each path's own
    /// random numbers, only so that the list can be sorted by them.
    pub(super) fn draw_strategies(&self, half: usize) -> Vec<[u32; 2]> {
        let drawn = |entry: &[u32; 2]| (entry[1] & 0xffff, entry[1] >> 16);
        let groups = self.build.groups;
        let of_group = |group: u32| {
            let first = groups.first(half, group);
            let mut entries: Vec<[u32; 2]> = (first..first + groups.group_paths())
                .map(|path| {
                    let words = rng::random_words(self.build.seed, path, self.pass_index, DIMENSION_STRATEGY);
                    let [edges, light] = self.bootstrap.strategies.pick(rng::uniform(words[0]));
                    [path, edges | light << 16]
                })
                .collect();
            entries.sort_by_key(drawn);
            entries
        };
        let by_group: Vec<_> = (0..groups.count()).into_par_iter().map(of_group).collect();
        merged(&by_group, drawn)
    }

    /// How well the chains mix, on a film of so many pixels.
    pub fn mixing(&self, pixels: u64) -> MixingStatistics {
        let longest = self.tallies.iter().chain([&self.rest]).map(|tally| tally.longest_wait).max().unwrap_or(0);
        let mutations = self.mutations() as f64 / f64::from(self.build.groups.paths());
        self.mixing.statistics(mutations, u64::from(longest), pixels)
    }
}
