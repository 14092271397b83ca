//! The window's state, what changes it, and what follows from changes.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};
use std::time::Duration;

use eframe::egui::{self, Rect, Ui, Vec2};
use glam::Vec3;

use super::canvas::{Hovered, Placement};
use super::files::Watches;
use super::messages::{Command, Event, Job, Opened};
use super::orbit::Orbit;
use super::overlay::Layer;
use super::slot::Slot;
use super::tone::Tone;
use crate::film::Image;
use crate::methods::{Method, Settings, default_size};
use crate::scene::Camera;

/// Changes of settings wait so long for more of them, in seconds: a slider that is dragged restarts once.
const SETTLE_S: f64 = 0.3;

/// A sentence in the status line.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    pub text: String,
    pub error: bool,
}

/// Everything that is shown and can be changed.
pub struct Viewer {
    commands: Sender<Command>,
    events: Receiver<Event>,
    /// Where the camera was asked to be placed, until the first scene is there.
    look: Option<(Vec3, Vec3)>,
    /// Whether the film's size was asked for; else it follows the camera.
    pub(super) own_size: bool,
    pub(super) settings: Settings,
    /// Another method beside the first.
    pub(super) second: Option<Method>,
    pub(super) scene: Option<Opened>,
    pub(super) orbit: Option<Orbit>,
    pub(super) slots: Vec<Slot>,
    pub(super) tone: Tone,
    pub(super) placement: Placement,
    /// First part of the canvas and the film's size, of the last frame.
    pub(super) parts: (Rect, Vec2),
    /// What lies over the pictures.
    pub(super) layer: Option<Layer>,
    /// How opaque it is, by its kind.
    pub(super) shares: [f32; 4],
    /// The kernel whose acceptance was looked at last.
    pub(super) kernel: Option<&'static str>,
    pub(super) reference: Option<Arc<Image>>,
    pub(super) hovered: Option<Hovered>,
    pub(super) note: Option<Note>,
    pub(super) paused: bool,
    moving: bool,
    /// When the wheel, which has no end, is taken to have stopped moving the camera.
    pub(super) still_at: Option<f64>,
    pub(super) panels: bool,
    pub(super) help: bool,
    /// Why the mix that was asked for is not rendered.
    pub(super) mix_error: Option<String>,
    /// When changed settings take effect.
    apply_at: Option<f64>,
    pub(super) watches: Watches,
    /// Seconds that the interface took for its last frames, and between them.
    pub(super) pace: Pace,
}

/// How the interface keeps up, as running means.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pace {
    pub work_s: f32,
    pub longest_s: f32,
}

impl Viewer {
    /// Asks for the scene at once.
    pub fn new(
        commands: Sender<Command>,
        events: Receiver<Event>,
        scene: &Path,
        settings: Settings,
        look: Option<(Vec3, Vec3)>,
        own_size: bool,
        reference: Option<&Path>,
    ) -> Self {
        let viewer = Self {
            commands,
            events,
            look,
            own_size,
            // The maps cost next to nothing and can then be shown at any time.
            settings: Settings { maps: true, ..settings },
            second: None,
            scene: None,
            orbit: None,
            slots: Vec::new(),
            tone: Tone::default(),
            placement: Placement::FIT,
            parts: (Rect::ZERO, Vec2::splat(1.0)),
            layer: None,
            shares: [0.6, 1.0, 1.0, 1.0],
            kernel: None,
            reference: None,
            hovered: None,
            note: None,
            paused: false,
            moving: false,
            still_at: None,
            panels: true,
            help: false,
            mix_error: None,
            apply_at: None,
            watches: Watches::default(),
            pace: Pace::default(),
        };
        viewer.send(Command::Open(scene.to_path_buf()));
        if let Some(path) = reference {
            viewer.send(Command::Reference(path.to_path_buf()));
        }
        viewer
    }

    /// The renderer hears everything while the window is open; a thread that is gone has said why.
    pub(super) fn send(&self, command: Command) {
        let _ = self.commands.send(command);
    }

    /// One frame of the interface.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.hear(&ctx);
        self.keys(&ctx);
        self.take_dropped(&ctx);
        self.look_at_the_disk(&ctx);
        self.top_bar(ui);
        self.status_bar(ui);
        if self.panels {
            self.side_panel(ui);
        }
        egui::CentralPanel::no_frame().show(ui, |ui| self.canvas(ui));
        self.help_window(&ctx);
        self.apply(&ctx);
    }

    /// What the renderer has sent.
    fn hear(&mut self, ctx: &egui::Context) {
        while let Ok(event) = self.events.try_recv() {
            match event {
                Event::Opened(opened) => {
                    ctx.send_viewport_cmd(egui::ViewportCommand::Title(title(&opened.path)));
                    self.opened(*opened);
                }
                Event::Progress { slot, stage, share } => {
                    if let Some(slot) = self.slots.get_mut(slot) {
                        slot.progress = Some((stage, share));
                    }
                }
                Event::Picture { slot, picture, error } => {
                    if let Some(slot) = self.slots.get_mut(slot) {
                        slot.set_picture(*picture, error);
                    }
                }
                Event::Reference { path, image } => {
                    self.watches.reference(&path);
                    self.slots.iter_mut().for_each(Slot::forget_errors);
                    self.reference = Some(image);
                    let (w, h) = (self.settings.width, self.settings.height);
                    self.note = self.reference.as_ref().filter(|_| !self.comparable()).map(|r| Note {
                        text: format!(
                            "the reference has {}x{} pixels and the image {w}x{h}: set the same size to compare them",
                            r.width, r.height
                        ),
                        error: true,
                    });
                }
                Event::Note(text) => self.note = Some(Note { text, error: false }),
                Event::Failed(text) => self.note = Some(Note { text, error: true }),
            }
        }
    }

    /// A scene was read, for the first time or again: a camera that was moved stays where it is.
    fn opened(&mut self, opened: Opened) {
        let again = self.scene.as_ref().is_some_and(|scene| scene.path == opened.path);
        let name = match &self.orbit {
            Some(orbit) => again.then(|| orbit.name().to_string()),
            None => self.settings.camera.clone(),
        };
        let camera = opened.cameras.iter().find(|c| Some(&c.name) == name.as_ref()).or(opened.cameras.first());
        let Some(camera) = camera.cloned() else { return };
        let before = self.orbit.as_ref().and_then(Orbit::look).filter(|_| again);
        let look = self.look.take().or(before);
        self.watches.opened(&opened);
        self.note = opened.warnings.first().map(|text| Note { text: text.clone(), error: false });
        let sphere = opened.sphere;
        self.scene = Some(opened);
        self.set_camera(camera, sphere, look);
        if !again {
            self.slots.clear();
            self.placement = Placement::FIT;
        }
        self.restart();
    }

    fn set_camera(&mut self, camera: Camera, sphere: (Vec3, f32), look: Option<(Vec3, Vec3)>) {
        if !self.own_size {
            (self.settings.width, self.settings.height) = default_size(&camera);
        }
        self.settings.camera = Some(camera.name.clone());
        // An orthographic one sees as the file has it.
        let camera = camera.through(self.settings.lens).unwrap_or(camera);
        let mut orbit = Orbit::new(camera, sphere);
        if let Some((eye, target)) = look {
            orbit.place(eye, target);
        }
        self.orbit = Some(orbit);
    }

    /// Another of the file's cameras, or the same as the file has it.
    pub(super) fn choose_camera(&mut self, number: usize) {
        let Some(scene) = &self.scene else { return };
        let Some(camera) = scene.cameras.get(number).cloned() else { return };
        self.set_camera(camera, scene.sphere, None);
        self.restart();
    }

    /// The file's camera as it was before it was moved.
    pub(super) fn camera_home(&mut self) {
        let name = self.orbit.as_ref().map(Orbit::name);
        let cameras = self.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
        if let Some(number) = cameras.iter().position(|c| Some(c.name.as_str()) == name) {
            self.choose_camera(number);
        }
    }

    /// Begins anew with the settings as they are.
    pub(super) fn restart(&mut self) {
        self.apply_at = None;
        let Some(orbit) = &self.orbit else { return };
        let job = Job { settings: self.settings.clone(), camera: orbit.camera(), second: self.second };
        let pictures = job.pictures();
        self.slots.truncate(pictures.len());
        for (i, settings) in pictures.into_iter().enumerate() {
            match self.slots.get_mut(i) {
                Some(slot) => slot.restart(settings),
                None => self.slots.push(Slot::new(settings)),
            }
        }
        if self.note.as_ref().is_some_and(|note| note.error) {
            self.note = None;
        }
        self.send(Command::Render(Box::new(job)));
    }

    /// Settings were changed: the render begins anew once they have settled.
    pub(super) fn changed(&mut self, ctx: &egui::Context) {
        self.apply_at = Some(ctx.input(|i| i.time) + SETTLE_S);
    }

    fn apply(&mut self, ctx: &egui::Context) {
        let Some(at) = self.apply_at else { return };
        let wait = at - ctx.input(|i| i.time);
        if wait <= 0.0 {
            self.restart();
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(wait));
        }
    }

    pub(super) fn set_method(&mut self, method: Method) {
        if self.settings.method == method {
            return;
        }
        self.settings.method = method;
        // A mix is for the method it was made for, and so is a partner.
        self.settings.kernels = None;
        self.mix_error = None;
        self.second = self.second.filter(|second| *second != method);
        self.restart();
    }

    pub(super) fn set_paused(&mut self, paused: bool) {
        self.paused = paused;
        self.send(Command::Pause(paused));
    }

    /// Moves the camera; the preview follows at once, the render begins when it is still.
    pub(super) fn move_camera(&mut self, change: impl FnOnce(&mut Orbit)) {
        let Some(orbit) = &mut self.orbit else { return };
        change(orbit);
        let camera = orbit.camera();
        if !self.moving {
            self.moving = true;
            self.send(Command::Moving(true));
        }
        for slot in &mut self.slots {
            slot.restart(slot.settings.clone());
        }
        self.send(Command::Look(camera));
    }

    pub(super) fn camera_is_still(&mut self) {
        if self.moving {
            self.moving = false;
            self.send(Command::Moving(false));
        }
    }

    /// Writes the pictures under the scene's name, into the current folder; never over a file that is there.
    pub(super) fn save(&mut self) {
        let Some(scene) = &self.scene else { return };
        let path = free_name(&scene.name, |path| path.exists());
        self.note = Some(Note { text: format!("saving {}", path.display()), error: false });
        self.send(Command::Save(path));
    }

    /// Whether the reference is of the image's size.
    pub(super) fn comparable(&self) -> bool {
        let size = (self.settings.width, self.settings.height);
        self.reference.as_ref().is_some_and(|r| (r.width, r.height) == size)
    }
}

impl eframe::App for Viewer {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.frame(ui);
        let taken = frame.info().cpu_usage.unwrap_or_default();
        self.pace.work_s += 0.1 * (taken - self.pace.work_s);
        self.pace.longest_s = taken.max(0.98 * self.pace.longest_s);
    }
}

/// The window's title for a scene.
pub fn title(scene: &Path) -> String {
    format!("{} - emlt", scene.file_name().unwrap_or_default().to_string_lossy())
}

/// `name.exr`, or the first of `name-2.exr`, `name-3.exr` and so on that is not taken.
fn free_name(name: &str, taken: impl Fn(&Path) -> bool) -> PathBuf {
    let numbered = |n: u32| PathBuf::from(if n == 1 { format!("{name}.exr") } else { format!("{name}-{n}.exr") });
    (1..).map(numbered).find(|path| !taken(path)).expect("numbers do not end")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saving_takes_a_name_that_is_free() {
        assert_eq!(free_name("box", |_| false), Path::new("box.exr"));
        let taken = ["box.exr", "box-2.exr"].map(Path::new);
        assert_eq!(free_name("box", |path| taken.contains(&path)), Path::new("box-3.exr"));
    }
}
