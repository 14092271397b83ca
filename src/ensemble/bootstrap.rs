//! The start: b and the seeds, from bidirectional candidates (METHOD.md 1.2, 1.3).

mod draw;

use std::mem;

use rayon::prelude::*;

pub use super::candidate::{Candidate, Mean};
use super::candidate::{rays, waited_for, weight};
use super::groups::Groups;
use super::path_traced::{Direct, Easy, PathTraced};
use super::photons;
use super::seeds::Lit;
use super::sightings::{self, Sighting};
use super::strategies::Strategies;
use super::two_stage::PixelWeights;
use super::type_shares::TypeShares;
use crate::gpu::layout::PassUniform;
use crate::gpu::run::{Buffer, Dispatch, Run};
use crate::gpu::shader::Variant;
use crate::reference::rng;
use crate::scene::Features;
use draw::{Draw, Made};

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
/// Candidates of a round, about: each has its share of all strategies, so that a start may end after any.
const ROUND: u32 = 1 << 17;
/// Rows that the maps take: of photons, then of sightings.
pub const MAPS_ROWS: u64 = photons::MOST_ROWS + sightings::ROWS;
/// Bytes of the output buffer that a batch needs.
pub const BATCH_BYTES: u64 = BATCH as u64 * size_of::<Candidate>() as u64;
/// Words of `lists` a candidate takes.
pub const LIST_WORDS: u32 = 3;
/// The path tracer's share of the time after the start where it has direct light alone.
const DIRECT_TIME_SHARE: f64 = 0.15;
/// Pass indices of the pilot and of the candidates: apart from those of mutations, which count up from 0.
const PILOT_PASSES: [u32; 2] = [0x8000_0000, 0x8000_0002];
pub const CANDIDATE_PASS: u32 = 0x8000_0001;

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
    /// Who renders easy light.
    pub direct: Direct,
    /// Row of the chains' buffer at which maps of where to look for light are to be laid, where they may help.
    pub maps_row: Option<u32>,
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

/// What a start finds out first, on which candidates and chains depend ever after.
#[derive(Debug, Clone, Copy, Default)]
pub struct Given {
    /// What is left to the path tracer, and so has no candidates.
    pub path_traced: PathTraced,
    /// Row of the chains' buffer at which the map of photons begins, if there is one.
    pub photons: Option<u32>,
    /// Likewise the map of sightings.
    pub sightings: Option<u32>,
}

impl Given {
    /// Tells the shaders of a pass.
    pub fn set(self, uniform: PassUniform) -> PassUniform {
        let [photons_first, sightings_first] = [self.photons, self.sightings].map(|row| row.unwrap_or(0));
        PassUniform { photons_first, sightings_first, ..self.path_traced.set(uniform) }
    }
}

/// A start on its way: first the pilots' candidates, then those that count.
pub struct Starting {
    /// Maps that are still to be made.
    searches: Vec<Search>,
    /// Where lamps were seen through specular vertices.
    sightings: Vec<Sighting>,
    /// The path tracer's of the time after the start.
    time_share: f64,
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

    /// What is known of the light; all of it once the pilots are done.
    pub fn given(&self) -> Given {
        self.draw.given
    }

    /// The path tracer's share of the time after the start, where it has anything to do.
    pub fn time_share(&self) -> f64 {
        self.time_share
    }

    /// Ends with the round that is under way: what is made so far is enough.
    pub fn hurry(&mut self) {
        let Draw { round, made, count, .. } = &mut self.draw;
        if self.round == self.pilots.len() && *made > 0 {
            *count = (*count).min(made.next_multiple_of(*round));
        }
    }

    fn is_done(&self) -> bool {
        self.round == self.pilots.len() && self.draw.is_done()
    }
}

/// What is looked for before there are candidates.
#[derive(Debug, Clone, Copy)]
enum Search {
    Photons,
    Sightings,
}

/// The pipeline of the start.
pub fn variant(features: Features, direct: Direct, sought: bool, max_edges: u32) -> Variant {
    let flags = direct.flag().into_iter().chain(sought.then_some("sought")).collect();
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
        let strategies = self.even(self.given());
        let large = self.direct == Direct::Auto || self.two_stage.is_some_and(|gamma| gamma > 0.0);
        let pilots = if large { TWO_STAGE_PILOTS } else { PILOTS };
        let pilots = pilots.map(|count| count.min(self.candidates));
        let draw = self.draw(run, strategies, self.given(), pilots[0], PILOT_PASSES[0]);
        Starting {
            searches: if self.maps_row.is_some() { vec![Search::Sightings, Search::Photons] } else { Vec::new() },
            sightings: Vec::new(),
            time_share: DIRECT_TIME_SHARE,
            pixel_weights: None,
            made: Made::default(),
            candidates: self.candidates,
            pilots,
            round: 0,
            draw,
        }
    }

    /// Strategies before anything is known.
    fn even(&self, given: Given) -> Strategies {
        let sky = self.features.sky && !self.features.mixed;
        Strategies::uniform(self.direct.min_edges()..=self.max_edges, sky, given.sightings.is_some())
    }

    /// Makes one batch of candidates; whether more are to be made.
    pub fn step(&self, run: &mut Run, starting: &mut Starting) -> crate::Result<bool> {
        match starting.searches.pop() {
            Some(Search::Photons) => {
                starting.draw.given.photons = self.lay_photons(run)?;
                return Ok(true);
            }
            Some(Search::Sightings) => {
                starting.sightings = self.seek(run)?;
                let path_traced = starting.draw.given.path_traced;
                let sightings = self.lay_sightings(run, &starting.sightings, path_traced);
                let given = Given { sightings, ..starting.draw.given };
                starting.draw = self.draw(run, self.even(given), given, starting.pilots[0], PILOT_PASSES[0]);
                return Ok(true);
            }
            None => {}
        }
        if starting.is_done() {
            return Ok(false);
        }
        let Starting { made, draw, round, pilots, .. } = starting;
        let first = draw.made;
        self.batch(run, draw)?;
        made.rays += rays(&draw.batch);
        if *round == pilots.len() {
            made.count(first, &draw.batch);
        } else {
            made.pilot.extend_from_slice(&draw.batch);
            if draw.is_done() {
                self.end_pilot(run, starting);
            }
        }
        Ok(!starting.is_done())
    }

    /// Learns from a pilot, and begins what comes after it.
    fn end_pilot(&self, run: &Run, starting: &mut Starting) {
        let Starting { draw, round, pilots, .. } = starting;
        let pilot = mem::take(&mut starting.made.pilot);
        let path_traced = match self.direct {
            // Of the last pilot, which is the largest.
            Direct::Auto if *round + 1 == pilots.len() => {
                let easy = Easy::chosen(self.film, self.features, self.max_edges, &pilot);
                starting.time_share = easy.time_share;
                easy.path_traced
            }
            _ => draw.given.path_traced,
        };
        let even = self.even(draw.given);
        // Nothing is sought that is path traced.
        let sightings = self.lay_sightings(run, &starting.sightings, path_traced);
        let given = Given { path_traced, sightings, ..draw.given };
        let left = |candidate: &Candidate| {
            let own = candidate.key().is_some_and(|key| !path_traced.has(key));
            if own { candidate.weight() } else { 0.0 }
        };
        let drawn = (0..).zip(&pilot).zip(waited_for(&pilot));
        let drawn = drawn.map(|((i, candidate), rays)| (draw.strategy(i), left(candidate), rays));
        let strategies = draw.strategies.adapted(drawn, &even);
        starting.pixel_weights = self.two_stage.map(|gamma| {
            let splats: Vec<_> = pilot.iter().map(|candidate| (candidate.pixel, candidate.weight())).collect();
            PixelWeights::from_pilot(self.film, gamma, &splats)
        });
        *round += 1;
        if path_traced.is_all(self.max_edges) {
            // Nothing is left to start chains from.
            starting.candidates = 0;
        }
        *draw = match pilots.get(*round) {
            Some(count) => self.draw(run, strategies, given, *count, PILOT_PASSES[*round]),
            None => self.draw(run, strategies, given, starting.candidates, CANDIDATE_PASS).in_rounds(),
        };
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
        let (chosen, shared) = self.choose(&lit, &weights, draw.round);
        self.fill_with(run, draw.given, chosen.iter().map(|&i| (draw.strategy(i), i)))?;
        let strategies = draw.strategies;
        Ok(Some(Bootstrap { strategies, b, target, pixel_weights, rays, largest_share, non_finite, shared, types }))
    }

    /// Makes `count` candidates, with their strategies; systematic over strategies, so neighbours share one.
    pub fn candidates(
        &self,
        run: &mut Run,
        strategies: &Strategies,
        given: Given,
        count: u32,
        pass_index: u32,
    ) -> crate::Result<(Vec<Candidate>, Vec<[u32; 2]>)> {
        let mut draw = self.draw(run, strategies.clone(), given, count, pass_index);
        let mut candidates = Vec::with_capacity(count as usize);
        while !draw.is_done() {
            self.batch(run, &mut draw)?;
            candidates.extend_from_slice(&draw.batch);
        }
        let strategies = (0..draw.count).map(|i| draw.strategy(i)).collect();
        Ok((candidates, strategies))
    }

    fn draw(&self, run: &Run, strategies: Strategies, given: Given, count: u32, pass_index: u32) -> Draw {
        run.set_strategies(&strategies.log_table());
        let offset = rng::uniform(rng::random_words(self.seed, 0, pass_index, u32::MAX)[0]);
        let round = count;
        Draw { strategies, given, pass_index, offset, count, round, made: 0, batch: Vec::new() }
    }

    fn batch(&self, run: &mut Run, draw: &mut Draw) -> crate::Result<()> {
        let first = draw.made;
        // No further than the end of a round.
        let entries = BATCH.min(draw.round - first % draw.round.max(1)).min(draw.count - first);
        let words: Vec<[u32; 3]> = (first..first + entries)
            .into_par_iter()
            .map(|i| {
                let [edges, light] = draw.strategy(i);
                [edges, light, i]
            })
            .collect();
        run.set_lists(words.as_flattened());
        let variant = variant(self.features, self.direct, self.maps_row.is_some(), self.max_edges);
        let uniform = PassUniform { entries, pass_index: draw.pass_index, ..self.uniform(draw.given) };
        run.submit(&[Dispatch { variant, uniform }])?;
        draw.batch = run.read(Buffer::Output, 0..size_of::<Candidate>() as u64 * u64::from(entries))?;
        draw.made += entries;
        Ok(())
    }

    /// Makes the chosen candidates again, into the chains from the first on.
    pub fn fill(&self, run: &mut Run, given: Given, list: &[[u32; 2]], chosen: &[u32]) -> crate::Result<()> {
        self.fill_with(run, given, chosen.iter().map(|&i| (list[i as usize], i)))
    }

    /// The same of candidates given by strategy and number.
    fn fill_with(
        &self,
        run: &mut Run,
        given: Given,
        chosen: impl Iterator<Item = ([u32; 2], u32)>,
    ) -> crate::Result<()> {
        let words: Vec<[u32; 3]> = chosen.map(|([edges, light], i)| [edges, light, i]).collect();
        run.set_lists(words.as_flattened());
        let variant = variant(self.features, self.direct, self.maps_row.is_some(), self.max_edges);
        let uniform =
            PassUniform { entries: words.len() as u32, pass_index: CANDIDATE_PASS, keep: 1, ..self.uniform(given) };
        run.submit(&[Dispatch { variant, uniform }])
    }

    /// What is known before the start.
    pub(super) fn given(&self) -> Given {
        Given { path_traced: self.direct.path_traced(), ..Given::default() }
    }

    /// The fields that all passes of the start have alike.
    pub(super) fn uniform(&self, given: Given) -> PassUniform {
        given.set(PassUniform { seed: self.seed, stride: self.stride, ..Default::default() })
    }
}
