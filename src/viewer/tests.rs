//! What the window asks of the renderer, and what it shows of what it hears.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use eframe::egui::{Key, Modifiers, PointerButton, Pos2, Vec2};
use glam::Vec3;

use super::messages::{Command, ErrorPoint, Event, Opened};
use super::overlay::Layer;
use super::tone::{Curve, Tone};
use super::window::{Window, opened};
use crate::film::Image;
use crate::methods::{Method, Stage};

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
    let tone = window.viewer().tone;
    assert_eq!((tone.exposure, tone.curve), (0.5, Curve::Srgb));
    assert!((tone.offset - 0.1).abs() < 1e-6);
    window.press(Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(window.viewer().tone.curve, Curve::Filmic);
    window.press(Modifiers::NONE, Key::N);
    assert!((window.viewer().tone.exposure - (1.0f32 / 0.75).log2()).abs() < 1e-6);
    window.press(Modifiers::NONE, Key::R);
    assert_eq!(window.viewer().tone, Tone::default());
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
        window.viewer().settings.max_depth = depth;
        let ctx = window.harness.ctx.clone();
        window.viewer().changed(&ctx);
        window.frame();
    }
    assert!(window.asked().is_empty());
    (0..4).for_each(|_| window.frame());
    let jobs = window.jobs();
    assert_eq!(jobs.len(), 1);
    assert_eq!(jobs[0].settings.max_depth, 7);
}

#[test]
fn another_method_beside_the_first_gets_a_picture_of_its_own() {
    let mut window = Window::new();
    window.asked();
    window.viewer().second = Some(Method::Pt);
    window.viewer().restart();
    let methods: Vec<Method> = window.jobs()[0].pictures().iter().map(|s| s.method).collect();
    assert_eq!(methods, [Method::Emlt, Method::Pt]);
    window.picture(1, [0.5; 3]);
    window.hear(Event::Progress { slot: 0, stage: Stage::Seeding, share: 0.5 });
    assert_eq!(window.viewer().slots.len(), 2);
    window.press(Modifiers::NONE, Key::Num3);
    assert_eq!(window.viewer().slots.len(), 1, "pt beside pt would be the same picture twice");
}

#[test]
fn the_right_button_turns_the_camera_and_the_render_begins_when_it_is_let_go() {
    let mut window = Window::new();
    window.asked();
    let at = Pos2::new(400.0, 400.0);
    window.button(at, PointerButton::Secondary, true);
    window.point(at + Vec2::new(40.0, 0.0));
    window.point(at + Vec2::new(80.0, 10.0));
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
    window.frame();
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
    window.point(at + Vec2::new(40.0, 20.0));
    window.button(at + Vec2::new(40.0, 20.0), PointerButton::Primary, false);
    assert_eq!(window.viewer().placement.offset, Vec2::new(40.0, 20.0));
    window.press(Modifiers::COMMAND, Key::Num0);
    assert_eq!(window.viewer().placement.zoom, Some(1.0));
    let middle = window.viewer().parts.0.center();
    window.point(middle);
    window.frame();
    assert_eq!(window.viewer().hovered.unwrap().pixel, [32, 24]);
    window.press(Modifiers::NONE, Key::F);
    assert_eq!(window.viewer().placement.zoom, None);
    assert!(window.asked().is_empty());
}

#[test]
fn files_are_taken_by_their_kind() {
    let mut window = Window::new();
    window.asked();
    window.drop_files(&["a.GLB", "b.gltf", "c.exr", "d.HDR", "e.txt"]);
    let asked = window.asked();
    assert!(
        matches!(&asked[..], [Command::Open(a), Command::Open(b), Command::Image(c), Command::Sky(d)]
            if a == Path::new("a.GLB") && b == Path::new("b.gltf") && c == Path::new("c.exr") && d == Path::new("d.HDR")),
        "{asked:?}"
    );
    assert!(window.viewer().note.as_ref().unwrap().error);
}

#[test]
fn the_command_line_is_copied_and_a_failure_is_shown() {
    let mut window = Window::new();
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::C);
    assert_eq!(
        window.copied.as_deref(),
        Some(
            "emlt render box.glb --method emlt --size 64x48 --spp 1 --ensemble 16384 --candidates 1048576 --direct mcmc --two-stage 0"
        )
    );
    window.hear(Event::Failed("no light reaches the camera".into()));
    window.frame();
    assert!(window.viewer().note.as_ref().is_some_and(|note| note.error));
    window.press(Modifiers::NONE, Key::Num2);
    assert_eq!(window.viewer().note, None, "a new job may succeed");
}

#[test]
fn a_reference_gives_a_curve_unless_its_size_differs() {
    let mut window = Window::new();
    let reference = |side| Arc::new(Image { width: side, height: 48, pixels: vec![[0.5; 3]; side as usize * 48] });
    window.hear(Event::Reference { path: "r.exr".into(), image: reference(32) });
    window.frame();
    assert!(window.viewer().note.as_ref().unwrap().text.contains("32x48"));
    window.hear(Event::Reference { path: "r.exr".into(), image: reference(64) });
    let error = |seconds| ErrorPoint { seconds, rel_mse: 1.0 / seconds, rel_mse_blocks: 0.1 };
    for seconds in [1.0, 2.0, 4.0] {
        let picture = Box::new(window.viewer().slots[0].picture.clone());
        window.hear(Event::Picture { slot: 0, picture, error: Some(error(seconds)) });
    }
    window.viewer().layer = Some(Layer::ReferenceError);
    window.frame();
    window.frame();
    assert_eq!(window.viewer().slots[0].errors.len(), 3);
}

#[test]
fn a_change_of_any_file_of_the_scene_reads_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, image, sky] = ["a.gltf", "a.png", "a.hdr"].map(|name| folder.path().join(name));
    for path in [&scene, &image, &sky] {
        fs::write(path, "one").unwrap();
    }
    let files = vec![scene.clone(), image.clone()];
    let mut window = Window::new();
    window.hear(Event::Opened(Box::new(Opened { path: scene.clone(), files, sky: Some(sky.clone()), ..opened() })));
    window.asked();
    let wait = |window: &mut Window| {
        (0..15).for_each(|_| window.frame());
        window.asked()
    };
    assert!(wait(&mut window).is_empty());
    fs::write(&image, "longer").unwrap();
    let asked = wait(&mut window);
    assert!(matches!(&asked[..], [Command::Open(path)] if *path == scene), "{asked:?}");
    fs::write(&sky, "longer").unwrap();
    let asked = wait(&mut window);
    assert!(matches!(&asked[..], [Command::Sky(path)] if *path == sky), "{asked:?}");
    assert!(wait(&mut window).is_empty());
}
