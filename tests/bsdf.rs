//! Scattering on the device: samples against their density, values against Walter's formulas in f64, reciprocity, energy.
//! Seeds are fixed; each statistical statement is false by chance with probability below 1e-5, all together below 1e-3.

#[path = "bsdf/device.rs"]
mod device;
#[path = "bsdf/layers.rs"]
mod layers;
#[path = "bsdf/walter.rs"]
mod walter;

use device::{Device, TAG_DIFFUSE, TAG_NONE, TAG_REFLECT, TAG_TRANSMIT};
use emlt::gpu::context::Context;
use emlt::reference::rng;
use emlt::scene::Material;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn context() -> Context {
    Context::open(None).unwrap_or_else(|e| panic!("{e}"))
}

/// Solid glass of index 1.5.
fn glass(alpha: f32) -> Material {
    Material {
        name: format!("glass of alpha {alpha}"),
        metallic: 0.0,
        roughness: alpha.sqrt(),
        transmission: 1.0,
        thin: false,
        ..Material::default()
    }
}

/// Every kind of rough material, wide enough for the grid of [`chi_square`].
fn materials() -> Vec<Material> {
    let rose = Vec3::new(0.9, 0.5, 0.6);
    let named = |name: &str, material: Material| Material { name: name.into(), ..material };
    vec![
        glass(0.1),
        glass(0.3),
        glass(0.8),
        named("dense tinted glass", Material { ior: 2.4, base_color: rose, ..glass(0.25) }),
        named("pane", Material { thin: true, base_color: rose, ..glass(0.2) }),
        named(
            "half transparent, part metal",
            Material { transmission: 0.5, metallic: 0.2, base_color: rose, ..glass(0.3) },
        ),
        named("half transparent pane", Material { transmission: 0.5, thin: true, ..glass(0.3) }),
        named("plastic", Material { transmission: 0.0, base_color: rose, ..glass(0.3) }),
        named("metal", Material { transmission: 0.0, metallic: 1.0, base_color: rose, ..glass(0.2) }),
    ]
}

/// Steep, slanting and grazing directions, from outside and from inside.
fn directions() -> Vec<DVec3> {
    [(0.95, 0.4), (0.6, 2.0), (0.15, 4.0), (-0.9, 1.0), (-0.6, 3.0), (-0.2, 5.5)]
        .map(|(z, phi)| spherical(z, phi))
        .to_vec()
}

fn spherical(z: f64, phi: f64) -> DVec3 {
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Uniform on the sphere.
fn random_direction(n: u32, salt: u32) -> DVec3 {
    let words = rng::random_words(7, n, 0, salt);
    spherical(2.0 * rng::uniform(words[0]) - 1.0, 2.0 * PI * rng::uniform(words[1]))
}

/// Probability of a chi^2 this large (Wilson and Hilferty 1931).
fn chi_square_tail(chi2: f64, dof: f64) -> f64 {
    let spread = 2.0 / (9.0 * dof);
    let z = ((chi2 / dof).cbrt() - 1.0 + spread) / spread.sqrt();
    0.5 * erfc(z / 2f64.sqrt())
}

/// Numerical Recipes' erfcc: relative error below 1.2e-7.
fn erfc(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    let c = [
        -1.26551223,
        1.00002368,
        0.37409196,
        0.09678418,
        -0.18628806,
        0.27886807,
        -1.13520398,
        1.48851587,
        -0.82215223,
        0.17087277,
    ];
    let sum = c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let tail = t * (sum - x * x).exp();
    if x >= 0.0 { tail } else { 2.0 - tail }
}

const ROWS: usize = 32;
const COLUMNS: usize = 48;
/// Quadrature points of a bin, each way. Densities jump where the half-vector leaves the hemisphere.
const POINTS: usize = 40;
const SAMPLES: usize = 1 << 19;

/// chi^2 of the directions and tags sampled for `w_in` against the density that evaluation states, over bins of the
/// sphere, and its degrees of freedom. Samples that are absorbed fill a bin of their own.
fn chi_square(
    device: &mut Device,
    material: usize,
    ns: DVec3,
    w_in: DVec3,
    tags: &[u32],
    fineness: usize,
) -> (f64, f64) {
    let samples = device.sample(material, ns, w_in, SAMPLES);
    let bins = ROWS * COLUMNS;
    let mut counts = vec![0f64; tags.len() * bins];
    for (w, tag) in samples.iter().filter(|s| s.1 != TAG_NONE) {
        let class = tags.iter().position(|t| t == tag).unwrap_or_else(|| panic!("tag {tag}"));
        let row = ((0.5 * (w.z + 1.0) * ROWS as f64) as usize).min(ROWS - 1);
        let column = ((w.y.atan2(w.x) / (2.0 * PI) + 0.5) * COLUMNS as f64) as usize % COLUMNS;
        counts[class * bins + row * COLUMNS + column] += 1.0;
    }
    let (rows, columns) = (ROWS * fineness, COLUMNS * fineness);
    let solid_angle = 4.0 * PI / (rows * columns) as f64;
    let mut expected = vec![0f64; tags.len() * bins];
    for (class, &tag) in tags.iter().enumerate() {
        for band in 0..ROWS {
            let points: Vec<_> = (0..fineness * columns)
                .map(|n| {
                    let z = 2.0 * ((band * fineness + n / columns) as f64 + 0.5) / rows as f64 - 1.0;
                    let phi = 2.0 * PI * (((n % columns) as f64 + 0.5) / columns as f64 - 0.5);
                    (spherical(z, phi), w_in, tag)
                })
                .collect();
            let first = class * bins + band * COLUMNS;
            for (n, e) in device.evaluate(material, ns, &points).iter().enumerate() {
                expected[first + n % columns / fineness] += e.pdf_to_light * solid_angle * SAMPLES as f64;
            }
        }
    }
    let (mut chi2, mut dof) = (0.0, 0.0);
    // Bins too rare for the normal law are put together, with the absorbed ones.
    let (mut rest, mut rest_expected) = (SAMPLES as f64, SAMPLES as f64);
    for (count, expected) in counts.iter().zip(&expected).filter(|(_, e)| **e >= 25.0) {
        chi2 += (count - expected).powi(2) / expected;
        dof += 1.0;
        rest -= count;
        rest_expected -= expected;
    }
    if rest_expected >= 25.0 {
        chi2 += (rest - rest_expected).powi(2) / rest_expected;
    } else {
        dof -= 1.0;
        assert!(rest <= 80.0, "{rest} samples where {rest_expected} are expected");
    }
    (chi2, dof)
}

/// All lobes among what is connected to, or all in classes of their own.
fn check_samples(materials: &[Material], threshold: f32, tags: &[u32]) {
    let context = context();
    let mut device = Device::new(&context, materials, threshold);
    let tilted = DVec3::new(0.2, -0.1, 1.0).normalize();
    for (index, material) in materials.iter().enumerate() {
        for (n, w_in) in directions().into_iter().enumerate() {
            let ns = if n % 3 == 1 { tilted } else { DVec3::Z };
            check_chi_square(&mut device, index, material, (ns, w_in), tags, POINTS);
        }
    }
}

fn check_chi_square(
    device: &mut Device,
    index: usize,
    material: &Material,
    (ns, w_in): (DVec3, DVec3),
    tags: &[u32],
    fineness: usize,
) {
    let (chi2, dof) = chi_square(device, index, ns, w_in, tags, fineness);
    let p = chi_square_tail(chi2, dof);
    println!("{}, {w_in:.2}: chi2 {chi2:.0} of {dof}, p {p:.2e}", material.name);
    assert!(p > 1e-5, "{} for {w_in}: p {p}", material.name);
}

#[test]
fn samples_have_their_density() {
    check_samples(&materials(), 0.0, &[TAG_DIFFUSE]);
}

#[test]
fn samples_of_narrow_lobes_have_their_density() {
    check_samples(&materials(), f32::INFINITY, &[TAG_DIFFUSE, TAG_REFLECT, TAG_TRANSMIT]);
}

/// Classes split the BSDF and change nothing about their sum.
#[test]
fn classes_add_up() {
    check_classes(&materials());
}

fn check_classes(materials: &[Material]) {
    let context = context();
    let mut whole = Device::new(&context, materials, 0.0);
    let mut split = Device::new(&context, materials, f32::INFINITY);
    for (index, material) in materials.iter().enumerate() {
        let pairs = pairs(&mut whole, index, 20_000);
        let whole = whole.evaluate(index, DVec3::Z, &pairs);
        let parts = [TAG_DIFFUSE, TAG_REFLECT, TAG_TRANSMIT].map(|tag| {
            let pairs: Vec<_> = pairs.iter().map(|p| (p.0, p.1, tag)).collect();
            split.evaluate(index, DVec3::Z, &pairs)
        });
        for (n, e) in whole.iter().enumerate() {
            for c in 0..3 {
                let sum: f64 = parts.iter().map(|p| p[n].value[c]).sum();
                assert!(
                    (sum - e.value[c]).abs() <= 1e-4 * e.value[c] + 1e-6,
                    "{}: {sum} of {}",
                    material.name,
                    e.value[c]
                );
            }
        }
    }
}

/// Pairs of directions as sampling makes them, and as many by chance.
fn pairs(device: &mut Device, material: usize, count: usize) -> Vec<(DVec3, DVec3, u32)> {
    let mut pairs = Vec::new();
    for w_camera in directions() {
        let sampled = device.sample(material, DVec3::Z, w_camera, count);
        pairs.extend(sampled.iter().filter(|s| s.1 == TAG_DIFFUSE).map(|s| (s.0, w_camera, TAG_DIFFUSE)));
    }
    pairs.extend((0..count as u32).map(|n| (random_direction(n, 1), random_direction(n, 2), TAG_DIFFUSE)));
    pairs
}

#[test]
fn rough_glass_is_walters() {
    let context = context();
    let materials = [glass(0.02), glass(0.1), glass(0.3), glass(0.8), Material { ior: 2.4, ..glass(0.25) }];
    let mut device = Device::new(&context, &materials, 0.0);
    for (index, material) in materials.iter().enumerate() {
        let pairs = pairs(&mut device, index, 20_000);
        let alpha = f64::from(material.roughness * material.roughness);
        let mut bad = 0;
        for ((light, camera, _), e) in pairs.iter().zip(device.evaluate(index, DVec3::Z, &pairs)) {
            let (reflected, transmitted, density) = walter::rough_glass(*light, *camera, alpha, material.ior.into());
            let near = |a: f64, b: f64| (a - b).abs() <= 2e-3 * b + 1e-5;
            bad += usize::from(!(near(e.value[0], reflected + transmitted) && near(e.pdf_to_light, density)));
        }
        println!("{}: {bad} of {} pairs differ", material.name, pairs.len());
        // Rounding of f32 directions at grazing angles and next to total reflection.
        assert!(bad as f64 <= 2e-3 * pairs.len() as f64, "{}: {bad}", material.name);
    }
}

/// f(a, b) / n_b^2 is the same both ways, and the density of one direction given the other does not depend on which of
/// them the light comes from.
#[test]
fn scattering_is_reciprocal() {
    check_reciprocity(&materials());
}

fn check_reciprocity(materials: &[Material]) {
    let context = context();
    let mut device = Device::new(&context, materials, 0.0);
    for (index, material) in materials.iter().enumerate() {
        let there = pairs(&mut device, index, 20_000);
        let back: Vec<_> = there.iter().map(|&(light, camera, tag)| (camera, light, tag)).collect();
        let index_of = |w: DVec3| if w.z > 0.0 || material.thin { 1.0 } else { f64::from(material.ior) };
        let forward = device.evaluate(index, DVec3::Z, &there);
        let backward = device.evaluate(index, DVec3::Z, &back);
        let mut bad = 0;
        for (((light, camera, _), f), b) in there.iter().zip(&forward).zip(&backward) {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * b.abs() + 1e-5;
            let same =
                (0..3).all(|c| near(f.value[c] / index_of(*camera).powi(2), b.value[c] / index_of(*light).powi(2)));
            bad +=
                usize::from(!(same && near(f.pdf_to_light, b.pdf_to_camera) && near(f.pdf_to_camera, b.pdf_to_light)));
        }
        println!("{}: {bad} of {} pairs differ", material.name, there.len());
        assert!(bad as f64 <= 2e-3 * there.len() as f64, "{}: {bad}", material.name);
    }
}

/// Out of light of the same L / n^2 all around comes no more than that, and for small alpha nearly all of it.
#[test]
fn no_energy_is_made() {
    let white = |name: &str, material: Material| Material { name: name.into(), base_color: Vec3::ONE, ..material };
    let materials = [
        glass(0.02),
        glass(0.1),
        glass(0.3),
        glass(0.8),
        white("pane", Material { thin: true, ..glass(0.02) }),
        white("rough pane", Material { thin: true, ..glass(0.3) }),
        white("half transparent", Material { transmission: 0.5, ..glass(0.3) }),
    ];
    let albedos = albedos(&materials);
    for (material, albedos) in materials.iter().zip(albedos) {
        for (camera, mean, error) in albedos {
            println!("{}, {camera:.2}: albedo {mean:.4} +- {error:.4}", material.name);
            assert!(mean < 1.0 + 4.5 * error + 1e-4, "{} for {camera}: {mean}", material.name);
            if material.roughness < 0.2 {
                assert!(mean > 0.97, "{} for {camera}: {mean}", material.name);
            }
        }
    }
}

/// What comes out of each material in each of [`directions`], with its standard error, where the same L / n^2 comes in
/// from all around.
fn albedos(materials: &[Material]) -> Vec<Vec<(DVec3, f64, f64)>> {
    let context = context();
    let mut device = Device::new(&context, materials, 0.0);
    let count = 1 << 17;
    let of = |(index, material): (usize, &Material)| {
        let albedo = |camera: DVec3| {
            let sampled = device.sample(index, DVec3::Z, camera, count);
            let pairs: Vec<_> = sampled.iter().filter(|s| s.1 != TAG_NONE).map(|&(w, tag)| (w, camera, tag)).collect();
            let (mut sum, mut squares) = (0.0, 0.0);
            for ((light, ..), e) in pairs.iter().zip(device.evaluate(index, DVec3::Z, &pairs)) {
                let index_of = |w: DVec3| if w.z > 0.0 || material.thin { 1.0 } else { f64::from(material.ior) };
                let squeeze = (index_of(*light) / index_of(camera)).powi(2);
                let w = e.value[0] * light.z.abs() / e.pdf_to_light * squeeze;
                sum += w;
                squares += w * w;
            }
            let mean = sum / count as f64;
            (camera, mean, ((squares / count as f64 - mean * mean).max(0.0) / count as f64).sqrt())
        };
        directions().into_iter().map(albedo).collect()
    };
    materials.iter().enumerate().map(of).collect()
}

/// A perturbation may bring the tag of a delta to a surface whose lobe is none: nothing is scattered there.
#[test]
fn rough_surfaces_have_no_delta() {
    let context = context();
    let mut materials = materials();
    materials.push(glass(0.0));
    let mut device = Device::new(&context, &materials, 0.0);
    let smooth = materials.len() - 1;
    let (light, camera) = (spherical(0.6, 1.0), spherical(0.6, 1.0 + PI));
    for tag in [TAG_REFLECT, TAG_TRANSMIT] {
        let light = if tag == TAG_REFLECT { light } else { spherical(-(1.0f64 - 0.64 / 2.25).sqrt(), 1.0) };
        for (index, material) in materials.iter().enumerate() {
            let value = device.evaluate(index, DVec3::Z, &[(light, camera, tag)])[0].value;
            assert_eq!(value != [0.0; 3], index == smooth, "{}, tag {tag}: {value:?}", material.name);
        }
    }
}
