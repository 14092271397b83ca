//! `pt`: path tracing, one sample of every pixel a pass.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::session::{Part, Stage};
use super::{Budget, Outcome, Settings};
use crate::ensemble::path_traced::PathTraced;
use crate::film::uncertainty::{CHANNELS, Uncertainty, Y};
use crate::film::{Channel, Image};
use crate::gpu::context::Context;
use crate::gpu::layout::{COUNTER_NON_FINITE, COUNTER_RAYS, COUNTER_WORDS, PassUniform};
use crate::gpu::run::{Buffer, Dispatch, Run, Sizes};
use crate::gpu::scene::GpuScene;
use crate::gpu::shader::Variant;
use crate::report::statistics::Statistics;
use crate::scene::{Features, LUMINANCE};

/// Passes between looks at the clock, where no step has a time limit.
const PASSES_PER_STEP: u32 = 4;
/// Pixels of the first step that has a time limit; later ones follow the clock.
const FIRST_PIXELS: u32 = 8192;

/// The path tracer at work.
pub(super) struct PathTracer<'a> {
    run: Run<'a>,
    variant: Variant,
    size: [u32; 2],
    budget: Budget,
    seed: u32,
    /// What it renders where it does not render all.
    path_traced: PathTraced,
    /// Keys the random numbers, together with the seed: renders whose images are added take numbers of their own.
    first_pass: u32,
    compiled: bool,
    /// Whole passes, and pixels of the next one that have their sample.
    samples: u32,
    sampled: u32,
    pixels_per_step: u32,
    rays: u64,
    non_finite: u64,
    compile_s: f64,
    render_s: f64,
}

impl<'a> PathTracer<'a> {
    /// A path tracer of all light, or of a part with a pass index to begin with: images that are added take random
    /// numbers of their own.
    pub(super) fn new(
        context: &'a Context,
        scene: Arc<GpuScene>,
        features: Features,
        settings: &Settings,
        part: Option<(PathTraced, u32)>,
    ) -> crate::Result<Self> {
        let (path_traced, first_pass) = part.unwrap_or_default();
        let flags = if part.is_some() { vec!["path_traced"] } else { vec![] };
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let sizes = Sizes { chains: 0, lists: 0, output: 48 * pixels, counters: 4 * COUNTER_WORDS as u64 };
        Ok(Self {
            run: Run::over(context, scene, sizes)?,
            variant: Variant { pass: "path_trace", features, max_edges: settings.max_depth, flags },
            size: [settings.width, settings.height],
            budget: settings.budget,
            seed: settings.seed,
            path_traced,
            first_pass,
            compiled: false,
            samples: 0,
            sampled: 0,
            pixels_per_step: FIRST_PIXELS,
            rays: 0,
            non_finite: 0,
            compile_s: 0.0,
            render_s: 0.0,
        })
    }

    fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// One pass over `count` pixels from the first that has no sample of it yet.
    fn dispatch(&self, pass: u32, count: u32) -> Dispatch {
        let uniform = self.path_traced.set(PassUniform {
            seed: self.seed,
            pass_index: self.first_pass + pass,
            entries: count,
            entries_offset: self.sampled,
            ..Default::default()
        });
        Dispatch { variant: self.variant.clone(), uniform }
    }

    fn render(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        let start = Instant::now();
        let rest = self.pixels() - self.sampled;
        let count = if limit.is_some() { self.pixels_per_step.min(rest) } else { rest };
        let passes = match self.budget {
            _ if limit.is_some() || self.sampled > 0 => 1,
            Budget::SamplesPerPixel(n) => PASSES_PER_STEP.min(n.saturating_sub(self.samples)).max(1),
            Budget::Seconds(_) => PASSES_PER_STEP.min(self.samples.max(1)),
        };
        let dispatches: Vec<Dispatch> = (0..passes).map(|i| self.dispatch(self.samples + i, count)).collect();
        self.run.submit(&dispatches)?;
        let counters: Vec<u32> = self.run.read(Buffer::Counters, 0..4 * COUNTER_WORDS as u64)?;
        self.rays += u64::from(counters[COUNTER_RAYS]);
        self.non_finite += u64::from(counters[COUNTER_NON_FINITE]);
        self.run.clear(Buffer::Counters);
        self.sampled += count;
        if self.sampled == self.pixels() {
            self.sampled = 0;
            self.samples += passes;
        }
        if let Some(limit) = limit {
            let fitting = f64::from(count) * limit.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6);
            self.pixels_per_step = (fitting.min(2.0 * f64::from(count)) as u32).next_multiple_of(64).max(64);
        }
        self.render_s += start.elapsed().as_secs_f64();
        Ok(())
    }
}

impl Part for PathTracer<'_> {
    fn stage(&self) -> Stage {
        if self.compiled { Stage::Rendering } else { Stage::Compiling }
    }

    fn share(&self) -> f64 {
        match self.budget {
            _ if !self.compiled => 0.0,
            Budget::SamplesPerPixel(n) => f64::from(self.samples) / f64::from(n),
            Budget::Seconds(s) => self.render_s / s,
        }
    }

    fn has_image(&self) -> bool {
        self.samples > 0
    }

    fn is_whole(&self) -> bool {
        self.sampled == 0
    }

    fn samples(&self) -> u64 {
        u64::from(self.samples) * u64::from(self.pixels()) + u64::from(self.sampled)
    }

    fn advance(&mut self, limit: Option<Duration>) -> crate::Result<()> {
        if self.compiled {
            return self.render(limit);
        }
        let start = Instant::now();
        self.run.compile(std::slice::from_ref(&self.variant))?;
        self.compiled = true;
        self.compile_s = start.elapsed().as_secs_f64();
        self.run.device_time = Duration::ZERO;
        Ok(())
    }

    fn statistics(&self) -> Statistics {
        let mut notes = Vec::new();
        if self.non_finite > 0 {
            let all = self.samples();
            notes.push(format!("not finite, so that they count as black: {} of {all} samples", self.non_finite));
        }
        Statistics {
            samples: self.samples(),
            rays: self.rays,
            compile_s: self.compile_s,
            render_s: self.render_s,
            host_share: 1.0 - self.run.device_time.as_secs_f64() / self.render_s.max(1e-9),
            notes,
            ..Statistics::default()
        }
    }

    fn snapshot(&mut self, with_error: bool) -> crate::Result<Outcome> {
        let pixels = self.pixels() as usize;
        let statistics = self.statistics();
        let device_time = self.run.device_time;
        let rows: Vec<[f32; 4]> = self.run.read(Buffer::Output, 0..48 * pixels as u64)?;
        self.run.device_time = device_time;
        let [width, height] = self.size;
        let mut image = Image { width, height, pixels: Vec::with_capacity(pixels) };
        let mut variances: Vec<[f64; CHANNELS]> = Vec::with_capacity(pixels);
        for (number, pixel) in rows.chunks_exact(3).enumerate() {
            let n = f64::from(self.samples + u32::from((number as u32) < self.sampled)).max(1.0);
            let mean = |c: usize| (f64::from(pixel[0][c]) - f64::from(pixel[1][c])) / n;
            let value = [0, 1, 2].map(mean);
            image.pixels.push(value.map(|v| v as f32));
            // Variance of the mean, from the samples' own scatter.
            let variance =
                |squares: f32, mean: f64| (f64::from(squares) / n - mean * mean).max(0.0) / (n - 1.0).max(1.0);
            let [r, g, b] = [0, 1, 2].map(|c| variance(pixel[2][c], value[c]));
            variances.push([r, g, b, variance(pixel[2][Y], LUMINANCE.dot(value.into()))]);
        }
        let channels = ["Variance.R", "Variance.G", "Variance.B"]
            .into_iter()
            .enumerate()
            .map(|(c, name)| Channel { name: name.into(), values: variances.iter().map(|v| v[c] as f32).collect() })
            .collect();
        // One sample a pixel has no scatter.
        let uncertainty = (with_error && self.samples > 1).then(|| Uncertainty::of_samples(&image, &variances));
        Ok(Outcome { image, channels, uncertainty, statistics })
    }
}
