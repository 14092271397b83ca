//! Easy light apart (METHOD.md 1.5): some types of paths by the path tracer, the others by chains, and the sum.
//!
//! The split is a function of the path alone, so that neither part needs to know of the other. Which types are easy is known
//! beforehand (`--direct pt`) or by the start's pilot (`--direct auto`).

use std::sync::Arc;
use std::time::Duration;

use super::chain_film;
use super::chains::Chains;
use super::pt::PathTracer;
use super::session::{Part, Stage};
use super::{Budget, Outcome, Settings};
use crate::ensemble::path_traced::{Easy, PathTraced};
use crate::film::Image;
use crate::gpu::context::Context;
use crate::gpu::scene::GpuScene;
use crate::report::statistics::Statistics;
use crate::scene::{Features, LUMINANCE};

/// Mutations in the time of a sample of the path tracer, about; and the fewest samples per pixel that it makes.
const MUTATIONS_A_SAMPLE: f64 = 2.0;
const FEWEST_SAMPLES: u32 = 4;
/// Pass index from which its random numbers count: apart from those of mutations and of the start.
const FIRST_PASS: u32 = 0x4000_0000;

/// The path tracer for easy light, and the chains for the rest. They take turns so that both spend their budgets
/// alike; neither's result depends on when.
pub(super) struct Both<'a> {
    context: &'a Context,
    scene: Arc<GpuScene>,
    features: Features,
    settings: Settings,
    /// None where no path may be longer than direct light.
    rest: Option<Chains<'a>>,
    tracer: Tracer<'a>,
}

/// The path tracer's side.
enum Tracer<'a> {
    /// What it has to do is not known yet.
    Unknown,
    Idle,
    Busy(Box<PathTracer<'a>>),
}

impl<'a> Both<'a> {
    pub(super) fn new(
        context: &'a Context,
        scene: Arc<GpuScene>,
        features: Features,
        settings: &Settings,
    ) -> crate::Result<Self> {
        let all_direct = settings.max_depth < settings.direct.min_edges();
        let rest = if all_direct { None } else { Some(Chains::new(context, Arc::clone(&scene), features, settings)?) };
        Ok(Self { context, scene, features, settings: settings.clone(), rest, tracer: Tracer::Unknown })
    }

    /// Begins the path tracer's side, once it is known what it has to do.
    fn begin(&mut self) -> crate::Result<()> {
        let all_direct = Easy { path_traced: PathTraced::direct(), time_share: 1.0 };
        let Easy { path_traced, time_share } = self.rest.as_ref().map_or(all_direct, Chains::easy);
        if path_traced.is_empty() {
            self.tracer = Tracer::Idle;
            return Ok(());
        }
        let share = if self.rest.as_ref().is_none_or(Chains::is_dark) { 1.0 } else { time_share };
        let budget = match (&mut self.rest, self.settings.budget) {
            (Some(rest), Budget::Seconds(s)) => {
                rest.leave(share);
                Budget::Seconds(share * rest.seconds_after_start(s))
            }
            (Some(_), Budget::SamplesPerPixel(n)) => {
                let samples = f64::from(n) / MUTATIONS_A_SAMPLE * (share / (1.0 - share)).min(1.0);
                Budget::SamplesPerPixel((samples as u32).max(FEWEST_SAMPLES))
            }
            (None, budget) => budget,
        };
        let max_depth = self.settings.max_depth.min(path_traced.longest());
        let part = Settings { max_depth, budget, ..self.settings.clone() };
        let part = (&part, Some((path_traced, FIRST_PASS)));
        self.tracer = Tracer::Busy(Box::new(PathTracer::new(
            self.context,
            Arc::clone(&self.scene),
            self.features,
            part.0,
            part.1,
        )?));
        Ok(())
    }

    fn at_work(&self) -> Option<&PathTracer<'a>> {
        if let Tracer::Busy(tracer) = &self.tracer { Some(tracer) } else { None }
    }

    /// Both sides that have work to do, as parts.
    fn parts(&self) -> impl Iterator<Item = &dyn Part> {
        let rest = self.rest.iter().map(|rest| rest as &dyn Part);
        rest.chain(self.at_work().map(|tracer| tracer as &dyn Part))
    }

    /// The figures of the chains with those of the path tracer added.
    fn total(&self, rest: Option<Statistics>) -> Statistics {
        let mut all = rest.unwrap_or_else(|| Statistics {
            notes: vec!["--max-depth leaves paths of at most 2 edges: all light is direct, by the path tracer".into()],
            ..Statistics::default()
        });
        let Some(part) = self.at_work().map(Part::statistics) else { return all };
        let host_s = all.host_share * all.render_s + part.host_share * part.render_s;
        all.path_traced_samples = part.samples;
        all.rays += part.rays;
        all.compile_s += part.compile_s;
        all.render_s += part.render_s;
        all.host_share = host_s / all.render_s.max(1e-9);
        all.notes.extend(part.notes);
        all
    }
}

impl Part for Both<'_> {
    fn stage(&self) -> Stage {
        if matches!(self.tracer, Tracer::Unknown) {
            return self.rest.as_ref().map_or(Stage::Compiling, Part::stage).min(Stage::Seeding);
        }
        self.parts().map(Part::stage).min().unwrap_or(Stage::Rendering)
    }

    fn share(&self) -> f64 {
        let stage = self.stage();
        let busy = self.parts().filter(|part| part.stage() == stage);
        busy.map(Part::share).fold(f64::INFINITY, f64::min)
    }

    fn has_image(&self) -> bool {
        !matches!(self.tracer, Tracer::Unknown) && self.parts().all(Part::has_image)
    }

    fn is_whole(&self) -> bool {
        self.parts().all(Part::is_whole)
    }

    fn samples(&self) -> u64 {
        // Where chains have nothing to carry, the path tracer's are all there are.
        match self.rest.as_ref().map_or(0, Part::samples) {
            0 => self.at_work().map_or(0, Part::samples),
            mutations => mutations,
        }
    }

    fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        if let Some(rest) = self.rest.as_mut().filter(|rest| rest.stage() < Stage::Rendering) {
            return rest.advance(limit);
        }
        if matches!(self.tracer, Tracer::Unknown) {
            return self.begin();
        }
        match (&mut self.rest, &mut self.tracer) {
            (Some(rest), Tracer::Busy(tracer)) if tracer.stage() == Stage::Rendering && tracer.is_whole() => {
                if !rest.is_whole() || rest.share() < tracer.share() {
                    rest.advance(limit)
                } else {
                    tracer.advance(limit)
                }
            }
            (_, Tracer::Busy(tracer)) => tracer.advance(limit),
            (Some(rest), _) => rest.advance(limit),
            (None, _) => Ok(()),
        }
    }

    fn statistics(&self) -> Statistics {
        self.total(self.rest.as_ref().map(Part::statistics))
    }

    fn snapshot(&mut self, with_error: bool) -> crate::Result<Outcome> {
        let easy = match &mut self.tracer {
            Tracer::Busy(tracer) => Some(tracer.snapshot(with_error)?),
            _ => None,
        };
        let easy_light = easy.as_ref().map(|easy| luminance(&easy.image));
        let outcome = match (&mut self.rest, easy) {
            (Some(rest), easy) => rest.snapshot_over(easy.as_ref(), with_error)?,
            // Layers are those that chains would have.
            (None, Some(easy)) => {
                Outcome { channels: chain_film::black(&self.settings, Statistics::default()).channels, ..easy }
            }
            (None, None) => chain_film::black(&self.settings, Statistics::default()),
        };
        let rest = self.rest.is_some().then_some(outcome.statistics);
        let mut statistics = self.total(rest);
        statistics.path_traced_light =
            easy_light.map(|light| light / luminance(&outcome.image)).filter(|share| share.is_finite());
        Ok(Outcome { statistics, ..outcome })
    }
}

/// The luminance of all pixels together.
fn luminance(image: &Image) -> f64 {
    image.pixels.iter().map(|pixel| f64::from(LUMINANCE.as_vec3().dot((*pixel).into()))).sum()
}
