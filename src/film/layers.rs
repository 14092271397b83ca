//! From the layers of a film, one a group of chains, to an image and its uncertainty.

use super::Image;
use super::cells::{Tiling, around};
use super::uncertainty::{CHANNELS, Estimate, Uncertainty, Y, floor, relative_error, share, with_luminance};

/// Sum and sum of squares over layers.
type Sums<const N: usize> = [[f64; N]; 2];

/// Layers of a film on their way.
pub struct Layers {
    width: u32,
    height: u32,
    tiling: Tiling,
    count: u32,
    /// Whether the uncertainty is asked for; without it, layers are only added up.
    with_error: bool,
    /// Each layer's pixels, and the means of its tiles.
    pixels: Vec<Vec<[f32; 3]>>,
    tiles: Vec<Vec<[f64; CHANNELS]>>,
    pixel_sums: Vec<Sums<3>>,
    film_sums: Sums<CHANNELS>,
}

impl Layers {
    pub fn new(width: u32, height: u32, with_error: bool) -> Self {
        let pixel_sums = vec![Sums::default(); width as usize * height as usize];
        let tiling = Tiling::of(width, height);
        Self {
            width,
            height,
            tiling,
            count: 0,
            with_error,
            pixels: vec![],
            tiles: vec![],
            pixel_sums,
            film_sums: Sums::default(),
        }
    }

    /// Adds a group's layer: R, G and B of every pixel, in any unit.
    pub fn add(&mut self, values: &[[f64; 3]]) {
        self.pixel_sums.iter_mut().zip(values).for_each(|(sums, value)| add(sums, *value));
        self.count += 1;
        if !self.with_error {
            return;
        }
        let mut tiles = vec![[0.0; CHANNELS]; self.tiling.count()];
        for (i, value) in values.iter().enumerate() {
            let tile = &mut tiles[self.tiling.tile(i)];
            tile.iter_mut().zip(with_luminance(*value)).for_each(|(sum, v)| *sum += v);
        }
        let mut film = [0.0; CHANNELS];
        for (tile, n) in tiles.iter_mut().zip(self.tiling.pixels()) {
            film.iter_mut().zip(*tile).for_each(|(sum, v)| *sum += v);
            tile.iter_mut().for_each(|v| *v /= n);
        }
        add(&mut self.film_sums, film.map(|v| v / values.len() as f64));
        self.tiles.push(tiles);
        self.pixels.push(values.iter().map(|pixel| pixel.map(|v| v as f32)).collect());
    }

    /// The mean of the layers times `scale`, whose own relative error is `scale_error`, and its uncertainty where it was
    /// asked for, which one layer alone does not tell. Both are of the sum with an independent image `beneath`, where there is one.
    pub fn finish(
        self,
        scale: f64,
        scale_error: f64,
        beneath: Option<(&Image, Option<&Uncertainty>)>,
    ) -> (Image, Option<Uncertainty>) {
        let n = f64::from(self.count);
        let mean = |sum: f64| sum / n.max(1.0) * scale;
        let below = |i: usize| beneath.map_or([0.0; 3], |(image, _)| image.pixels[i]);
        let pixel = |(i, [sum, _]): (usize, &Sums<3>)| [0, 1, 2].map(|c| mean(sum[c]) as f32 + below(i)[c]);
        let pixels = self.pixel_sums.iter().enumerate().map(pixel).collect();
        let image = Image { width: self.width, height: self.height, pixels };
        let samples = beneath.and_then(|(_, uncertainty)| uncertainty);
        if !self.with_error || self.count < 2 || (beneath.is_some() && samples.is_none()) {
            return (image, None);
        }
        // Variance of the mean of the layers.
        let scatter = |sum: f64, squares: f64| (squares - sum * sum / n).max(0.0) / (n - 1.0) / n * scale * scale;
        let estimate = |[sum, squares]: &Sums<CHANNELS>, other: Option<&[Estimate; CHANNELS]>| {
            std::array::from_fn(|c| {
                let own = Estimate {
                    mean: mean(sum[c]),
                    of_groups: scatter(sum[c], squares[c]),
                    groups_dof: n - 1.0,
                    of_samples: 0.0,
                    of_scale: (scale_error * mean(sum[c])).powi(2),
                };
                other.map_or(own, |other| own.plus(&other[c]))
            })
        };
        let film = estimate(&self.film_sums, samples.map(|s| &s.film));
        let tiles: Vec<[Estimate; CHANNELS]> = (0..self.tiling.count())
            .map(|t| {
                let mut sums = Sums::default();
                self.tiles.iter().for_each(|tiles| add(&mut sums, tiles[t]));
                estimate(&sums, samples.map(|s| &s.tiles[t]))
            })
            .collect();
        // Of every pixel: variance by the groups' scatter, and by all else.
        let variances: Vec<[[f64; 2]; 3]> = self
            .pixel_sums
            .iter()
            .enumerate()
            .map(|(i, [sum, squares])| {
                let other = samples.map_or([0.0; 3], |s| s.pixels.pixels[i]);
                [0, 1, 2].map(|c| {
                    let rest = f64::from(other[c]).powi(2) + (scale_error * mean(sum[c])).powi(2);
                    [scatter(sum[c], squares[c]), rest]
                })
            })
            .collect();
        let errors = variances.iter().map(|pixel| pixel.map(|[groups, rest]| (groups + rest).sqrt() as f32));
        let pixels = Image { pixels: errors.collect(), ..image };
        let floor = floor(&film);
        let relative = self.relative(&image, &variances, scale, floor);
        let relative_of_tiles = self.relative_of_tiles(&tiles, scale, floor);
        let (groups, tile_columns) = (self.count, self.tiling.columns());
        let uncertainty = Uncertainty { groups, pixels, tiles, tile_columns, film, relative, relative_of_tiles };
        (image, Some(uncertainty))
    }

    /// Relative error of the pixels of `image`. A group's deviation is divided by what the image would be near there
    /// without the group: its mean over the others and over the surroundings.
    fn relative(&self, image: &Image, variances: &[[[f64; 2]; 3]], scale: f64, floor: f64) -> f64 {
        let n = self.pixels.len() as f64;
        let near = around(self.width, self.height, &image.pixels, false);
        let mut shares: Vec<f64> = variances
            .iter()
            .zip(&near)
            .flat_map(|(variance, near)| [0, 1, 2].map(|c| share(variance[c][1], f64::from(near[c]), floor)))
            .collect();
        let means: Vec<[f32; 3]> =
            self.pixel_sums.iter().map(|[sum, _]| sum.map(|sum| (sum / n * scale) as f32)).collect();
        let near_means = around(self.width, self.height, &means, false);
        for layer in &self.pixels {
            let near_layer = around(self.width, self.height, layer, false);
            for (i, [sum, _]) in self.pixel_sums.iter().enumerate() {
                for c in 0..3 {
                    let deviation = (f64::from(layer[i][c]) - sum[c] / n) * scale;
                    let without = f64::from(near_means[i][c]) - f64::from(near_layer[i][c]) * scale;
                    let without = f64::from(near[i][c]) + without / (n - 1.0);
                    shares[3 * i + c] += share(deviation * deviation / (n - 1.0) / n, without, floor);
                }
            }
        }
        relative_error(shares.into_iter())
    }

    /// The same of the tiles, without their surroundings, which are another part of the scene.
    fn relative_of_tiles(&self, tiles: &[[Estimate; CHANNELS]], scale: f64, floor: f64) -> f64 {
        let n = self.tiles.len() as f64;
        let mut shares: Vec<f64> = Vec::with_capacity(Y * tiles.len());
        for (t, estimates) in tiles.iter().enumerate() {
            for (c, estimate) in estimates.iter().enumerate().take(Y) {
                let own_mean = self.tiles.iter().map(|layer| layer[t][c]).sum::<f64>() / n;
                let by_groups = self.tiles.iter().map(|layer| {
                    let deviation = (layer[t][c] - own_mean) * scale;
                    share(deviation * deviation / (n - 1.0) / n, estimate.mean - deviation / (n - 1.0), floor)
                });
                shares.push(
                    by_groups.sum::<f64>() + share(estimate.of_samples + estimate.of_scale, estimate.mean, floor),
                );
            }
        }
        relative_error(shares.into_iter())
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
        let mut layers = Layers::new(9, 1, true);
        let layer = |first: f64, last: f64| {
            let mut pixels = vec![[1.0; 3]; 9];
            (pixels[0], pixels[8]) = ([first; 3], [last; 3]);
            pixels
        };
        layers.add(&layer(1.0, 4.0));
        layers.add(&layer(3.0, 2.0));
        let (image, uncertainty) = layers.finish(10.0, 0.1, None);
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
    fn a_group_is_divided_by_the_others() {
        let mut layers = Layers::new(1, 1, true);
        layers.add(&[[1.0; 3]]);
        layers.add(&[[3.0; 3]]);
        let (_, uncertainty) = layers.finish(1.0, 0.0, None);
        // Both deviate by 1, one beside 3 and one beside 1; the mean is 2.
        let expected = f64::sqrt(0.5 / 9.04 + 0.5 / 1.04);
        let uncertainty = uncertainty.unwrap();
        assert_near(uncertainty.relative, expected);
        assert_near(uncertainty.relative_of_tiles, expected);
    }

    #[test]
    fn one_layer_tells_no_error_and_nobody_who_is_not_asked() {
        let mut layers = Layers::new(1, 1, false);
        layers.add(&[[1.0; 3]]);
        layers.add(&[[2.0; 3]]);
        assert_eq!(layers.finish(2.0, 0.1, None), (Image { width: 1, height: 1, pixels: vec![[3.0; 3]] }, None));
        let mut layers = Layers::new(1, 1, true);
        layers.add(&[[2.0; 3]]);
        let (image, uncertainty) = layers.finish(0.5, 0.1, None);
        assert_eq!((image.pixels, uncertainty), (vec![[1.0; 3]], None));
    }

    #[test]
    fn an_independent_image_beneath_adds_its_variance() {
        let image = Image { width: 2, height: 1, pixels: vec![[1.0; 3], [3.0; 3]] };
        let samples = Uncertainty::of_samples(&image, &[[0.04; 4], [0.12; 4]]);
        let layers = || {
            let mut layers = Layers::new(2, 1, true);
            layers.add(&[[1.0; 3], [0.0; 3]]);
            layers.add(&[[3.0; 3], [0.0; 3]]);
            layers
        };
        let (sum, uncertainty) = layers().finish(1.0, 0.1, Some((&image, Some(&samples))));
        let uncertainty = uncertainty.unwrap();
        assert_eq!(sum.pixels, [[3.0; 3]; 2]);
        assert_near(uncertainty.film[1].mean, 3.0);
        // The scale's error is that of the layers alone.
        assert_near(uncertainty.film[1].variance(), 0.25 + 0.04 + 0.01);
        assert_near(f64::from(uncertainty.pixels.pixels[0][2]), 1.08f64.sqrt());
        assert_eq!(uncertainty.groups, 2);
        assert_eq!(layers().finish(1.0, 0.1, Some((&image, None))).1, None);
    }
}
