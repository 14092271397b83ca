//! Extensions of materials that become others' parameters, and the light around a scene.

use emlt::scene::Features;
use emlt::scene::material::{Anisotropy, Sheen};

use super::textures::{png_bytes, textured};
use super::*;

#[test]
fn sheen_and_anisotropy_are_read() {
    let scene = with_material(json!({ "extensions": {
        "KHR_materials_sheen": { "sheenColorFactor": [0.1, 0.2, 2], "sheenRoughnessFactor": 0.4 },
        "KHR_materials_anisotropy": { "anisotropyStrength": 0.6, "anisotropyRotation": 0.5 } } }))
    .scene();
    let m = &scene.materials[0];
    assert_eq!(m.sheen, Sheen { color: vec3(0.1, 0.2, 1.0), roughness: 0.4 });
    assert_eq!(m.anisotropy, Anisotropy { strength: 0.6, rotation: 0.5 });
    let features = Features::of(&scene);
    assert!(features.sheen && features.anisotropic && features.textured && scene.tangents.len() == 3);
    assert!(!warned(&scene, "KHR_materials"), "{:?}", scene.warnings);
}

#[test]
fn anisotropy_follows_the_first_coordinates() {
    let black = json!({ "extensions": { "KHR_materials_anisotropy": { "anisotropyStrength": 1 } } });
    let scene = textured(&png_bytes(1, &[[0, 0, 0, 255]]), black).scene();
    // TEXCOORD_0 grows along x on the triangle of the tests.
    assert_eq!(scene.tangents[0].truncate(), Vec3::X);
}

fn glossy(extension: Value) -> Value {
    json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 1, 0, 1], "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_pbrSpecularGlossiness": extension } })
}

#[test]
fn specular_glossiness_becomes_specular_and_roughness() {
    let scene = with_material(glossy(json!({ "diffuseFactor": [0.5, 0.4, 1, 0.25], "specularFactor": [0.1, 0.5, 0.2],
        "glossinessFactor": 0.75 })));
    let mut scene = scene;
    scene.json["materials"][0]["pbrMetallicRoughness"] = json!({});
    let m = &scene.scene().materials[0];
    assert_eq!((m.metallic, m.roughness, m.ior, m.specular), (0.0, 0.25, 0.0, 1.0));
    assert_eq!((m.base_color, m.specular_color, m.base_alpha), (vec3(0.25, 0.2, 0.5), vec3(0.1, 0.5, 0.2), 0.25));
    assert_eq!(m.textures.base_color, None);
}

#[test]
fn specular_glossiness_textures_are_made_into_others() {
    let pixels = [[255, 0, 0, 51], [188, 188, 188, 255]];
    let texture = json!({ "index": 0 });
    let both = json!({ "diffuseTexture": texture, "specularGlossinessTexture": texture, "glossinessFactor": 0.5 });
    let scene = textured(&png_bytes(2, &pixels), glossy(both)).scene();
    let m = &scene.materials[0];
    let of = |texture: &Option<emlt::scene::Texture>, at| {
        let texture = texture.as_ref().unwrap();
        emlt::scene::Texture { linear: false, ..texture.clone() }.sample(&scene.images, at)
    };
    let near = |a: [f64; 4], b: [f64; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 4e-3);
    let (left, right) = ([0.25, 0.5], [0.75, 0.5]);
    // Code 188 is half of white.
    assert!(near(of(&m.textures.specular_color, left), [1.0, 0.0, 0.0]));
    assert!(near(of(&m.textures.specular_color, right), [0.503; 3]));
    assert!(near(of(&m.textures.base_color, left), [0.0; 3]) && near(of(&m.textures.base_color, right), [0.25; 3]));
    let rough = [left, right].map(|at| f64::from(m.roughness) * of(&m.textures.metallic_roughness, at)[1]);
    assert!((rough[0] - 0.9).abs() < 4e-3 && (rough[1] - 0.5).abs() < 4e-3, "{rough:?}");
    let [mean, most] = m.mapped_alpha.unwrap();
    assert!((mean - 0.53).abs() < 0.01 && (most - 0.81).abs() < 0.01, "{mean} {most}");
    // Without a diffuse texture, what the reflectance leaves is a texture all the same.
    let scene = textured(&png_bytes(2, &pixels), glossy(json!({ "specularGlossinessTexture": texture }))).scene();
    let base = scene.materials[0].textures.base_color.as_ref().unwrap();
    assert!(near(base.sample(&scene.images, [0.75, 0.5]), [0.497; 3]));
}

#[test]
fn unlit_is_radiance_of_both_sides() {
    let unlit = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 1], "baseColorTexture": { "index": 0 } },
        "emissiveFactor": [1, 1, 1], "extensions": { "KHR_materials_unlit": {} } });
    let scene = textured(&png_bytes(1, &[[255; 4]]), unlit).scene();
    let m = &scene.materials[0];
    assert_eq!((m.base_color, m.emission, m.specular, m.metallic), (Vec3::ZERO, vec3(0.5, 0.25, 1.0), 0.0, 0.0));
    assert!(
        m.unlit
            && m.emits_on_both_sides()
            && m.is_culled()
            && m.textures.emissive.is_some()
            && m.textures.base_color.is_none()
    );
    // It is not what lights a scene.
    assert!(warned(&scene, "no light") && scene.sky.is_none() && scene.environment.is_some());
    assert!(!warned(&scene, "nlit mat"), "{:?}", scene.warnings);
}

/// A scene in a white environment of brightness 2.
pub fn image_lit() -> Doc {
    // 4, as RGBD.
    let mut doc = textured(&png_bytes(1, &[[255, 255, 255, 64]]), json!({}));
    let light = json!({ "intensity": 0.5, "rotation": [0, 1, 0, 1], "irradianceCoefficients": [],
        "specularImages": [[0, 0, 0, 0, 0, 0]], "specularImageSize": 1 });
    doc.json["extensions"] = json!({ "EXT_lights_image_based": { "lights": [light] } });
    doc.json["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 0 } });
    doc
}

#[test]
fn an_image_based_light_surrounds_the_scene() {
    let mut doc = image_lit();
    doc.json["scenes"][0]["extensions"] = json!({});
    assert!(doc.scene().environment.is_none(), "no scene names the light");
    doc.json["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 0 } });
    let scene = doc.scene();
    let environment = scene.environment.as_ref().unwrap();
    assert!(environment.pixels.iter().all(|p| (p[0] - 0.5 * 255.0 / 64.0).abs() < 1e-4), "{environment:?}");
    assert!(scene.sky.is_none() && !warned(&scene, "light"), "{:?}", scene.warnings);
    let mut broken = |path: &str, value: Value, part: &str| {
        let old = std::mem::replace(doc.json.pointer_mut(path).unwrap(), value);
        let scene = doc.scene();
        assert!(warned(&scene, part) && scene.sky.is_some(), "{part}: {:?}", scene.warnings);
        *doc.json.pointer_mut(path).unwrap() = old;
    };
    let light = "/extensions/EXT_lights_image_based/lights/0";
    broken("/scenes/0/extensions/EXT_lights_image_based/light", json!(3), "does not exist");
    broken(&format!("{light}/rotation"), json!([0, 0, 0, 0]), "no quaternion");
    broken(&format!("{light}/intensity"), json!(-1), "intensity");
    broken(&format!("{light}/specularImages"), json!([[0, 0]]), "six images");
    broken(&format!("{light}/specularImages/0/3"), json!(9), "images[9] does not exist");
}
