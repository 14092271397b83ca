//! Pictures side by side, each under a caption, as one PNG.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::plot::{register_fonts, text_style};
use crate::film::png::{self, direction_color, srgb_byte};
use crate::film::{Channel, Image};
use crate::{Error, Result};

/// A picture of sRGB bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub rgb: Vec<[u8; 3]>,
}

/// A part of a picture: left, top, width and height in pixels.
pub type Window = [u32; 4];

impl Picture {
    /// As the preview shows it: clipped, no tone curve.
    pub fn of(image: &Image) -> Self {
        let rgb = image.pixels.iter().map(|p| p.map(srgb_byte)).collect();
        Self { width: image.width, height: image.height, rgb }
    }

    /// Mutation directions: red horizontal, green vertical.
    pub fn of_directions(size: [u32; 2], channels: &[Channel]) -> Option<Self> {
        let layer = |name: &str| channels.iter().find(|c| c.name == name).map(|c| &c.values);
        let (h, v) = (layer("Maps.Horizontal")?, layer("Maps.Vertical")?);
        let rgb = h.iter().zip(v).map(|(h, v)| direction_color(*h, *v)).collect();
        Some(Self { width: size[0], height: size[1], rgb })
    }

    fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        self.rgb[(y * self.width + x) as usize]
    }

    /// The part inside the window.
    pub fn crop(&self, [left, top, width, height]: Window) -> Self {
        let rows = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
        Self { width, height, rgb: rows.map(|(x, y)| self.pixel(x, y)).collect() }
    }

    /// With each pixel as a square of `zoom` pixels.
    pub fn enlarge(&self, zoom: u32) -> Self {
        let (width, height) = (self.width * zoom, self.height * zoom);
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, rgb: rows.map(|(x, y)| self.pixel(x / zoom, y / zoom)).collect() }
    }

    /// With the window's border drawn in.
    pub fn outline(mut self, [left, top, width, height]: Window) -> Self {
        for y in top..top + height {
            for x in left..left + width {
                let inside = x > left && y > top && x + 1 < left + width && y + 1 < top + height;
                if !inside {
                    self.rgb[(y * self.width + x) as usize] = [255, 200, 0];
                }
            }
        }
        self
    }
}

/// A picture with its caption.
pub struct Panel {
    pub caption: String,
    pub picture: Picture,
}

/// Pixels between panels, and those of captions.
const GAP: u32 = 12;
const CAPTION: u32 = 30;

/// How often a film of this width fits into a panel.
pub fn zoom(width: u32) -> u32 {
    (384 / width.max(1)).clamp(1, 24)
}

/// Writes rows of panels; every column is as wide as its widest panel.
pub fn write(path: &Path, rows: &[Vec<Panel>]) -> Result<()> {
    register_fonts();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widest = |c: usize| rows.iter().filter_map(|row| row.get(c)).map(|p| p.picture.width).max().unwrap_or(0);
    let widths: Vec<u32> = (0..columns).map(widest).collect();
    // A row without captions needs no place for them.
    let captions: Vec<u32> =
        rows.iter().map(|row| if row.iter().all(|p| p.caption.is_empty()) { 0 } else { CAPTION }).collect();
    let highest = |row: &[Panel]| row.iter().map(|p| p.picture.height).max().unwrap_or(0);
    let heights: Vec<u32> = rows.iter().zip(&captions).map(|(row, caption)| highest(row) + caption).collect();
    let width = widths.iter().sum::<u32>() + GAP * (columns as u32 + 1);
    let height = heights.iter().sum::<u32>() + GAP * (rows.len() as u32 + 1);
    let mut rgb = vec![255u8; 3 * (width * height) as usize];
    let place = |row: usize, column: usize| {
        let left = GAP + widths[..column].iter().map(|w| w + GAP).sum::<u32>();
        let top = GAP + heights[..row].iter().map(|h| h + GAP).sum::<u32>();
        (left, top)
    };
    {
        let failed = |why: String| Error::runtime(format!("cannot write {}: {why}", path.display()));
        let root = BitMapBackend::with_buffer(&mut rgb, (width, height)).into_drawing_area();
        for (r, row) in rows.iter().enumerate() {
            for (c, panel) in row.iter().enumerate() {
                let (left, top) = place(r, c);
                let style = text_style(20.0, BLACK, HPos::Left, VPos::Center);
                let text = Text::new(panel.caption.clone(), (left as i32, (top + CAPTION / 2) as i32), style);
                root.draw(&text).map_err(|e| failed(e.to_string()))?;
            }
        }
        root.present().map_err(|e| failed(e.to_string()))?;
    }
    for (r, row) in rows.iter().enumerate() {
        for (c, Panel { picture, .. }) in row.iter().enumerate() {
            let (left, top) = place(r, c);
            for y in 0..picture.height {
                for x in 0..picture.width {
                    let at = 3 * ((top + captions[r] + y) * width + left + x) as usize;
                    rgb[at..at + 3].copy_from_slice(&picture.pixel(x, y));
                }
            }
        }
    }
    png::write(path, width, height, &rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_cut_enlarged_and_outlined() {
        let rgb = (0..12).map(|n| [n, 0, 0]).collect();
        let picture = Picture { width: 4, height: 3, rgb };
        let part = picture.crop([1, 1, 2, 2]);
        assert_eq!(part.rgb, [5, 6, 9, 10].map(|n| [n, 0, 0]));
        assert_eq!(part.enlarge(2).rgb[..4], [5, 5, 6, 6].map(|n| [n, 0, 0]));
        let outlined = picture.clone().outline([0, 0, 4, 3]);
        let changed: Vec<usize> = (0..12).filter(|n| outlined.rgb[*n] != picture.rgb[*n]).collect();
        assert_eq!(changed, [0, 1, 2, 3, 4, 7, 8, 9, 10, 11]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.png");
        let panel = |caption: &str| Panel { caption: caption.into(), picture: picture.enlarge(8) };
        write(&path, &[vec![panel("a"), panel("b")], vec![panel("c")]]).unwrap();
        assert!(path.is_file());
    }
}
