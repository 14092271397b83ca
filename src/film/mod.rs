//! Images: what the renderer hands over, and how it is written and compared.

pub mod cells;
pub mod exr;
pub mod file;
pub mod flip;
pub mod layers;
pub mod metrics;
pub mod png;
pub mod uncertainty;

/// Linear Rec.709 pixels, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    /// `width * height` pixels, row by row.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }
}

/// A further channel of the same size as the image it goes with, such as `Maps.Horizontal`.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    pub name: String,
    pub values: Vec<f32>,
}
