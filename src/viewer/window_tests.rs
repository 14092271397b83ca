//! The window as a person uses it, by the names of what can be clicked, and as it is painted.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, Pos2, Rect, Vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{SnapshotError, SnapshotOptions};

use super::messages::{Command, ErrorPoint, Event, OwnError, Picture};
use super::overlay::Layer;
use super::tone::Curve;
use super::window::{SIZE, Window};
use crate::film::Image;
use crate::gpu::context;
use crate::methods::{Direct, Method, Stage};
use crate::report::statistics::{KernelStatistics, Statistics};

/// A value for every pixel, from its place in [0, 1).
fn pixels<T>(value: impl Fn(f32, f32) -> T) -> Vec<T> {
    let [width, height] = SIZE;
    let place = |i: u32| ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
    (0..width * height).map(place).map(|(x, y)| value(x, y)).collect()
}

fn image(value: impl Fn(f32, f32) -> [f32; 3]) -> Image {
    let [width, height] = SIZE;
    Image { width, height, pixels: pixels(value) }
}

/// A picture that has everything a picture can have: a disc on a gradient.
fn full_picture() -> Picture {
    let disc = |x: f32, y: f32| (x - 0.5).hypot(0.75 * (y - 0.5)) < 0.25;
    let kernel = |name: &str, mutations, accepted, mean_squared_jump_px2| KernelStatistics {
        name: name.into(),
        mutations,
        accepted,
        non_finite: 0,
        mean_squared_jump_px2,
        device_s: Some(0.5),
    };
    let maps = [pixels(|x, _| x), pixels(|_, y| y)];
    let accepted = |x: f32, y: f32| if disc(x, y) { x } else { f32::NAN };
    let acceptance = vec![("lens".to_string(), pixels(|_, y| y)), ("guided-lens".to_string(), pixels(accepted))];
    let own =
        OwnError { seconds: 4.0, relative: 0.25, pixels: image(|x, y| if disc(x, y) { [x; 3] } else { [0.0; 3] }) };
    Picture {
        image: Some(Arc::new(image(|x, y| if disc(x, y) { [0.8, 0.4, 0.1] } else { [0.5 * x, 0.5 * y, 0.3] }))),
        maps: Some(Arc::new(maps)),
        statistics: Statistics {
            device: "a device".into(),
            samples: 123_456,
            rays: 234_567,
            kernels: vec![
                kernel("independence", 10_000, 346, 19_287.1),
                kernel("lens", 90_000, 73_000, 130.9),
                kernel("guided-lens", 91_000, 70_000, 220.3),
            ],
            b: Some((0.3517, 0.0006)),
            seeding_s: 1.0,
            render_s: 4.0,
            ..Statistics::default()
        },
        acceptance: Some(Arc::new(acceptance)),
        own: Some(Arc::new(own)),
        preview: false,
    }
}

fn show(window: &mut Window, slot: usize, seconds: f64) {
    let mut picture = full_picture();
    picture.own =
        picture.own.map(|own| Arc::new(OwnError { seconds, relative: 0.5 / seconds.sqrt(), ..(*own).clone() }));
    let error = window.viewer().reference.is_some().then_some(ErrorPoint {
        seconds,
        rel_mse: 0.3 / seconds,
        rel_mse_blocks: 0.03 / seconds,
    });
    window.hear(Event::Picture { slot, picture: Box::new(picture), error });
}

/// Clicks on what is called so.
fn click(window: &mut Window, name: &str) {
    window.harness.get_by_label(name).click();
    window.frame();
    window.frame();
}

/// Opens the list called `name` and takes an entry of it.
fn choose(window: &mut Window, name: &str, entry: &str) {
    click(window, name);
    // The list lies over everything else, and comes last.
    let entries: Vec<_> = window.harness.get_all_by_label(entry).collect();
    entries.last().unwrap().click();
    window.frame();
    window.frame();
}

#[test]
fn everything_that_takes_input_has_a_name() {
    let mut window = Window::new();
    show(&mut window, 0, 1.0);
    window.harness.check_accessibility();
    window.viewer().settings.two_stage = Some(0.5);
    window.viewer().settings.guidance.alpha = [0.1; 2];
    window.viewer().layer = Some(Layer::OwnError);
    click(&mut window, "Kernel mix");
    window.harness.check_accessibility();
}

#[test]
fn the_buttons_do_what_they_say() {
    let mut window = Window::new();
    window.asked();
    click(&mut window, "Pause");
    assert!(matches!(window.asked()[..], [Command::Pause(true)]));
    click(&mut window, "Resume");
    assert!(matches!(window.asked()[..], [Command::Pause(false)]));
    click(&mut window, "Restart");
    assert_eq!(window.jobs().len(), 1);
    click(&mut window, "mlt");
    assert_eq!(window.jobs()[0].settings.method, Method::Mlt);
    click(&mut window, "Save");
    assert!(matches!(&window.asked()[..], [Command::Save(path)] if path == Path::new("box.exr")));
    click(&mut window, "1:1");
    assert_eq!(window.viewer().placement.zoom, Some(1.0));
    click(&mut window, "Fit");
    assert_eq!(window.viewer().placement.zoom, None);
    click(&mut window, "filmic");
    assert_eq!(window.viewer().tone.curve, Curve::Filmic);
    click(&mut window, "Reset");
    assert_eq!(window.viewer().tone.curve, Curve::Srgb);
    click(&mut window, "Keys");
    window.harness.get_by_label("fit the image into the window");
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.harness.query_by_label("fit the image into the window").is_none());
    click(&mut window, "Panels");
    assert!(window.harness.query_by_label("Statistics").is_none());
}

#[test]
fn the_panel_changes_what_is_rendered() {
    let mut window = Window::new();
    window.asked();
    choose(&mut window, "second method", "pt");
    choose(&mut window, "ensemble", "4096");
    click(&mut window, "path traced");
    (0..4).for_each(|_| window.frame());
    let jobs = window.jobs();
    let job = jobs.last().unwrap();
    assert_eq!((job.second, job.settings.ensemble), (Some(Method::Pt), 4096));
    assert_eq!(job.settings.direct, Direct::Pt);
    choose(&mut window, "of the file", "Near");
    assert_eq!(window.jobs().last().unwrap().camera.name, "Near");
    // What would be no mix is not rendered, but told.
    click(&mut window, "Kernel mix");
    let slider = window.harness.get_by_role_and_label(Role::Slider, "independence");
    slider.set_value_accesskit(0.0);
    (0..5).for_each(|_| window.frame());
    assert!(window.jobs().is_empty());
    window.harness.get_by_label_contains("the mix lacks the independence kernel");
}

#[test]
fn overlays_are_chosen_by_key_button_and_list() {
    let mut window = Window::new();
    show(&mut window, 0, 1.0);
    window.press(Modifiers::NONE, Key::M);
    assert_eq!(window.viewer().layer, Some(Layer::Directions));
    // The kernel that makes most mutations comes first.
    click(&mut window, "Acceptance");
    assert_eq!(window.viewer().layer, Some(Layer::Acceptance("guided-lens")));
    for layer in [None, Some("independence"), Some("lens"), Some("guided-lens")] {
        window.press(Modifiers::NONE, Key::A);
        assert_eq!(window.viewer().layer, layer.map(Layer::Acceptance));
    }
    window.press(Modifiers::SHIFT, Key::A);
    assert_eq!(window.viewer().layer, Some(Layer::Acceptance("lens")));
    choose(&mut window, "overlay", "its own error");
    assert_eq!(window.viewer().layer, Some(Layer::OwnError));
    let middle = window.viewer().parts.0.center();
    window.point(middle);
    window.frame();
    // The disc's middle: 0.8 + 0.4 + 0.1 and 0.03, beside three times its place.
    let text = window.harness.get_by_label_contains("(32, 24)").value().unwrap();
    assert!(text.contains("0.8000 0.4000 0.1000  112.8 %"), "{text}");
    click(&mut window, "Own error");
    assert_eq!(window.viewer().layer, None);
}

#[test]
fn a_failure_is_shown_in_words_and_can_be_hidden() {
    let mut window = Window::new();
    let sentence = "box.glb is not JSON: export it as glTF 2.0 again";
    window.hear(Event::Failed(sentence.into()));
    window.frame();
    window.harness.get_by_label(sentence);
    click(&mut window, "Hide");
    assert!(window.harness.query_by_label(sentence).is_none());
}

/// Compares what is painted with a picture in the repository. `UPDATE_SNAPSHOTS=1` makes those that differ anew; look at
/// them before they are committed. What differs goes to `target/snapshots`.
fn compare(window: &mut Window, name: &str) {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots");
    // Colours of single pixels may differ as drivers round, shapes may not. The harness paints on a software device where
    // there is one, as it painted the pictures; a GPU draws the edges of lines otherwise.
    let software = context::list().iter().any(|device| device.software);
    let pixels = if software { 4 } else { 400 };
    let options = SnapshotOptions::new().output_path(&kept).threshold(1.0).max_failed_pixels(pixels);
    let result = window.harness.try_snapshot_options(name, &options);
    let failed = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/snapshots");
    fs::create_dir_all(&failed).unwrap();
    for kind in ["new", "diff", "old"] {
        let file = format!("{name}.{kind}.png");
        let _ = fs::rename(kept.join(&file), failed.join(&file));
    }
    if let Err(error) = result {
        let how = match error {
            SnapshotError::Diff { diff, failing_pixels_by_threshold, .. } => {
                format!("{diff} pixels differ, by tolerance {failing_pixels_by_threshold:?}")
            }
            error => error.to_string(),
        };
        panic!("{name}: {how}: look at target/snapshots, and set UPDATE_SNAPSHOTS=1 if it is as it should be");
    }
}

#[test]
fn the_panel_keeps_its_width() {
    let mut window = Window::new();
    window.hear(Event::Reference { path: "reference.exr".into(), image: Arc::new(image(|x, _| [x; 3])) });
    for seconds in [1.0, 2.0] {
        show(&mut window, 0, seconds);
    }
    window.frame();
    let before = window.viewer().parts.0.width();
    (0..40).for_each(|_| window.frame());
    assert_eq!(window.viewer().parts.0.width(), before);
}

#[test]
fn the_window_is_painted_as_it_was() {
    let mut window = Window::painting(Vec2::new(720.0, 400.0));
    show(&mut window, 0, 1.0);
    window.frame();
    compare(&mut window, "window");
}

#[test]
fn two_methods_with_their_overlays_are_painted_as_they_were() {
    let mut window = Window::painting(Vec2::new(640.0, 260.0));
    window.viewer().second = Some(Method::Mlt);
    window.viewer().restart();
    window.viewer().panels = false;
    show(&mut window, 0, 1.0);
    window.viewer().layer = Some(Layer::Acceptance("guided-lens"));
    // The second has begun, and says so.
    window.hear(Event::Progress { slot: 1, stage: Stage::Seeding, share: 0.4 });
    window.point(Pos2::new(160.0, 140.0));
    window.frame();
    compare(&mut window, "two_methods");
}

#[test]
fn figures_and_curves_are_painted_as_they_were() {
    let mut window = Window::painting(Vec2::new(720.0, 720.0));
    window.hear(Event::Reference { path: "reference.exr".into(), image: Arc::new(image(|x, _| [x; 3])) });
    for seconds in [1.0, 2.0, 4.0, 8.0] {
        show(&mut window, 0, seconds);
    }
    for section in ["Display", "Rendering", "Camera", "Scene"] {
        click(&mut window, section);
    }
    window.harness.remove_cursor();
    window.frame();
    // The memory that the test takes is none of the picture's business.
    let row = window.harness.get_by_label("memory").rect();
    window.harness.mask(Rect::from_min_max(row.min, Pos2::new(720.0, row.max.y)));
    compare(&mut window, "figures");
}
