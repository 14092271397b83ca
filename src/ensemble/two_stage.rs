//! The two-stage target (METHOD.md 1.4 and 5, item 1): chains have the law of I / w(p), w = (luminance of a pilot)^gamma.
//!
//! Samples then spread over the film in proportion to I^(1 - gamma), while splats count w(p): dark parts get more of them.
//! Any positive w that is fixed before the run leaves the image's expectation alone, so the pilot may be as coarse as few
//! candidates make it: tiles, smoothed.

use crate::gpu::layout::{WEIGHT_ENTRIES, WEIGHT_TILES};

/// Least w, over its mean on the film: the pilot may have missed light there.
const FLOOR: f64 = 0.05;
/// Largest share of one candidate in the pilot's light: a chance find says little about its tile.
const LARGEST_SHARE: f64 = 1e-3;

/// w(p) by tiles of the film.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelWeights {
    film: [u32; 2],
    /// In (0, 1], so that no splat is heavier than under the plain target.
    weights: [f32; WEIGHT_ENTRIES],
}

impl PixelWeights {
    /// From pilot candidates: positions on the film in pixels, and I / density.
    pub fn from_pilot(film: [u32; 2], gamma: f64, pilot: &[([f32; 2], f64)]) -> Self {
        let mut this = Self { film, weights: [1.0; WEIGHT_ENTRIES] };
        let total: f64 = pilot.iter().map(|(_, weight)| weight).sum();
        if total <= 0.0 {
            return this;
        }
        let mut light = vec![0.0; WEIGHT_ENTRIES];
        for (position, weight) in pilot {
            light[this.tile(this.pixel(*position))] += weight.min(LARGEST_SHARE * total);
        }
        let mut area = vec![0.0; WEIGHT_ENTRIES];
        for y in 0..film[1] {
            (0..film[0]).for_each(|x| area[this.tile([x, y])] += 1.0);
        }
        let smooth: Vec<f64> =
            blurred(&light).iter().zip(blurred(&area)).map(|(l, a)| (l / a.max(1e-9)).powf(gamma)).collect();
        let mean = smooth.iter().zip(&area).map(|(w, a)| w * a).sum::<f64>() / area.iter().sum::<f64>();
        let floored: Vec<f64> = smooth.iter().map(|w| w.max(FLOOR * mean)).collect();
        let largest = floored.iter().zip(&area).filter(|(_, a)| **a > 0.0).map(|(w, _)| *w).fold(0.0, f64::max);
        for ((w, floored), area) in this.weights.iter_mut().zip(floored).zip(area) {
            if area > 0.0 {
                *w = (floored / largest) as f32;
            }
        }
        this
    }

    /// Pixel of a position, clamped to the film as in shaders/target/film.wesl.
    fn pixel(&self, position: [f32; 2]) -> [u32; 2] {
        [0, 1].map(|i| (position[i].max(0.0) as u32).min(self.film[i] - 1))
    }

    /// Twin: `pixel_weight` in shaders/target/two_stage.wesl.
    fn tile(&self, [x, y]: [u32; 2]) -> usize {
        let side = self.film[0].max(self.film[1]).div_ceil(WEIGHT_TILES);
        (y / side * WEIGHT_TILES + x / side) as usize
    }

    /// w at a position in pixels.
    pub fn at(&self, position: [f32; 2]) -> f64 {
        f64::from(self.weights[self.tile(self.pixel(position))])
    }

    /// w of a pixel, by its number.
    pub fn of_pixel(&self, number: u32) -> f64 {
        f64::from(self.weights[self.tile([number % self.film[0], number / self.film[0]])])
    }

    /// Mean of w over the film's pixels.
    pub fn mean(&self) -> f64 {
        let pixels = self.film[0] * self.film[1];
        (0..pixels).map(|number| self.of_pixel(number)).sum::<f64>() / f64::from(pixels)
    }

    /// As the shaders read it.
    pub fn table(&self) -> &[f32; WEIGHT_ENTRIES] {
        &self.weights
    }
}

/// Sums over neighbouring tiles with binomial weights 1 4 6 4 1 both ways; there is nothing outside.
fn blurred(tiles: &[f64]) -> Vec<f64> {
    const BINOMIAL: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
    let side = WEIGHT_TILES as usize;
    let along = |tiles: &[f64], step: usize| -> Vec<f64> {
        let term = |i: usize, n: usize| {
            let place = (i / step % side + n).checked_sub(2).filter(|place| *place < side)?;
            Some(BINOMIAL[n] / 16.0 * tiles[i - i / step % side * step + place * step])
        };
        (0..tiles.len()).map(|i| (0..5).filter_map(|n| term(i, n)).sum()).collect()
    };
    along(&along(tiles, 1), side)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pilot of one candidate in every pixel, with `weight` of it.
    fn pilot([width, height]: [u32; 2], weight: impl Fn(u32, u32) -> f64) -> Vec<([f32; 2], f64)> {
        let pixels = (0..width * height).map(|i| (i % width, i / width));
        pixels.map(|(x, y)| ([x as f32 + 0.5, y as f32 + 0.5], weight(x, y))).collect()
    }

    #[test]
    fn an_even_film_has_even_weights() {
        for film in [[33, 25], [640, 480], [1, 1], [7, 1000]] {
            let weights = PixelWeights::from_pilot(film, 0.5, &pilot(film, |_, _| 2.0));
            for number in 0..film[0] * film[1] {
                assert!((weights.of_pixel(number) - 1.0).abs() < 1e-6, "{film:?} {number}");
            }
        }
        let none = PixelWeights::from_pilot([8, 8], 0.5, &pilot([8, 8], |_, _| 0.0));
        assert!(none.weights.iter().all(|w| *w == 1.0));
    }

    #[test]
    fn weights_are_powers_of_the_pilot_above_a_floor() {
        let film = [128, 96];
        let step = |x: u32| {
            if x < 32 {
                1.0
            } else if x < 80 {
                0.25
            } else {
                0.0
            }
        };
        let list = pilot(film, |x, _| step(x));
        for gamma in [0.0, 0.5, 1.0] {
            let weights = PixelWeights::from_pilot(film, gamma, &list);
            // Away from the edges of the steps, by more than two tiles of 4 pixels.
            assert_eq!(weights.at([4.5, 50.0]), 1.0);
            assert!((weights.at([52.0, 7.0]) - 0.25f64.powf(gamma)).abs() < 1e-6);
            let dark = weights.at([120.0, 90.0]);
            let mean = (0..film[0] * film[1]).map(|n| weights.of_pixel(n)).sum::<f64>() / 12288.0;
            assert!(gamma == 0.0 || (dark / mean / FLOOR - 1.0).abs() < 0.1, "{dark} {mean}");
            assert_eq!(weights.at([-1.0, 1e9]), weights.of_pixel(95 * 128));
        }
    }
}
