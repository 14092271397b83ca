//! Bins of an image: square tiles at two scales and the whole film, each in R, G and B.

use std::fmt;
use std::ops::Range;

use emlt::film::Image;

/// Tiles see what is wrong in one place; blocks of three by three tiles and the film see what is a little wrong all over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Tile,
    Block,
    Film,
}

/// One channel over a rectangle of pixels.
#[derive(Debug, Clone)]
pub struct Bin {
    pub scale: Scale,
    x: Range<u32>,
    y: Range<u32>,
    channel: usize,
}

/// All bins of an image with tiles of `side` pixels; those at the right and bottom edge may be smaller.
pub fn bins(width: u32, height: u32, side: u32) -> Vec<Bin> {
    let cuts = |size: u32, side: u32| (0..size.div_ceil(side)).map(move |i| i * side..((i + 1) * side).min(size));
    let mut bins = Vec::new();
    for (scale, side) in [(Scale::Tile, side), (Scale::Block, 3 * side), (Scale::Film, width.max(height))] {
        for y in cuts(height, side) {
            for x in cuts(width, side) {
                bins.extend((0..3).map(|channel| Bin { scale, x: x.clone(), y: y.clone(), channel }));
            }
        }
    }
    bins
}

impl Bin {
    fn pixels(&self) -> f64 {
        self.x.len() as f64 * self.y.len() as f64
    }

    pub fn mean(&self, image: &Image) -> f64 {
        let row = |y: u32| &image.pixels[(y * image.width + self.x.start) as usize..][..self.x.len()];
        let sum: f64 = self.y.clone().flat_map(row).map(|pixel| f64::from(pixel[self.channel])).sum();
        sum / self.pixels()
    }

    /// Variance of the mean where `variances` holds those of the pixels, which are independent.
    pub fn variance(&self, variances: &Image) -> f64 {
        self.mean(variances) / self.pixels()
    }
}

impl fmt::Display for Bin {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of pixels {:?} x {:?}", ["R", "G", "B"][self.channel], self.x, self.y)
    }
}

#[test]
fn bins_hold_their_pixels_and_no_others() {
    let pixels = (0..40).map(|i| [i as f32, 0.0, 1.0]).collect();
    let image = Image { width: 8, height: 5, pixels };
    let bins = bins(8, 5, 2);
    // 4 x 3 tiles, 2 x 1 blocks, 1 film.
    assert_eq!(bins.len(), 3 * (12 + 2 + 1));
    // Pixels 34 and 35 of the last row, which cuts the tile; columns 6 and 7 of all rows; all.
    assert_eq!(bins[3 * 9].mean(&image), 34.5);
    assert_eq!(bins[3 * 13].mean(&image), 22.5);
    assert_eq!(bins[3 * 14].mean(&image), 19.5);
    assert_eq!(bins[3 * 14 + 2].variance(&image), 1.0 / 40.0);
}
