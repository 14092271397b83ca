//! Closed furnaces of extreme shapes: where every surface has the emission e and the albedo rho, a path of k edges that
//! ends on one carries e rho^(k - 1), and every pixel is e (1 - rho^K) / (1 - rho) with at most K edges, whatever the
//! shape, camera and film.

use emlt::film::Image;
use emlt::methods::Method::{self, Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::scene::Scene;
use glam::{Vec3, vec3};

use super::comparison::{Power, Truth, check};
use super::renders::{render, replicates, settings};
use super::shapes::{ball, camera, cuboid, facet, matt, quad};

pub const EMISSION: Vec3 = vec3(0.5, 1.0, 0.25);
pub const ALBEDO: Vec3 = vec3(0.6, 0.5, 0.3);
/// Longest paths, in edges: the same for all scenes of flat colours here, so that their shaders are.
pub const EDGES: u32 = 5;
const FILM: [u32; 2] = [16, 12];

/// What every pixel is.
fn radiance() -> [f32; 3] {
    [0, 1, 2].map(|c| {
        let [e, rho] = [EMISSION[c], ALBEDO[c]].map(f64::from);
        (e * (1.0 - rho.powi(EDGES as i32)) / (1.0 - rho)) as f32
    })
}

/// A scene of `surfaces` of one material, by a camera at `eye` that looks at `target`.
fn furnace(name: &str, eye: Vec3, target: Vec3, degrees: f32, surfaces: impl Fn(&mut Scene)) -> Scene {
    let mut scene = Scene {
        name: name.into(),
        materials: vec![matt(ALBEDO, EMISSION)],
        cameras: vec![camera(eye, target, degrees)],
        ..Scene::default()
    };
    surfaces(&mut scene);
    scene
}

/// The plain one.
pub fn box_furnace() -> Scene {
    furnace("box", vec3(0.3, 1.1, 1.0), vec3(-0.2, 0.8, -1.0), 50.0, room)
}

fn room(scene: &mut Scene) {
    cuboid(scene, vec3(-1.0, 0.0, -1.5), vec3(1.0, 2.0, 1.5), true, 0);
}

/// A furnace rendered by every method, with what changes of the settings; fewer samples of more pixels.
fn check_shape(scene: &Scene, [width, height]: [u32; 2], change: impl Fn(Settings) -> Settings, power: Power) {
    let pixels = vec![radiance(); (width * height) as usize];
    let truth = Truth { image: Image { width, height, pixels }, variance: None, tile: 4 };
    let samples = |all: u32| all / (width * height);
    for (method, spp) in [(Pt, samples(10_000)), (Mlt, samples(80_000)), (Emlt, samples(80_000))] {
        let base = Settings { max_depth: EDGES, candidates: 1 << 15, ..settings(method, [width, height], spp) };
        let images = replicates(scene, &change(base), 12);
        let power = if method == Pt { Power { film: 0.01, tile: 0.02 } } else { Power { ..power } };
        check(&format!("{} by {}", scene.name, method.name()), &images, &truth, power);
    }
}

const POWER: Power = Power { film: 0.05, tile: 0.2 };

/// Shares of accepted mutations: of the independence kernel, whose weights must be bounded, and of the lens perturbation.
fn acceptance(scene: &Scene, method: Method) -> [f64; 2] {
    let settings = Settings { max_depth: EDGES, candidates: 1 << 16, ..settings(method, FILM, 1000) };
    let kernels = render(scene, &settings).statistics.kernels;
    let of = |name: &str| {
        let kernel = kernels.iter().find(|k| k.name == name).unwrap();
        kernel.accepted as f64 / kernel.mutations as f64
    };
    [of("independence"), of("lens")]
}

/// Item 5: two planes that meet at one degree, seen from between them.
#[test]
fn crevice() {
    let (slope, half) = (1f32.to_radians().tan(), 0.5 * Vec3::Z);
    let scene = furnace("crevice", vec3(0.6, 0.3 * slope, 0.0), vec3(0.0, 0.3 * slope, 0.0), 60.0, |scene| {
        let [tip, floor, roof] = [Vec3::ZERO, Vec3::X, vec3(1.0, slope, 0.0)];
        quad(scene, tip - half, 2.0 * half, Vec3::X, 0);
        quad(scene, tip - half, roof, 2.0 * half, 0);
        quad(scene, floor - half, 2.0 * half, roof - floor, 0);
        facet(scene, [tip - half, floor - half, roof - half], 0);
        facet(scene, [tip + half, roof + half, floor + half], 0);
    });
    for method in [Mlt, Emlt] {
        let accepted = acceptance(&scene, method);
        println!("crevice by {}: accepted {accepted:.3?}", method.name());
        // Chains that stuck at 1 / r^2 would accept nothing for long.
        assert!(accepted.iter().all(|share| *share > 0.5), "{accepted:?}");
    }
    check_shape(&scene, FILM, |s| s, POWER);
}

/// Item 6: plates at a distance of 1.4e-5 of the scene's radius, seen from between them.
#[test]
fn gap() {
    let scene = furnace("gap", Vec3::ZERO, -Vec3::Z, 60.0, |scene| {
        cuboid(scene, vec3(-1.0, -1e-5, -1.0), vec3(1.0, 1e-5, 1.0), true, 0);
    });
    check_shape(&scene, FILM, |s| s, POWER);
    // What is lost to the floors of cosines and distances, and to rounding between neighbours, is below 1e-4: here the
    // standard error of a long path tracing is 1e-5.
    let long = render(&scene, &Settings { max_depth: EDGES, ..settings(Pt, FILM, 2048) }).image;
    for (c, truth) in radiance().map(f64::from).into_iter().enumerate() {
        let mean = long.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / long.pixels.len() as f64;
        println!("gap, channel {c}: {:+.1e} of the light", mean / truth - 1.0);
        assert!((mean / truth - 1.0).abs() < 1e-4, "channel {c}: {mean} of {truth}");
    }
}

/// Item 6: a box in the room, with walls of 1e-5 around a light a hundred times as bright: nothing leaks.
#[test]
fn shell() {
    let mut scene = furnace("shell", vec3(0.3, 1.1, 1.0), vec3(-0.1, 0.8, 0.0), 50.0, |scene| {
        room(scene);
        cuboid(scene, vec3(-0.4, 0.5, -0.3), vec3(0.1, 1.0, 0.2), false, 0);
    });
    let wall = Vec3::splat(1e-5);
    scene.materials.push(matt(ALBEDO, 100.0 * EMISSION));
    cuboid(&mut scene, vec3(-0.4, 0.5, -0.3) + wall, vec3(0.1, 1.0, 0.2) - wall, true, 1);
    check_shape(&scene, FILM, |s| s, POWER);
}

/// Item 10: two paths in a half of every group, most of whose types have no guides.
#[test]
fn hardly_any_guides() {
    let scene = Scene { name: "two paths a group".into(), ..box_furnace() };
    check_shape(&scene, FILM, |s| Settings { ensemble: 32, ..s }, POWER);
}

/// Item 17: films of a few pixels, off which most steps lead.
#[test]
fn small_films() {
    for [width, height] in [[1, 1], [16, 1]] {
        let scene = Scene { name: format!("film of {width}x{height}"), ..box_furnace() };
        check_shape(&scene, [width, height], |s| s, POWER);
    }
}

/// Item 18: a camera of 170 degrees, whose pixels see solid angles that differ by a factor of 1e3.
#[test]
fn wide_camera() {
    let scene = furnace("170 degrees", vec3(0.3, 1.1, 1.0), vec3(-0.2, 0.8, -1.0), 170.0, room);
    check_shape(&scene, FILM, |s| s, POWER);
}

/// Item 20: a ball of 1e-3 of 4096 facets fills the film, so that all guides are alike by position.
#[test]
fn tiny_triangles() {
    let centre = vec3(0.2, 0.9, 0.3);
    let scene = furnace("tiny triangles", centre + vec3(0.0, 1e-3, 2e-3), centre, 60.0, |scene| {
        room(scene);
        ball(scene, centre, 1e-3, 32, 0);
    });
    check_shape(&scene, FILM, |s| s, POWER);
}
