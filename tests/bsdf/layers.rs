//! Layers over materials: against twins in f64 written from the extensions' formulas, apart from the shaders.

use super::*;
use emlt::scene::albedo::{self, ALBEDO_ENTRIES};
use emlt::scene::material::{Anisotropy, Coat, Sheen};
use emlt::scene::{Texture, sheen};

fn coat(factor: f32, alpha: f32) -> Coat {
    Coat { factor, roughness: alpha.sqrt(), mapped_alpha: None }
}

/// Matt white unless told otherwise, opaque.
fn matt(name: &str) -> Material {
    Material { name: name.into(), metallic: 0.0, specular: 0.0, ..Material::default() }
}

/// Coats over every kind of base, wide enough for the grid of [`chi_square`].
fn coated() -> Vec<Material> {
    let rose = Vec3::new(0.9, 0.5, 0.6);
    vec![
        Material { base_color: rose, coat: coat(1.0, 0.2), ..matt("coat on rose") },
        Material { base_color: Vec3::ZERO, coat: coat(0.6, 0.3), ..matt("coat on black") },
        Material { base_color: rose, metallic: 1.0, roughness: 0.5, coat: coat(0.8, 0.15), ..matt("coat on metal") },
        Material { coat: coat(1.0, 0.4), base_color: rose, ..Material { name: "coat on glass".into(), ..glass(0.3) } },
    ]
}

/// chi^2 as for the materials without layers; opaque ones are the same on either side, and have no density that jumps.
fn check_layers(materials: &[Material], threshold: f32) {
    let context = context();
    let mut device = Device::new(&context, materials, threshold);
    let tilted = DVec3::new(0.2, -0.1, 1.0).normalize();
    for (index, material) in materials.iter().enumerate() {
        let clear = material.transmission > 0.0;
        let tags = match (threshold > 0.0, clear) {
            (false, _) => &[TAG_DIFFUSE][..],
            (true, false) => &[TAG_DIFFUSE, TAG_REFLECT],
            (true, true) => &[TAG_DIFFUSE, TAG_REFLECT, TAG_TRANSMIT],
        };
        let shown = directions().into_iter().enumerate().filter(|(n, _)| if clear { n % 3 == 1 } else { *n < 3 });
        for (n, w_in) in shown {
            let ns = if n == 1 { tilted } else { DVec3::Z };
            check_chi_square(&mut device, index, material, (ns, w_in), tags, if clear { POINTS } else { 12 });
        }
    }
}

/// A coat's normals need not be the base's: bumps under a smooth coat.
#[test]
fn samples_of_coats_with_their_own_normals_have_their_density() {
    let context = context();
    let transform = emlt::scene::texture::IDENTITY;
    let bumps = Texture { image: 0, srgb: false, linear: false, wrap: Default::default(), slot: 0, transform };
    let mut materials = coated();
    materials[0].textures.normal = Some((bumps, 1.0));
    for (threshold, tags) in [(0.0, &[TAG_DIFFUSE][..]), (f32::INFINITY, &[TAG_DIFFUSE, TAG_REFLECT])] {
        let mut device = Device::new(&context, &materials[..3], threshold);
        device.lean = 0.25;
        for (index, material) in materials[..3].iter().enumerate() {
            let ns = DVec3::new(-0.2, 0.1, 1.0).normalize();
            check_chi_square(&mut device, index, material, (ns, directions()[1]), tags, 12);
        }
    }
}

#[test]
fn samples_of_coats_have_their_density() {
    check_layers(&coated(), 0.0);
}

#[test]
fn samples_of_narrow_coats_have_their_density() {
    check_layers(&coated(), f32::INFINITY);
}

#[test]
fn classes_of_coats_add_up() {
    check_classes(&coated());
}

#[test]
fn coats_are_reciprocal() {
    check_reciprocity(&coated());
}

/// Under a coat of any roughness, white stays at most white, and under a smooth one over a mirror or matt white it hardly
/// darkens: less than a twentieth, the mean of the coat's albedo over the directions that light comes from.
#[test]
fn coats_make_no_energy() {
    let mirror = |alpha| Material { metallic: 1.0, roughness: 0.05, coat: coat(1.0, alpha), ..matt("coat on mirror") };
    let white = |alpha| Material { coat: coat(1.0, alpha), ..matt("coat on white") };
    let alphas = [0.0, 0.05, 0.3, 1.0];
    let materials: Vec<_> = alphas.into_iter().flat_map(|alpha| [mirror(alpha), white(alpha)]).collect();
    for (material, albedos) in materials.iter().zip(albedos(&materials)) {
        for (camera, mean, error) in albedos {
            let alpha = material.coat_alpha();
            println!("{} of alpha {alpha}, {camera:.2}: albedo {mean:.4} +- {error:.4}", material.name);
            assert!(mean < 1.0 + 4.5 * error + 5e-4, "{} of alpha {alpha}, {camera}: {mean}", material.name);
            let least = if material.metallic > 0.0 { 0.985 } else { 0.945 };
            assert!(alpha > 0.01 || mean > least - 4.5 * error, "{} of alpha {alpha}, {camera}: {mean}", material.name);
        }
    }
}

/// GGX, separable Smith and Schlick of glTF 2.0, appendix B.3, about `n`.
fn ggx(l: DVec3, v: DVec3, n: DVec3, alpha: f64) -> f64 {
    let h = (l + v).normalize();
    let (a2, nh) = (alpha * alpha, n.dot(h));
    let d = a2 / (PI * (nh * nh * (a2 - 1.0) + 1.0).powi(2));
    let g1 = |c: f64| 2.0 * c / (c + (a2 + (1.0 - a2) * c * c).sqrt());
    d * g1(n.dot(l)) * g1(n.dot(v)) / (4.0 * n.dot(l) * n.dot(v))
}

fn schlick(cosine: f64) -> f64 {
    0.04 + 0.96 * (1.0 - cosine).powi(5)
}

#[test]
fn coats_are_their_twins() {
    let context = context();
    let materials = &coated()[..2];
    let mut device = Device::new(&context, materials, 0.0);
    for (index, material) in materials.iter().enumerate() {
        let pairs = pairs(&mut device, index, 2_000);
        let (factor, alpha) = (f64::from(material.coat.factor), f64::from(material.coat_alpha()));
        let mut bad = 0;
        for ((light, camera, _), e) in pairs.iter().zip(device.evaluate(index, DVec3::Z, &pairs)) {
            let side = camera.z.signum();
            if light.z * side <= 1e-6 {
                assert_eq!(e.value, [0.0; 3]);
                continue;
            }
            // Of the table's interpolation, up to 1e-3.
            let taken =
                [light, camera].map(|w| factor * albedo::coat(alpha, w.z.abs(), 24)).into_iter().fold(0.0, f64::max);
            let fresnel = factor * schlick((*light + *camera).normalize().dot(*camera));
            for c in 0..3 {
                let base = f64::from(material.base_color[c]) / PI * (1.0 - taken);
                let expected = base + fresnel * ggx(*light, *camera, side * DVec3::Z, alpha);
                bad += usize::from((e.value[c] - expected).abs() > 3e-3 * expected + 1e-3);
            }
        }
        println!("{}: {bad} of {} values differ", material.name, 3 * pairs.len());
        assert!(bad as f64 <= 2e-3 * 3.0 * pairs.len() as f64, "{}: {bad}", material.name);
    }
}

fn fibres(color: [f32; 3], roughness: f32) -> Sheen {
    Sheen { color: color.into(), roughness }
}

/// Sheen over every kind of base, alone and under a coat, and facets that spread unevenly.
fn sheens_and_grains() -> Vec<Material> {
    let rose = Vec3::new(0.9, 0.5, 0.6);
    let grain = |strength, rotation| Anisotropy { strength, rotation };
    let metal = |alpha: f32| Material { metallic: 1.0, roughness: alpha.sqrt(), base_color: rose, ..matt("") };
    vec![
        Material { base_color: rose, sheen: fibres([0.7, 0.8, 1.0], 0.5), ..matt("sheen on rose") },
        Material { sheen: fibres([1.0; 3], 0.3), name: "sheen on metal".into(), ..metal(0.3) },
        Material { coat: coat(0.8, 0.3), sheen: fibres([0.9, 0.5, 0.2], 0.8), ..matt("coat on sheen") },
        Material { anisotropy: grain(0.7, 0.6), name: "brushed metal".into(), ..metal(0.15) },
        Material { anisotropy: grain(0.6, 2.0), ..Material { name: "brushed glass".into(), ..glass(0.2) } },
        Material { anisotropy: grain(0.5, 1.0), coat: coat(1.0, 0.2), name: "coat on brushed".into(), ..metal(0.2) },
    ]
}

#[test]
fn samples_of_sheen_and_grain_have_their_density() {
    check_layers(&sheens_and_grains(), 0.0);
}

#[test]
fn samples_of_narrow_grain_have_their_density() {
    check_layers(&sheens_and_grains()[2..], f32::INFINITY);
}

#[test]
fn classes_of_sheen_and_grain_add_up() {
    check_classes(&sheens_and_grains());
}

#[test]
fn sheen_and_grain_are_reciprocal() {
    check_reciprocity(&sheens_and_grains());
}

#[test]
fn sheen_and_grain_make_no_energy() {
    let white = |roughness| Material { sheen: fibres([1.0; 3], roughness), ..matt("sheen on white") };
    let brushed = |alpha: f32| Material {
        metallic: 1.0,
        roughness: alpha.sqrt(),
        anisotropy: Anisotropy { strength: 0.8, rotation: 0.3 },
        ..matt("brushed white")
    };
    let materials: Vec<_> = [0.0, 0.1, 0.3, 1.0].map(white).into_iter().chain([0.01, 0.2].map(brushed)).collect();
    for (material, albedos) in materials.iter().zip(albedos(&materials)) {
        for (camera, mean, error) in albedos {
            println!("{}, {camera:.2}: albedo {mean:.4} +- {error:.4}", material.name);
            assert!(mean < 1.0 + 4.5 * error + 2e-3, "{}, {camera}: {mean}", material.name);
        }
    }
}

/// The tables' interpolation against quadrature with more points, between their entries.
#[test]
fn the_tables_are_the_layers_albedos() {
    let last = (ALBEDO_ENTRIES - 1) as f64;
    let least = f64::from(sheen::SHEEN_ROUGHNESS);
    let of_sheen = |down: f64, cosine| sheen::albedo((least + (1.0 - least) * down).powi(2), cosine, 400);
    let of_coat = |down: f64, cosine| albedo::coat(down * down, cosine, 400);
    type Albedo<'a> = &'a dyn Fn(f64, f64) -> f64;
    let tables: [(&[f32], Albedo); 2] = [(&albedo::SHEEN_ALBEDO, &of_sheen), (&albedo::COAT_ALBEDO, &of_coat)];
    for (table, albedo) in tables {
        for (row, column) in [(0, 8), (1, 15), (5, 6), (12, 20), (20, 3), (30, 30)] {
            let at = |i: usize, j: usize| f64::from(table[i * ALBEDO_ENTRIES + j]);
            let entries = [at(row, column), at(row, column + 1), at(row + 1, column), at(row + 1, column + 1)];
            let (down, cosine) = ((row as f64 + 0.5) / last, ((column as f64 + 0.5) / last).powi(2));
            let (exact, mean) = (albedo(down, cosine), entries.iter().sum::<f64>() / 4.0);
            println!("row {row}, cosine {cosine:.3}: {mean:.4} for {exact:.4}");
            assert!((mean - exact).abs() < 0.03 * exact + 3e-3, "{mean} {exact}");
        }
    }
}

#[test]
fn sheen_and_grain_are_their_twins() {
    let context = context();
    let rose = Vec3::new(0.9, 0.5, 0.6);
    let brushed = Material { metallic: 1.0, roughness: 0.4, base_color: rose, ..matt("brushed") };
    let materials = [
        Material { base_color: Vec3::ZERO, sheen: fibres([0.7, 0.2, 0.9], 0.6), ..matt("sheen") },
        Material { anisotropy: Anisotropy { strength: 0.7, rotation: 0.6 }, ..brushed },
    ];
    let mut device = Device::new(&context, &materials, 0.0);
    let bad = |index: usize, device: &mut Device, twin: &dyn Fn(DVec3, DVec3, usize) -> f64| {
        let pairs: Vec<_> = pairs(device, index, 20_000).into_iter().filter(|p| p.0.z.min(p.1.z) > 1e-4).collect();
        let mut bad = 0;
        for ((light, camera, _), e) in pairs.iter().zip(device.evaluate(index, DVec3::Z, &pairs)) {
            for c in 0..3 {
                let expected = twin(*light, *camera, c);
                bad += usize::from((e.value[c] - expected).abs() > 3e-3 * expected + 1e-5);
            }
        }
        println!("{}: {bad} of {} values differ", materials[index].name, 3 * pairs.len());
        assert!(bad as f64 <= 2e-3 * 3.0 * pairs.len() as f64, "{}: {bad}", materials[index].name);
    };
    let alpha = 0.36;
    bad(0, &mut device, &|l, v, c| {
        let h = (l + v).normalize();
        let sine = (1.0 - h.z * h.z).sqrt();
        let shadowed = (1.0 + sheen::lambda(l.z, alpha) + sheen::lambda(v.z, alpha)) * 4.0 * l.z * v.z;
        f64::from(materials[0].sheen.color[c]) * sheen::distribution(sine, alpha) / shadowed
    });
    // KHR_materials_anisotropy, with separable shadowing.
    let (across, along) = (0.16f64, 0.16 + 0.84 * 0.49);
    let (t, b) = (DVec3::new(0.6f64.cos(), 0.6f64.sin(), 0.0), DVec3::new(-0.6f64.sin(), 0.6f64.cos(), 0.0));
    bad(1, &mut device, &|l, v, c| {
        let h = (l + v).normalize();
        let slope = (h.dot(t) / along).powi(2) + (h.dot(b) / across).powi(2) + h.z * h.z;
        let d = 1.0 / (PI * along * across * slope * slope);
        let g1 = |w: DVec3| {
            2.0 * w.z / (w.z + ((along * w.dot(t)).powi(2) + (across * w.dot(b)).powi(2) + w.z * w.z).sqrt())
        };
        let f0 = f64::from(rose[c]);
        (f0 + (1.0 - f0) * (1.0 - h.dot(v)).powi(5)) * d * g1(l) * g1(v) / (4.0 * l.z * v.z)
    });
}
