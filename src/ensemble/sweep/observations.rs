//! What is seen of the chains once in each half-sweep, after its first mutation.

use super::Ensemble;
use super::keys::KeyRow;
use crate::Result;
use crate::ensemble::mixing::{MixingStatistics, Seen};
use crate::gpu::layout::{ROW_PIXEL, ROW_VERTICES};
use crate::gpu::run::Run;

impl Ensemble {
    /// Looks at a half whose key rows are given. Log I is that of the states as they are: the pass `weigh` has just made
    /// it, or the independence kernel with the state.
    pub(super) fn observe(&mut self, run: &mut Run, half: usize, keys: &[KeyRow]) -> Result<()> {
        let rows = self.read_rows(run, half, &[ROW_PIXEL, ROW_VERTICES])?;
        let (pixels, vertices) = rows.split_at(keys.len());
        let seen: Vec<Seen> = keys
            .iter()
            .zip(pixels.iter().zip(vertices))
            .map(|(row, (pixel, vertex))| Seen { key: row.key, log_i: f32::from_bits(vertex[3]), waited: pixel[3] })
            .collect();
        self.mixing.observe(half, &seen);
        Ok(())
    }

    /// How well the chains mix, on a film of so many pixels.
    pub fn mixing(&self, pixels: u64) -> MixingStatistics {
        let longest = self.tallies.iter().chain([&self.rest]).map(|tally| tally.longest_wait).max().unwrap_or(0);
        let mutations = self.mutations() as f64 / f64::from(self.build.groups.paths());
        self.mixing.statistics(mutations, u64::from(longest), pixels)
    }
}
