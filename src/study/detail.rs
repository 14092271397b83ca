//! Detail of images: where it is, and which way it runs.

use super::panels::Window;
use crate::film::Image;
use crate::scene::LUMINANCE;

/// Pixels on a side of the window whose mean is the ground that detail stands out from.
const GROUND: i64 = 5;

/// Luminance of every pixel.
pub fn luminance(image: &Image) -> Vec<f64> {
    image.pixels.iter().map(|p| LUMINANCE.dot(p.map(f64::from).into())).collect()
}

/// Luminance above the mean of the 5x5 pixels around (fewer at the edges).
pub fn detail(image: &Image) -> Vec<f64> {
    let (width, height) = (i64::from(image.width), i64::from(image.height));
    let values = luminance(image);
    let reach = GROUND / 2;
    let ground = |x: i64, y: i64| {
        let columns = (x - reach).max(0)..=(x + reach).min(width - 1);
        let rows = (y - reach).max(0)..=(y + reach).min(height - 1);
        let count = columns.clone().count() * rows.clone().count();
        let sum: f64 = rows
            .flat_map(|y| columns.clone().map(move |x| (x, y)))
            .map(|(x, y)| values[(y * width + x) as usize])
            .sum();
        sum / count as f64
    };
    let place = |i: usize| (i as i64 % width, i as i64 / width);
    (0..values.len()).map(|i| (place(i), values[i])).map(|((x, y), value)| value - ground(x, y)).collect()
}

/// The window of a third of the film on either side that has the most detail, relative to how bright it is.
pub fn busiest(image: &Image) -> Window {
    let (width, height) = (image.width, image.height);
    let window = [width.div_ceil(3), height.div_ceil(3)];
    let values = luminance(image);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    // Relative, so that one bright edge does not win, and no more than doubling counts.
    let contrast: Vec<f64> =
        detail(image).iter().zip(&values).map(|(d, v)| (d.abs() / (v.max(0.0) + 0.1 * mean)).min(1.0)).collect();
    let sum = |left: u32, top: u32| {
        let rows = (top..top + window[1]).flat_map(|y| (left..left + window[0]).map(move |x| (x, y)));
        rows.map(|(x, y)| contrast[(y * width + x) as usize]).sum::<f64>()
    };
    let places =
        (0..=height - window[1]).step_by(2).flat_map(|y| (0..=width - window[0]).step_by(2).map(move |x| (x, y)));
    let best = places.max_by(|a, b| sum(a.0, a.1).total_cmp(&sum(b.0, b.1)));
    let (left, top) = best.unwrap_or((0, 0));
    [left, top, window[0], window[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detail_is_what_stands_out() {
        let mut pixels = vec![[1.0f32; 3]; 18 * 12];
        pixels[8 * 18 + 14] = [2.0; 3];
        let image = Image { width: 18, height: 12, pixels };
        let found = detail(&image);
        assert!((found[8 * 18 + 14] - 24.0 / 25.0).abs() < 1e-6);
        assert_eq!(found[0], 0.0);
        let [left, top, width, height] = busiest(&image);
        assert!((left..left + width).contains(&14) && (top..top + height).contains(&8) && [width, height] == [6, 4]);
    }
}
