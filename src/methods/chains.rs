//! `mlt` and `emlt`: chains in path space, as mixes of kernels over the same sweeps.

use std::mem;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::chain_film::{
    acceptance, black, channels_of, counts_fit, few_groups, film_bytes, layer_bytes, layers_that_fit, luminance, maps,
    no_counts, pixels,
};
use super::session::{Part, Stage};
use super::{Budget, Direct, Outcome, Settings, default_mix};
use crate::ensemble::bootstrap::{self, BATCH, BATCH_BYTES, Bootstrap, Start, Starting};
use crate::ensemble::groups::Groups;
use crate::ensemble::mix::Mix;
use crate::ensemble::strategies::INDIRECT_EDGES;
use crate::ensemble::sweep::{Build, Ensemble, list_words};
use crate::ensemble::type_shares;
use crate::film::layers::Layers;
use crate::gpu::context::Context;
use crate::gpu::layout::{chain_rows, counter_bytes};
use crate::gpu::pipelines::{Built, Compilation};
use crate::gpu::run::{Buffer, PASS_SLOTS, Run, Sizes};
use crate::gpu::scene::GpuScene;
use crate::report::statistics::Statistics;
use crate::scene::Features;

/// Share of a time limit that is left to the chains, however long their start took.
const LEAST_RENDERING: f64 = 0.25;

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
    /// The kernels' pipelines are built while the start is made; it needs but one.
    kernels: Option<JoinHandle<crate::Result<Built>>>,
    /// Dispatches of perturbations in a step that has a time limit; follows the clock.
    dispatches_per_step: usize,
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
        let min_edges = if settings.direct == Direct::Pt { INDIRECT_EDGES } else { 1 };
        let build = Build {
            features,
            min_edges,
            max_edges: settings.max_depth,
            maps: settings.maps,
            two_stage: settings.two_stage.is_some(),
            guidance: settings.guidance,
            seed: settings.seed,
            groups,
        };
        let sizes = Sizes {
            chains: 16 * chain_rows(settings.max_depth) as u64 * u64::from(settings.ensemble),
            lists: 4 * list_words(settings.ensemble, BATCH),
            output: film_bytes(settings, groups.count(), if counted { kernels } else { 0 }).max(BATCH_BYTES),
            counters: counter_bytes(kernels),
        };
        let start = Start {
            features,
            min_edges,
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
            kernels: None,
            dispatches_per_step: 1,
            statistics: Statistics {
                notes: few_groups(settings, groups).into_iter().chain(no_counts(settings, counted)).collect(),
                ..Statistics::default()
            },
        })
    }

    fn pixels(&self) -> u64 {
        pixels(&self.settings)
    }

    /// Has pipelines built: those of the kernels on a thread of their own.
    fn prepare(&mut self) -> crate::Result<Phase> {
        let Start { features, min_edges, max_edges, .. } = self.start;
        let kernels = self.run.missing(&self.build.variants(&self.mix));
        let builder = self.run.builder();
        self.kernels = Some(std::thread::spawn(move || builder.build_all(&kernels)));
        let first = self.run.missing(&[bootstrap::variant(features, min_edges, max_edges)]);
        let built = self.run.builder().build_all(&first)?;
        Ok(Phase::Preparing(self.run.adopt(built)))
    }

    /// From the candidates to start paths, or into the dark.
    fn seeded(&mut self, starting: Starting) -> crate::Result<Phase> {
        let Some(bootstrap) = self.start.finish(&mut self.run, starting)? else {
            if self.settings.direct == Direct::Mcmc {
                return Err(crate::Error::input(
                    "no light reaches the camera: turn the camera, add a light, or allow longer paths with --max-depth",
                ));
            }
            self.statistics
                .notes
                .push("no path of 3 edges or more was found to carry light: all of it is direct".into());
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
                let left = (s - self.statistics.seeding_s).max(LEAST_RENDERING * s);
                self.statistics.render_s / left
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
            statistics.notes.extend(type_shares::warnings(&statistics.types).into_iter().take(MOST_WARNINGS));
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

impl Chains<'_> {
    /// The image on top of an independent one.
    pub(super) fn snapshot_over(&mut self, beneath: Option<&Outcome>, with_error: bool) -> crate::Result<Outcome> {
        let mut statistics = self.statistics();
        let beneath = beneath.map(|outcome| (&outcome.image, outcome.uncertainty.as_ref()));
        let Phase::Rendering(ensemble) = &self.phase else {
            let mut outcome = black(&self.settings, statistics);
            if let Some((image, uncertainty)) = beneath {
                outcome.image = image.clone();
                outcome.uncertainty = uncertainty.cloned();
            }
            return Ok(outcome);
        };
        let device_time = self.run.device_time;
        let groups = self.build.groups.count();
        // Of one group; all make as many.
        let mutations = ensemble.mutations().max(1) as f64 / f64::from(groups);
        let weights: Vec<f64> = (0..self.pixels() as usize).map(|pixel| ensemble.pixel_weight(pixel)).collect();
        let mut layers = Layers::new(self.settings.width, self.settings.height, with_error);
        let mut integrity = 0.0f64;
        // A layer at a time: all together would take several times the image's memory.
        let layer = layer_bytes(&self.settings);
        for group in 0..u64::from(groups) {
            let bytes = self.run.read(Buffer::Output, group * layer..(group + 1) * layer)?;
            let values: Vec<[f64; 3]> = channels_of(&bytes);
            let lost = luminance(&values, &weights) / mutations - 1.0;
            integrity = if lost.abs() > integrity.abs() { lost } else { integrity };
            layers.add(&values);
        }
        statistics.integrity = Some(integrity);
        let scale = ensemble.target() * self.pixels() as f64 / mutations;
        let (image, uncertainty) = layers.finish(scale, ensemble.target_error() / ensemble.target(), beneath);
        let mut directions: Vec<[f64; 2]> = Vec::new();
        if self.settings.maps {
            let behind = u64::from(groups) * layer..film_bytes(&self.settings, groups, 0);
            directions = channels_of(&self.run.read(Buffer::Output, behind)?);
        }
        let mut accepted = Vec::new();
        for (number, kernel) in self.mix.kernels().enumerate().filter(|_| self.counted && with_error) {
            let bytes = [number, number + 1].map(|kernels| film_bytes(&self.settings, groups, kernels));
            accepted.push(acceptance(kernel.name, &self.run.read(Buffer::Output, bytes[0]..bytes[1])?));
        }
        self.run.device_time = device_time;
        let mut channels = maps(&self.settings, |pixel, channel| directions[pixel][channel] as f32);
        channels.extend(accepted);
        Ok(Outcome { image, channels, uncertainty, statistics })
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
