//! Who hears of a render's progress.

/// Hears of progress and may ask to stop; called between dispatches on the rendering thread.
pub trait Observer {
    /// A new stage begins ("compiling shaders", "seeding", "rendering").
    fn stage(&mut self, _name: &str) {}
    /// Done share of the current stage in [0, 1].
    fn progress(&mut self, _share: f64) {}
    /// True ends the render early with the image as it stands.
    fn stop_requested(&self) -> bool {
        false
    }
}

/// Neither shows nor stops anything.
pub struct Silent;

impl Observer for Silent {}
