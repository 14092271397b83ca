//! `pt`: path tracing, one sample of every pixel a pass.

use std::time::Instant;

use super::{Budget, Method, Observer, Outcome, Settings};
use crate::film::{Channel, Image};
use crate::gpu::context::Context;
use crate::gpu::layout::{COUNTER_NON_FINITE, COUNTER_RAYS, COUNTER_WORDS, PassUniform};
use crate::gpu::run::{Buffer, Dispatch, Run, Sizes};
use crate::gpu::scene::SceneData;
use crate::gpu::shader::Variant;
use crate::report::statistics::Statistics;
use crate::scene::Features;

/// Passes between looks at the clock and the observer.
const PASSES_PER_SUBMISSION: u32 = 4;

/// `first_pass` keys the random numbers, together with the seed: renders whose images are added take numbers of their own.
pub(super) fn render(
    context: &Context,
    features: Features,
    data: &SceneData,
    settings: &Settings,
    first_pass: u32,
    observer: &mut dyn Observer,
    mut statistics: Statistics,
) -> crate::Result<Outcome> {
    assert_eq!(settings.method, Method::Pt);
    let pixels = settings.width as usize * settings.height as usize;
    let counters_bytes = 4 * COUNTER_WORDS as u64;
    let sizes = Sizes { chains: 0, lists: 0, output: 48 * pixels as u64, counters: counters_bytes };
    let mut run = Run::new(context, data, sizes)?;
    let variant = Variant { pass: "path_trace", features, max_edges: settings.max_depth, flags: vec![] };

    observer.stage("compiling shaders");
    let start = Instant::now();
    run.compile(std::slice::from_ref(&variant))?;
    statistics.compile_s = start.elapsed().as_secs_f64();

    observer.stage("rendering");
    let start = Instant::now();
    run.device_time = Default::default();
    let mut samples = 0u32;
    let mut non_finite = 0;
    loop {
        let share = match settings.budget {
            Budget::SamplesPerPixel(n) => f64::from(samples) / f64::from(n),
            Budget::Seconds(s) => start.elapsed().as_secs_f64() / s,
        };
        observer.progress(share.min(1.0));
        if samples > 0 && observer.stop_requested() {
            statistics.interrupted = true;
            break;
        }
        if samples > 0 && share >= 1.0 {
            break;
        }
        let batch = match settings.budget {
            Budget::SamplesPerPixel(n) => PASSES_PER_SUBMISSION.min(n - samples),
            Budget::Seconds(_) => PASSES_PER_SUBMISSION.min(samples.max(1)),
        };
        let dispatches: Vec<Dispatch> = (0..batch)
            .map(|i| Dispatch {
                variant: variant.clone(),
                uniform: PassUniform {
                    seed: settings.seed,
                    pass_index: first_pass + samples + i,
                    entries: pixels as u32,
                    ..Default::default()
                },
            })
            .collect();
        run.submit(&dispatches)?;
        let counters = run.read(Buffer::Counters, 0..counters_bytes)?;
        let counters: &[u32] = bytemuck::cast_slice(&counters);
        statistics.rays += u64::from(counters[COUNTER_RAYS]);
        non_finite += u64::from(counters[COUNTER_NON_FINITE]);
        run.clear(Buffer::Counters);
        samples += batch;
    }
    statistics.render_s = start.elapsed().as_secs_f64();
    statistics.host_share = 1.0 - run.device_time.as_secs_f64() / statistics.render_s.max(1e-9);
    if non_finite > 0 {
        statistics.notes.push(format!("{non_finite} samples were not finite and count as black"));
    }
    statistics.samples = u64::from(samples) * pixels as u64;

    let bytes = run.read(Buffer::Output, 0..48 * pixels as u64)?;
    let rows: &[[f32; 4]] = bytemuck::cast_slice(&bytes);
    let n = f64::from(samples);
    let mut image = Image { width: settings.width, height: settings.height, pixels: Vec::with_capacity(pixels) };
    let mut variance = [const { Vec::new() }; 3];
    for pixel in rows.chunks_exact(3) {
        let mean = |c: usize| (f64::from(pixel[0][c]) - f64::from(pixel[1][c])) / n;
        image.pixels.push([0, 1, 2].map(|c| mean(c) as f32));
        for (c, channel) in variance.iter_mut().enumerate() {
            // Variance of the mean, from the samples' own scatter.
            let scatter = (f64::from(pixel[2][c]) / n - mean(c) * mean(c)).max(0.0);
            channel.push((scatter / (n - 1.0).max(1.0)) as f32);
        }
    }
    let channels = ["Variance.R", "Variance.G", "Variance.B"]
        .into_iter()
        .zip(variance)
        .map(|(name, values)| Channel { name: name.into(), values })
        .collect();
    Ok(Outcome { image, channels, statistics })
}
