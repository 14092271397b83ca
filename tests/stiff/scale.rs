//! Item 3: the scene's units do not show.

use emlt::film::Image;
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::{Method, Outcome, Settings};
use emlt::scene::Scene;

use super::comparison::{Power, Truth, check};
use super::furnaces::EDGES;
use super::normals::room;
use super::renders::{render, replicates, settings};

const FILM: [u32; 2] = [16, 12];

/// Coloured walls and a mirror, `factor` times as large.
fn scaled(factor: f32) -> Scene {
    let mut scene = room(60.0);
    scene.positions.iter_mut().for_each(|p| *p *= factor);
    scene.cameras.iter_mut().for_each(|c| c.world_from_camera.translation *= factor);
    scene
}

fn of(scene: &Scene, method: Method) -> Outcome {
    let settings = Settings { max_depth: EDGES, candidates: 1 << 15, ..settings(method, FILM, 40) };
    render(scene, &settings)
}

/// By powers of two, the smaller of them 1.2e-4 and the larger 1.05e6, nothing is rounded otherwise: bit for bit.
#[test]
fn scenes_of_any_size_give_the_same_bits() {
    for method in [Pt, Mlt, Emlt] {
        let [small, plain, large] = [-13, 0, 20].map(|power| of(&scaled(2f32.powi(power)), method));
        for (name, other) in [("small", small), ("large", large)] {
            assert!(other.image == plain.image, "{name} by {}", method.name());
            let b = |outcome: &Outcome| outcome.statistics.b.map(|b| b.0.to_bits());
            assert_eq!(b(&other), b(&plain), "{name} by {}", method.name());
        }
    }
}

/// By 1e-4 and 1e6, positions are rounded otherwise in their last bit, and the search tree may order triangles otherwise, so
/// that other random numbers choose them: the same image but for noise.
#[test]
#[ignore = "takes a minute; ./run test --long"]
fn long_scenes_of_any_size_give_the_same_image() {
    let base = |method, samples| Settings { max_depth: EDGES, candidates: 1 << 16, ..settings(method, FILM, samples) };
    let Outcome { image, channels, .. } = render(&scaled(1.0), &base(Pt, 2048));
    let pixels = (0..image.pixels.len()).map(|i| [0, 1, 2].map(|c| channels[c].values[i])).collect();
    let truth = Truth { variance: Some(Image { pixels, ..image }), image, tile: 4 };
    for (factor, method) in [(1e-4, Pt), (1e6, Pt), (1e-4, Mlt), (1e6, Emlt)] {
        let images = replicates(&scaled(factor), &base(method, if method == Pt { 128 } else { 500 }), 12);
        let [film, tile] = if method == Pt { [0.08, 0.2] } else { [0.08, 0.3] };
        check(&format!("units of {factor:.0e} by {}", method.name()), &images, &truth, Power { film, tile });
    }
}
