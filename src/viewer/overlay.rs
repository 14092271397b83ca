//! What can be laid over a picture: maps in false colours, and the reference.

use eframe::egui::{Color32, ColorImage, Ui};

use super::app::{Note, Viewer};
use super::messages::Picture;
use super::tone::Tone;
use crate::film::Image;
use crate::film::png::{self, direction_color};
use crate::kernels;

/// Of pixels of which the map tells nothing.
pub const UNKNOWN: Color32 = Color32::from_gray(90);

/// A map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Where accepted perturbations move.
    Directions,
    /// The share of a kernel's proposals that was accepted, by the pixel from which they were made.
    Acceptance(&'static str),
    /// The standard error that the image tells of itself, relative.
    OwnError,
    /// The relative error against the reference.
    ReferenceError,
}

impl Layer {
    /// For the interface.
    pub fn name(self) -> String {
        match self {
            Self::Directions => "mutation directions".into(),
            Self::Acceptance(kernel) => format!("acceptance of {kernel}"),
            Self::OwnError => "its own error".into(),
            Self::ReferenceError => "error to the reference".into(),
        }
    }

    /// Where the kinds keep how opaque they are.
    pub fn kind(self) -> usize {
        match self {
            Self::Directions => 0,
            Self::Acceptance(_) => 1,
            Self::OwnError => 2,
            Self::ReferenceError => 3,
        }
    }
}

/// What is laid over the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlay {
    pub layer: Option<Layer>,
    /// Its share in what is seen, in [0, 1].
    pub share: f32,
    /// The reference alone, instead of all else.
    pub reference: bool,
}

/// A map's values, for a picture that has them.
pub enum Values<'a> {
    Directions(&'a [Vec<f32>; 2]),
    /// From 0 to 1; NaN is unknown.
    Acceptance(&'a [f32]),
    /// Errors by pixel, and what they are relative to.
    Own(&'a Image, &'a Image),
    /// The picture and the reference.
    Reference(&'a Image, &'a Image),
}

impl Values<'_> {
    /// What `layer` tells of a picture; none where it does not tell anything.
    pub fn of<'a>(layer: Layer, picture: &'a Picture, reference: Option<&'a Image>) -> Option<Values<'a>> {
        let image = picture.image.as_deref()?;
        let fits = |other: &&Image| other.size() == image.size();
        match layer {
            Layer::Directions => picture.maps.as_deref().map(Values::Directions),
            Layer::Acceptance(kernel) => {
                let of_kernel = picture.acceptance.iter().flat_map(|all| all.iter()).find(|(name, _)| name == kernel);
                of_kernel.map(|(_, values)| Values::Acceptance(values))
            }
            Layer::OwnError => {
                picture.own.as_deref().map(|own| &own.pixels).filter(fits).map(|e| Values::Own(e, image))
            }
            Layer::ReferenceError => reference.filter(fits).map(|reference| Values::Reference(image, reference)),
        }
    }

    /// The share that the colour of a pixel stands for; none of directions, which have two.
    pub fn share(&self, pixel: usize) -> Option<f32> {
        match self {
            Self::Directions(_) => None,
            Self::Acceptance(values) => Some(values[pixel]).filter(|share| !share.is_nan()),
            Self::Own(errors, image) => {
                let error = errors.pixels[pixel];
                // Where no light has been seen yet, nothing is known of it either.
                (error != [0.0; 3]).then(|| relative(error, image.pixels[pixel]))
            }
            Self::Reference(image, reference) => {
                let (a, r) = (image.pixels[pixel], reference.pixels[pixel]);
                Some(relative([0, 1, 2].map(|c| a[c] - r[c]), r))
            }
        }
    }

    fn color(&self, pixel: usize) -> Color32 {
        match self {
            Self::Directions([horizontal, vertical]) => {
                let [r, g, b] = direction_color(horizontal[pixel], vertical[pixel]);
                Color32::from_rgb(r, g, b)
            }
            _ => self.share(pixel).map_or(UNKNOWN, heat),
        }
    }
}

impl Viewer {
    /// What lies over the pictures now; the reference is seen while Shift is held, as in tev.
    pub(super) fn overlay(&self, ui: &Ui) -> Overlay {
        let free = ui.ctx().input(|i| i.modifiers.shift_only() && !i.pointer.any_down());
        let reference = free && self.reference.is_some() && !ui.ctx().egui_wants_keyboard_input();
        Overlay { layer: self.layer, share: self.layer.map_or(0.0, |layer| self.shares[layer.kind()]), reference }
    }

    /// Lays a map over the pictures, or takes it away where it is there.
    pub(super) fn toggle(&mut self, layer: Layer) {
        self.layer = if self.layer == Some(layer) { None } else { Some(layer) };
    }

    /// The kernels at work in any picture, in the order of the list of all.
    pub(super) fn kernels_at_work(&self) -> Vec<&'static str> {
        let works = |name: &str| {
            let mut all = self.slots.iter().flat_map(|slot| &slot.picture.statistics.kernels);
            all.any(|kernel| kernel.name == name)
        };
        kernels::ALL.iter().map(|kernel| kernel.name).filter(|name| works(name)).collect()
    }

    /// The acceptance of the kernel that was looked at last, or of the one that makes most mutations.
    pub(super) fn acceptance(&self) -> Option<Layer> {
        let names = self.kernels_at_work();
        let all = self.slots.iter().flat_map(|slot| &slot.picture.statistics.kernels);
        let most = all.max_by_key(|kernel| kernel.mutations).map(|kernel| kernel.name.clone());
        let of = |wanted: Option<&str>| names.iter().copied().find(|name| Some(*name) == wanted);
        of(self.kernel).or_else(|| of(most.as_deref())).map(Layer::Acceptance)
    }

    pub(super) fn toggle_acceptance(&mut self) {
        match (self.layer, self.acceptance()) {
            (Some(Layer::Acceptance(_)), _) => self.layer = None,
            (_, Some(layer)) => self.look_at(layer),
            _ => self.note = Some(Note { text: "no kernel has made mutations yet".into(), error: false }),
        }
    }

    /// Lays a map over the pictures.
    pub(super) fn look_at(&mut self, layer: Layer) {
        self.layer = Some(layer);
        if let Layer::Acceptance(kernel) = layer {
            self.kernel = Some(kernel);
        }
    }

    /// From kernel to kernel, and past the last to none.
    pub(super) fn next_acceptance(&mut self, forwards: bool) {
        let mut layers: Vec<Option<Layer>> = vec![None];
        layers.extend(self.kernels_at_work().into_iter().map(|kernel| Some(Layer::Acceptance(kernel))));
        let Some(at) = layers.iter().position(|layer| *layer == self.layer) else {
            return self.toggle_acceptance();
        };
        match layers[(at + if forwards { 1 } else { layers.len() - 1 }) % layers.len()] {
            Some(layer) => self.look_at(layer),
            None => self.layer = None,
        }
    }
}

/// The colours on the screen, pixel by pixel.
pub fn develop(
    image: &Image,
    picture: &Picture,
    tone: Tone,
    overlay: Overlay,
    reference: Option<&Image>,
) -> ColorImage {
    let table = tone.table();
    let fitting = reference.filter(|r| r.size() == image.size());
    let shown = if overlay.reference { fitting.unwrap_or(image) } else { image };
    let layer = overlay.layer.filter(|_| !overlay.reference && overlay.share > 0.0);
    let values = layer.and_then(|layer| Values::of(layer, picture, reference));
    let plain = |pixel: &[f32; 3]| table.color(*pixel);
    let colors = match values {
        None => shown.pixels.iter().map(plain).collect(),
        Some(values) if overlay.share >= 1.0 => (0..shown.pixels.len()).map(|pixel| values.color(pixel)).collect(),
        Some(values) => {
            let blended = |(i, pixel)| plain(pixel).lerp_to_gamma(values.color(i), overlay.share);
            shown.pixels.iter().enumerate().map(blended).collect()
        }
    };
    ColorImage::new([image.width as usize, image.height as usize], colors)
}

/// The size of an error beside a value, which is floored at a hundredth of white.
fn relative(error: [f32; 3], value: [f32; 3]) -> f32 {
    let sum = |v: [f32; 3]| v.iter().map(|v| v.abs()).sum::<f32>();
    sum(error) / (sum(value) + 0.03)
}

/// From black (none) to pale yellow (all, or more); what is no number is magenta.
pub fn heat(share: f32) -> Color32 {
    if share.is_nan() {
        return Color32::from_rgb(255, 0, 255);
    }
    let [r, g, b] = png::heat(f64::from(share));
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::messages::OwnError;
    use super::*;

    fn image(pixels: &[[f32; 3]]) -> Image {
        Image { width: pixels.len() as u32, height: 1, pixels: pixels.to_vec() }
    }

    fn over(layer: Layer, share: f32) -> Overlay {
        Overlay { layer: Some(layer), share, reference: false }
    }

    /// The colours of two pixels under a layer.
    fn shown(a: &[[f32; 3]], picture: Picture, overlay: Overlay, reference: Option<&Image>) -> Vec<Color32> {
        let picture = Picture { image: Some(Arc::new(image(a))), ..picture };
        develop(&image(a), &picture, Tone::default(), overlay, reference).pixels
    }

    #[test]
    fn maps_are_blended_over_the_picture() {
        let color = |share| {
            let picture = Picture { maps: Some(Arc::new([vec![1.0], vec![0.0]])), ..Picture::default() };
            shown(&[[1.0; 3]], picture, over(Layer::Directions, share), None)[0]
        };
        assert_eq!(color(0.0), Color32::WHITE);
        assert_eq!(color(1.0), Color32::RED);
        assert_eq!(color(0.5), Color32::from_rgb(255, 128, 128));
    }

    #[test]
    fn acceptance_is_that_of_the_kernel() {
        let acceptance = vec![("lens".to_string(), vec![0.25, f32::NAN]), ("caustic".into(), vec![1.0, 0.0])];
        let colors = |kernel| {
            let picture = Picture { acceptance: Some(Arc::new(acceptance.clone())), ..Picture::default() };
            shown(&[[1.0; 3]; 2], picture, over(Layer::Acceptance(kernel), 1.0), None)
        };
        assert_eq!(colors("lens"), [heat(0.25), UNKNOWN]);
        assert_eq!(colors("caustic"), [heat(1.0), heat(0.0)]);
        assert_eq!(colors("guided-lens"), [Color32::WHITE; 2], "the method has no such kernel");
    }

    #[test]
    fn errors_are_hot_and_agreement_is_black() {
        let a = [[1.0; 3], [2.0; 3]];
        let colors = |r: &[[f32; 3]]| shown(&a, Picture::default(), over(Layer::ReferenceError, 1.0), Some(&image(r)));
        assert_eq!(colors(&[[1.0; 3]; 2]), [heat(0.0), heat(3.0 / 3.03)]);
        assert_eq!(colors(&[[1.0; 3]])[0], Color32::WHITE, "a reference of another size cannot be compared");
    }

    #[test]
    fn what_the_image_tells_of_itself_is_hot_too() {
        let own = OwnError { seconds: 1.0, relative: 0.5, pixels: image(&[[0.0; 3], [1.98; 3]]) };
        let told = Picture { own: Some(Arc::new(own)), ..Picture::default() };
        let colors = |picture| shown(&[[1.0; 3], [1.97; 3]], picture, over(Layer::OwnError, 1.0), None);
        assert_eq!(colors(told), [UNKNOWN, heat(1.0)]);
        assert_eq!(colors(Picture::default())[0], Color32::WHITE, "not told yet");
    }
}
