//! One picture of the window: what the renderer sent last, and the colours that show it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use eframe::egui::ColorImage;

use super::messages::{ErrorPoint, Picture};
use super::overlay::{Overlay, develop};
use super::tone::Tone;
use crate::film::Image;
use crate::methods::{Settings, Stage};

/// Counts the colours made by all slots.
static MADE: AtomicU64 = AtomicU64::new(1);

/// A picture with its colours.
pub struct Slot {
    /// How it is rendered.
    pub settings: Settings,
    pub picture: Picture,
    /// What the renderer is busy with, until there is a picture.
    pub progress: Option<(Stage, f64)>,
    /// Errors against the reference, in order of time.
    pub errors: Vec<ErrorPoint>,
    /// The image's own estimates of its error: seconds and the relMSE to be expected.
    pub own_errors: Vec<[f64; 2]>,
    colors: Arc<ColorImage>,
    /// A number that no other colours have.
    version: u64,
    /// What they were made with; none where the picture is newer.
    made_with: Option<(Tone, Overlay)>,
}

impl Slot {
    pub fn new(settings: Settings) -> Self {
        let (picture, progress) = (Picture::default(), None);
        let (errors, own_errors, colors) = (Vec::new(), Vec::new(), Arc::default());
        Self { settings, picture, progress, errors, own_errors, colors, version: 0, made_with: None }
    }

    /// A new job begins: the last picture stays on the screen until there is another.
    pub fn restart(&mut self, settings: Settings) {
        self.settings = settings;
        self.progress = None;
        self.errors.clear();
        self.own_errors.clear();
    }

    /// The reference is another one: what was measured and shown with it is no more.
    pub fn forget_errors(&mut self) {
        self.errors.clear();
        self.made_with = None;
    }

    /// Shows another picture from now on.
    pub fn set_picture(&mut self, picture: Picture, error: Option<ErrorPoint>) {
        if !picture.preview {
            self.progress = None;
        }
        self.picture = picture;
        self.errors.extend(error);
        if let Some(own) = &self.picture.own
            && self.own_errors.last().is_none_or(|[seconds, _]| own.seconds > *seconds)
        {
            self.own_errors.push([own.seconds, own.relative * own.relative]);
        }
        self.made_with = None;
    }

    /// The colours as the tone and the overlay want them, made anew only where something changed, with the number of
    /// their making. Their sides are at most `max_side`.
    pub fn colors(
        &mut self,
        tone: Tone,
        overlay: Overlay,
        reference: Option<&Image>,
        max_side: usize,
    ) -> Option<(Arc<ColorImage>, u64)> {
        let image = self.picture.image.as_ref()?;
        if self.made_with.as_ref().is_none_or(|made| *made != (tone, overlay)) {
            let colors = develop(image, &self.picture, tone, overlay, reference);
            self.colors = Arc::new(shrunk(colors, max_side));
            self.version = MADE.fetch_add(1, Ordering::Relaxed);
            self.made_with = Some((tone, overlay));
        }
        Some((Arc::clone(&self.colors), self.version))
    }
}

/// Every n-th pixel, so that the sides fit into a texture.
fn shrunk(colors: ColorImage, max_side: usize) -> ColorImage {
    let [width, height] = colors.size;
    let n = width.max(height).div_ceil(max_side);
    if n <= 1 {
        return colors;
    }
    let pixels = (0..height).step_by(n).flat_map(|y| (0..width).step_by(n).map(move |x| y * width + x));
    let pixels = pixels.map(|i| colors.pixels[i]).collect();
    ColorImage::new([width.div_ceil(n), height.div_ceil(n)], pixels)
}

#[cfg(test)]
mod tests {
    use eframe::egui::Color32;

    use super::*;

    #[test]
    fn large_images_are_thinned_out() {
        let big = ColorImage::new([5, 3], (0..15).map(Color32::from_gray).collect());
        let small = shrunk(big, 3);
        assert_eq!(small.size, [3, 2]);
        assert_eq!(small.pixels[4], Color32::from_gray(12));
    }
}
