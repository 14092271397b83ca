//! Direct light apart (METHOD.md 1.5): paths of at most 2 edges by the path tracer, the others by chains, and the sum.
//!
//! The split is a function of the path alone, its number of edges, so that neither part needs to know of the other.

use std::sync::Arc;
use std::time::Duration;

use super::chain_film;
use super::chains::Chains;
use super::pt::PathTracer;
use super::session::{Part, Stage};
use super::{Budget, Outcome, Settings};
use crate::ensemble::strategies::INDIRECT_EDGES;
use crate::gpu::context::Context;
use crate::gpu::scene::GpuScene;
use crate::report::statistics::Statistics;
use crate::scene::Features;

/// Samples per pixel of the path tracer: this share of the mutations per pixel, and at least so many. Direct light is the
/// easy part; an eighth as many samples leave it less noise than chains leave the rest.
const SHARE: u32 = 8;
const FEWEST_SAMPLES: u32 = 4;
/// Its share of a budget of time.
const TIME_SHARE: f64 = 0.15;
/// Pass index from which its random numbers count: apart from those of mutations and of the start.
const FIRST_PASS: u32 = 0x4000_0000;

/// The path tracer for direct light, and the chains for the rest. They take turns so that both spend their budgets
/// alike; neither's result depends on when.
pub(super) struct Both<'a> {
    settings: Settings,
    direct: PathTracer<'a>,
    /// None where no path may be longer.
    rest: Option<Chains<'a>>,
}

impl<'a> Both<'a> {
    pub(super) fn new(
        context: &'a Context,
        scene: Arc<GpuScene>,
        features: Features,
        settings: &Settings,
    ) -> crate::Result<Self> {
        let all_direct = settings.max_depth < INDIRECT_EDGES;
        let [budget, rest] = if all_direct { [settings.budget; 2] } else { split(settings.budget) };
        let part = Settings { max_depth: settings.max_depth.min(INDIRECT_EDGES - 1), budget, ..settings.clone() };
        let direct = PathTracer::new(context, Arc::clone(&scene), features, &part, FIRST_PASS)?;
        let part = Settings { budget: rest, ..settings.clone() };
        let rest = if all_direct { None } else { Some(Chains::new(context, scene, features, &part)?) };
        Ok(Self { settings: settings.clone(), direct, rest })
    }

    /// The figures of the chains with those of the path tracer added.
    fn total(&self, rest: Option<Statistics>) -> Statistics {
        let part = self.direct.statistics();
        let mut all = rest.unwrap_or_else(|| Statistics {
            notes: vec!["--max-depth leaves paths of at most 2 edges: all light is direct, by the path tracer".into()],
            ..Statistics::default()
        });
        let host_s = all.host_share * all.render_s + part.host_share * part.render_s;
        all.direct_samples = part.samples;
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
        self.rest.as_ref().map_or(Stage::Rendering, Part::stage).min(self.direct.stage())
    }

    fn share(&self) -> f64 {
        match &self.rest {
            Some(rest) if rest.stage() < Stage::Rendering => rest.share(),
            Some(rest) => rest.share().min(self.direct.share()),
            None => self.direct.share(),
        }
    }

    fn has_image(&self) -> bool {
        self.direct.has_image() && self.rest.as_ref().is_none_or(Part::has_image)
    }

    fn is_whole(&self) -> bool {
        self.direct.is_whole() && self.rest.as_ref().is_none_or(Part::is_whole)
    }

    fn samples(&self) -> u64 {
        // Where chains have nothing to carry, the path tracer's are all there are.
        match self.rest.as_ref().map_or(0, Part::samples) {
            0 => self.direct.samples(),
            mutations => mutations,
        }
    }

    fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        match &mut self.rest {
            Some(rest) if self.direct.stage() == Stage::Rendering && self.direct.is_whole() => {
                if rest.stage() < Stage::Rendering || !rest.is_whole() || rest.share() < self.direct.share() {
                    rest.advance(limit)
                } else {
                    self.direct.advance(limit)
                }
            }
            _ => self.direct.advance(limit),
        }
    }

    fn statistics(&self) -> Statistics {
        self.total(self.rest.as_ref().map(Part::statistics))
    }

    fn snapshot(&mut self, with_error: bool) -> crate::Result<Outcome> {
        let direct = self.direct.snapshot(with_error)?;
        let outcome = match &mut self.rest {
            Some(rest) => rest.snapshot_over(Some(&direct), with_error)?,
            // Layers are those that chains would have.
            None => Outcome { channels: chain_film::black(&self.settings, Statistics::default()).channels, ..direct },
        };
        let rest = self.rest.is_some().then_some(outcome.statistics);
        Ok(Outcome { statistics: self.total(rest), ..outcome })
    }
}

/// The path tracer's budget and the chains'.
fn split(budget: Budget) -> [Budget; 2] {
    match budget {
        Budget::SamplesPerPixel(n) => [Budget::SamplesPerPixel((n / SHARE).max(FEWEST_SAMPLES)), budget],
        Budget::Seconds(s) => [TIME_SHARE, 1.0 - TIME_SHARE].map(|share| Budget::Seconds(share * s)),
    }
}
