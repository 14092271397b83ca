//! Material parameters, glass, and what is left out of them.

use super::*;
use emlt::scene::Features;
use emlt::scene::light::{Light, LightKind};
use emlt::scene::material::{AlphaMode, DELTA_ALPHA};

#[test]
fn every_material_parameter() {
    let scene = with_material(json!({ "name": "m", "doubleSided": true, "emissiveFactor": [0.5, 1, 0],
        "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.4, "roughnessFactor": 0.6 },
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 }, "KHR_materials_ior": { "ior": 1.7 },
            "KHR_materials_specular": { "specularFactor": 0.25, "specularColorFactor": [1, 2, 3] },
            "KHR_materials_transmission": { "transmissionFactor": 0.75 },
            "KHR_materials_volume": { "thicknessFactor": 0.1 } } }))
    .scene();
    let m = &scene.materials[0];
    assert_eq!((m.name.as_str(), m.double_sided, m.thin), ("m", true, false));
    assert_eq!((m.metallic, m.roughness, m.ior, m.specular, m.transmission), (0.4, 0.6, 1.7, 0.25, 0.75));
    assert_eq!(m.base_color, vec3(0.1, 0.2, 0.3));
    assert_eq!(m.specular_color, vec3(1.0, 2.0, 3.0));
    assert_eq!(m.emission, vec3(4.0, 8.0, 0.0));
    assert_eq!(scene.sky, None);
    assert!(!warned(&scene, "transmission"), "{:?}", scene.warnings);

    let scene = triangle().scene();
    assert_eq!(scene.materials, [emlt::scene::Material::default()]);
    assert_eq!(scene.sky, Some(Vec3::ONE));
    assert!(warned(&scene, "no light"));
}

#[test]
fn unsupported_material_features_are_said_once() {
    let scene = with_material(json!({ "alphaMode": "BLEND",
        "extensions": { "KHR_materials_iridescence": {}, "KHR_materials_dispersion": {},
            "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": { "thicknessFactor": 0,
            "attenuationDistance": 1, "attenuationColor": [1, 0, 0] } } }))
    .scene();
    for part in ["Alpha blending of glass", "KHR_materials_iridescence", "KHR_materials_dispersion"] {
        assert!(warned(&scene, part), "{part}: {:?}", scene.warnings);
    }
    assert!(scene.materials[0].thin && scene.sky.is_some());

    let error = with_material(json!({ "emissiveFactor": [1e39, 0, 0] })).error();
    assert!(error.contains("materials[0]: emissiveFactor"), "{error}");
}

#[test]
fn coats_are_read_and_have_no_deltas() {
    let smooth = json!({ "metallicFactor": 1, "roughnessFactor": 0 });
    let coated = |coat: Value| {
        with_material(
            json!({ "pbrMetallicRoughness": smooth.clone(), "extensions": { "KHR_materials_clearcoat": coat } }),
        )
    };
    let scene = coated(json!({ "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.8 })).scene();
    let m = &scene.materials[0];
    assert_eq!((m.coat.factor, m.coat.roughness), (0.5, 0.8));
    assert!((m.coat_alpha() - 0.64).abs() < 1e-6 && m.alpha() == DELTA_ALPHA);
    let features = Features::of(&scene);
    assert!(features.coated && features.glossy && features.narrow && features.mirror);
    assert!(!warned(&scene, "clearcoat"), "{:?}", scene.warnings);
    // Without a factor there is none.
    let scene = coated(json!({ "clearcoatRoughnessFactor": 0.8 })).scene();
    assert!(scene.materials[0].alpha() == 0.0 && !Features::of(&scene).coated);
    assert!(coated(json!({ "clearcoatFactor": 1e39 })).error().contains("KHR_materials_clearcoat is not a finite"));
}

#[test]
fn unsupported_scene_features_are_said_once() {
    let mut doc = triangle();
    doc.json["extensionsRequired"] = json!(["VENDOR_thing", "KHR_lights_punctual"]);
    let scene = doc.scene();
    assert!(warned(&scene, "VENDOR_thing"), "{:?}", scene.warnings);
}

#[test]
fn glass_refracts_where_closed_or_thick() {
    let glass = |volume: Option<f32>| {
        let mut doc = Doc::new();
        let mut extensions = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
        if let Some(thickness) = volume {
            extensions["KHR_materials_volume"] = json!({ "thicknessFactor": thickness });
        }
        doc.push(
            "materials",
            json!({ "name": "glass", "pbrMetallicRoughness": { "roughnessFactor": 0 },
            "extensions": extensions }),
        );
        // Faces of their own vertices: closed only after welding.
        let soup: Vec<[f32; 3]> = TETRAHEDRON_INDICES.iter().map(|&i| TETRAHEDRON[i as usize]).collect();
        let closed = doc.vectors(&soup);
        let open = doc.vectors(&soup[3..]);
        doc.show(json!({ "attributes": { "POSITION": closed }, "material": 0 }));
        doc.show(json!({ "attributes": { "POSITION": open }, "material": 0 }));
        let scene = doc.scene();
        let thin = |t: usize| scene.materials[scene.triangle_materials[t] as usize].thin;
        (thin(0), thin(4), scene.materials.len())
    };
    assert_eq!(glass(None), (false, true, 2));
    assert_eq!(glass(Some(0.1)), (false, false, 1));
    assert_eq!(glass(Some(0.0)), (true, true, 1));
}

#[test]
fn glass_closed_over_several_primitives_refracts() {
    let mut doc = Doc::new();
    doc.push("materials", json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } } }));
    let positions = doc.vectors(&TETRAHEDRON);
    let (one, other) = (doc.indices(&TETRAHEDRON_INDICES[..6]), doc.indices(&TETRAHEDRON_INDICES[6..]));
    let part = |indices: usize| json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 0 });
    let mesh = doc.push("meshes", json!({ "primitives": [part(one), part(other)] }));
    doc.root(json!({ "mesh": mesh }));
    let scene = doc.scene();
    assert!(scene.materials.len() == 1 && !scene.materials[0].thin);
}

#[test]
fn attenuation_is_beers_law() {
    let scene = with_material(json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 0.5, 0] } } }))
    .scene();
    let sigma = scene.materials[0].absorption;
    assert!(sigma.x == 0.0 && (sigma.y - 2.0 * 2f32.ln()).abs() < 1e-6 && sigma.z > 20.0, "{sigma}");
    assert!(Features::of(&scene).absorbing);
}

#[test]
fn alpha_modes() {
    let scene = with_material(json!({ "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5] } }))
    .scene();
    assert_eq!((scene.materials[0].base_alpha, scene.materials[0].alpha_mode), (0.5, AlphaMode::Mask(0.25)));
    assert!(!Features::of(&scene).masked, "an alpha that is the same everywhere needs no look-up");
    let scene = with_material(json!({ "alphaMode": "BLEND" })).scene();
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Blend);
    assert!(Features::of(&scene).blended && Features::of(&scene).mirror);
    // Below the cutoff all over: there is nothing of it.
    let mut doc = with_material(json!({ "alphaMode": "MASK",
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.4] } }));
    assert!(doc.error().contains("no triangles"));
    let positions = doc.vectors(&TRIANGLE);
    doc.show(json!({ "attributes": { "POSITION": positions } }));
    assert_eq!(doc.scene().triangles.len(), 1);
}

#[test]
fn punctual_lights_follow_their_nodes() {
    let mut doc = triangle();
    doc.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "color": [1, 0.5, 0], "intensity": 4 },
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
        { "type": "directional", "intensity": 0 },
        { "type": "laser" }] } });
    let turned = [FRAC_PI_2.sin() / 2f32.sqrt(), 0.0, 0.0, (FRAC_PI_2 / 2.0).cos()];
    for (light, extra) in [(0, json!([1, 2, 3])), (1, json!([0, 0, 0])), (2, json!([0, 0, 0]))] {
        doc.root(json!({ "translation": extra, "rotation": turned,
            "extensions": { "KHR_lights_punctual": { "light": light } } }));
    }
    let scene = doc.scene();
    assert!(scene.sky.is_none() && scene.lights.len() == 2, "{:?}", scene.lights);
    let point = Light { kind: LightKind::Point { position: vec3(1.0, 2.0, 3.0) }, intensity: vec3(4.0, 2.0, 0.0) };
    assert_eq!(scene.lights[0], point);
    let LightKind::Spot { direction, inner_cosine, .. } = scene.lights[1].kind else { panic!("{:?}", scene.lights[1]) };
    // A quarter turn about x takes -z to +y.
    assert!((direction - Vec3::Y).length() < 1e-6 && (inner_cosine - 0.1f32.cos()).abs() < 1e-6, "{direction}");
    for (light, part) in [(3, "lights[3].type is unknown"), (4, "lights[4] does not exist")] {
        doc.json["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": light } });
        assert!(doc.error().contains(part), "{}", doc.error());
    }
}
