//! The image of chains as it stands.

use super::super::Outcome;
use super::super::chain_film::{acceptance, black, channels_of, film_bytes, layer_bytes, luminance, maps};
use super::super::session::Part;
use super::{Chains, Phase};
use crate::film::layers::Layers;
use crate::gpu::run::Buffer;

impl Chains<'_> {
    /// The image on top of an independent one.
    pub(in super::super) fn snapshot_over(
        &mut self,
        beneath: Option<&Outcome>,
        with_error: bool,
    ) -> crate::Result<Outcome> {
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
            let values = channels_of::<3>(&self.run.read(Buffer::Output, group * layer..(group + 1) * layer)?);
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
