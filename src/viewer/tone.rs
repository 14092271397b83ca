//! From radiance to the screen: exposure, offset and a tone curve, looked up in a table.

use eframe::egui::Color32;

use crate::film::png::srgb_byte;

/// How a value is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// The value itself, clipped: dark on screens, which expect sRGB.
    Linear,
    /// sRGB (IEC 61966-2-1), clipped, as in the PNG preview.
    Srgb,
    /// Rolls highlights off (Narkowicz 2015, a fit to the ACES curve), then sRGB.
    Filmic,
}

impl Curve {
    /// In the order in which keys step through them.
    pub const ALL: [Self; 3] = [Self::Srgb, Self::Filmic, Self::Linear];

    /// For the interface.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Srgb => "sRGB",
            Self::Filmic => "filmic",
        }
    }

    fn byte(self, x: f32) -> u8 {
        match self {
            // The cast turns NaN into 0.
            Self::Linear => (255.0 * x.clamp(0.0, 1.0) + 0.5) as u8,
            Self::Srgb => srgb_byte(x),
            Self::Filmic => {
                let x = x.max(0.0);
                srgb_byte((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14))
            }
        }
    }
}

/// What is done to a value before it is shown: `value * 2^exposure + offset`, then the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// In stops.
    pub exposure: f32,
    pub offset: f32,
    pub curve: Curve,
}

impl Default for Tone {
    fn default() -> Self {
        Self { exposure: 0.0, offset: 0.0, curve: Curve::Srgb }
    }
}

impl Tone {
    /// The tone that shows the smallest value black and the largest one white; unchanged where all are alike.
    pub fn normalising(self, pixels: &[[f32; 3]]) -> Self {
        let finite = || pixels.iter().flatten().copied().filter(|v| v.is_finite());
        let (low, high) = finite().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if high <= low {
            return self;
        }
        let scale = 1.0 / (high - low);
        Self { exposure: scale.log2(), offset: -low * scale, ..self }
    }

    /// A table over all values, made anew when the tone changes.
    pub fn table(self) -> Table {
        let bytes = (0..=LAST - FIRST).map(|i| self.curve.byte(f32::from_bits((FIRST + i) << SHIFT))).collect();
        Table { scale: self.exposure.exp2(), offset: self.offset, curve: self.curve, bytes }
    }
}

/// Mantissa bits that are left out: 11 stay, so that a byte is off by less than half a step.
const SHIFT: u32 = 12;
/// Keys of 2^-14, below which every curve is black, and of 2^6, from which on every curve is white.
const FIRST: u32 = (127 - 14) << 11;
const LAST: u32 = (127 + 6) << 11;

/// A tone curve by the upper bits of a float: no power is taken per pixel.
pub struct Table {
    scale: f32,
    offset: f32,
    curve: Curve,
    bytes: Vec<u8>,
}

impl Table {
    /// The colour on the screen of a linear Rec.709 pixel; what is not finite is shown in magenta.
    pub fn color(&self, pixel: [f32; 3]) -> Color32 {
        if !pixel.iter().all(|v| v.is_finite()) {
            return Color32::from_rgb(255, 0, 255);
        }
        let [r, g, b] = pixel.map(|value| self.byte(value * self.scale + self.offset));
        Color32::from_rgb(r, g, b)
    }

    fn byte(&self, x: f32) -> u8 {
        if x <= 0.0 {
            return self.curve.byte(0.0);
        }
        let key = (x.to_bits() >> SHIFT).clamp(FIRST, LAST);
        self.bytes[(key - FIRST) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_curve() {
        for curve in Curve::ALL {
            let table = Tone { curve, ..Tone::default() }.table();
            for i in 0..20_000 {
                let x = 1e-5 * 1.001f32.powi(i);
                let (got, want) = (table.byte(x), curve.byte(x));
                assert!(got.abs_diff(want) <= 1, "{curve:?} of {x}: {got} and {want}");
            }
            assert_eq!([table.byte(0.0), table.byte(-1.0), table.byte(1e9)], [0, 0, 255], "{curve:?}");
        }
    }

    #[test]
    fn exposure_doubles_and_offset_adds() {
        let tone = Tone { exposure: 1.0, offset: 0.25, curve: Curve::Linear };
        assert_eq!(tone.table().color([0.125, 0.0, 1.0]), Color32::from_rgb(128, 64, 255));
        assert_eq!(tone.table().color([f32::NAN, 0.0, 0.0]), Color32::from_rgb(255, 0, 255));
    }

    #[test]
    fn normalising_takes_the_range() {
        let tone = Tone::default().normalising(&[[1.0, 2.0, f32::NAN], [3.0, 5.0, 4.0]]);
        assert_eq!((tone.exposure, tone.offset), (-2.0, -0.25));
        assert_eq!(Tone::default().normalising(&[[1.0; 3]]), Tone::default());
    }
}
