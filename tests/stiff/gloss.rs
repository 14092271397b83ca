//! Item 1: lobes about as narrow as a delta.

use emlt::film::Image;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::{Outcome, Settings};
use emlt::scene::material::DELTA_ALPHA;
use emlt::scene::{Material, Scene};
use glam::{Vec3, vec3};

use super::comparison::{Power, Truth, check};
use super::furnaces::EDGES;
use super::renders::{render, replicates, settings};
use super::shapes::{camera, matt, quad};

const FILM: [u32; 2] = [24, 18];

/// A copper floor of GGX alpha `alpha` between glowing walls, which reflects these and a lamp of such a side and
/// radiance; the walls reflect a share too.
fn floor(alpha: f32, [side, radiance]: [f32; 2], share: f32) -> Scene {
    let copper = Material { base_color: vec3(0.9, 0.6, 0.4), roughness: alpha.sqrt(), ..Material::default() };
    let wall = |albedo: Vec3, glow| matt(share * albedo, glow);
    let mut scene = Scene {
        name: format!("floor of alpha {alpha}"),
        materials: vec![
            copper,
            wall(vec3(0.3, 0.5, 0.7), vec3(0.1, 0.2, 0.3)),
            matt(Vec3::ZERO, radiance * vec3(1.0, 0.8, 0.5)),
            wall(vec3(0.7, 0.4, 0.3), vec3(0.2, 0.1, 0.1)),
        ],
        cameras: vec![camera(vec3(0.1, 0.9, 1.3), vec3(0.0, 0.3, -0.5), 55.0)],
        ..Scene::default()
    };
    let (x, y, z) = (2.0 * Vec3::X, 1.5 * Vec3::Y, 3.0 * Vec3::Z);
    let corner = vec3(-1.0, 0.0, -1.5);
    quad(&mut scene, corner, z, x, 0);
    quad(&mut scene, corner, x, y, 1);
    quad(&mut scene, corner, y, z, 3);
    quad(&mut scene, corner + x, z, y, 1);
    // Facing down and a little to the camera.
    quad(&mut scene, vec3(-0.5 * side, 1.1, -0.6), side * Vec3::X, side * vec3(0.0, 0.2, 1.0), 2);
    scene
}

/// A long path tracing.
fn traced(scene: &Scene) -> Truth {
    let Outcome { image, channels, .. } = render(scene, &Settings { max_depth: EDGES, ..settings(Pt, FILM, 768) });
    let pixels = (0..image.pixels.len()).map(|i| [0, 1, 2].map(|c| channels[c].values[i])).collect();
    Truth { variance: Some(Image { pixels, ..image }), image, tile: 6 }
}

fn check_floor(scene: &Scene, method: Method, truth: &Truth, power: Power) {
    let samples = if method == Pt { 96 } else { 160 };
    let settings = Settings { max_depth: EDGES, candidates: 1 << 17, ..settings(method, FILM, samples) };
    let name = format!("{} by {}", scene.name, method.name());
    check(&name, &replicates(scene, &settings, 12), truth, power);
}

/// Just above the switch a lobe turns what it reflects by 0.1 degrees, which means of 6x6 pixels do not show: the image is
/// that of the delta just below it, and of one that is none at all. The lamp is 5 cm, seen in the floor.
#[test]
fn near_deltas_are_as_deltas() {
    let of = |alpha| floor(alpha, [0.05, 40.0], 0.1);
    let truth = traced(&of(0.0));
    for (method, film, tile) in [(Pt, 0.1, 0.05), (Mlt, 0.1, 0.3), (Emlt, 0.1, 0.3)] {
        for alpha in [0.99 * DELTA_ALPHA, 1.01 * DELTA_ALPHA] {
            check_floor(&of(alpha), method, &truth, Power { film, tile });
        }
    }
}

/// Ten times as wide, in a room that reflects its light, against path tracing, which knows no class of narrow lobes.
#[test]
#[ignore = "takes a minute; ./run test --long"]
fn long_narrow_lobes() {
    let scene = floor(0.01, [0.4, 6.0], 1.0);
    let truth = traced(&scene);
    for method in [Mlt, Emlt] {
        check_floor(&scene, method, &truth, Power { film: 0.1, tile: 0.5 });
    }
}
