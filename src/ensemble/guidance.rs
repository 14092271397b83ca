//! How guided kernels look at the other half (METHOD.md 3.2 to 3.4). Fixed before the run, so any choice is exact.

use crate::gpu::layout::PassUniform;
use crate::{Error, Result};

/// Most guides a look-up: the shaders' arrays hold so many.
pub const MOST_GUIDES: u32 = 32;
/// Similarity bandwidth h as a fraction of the scene's bounding radius (METHOD.md 3.3).
pub const SIMILARITY_RADIUS: f32 = 0.2;
/// What normals are multiplied by before they count like positions; in units of the bounding radius. Twin in
/// shaders/transport/similarity.wesl.
pub const NORMAL_LENGTH: f64 = 0.2;

/// What guided kernels take from the other half, and how far they go with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guidance {
    /// Guides a look-up, M of the supplement: 1 to [`MOST_GUIDES`].
    pub guides: u32,
    /// Least and largest size of a step in spreads of the guides; between them by similarity. Equal: a static size.
    pub alpha: [f32; 2],
    /// Whether similarity compares normals too (the supplement's section 6 does for comparison, and finds it worse).
    pub normals: bool,
}

impl Default for Guidance {
    /// The supplement's figures.
    fn default() -> Self {
        Self { guides: 16, alpha: [0.05, 0.5], normals: false }
    }
}

impl Guidance {
    /// Refuses what the kernels cannot do.
    pub fn check(&self) -> Result<()> {
        if !(1..=MOST_GUIDES).contains(&self.guides) {
            return Err(Error::input(format!("{} guides a look-up: choose 1 to {MOST_GUIDES}", self.guides)));
        }
        if !self.alpha.iter().all(|alpha| *alpha > 0.0 && *alpha <= 1.0) || self.alpha[0] > self.alpha[1] {
            return Err(Error::input("alpha is a number above 0 and at most 1: try 0.05 to 0.5"));
        }
        Ok(())
    }

    /// `uniform` with everything that is the same all through a run.
    pub fn of_run(&self, uniform: PassUniform) -> PassUniform {
        PassUniform {
            similarity_scale: 1.0 / (SIMILARITY_RADIUS * SIMILARITY_RADIUS),
            guides: self.guides,
            alpha_low: self.alpha[0],
            alpha_high: self.alpha[1],
            ..uniform
        }
    }

    /// The flag of passes that read or publish guides.
    pub fn flags(&self) -> &'static [&'static str] {
        if self.normals { &["normals"] } else { &[] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_guidance_is_refused() {
        assert!(Guidance::default().check().is_ok());
        for guides in [0, MOST_GUIDES + 1] {
            assert!(Guidance { guides, ..Default::default() }.check().is_err());
        }
        for alpha in [[0.0, 0.5], [0.5, 0.05], [f32::NAN, 0.5], [0.05, 1.5]] {
            assert!(Guidance { alpha, ..Default::default() }.check().is_err(), "{alpha:?}");
        }
    }
}
