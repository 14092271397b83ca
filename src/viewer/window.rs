//! The window without a display, for tests: frames are run by hand, keys and clicks are put in, and what it asks of the
//! renderer is read from the channel.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};

use eframe::egui::{self, DroppedFile, Event as Input, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use glam::{Affine3A, Vec3};

use super::app::Viewer;
use super::messages::{Command, Event, Job, Opened, Picture};
use super::screen;
use crate::film::Image;
use crate::methods::Settings;
use crate::scene::{Camera, Features};

/// Pixels of the pictures.
pub const SIZE: [u32; 2] = [64, 48];

/// A window and both ends of what it says and hears.
pub struct Window {
    pub harness: Harness<'static, Viewer>,
    inbox: Receiver<Command>,
    pub events: Sender<Event>,
    /// What was asked for copying.
    pub copied: Option<String>,
}

impl Window {
    /// With a scene of two cameras, and a first picture of it.
    pub fn new() -> Self {
        Self::with(|builder| builder)
    }

    /// One that paints on a device, as it would on the screen.
    pub fn painting(size: Vec2) -> Self {
        Self::with(|builder| {
            let state = create_render_state(default_wgpu_setup(), Default::default());
            screen::install(&state);
            builder.with_size(size).renderer(WgpuTestRenderer::from_render_state(state)).with_render_cursor(false)
        })
    }

    fn with(setup: impl FnOnce(egui_kittest::HarnessBuilder<Viewer>) -> egui_kittest::HarnessBuilder<Viewer>) -> Self {
        let (commands, inbox) = mpsc::channel();
        let (events, heard) = mpsc::channel();
        let [width, height] = SIZE;
        let settings = Settings { width, height, ..Settings::default() };
        let viewer = Viewer::new(commands, heard, Path::new("box.glb"), settings, None, true, None);
        // A tenth of a second a frame.
        let builder = Harness::builder().with_size(Vec2::new(1280.0, 800.0)).with_step_dt(0.1);
        let harness = setup(builder).build_ui_state(|ui, viewer: &mut Viewer| viewer.frame(ui), viewer);
        let mut window = Self { harness, inbox, events, copied: None };
        assert!(matches!(window.asked()[..], [Command::Open(_)]));
        window.hear(Event::Opened(Box::new(opened())));
        window.picture(0, [0.25, 0.5, 1.0]);
        window
    }

    pub fn viewer(&mut self) -> &mut Viewer {
        self.harness.state_mut()
    }

    /// The renderer says something, and a frame passes.
    pub fn hear(&mut self, event: Event) {
        self.events.send(event).unwrap();
        self.frame();
    }

    /// A picture of one colour comes.
    pub fn picture(&mut self, slot: usize, value: [f32; 3]) {
        let [width, height] = SIZE;
        let image = Image { width, height, pixels: vec![value; (width * height) as usize] };
        let picture = Picture { image: Some(Arc::new(image)), ..Picture::default() };
        self.hear(Event::Picture { slot, picture: Box::new(picture), error: None });
    }

    /// A frame for every input that waits; at least one.
    pub fn frame(&mut self) {
        self.harness.step();
        for command in &self.harness.output().platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                self.copied = Some(text.clone());
            }
        }
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        let event = |pressed| Input::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        let held = Input::ModifiersChanged(modifiers);
        for event in [held, event(true), event(false), Input::ModifiersChanged(Modifiers::NONE)] {
            self.harness.event(event);
            self.frame();
        }
    }

    pub fn point(&mut self, at: Pos2) {
        self.harness.event(Input::PointerMoved(at));
        self.frame();
    }

    pub fn button(&mut self, at: Pos2, button: PointerButton, pressed: bool) {
        self.harness.event(Input::PointerMoved(at));
        self.harness.event(Input::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
        self.frame();
    }

    /// Files are let go over the window.
    pub fn drop_files(&mut self, paths: &[&str]) {
        let file = |path: &&str| -> egui::DroppedFileHandle { Arc::new(Dropped(PathBuf::from(path))) };
        self.harness.input_mut().dropped_files = paths.iter().map(file).collect();
        self.frame();
    }

    /// What was asked of the renderer since.
    pub fn asked(&self) -> Vec<Command> {
        self.inbox.try_iter().collect()
    }

    pub fn jobs(&self) -> Vec<Job> {
        let job = |command| if let Command::Render(job) = command { Some(*job) } else { None };
        self.asked().into_iter().filter_map(job).collect()
    }
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("no file is read here".into())
    }
}

/// A scene of two cameras.
pub fn opened() -> Opened {
    let camera = |name: &str, z| Camera {
        name: name.into(),
        world_from_camera: Affine3A::from_translation(Vec3::Z * z),
        vertical_fov: 0.8,
        orthographic_height: None,
        lens: None,
        aspect: None,
    };
    Opened {
        path: "box.glb".into(),
        files: vec![],
        name: "box".into(),
        sky: None,
        triangles: 12,
        cameras: vec![camera("Main", 4.0), camera("Near", 2.0)],
        sphere: (Vec3::ZERO, 1.0),
        features: Features::default(),
        warnings: vec![],
    }
}
