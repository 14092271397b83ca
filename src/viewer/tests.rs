//! The window without a display: frames are run by hand, keys and clicks are put in, and what it asks of the renderer is
//! read from the channel.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};

use eframe::egui::{self, Event as Input, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, Vec2};
use glam::{Affine3A, Vec3};

use super::app::Viewer;
use super::messages::{Command, ErrorPoint, Event, Job, Opened, Picture};
use super::slot::ErrorMap;
use super::tone::{Curve, Tone};
use crate::film::Image;
use crate::methods::{Method, Settings, Stage};
use crate::scene::{Camera, Features};

/// A window of 1280 x 800 points, and both ends of what it says and hears.
struct Window {
    viewer: Viewer,
    ctx: egui::Context,
    inbox: Receiver<Command>,
    events: Sender<Event>,
    time_s: f64,
    modifiers: Modifiers,
    /// What was asked for copying.
    copied: Option<String>,
}

impl Window {
    /// With a scene of two cameras, and a first picture of it.
    fn new() -> Self {
        let (commands, inbox) = mpsc::channel();
        let (events, heard) = mpsc::channel();
        let settings = Settings { width: 64, height: 48, ..Settings::default() };
        let viewer = Viewer::new(commands, heard, Path::new("box.glb"), settings, None, true, None);
        let ctx = egui::Context::default();
        let (time_s, modifiers, copied) = (0.0, Modifiers::NONE, None);
        let mut window = Self { viewer, ctx, inbox, events, time_s, modifiers, copied };
        assert!(matches!(window.asked()[..], [Command::Open(_)]));
        window.events.send(Event::Opened(Box::new(opened()))).unwrap();
        window.frame(vec![]);
        window.picture(0, [0.25, 0.5, 1.0]);
        window.frame(vec![]);
        window
    }

    fn picture(&self, slot: usize, value: [f32; 3]) {
        let image = Image { width: 64, height: 48, pixels: vec![value; 64 * 48] };
        let picture = Picture { image: Some(Arc::new(image)), ..Picture::default() };
        self.events.send(Event::Picture { slot, picture: Box::new(picture), error: None }).unwrap();
    }

    /// One frame, a tenth of a second after the last.
    fn frame(&mut self, mut events: Vec<Input>) {
        self.time_s += 0.1;
        events.insert(0, Input::ModifiersChanged(self.modifiers));
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, Vec2::new(1280.0, 800.0))),
            time: Some(self.time_s),
            events,
            ..RawInput::default()
        };
        let mut output = self.ctx.clone().run_ui(input, |ui| self.viewer.frame(ui));
        // What is on the screen can be turned into triangles, whatever it is.
        let shapes = std::mem::take(&mut output.shapes);
        assert!(!self.ctx.tessellate(shapes, output.pixels_per_point).is_empty());
        for command in output.platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                self.copied = Some(text);
            }
        }
        assert!(self.time_s < 1e3);
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        let event = |pressed| Input::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        self.modifiers = modifiers;
        self.frame(vec![event(true), event(false)]);
        self.modifiers = Modifiers::NONE;
    }

    fn button(&mut self, at: Pos2, button: PointerButton, pressed: bool) {
        let modifiers = self.modifiers;
        self.frame(vec![Input::PointerMoved(at), Input::PointerButton { pos: at, button, pressed, modifiers }]);
    }

    /// What was asked of the renderer since.
    fn asked(&self) -> Vec<Command> {
        self.inbox.try_iter().collect()
    }

    fn jobs(&self) -> Vec<Job> {
        let job = |command| if let Command::Render(job) = command { Some(*job) } else { None };
        self.asked().into_iter().filter_map(job).collect()
    }
}

fn opened() -> Opened {
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
        name: "box".into(),
        sky: None,
        triangles: 12,
        cameras: vec![camera("Main", 4.0), camera("Near", 2.0)],
        sphere: (Vec3::ZERO, 1.0),
        features: Features::default(),
        warnings: vec![],
    }
}

#[test]
fn a_scene_starts_with_its_first_camera() {
    let window = Window::new();
    let jobs = window.jobs();
    assert_eq!(jobs.len(), 1);
    assert_eq!((jobs[0].camera.name.as_str(), jobs[0].second), ("Main", None));
    let pictures = jobs[0].pictures();
    assert_eq!(pictures.len(), 1);
    assert!(pictures[0].maps && pictures[0].method == Method::Emlt);
}

#[test]
fn exposure_and_curve_follow_the_keys_and_ask_nothing_of_the_renderer() {
    let mut window = Window::new();
    window.jobs();
    window.press(Modifiers::NONE, Key::E);
    window.press(Modifiers::NONE, Key::E);
    window.press(Modifiers::SHIFT, Key::E);
    window.press(Modifiers::NONE, Key::O);
    let tone = window.viewer.tone;
    assert_eq!((tone.exposure, tone.curve), (0.5, Curve::Srgb));
    assert!((tone.offset - 0.1).abs() < 1e-6);
    window.press(Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(window.viewer.tone.curve, Curve::Filmic);
    window.press(Modifiers::NONE, Key::N);
    assert!((window.viewer.tone.exposure - (1.0f32 / 0.75).log2()).abs() < 1e-6);
    window.press(Modifiers::NONE, Key::R);
    assert_eq!(window.viewer.tone, Tone::default());
    assert!(window.asked().is_empty());
}

#[test]
fn space_pauses_and_resumes() {
    let mut window = Window::new();
    window.asked();
    window.press(Modifiers::NONE, Key::Space);
    assert!(matches!(window.asked()[..], [Command::Pause(true)]));
    window.press(Modifiers::NONE, Key::Space);
    assert!(matches!(window.asked()[..], [Command::Pause(false)]));
}

#[test]
fn a_method_restarts_at_once_and_a_setting_once_it_has_settled() {
    let mut window = Window::new();
    window.asked();
    window.press(Modifiers::NONE, Key::Num3);
    let jobs = window.jobs();
    assert_eq!(jobs.len(), 1);
    assert_eq!(jobs[0].settings.method, Method::Pt);
    assert!(!jobs[0].pictures()[0].maps, "path tracing has none");
    // As a slider that is dragged changes it.
    for depth in [5, 6, 7] {
        window.viewer.settings.max_depth = depth;
        window.viewer.changed(&window.ctx.clone());
        window.frame(vec![]);
    }
    assert!(window.asked().is_empty());
    (0..4).for_each(|_| window.frame(vec![]));
    let jobs = window.jobs();
    assert_eq!(jobs.len(), 1);
    assert_eq!(jobs[0].settings.max_depth, 7);
}

#[test]
fn another_method_beside_the_first_gets_a_picture_of_its_own() {
    let mut window = Window::new();
    window.asked();
    window.viewer.second = Some(Method::Pt);
    window.viewer.restart();
    let methods: Vec<Method> = window.jobs()[0].pictures().iter().map(|s| s.method).collect();
    assert_eq!(methods, [Method::Emlt, Method::Pt]);
    window.picture(1, [0.5; 3]);
    window.events.send(Event::Progress { slot: 0, stage: Stage::Seeding, share: 0.5 }).unwrap();
    window.frame(vec![]);
    assert_eq!(window.viewer.slots.len(), 2);
    window.press(Modifiers::NONE, Key::Num3);
    assert_eq!(window.viewer.slots.len(), 1, "pt beside pt would be the same picture twice");
}

#[test]
fn the_right_button_turns_the_camera_and_the_render_begins_when_it_is_let_go() {
    let mut window = Window::new();
    window.asked();
    let at = Pos2::new(400.0, 400.0);
    window.button(at, PointerButton::Secondary, true);
    window.frame(vec![Input::PointerMoved(at + Vec2::new(40.0, 0.0))]);
    window.frame(vec![Input::PointerMoved(at + Vec2::new(80.0, 10.0))]);
    let asked = window.asked();
    assert!(matches!(asked[0], Command::Moving(true)), "{asked:?}");
    let eyes: Vec<Vec3> = asked
        .iter()
        .filter_map(|c| {
            if let Command::Look(camera) = c { Some(camera.world_from_camera.translation.into()) } else { None }
        })
        .collect();
    assert!(eyes.len() >= 2 && eyes.iter().all(|eye| (eye.length() - 4.0).abs() < 1e-3), "{eyes:?}");
    assert!(eyes.last().unwrap().x < -1.0, "the scene follows the hand: {eyes:?}");
    window.button(at + Vec2::new(80.0, 10.0), PointerButton::Secondary, false);
    window.frame(vec![]);
    assert!(matches!(window.asked()[..], [Command::Moving(false)]));
    window.press(Modifiers::NONE, Key::Home);
    assert_eq!(window.jobs()[0].camera, opened().cameras[0]);
}

#[test]
fn the_left_button_and_the_wheel_move_the_image_alone() {
    let mut window = Window::new();
    window.asked();
    let at = Pos2::new(400.0, 400.0);
    window.button(at, PointerButton::Primary, true);
    window.frame(vec![Input::PointerMoved(at + Vec2::new(40.0, 20.0))]);
    window.button(at + Vec2::new(40.0, 20.0), PointerButton::Primary, false);
    assert_eq!(window.viewer.placement.offset, Vec2::new(40.0, 20.0));
    window.press(Modifiers::COMMAND, Key::Num0);
    assert_eq!(window.viewer.placement.zoom, Some(1.0));
    window.frame(vec![Input::PointerMoved(window.viewer.parts.0.center())]);
    window.frame(vec![]);
    assert_eq!(window.viewer.hovered.unwrap().pixel, [32, 24]);
    window.press(Modifiers::NONE, Key::F);
    assert_eq!(window.viewer.placement.zoom, None);
    assert!(window.asked().is_empty());
}

#[test]
fn files_are_taken_by_their_kind() {
    let mut window = Window::new();
    window.asked();
    for path in ["a.GLB", "b.gltf", "c.exr", "d.HDR", "e.txt"] {
        window.viewer.take_file(Path::new(path));
    }
    let asked = window.asked();
    assert!(
        matches!(&asked[..], [Command::Open(a), Command::Open(b), Command::Image(c), Command::Sky(d)]
            if a == Path::new("a.GLB") && b == Path::new("b.gltf") && c == Path::new("c.exr") && d == Path::new("d.HDR")),
        "{asked:?}"
    );
    assert!(window.viewer.note.as_ref().unwrap().error);
}

#[test]
fn the_command_line_is_copied_and_a_failure_is_shown() {
    let mut window = Window::new();
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::C);
    assert_eq!(window.copied.as_deref(), Some("emlt render box.glb --method emlt --size 64x48 --spp 1"));
    window.events.send(Event::Failed("no light reaches the camera".into())).unwrap();
    window.frame(vec![]);
    assert!(window.viewer.note.as_ref().is_some_and(|note| note.error));
    window.press(Modifiers::NONE, Key::Num2);
    assert_eq!(window.viewer.note, None, "a new job may succeed");
}

#[test]
fn a_reference_gives_a_curve_unless_its_size_differs() {
    let mut window = Window::new();
    let reference = |side| Arc::new(Image { width: side, height: 48, pixels: vec![[0.5; 3]; side as usize * 48] });
    window.events.send(Event::Reference(reference(32))).unwrap();
    window.frame(vec![]);
    assert!(window.viewer.note.as_ref().unwrap().text.contains("32x48"));
    window.events.send(Event::Reference(reference(64))).unwrap();
    let error = |seconds| ErrorPoint { seconds, rel_mse: 1.0 / seconds, rel_mse_blocks: 0.1 };
    for seconds in [1.0, 2.0, 4.0] {
        let picture = Box::new(window.viewer.slots[0].picture.clone());
        window.events.send(Event::Picture { slot: 0, picture, error: Some(error(seconds)) }).unwrap();
    }
    window.viewer.show_error = Some(ErrorMap::Reference);
    window.frame(vec![]);
    window.frame(vec![]);
    assert_eq!(window.viewer.slots[0].errors.len(), 3);
}
