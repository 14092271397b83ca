//! A thin lens: coloured_box through one 0.4 wide, sharp at 2.6 (its back wall), against Mitsuba's.

use emlt::kernels::{Kernel, bidirectional, independence, lens};
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

/// What these are for: a mutation that draws points on the lens unevenly and leaves their density out, a lens sharp
/// elsewhere, and a pinhole.
#[test]
fn wrong_lenses_are_caught() {
    static UNEVEN: Kernel = Kernel { flags: &["segment", "twin_lens"], ..bidirectional::KERNEL };
    let truth = reference("coloured_box_lens");
    let mix = |kernel| Some(vec![(&independence::KERNEL, 0.05), (kernel, 0.5), (&lens::KERNEL, 0.5)]);
    for (what, lens, kernels, method) in [
        ("a right one", Some(LENS), mix(&bidirectional::KERNEL), Mlt),
        ("points drawn unevenly", Some(LENS), mix(&UNEVEN), Mlt),
        ("sharp at 2.3", Some(Lens { focus: 2.3, ..LENS }), None, Pt),
        ("a pinhole", None, None, Pt),
    ] {
        let spp = if method == Pt { 12 } else { 120 };
        let settings = Settings { lens, kernels, ..settings_for(&truth, method, FULL_DEPTH, spp) };
        let comparison = Comparison::new(&replicates(&scene(COLOURED_BOX), &settings, 16), &truth);
        println!("{}", comparison.report(what));
        assert_eq!(comparison.passes(), what == "a right one", "{what}");
    }
}
