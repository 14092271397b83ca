//! The same seed gives the same image, bit for bit; another seed another one.

use emlt::methods::{Direct, Method, Outcome, Settings};

use super::renders::{render, scene, settings};

/// Every bit of the image and of its layers.
fn bits(outcome: &Outcome) -> Vec<u32> {
    let pixels = outcome.image.pixels.iter().flatten();
    let layers = outcome.channels.iter().flat_map(|c| &c.values);
    pixels.chain(layers).map(|v| v.to_bits()).collect()
}

fn check(method: Method, layers: &[&str]) {
    check_with(Settings { method, ..Settings::default() }, layers);
}

fn check_with(options: Settings, layers: &[&str]) {
    let Settings { method, direct, two_stage, .. } = options;
    let scene = scene("tests/scenes/coloured_box.glb");
    // Not a multiple of the workgroup's size, and several half-sweeps.
    let settings =
        Settings { maps: method != Method::Pt, max_depth: 6, direct, two_stage, ..settings(method, [33, 25], 100) };
    let first = render(&scene, &settings);
    let names: Vec<&str> = first.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, layers);
    assert!(first.channels.iter().all(|c| c.values.iter().any(|v| *v > 0.0)), "an empty layer");
    assert_eq!(bits(&first), bits(&render(&scene, &settings)), "the same seed twice");
    let other = render(&scene, &Settings { seed: settings.seed + 1, ..settings });
    let same = first.image.pixels.iter().zip(&other.image.pixels).filter(|(a, b)| a == b).count();
    assert!(same < first.image.pixels.len() / 10, "{same} pixels are the same with another seed");
}

#[test]
fn pt_repeats() {
    check(Method::Pt, &["Variance.R", "Variance.G", "Variance.B"]);
}

#[test]
fn mlt_repeats() {
    check(Method::Mlt, &["Maps.Horizontal", "Maps.Vertical"]);
}

#[test]
fn emlt_repeats() {
    check(Method::Emlt, &["Maps.Horizontal", "Maps.Vertical"]);
}

#[test]
fn options_repeat() {
    let options = Settings { direct: Direct::Pt, two_stage: Some(0.5), ..Settings::default() };
    check_with(options, &["Maps.Horizontal", "Maps.Vertical"]);
}
