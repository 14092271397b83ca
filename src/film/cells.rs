//! Pixels by their place on the film: the tiles they are in, and those around them.

/// Pixels on a side of a tile; tiles at the right and bottom edge may be smaller.
pub const TILE: u32 = 8;
/// How far from a pixel its surroundings reach, in pixels.
const REACH: usize = 2;

/// Tiles over a film.
#[derive(Debug, Clone, Copy)]
pub struct Tiling {
    width: u32,
    height: u32,
}

impl Tiling {
    pub fn of(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Tiles in a row.
    pub fn columns(&self) -> u32 {
        self.width.div_ceil(TILE)
    }

    pub fn count(&self) -> usize {
        (self.columns() * self.height.div_ceil(TILE)) as usize
    }

    /// The tile of a pixel, both by number.
    pub fn tile(&self, pixel: usize) -> usize {
        let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
        (y / TILE * self.columns() + x / TILE) as usize
    }

    /// Pixels of every tile, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { width, height } = *self;
        let side = |at: u32, size: u32| f64::from(TILE.min(size - at * TILE));
        let columns = self.columns();
        (0..height.div_ceil(TILE)).flat_map(move |y| (0..columns).map(move |x| side(x, width) * side(y, height)))
    }
}

/// Mean over the square of 5 x 5 pixels about every pixel, as far as the film goes; without the pixel itself where
/// `others` is set, unless there is no other.
pub fn around(width: u32, height: u32, values: &[[f32; 3]], others: bool) -> Vec<[f32; 3]> {
    let (width, height) = (width as usize, height as usize);
    let span = |at: usize, size: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(size);
    let plus = |a: [f32; 3], b: [f32; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    // Along rows, then along columns.
    let mut rows = Vec::with_capacity(values.len());
    for line in values.chunks_exact(width) {
        for x in 0..width {
            rows.push(line[span(x, width)].iter().copied().fold([0.0; 3], plus));
        }
    }
    let mut means = Vec::with_capacity(values.len());
    for y in 0..height {
        for x in 0..width {
            let mut sum = span(y, height).map(|y| rows[y * width + x]).fold([0.0; 3], plus);
            let mut count = span(x, width).len() * span(y, height).len();
            if others && count > 1 {
                sum = plus(sum, values[y * width + x].map(|v| -v));
                count -= 1;
            }
            means.push(sum.map(|v| v / count as f32));
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_at_the_edge_are_smaller() {
        let tiling = Tiling::of(17, 9);
        assert_eq!((tiling.columns(), tiling.count()), (3, 6));
        assert_eq!(tiling.pixels().collect::<Vec<_>>(), [64.0, 64.0, 8.0, 8.0, 8.0, 1.0]);
        let mut counts = [0.0; 6];
        (0..17 * 9).for_each(|pixel| counts[tiling.tile(pixel)] += 1.0);
        assert_eq!(counts.to_vec(), tiling.pixels().collect::<Vec<_>>());
    }

    #[test]
    fn surroundings_end_with_the_film() {
        // 4 x 2 pixels, numbered.
        let values: Vec<[f32; 3]> = (0..8).map(|i| [i as f32; 3]).collect();
        let all = around(4, 2, &values, false);
        // Columns 0 to 2 of both rows: (0 + 1 + 2 + 4 + 5 + 6) / 6; then all columns.
        assert_eq!((all[0], all[1]), ([3.0; 3], [3.5; 3]));
        let others = around(4, 2, &values, true);
        assert_eq!((others[0], others[5]), ([3.6; 3], [23.0 / 7.0; 3]));
        assert_eq!(around(1, 1, &[[2.0; 3]], true), [[2.0; 3]]);
    }
}
