//! A ball of radiance L and radius R over a Lambertian plane of albedo rho (tests/scenes/sphere_over_plane.glb).
//!
//! Where the whole ball is above the horizon, the irradiance at distance d from its centre is
//! E = pi L (R / d)^2 cos(theta), as if the ball were a point of intensity pi R^2 L (Lambert 1760), and the plane's
//! radiance rho E / pi. The ball is a mesh of 5120 facets whose area is 4 pi R^2: as a convex body of that area it has the
//! ball's mean silhouette (Cauchy). What facets still change is computed below, and is far below what the images resolve.

use emlt::ensemble::bootstrap::CANDIDATES;
use emlt::film::Image;
use emlt::methods::{Method, Settings};
use emlt::scene::Scene;
use glam::{DVec3, Vec3};

use super::comparison::{self, Power, Truth};
use super::renders::{replicates, scene, settings};

pub(super) const SCENE: &str = "tests/scenes/sphere_over_plane.glb";
const RADIANCE: [f64; 3] = [10.0, 8.0, 5.0];
const ALBEDO: [f64; 3] = [0.8, 0.5, 0.25];
const CENTRE: DVec3 = DVec3::Y;
const RADIUS: f64 = 0.2;
pub(super) const FILM: [u32; 2] = [32, 24];
/// Midpoints on a side of a pixel for its mean.
const GRID: u32 = 4;

/// Where the plane y = 0 is seen through a position of the film, in pixels.
fn seen(scene: &Scene, [px, py]: [f64; 2]) -> DVec3 {
    let camera = scene.camera(None).unwrap();
    let [width, height] = FILM.map(f64::from);
    let pixels_per_unit = 0.5 * height / (0.5 * f64::from(camera.vertical_fov)).tan();
    let film = [px - 0.5 * width, 0.5 * height - py].map(|p| (p / pixels_per_unit) as f32);
    let direction = camera.world_from_camera.transform_vector3(Vec3::new(film[0], film[1], -1.0)).as_dvec3();
    let origin = Vec3::from(camera.world_from_camera.translation).as_dvec3();
    origin - direction * (origin.y / direction.y)
}

/// Irradiance on the plane over radiance, of the ball.
fn ball(point: DVec3) -> f64 {
    let d = point.distance(CENTRE);
    std::f64::consts::PI * (RADIUS / d).powi(2) * (CENTRE.y / d)
}

/// The same of the mesh: Lambert's formula, half the sum over every visible facet's edges of the angle an edge spans,
/// times the cosine between the plane's normal and that of the edge's plane through the point.
fn facets(scene: &Scene, point: DVec3) -> f64 {
    let mut sum = 0.0;
    for (triangle, material) in scene.triangles.iter().zip(&scene.triangle_materials) {
        let v = triangle.map(|i| scene.positions[i as usize].as_dvec3() - point);
        let normal = (v[1] - v[0]).cross(v[2] - v[0]);
        if scene.materials[*material as usize].emits() && normal.dot(v[0]) < 0.0 {
            for i in 0..3 {
                let (a, b) = (v[(i + 1) % 3], v[i]);
                sum += 0.5 * a.angle_between(b) * a.cross(b).normalize().y;
            }
        }
    }
    sum
}

pub(super) fn truth(scene: &Scene) -> Image {
    let mut pixels = Vec::new();
    for (y, x) in (0..FILM[1]).flat_map(|y| (0..FILM[0]).map(move |x| (y, x))) {
        let step = |pixel: u32, i: u32| f64::from(pixel) + (f64::from(i) + 0.5) / f64::from(GRID);
        let points = (0..GRID * GRID).map(|i| seen(scene, [step(x, i % GRID), step(y, i / GRID)]));
        let mean = points.map(ball).sum::<f64>() / f64::from(GRID * GRID);
        pixels.push([0, 1, 2].map(|c| (ALBEDO[c] / std::f64::consts::PI * RADIANCE[c] * mean) as f32));
    }
    Image { width: FILM[0], height: FILM[1], pixels }
}

/// Facets change the irradiance by less than 1e-4 of it, a tenth of the film's resolution and less of a tile's.
#[test]
fn facets_shine_as_the_ball_does() {
    let scene = scene(SCENE);
    let mut worst: f64 = 0.0;
    for (x, y) in (0..9).flat_map(|y| (0..9).map(move |x| (x, y))) {
        let point = seen(&scene, [f64::from(FILM[0] * x) / 8.0, f64::from(FILM[1] * y) / 8.0]);
        worst = worst.max((facets(&scene, point) / ball(point) - 1.0).abs());
    }
    println!("facets and ball differ by {worst:.1e} at most");
    assert!(worst < 1e-4, "{worst}");
}

fn check(method: Method, samples_per_pixel: u32, count: u32, power: Power) {
    let scene = scene(SCENE);
    // The plane alone scatters, so there are no longer paths.
    // All candidates: with fewer, b's noise would hide what the test is to see.
    let settings = Settings { max_depth: 3, candidates: CANDIDATES, ..settings(method, FILM, samples_per_pixel) };
    let images = replicates(&scene, &settings, count);
    let truth = Truth { image: truth(&scene), variance: None, tile: 8 };
    comparison::check(&format!("sphere {}", method.name()), &images, &truth, power);
}

#[test]
fn sphere_by_pt() {
    check(Method::Pt, 128, 24, Power { film: 0.015, tile: 0.04 });
}

#[test]
fn sphere_by_mlt() {
    check(Method::Mlt, 600, 12, Power { film: 0.01, tile: 0.15 });
}

#[test]
fn sphere_by_emlt() {
    check(Method::Emlt, 600, 12, Power { film: 0.01, tile: 0.15 });
}
