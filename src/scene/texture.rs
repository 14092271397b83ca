//! Images and how materials use them: wrapping, filtering and colour as glTF 2.0 has them (section 3.8), in f64.
//! Twin of shaders/texture/lookup.wesl.

use std::sync::LazyLock;

/// An image of 8 bits a channel, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    /// Row by row: red in the lowest byte, then green, blue, alpha.
    pub texels: Vec<u32>,
}

/// What lies beyond [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

/// One use of an image by a material.
///
/// There is no mipmapping: a vertex of a path has no footprint, and samples of a pixel average its texels anyway.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Index into the scene's images.
    pub image: u32,
    /// Colour channels are sRGB-coded; alpha never is.
    pub srgb: bool,
    /// Bilinear between the four nearest texels, or the nearest one.
    pub linear: bool,
    /// Horizontally and vertically.
    pub wrap: [Wrap; 2],
    /// Which of the vertices' coordinates: 0 or 1.
    pub slot: usize,
    /// Rows of KHR_texture_transform's matrix, applied to (u, v, 1).
    pub transform: [[f32; 3]; 2],
}

/// No change of coordinates.
pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Linear values of the 256 sRGB codes (IEC 61966-2-1).
pub static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let c = code as f64 / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

impl Texture {
    /// Red, green, blue (linear) and alpha at the coordinates of a vertex or of a point between vertices.
    pub fn sample(&self, images: &[Image], coordinates: [f64; 2]) -> [f64; 4] {
        let image = &images[self.image as usize];
        let [u, v] = self
            .transform
            .map(|row| f64::from(row[0]) * coordinates[0] + f64::from(row[1]) * coordinates[1] + f64::from(row[2]));
        let reduce = |c: f64, wrap| match wrap {
            Wrap::Repeat => c - c.floor(),
            Wrap::Mirror => c - 2.0 * (0.5 * c).floor(),
            Wrap::Clamp => c.clamp(-1.0, 2.0),
        };
        let x = reduce(u, self.wrap[0]) * f64::from(image.width);
        let y = reduce(v, self.wrap[1]) * f64::from(image.height);
        let texel = |x: f64, y: f64| {
            let column = self.wrap[0].index(x as i64, image.width);
            let row = self.wrap[1].index(y as i64, image.height);
            self.decode(image.texels[row * image.width as usize + column])
        };
        if !self.linear {
            return texel(x.floor(), y.floor());
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let mut sum = [0.0; 4];
        for (i, j) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let weight = (1.0 - (x - left - i).abs()) * (1.0 - (y - top - j).abs());
            for (s, t) in sum.iter_mut().zip(texel(left + i, top + j)) {
                *s += weight * t;
            }
        }
        sum
    }

    /// Red, green, blue (linear) and alpha of a texel.
    pub fn decode(&self, texel: u32) -> [f64; 4] {
        let [r, g, b, a] = texel.to_le_bytes();
        let color = |code: u8| if self.srgb { f64::from(SRGB[code as usize]) } else { f64::from(code) / 255.0 };
        [color(r), color(g), color(b), f64::from(a) / 255.0]
    }
}

impl Wrap {
    /// The texel that column or row `i` shows, out of `n`.
    fn index(self, i: i64, n: u32) -> usize {
        let n = i64::from(n);
        let wrapped = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Mirror => {
                let folded = i.rem_euclid(2 * n);
                folded.min(2 * n - 1 - folded)
            }
            Self::Clamp => i.clamp(0, n - 1),
        };
        wrapped as usize
    }
}

impl Image {
    /// The same at half the width and height (at least 1), each texel the mean of those it covers. The means are of the
    /// coded values, or of what they code where `srgb`.
    pub fn halved(&self, srgb: bool) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let value = |code: u8| if srgb { SRGB[code as usize] } else { f32::from(code) / 255.0 };
        let code = |value: f32| {
            if !srgb {
                return (255.0 * value).round() as u8;
            }
            let above = SRGB.partition_point(|v| *v < value).min(255);
            let below = above.saturating_sub(1);
            if value - SRGB[below] < SRGB[above] - value { below as u8 } else { above as u8 }
        };
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0f32; 4];
                for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (x, y) = ((2 * x + i).min(self.width - 1), (2 * y + j).min(self.height - 1));
                    let [r, g, b, a] = self.texels[(y * self.width + x) as usize].to_le_bytes();
                    let here = [value(r), value(g), value(b), f32::from(a) / 255.0];
                    sum.iter_mut().zip(here).for_each(|(s, h)| *s += 0.25 * h);
                }
                let alpha = (255.0 * sum[3]).round() as u8;
                texels.push(u32::from_le_bytes([code(sum[0]), code(sum[1]), code(sum[2]), alpha]));
            }
        }
        Self { width, height, texels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(linear: bool, wrap: Wrap) -> Texture {
        Texture { image: 0, srgb: false, linear, wrap: [wrap; 2], slot: 0, transform: IDENTITY }
    }

    /// Four columns of red 0, 51, 102, 153 in one row.
    fn ramp() -> [Image; 1] {
        [Image { width: 4, height: 1, texels: vec![0, 51, 102, 153] }]
    }

    #[test]
    fn filtering_and_wrapping_by_hand() {
        let red = |linear, wrap, u: f64| texture(linear, wrap).sample(&ramp(), [u, 0.5])[0];
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(red(false, Wrap::Repeat, 0.3), 0.2);
        near(red(false, Wrap::Repeat, -0.1), 0.6);
        near(red(false, Wrap::Mirror, -0.1), 0.0);
        near(red(false, Wrap::Mirror, 1.3), 0.4);
        near(red(false, Wrap::Clamp, 7.0), 0.6);
        near(red(true, Wrap::Clamp, 0.5), 0.3);
        // Across the seam: half of the first and half of the last texel, or the first alone.
        near(red(true, Wrap::Repeat, 0.0), 0.3);
        near(red(true, Wrap::Mirror, 0.0), 0.0);
        near(red(true, Wrap::Clamp, -3.0), 0.0);
    }

    #[test]
    fn a_transform_is_applied_first() {
        let turned = Texture { transform: [[0.0, 2.0, 0.25], [1.0, 0.0, 0.0]], ..texture(false, Wrap::Repeat) };
        assert_eq!(turned.sample(&ramp(), [0.0, 0.25])[0], 0.6);
    }

    #[test]
    fn halving_keeps_the_mean() {
        let half = ramp()[0].halved(false);
        assert_eq!((half.width, half.height, half.texels), (2, 1, vec![26, 128]));
        let white = Image { width: 1, height: 3, texels: vec![u32::MAX; 3] };
        assert_eq!(white.halved(true), Image { width: 1, height: 1, texels: vec![u32::MAX] });
        assert_eq!(Image { width: 2, height: 1, texels: vec![0, 255] }.halved(true).texels, [188]);
    }
}
