//! Candidates on their way, and what has been made.

use rayon::prelude::*;

use super::{Given, ROUND};
use crate::ensemble::candidate::{Candidate, Mean, weight};
use crate::ensemble::seeds::Lit;
use crate::ensemble::strategies::Strategies;

/// Candidates on their way, a batch at a time.
pub(super) struct Draw {
    pub strategies: Strategies,
    pub given: Given,
    pub pass_index: u32,
    /// Of the systematic draw of strategies.
    pub offset: f64,
    pub count: u32,
    /// After so many all strategies have had their share, and it begins anew.
    pub round: u32,
    pub made: u32,
    pub batch: Vec<Candidate>,
}

impl Draw {
    /// The same in rounds that are alike; a few candidates fewer where they cannot share them evenly.
    pub fn in_rounds(mut self) -> Self {
        self.round = self.count / (self.count / ROUND).max(1);
        self.count -= self.count % self.round.max(1);
        self
    }

    pub fn is_done(&self) -> bool {
        self.made == self.count
    }

    /// The strategy of candidate `i`.
    pub fn strategy(&self, i: u32) -> [u32; 2] {
        self.strategies.systematic_at(i % self.round.max(1), self.round, self.offset)
    }
}

/// What has been made: of a pilot everything, of those that count only what carries light.
#[derive(Default)]
pub(super) struct Made {
    pub pilot: Vec<Candidate>,
    pub lit: Vec<Lit>,
    pub b: Mean,
    pub rays: u64,
    pub non_finite: usize,
}

impl Made {
    pub fn count(&mut self, first: u32, batch: &[Candidate]) {
        let lit = |(i, candidate): (usize, &Candidate)| {
            let Candidate { log_weight, pixel, key, .. } = *candidate;
            (candidate.weight() > 0.0).then_some(Lit { index: first + i as u32, log_weight, pixel, key })
        };
        let begin = self.lit.len();
        self.lit.par_extend(batch.par_iter().enumerate().filter_map(lit));
        self.lit[begin..].iter().for_each(|lit| self.b.add(weight(lit.log_weight.into())));
        // The others add nothing but their number.
        self.b.count += (batch.len() - (self.lit.len() - begin)) as f64;
        self.non_finite += batch.iter().filter(|c| !f64::from(c.log_weight).exp().is_finite()).count();
    }
}
