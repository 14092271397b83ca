//! What comes from the disk while the window is open: files that are dropped, and those that change.

use std::path::{Path, PathBuf};
use std::time::Duration;

use eframe::egui;

use super::app::{Note, Viewer};
use super::messages::{Command, Opened};
use super::watch::{self, Watch};

/// What is read again when it changes; each is none until there is one.
#[derive(Debug, Default)]
pub struct Watches {
    /// The scene with its buffers and images.
    scene: Option<Watch>,
    sky: Option<Watch>,
    reference: Option<Watch>,
    shaders: Option<Watch>,
}

impl Watches {
    /// A scene was read, perhaps with a sky.
    pub fn opened(&mut self, opened: &Opened) {
        // The path that was asked for comes first, also where nothing is said of files.
        let beside = opened.files.iter().filter(|path| **path != opened.path);
        watch(&mut self.scene, [&opened.path].into_iter().chain(beside).cloned().collect());
        match &opened.sky {
            Some(sky) => watch(&mut self.sky, vec![sky.clone()]),
            None => self.sky = None,
        }
    }

    pub fn reference(&mut self, path: &Path) {
        watch(&mut self.reference, vec![path.to_path_buf()]);
    }

    /// What to ask of the renderer at this time.
    fn changes(&mut self, now_s: f64) -> Vec<Command> {
        let read_again: [Watched; 4] = [
            (&mut self.scene, Command::Open),
            (&mut self.sky, Command::Sky),
            (&mut self.reference, Command::Reference),
            (&mut self.shaders, Command::Shaders),
        ];
        let changed = |(watch, command): Watched| {
            let watch = watch.as_mut()?;
            watch.changed(now_s).then(|| command(watch.paths()[0].clone()))
        };
        read_again.into_iter().filter_map(changed).collect()
    }
}

/// What is watched, and what to ask of the renderer when it has changed.
type Watched<'a> = (&'a mut Option<Watch>, fn(PathBuf) -> Command);

/// Watches these paths from now on; where they are watched already, changes since they were read are not lost.
fn watch(watch: &mut Option<Watch>, paths: Vec<PathBuf>) {
    if watch.as_ref().is_none_or(|watch| watch.paths() != paths) {
        *watch = Some(Watch::of_all(paths));
    }
}

impl Viewer {
    /// Reads the scene again.
    pub(super) fn reload(&mut self) {
        if let Some(scene) = &self.scene {
            self.send(Command::Open(scene.path.clone()));
        }
    }

    /// Uses a folder's shaders, now and whenever one of them changes.
    pub(super) fn use_shaders(&mut self, folder: &Path) {
        self.watches.shaders = Some(Watch::new(folder));
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
        for command in self.watches.changes(ctx.input(|i| i.time)) {
            self.send(command);
        }
        ctx.request_repaint_after(Duration::from_secs_f64(watch::INTERVAL_S));
    }
}
