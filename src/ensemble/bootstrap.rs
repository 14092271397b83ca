//! The start: b and the seeds, from bidirectional candidates (METHOD.md 1.2, 1.3).

use super::groups::Groups;
use super::pool::TypeKey;
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
    rays: f32,
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
    pass_index: u32,
    list: Vec<[u32; 2]>,
    candidates: Vec<Candidate>,
}

impl Draw {
    fn is_done(&self) -> bool {
        self.candidates.len() == self.list.len()
    }
}

/// A start on its way: first the pilots' candidates, then those that count.
pub struct Starting {
    strategies: Strategies,
    pixel_weights: Option<PixelWeights>,
    rays: u64,
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
        let before = sum(&self.pilots[..self.round]) + self.draw.candidates.len() as f64;
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
        let draw = self.draw(run, &strategies, pilots[0], PILOT_PASSES[0]);
        Starting { strategies, pixel_weights: None, rays: 0, candidates: self.candidates, pilots, round: 0, draw }
    }

    /// Strategies before anything is known.
    fn even(&self) -> Strategies {
        Strategies::uniform(self.min_edges..=self.max_edges, self.features.sky && !self.features.mixed)
    }

    /// Makes one batch of candidates; whether more are to be made.
    pub fn step(&self, run: &mut Run, starting: &mut Starting) -> crate::Result<bool> {
        self.batch(run, &mut starting.draw)?;
        if starting.round < starting.pilots.len() && starting.draw.is_done() {
            let Draw { list, candidates: pilot, .. } = &starting.draw;
            starting.rays += rays(pilot);
            starting.strategies = starting.strategies.adapted(
                list.iter()
                    .zip(pilot)
                    .zip(waited_for(pilot))
                    .map(|((strategy, candidate), rays)| (*strategy, candidate.weight(), rays)),
                &self.even(),
            );
            starting.pixel_weights = self.two_stage.map(|gamma| {
                let splats: Vec<_> = pilot.iter().map(|candidate| (candidate.pixel, candidate.weight())).collect();
                PixelWeights::from_pilot(self.film, gamma, &splats)
            });
            starting.round += 1;
            starting.draw = match starting.pilots.get(starting.round) {
                Some(count) => self.draw(run, &starting.strategies, *count, PILOT_PASSES[starting.round]),
                None => self.draw(run, &starting.strategies, self.candidates, CANDIDATE_PASS),
            };
        }
        Ok(!starting.is_done())
    }

    /// Chooses the seeds among the candidates, once all are made, and fills the chains.
    pub fn finish(&self, run: &mut Run, starting: Starting) -> crate::Result<Option<Bootstrap>> {
        assert!(starting.is_done(), "candidates are missing");
        let Starting { strategies, pixel_weights, draw: Draw { list, candidates, .. }, .. } = starting;
        let rays = starting.rays + rays(&candidates);
        let mut b = Mean::default();
        candidates.iter().for_each(|candidate| b.add(candidate.weight()));
        if b.sum <= 0.0 {
            return Ok(None);
        }
        let counts = |pixel| pixel_weights.as_ref().map_or(1.0, |w| w.at(pixel));
        let weights: Vec<f64> = candidates.iter().map(|c| c.weight() / counts(c.pixel)).collect();
        let mut target = Mean::default();
        weights.iter().for_each(|w| target.add(*w));
        let non_finite = candidates.iter().filter(|c| !f64::from(c.log_weight).exp().is_finite()).count();
        let largest_share = weights.iter().copied().fold(0.0, f64::max) / target.sum;
        let types = TypeShares::of_start(candidates.iter().map(|c| c.key).zip(weights.iter().copied()));
        let (chosen, shared) = self.choose(&candidates, &weights);
        self.fill(run, &list, &chosen)?;
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
        let mut draw = self.draw(run, strategies, count, pass_index);
        while !draw.is_done() {
            self.batch(run, &mut draw)?;
        }
        Ok((draw.candidates, draw.list))
    }

    fn draw(&self, run: &Run, strategies: &Strategies, count: u32, pass_index: u32) -> Draw {
        run.set_strategies(&strategies.log_table());
        let offset = rng::uniform(rng::random_words(self.seed, 0, pass_index, u32::MAX)[0]);
        let list = strategies.systematic(count, offset);
        Draw { pass_index, list, candidates: Vec::with_capacity(count as usize) }
    }

    fn batch(&self, run: &mut Run, draw: &mut Draw) -> crate::Result<()> {
        let first = draw.candidates.len() as u32;
        let entries = BATCH.min(draw.list.len() as u32 - first);
        let words: Vec<u32> =
            (first..first + entries).flat_map(|i| [draw.list[i as usize][0], draw.list[i as usize][1], i]).collect();
        run.set_lists(&words);
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
        draw.candidates.extend_from_slice(bytemuck::cast_slice(&bytes));
        Ok(())
    }

    /// Seeds of both halves: candidates drawn with probability proportional to weight by systematic resampling along a
    /// Hilbert curve over the film. Every half of every group draws from candidates of its own (METHOD.md 1.3 c), every so
    /// many of the list, which is sorted by strategy: each has its share of all strategies.
    /// With the seeds comes whether that could not be done: where hardly any candidates carry light, groups share them.
    fn choose(&self, candidates: &[Candidate], weights: &[f64]) -> (Vec<u32>, bool) {
        let side = self.film[0].max(self.film[1]).next_power_of_two();
        let seeds = self.groups.group_paths();
        // In the order of paths: the groups of the first half, then those of the second.
        let mut pools: Vec<Vec<(u64, u32)>> = vec![Vec::new(); 2 * self.groups.count() as usize];
        let count = pools.len();
        for (i, candidate) in candidates.iter().enumerate().filter(|(i, _)| weights[*i] > 0.0) {
            let [x, y] = candidate.pixel.map(|p| p.max(0.0) as u32);
            pools[i % count].push((hilbert_index(side, x.min(side - 1), y.min(side - 1)), i as u32));
        }
        let mut chosen = Vec::with_capacity(self.groups.paths() as usize);
        let mut shared = false;
        for (subset, mut pool) in (0..).zip(pools) {
            if pool.is_empty() {
                shared = true;
                pool = (0..candidates.len() as u32).filter(|&i| weights[i as usize] > 0.0).map(|i| (0, i)).collect();
            }
            pool.sort_unstable();
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
                chosen.push(pool[member].1);
            }
        }
        (chosen, shared)
    }

    /// Makes the chosen candidates again, into the chains from the first on.
    pub fn fill(&self, run: &mut Run, list: &[[u32; 2]], chosen: &[u32]) -> crate::Result<()> {
        let words: Vec<u32> = chosen.iter().flat_map(|&i| [list[i as usize][0], list[i as usize][1], i]).collect();
        run.set_lists(&words);
        let variant = variant(self.features, self.min_edges, self.max_edges);
        let uniform = PassUniform {
            entries: chosen.len() as u32,
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
