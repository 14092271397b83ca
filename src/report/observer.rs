//! Who hears of a render's progress.

use crate::Result;
use crate::methods::Outcome;

/// Hears of progress and may ask to stop; called between dispatches on the rendering thread.
pub trait Observer {
    /// A new stage begins ("compiling shaders", "seeding", "rendering").
    fn stage(&mut self, _name: &str) {}
    /// Done share of the current stage in [0, 1].
    fn progress(&mut self, _share: f64) {}
    /// Whether to be shown the image at times fixed in advance; each look costs a copy of the film.
    fn looks(&self) -> bool {
        false
    }
    /// The image as it stands: at mutation counts that grow by about the square root of 2, and at the end. An error ends
    /// the render.
    fn look(&mut self, _outcome: &Outcome) -> Result<()> {
        Ok(())
    }
    /// True ends the render early with the image as it stands.
    fn stop_requested(&self) -> bool {
        false
    }
}

/// Neither shows nor stops anything.
pub struct Silent;

impl Observer for Silent {}
