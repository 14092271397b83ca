//! What the kernels of a run have done, as the device counts it.

use super::{Ensemble, counters_of};
use crate::Result;
use crate::gpu::layout::{
    COUNTER_ACCEPTED, COUNTER_JUMP_HIGH, COUNTER_JUMP_LOW, COUNTER_LONGEST_WAIT, COUNTER_NON_FINITE, COUNTER_RAYS,
    COUNTER_WORDS, JUMP_SCALE, counter_bytes,
};
use crate::gpu::run::{Buffer, Run};
use crate::report::statistics::KernelStatistics;

/// Counts of one kernel over the run.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) mutations: u64,
    accepted: u64,
    non_finite: u64,
    rays: u64,
    /// On the device's clock, where it has one.
    seconds: f64,
    jump_px2: f64,
    /// The most mutations that a path had waited for a move when this kernel was the last that failed.
    pub(super) longest_wait: u32,
}

impl Ensemble {
    /// Adds the device's counters to the tallies and clears them.
    pub(super) fn tally(&mut self, run: &mut Run) -> Result<()> {
        let words: Vec<u32> = run.read(Buffer::Counters, 0..counter_bytes(self.tallies.len()))?;
        run.clear(Buffer::Counters);
        let seconds = run.times()?;
        let tallies = self.tallies.iter_mut().chain([&mut self.rest]);
        for (kernel, (tally, words)) in tallies.zip(words.chunks_exact(COUNTER_WORDS)).enumerate() {
            tally.accepted += u64::from(words[COUNTER_ACCEPTED]);
            tally.non_finite += u64::from(words[COUNTER_NON_FINITE]);
            tally.rays += u64::from(words[COUNTER_RAYS]);
            let jump = f64::from(words[COUNTER_JUMP_LOW]) + f64::from(words[COUNTER_JUMP_HIGH]) * 2f64.powi(32);
            tally.jump_px2 += jump / JUMP_SCALE;
            tally.seconds += seconds.get(&counters_of(kernel)).unwrap_or(&0.0);
            tally.longest_wait = tally.longest_wait.max(words[COUNTER_LONGEST_WAIT]);
        }
        Ok(())
    }

    /// Rays of the start and of all mutations.
    pub fn rays(&self) -> u64 {
        self.bootstrap.rays + self.tallies.iter().map(|t| t.rays).sum::<u64>()
    }

    /// Counts per kernel.
    pub fn kernel_statistics(&self) -> Vec<KernelStatistics> {
        let mut statistics: Vec<KernelStatistics> = self
            .mix
            .kernels()
            .zip(&self.tallies)
            .map(|(kernel, tally)| KernelStatistics {
                name: kernel.name.into(),
                mutations: tally.mutations,
                accepted: tally.accepted,
                non_finite: tally.non_finite,
                mean_squared_jump_px2: tally.jump_px2 / tally.mutations.max(1) as f64,
                device_s: (tally.seconds > 0.0).then_some(tally.seconds),
            })
            .collect();
        if self.rest.mutations > 0 {
            let name = "(none applies)".into();
            statistics.push(KernelStatistics { name, mutations: self.rest.mutations, ..Default::default() });
        }
        statistics
    }
}
