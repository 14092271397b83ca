//! `mlt` and `emlt`: chains in path space, as mixes of kernels over the same sweeps.

use std::time::Instant;

use super::{Budget, Direct, Method, Observer, Outcome, Settings};
use crate::ensemble::bootstrap::{self, BATCH, Start};
use crate::ensemble::mix::Mix;
use crate::ensemble::strategies::INDIRECT_EDGES;
use crate::ensemble::sweep::{Build, Ensemble, list_words};
use crate::film::{Channel, Image};
use crate::gpu::context::Context;
use crate::gpu::layout::{COUNTER_WORDS, FILM_SCALE, chain_rows};
use crate::gpu::run::{Buffer, Run, Sizes};
use crate::gpu::scene::SceneData;
use crate::kernels::{
    Kernel, bidirectional, caustic, guided_bidirectional, guided_lens, independence, lens, multi_chain,
};
use crate::report::statistics::Statistics;
use crate::scene::Features;

/// The kernels of a method with their weights (docs/kernels.md says how they were chosen).
pub fn default_mix(method: Method) -> Vec<(&'static Kernel, f64)> {
    let guided = method == Method::Emlt;
    let mut weights = vec![
        (&independence::KERNEL, 0.05),
        (if guided { &guided_bidirectional::KERNEL } else { &bidirectional::KERNEL }, 0.15),
        (&lens::KERNEL, 1.0),
        (&multi_chain::KERNEL, 1.0),
        (&caustic::KERNEL, 1.0),
    ];
    if guided {
        weights.push((&guided_lens::KERNEL, 1.0));
    }
    weights
}

pub(super) fn render(
    context: &Context,
    features: Features,
    data: &SceneData,
    settings: &Settings,
    observer: &mut dyn Observer,
    mut statistics: Statistics,
) -> crate::Result<Outcome> {
    settings.guidance.check()?;
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let channels = if settings.maps { 5 } else { 3 };
    let weights = settings.kernels.clone().unwrap_or_else(|| default_mix(settings.method));
    let mix = Mix::new(&weights, features);
    let min_edges = if settings.direct == Direct::Pt { INDIRECT_EDGES } else { 1 };
    let build = Build {
        features,
        min_edges,
        max_edges: settings.max_depth,
        maps: settings.maps,
        two_stage: settings.two_stage.is_some(),
        guidance: settings.guidance,
        seed: settings.seed,
        paths: settings.ensemble,
    };
    let film_bytes = 8 * channels * pixels;
    let mut run = Run::new(
        context,
        data,
        Sizes {
            chains: 16 * chain_rows(settings.max_depth) as u64 * u64::from(settings.ensemble),
            lists: 4 * list_words(settings.ensemble, BATCH),
            output: film_bytes.max(16 * u64::from(BATCH)),
            counters: 4 * (COUNTER_WORDS * mix.kernels().len()) as u64,
        },
    )?;

    // The kernels' pipelines are built while the start is made; it needs but one.
    let builder = run.builder();
    let variants = build.variants(&mix);
    let (bootstrap, built) = std::thread::scope(|scope| -> crate::Result<_> {
        let built = scope.spawn(|| builder.build_all(&variants));
        observer.stage("compiling shaders");
        let start = Instant::now();
        run.compile(&[bootstrap::variant(features, min_edges, settings.max_depth)])?;
        statistics.compile_s = start.elapsed().as_secs_f64();

        observer.stage("seeding");
        let start = Instant::now();
        let bootstrap = Start {
            features,
            min_edges,
            max_edges: settings.max_depth,
            two_stage: settings.two_stage,
            seed: settings.seed,
            paths: settings.ensemble,
            stride: settings.ensemble,
            film: [settings.width, settings.height],
            observer,
        }
        .run(&mut run)?;
        statistics.seeding_s = start.elapsed().as_secs_f64();
        Ok((bootstrap, built.join().expect("building pipelines does not panic")?))
    })?;
    let Some(bootstrap) = bootstrap else {
        if settings.direct == Direct::Mcmc {
            return Err(crate::Error::input(
                "no light reaches the camera: turn the camera, add a light, or allow longer paths with --max-depth",
            ));
        }
        statistics.notes.push("no path of 3 edges or more was found to carry light: all of it is direct".into());
        return Ok(black(settings, statistics));
    };
    if bootstrap.largest_share > 0.01 {
        statistics.notes.push(format!(
            "one start candidate holds {:.1} % of all light: b and the start are uncertain, compare several seeds",
            100.0 * bootstrap.largest_share
        ));
    }
    observer.stage("compiling shaders");
    let start = Instant::now();
    run.adopt(built)?;
    statistics.compile_s += start.elapsed().as_secs_f64();
    run.clear(Buffer::Output);
    run.clear(Buffer::Counters);
    let mut ensemble = Ensemble::new(&mut run, build, mix, bootstrap)?;

    observer.stage("rendering");
    let start = Instant::now();
    run.device_time = Default::default();
    loop {
        let share = match settings.budget {
            Budget::SamplesPerPixel(n) => ensemble.mutations() as f64 / (f64::from(n) * pixels as f64),
            Budget::Seconds(s) => start.elapsed().as_secs_f64() / s,
        };
        observer.progress(share.min(1.0));
        if ensemble.mutations() > 0 {
            if observer.stop_requested() {
                statistics.interrupted = true;
                break;
            }
            if share >= 1.0 {
                break;
            }
        }
        ensemble.half_sweep(&mut run)?;
    }
    statistics.render_s = start.elapsed().as_secs_f64();
    statistics.host_share = 1.0 - run.device_time.as_secs_f64() / statistics.render_s.max(1e-9);
    statistics.samples = ensemble.mutations();
    statistics.rays = ensemble.rays();
    statistics.kernels = ensemble.kernel_statistics();
    statistics.b = Some(ensemble.b());

    let bytes = run.read(Buffer::Output, 0..film_bytes)?;
    let film = Film { words: bytemuck::cast_slice(&bytes), channels: channels as usize };
    statistics.integrity =
        Some(film.luminance(|pixel| ensemble.pixel_weight(pixel)) / ensemble.mutations() as f64 - 1.0);
    let scale = ensemble.target() * pixels as f64 / ensemble.mutations() as f64;
    let image = Image {
        width: settings.width,
        height: settings.height,
        pixels: (0..pixels as usize).map(|p| [0, 1, 2].map(|c| (film.value(p, c) * scale) as f32)).collect(),
    };
    let layers = maps(settings, |pixel, channel| film.value(pixel, channel) as f32);
    Ok(Outcome { image, channels: layers, statistics })
}

/// The layers that were asked for, by pixel and channel of the film.
fn maps(settings: &Settings, value: impl Fn(usize, usize) -> f32) -> Vec<Channel> {
    let pixels = settings.width as usize * settings.height as usize;
    let layer = |(name, channel): (&str, usize)| Channel {
        name: name.into(),
        values: (0..pixels).map(|pixel| value(pixel, channel)).collect(),
    };
    let names = [("Maps.Horizontal", 3), ("Maps.Vertical", 4)];
    names.into_iter().filter(|_| settings.maps).map(layer).collect()
}

/// What chains without any light to carry make.
pub(super) fn black(settings: &Settings, statistics: Statistics) -> Outcome {
    let Settings { width, height, .. } = *settings;
    let image = Image { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] };
    Outcome { image, channels: maps(settings, |_, _| 0.0), statistics }
}

/// The integer film as the shaders leave it: low and high word per pixel and channel.
struct Film<'a> {
    words: &'a [u32],
    channels: usize,
}

impl Film<'_> {
    fn value(&self, pixel: usize, channel: usize) -> f64 {
        let word = 2 * (pixel * self.channels + channel);
        (f64::from(self.words[word]) + f64::from(self.words[word + 1]) * 2f64.powi(32)) / FILM_SCALE
    }

    /// Total splatted luminance over w of the pixel: one per mutation if no weight is lost (METHOD.md 1.4, C12).
    fn luminance(&self, pixel_weight: impl Fn(usize) -> f64) -> f64 {
        let pixels = self.words.len() / (2 * self.channels);
        let luminance = |p| 0.2126 * self.value(p, 0) + 0.7152 * self.value(p, 1) + 0.0722 * self.value(p, 2);
        (0..pixels).map(|p| luminance(p) / pixel_weight(p)).sum()
    }
}
