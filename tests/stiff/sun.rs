//! Item 15: a sun that is 1e5 times as bright as its sky, in an environment map. A Lambertian plane that sees nothing else
//! has the radiance rho / pi INT L cos dw, by quadrature of the interpolated map.

use std::f64::consts::PI;

use emlt::film::Image;
use emlt::methods::Method::{Emlt, Mlt, Pt};
use emlt::methods::Settings;
use emlt::scene::Scene;
use emlt::scene::light::Environment;
use glam::{DVec3, Vec3, vec3};

use super::comparison::{Power, Truth, check};
use super::furnaces::{ALBEDO, EDGES};
use super::renders::{replicates, settings};
use super::shapes::{camera_down, matt, quad};

const WIDTH: u32 = 32;
const HEIGHT: u32 = 16;

/// A coloured sky, brighter towards the horizon, with the sun in `row`.
fn sky(row: u32) -> Environment {
    let pixel = |i: u32| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let sun = if (x, y) == (11, row) { 1e5 } else { 1.0 };
        [0.3 + 0.05 * y as f32, 0.5 + 0.02 * x as f32, 1.2].map(|v| sun * v)
    };
    Environment { width: WIDTH, height: HEIGHT, pixels: (0..WIDTH * HEIGHT).map(pixel).collect() }
}

/// Irradiance of the upper half of the sky, from midpoints in every pixel of the map, between whose centres it is linear.
fn irradiance(sky: &Environment) -> DVec3 {
    const FINE: u32 = 32;
    let at = |x: i64, y: i64| {
        let x = x.rem_euclid(WIDTH.into()) as u32;
        let y = y.clamp(0, i64::from(HEIGHT) - 1) as u32;
        Vec3::from(sky.pixels[(y * WIDTH + x) as usize]).as_dvec3()
    };
    let mut sum = DVec3::ZERO;
    for j in 0..FINE * HEIGHT / 2 {
        let v = (f64::from(j) + 0.5) / f64::from(FINE);
        let theta = PI * v / f64::from(HEIGHT);
        let row = (v - 0.5).floor();
        for i in 0..FINE * WIDTH {
            let u = (f64::from(i) + 0.5) / f64::from(FINE) - 0.5;
            let (x, y) = (u.floor() as i64, row as i64);
            let (s, t) = (u - u.floor(), v - 0.5 - row);
            let above = at(x, y).lerp(at(x + 1, y), s);
            let below = at(x, y + 1).lerp(at(x + 1, y + 1), s);
            sum += above.lerp(below, t) * (theta.sin() * theta.cos());
        }
    }
    sum * (PI / f64::from(FINE * HEIGHT)) * (2.0 * PI / f64::from(FINE * WIDTH))
}

fn check_sun(name: &str, row: u32, power: Power, metropolis: Power) {
    let sky = sky(row);
    let radiance = (ALBEDO.as_dvec3() * irradiance(&sky) / PI).as_vec3();
    let mut scene = Scene {
        name: name.into(),
        materials: vec![matt(ALBEDO, Vec3::ZERO)],
        cameras: vec![camera_down(vec3(0.1, 0.6, 0.2), 60.0)],
        environment: Some(sky),
        ..Scene::default()
    };
    quad(&mut scene, vec3(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X, 0);
    let [width, height] = [16, 12];
    let pixels = vec![radiance.to_array(); (width * height) as usize];
    let truth = Truth { image: Image { width, height, pixels }, variance: None, tile: 4 };
    for (method, samples) in [(Pt, 256), (Mlt, 500), (Emlt, 500)] {
        let settings = Settings { max_depth: EDGES, candidates: 1 << 16, ..settings(method, [width, height], samples) };
        let images = replicates(&scene, &settings, 12);
        let power = if method == Pt { &power } else { &metropolis };
        check(&format!("{name} by {}", method.name()), &images, &truth, Power { ..*power });
    }
}

#[test]
fn sun() {
    check_sun("sun", 3, Power { film: 0.02, tile: 0.07 }, Power { film: 0.04, tile: 0.2 });
}

/// Below the horizon it takes almost all samples of the map, and lights nothing.
#[test]
fn sun_below_the_horizon() {
    check_sun("sun below the horizon", 12, Power { film: 0.02, tile: 0.05 }, Power { film: 0.05, tile: 0.2 });
}
