//! Writing the pictures without holding up the renderer.

use std::path::{Path, PathBuf};
use std::thread;

use super::messages::Event;
use super::worker::Worker;
use crate::methods::{Method, Outcome, Settings};
use crate::report::outputs::{self, Outputs};
use crate::scene::Scene;
use crate::{Error, Result};

impl Worker<'_> {
    /// Takes the pictures as they stand; the files are written on a thread of their own, which outlives the window.
    pub(super) fn save(&mut self, path: &Path) -> Result<()> {
        let Some(loaded) = &self.state.loaded else { return Ok(()) };
        if self.tracks.is_empty() || self.tracks.iter().any(|track| !track.session.has_image()) {
            return Err(Error::input("there is no image to save yet: wait until the preview has gone"));
        }
        let several = self.tracks.len() > 1;
        let mut writes: Vec<(Outputs, Settings, Outcome)> = Vec::new();
        for track in &mut self.tracks {
            while !track.session.is_whole() {
                track.session.advance(None)?;
            }
            let path = if several { with_method(path, track.settings.method) } else { path.to_path_buf() };
            let outcome = track.session.snapshot()?;
            writes.push((Outputs::new(path, track.settings.maps), track.settings.clone(), outcome));
        }
        // The file's header needs the name alone.
        let scene = Scene { name: loaded.scene.name.clone(), ..Scene::default() };
        let out = self.state.out.clone();
        self.state.saves.retain(|save| !save.is_finished());
        self.state.saves.push(thread::spawn(move || {
            for (outputs, settings, outcome) in writes {
                out.send(match outputs::write(&outputs, &scene, &settings, &outcome) {
                    Ok(_) => Event::Note(format!("saved {} with its preview", outputs.exr.display())),
                    Err(error) => Event::Failed(error.to_string()),
                });
            }
        }));
        Ok(())
    }
}

/// `a.exr` becomes `a.mlt.exr`.
fn with_method(path: &Path, method: Method) -> PathBuf {
    path.with_extension(format!("{}.exr", method.name()))
}
