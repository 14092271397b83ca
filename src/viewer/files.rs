//! What comes from the disk while the window is open: files that are dropped, and those that change.

use std::path::Path;
use std::time::Duration;

use eframe::egui;

use super::app::{Note, Viewer};
use super::messages::Command;
use super::watch::{self, Watch};

impl Viewer {
    /// Reads the scene again.
    pub(super) fn reload(&mut self) {
        if let Some(scene) = &self.scene {
            self.send(Command::Open(scene.path.clone()));
        }
    }

    /// Uses a folder's shaders, now and whenever one of them changes.
    pub(super) fn use_shaders(&mut self, folder: &Path) {
        self.shaders = Some(Watch::new(folder));
        self.send(Command::Shaders(folder.to_path_buf()));
    }

    pub(super) fn take_dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for file in files {
            self.take_file(file.path());
        }
    }

    /// A scene or a reference, by its name.
    pub(super) fn take_file(&mut self, path: &Path) {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("glb" | "gltf") => self.send(Command::Open(path.to_path_buf())),
            Some("exr") => self.send(Command::Image(path.to_path_buf())),
            Some("hdr") => self.send(Command::Sky(path.to_path_buf())),
            _ => {
                let text = format!(
                    "{} is neither a scene nor an image: drop a .glb or .gltf scene, a sky (.hdr, .exr) or a reference (.exr)",
                    path.display()
                );
                self.note = Some(Note { text, error: true });
            }
        }
    }

    pub(super) fn look_at_the_disk(&mut self, ctx: &egui::Context) {
        let now = ctx.input(|i| i.time);
        let changed = |watch: &mut Option<Watch>| {
            let watch = watch.as_mut()?;
            watch.changed(now).then(|| watch.path().to_path_buf())
        };
        if let Some(path) = changed(&mut self.watch) {
            self.send(Command::Open(path));
        }
        if let Some(path) = changed(&mut self.shaders) {
            self.send(Command::Shaders(path));
        }
        ctx.request_repaint_after(Duration::from_secs_f64(watch::INTERVAL_S));
    }
}
