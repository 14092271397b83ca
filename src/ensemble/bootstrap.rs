//! The start: b and the seeds, from bidirectional candidates (METHOD.md 1.2, 1.3).

use std::mem;

use rayon::prelude::*;

use super::groups::Groups;
use super::pool::TypeKey;
use super::seeds::Lit;
use super::strategies::{INDIRECT_EDGES, Strategies};
use super::two_stage::PixelWeights;
use super::type_shares::TypeShares;
use crate::gpu::layout::PassUniform;
use crate::gpu::run::{Buffer, Dispatch, Run};
use crate::gpu::shader::Variant;
use crate::reference::rng;
use crate::scene::Features;

/// Candidates from which b and the seeds come, unless told otherwise.
pub const CANDIDATES: u32 = 1 << 20;
/// Candidates of the two rounds from which the strategies' probabilities are set before; neither b nor the start uses them
/// again.
const PILOTS: [u32; 2] = [1 << 15, 1 << 15];
/// The same where the second round also sets w of a two-stage target: it has to tell every part of the film, and one
/// candidate in a hundred carries light in some scenes.
const TWO_STAGE_PILOTS: [u32; 2] = [1 << 15, 1 << 17];
/// Candidates a dispatch.
pub const BATCH: u32 = 1 << 16;
/// Invocations that wait for the slowest among them: the lanes of a processor's vectors. GPUs have 32 and more.
const LOCKSTEP: usize = 8;
/// Words of `lists` a candidate takes.
pub const LIST_WORDS: u32 = 3;
/// Pass indices of the pilot and of the candidates: apart from those of mutations, which count up from 0.
const PILOT_PASSES: [u32; 2] = [0x8000_0000, 0x8000_0002];
pub const CANDIDATE_PASS: u32 = 0x8000_0001;

/// Running mean of independent samples of b, with the scatter that gives its standard error.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    pub count: f64,
    pub sum: f64,
    pub sum_of_squares: f64,
}

impl Mean {
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.sum_of_squares += value * value;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        let variance = (self.sum_of_squares / self.count.max(1.0) - self.mean().powi(2)).max(0.0);
        (variance / (self.count - 1.0).max(1.0)).sqrt()
    }
}

/// One candidate as the device reports it.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Candidate {
    /// log(I / density), -1e30 where I = 0.
    pub log_weight: f32,
    pub pixel: [f32; 2],
    pub rays: f32,
    /// Of a candidate that carries light.
    key: [u32; 4],
}

/// From the log of a weight to the weight; what is not finite counts as black.
pub(super) fn weight(log_weight: f64) -> f64 {
    let w = log_weight.exp();
    if w.is_finite() { w } else { 0.0 }
}

/// Bytes of the output buffer that a batch needs.
pub const BATCH_BYTES: u64 = BATCH as u64 * size_of::<Candidate>() as u64;

impl Candidate {
    /// Type of a candidate that carries light.
    pub fn key(&self) -> Option<TypeKey> {
        TypeKey::from_words(self.key)
    }

    /// I / density: a sample of b.
    pub fn weight(&self) -> f64 {
        weight(self.log_weight.into())
    }
}

/// What the start leaves: the paths themselves are in the chains.
pub struct Bootstrap {
    pub strategies: Strategies,
    pub b: Mean,
    /// The integral of the chains' target: of I / w where that is two-stage, else b.
    pub target: Mean,
    /// w of a two-stage target.
    pub pixel_weights: Option<PixelWeights>,
    pub rays: u64,
    /// Largest share of one candidate in what the seeds are drawn by: above 1/100 the seeds are many copies of one path.
    pub largest_share: f64,
    /// Candidates whose weight is not finite.
    pub non_finite: usize,
    /// Whether groups share candidates, of which hardly any carry light.
    pub shared: bool,
    /// How the target is shared among types of paths, as the candidates have it.
    pub types: TypeShares,
}

/// The part of a run's set-up that the start needs.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    pub features: Features,
    /// 1, or [`INDIRECT_EDGES`] where direct light is made apart.
    pub min_edges: u32,
    pub max_edges: u32,
    /// Exponent of a two-stage target.
    pub two_stage: Option<f64>,
    /// Candidates that count, the pilots' not among them.
    pub candidates: u32,
    pub seed: u32,
    pub groups: Groups,
    /// Columns of the chains, at least as many as paths.
    pub stride: u32,
    pub film: [u32; 2],
}

/// Candidates on their way, a batch at a time.
struct Draw {
    strategies: Strategies,
    pass_index: u32,
    /// Of the systematic draw of strategies.
    offset: f64,
    count: u32,
    made: u32,
    batch: Vec<Candidate>,
}

impl Draw {
    fn is_done(&self) -> bool {
        self.made == self.count
    }

    /// The strategy of candidate `i`.
    fn strategy(&self, i: u32) -> [u32; 2] {
        self.strategies.systematic_at(i, self.count, self.offset)
    }
}

/// What has been made: of a pilot everything, of those that count only what carries light.
#[derive(Default)]
struct Made {
    pilot: Vec<Candidate>,
    lit: Vec<Lit>,
    b: Mean,
    rays: u64,
    non_finite: usize,
}

impl Made {
    fn count(&mut self, first: u32, batch: &[Candidate]) {
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

/// A start on its way: first the pilots' candidates, then those that count.
pub struct Starting {
    pixel_weights: Option<PixelWeights>,
    made: Made,
    /// That count.
    candidates: u32,
    /// Candidates of each pilot: no more than those that count.
    pilots: [u32; 2],
    /// Pilots that are done with.
    round: usize,
    draw: Draw,
}

impl Starting {
    /// Share of the candidates that are made, in [0, 1].
    pub fn share(&self) -> f64 {
        let sum = |counts: &[u32]| f64::from(counts.iter().sum::<u32>());
        let before = sum(&self.pilots[..self.round]) + f64::from(self.draw.made);
        before / (sum(&self.pilots) + f64::from(self.candidates))
    }

    fn is_done(&self) -> bool {
        self.round == self.pilots.len() && self.draw.is_done()
    }
}

/// Per candidate, the rays of the slowest one among those that run in lockstep with it.
fn waited_for(candidates: &[Candidate]) -> impl Iterator<Item = f64> + '_ {
    candidates.chunks(LOCKSTEP).flat_map(|group| {
        let slowest = group.iter().map(|c| c.rays).fold(0.0, f32::max);
        group.iter().map(move |_| f64::from(slowest))
    })
}

/// The pipeline of the start.
pub fn variant(features: Features, min_edges: u32, max_edges: u32) -> Variant {
    let flags = if min_edges == INDIRECT_EDGES { vec!["indirect"] } else { vec![] };
    Variant { pass: "bootstrap", features, max_edges, flags }
}

impl Start {
    /// Estimates b and fills the chains of `run`; its output buffer is left with candidates in it. `None` where no
    /// candidate carries light.
    pub fn run(&self, run: &mut Run) -> crate::Result<Option<Bootstrap>> {
        let mut starting = self.begin(run);
        while self.step(run, &mut starting)? {}
        self.finish(run, starting)
    }

    /// Begins what [`Self::run`] does at once; nothing is made yet.
    pub fn begin(&self, run: &Run) -> Starting {
        let strategies = self.even();
        let pilots = if self.two_stage.is_some_and(|gamma| gamma > 0.0) { TWO_STAGE_PILOTS } else { PILOTS };
        let pilots = pilots.map(|count| count.min(self.candidates));
        let draw = self.draw(run, strategies, pilots[0], PILOT_PASSES[0]);
        Starting { pixel_weights: None, made: Made::default(), candidates: self.candidates, pilots, round: 0, draw }
    }

    /// Strategies before anything is known.
    fn even(&self) -> Strategies {
        Strategies::uniform(self.min_edges..=self.max_edges, self.features.sky && !self.features.mixed)
    }

    /// Makes one batch of candidates; whether more are to be made.
    pub fn step(&self, run: &mut Run, starting: &mut Starting) -> crate::Result<bool> {
        let Starting { made, draw, round, pilots, .. } = starting;
        let first = draw.made;
        self.batch(run, draw)?;
        made.rays += rays(&draw.batch);
        if *round == pilots.len() {
            made.count(first, &draw.batch);
            return Ok(!starting.is_done());
        }
        made.pilot.extend_from_slice(&draw.batch);
        if draw.is_done() {
            let pilot = mem::take(&mut made.pilot);
            let drawn = (0..).zip(&pilot).zip(waited_for(&pilot));
            let strategies = draw.strategies.adapted(
                drawn.map(|((i, candidate), rays)| (draw.strategy(i), candidate.weight(), rays)),
                &self.even(),
            );
            starting.pixel_weights = self.two_stage.map(|gamma| {
                let splats: Vec<_> = pilot.iter().map(|candidate| (candidate.pixel, candidate.weight())).collect();
                PixelWeights::from_pilot(self.film, gamma, &splats)
            });
            *round += 1;
            *draw = match pilots.get(*round) {
                Some(count) => self.draw(run, strategies, *count, PILOT_PASSES[*round]),
                None => self.draw(run, strategies, starting.candidates, CANDIDATE_PASS),
            };
        }
        Ok(true)
    }

    /// Chooses the seeds among the candidates, once all are made, and fills the chains.
    pub fn finish(&self, run: &mut Run, starting: Starting) -> crate::Result<Option<Bootstrap>> {
        assert!(starting.is_done(), "candidates are missing");
        let Starting { pixel_weights, made: Made { lit, b, rays, non_finite, .. }, draw, .. } = starting;
        if b.sum <= 0.0 {
            return Ok(None);
        }
        let counts = |pixel| pixel_weights.as_ref().map_or(1.0, |w| w.at(pixel));
        let in_target = |lit: &Lit| weight(lit.log_weight.into()) / counts(lit.pixel);
        let weights: Vec<f64> = lit.par_iter().map(in_target).collect();
        let mut target = Mean { count: b.count - lit.len() as f64, ..Mean::default() };
        weights.iter().for_each(|w| target.add(*w));
        let largest_share = weights.iter().copied().fold(0.0, f64::max) / target.sum;
        let types = TypeShares::of_start(lit.iter().map(|lit| lit.key).zip(weights.iter().copied()));
        let (chosen, shared) = self.choose(&lit, &weights);
        self.fill_with(run, chosen.iter().map(|&i| (draw.strategy(i), i)))?;
        let strategies = draw.strategies;
        Ok(Some(Bootstrap { strategies, b, target, pixel_weights, rays, largest_share, non_finite, shared, types }))
    }

    /// Makes `count` candidates, with their strategies; systematic over strategies, so neighbours share one.
    pub fn candidates(
        &self,
        run: &mut Run,
        strategies: &Strategies,
        count: u32,
        pass_index: u32,
    ) -> crate::Result<(Vec<Candidate>, Vec<[u32; 2]>)> {
        let mut draw = self.draw(run, strategies.clone(), count, pass_index);
        let mut candidates = Vec::with_capacity(count as usize);
        while !draw.is_done() {
            self.batch(run, &mut draw)?;
            candidates.extend_from_slice(&draw.batch);
        }
        let strategies = (0..count).map(|i| draw.strategy(i)).collect();
        Ok((candidates, strategies))
    }

    fn draw(&self, run: &Run, strategies: Strategies, count: u32, pass_index: u32) -> Draw {
        run.set_strategies(&strategies.log_table());
        let offset = rng::uniform(rng::random_words(self.seed, 0, pass_index, u32::MAX)[0]);
        Draw { strategies, pass_index, offset, count, made: 0, batch: Vec::new() }
    }

    fn batch(&self, run: &mut Run, draw: &mut Draw) -> crate::Result<()> {
        let first = draw.made;
        let entries = BATCH.min(draw.count - first);
        let words: Vec<[u32; 3]> = (first..first + entries)
            .into_par_iter()
            .map(|i| {
                let [edges, light] = draw.strategy(i);
                [edges, light, i]
            })
            .collect();
        run.set_lists(words.as_flattened());
        let variant = variant(self.features, self.min_edges, self.max_edges);
        let uniform = PassUniform {
            entries,
            pass_index: draw.pass_index,
            seed: self.seed,
            stride: self.stride,
            ..Default::default()
        };
        run.submit(&[Dispatch { variant, uniform }])?;
        let bytes = run.read(Buffer::Output, 0..size_of::<Candidate>() as u64 * u64::from(entries))?;
        draw.batch = bytemuck::cast_slice(&bytes).to_vec();
        draw.made += entries;
        Ok(())
    }

    /// Makes the chosen candidates again, into the chains from the first on.
    pub fn fill(&self, run: &mut Run, list: &[[u32; 2]], chosen: &[u32]) -> crate::Result<()> {
        self.fill_with(run, chosen.iter().map(|&i| (list[i as usize], i)))
    }

    /// The same of candidates given by strategy and number.
    fn fill_with(&self, run: &mut Run, chosen: impl Iterator<Item = ([u32; 2], u32)>) -> crate::Result<()> {
        let words: Vec<[u32; 3]> = chosen.map(|([edges, light], i)| [edges, light, i]).collect();
        run.set_lists(words.as_flattened());
        let variant = variant(self.features, self.min_edges, self.max_edges);
        let uniform = PassUniform {
            entries: words.len() as u32,
            pass_index: CANDIDATE_PASS,
            keep: 1,
            seed: self.seed,
            stride: self.stride,
            ..Default::default()
        };
        run.submit(&[Dispatch { variant, uniform }])
    }
}

/// Rays that candidates took, all together.
fn rays(candidates: &[Candidate]) -> u64 {
    candidates.iter().map(|c| c.rays as u64).sum()
}
