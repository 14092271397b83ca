//! Crossovers leave the image alone: with much of them, with direct light apart (so that no exchange may make a path
//! shorter than three edges) and in two stages.

use emlt::ensemble::mix::Mix;
use emlt::methods::Method::Emlt;
use emlt::methods::{Direct, Settings};

use super::comparison::{Power, check};
use super::mitsuba::{COLOURED_BOX, FULL_DEPTH, reference, settings_for};
use super::renders::{replicates, scene};

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_coloured_box_by_crossovers() {
    let truth = reference("coloured_box");
    let mix = "independence=0.1,crossover=0.4,lens=1,guided-lens=1,multi-chain=1,caustic=1";
    let settings = Settings {
        direct: Direct::Pt,
        two_stage: Some(0.5),
        kernels: Some(Mix::parse(mix).unwrap()),
        ..settings_for(&truth, Emlt, FULL_DEPTH, 60)
    };
    let images = replicates(&scene(COLOURED_BOX), &settings, 10);
    check("coloured_box by crossovers", &images, &truth, Power { film: 0.05, tile: 0.4 });
}
