//! One picture of the window: what the renderer sent last, and the colours that show it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use eframe::egui::{Color32, ColorImage};

use super::messages::{ErrorPoint, Picture};
use super::tone::Tone;
use crate::film::Image;
use crate::film::png::direction_color;
use crate::methods::{Settings, Stage};

/// Of pixels whose error nothing tells.
const UNKNOWN: Color32 = Color32::from_gray(90);

/// Counts the colours made by all slots.
static MADE: AtomicU64 = AtomicU64::new(1);

/// Which error is shown in false colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorMap {
    /// That against the reference.
    Reference,
    /// The standard error that the image tells of itself.
    Own,
}

/// What is laid over the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// Share of the mutation-direction maps in what is seen, in [0, 1].
    pub maps: f32,
    /// A relative error in false colours, instead of the picture.
    pub error: Option<ErrorMap>,
    /// The reference instead of the picture.
    pub reference: bool,
}

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
        overlay: &Overlay,
        reference: Option<&Image>,
        max_side: usize,
    ) -> Option<(Arc<ColorImage>, u64)> {
        let image = self.picture.image.as_ref()?;
        if self.made_with.as_ref().is_none_or(|(t, o)| *t != tone || o != overlay) {
            let colors = develop(image, &self.picture, tone, overlay, reference);
            self.colors = Arc::new(shrunk(colors, max_side));
            self.version = MADE.fetch_add(1, Ordering::Relaxed);
            self.made_with = Some((tone, overlay.clone()));
        }
        Some((Arc::clone(&self.colors), self.version))
    }
}

/// The colours on the screen, pixel by pixel.
fn develop(image: &Image, picture: &Picture, tone: Tone, overlay: &Overlay, reference: Option<&Image>) -> ColorImage {
    let table = tone.table();
    let reference = reference.filter(|r| (r.width, r.height) == (image.width, image.height));
    let shown = if overlay.reference { reference.unwrap_or(image) } else { image };
    let own = picture.own.as_deref().map(|own| &own.pixels).filter(|e| e.pixels.len() == image.pixels.len());
    let pairs = image.pixels.iter();
    let mut colors: Vec<Color32> = match (overlay.error.filter(|_| !overlay.reference), reference, own) {
        (Some(ErrorMap::Reference), Some(reference), _) => {
            pairs.zip(&reference.pixels).map(|(a, r)| error_color([0, 1, 2].map(|c| a[c] - r[c]), *r)).collect()
        }
        (Some(ErrorMap::Own), _, Some(own)) => {
            // Where no light has been seen yet, nothing is known of it either.
            let color = |a: &[f32; 3], e: &[f32; 3]| if *e == [0.0; 3] { UNKNOWN } else { error_color(*e, *a) };
            pairs.zip(&own.pixels).map(|(a, e)| color(a, e)).collect()
        }
        _ => shown.pixels.iter().map(|pixel| table.color(*pixel)).collect(),
    };
    if let Some([horizontal, vertical]) = picture.maps.as_deref().filter(|_| overlay.maps > 0.0) {
        for ((color, h), v) in colors.iter_mut().zip(horizontal).zip(vertical) {
            let [r, g, b] = direction_color(*h, *v);
            *color = color.lerp_to_gamma(Color32::from_rgb(r, g, b), overlay.maps);
        }
    }
    ColorImage::new([image.width as usize, image.height as usize], colors)
}

/// The colour of an error beside a value: [`heat`] of their ratio, floored at a hundredth of white.
fn error_color(error: [f32; 3], value: [f32; 3]) -> Color32 {
    let sum = |v: [f32; 3]| v.iter().map(|v| v.abs()).sum::<f32>();
    heat(sum(error) / (sum(value) + 0.03))
}

/// From black (no error) over purple and orange to pale yellow (an error of 100 % and more).
pub fn heat(share: f32) -> Color32 {
    const STOPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 4.0], [87.0, 16.0, 110.0], [188.0, 55.0, 84.0], [249.0, 142.0, 9.0], [252.0, 255.0, 164.0]];
    if share.is_nan() {
        return Color32::from_rgb(255, 0, 255);
    }
    let at = 4.0 * share.clamp(0.0, 1.0);
    let (low, part) = ((at as usize).min(3), at - at.floor().min(3.0));
    let [r, g, b] = [0, 1, 2].map(|c| (STOPS[low][c] + part * (STOPS[low + 1][c] - STOPS[low][c])) as u8);
    Color32::from_rgb(r, g, b)
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
    use super::super::messages::OwnError;
    use super::*;

    fn image(pixels: &[[f32; 3]]) -> Image {
        Image { width: pixels.len() as u32, height: 1, pixels: pixels.to_vec() }
    }

    #[test]
    fn maps_are_blended_over_the_picture() {
        let overlay = |maps| Overlay { maps, error: None, reference: false };
        let picture = Picture { maps: Some(Arc::new([vec![1.0], vec![0.0]])), ..Picture::default() };
        let color = |share| develop(&image(&[[1.0; 3]]), &picture, Tone::default(), &overlay(share), None).pixels[0];
        assert_eq!(color(0.0), Color32::WHITE);
        assert_eq!(color(1.0), Color32::RED);
        assert_eq!(color(0.5), Color32::from_rgb(255, 128, 128));
    }

    #[test]
    fn errors_are_hot_and_agreement_is_black() {
        let overlay = Overlay { maps: 0.0, error: Some(ErrorMap::Reference), reference: false };
        let picture = Picture::default();
        let (a, r) = (image(&[[1.0; 3], [2.0; 3]]), image(&[[1.0; 3], [1.0; 3]]));
        let colors = develop(&a, &picture, Tone::default(), &overlay, Some(&r)).pixels;
        assert_eq!(colors[0], heat(0.0));
        assert_eq!(colors[1], heat(0.99));
        // A reference of another size cannot be compared.
        let colors = develop(&a, &picture, Tone::default(), &overlay, Some(&image(&[[1.0; 3]]))).pixels;
        assert_eq!(colors[0], Color32::WHITE);
    }

    #[test]
    fn what_the_image_tells_of_itself_is_hot_too() {
        let own = OwnError { seconds: 1.0, relative: 0.5, pixels: image(&[[0.0; 3], [1.98; 3]]) };
        let picture = Picture { own: Some(Arc::new(own)), ..Picture::default() };
        let overlay = Overlay { maps: 0.0, error: Some(ErrorMap::Own), reference: false };
        let shown =
            |picture| develop(&image(&[[1.0; 3], [1.97; 3]]), picture, Tone::default(), &overlay, None).pixels.clone();
        assert_eq!(shown(&picture), [UNKNOWN, heat(1.0)]);
        assert_eq!(shown(&Picture::default())[0], Color32::WHITE, "not told yet");
    }

    #[test]
    fn large_images_are_thinned_out() {
        let big = ColorImage::new([5, 3], (0..15).map(Color32::from_gray).collect());
        let small = shrunk(big, 3);
        assert_eq!(small.size, [3, 2]);
        assert_eq!(small.pixels[4], Color32::from_gray(12));
    }
}
