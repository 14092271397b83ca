//! The film of chains on the device: what it takes, and how it is read.

use super::{Outcome, Settings};
use crate::ensemble::groups::{Groups, MOST_GROUPS};
use crate::film::{Channel, Image};
use crate::gpu::context::Context;
use crate::gpu::layout::FILM_SCALE;
use crate::report::statistics::Statistics;
use crate::scene::LUMINANCE;

/// Begins the names of the layers of acceptance; a kernel's name follows.
pub const ACCEPTANCE: &str = "Acceptance.";

pub(super) fn pixels(settings: &Settings) -> u64 {
    u64::from(settings.width) * u64::from(settings.height)
}

/// Bytes of the film's layer of one group on the device: a low and a high word for each pixel's R, G and B.
pub(super) fn layer_bytes(settings: &Settings) -> u64 {
    24 * pixels(settings)
}

/// Bytes of the film on the device: a layer a group, then, where the maps are asked for, the two directions and two words
/// for each of so many kernels.
pub(super) fn film_bytes(settings: &Settings, groups: u32, kernels: usize) -> u64 {
    let maps = if settings.maps { 16 + 8 * kernels as u64 } else { 0 };
    u64::from(groups) * layer_bytes(settings) + maps * pixels(settings)
}

/// How many layers the device can bind; at least one, and whoever allocates it says where even that is too large.
pub(super) fn layers_that_fit(context: &Context, settings: &Settings) -> u32 {
    let limit = context.device.limits().max_storage_buffer_binding_size;
    (1..=MOST_GROUPS).rev().find(|groups| film_bytes(settings, *groups, 0) <= limit).unwrap_or(1)
}

/// Whether the counts of so many kernels fit beside the layers: the groups, which tell the error, come first.
pub(super) fn counts_fit(context: &Context, settings: &Settings, groups: u32, kernels: usize) -> bool {
    let limit = context.device.limits().max_storage_buffer_binding_size;
    settings.maps && film_bytes(settings, groups, kernels) <= limit
}

/// What the user should know where they do not.
pub(super) fn no_counts(settings: &Settings, fit: bool) -> Option<String> {
    let text = "the acceptance by pixel is left out, for which the device cannot bind enough memory: it needs a smaller --size";
    (settings.maps && !fit).then(|| text.into())
}

/// What the user should know where there are fewer groups than asked for.
pub(super) fn few_groups(settings: &Settings, groups: Groups) -> Option<String> {
    let (count, wanted) = (groups.count(), settings.groups);
    (count < wanted).then(|| {
        let told = if count > 1 {
            format!("the error is told by the scatter of {count} groups instead of {wanted}")
        } else {
            "no error is estimated".into()
        };
        format!("{told}: {wanted} groups need a smaller --size, or an --ensemble that can be divided by {}", 2 * wanted)
    })
}

/// The layers that were asked for, by pixel and map.
pub(super) fn maps(settings: &Settings, value: impl Fn(usize, usize) -> f32) -> Vec<Channel> {
    let pixels = settings.width as usize * settings.height as usize;
    let layer = |(name, channel): (&str, usize)| Channel {
        name: name.into(),
        values: (0..pixels).map(|pixel| value(pixel, channel)).collect(),
    };
    let names = [("Maps.Horizontal", 0), ("Maps.Vertical", 1)];
    names.into_iter().filter(|_| settings.maps).map(layer).collect()
}

/// Accepted over proposed by pixel, from both as the shaders count them; NaN where nothing was proposed.
pub(super) fn acceptance(kernel: &str, counts: &[[u32; 2]]) -> Channel {
    let share = |[proposed, accepted]: &[u32; 2]| match proposed {
        0 => f32::NAN,
        _ => *accepted as f32 / *proposed as f32,
    };
    Channel { name: format!("{ACCEPTANCE}{kernel}"), values: counts.iter().map(share).collect() }
}

/// What chains without any light to carry make.
pub(super) fn black(settings: &Settings, statistics: Statistics) -> Outcome {
    let Settings { width, height, .. } = *settings;
    let image = Image { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] };
    Outcome { image, channels: maps(settings, |_, _| 0.0), uncertainty: None, statistics }
}

/// Channels of pixels from the integer film as the shaders leave it: low and high word each.
pub(super) fn channels_of<const N: usize>(units: &[[u64; N]]) -> Vec<[f64; N]> {
    units.iter().map(|pixel| pixel.map(|value| value as f64 / FILM_SCALE)).collect()
}

/// Total luminance over w: one per mutation if no weight is lost (METHOD.md 1.4, C12).
pub(super) fn luminance(pixels: &[[f64; 3]], weights: &[f64]) -> f64 {
    pixels.iter().zip(weights).map(|(pixel, weight)| LUMINANCE.dot((*pixel).into()) / weight).sum()
}
