//! LDR-FLIP, how different two images look when one alternates between them (Andersson, Nilsson, Akenine-Moller, Oskarsson,
//! Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images"; constants and section numbers are that
//! paper's). Written from the paper.
//!
//! Input is linear Rec. 709, clipped to [0, 1]: what an sRGB display shows of the image without exposure or tone curve.
//! Both are seen from 0.7 m on a screen 0.7 m wide with 3840 pixels, the paper's default.

use std::f64::consts::{PI, SQRT_2};

use super::Image;
use super::metrics::check_sizes;
use crate::Result;

/// Pixels per degree of visual angle, p (section 4.1): distance over the size of a pixel, times a degree.
const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Contrast sensitivity per opponent channel as sums of two Gaussians: (a1, b1, a2, b2) (section 4.1.1, table 1).
const SENSITIVITY: [[f64; 4]; 3] = [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];
/// Largest b of that table, which sets how far the filters reach.
const WIDEST: f64 = 0.04;

/// Exponent of colour differences, and the piecewise linear map of section 4.1.3: up to the share `KNEE` of the largest
/// difference come the values up to `KNEE_VALUE`.
const COLOUR_EXPONENT: f64 = 0.7;
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;

/// Width of the edge and point detectors in degrees, and the exponent of feature differences (section 4.2).
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// White of D65 in XYZ, as linear sRGB (1, 1, 1) gives it.
const WHITE: [f64; 3] = [0.950428545, 1.0, 1.088900371];

/// FLIP's values, 0 (alike) to 1, of every pixel, row by row; images of different sizes are [`crate::Error::Input`].
pub fn flip(image: &Image, reference: &Image) -> Result<Vec<f64>> {
    check_sizes(image.size(), reference.size())?;
    let seen = |image: &Image| Plane {
        width: image.width as usize,
        height: image.height as usize,
        // A value that is no number is seen as black.
        values: image
            .pixels
            .iter()
            .map(|p| ycxcz(p.map(|v| if v > 0.0 { f64::from(v.min(1.0)) } else { 0.0 })))
            .collect(),
    };
    let [a, b] = [seen(image), seen(reference)];
    let (colours_a, colours_b) = (colours(&a), colours(&b));
    let (features_a, features_b) = (features(&a), features(&b));
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT);
    let values = (0..image.pixels.len()).map(|i| {
        let colour = redistributed(hyab(colours_a[i], colours_b[i]).powf(COLOUR_EXPONENT), largest);
        let difference = |k: usize| (features_a[i][k] - features_b[i][k]).abs();
        let feature = (difference(0).max(difference(1)) / SQRT_2).powf(FEATURE_EXPONENT);
        colour.powf(1.0 - feature)
    });
    Ok(values.collect())
}

/// Mean of FLIP's values.
pub fn mean_flip(image: &Image, reference: &Image) -> Result<f64> {
    let values = flip(image, reference)?;
    Ok(values.iter().sum::<f64>() / values.len().max(1) as f64)
}

/// An image of three values a pixel.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<[f64; 3]>,
}

impl Plane {
    /// Each channel filtered by its `kernel`, of 2 r + 1 taps, along rows or columns; the border's values go on outside.
    fn filtered(&self, kernels: [&[f64]; 3], along_rows: bool) -> Self {
        let radius = (kernels[0].len() / 2) as isize;
        let (width, height) = (self.width as isize, self.height as isize);
        let mut values = Vec::with_capacity(self.values.len());
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 3];
                for tap in -radius..=radius {
                    let at = if along_rows {
                        y * width + (x + tap).clamp(0, width - 1)
                    } else {
                        (y + tap).clamp(0, height - 1) * width + x
                    };
                    let value = &self.values[at as usize];
                    for c in 0..3 {
                        sum[c] += kernels[c][(tap + radius) as usize] * value[c];
                    }
                }
                values.push(sum);
            }
        }
        Self { values, ..*self }
    }
}

/// What the eye resolves of the colours (section 4.1.1), in L*a*b* after Hunt's effect (section 4.1.2).
fn colours(image: &Plane) -> Vec<[f64; 3]> {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    // A Gaussian over the film is one along rows, then one along columns; a sum of two takes both apart.
    let gaussian = |b: f64| -> Vec<f64> {
        let at = |x: i32| (-(PI * f64::from(x) / PIXELS_PER_DEGREE).powi(2) / b).exp();
        (-radius..=radius).map(at).collect()
    };
    let mut total = [0.0; 3];
    let mut sum = vec![[0.0; 3]; image.values.len()];
    for term in 0..2 {
        let [a, b] = [2 * term, 2 * term + 1].map(|i| SENSITIVITY.map(|channel| channel[i]));
        if a.iter().all(|a| *a == 0.0) {
            continue;
        }
        let kernels = b.map(gaussian);
        let kernels = [0, 1, 2].map(|c| kernels[c].as_slice());
        let filtered = image.filtered(kernels, true).filtered(kernels, false);
        let factor = [0, 1, 2].map(|c| a[c] * (PI / b[c]).sqrt());
        for c in 0..3 {
            total[c] += factor[c] * kernels[c].iter().sum::<f64>().powi(2);
        }
        for (sum, value) in sum.iter_mut().zip(&filtered.values) {
            (0..3).for_each(|c| sum[c] += factor[c] * value[c]);
        }
    }
    let resolved = sum.iter().map(|sum| {
        let [y, cx, cz] = [0, 1, 2].map(|c| sum[c] / total[c]);
        hunt_lab(rgb_of_ycxcz([y, cx, cz]).map(|v| v.clamp(0.0, 1.0)))
    });
    resolved.collect()
}

/// Strength of edges and of points in every pixel's luminance (section 4.2).
fn features(image: &Plane) -> Vec<[f64; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let gaussian = |x: f64| (-0.5 * (x / deviation).powi(2)).exp();
    let taps = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { (-radius..=radius).map(|x| f(f64::from(x))).collect() };
    let smooth = taps(&gaussian);
    // First and second derivative of the Gaussian; positive and negative weights each sum to 1.
    let edge = balanced(taps(&|x| -x * gaussian(x)));
    let point = balanced(taps(&|x| ((x / deviation).powi(2) - 1.0) * gaussian(x)));
    let total: f64 = smooth.iter().sum();
    let smooth: Vec<f64> = smooth.iter().map(|v| v / total).collect();
    let luminance = Plane { values: image.values.iter().map(|v| [(v[0] + 16.0) / 116.0; 3]).collect(), ..*image };
    let kernels: [[&[f64]; 3]; 2] = [[&edge, &point, &smooth], [&smooth, &smooth, &smooth]];
    let horizontal = luminance.filtered(kernels[0], true).filtered(kernels[1], false);
    let vertical = luminance.filtered(kernels[0], false).filtered(kernels[1], true);
    let strength = horizontal.values.iter().zip(&vertical.values).map(|(h, v)| [h[0].hypot(v[0]), h[1].hypot(v[1])]);
    strength.collect()
}

/// Positive weights scaled to sum 1, and negative ones to sum -1.
fn balanced(weights: Vec<f64>) -> Vec<f64> {
    let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
    weights.iter().map(|w| if *w > 0.0 { w / positive } else { w / negative }).collect()
}

/// Small differences, up to the knee, take most of the range (section 4.1.3).
fn redistributed(difference: f64, largest: f64) -> f64 {
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}

/// Distance of two colours in L*a*b*: city block in lightness, Euclidean in chroma (Abasi et al. 2020).
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// XYZ relative to white of linear sRGB (IEC 61966-2-1).
fn xyz([r, g, b]: [f64; 3]) -> [f64; 3] {
    let rows = [
        [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
        [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
        [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
    ];
    [0, 1, 2].map(|i| (rows[i][0] * r + rows[i][1] * g + rows[i][2] * b) / WHITE[i])
}

/// The linear opponent space YCxCz.
fn ycxcz(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_of_ycxcz([luma, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (luma + 16.0) / 116.0;
    let [x, z] = [(y + cx / 500.0) * WHITE[0], (y - cz / 200.0) * WHITE[2]];
    // The inverse of the matrix above.
    [
        3.241003275 * x - 1.537398934 * y - 0.498615861 * z,
        -0.969224334 * x + 1.875930071 * y + 0.041554224 * z,
        0.055639423 * x - 0.204011202 * y + 1.057148933 * z,
    ]
}

/// L*a*b* of linear sRGB, the chroma scaled by lightness (Hunt's effect).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Image { width, height, pixels }
    }

    fn of_constants(a: [f32; 3], b: [f32; 3]) -> f64 {
        let [a, b] = [a, b].map(|colour| image(5, 4, |_, _| colour));
        let values = flip(&a, &b).unwrap();
        assert!(values.iter().all(|v| (v - values[0]).abs() < 1e-9));
        values[0]
    }

    #[test]
    fn constant_colours_by_hand() {
        assert_eq!(of_constants([0.3, 0.5, 0.1], [0.3, 0.5, 0.1]), 0.0);
        // Green and blue are the largest difference there is.
        assert!((of_constants([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]) - 1.0).abs() < 1e-6);
        // Black and white: HyAB 100; green and blue 203.25 apart, so 100^0.7 = 25.119 of 41.26, beyond the knee at 16.5.
        assert!((of_constants([0.0; 3], [1.0; 3]) - 0.9674).abs() < 5e-4);
        // By the authors' own program.
        assert!((of_constants([0.2, 0.3, 0.4], [0.25, 0.3, 0.38]) - 0.14389).abs() < 5e-4);
        // What a display cannot show makes no difference.
        assert_eq!(of_constants([1.0; 3], [7.0, 2.0, f32::INFINITY]), 0.0);
        assert_eq!(of_constants([0.0; 3], [-1.0, f32::NAN, 0.0]), 0.0);
    }

    #[test]
    fn space_turns_both_ways_and_does_not_matter() {
        let a = image(23, 17, |x, y| [(x * y % 7) as f32 / 7.0, x as f32 / 23.0, (y % 5) as f32 / 5.0]);
        let b = image(23, 17, |x, y| [(x * y % 5) as f32 / 5.0, x as f32 / 23.0, (y % 4) as f32 / 5.0]);
        let turned = |image: &Image| {
            let at = |x: u32, y: u32| image.pixels[(x * image.width + y) as usize];
            self::image(image.height, image.width, at)
        };
        let straight = flip(&a, &b).unwrap();
        assert!(straight.iter().all(|v| (0.0..=1.0).contains(v)));
        assert_eq!(straight, flip(&b, &a).unwrap());
        let other = flip(&turned(&a), &turned(&b)).unwrap();
        for y in 0..17 {
            for x in 0..23 {
                assert!((straight[y * 23 + x] - other[x * 17 + y]).abs() < 1e-9);
            }
        }
    }

    /// Means by the authors' own program (`flip-evaluator` 1.7 of the Python package index) of the same values.
    #[test]
    fn patterns_agree_with_the_authors_program() {
        let wave = |x: u32, y: u32, k: f32| 0.5 + 0.5 * (k * x as f32 + 0.5 * y as f32).sin();
        let a = image(64, 48, |x, y| [wave(x, y, 0.3), wave(y, x, 0.2), wave(x, y, 0.7)]);
        let b = image(64, 48, |x, y| [wave(x, y, 0.35), wave(y, x, 0.2), 0.5]);
        let grain = image(64, 48, |x, y| {
            a.pixels[(y * 64 + x) as usize].map(|v| v + if (x + y) % 2 == 0 { 0.2 } else { -0.2 })
        });
        let found = [mean_flip(&b, &a).unwrap(), mean_flip(&grain, &a).unwrap()];
        assert!((found[0] - 0.53369).abs() < 1e-3 && (found[1] - 0.24800).abs() < 1e-3, "{found:?}");
    }
}
