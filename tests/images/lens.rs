//! A thin lens: coloured_box through one 0.4 wide, sharp at 2.6 (its back wall), against Mitsuba's.

use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::scene::Lens;

use super::comparison::{Comparison, Power, check};
use super::mitsuba::{COLOURED_BOX, FULL_DEPTH, reference, settings_for};
use super::renders::{replicates, scene};

const LENS: Lens = Lens { aperture: 0.4, focus: 2.6 };

fn compare(method: Method, [spp, count]: [u32; 2], power: Power) {
    let truth = reference("coloured_box_lens");
    let settings = Settings { lens: Some(LENS), ..settings_for(&truth, method, FULL_DEPTH, spp) };
    let images = replicates(&scene(COLOURED_BOX), &settings, count);
    check(&format!("coloured_box through a lens {}", method.name()), &images, &truth, power);
}

#[test]
fn lens_by_pt() {
    compare(Pt, [24, 24], Power { film: 0.01, tile: 0.04 });
}

#[test]
fn lens_by_mlt() {
    compare(Mlt, [240, 16], Power { film: 0.03, tile: 0.2 });
}

#[test]
fn lens_by_emlt() {
    compare(Emlt, [240, 16], Power { film: 0.03, tile: 0.2 });
}

/// What these are for: lenses that are sharp elsewhere or of another width, and a pinhole. (A mutation that draws points on
/// the lens unevenly changes this image too little to be seen: tests/kernel_proofs.rs catches it.)
#[test]
fn wrong_lenses_are_caught() {
    let truth = reference("coloured_box_lens");
    // Samples a pixel: what shows at a glance needs few.
    for (what, lens, spp) in [
        ("sharp at 2", Some(Lens { focus: 2.0, ..LENS }), 16),
        ("0.5 wide", Some(Lens { aperture: 0.5, ..LENS }), 24),
        ("a pinhole", None, 4),
    ] {
        let settings = Settings { lens, ..settings_for(&truth, Pt, FULL_DEPTH, spp) };
        let comparison = Comparison::new(&replicates(&scene(COLOURED_BOX), &settings, 24), &truth);
        println!("{}", comparison.report(what));
        assert!(!comparison.passes(), "not caught: {what}");
    }
}
