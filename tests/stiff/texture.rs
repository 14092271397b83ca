//! Item 19: the roughness of a texture, from alpha 0.035 to 0.25, on both sides of the threshold below which lobes are taken
//! for specular: whatever that is, the image is the same.

use emlt::film::Image;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::{Outcome, Settings};

use super::comparison::{Power, Truth, check};
use super::furnaces::EDGES;
use super::renders::{render, replicates, settings};
use super::room::room;

const FILM: [u32; 2] = [24, 18];

fn check_thresholds(cases: &[(Method, f32)]) {
    let scene = room();
    let Outcome { image, channels, .. } = render(&scene, &Settings { max_depth: EDGES, ..settings(Pt, FILM, 1024) });
    let pixels = (0..image.pixels.len()).map(|i| [0, 1, 2].map(|c| channels[c].values[i])).collect();
    let truth = Truth { variance: Some(Image { pixels, ..image }), image, tile: 6 };
    // The mean alpha, by which the whole material is classed, is 0.09.
    for &(method, threshold) in cases {
        let base = Settings { max_depth: EDGES, candidates: 1 << 17, ..settings(method, FILM, 160) };
        let images = replicates(&scene, &Settings { glossy_as_specular_alpha: threshold, ..base }, 12);
        let name = format!("textured roughness by {}, threshold {threshold}", method.name());
        check(&name, &images, &truth, Power { film: 0.1, tile: 0.5 });
    }
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_textured_roughness_across_the_threshold() {
    check_thresholds(&[(Mlt, 0.1), (Emlt, 0.1), (Mlt, 0.0), (Emlt, 0.0)]);
}
