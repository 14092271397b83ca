//! The decoder of EXT_meshopt_compression and KHR_meshopt_compression, after their specifications: one buffer view's
//! worth of vertex data or indices from its compressed bytes.
//!
//! Nothing is trusted: what is decoded grows with the bytes that are read, and every read is checked.

mod filters;
mod indices;
#[cfg(test)]
mod tests;
mod vertices;

/// What the bytes hold (the extension's `mode`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Vertex data of any kind.
    Attributes,
    /// Indices of a triangle list.
    Triangles,
    /// Any other indices.
    Indices,
}

/// What is applied to vertex data once it is decoded (the extension's `filter`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    None,
    /// Unit vectors.
    Octahedral,
    /// Unit quaternions.
    Quaternion,
    /// Floating-point numbers.
    Exponential,
    /// Colours.
    Color,
}

/// How a buffer view is compressed; see [`Layout::check`] for what is allowed.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    pub mode: Mode,
    pub filter: Filter,
    /// Bytes of one element.
    pub stride: u64,
    /// Number of elements.
    pub count: u64,
}

/// Said where the bytes end before the elements do.
const SHORT: &str = "its data ends too early";
/// Said where the elements end before the bytes do.
const LEFT_OVER: &str = "it has more data than elements";

impl Layout {
    /// Whether the extension allows this layout; what is wrong with it otherwise.
    pub fn check(&self) -> Result<(), &'static str> {
        let Self { mode, filter, stride, count } = *self;
        let stride_fits = match mode {
            Mode::Attributes => stride % 4 == 0 && (4..=256).contains(&stride),
            Mode::Triangles | Mode::Indices => stride == 2 || stride == 4,
        };
        let filter_fits = match filter {
            Filter::None => true,
            Filter::Octahedral | Filter::Color => stride == 4 || stride == 8,
            Filter::Quaternion => stride == 8,
            Filter::Exponential => true,
        };
        if !stride_fits || !filter_fits {
            return Err("its byteStride does not fit its mode and filter");
        }
        if filter != Filter::None && mode != Mode::Attributes {
            return Err("its filter does not fit its mode");
        }
        if mode == Mode::Triangles && count % 3 != 0 {
            return Err("its count is not one of whole triangles");
        }
        Ok(())
    }

    /// The `count * stride` bytes that `data` stands for. The layout is one that [`Self::check`] lets pass.
    ///
    /// # Errors
    /// What is wrong with the data, as half a sentence.
    pub fn decode(&self, data: &[u8]) -> Result<Vec<u8>, &'static str> {
        let (stride, count) = (self.stride as usize, self.count);
        let mut bytes = match self.mode {
            Mode::Attributes => vertices::decode(stride, count, data)?,
            Mode::Triangles => indices::triangles(stride, count, data)?,
            Mode::Indices => indices::sequence(stride, count, data)?,
        };
        match self.filter {
            Filter::None => {}
            Filter::Octahedral => filters::octahedral(stride, &mut bytes),
            Filter::Quaternion => filters::quaternion(&mut bytes),
            Filter::Exponential => filters::exponential(&mut bytes),
            Filter::Color => filters::color(stride, &mut bytes),
        }
        Ok(bytes)
    }
}
