//! What is seen of the chains once in each half-sweep, after its first mutation.

use rayon::prelude::*;

use super::Ensemble;
use crate::Result;
use crate::ensemble::mixing::{MixingStatistics, Seen};
use crate::ensemble::pool::TypeKey;
use crate::gpu::layout::{ROW_KEY, ROW_PIXEL, ROW_VERTICES};
use crate::gpu::run::{Buffer, Run};

impl Ensemble {
    /// Looks at a half. Log I is that of the states as they are: the pass `weigh` has just made it, or the independence
    /// kernel with the state.
    pub(super) fn observe(&mut self, run: &mut Run, half: usize) -> Result<()> {
        let ranges = self.ranges_of(half, &[ROW_KEY, ROW_PIXEL, ROW_VERTICES]);
        let mixing = &mut self.mixing;
        run.look_at(Buffer::Chains, &ranges, |bytes| {
            let rows: &[[u32; 4]] = bytemuck::cast_slice(bytes);
            let (keys, rows) = rows.split_at(rows.len() / 3);
            let (pixels, vertices) = rows.split_at(rows.len() / 2);
            let seen = |i: usize| {
                let key = TypeKey::from_words([keys[i][0], keys[i][1]]);
                Seen {
                    key: key.expect("the half was grouped by its keys"),
                    log_i: f32::from_bits(vertices[i][3]),
                    waited: pixels[i][3],
                }
            };
            mixing.observe(half, &(0..keys.len()).into_par_iter().map(seen).collect::<Vec<_>>());
        })
    }

    /// How well the chains mix, on a film of so many pixels.
    pub fn mixing(&self, pixels: u64) -> MixingStatistics {
        let longest = self.tallies.iter().chain([&self.rest]).map(|tally| tally.longest_wait).max().unwrap_or(0);
        let mutations = self.mutations() as f64 / f64::from(self.build.groups.paths());
        self.mixing.statistics(mutations, u64::from(longest), pixels)
    }
}
