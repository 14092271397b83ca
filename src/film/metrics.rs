//! How far an image is from a reference.
//!
//! With a the image, r the reference, both per pixel and channel, and m the mean luminance of the reference:
//! - MSE: mean of (a - r)^2
//! - MAE: mean of |a - r|
//! - relMSE: mean of (a - r)^2 / (r^2 + 0.01 m^2)
//! - relMSE of block means: the same on the means of blocks of 4 x 4 pixels, which tells blotches from grain
//!
//! A reference with noise of its own adds its variance to every squared difference; given that variance, it is
//! subtracted. A mean can then be slightly negative. A value that is not finite in the image makes every figure so.

use super::Image;
use crate::{Error, Result};

/// Pixels on a side of the blocks of the blotch-sensitive figure.
pub const BLOCK: u32 = 4;

/// Share of the squared mean luminance that keeps dark pixels from dominating relMSE.
const FLOOR: f64 = 0.01;

/// The figures of one comparison; see the module's documentation for their definitions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// In squared radiance.
    pub mse: f64,
    /// In radiance.
    pub mae: f64,
    pub rel_mse: f64,
    pub rel_mse_blocks: f64,
}

/// Compares `image` with `reference`; `reference_variance` holds the variance of each of the reference's pixel values.
///
/// Images of different sizes, and a reference without light (no relative error exists), are [`Error::Input`].
pub fn compare(image: &Image, reference: &Image, reference_variance: Option<&Image>) -> Result<Errors> {
    for other in [Some(image), reference_variance].into_iter().flatten() {
        check_sizes(other.size(), reference.size())?;
    }
    let mean = mean_luminance(reference);
    if !(mean > 0.0 && mean.is_finite()) {
        return Err(Error::input("the reference is black or not finite, so no relative error exists"));
    }
    let floor = FLOOR * mean * mean;
    let (a, r) = (doubles(image), doubles(reference));
    let v = reference_variance.map(doubles);
    // The variance of a block's mean is the mean of the variances over the number of pixels.
    let blocks = |values: &[[f64; 3]]| block_means(values, image.width, image.height);
    let block_variance = v.as_ref().map(|v| {
        let (means, counts) = blocks(v);
        means.iter().zip(counts).map(|(m, n)| m.map(|x| x / n)).collect::<Vec<_>>()
    });
    Ok(Errors {
        mse: mean_over(&a, &r, v.as_deref(), |d2, _| d2),
        mae: mean_over(&a, &r, None, |d2, _| d2.sqrt()),
        rel_mse: mean_over(&a, &r, v.as_deref(), |d2, r| d2 / (r * r + floor)),
        rel_mse_blocks: mean_over(&blocks(&a).0, &blocks(&r).0, block_variance.as_deref(), |d2, r| {
            d2 / (r * r + floor)
        }),
    })
}

/// Images of different sizes (width and height in pixels) are [`Error::Input`].
pub fn check_sizes(image: [u32; 2], reference: [u32; 2]) -> Result<()> {
    if image == reference {
        return Ok(());
    }
    Err(Error::input(format!(
        "the images differ in size ({}x{} and {}x{}): render both at the same --size",
        image[0], image[1], reference[0], reference[1]
    )))
}

/// Mean Rec.709 luminance over the pixels.
pub fn mean_luminance(image: &Image) -> f64 {
    let sum: f64 = doubles(image).iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).sum();
    sum / image.pixels.len() as f64
}

fn doubles(image: &Image) -> Vec<[f64; 3]> {
    image.pixels.iter().map(|p| p.map(f64::from)).collect()
}

/// Mean of `term((a - r)^2 - variance, r)` over pixels and channels.
fn mean_over(a: &[[f64; 3]], r: &[[f64; 3]], variance: Option<&[[f64; 3]]>, term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for (i, (a, r)) in a.iter().zip(r).enumerate() {
        for c in 0..3 {
            let noise = variance.map_or(0.0, |v| v[i][c]);
            sum += term((a[c] - r[c]).powi(2) - noise, r[c]);
        }
    }
    sum / (3 * a.len()) as f64
}

/// Mean and number of pixels of each block, row by row; blocks at the right and bottom edge may be smaller.
fn block_means(values: &[[f64; 3]], width: u32, height: u32) -> (Vec<[f64; 3]>, Vec<f64>) {
    let columns = width.div_ceil(BLOCK) as usize;
    let mut means = vec![[0.0; 3]; columns * height.div_ceil(BLOCK) as usize];
    let mut counts = vec![0.0; means.len()];
    for (i, value) in values.iter().enumerate() {
        let (x, y) = (i % width as usize, i / width as usize);
        let block = y / BLOCK as usize * columns + x / BLOCK as usize;
        counts[block] += 1.0;
        for c in 0..3 {
            means[block][c] += value[c];
        }
    }
    for (mean, count) in means.iter_mut().zip(&counts) {
        *mean = mean.map(|sum| sum / count);
    }
    (means, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Image { width, height, pixels }
    }

    #[track_caller]
    fn assert_near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-3), "{a} is not {b}");
    }

    #[test]
    fn two_pixels_by_hand() {
        let reference = image(2, 1, |x, _| if x == 0 { [1.0; 3] } else { [3.0; 3] });
        let other = image(2, 1, |x, _| if x == 0 { [1.5, 1.0, 1.0] } else { [3.0, 3.0, 2.0] });
        let errors = compare(&other, &reference, None).unwrap();
        // Mean luminance 2, floor 0.04; squared differences 0.25 (at r = 1) and 1 (at r = 3) among 6 values.
        assert_near(errors.mse, 1.25 / 6.0);
        assert_near(errors.mae, 1.5 / 6.0);
        assert_near(errors.rel_mse, (0.25 / 1.04 + 1.0 / 9.04) / 6.0);
        // One block of mean 2: differences 0.25 in red and -0.5 in blue.
        assert_near(errors.rel_mse_blocks, (0.0625 + 0.25) / 4.04 / 3.0);
    }

    #[test]
    fn the_floor_uses_luminance() {
        let reference = image(1, 1, |_, _| [1.0, 0.0, 0.0]);
        let other = image(1, 1, |_, _| [1.0, 1.0, 0.0]);
        let errors = compare(&other, &reference, None).unwrap();
        let floor = 0.01 * 0.2126 * 0.2126;
        assert_near(errors.rel_mse, 1.0 / floor / 3.0);
    }

    #[test]
    fn grain_vanishes_in_blocks_and_blotches_do_not() {
        let reference = image(8, 8, |_, _| [1.0; 3]);
        let grain = image(8, 8, |x, y| if (x + y) % 2 == 0 { [1.5; 3] } else { [0.5; 3] });
        let blotches = image(8, 8, |x, y| if (x / 4 + y / 4) % 2 == 0 { [1.5; 3] } else { [0.5; 3] });
        let (grain, blotches) =
            (compare(&grain, &reference, None).unwrap(), compare(&blotches, &reference, None).unwrap());
        assert_near(grain.rel_mse, 0.25 / 1.01);
        assert_near(blotches.rel_mse, 0.25 / 1.01);
        assert_near(grain.rel_mse_blocks, 0.0);
        assert_near(blotches.rel_mse_blocks, 0.25 / 1.01);
    }

    #[test]
    fn edge_blocks_are_means_of_what_they_hold() {
        let values: Vec<[f64; 3]> = (0..15).map(|i| [f64::from(i); 3]).collect();
        let (means, counts) = block_means(&values, 5, 3);
        assert_eq!(counts, [12.0, 3.0]);
        // Columns 0 to 3 of rows 0, 5, 10: mean 1.5 + 5; column 4: 4, 9, 14.
        assert_eq!(means, [[6.5; 3], [9.0; 3]]);
    }

    #[test]
    fn the_reference_variance_is_subtracted() {
        let reference = image(4, 4, |_, _| [1.0; 3]);
        let other = image(4, 4, |_, _| [1.25; 3]);
        let variance = image(4, 4, |_, _| [0.03125; 3]);
        let errors = compare(&other, &reference, Some(&variance)).unwrap();
        assert_near(errors.mse, 0.0625 - 0.03125);
        assert_near(errors.mae, 0.25);
        assert_near(errors.rel_mse, 0.03125 / 1.01);
        assert_near(errors.rel_mse_blocks, (0.0625 - 0.03125 / 16.0) / 1.01);
    }

    #[test]
    fn what_cannot_be_compared_is_an_error() {
        let one = image(2, 2, |_, _| [1.0; 3]);
        assert_eq!(compare(&one, &image(2, 3, |_, _| [1.0; 3]), None).unwrap_err().exit_status(), 2);
        assert_eq!(compare(&one, &image(2, 2, |_, _| [0.0; 3]), None).unwrap_err().exit_status(), 2);
        let bad = image(2, 2, |_, _| [f32::NAN; 3]);
        assert!(compare(&bad, &one, None).unwrap().mse.is_nan());
    }
}
