//! How uncertain an image is, by itself: variances at three scales, pixels, tiles and the whole film.
//!
//! What makes an image uncertain comes from up to three places, which are independent, so that variances add:
//! - groups: the scatter of R independent ensembles' images (METHOD.md 5.10), with R - 1 degrees of freedom. It knows
//!   of the correlation between pixels that one path has visited, so tiles have a scatter of their own.
//! - samples: the scatter of a path tracer's samples, which are independent from pixel to pixel; a tile's variance
//!   follows from its pixels'.
//! - scale: the relative error of b (or of what stands in for it under a two-stage target), by which all that chains
//!   have made is multiplied alike.
//!
//! Relative errors are the roots of what relMSE of [`super::metrics`] would be against the truth: of the mean over cells
//! and channels of variance / (truth^2 + 0.01 m^2), m the mean luminance. What stands in for the truth must not be made
//! of the noise that it is to divide: a pixel that is bright by chance would hide its own error, and an image of few samples
//! would seem exact. So the scatter of a group is divided by what the other groups have in the pixel and the 24 around it,
//! and that of a pixel's samples by what those 24 have.
//!
//! The scale and the groups share the start's candidates, and are taken as independent all the same: that is so once the
//! chains have forgotten their start, and for the whole film's luminance always, which each group has by construction.

use super::Image;
use super::cells::{Tiling, around};
use crate::report::student::critical_between;
use crate::scene::LUMINANCE;

/// Share of the squared mean luminance in the denominator of relative errors, as in [`super::metrics`].
const FLOOR: f64 = 0.01;
/// R, G, B, luminance.
pub const CHANNELS: usize = 4;
/// The channel of luminance.
pub const Y: usize = 3;

/// One value with the variances of its mean.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// In radiance.
    pub mean: f64,
    /// Variance by the scatter of groups.
    pub of_groups: f64,
    /// Degrees of freedom of that.
    pub groups_dof: f64,
    /// Variance by the scatter of independent samples.
    pub of_samples: f64,
    /// Variance by the common scale.
    pub of_scale: f64,
}

impl Estimate {
    pub fn variance(&self) -> f64 {
        self.of_groups + self.of_samples + self.of_scale
    }

    pub fn standard_error(&self) -> f64 {
        self.variance().sqrt()
    }

    /// Degrees of freedom of the sum of variances (Satterthwaite 1946): those of the groups' where these are all of it,
    /// and the more the less they are, since the others come from very many samples.
    pub fn dof(&self) -> f64 {
        if self.of_groups > 0.0 { self.groups_dof * (self.variance() / self.of_groups).powi(2) } else { f64::INFINITY }
    }

    /// Half the width of the interval about the mean that misses the truth with probability `p`.
    pub fn half_width(&self, p: f64) -> f64 {
        critical_between(p, self.dof()) * self.standard_error()
    }

    /// Both of independent parts of one value.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            mean: self.mean + other.mean,
            of_groups: self.of_groups + other.of_groups,
            groups_dof: self.groups_dof.max(other.groups_dof),
            of_samples: self.of_samples + other.of_samples,
            of_scale: self.of_scale + other.of_scale,
        }
    }
}

/// The uncertainty of one image.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Independent groups of chains; 0 without chains.
    pub groups: u32,
    /// Standard error of every pixel's R, G and B, all parts of it.
    pub pixels: Image,
    /// Tiles of [`super::cells::TILE`] pixels, row by row, and how many there are in a row; R, G, B and luminance of each.
    pub tiles: Vec<[Estimate; CHANNELS]>,
    pub tile_columns: u32,
    /// The means over the film.
    pub film: [Estimate; CHANNELS],
    /// Estimated relative error of pixels.
    pub relative: f64,
    /// The same of the means of tiles.
    pub relative_of_tiles: f64,
}

impl Uncertainty {
    /// Of independent samples: the image and the variance of every pixel's R, G, B and luminance.
    pub fn of_samples(image: &Image, variances: &[[f64; CHANNELS]]) -> Self {
        let tiling = Tiling::of(image.width, image.height);
        let mut tiles = vec![[Estimate::default(); CHANNELS]; tiling.count()];
        let mut film = [Estimate::default(); CHANNELS];
        for (i, (pixel, variance)) in image.pixels.iter().zip(variances).enumerate() {
            let value = with_luminance(pixel.map(f64::from));
            for cell in [&mut tiles[tiling.tile(i)], &mut film] {
                for c in 0..CHANNELS {
                    cell[c].mean += value[c];
                    cell[c].of_samples += variance[c];
                }
            }
        }
        let mean_of = |cell: &mut [Estimate; CHANNELS], n: f64| {
            for estimate in cell {
                estimate.mean /= n;
                estimate.of_samples /= n * n;
            }
        };
        tiles.iter_mut().zip(tiling.pixels()).for_each(|(cell, n)| mean_of(cell, n));
        mean_of(&mut film, image.pixels.len() as f64);
        let floor = floor(&film);
        let near = around(image.width, image.height, &image.pixels, true);
        let parts = variances
            .iter()
            .zip(near)
            .flat_map(|(variance, near)| (0..Y).map(move |c| (variance[c], f64::from(near[c]))));
        let relative = relative_error(parts.map(|(variance, near)| share(variance, near, floor)));
        let parts = tiles.iter().flat_map(|tile| &tile[..Y]);
        let relative_of_tiles = relative_error(parts.map(|e| share(e.of_samples, e.mean, floor)));
        let errors = variances.iter().map(|v| [0, 1, 2].map(|c| v[c].sqrt() as f32)).collect();
        let pixels = Image { pixels: errors, ..*image };
        Self { groups: 0, pixels, tiles, tile_columns: tiling.columns(), film, relative, relative_of_tiles }
    }
}

/// What keeps the dark from having all the relative error.
pub(super) fn floor(film: &[Estimate; CHANNELS]) -> f64 {
    FLOOR * film[Y].mean.powi(2)
}

/// A variance relative to the square of a value; no light and no error is no error.
pub(super) fn share(variance: f64, value: f64, floor: f64) -> f64 {
    variance / (value * value + floor).max(f64::MIN_POSITIVE)
}

/// Root of the mean.
pub(super) fn relative_error(shares: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = shares.fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

pub(super) fn with_luminance([r, g, b]: [f64; 3]) -> [f64; CHANNELS] {
    [r, g, b, LUMINANCE.x * r + LUMINANCE.y * g + LUMINANCE.z * b]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_of_freedom_are_between_the_parts() {
        let groups = Estimate { of_groups: 2.0, groups_dof: 7.0, ..Default::default() };
        assert_eq!(groups.dof(), 7.0);
        let both = Estimate { of_samples: 1.0, of_scale: 1.0, ..groups };
        assert_eq!((both.variance(), both.dof()), (4.0, 28.0));
        assert!((groups.half_width(0.05) - 2.3646 * 2f64.sqrt()).abs() < 1e-3);
        assert_eq!(Estimate { of_scale: 1.0, ..Default::default() }.dof(), f64::INFINITY);
    }

    #[test]
    fn samples_are_independent_from_pixel_to_pixel() {
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [3.0; 3]] };
        let samples = Uncertainty::of_samples(&image, &[[0.25; 4], [1.0; 4]]);
        assert_eq!((samples.film[0].mean, samples.film[0].of_samples), (2.0, 1.25 / 4.0));
        assert_eq!(samples.tiles, [samples.film]);
        assert_eq!(samples.pixels.pixels, [[0.5; 3], [1.0; 3]]);
        // Each pixel's variance by its neighbour's value; 0.01 m^2 is 0.04.
        assert!((samples.relative - ((0.25 / 9.04 + 1.0 / 1.04) / 2.0f64).sqrt()).abs() < 1e-9);
        assert!((samples.relative_of_tiles - (0.3125f64 / 4.04).sqrt()).abs() < 1e-9);
    }

    /// One sample in a hundred carries all the light of a pixel: one that has found it seems brighter than it is, and by its
    /// own value never more than 100 % off.
    #[test]
    fn chance_does_not_hide_its_own_error() {
        let mut pixels = vec![[1.0; 3]; 100];
        pixels[44] = [50.0; 3];
        let image = Image { width: 10, height: 10, pixels };
        let variances: Vec<[f64; 4]> = (0..100).map(|i| [if i == 44 { 2500.0 } else { 0.01 }; 4]).collect();
        assert!(Uncertainty::of_samples(&image, &variances).relative > 4.0);
    }
}
