//! Layers over materials: against twins in f64 written from the extensions' formulas, apart from the shaders.

use super::*;
use emlt::scene::material::Coat;

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
        Material { coat: coat(0.8, 0.15), metallic: 1.0, ..Material { name: "coat on metal".into(), ..glass(0.0) } },
        Material { coat: coat(1.0, 0.4), base_color: rose, ..Material { name: "coat on glass".into(), ..glass(0.3) } },
    ]
}

/// Metal is opaque; [`coated`]'s is made of glass's parameters.
fn coated_opaque() -> Vec<Material> {
    let mut materials = coated();
    materials[2] = Material { transmission: 0.0, thin: true, roughness: 0.5, ..materials[2].clone() };
    materials
}

#[test]
fn samples_of_coats_have_their_density() {
    check_samples(&coated_opaque(), 0.0, &[TAG_DIFFUSE]);
}

#[test]
fn samples_of_narrow_coats_have_their_density() {
    check_samples(&coated_opaque(), f32::INFINITY, &[TAG_DIFFUSE, TAG_REFLECT, TAG_TRANSMIT]);
}

#[test]
fn classes_of_coats_add_up() {
    check_classes(&coated_opaque());
}

#[test]
fn coats_are_reciprocal() {
    check_reciprocity(&coated_opaque());
}

/// Under a coat of any roughness, white stays at most white, and under a smooth one over a mirror or matt white it hardly
/// darkens: less than a twentieth, the mean of the coat's Fresnel term over the directions that light comes from.
#[test]
fn coats_make_no_energy() {
    let mirror = |alpha| Material { metallic: 1.0, roughness: 0.05, coat: coat(1.0, alpha), ..matt("coat on mirror") };
    let white = |alpha| Material { coat: coat(1.0, alpha), ..matt("coat on white") };
    let alphas = [0.0, 0.05, 0.2, 0.5, 1.0];
    let materials: Vec<_> = alphas.into_iter().flat_map(|alpha| [mirror(alpha), white(alpha)]).collect();
    for (material, albedos) in materials.iter().zip(albedos(&materials)) {
        for (camera, mean, error) in albedos {
            let alpha = material.coat_alpha();
            println!("{} of alpha {alpha}, {camera:.2}: albedo {mean:.4} +- {error:.4}", material.name);
            assert!(mean < 1.0 + 4.5 * error + 1e-4, "{} of alpha {alpha}, {camera}: {mean}", material.name);
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
    let materials = &coated_opaque()[..2];
    let mut device = Device::new(&context, materials, 0.0);
    for (index, material) in materials.iter().enumerate() {
        let pairs = pairs(&mut device, index, 20_000);
        let (factor, alpha) = (f64::from(material.coat.factor), f64::from(material.coat_alpha()));
        let mut bad = 0;
        for ((light, camera, _), e) in pairs.iter().zip(device.evaluate(index, DVec3::Z, &pairs)) {
            let side = camera.z.signum();
            if light.z * side <= 1e-6 {
                assert_eq!(e.value, [0.0; 3]);
                continue;
            }
            let (fl, fc) = (factor * schlick(light.z.abs()), factor * schlick(camera.z.abs()));
            for c in 0..3 {
                let base = f64::from(material.base_color[c]) / PI * (1.0 - fl.max(fc));
                let expected = base + fl.min(fc) * ggx(*light, *camera, side * DVec3::Z, alpha);
                bad += usize::from((e.value[c] - expected).abs() > 2e-3 * expected + 1e-5);
            }
        }
        println!("{}: {bad} of {} values differ", material.name, 3 * pairs.len());
        assert!(bad as f64 <= 2e-3 * 3.0 * pairs.len() as f64, "{}: {bad}", material.name);
    }
}
