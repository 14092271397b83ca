//! Direct light apart (METHOD.md 1.5): paths of at most 2 edges by the path tracer, the others by chains, and the sum.
//!
//! The split is a function of the path alone, its number of edges, so that neither part needs to know of the other.

use super::{Budget, Method, Observer, Outcome, Settings, chains, pt};
use crate::ensemble::strategies::INDIRECT_EDGES;
use crate::gpu::context::Context;
use crate::gpu::scene::SceneData;
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

pub(super) fn render(
    context: &Context,
    features: Features,
    data: &SceneData,
    settings: &Settings,
    observer: &mut dyn Observer,
    statistics: Statistics,
) -> crate::Result<Outcome> {
    let all_direct = settings.max_depth < INDIRECT_EDGES;
    let [budget, rest] = if all_direct { [settings.budget; 2] } else { split(settings.budget) };
    let part = Settings {
        method: Method::Pt,
        max_depth: settings.max_depth.min(INDIRECT_EDGES - 1),
        budget,
        ..settings.clone()
    };
    let direct = pt::render(context, features, data, &part, FIRST_PASS, observer, Statistics::default())?;
    let mut outcome = if all_direct {
        let mut statistics = statistics;
        statistics
            .notes
            .push("--max-depth leaves paths of at most 2 edges: all light is direct, by the path tracer".into());
        chains::black(settings, statistics)
    } else {
        chains::render(context, features, data, &Settings { budget: rest, ..settings.clone() }, observer, statistics)?
    };
    for (pixel, add) in outcome.image.pixels.iter_mut().zip(&direct.image.pixels) {
        pixel.iter_mut().zip(add).for_each(|(sum, add)| *sum += add);
    }
    let (all, part) = (&mut outcome.statistics, direct.statistics);
    let host_s = all.host_share * all.render_s + part.host_share * part.render_s;
    all.direct_samples = part.samples;
    all.rays += part.rays;
    all.compile_s += part.compile_s;
    all.render_s += part.render_s;
    all.host_share = host_s / all.render_s.max(1e-9);
    all.interrupted |= part.interrupted;
    all.notes.extend(part.notes);
    Ok(outcome)
}

/// The path tracer's budget and the chains'.
fn split(budget: Budget) -> [Budget; 2] {
    match budget {
        Budget::SamplesPerPixel(n) => [Budget::SamplesPerPixel((n / SHARE).max(FEWEST_SAMPLES)), budget],
        Budget::Seconds(s) => [TIME_SHARE, 1.0 - TIME_SHARE].map(|share| Budget::Seconds(share * s)),
    }
}
