//! The same seed gives the same image, bit for bit; another seed another one.

use emlt::methods::{Direct, Method, Outcome, Settings};

use super::renders::{render, scene, settings};

/// Every bit of the image and of its layers.
pub fn bits(outcome: &Outcome) -> Vec<u32> {
    let pixels = outcome.image.pixels.iter().flatten();
    let layers = outcome.channels.iter().flat_map(|c| &c.values);
    pixels.chain(layers).map(|v| v.to_bits()).collect()
}

fn check(options: &Settings, layers: &[&str]) {
    let scene = scene("tests/scenes/coloured_box.glb");
    let first = render(&scene, options);
    let names: Vec<&str> = first.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, layers);
    assert!(first.channels.iter().all(|c| c.values.iter().any(|v| *v > 0.0)), "an empty layer");
    assert_eq!(bits(&first), bits(&render(&scene, options)), "the same seed twice");
    let other = render(&scene, &Settings { seed: options.seed + 1, ..options.clone() });
    let same = first.image.pixels.iter().zip(&other.image.pixels).filter(|(a, b)| a == b).count();
    assert!(same < first.image.pixels.len() / 10, "{same} pixels are the same with another seed");
}

/// Not a multiple of the workgroup's size, and several half-sweeps.
fn small(method: Method) -> Settings {
    settings(method, [33, 25], 100)
}

/// With the layers of all maps.
fn check_maps(method: Method, kernels: &[&str]) {
    let acceptance = kernels.iter().map(|kernel| format!("Acceptance.{kernel}"));
    let layers: Vec<String> =
        ["Maps.Horizontal", "Maps.Vertical"].map(String::from).into_iter().chain(acceptance).collect();
    check(&Settings { maps: true, ..small(method) }, &layers.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn pt_repeats() {
    check(&small(Method::Pt), &["Variance.R", "Variance.G", "Variance.B"]);
}

#[test]
fn mlt_repeats() {
    check_maps(Method::Mlt, &["independence", "bidirectional", "lens", "multi-chain", "caustic"]);
}

#[test]
fn emlt_repeats() {
    check_maps(
        Method::Emlt,
        &[
            "independence",
            "guided-bidirectional",
            "lens",
            "multi-chain",
            "caustic",
            "guided-lens",
            "lens-subpath",
            "guided-light-subpath",
            "manifold",
        ],
    );
}

// Apart, and with the shaders that tests/images/options.rs has compiled anyway.
#[test]
fn direct_light_apart_repeats() {
    check(&Settings { direct: Direct::Pt, ..small(Method::Emlt) }, &[]);
}

#[test]
fn easy_light_apart_repeats() {
    check(&Settings { direct: Direct::Auto, ..small(Method::Emlt) }, &[]);
}

#[test]
fn two_stages_repeat() {
    check(&Settings { two_stage: Some(0.5), ..small(Method::Emlt) }, &[]);
}
