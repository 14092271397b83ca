//! `mlt` and `emlt`: chains in path space, as mixes of kernels over the same sweeps.

mod snapshot;

use std::mem;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::chain_film::{counts_fit, few_groups, film_bytes, layers_that_fit, no_counts, pixels};
use super::session::{Part, Stage};
use super::{Budget, Method, Outcome, Settings, default_mix};
use crate::ensemble::bootstrap::{self, BATCH, BATCH_BYTES, Bootstrap, Given, MAPS_ROWS, Start, Starting};
use crate::ensemble::groups::Groups;
use crate::ensemble::mix::Mix;
use crate::ensemble::path_traced::Easy;
use crate::ensemble::photons::{self, has_photons};
use crate::ensemble::sweep::{Build, Ensemble, list_words};
use crate::ensemble::type_shares;
use crate::gpu::context::Context;
use crate::gpu::layout::{chain_rows, counter_bytes};
use crate::gpu::pipelines::{Built, Compilation};
use crate::gpu::run::{Buffer, PASS_SLOTS, Run, Sizes};
use crate::gpu::scene::GpuScene;
use crate::report::statistics::Statistics;
use crate::scene::Features;

/// Share of a time limit that is left to the chains, however long their start took.
const LEAST_RENDERING: f64 = 0.25;

/// Share of a time limit after which a start makes do with the candidates it has.
const MOST_SEEDING: f64 = 0.35;

/// Share of the start's candidates that may be lost to rounding before a note speaks of it.
const NON_FINITE_SHARE: f64 = 1e-5;
/// Types of paths that notes speak of.
const MOST_WARNINGS: usize = 3;

/// Chains at work.
pub(super) struct Chains<'a> {
    run: Run<'a>,
    settings: Settings,
    build: Build,
    mix: Mix,
    /// Whether the film counts proposals by kernel and pixel.
    counted: bool,
    start: Start,
    phase: Phase,
    /// The path tracer's share of the time after the start, where there is one.
    path_tracers_share: f64,
    /// The kernels' pipelines are built while the start is made; it needs but one.
    kernels: Option<JoinHandle<crate::Result<Built>>>,
    /// Dispatches of perturbations in a step that has a time limit; follows the clock.
    dispatches_per_step: usize,
    /// Of the time after the start: less than 1 where a path tracer has the rest.
    time_share: f64,
    /// Times and notes; what the ensemble counts is asked of it.
    statistics: Statistics,
}

/// What a step works at.
enum Phase {
    /// Nothing is built before the first step.
    Fresh,
    /// The start's pipeline compiles.
    Preparing(Compilation),
    Seeding(Box<Starting>),
    /// The kernels' pipelines compile.
    Compiling(Compilation, Box<Bootstrap>),
    Rendering(Box<Ensemble>),
    /// There is no light for the chains to carry.
    Dark,
}

impl<'a> Chains<'a> {
    pub(super) fn new(
        context: &'a Context,
        scene: Arc<GpuScene>,
        features: Features,
        settings: &Settings,
    ) -> crate::Result<Self> {
        settings.guidance.check()?;
        let weights = settings.kernels.clone().unwrap_or_else(|| default_mix(settings.method));
        let mix = Mix::new(&weights, features);
        let kernels = mix.kernels().len();
        let groups = Groups::new(settings.ensemble, settings.groups.min(layers_that_fit(context, settings)));
        let counted = counts_fit(context, settings, groups.count(), kernels);
        if settings.target_error.is_some() && groups.count() < 2 {
            return Err(crate::Error::input(
                "a target error needs at least two groups, whose scatter tells the error: raise --groups or lower --size",
            ));
        }
        // The start's maps lie behind the chains. mlt starts as Veach's does.
        let rows = chain_rows(settings.max_depth) as u64 * u64::from(settings.ensemble);
        let fits = 16 * (rows + MAPS_ROWS) <= context.device.limits().max_storage_buffer_binding_size;
        let maps_row = (settings.method == Method::Emlt && has_photons(features) && fits).then_some(rows as u32);
        let build = Build {
            features,
            direct: settings.direct,
            sought: maps_row.is_some(),
            given: Given { path_traced: settings.direct.path_traced(), ..Given::default() },
            max_edges: settings.max_depth,
            maps: settings.maps,
            two_stage: settings.two_stage.is_some(),
            guidance: settings.guidance,
            seed: settings.seed,
            groups,
        };
        let sizes = Sizes {
            chains: 16 * (rows + if maps_row.is_some() { MAPS_ROWS } else { 0 }),
            lists: 4 * list_words(settings.ensemble, BATCH),
            output: film_bytes(settings, groups.count(), if counted { kernels } else { 0 }).max(BATCH_BYTES),
            counters: counter_bytes(kernels),
        };
        let start = Start {
            features,
            direct: settings.direct,
            maps_row,
            max_edges: settings.max_depth,
            two_stage: settings.two_stage,
            candidates: settings.candidates,
            seed: settings.seed,
            groups,
            stride: settings.ensemble,
            film: [settings.width, settings.height],
        };
        Ok(Self {
            run: Run::over(context, scene, sizes)?,
            settings: settings.clone(),
            build,
            mix,
            counted,
            start,
            phase: Phase::Fresh,
            path_tracers_share: 0.0,
            kernels: None,
            dispatches_per_step: 1,
            time_share: 1.0,
            statistics: Statistics {
                notes: few_groups(settings, groups).into_iter().chain(no_counts(settings, counted)).collect(),
                ..Statistics::default()
            },
        })
    }

    /// What is left to the path tracer; known once the start is made.
    pub(super) fn easy(&self) -> Easy {
        Easy { path_traced: self.build.given.path_traced, time_share: self.path_tracers_share }
    }

    /// Whether there is nothing else.
    pub(super) fn is_dark(&self) -> bool {
        matches!(self.phase, Phase::Dark)
    }

    /// Of a budget of so many seconds, what the start leaves.
    pub(super) fn seconds_after_start(&self, seconds: f64) -> f64 {
        (seconds - self.statistics.seeding_s).max(LEAST_RENDERING * seconds)
    }

    /// Leaves a share of the time after the start to others.
    pub(super) fn leave(&mut self, share: f64) {
        self.time_share = 1.0 - share;
    }

    fn pixels(&self) -> u64 {
        pixels(&self.settings)
    }

    /// Has pipelines built: those of the kernels on a thread of their own.
    fn prepare(&mut self) -> crate::Result<Phase> {
        let Start { features, direct, maps_row, max_edges, .. } = self.start;
        let kernels = self.run.missing(&self.build.variants(&self.mix));
        let builder = self.run.builder();
        self.kernels = Some(std::thread::spawn(move || builder.build_all(&kernels)));
        let mut first = vec![bootstrap::variant(features, direct, maps_row.is_some(), max_edges)];
        first.extend(maps_row.map(|_| photons::variant(features, max_edges)));
        let first = self.run.missing(&first);
        let built = self.run.builder().build_all(&first)?;
        Ok(Phase::Preparing(self.run.adopt(built)))
    }

    /// From the candidates to start paths, or into the dark.
    fn seeded(&mut self, starting: Starting) -> crate::Result<Phase> {
        self.build.given = starting.given();
        self.path_tracers_share = starting.time_share();
        let Some(bootstrap) = self.start.finish(&mut self.run, starting)? else {
            if self.build.given.path_traced.is_empty() {
                return Err(crate::Error::input(
                    "no light reaches the camera: turn the camera, add a light, or allow longer paths with --max-depth",
                ));
            }
            let all = self.build.given.path_traced.is_all(self.settings.max_depth);
            let note = if all {
                "all light is path traced, since that finds it easily here: --direct mcmc leaves it to the chains"
            } else {
                "no path was found to carry light but those that are path traced"
            };
            self.statistics.notes.push(note.into());
            return Ok(Phase::Dark);
        };
        if bootstrap.largest_share > 0.01 {
            self.statistics.notes.push(format!(
                "one start candidate holds {:.1} % of all light: b and the start are uncertain, compare several seeds",
                100.0 * bootstrap.largest_share
            ));
        }
        if bootstrap.non_finite as f64 > NON_FINITE_SHARE * f64::from(self.start.candidates) {
            let (n, all) = (bootstrap.non_finite, self.start.candidates);
            self.statistics
                .notes
                .push(format!("not finite, so that they count as black: {n} of {all} start candidates"));
        }
        if bootstrap.shared {
            self.statistics.notes.push(
                "hardly any start candidates carry light, so that groups had to share them: the stated error is too small"
                    .into(),
            );
        }
        let built = match self.kernels.take() {
            Some(thread) => thread.join().expect("building pipelines does not panic")?,
            None => Built::new(),
        };
        Ok(Phase::Compiling(self.run.adopt(built), Box::new(bootstrap)))
    }

    /// From the start paths to chains that move.
    fn started(&mut self, bootstrap: Bootstrap) -> crate::Result<Phase> {
        self.run.clear(Buffer::Output);
        self.run.clear(Buffer::Counters);
        let ensemble = Ensemble::new(&mut self.run, self.build, self.mix.clone(), bootstrap)?;
        self.run.device_time = Duration::ZERO;
        Ok(Phase::Rendering(Box::new(ensemble)))
    }

    /// A part of a half-sweep, or the whole of its perturbations.
    fn render(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        let Phase::Rendering(ensemble) = &mut self.phase else { return Ok(()) };
        let start = Instant::now();
        let perturbs = ensemble.perturbs();
        ensemble.step(&mut self.run, if limit.is_some() { self.dispatches_per_step } else { usize::MAX })?;
        if let Some(limit) = limit {
            self.run.wait()?;
            if perturbs {
                self.dispatches_per_step = fitting(self.dispatches_per_step, limit, start.elapsed());
            }
        }
        self.statistics.render_s += start.elapsed().as_secs_f64();
        Ok(())
    }
}

impl Part for Chains<'_> {
    fn stage(&self) -> Stage {
        match self.phase {
            Phase::Fresh | Phase::Preparing(_) | Phase::Compiling(..) => Stage::Compiling,
            Phase::Seeding(_) => Stage::Seeding,
            Phase::Rendering(_) | Phase::Dark => Stage::Rendering,
        }
    }

    fn share(&self) -> f64 {
        match (&self.phase, self.settings.budget) {
            (Phase::Fresh, _) => 0.0,
            (Phase::Preparing(compilation) | Phase::Compiling(compilation, _), _) => compilation.share(),
            (Phase::Seeding(starting), _) => starting.share(),
            (Phase::Rendering(ensemble), Budget::SamplesPerPixel(n)) => {
                ensemble.mutations() as f64 / (f64::from(n) * self.pixels() as f64)
            }
            (Phase::Rendering(_), Budget::Seconds(s)) => {
                self.statistics.render_s / (self.time_share * self.seconds_after_start(s))
            }
            // Nothing is left to do, ever.
            (Phase::Dark, _) => f64::INFINITY,
        }
    }

    fn has_image(&self) -> bool {
        match &self.phase {
            Phase::Rendering(ensemble) => ensemble.mutations() > 0,
            Phase::Dark => true,
            _ => false,
        }
    }

    fn is_whole(&self) -> bool {
        match &self.phase {
            Phase::Rendering(ensemble) => ensemble.is_whole(),
            Phase::Dark => true,
            _ => false,
        }
    }

    fn samples(&self) -> u64 {
        if let Phase::Rendering(ensemble) = &self.phase { ensemble.mutations() } else { 0 }
    }

    fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        let start = Instant::now();
        match &mut self.phase {
            Phase::Fresh => {
                self.phase = self.prepare()?;
                self.statistics.compile_s += start.elapsed().as_secs_f64();
            }
            Phase::Preparing(compilation) => {
                if !compilation.step(&mut self.run)? {
                    self.phase = Phase::Seeding(Box::new(self.start.begin(&self.run)));
                }
                self.statistics.compile_s += start.elapsed().as_secs_f64();
            }
            Phase::Seeding(starting) => {
                if let Budget::Seconds(s) = self.settings.budget
                    && self.statistics.seeding_s > MOST_SEEDING * s
                {
                    starting.hurry();
                }
                if !self.start.step(&mut self.run, starting)? {
                    let Phase::Seeding(starting) = mem::replace(&mut self.phase, Phase::Dark) else { unreachable!() };
                    self.phase = self.seeded(*starting)?;
                }
                self.statistics.seeding_s += start.elapsed().as_secs_f64();
            }
            Phase::Compiling(compilation, _) => {
                if !compilation.step(&mut self.run)? {
                    let Phase::Compiling(_, bootstrap) = mem::replace(&mut self.phase, Phase::Dark) else {
                        unreachable!()
                    };
                    self.phase = self.started(*bootstrap)?;
                }
                self.statistics.compile_s += start.elapsed().as_secs_f64();
            }
            Phase::Rendering(_) => self.render(limit)?,
            Phase::Dark => {}
        }
        Ok(())
    }

    fn statistics(&self) -> Statistics {
        let mut statistics = self.statistics.clone();
        if let Phase::Rendering(ensemble) = &self.phase {
            statistics.host_share = 1.0 - self.run.device_time.as_secs_f64() / statistics.render_s.max(1e-9);
            statistics.samples = ensemble.mutations();
            statistics.rays = ensemble.rays();
            statistics.kernels = ensemble.kernel_statistics();
            statistics.b = Some(ensemble.b());
            statistics.types = ensemble.types().statistics();
            statistics.notes.extend(
                type_shares::warnings(&statistics.types, self.build.given.path_traced).into_iter().take(MOST_WARNINGS),
            );
            let mixing = ensemble.mixing(self.pixels());
            statistics.notes.extend(mixing.warnings());
            statistics.mixing = Some(mixing);
        }
        statistics
    }

    fn snapshot(&mut self, with_error: bool) -> crate::Result<Outcome> {
        self.snapshot_over(None, with_error)
    }
}

/// Dispatches for the next step where `dispatches` took so long: as many as fit into the limit, at most twice as many as
/// before, and no more than a submission holds.
fn fitting(dispatches: usize, limit: Duration, took: Duration) -> usize {
    let fitting = dispatches as f64 * limit.as_secs_f64() / took.as_secs_f64();
    (fitting as usize).clamp(1, (2 * dispatches).min(PASS_SLOTS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_to_a_submission_and_shrink_to_one_dispatch() {
        let [limit, short, long] = [40, 1, 1000].map(Duration::from_millis);
        // Steps that are always short must not double for ever.
        let most = (0..100).fold(1, |dispatches, _| fitting(dispatches, limit, short));
        assert_eq!(most, PASS_SLOTS);
        assert_eq!(fitting(most, limit, Duration::ZERO), PASS_SLOTS);
        assert_eq!((fitting(100, limit, long), fitting(3, limit, long), fitting(10, limit, limit)), (4, 1, 10));
    }
}
