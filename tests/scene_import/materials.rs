//! Material parameters, glass, and what is left out of them.

use super::*;

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
    let scene = with_material(json!({ "alphaMode": "MASK",
        "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 }, "KHR_materials_sheen": {},
            "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": { "thicknessFactor": 0,
            "attenuationDistance": 1, "attenuationColor": [1, 0, 0] } } }))
    .scene();
    for part in ["Alpha", "KHR_materials_clearcoat", "KHR_materials_sheen", "Attenuation"] {
        assert!(warned(&scene, part), "{part}: {:?}", scene.warnings);
    }
    assert!(scene.materials[0].thin && scene.sky.is_some());

    let scene = with_material(json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1] },
        "extensions": { "KHR_materials_unlit": {} } }))
    .scene();
    let m = &scene.materials[0];
    assert_eq!((m.metallic, m.specular, m.base_color), (0.0, 0.0, Vec3::splat(0.5)));
    assert!(warned(&scene, "Unlit"));
    let error = with_material(json!({ "emissiveFactor": [1e39, 0, 0] })).error();
    assert!(error.contains("materials[0]: emissiveFactor"), "{error}");
}

#[test]
fn unsupported_scene_features_are_said_once() {
    let mut doc = triangle();
    doc.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    doc.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    doc.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    doc.json["extensionsRequired"] = json!(["VENDOR_thing", "KHR_lights_punctual"]);
    let scene = doc.scene();
    for part in ["Punctual lights", "Image-based", "VENDOR_thing"] {
        assert!(warned(&scene, part), "{part}: {:?}", scene.warnings);
    }
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
