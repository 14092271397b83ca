//! Lights that are no surfaces: points, spots, directions (KHR_lights_punctual), and an environment around the scene.

use glam::Vec3;

/// A light of KHR_lights_punctual: it cannot be hit, only connected to.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    pub kind: LightKind,
    /// Linear Rec.709: radiant intensity (candela as it stands) of a point or spot, irradiance (lux) of a direction.
    pub intensity: Vec3,
}

/// Where a light is, in world space and the file's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    Point {
        position: Vec3,
    },
    /// Full inside the inner cone about `direction` (unit, away from the light), none outside the outer one.
    Spot {
        position: Vec3,
        direction: Vec3,
        inner_cosine: f32,
        outer_cosine: f32,
    },
    /// All light goes along `direction` (unit).
    Directional {
        direction: Vec3,
    },
}

/// Radiance from infinitely far, as an equirectangular image: its centre lies in -z, its upper edge in +y, and +x is to
/// the right of the centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    pub width: u32,
    pub height: u32,
    /// Linear Rec.709, row 0 at the top; finite and not negative.
    pub pixels: Vec<[f32; 3]>,
}

impl Environment {
    /// Weight of each pixel for sampling: solid angle times the mean luminance of what is interpolated over it. Positive
    /// wherever the interpolated radiance is.
    pub fn weights(&self) -> Vec<f64> {
        let (w, h) = (self.width as usize, self.height as usize);
        let luminance = |x: usize, y: usize| {
            let [r, g, b] = self.pixels[y * w + x].map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        // The mean of linear interpolation over a pixel takes an eighth of either neighbour.
        let across = |x: usize, y: usize| {
            0.75 * luminance(x, y) + 0.125 * (luminance((x + w - 1) % w, y) + luminance((x + 1) % w, y))
        };
        let mut weights = Vec::with_capacity(w * h);
        for y in 0..h {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(h - 1));
            let angle = self.solid_angle(y as u32);
            weights
                .extend((0..w).map(|x| angle * (0.75 * across(x, y) + 0.125 * (across(x, above) + across(x, below)))));
        }
        weights
    }

    /// Solid angle of a pixel in row `y`.
    pub fn solid_angle(&self, y: u32) -> f64 {
        use std::f64::consts::PI;
        let edge = |y: u32| (PI * f64::from(y) / f64::from(self.height)).cos();
        2.0 * PI / f64::from(self.width) * (edge(y) - edge(y + 1))
    }

    /// Half as wide and high, each pixel the mean of those it covers.
    pub fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let at = |x: u32, y: u32| {
            let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
            Vec3::from(self.pixels[(y * self.width + x) as usize])
        };
        let mean = |x: u32, y: u32| {
            0.25 * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1))
        };
        let pixels = (0..width * height).map(|i| mean(i % width, i / width).to_array()).collect();
        Self { width, height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_interpolated_power() {
        let mut pixels = vec![[0.0; 3]; 32];
        pixels[8 + 3] = [1.0; 3];
        let environment = Environment { width: 8, height: 4, pixels };
        let weights = environment.weights();
        assert_eq!(weights.iter().filter(|w| **w > 0.0).count(), 9);
        assert!((weights[8 + 3] - 0.5625 * environment.solid_angle(1)).abs() < 1e-6);
        let all: f64 = (0..4).map(|y| 8.0 * environment.solid_angle(y)).sum();
        assert!((all - 4.0 * std::f64::consts::PI).abs() < 1e-12);
        assert_eq!(environment.halved().pixels[1], [0.25; 3]);
    }
}
