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
//! The scale and the groups share the start's candidates, and are taken as independent all the same: that is so once the
//! chains have forgotten their start, and for the whole film's luminance always, which each group has by construction.

use super::Image;
use crate::report::student::critical_between;
use crate::scene::LUMINANCE;

/// Pixels on a side of a tile; tiles at the right and bottom edge may be smaller.
pub const TILE: u32 = 8;
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
    fn plus(&self, other: &Self) -> Self {
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
    /// Tiles of [`TILE`] pixels, row by row, and how many there are in a row; R, G, B and luminance of each.
    pub tiles: Vec<[Estimate; CHANNELS]>,
    pub tile_columns: u32,
    /// The means over the film.
    pub film: [Estimate; CHANNELS],
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
        let errors = variances.iter().map(|v| [0, 1, 2].map(|c| v[c].sqrt() as f32)).collect();
        let pixels = Image { pixels: errors, ..*image };
        Self { groups: 0, pixels, tiles, tile_columns: tiling.columns, film }
    }

    /// Of the sum of two independent images.
    pub fn plus(mut self, other: &Self) -> Self {
        let hypot = |(a, b): (&mut f32, &f32)| *a = a.hypot(*b);
        self.pixels.pixels.iter_mut().flatten().zip(other.pixels.pixels.iter().flatten()).for_each(hypot);
        let add = |(a, b): (&mut Estimate, &Estimate)| *a = a.plus(b);
        self.tiles.iter_mut().flatten().zip(other.tiles.iter().flatten()).for_each(add);
        self.film.iter_mut().zip(&other.film).for_each(add);
        self.groups = self.groups.max(other.groups);
        self
    }

    /// Estimated relative error of `image` a pixel: root of the mean over pixels and channels of
    /// variance / (value^2 + 0.01 m^2), with m the mean luminance; that is the root of what relMSE of
    /// [`super::metrics`] would be against the truth.
    pub fn relative_error(&self, image: &Image) -> f64 {
        let pairs = image.pixels.iter().flatten().zip(self.pixels.pixels.iter().flatten());
        self.relative(pairs.map(|(value, error)| (f64::from(*value), f64::from(*error).powi(2))))
    }

    /// The same of the means of tiles.
    pub fn relative_error_of_tiles(&self) -> f64 {
        self.relative(self.tiles.iter().flat_map(|tile| &tile[..Y]).map(|e| (e.mean, e.variance())))
    }

    fn relative(&self, values: impl Iterator<Item = (f64, f64)>) -> f64 {
        let floor = FLOOR * self.film[Y].mean.powi(2);
        let (mut sum, mut count) = (0.0, 0.0);
        for (value, variance) in values {
            // No light and no error is no error.
            sum += variance / (value * value + floor).max(f64::MIN_POSITIVE);
            count += 1.0;
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }
}

fn with_luminance([r, g, b]: [f64; 3]) -> [f64; CHANNELS] {
    [r, g, b, LUMINANCE.x * r + LUMINANCE.y * g + LUMINANCE.z * b]
}

/// Tiles over a film.
#[derive(Debug, Clone, Copy)]
struct Tiling {
    width: u32,
    height: u32,
    columns: u32,
}

impl Tiling {
    fn of(width: u32, height: u32) -> Self {
        Self { width, height, columns: width.div_ceil(TILE) }
    }

    fn count(&self) -> usize {
        (self.columns * self.height.div_ceil(TILE)) as usize
    }

    /// The tile of a pixel, both by number.
    fn tile(&self, pixel: usize) -> usize {
        let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
        (y / TILE * self.columns + x / TILE) as usize
    }

    /// Pixels of every tile.
    fn pixels(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { width, height, columns } = *self;
        let side = |at: u32, size: u32| f64::from(TILE.min(size - at * TILE));
        (0..height.div_ceil(TILE)).flat_map(move |y| (0..columns).map(move |x| side(x, width) * side(y, height)))
    }
}

/// Sum and sum of squares over layers.
type Sums<const N: usize> = [[f64; N]; 2];

/// Layers of a film, one a group, on their way to an image and its uncertainty.
pub struct Layers {
    tiling: Tiling,
    count: u32,
    pixels: Vec<Sums<3>>,
    tiles: Vec<Sums<CHANNELS>>,
    film: Sums<CHANNELS>,
}

impl Layers {
    pub fn new(width: u32, height: u32) -> Self {
        let tiling = Tiling::of(width, height);
        Self {
            tiling,
            count: 0,
            pixels: vec![Sums::default(); width as usize * height as usize],
            tiles: vec![Sums::default(); tiling.count()],
            film: Sums::default(),
        }
    }

    /// Adds a group's layer: R, G and B of every pixel in any unit, that of [`Self::finish`].
    pub fn add(&mut self, values: &[[f64; 3]]) {
        let mut tiles = vec![[0.0; CHANNELS]; self.tiles.len()];
        for (i, (sums, value)) in self.pixels.iter_mut().zip(values).enumerate() {
            add(sums, *value);
            let tile = &mut tiles[self.tiling.tile(i)];
            tile.iter_mut().zip(with_luminance(*value)).for_each(|(sum, v)| *sum += v);
        }
        let mut film = [0.0; CHANNELS];
        for ((sums, mut tile), n) in self.tiles.iter_mut().zip(tiles).zip(self.tiling.pixels()) {
            film.iter_mut().zip(tile).for_each(|(sum, v)| *sum += v);
            tile.iter_mut().for_each(|v| *v /= n);
            add(sums, tile);
        }
        let n = self.pixels.len() as f64;
        add(&mut self.film, film.map(|v| v / n));
        self.count += 1;
    }

    /// The mean of the layers times `scale`, whose own relative error is `scale_error`; no uncertainty of one layer alone.
    pub fn finish(self, scale: f64, scale_error: f64) -> (Image, Option<Uncertainty>) {
        let Self { tiling, count, pixels, tiles, film } = self;
        let n = f64::from(count.max(1));
        let mean = |sum: f64| sum / n * scale;
        let image = Image {
            width: tiling.width,
            height: tiling.height,
            pixels: pixels.iter().map(|[sum, _]| sum.map(|v| mean(v) as f32)).collect(),
        };
        if count < 2 {
            return (image, None);
        }
        // Variance of the mean of the layers.
        let scatter = |sum: f64, squares: f64| (squares - sum * sum / n).max(0.0) / (n - 1.0) / n * scale * scale;
        let estimate = |[sum, squares]: &Sums<CHANNELS>| {
            std::array::from_fn(|c| Estimate {
                mean: mean(sum[c]),
                of_groups: scatter(sum[c], squares[c]),
                groups_dof: n - 1.0,
                of_samples: 0.0,
                of_scale: (scale_error * mean(sum[c])).powi(2),
            })
        };
        let error = |[sum, squares]: &Sums<3>| {
            [0, 1, 2].map(|c| scatter(sum[c], squares[c]).sqrt().hypot(scale_error * mean(sum[c])) as f32)
        };
        let uncertainty = Uncertainty {
            groups: count,
            pixels: Image { pixels: pixels.iter().map(error).collect(), ..image },
            tiles: tiles.iter().map(estimate).collect(),
            tile_columns: tiling.columns,
            film: estimate(&film),
        };
        (image, Some(uncertainty))
    }
}

fn add<const N: usize>(sums: &mut Sums<N>, values: [f64; N]) {
    for (c, value) in values.into_iter().enumerate() {
        sums[0][c] += value;
        sums[1][c] += value * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-9), "{a} is not {b}");
    }

    #[test]
    fn two_layers_by_hand() {
        // 9 x 1 pixels: a tile of 8, a tile of 1.
        let mut layers = Layers::new(9, 1);
        let layer = |first: f64, last: f64| {
            let mut pixels = vec![[1.0; 3]; 9];
            (pixels[0], pixels[8]) = ([first; 3], [last; 3]);
            pixels
        };
        layers.add(&layer(1.0, 4.0));
        layers.add(&layer(3.0, 2.0));
        let (image, uncertainty) = layers.finish(10.0, 0.1);
        let uncertainty = uncertainty.unwrap();
        assert_eq!((image.pixels[0], image.pixels[4], image.pixels[8]), ([20.0; 3], [10.0; 3], [30.0; 3]));
        // Two values 10 and 30: variance of their mean 100; 10 % of the mean of 20 is 2.
        assert_near(f64::from(uncertainty.pixels.pixels[0][0]), 104f64.sqrt());
        assert_near(f64::from(uncertainty.pixels.pixels[4][1]), 1.0);
        let [left, right] = [uncertainty.tiles[0][Y], uncertainty.tiles[1][Y]];
        assert_eq!((uncertainty.tile_columns, uncertainty.groups), (2, 2));
        // The first tile's means are 10 and 12.5.
        assert_near(left.mean, 11.25);
        assert_near(left.of_groups, 1.5625);
        assert_near(left.of_scale, 1.265625);
        assert_near(right.variance(), 109.0);
        // Over the film both layers are alike: what is left is the scale.
        assert_near(uncertainty.film[Y].mean, 120.0 / 9.0);
        assert_near(uncertainty.film[Y].variance(), (12.0f64 / 9.0).powi(2));
        assert!(uncertainty.film[Y].of_groups < 1e-12);
    }

    #[test]
    fn one_layer_tells_no_error() {
        let mut layers = Layers::new(1, 1);
        layers.add(&[[2.0; 3]]);
        let (image, uncertainty) = layers.finish(0.5, 0.1);
        assert_eq!((image.pixels, uncertainty), (vec![[1.0; 3]], None));
    }

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
    fn independent_parts_add_up() {
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [3.0; 3]] };
        let samples = Uncertainty::of_samples(&image, &[[0.04; 4], [0.12; 4]]);
        assert_near(samples.film[0].mean, 2.0);
        assert_near(samples.film[0].of_samples, 0.04);
        let mut layers = Layers::new(2, 1);
        layers.add(&[[1.0; 3], [0.0; 3]]);
        layers.add(&[[3.0; 3], [0.0; 3]]);
        let (_, chains) = layers.finish(1.0, 0.0);
        let sum = chains.unwrap().plus(&samples);
        assert_near(sum.film[1].mean, 3.0);
        assert_near(sum.film[1].variance(), 0.25 + 0.04);
        assert_near(f64::from(sum.pixels.pixels[0][2]), 1.04f64.sqrt());
        assert_eq!(sum.groups, 2);
    }

    #[test]
    fn the_relative_error_is_that_of_rel_mse() {
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [3.0; 3]] };
        let samples = Uncertainty::of_samples(&image, &[[0.25; 4], [1.0; 4]]);
        assert_near(samples.relative_error(&image), ((0.25 / 1.04 + 1.0 / 9.04) / 2.0f64).sqrt());
        // One tile of mean 2 and variance 1.25 / 4.
        assert_near(samples.relative_error_of_tiles(), (0.3125f64 / 4.04).sqrt());
    }
}
