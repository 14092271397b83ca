//! The layers of acceptance by kernel and pixel.

use emlt::methods::{ACCEPTANCE, Method, Settings};

use super::renders::{render, scene, settings};

/// On a film of one pixel a layer holds what the kernel's counters say of the whole run. Bidirectional and subpath mutations
/// also count what cannot be proposed at all, which has no place on the film.
#[test]
fn the_only_pixel_accepts_what_the_kernel_does() {
    let scene = scene("tests/scenes/coloured_box.glb");
    for method in [Method::Mlt, Method::Emlt] {
        let outcome = render(&scene, &Settings { maps: true, ..settings(method, [1, 1], 20_000) });
        let kernels = &outcome.statistics.kernels;
        let mut seen = 0;
        for kernel in kernels.iter().filter(|kernel| !kernel.name.starts_with('(')) {
            let name = format!("{ACCEPTANCE}{}", kernel.name);
            let layer = outcome.channels.iter().find(|channel| channel.name == name);
            let [share] = layer.expect(&name).values[..] else { panic!("{name} has more than one pixel") };
            let counted = kernel.accepted as f32 / kernel.mutations as f32;
            if ["bidirectional", "subpath"].iter().any(|drawn| kernel.name.ends_with(drawn)) {
                assert!(share >= counted && share < 1.0, "{name}: {share} and {counted}");
            } else {
                assert_eq!(share, counted, "{name}");
            }
            seen += 1;
        }
        assert!(seen >= 3, "{kernels:?}");
    }
}
