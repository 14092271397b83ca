//! The crossover's part of a half-sweep: it moves both halves, the frozen one between two spells of being frozen.

use super::{Ensemble, counters_of};
use crate::Result;
use crate::ensemble::crossings::{PairList, Partners};
use crate::gpu::layout::PassUniform;
use crate::gpu::run::{Dispatch, Run};
use crate::reference::rng;

/// Whose random numbers give the partners (of the first group; the others' follow below), and their dimension block: no
/// path's.
const PARTNERS: (u32, u32) = (u32::MAX, 0xfffd);

impl Ensemble {
    /// One crossover of every path of `half` with one of the other half, which is frozen anew after it (METHOD.md C6d).
    /// The caller takes the pool of `half` again.
    pub(super) fn crossover(&mut self, run: &mut Run, half: usize, kernel: usize) -> Result<()> {
        let random = |path, dimension| rng::random_words(self.build.seed, path, self.pass_index, dimension);
        let groups = (0..self.build.groups.count()).map(|group| Partners {
            halves: [half, 1 - half].map(|h| &self.halves[h][group as usize].pool),
            first: [half, 1 - half].map(|h| self.build.groups.first(h, group)),
            shift: random(PARTNERS.0 - group, PARTNERS.1)[0],
        });
        let list = PairList::draw(groups, random, self.build.direct.min_edges()..=self.build.max_edges);
        run.set_lists(&list.words);
        let pairs = list.pairs.len() as u32;
        let base =
            PassUniform { pass_index: self.pass_index, counters_offset: counters_of(kernel), ..self.build.uniform() };
        let dispatches = [
            ("crossover", PassUniform { entries: 2 * pairs, ..base }),
            ("exchange", PassUniform { entries: pairs, ..base }),
            ("rest", PassUniform { entries: list.resting, entries_offset: list.resting_offset, weight: 1.0, ..base }),
        ];
        let dispatches: Vec<Dispatch> = dispatches
            .into_iter()
            .filter(|(_, uniform)| uniform.entries > 0)
            .map(|(pass, uniform)| Dispatch { variant: self.build.variant(pass, &[]), uniform })
            .collect();
        // A mutation of either path; without a crossing, one that fails at once.
        self.tallies[kernel].mutations += 2 * u64::from(self.build.groups.half_paths());
        self.pass_index += 1;
        run.submit_timed(&dispatches)?;
        self.regroup(run, 1 - half, false)?;
        self.freeze(run, 1 - half)
    }
}
