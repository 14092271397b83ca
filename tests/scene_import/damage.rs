//! Broken and hostile files: one-sentence errors, never a panic.

use super::*;

#[test]
fn broken_references_are_named() {
    let edit = |path: &str, value: Value| {
        let mut doc = triangle();
        *doc.json.pointer_mut(path).unwrap_or_else(|| panic!("{path}")) = value;
        doc.error()
    };
    let cases = [
        ("/accessors/0/count", json!(4), "accessors[0]: its 4 elements reach beyond bufferViews[0]"),
        ("/accessors/0/count", json!(u64::MAX), "accessors[0]: its"),
        ("/accessors/0/bufferView", json!(8), "bufferViews[8] does not exist"),
        ("/accessors/0/componentType", json!(5125), "accessors[0]: its type or componentType"),
        ("/accessors/0/componentType", json!(1), "accessors[0]: its componentType"),
        ("/accessors/0/type", json!("VEC2"), "accessors[0]: its type"),
        ("/bufferViews/0/byteLength", json!(4000), "bufferViews[0] reaches beyond buffers[0]"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "bufferViews[0] reaches beyond buffers[0]"),
        ("/bufferViews/0/buffer", json!(2), "buffers[2] does not exist"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(5), "meshes[0].primitives[0]: accessors[5]"),
        ("/meshes/0/primitives/0/attributes", json!({}), "meshes[0].primitives[0]: it has no POSITION"),
        ("/meshes/0/primitives", json!(3), "meshes[0]"),
        (
            "/meshes/0/primitives/0",
            json!({ "attributes": { "POSITION": 0 }, "material": 3 }),
            "materials[3] does not exist",
        ),
        ("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "indices": 1 }), "accessors[1]"),
        ("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "mode": 9 }), "its mode is unknown"),
        ("/nodes/0/mesh", json!(1), "meshes[1] does not exist"),
        ("/nodes/0", json!({ "mesh": 0, "children": [0] }), "nodes[0] is reached twice"),
        ("/nodes/0", json!({ "mesh": 0, "children": [3] }), "nodes[3] does not exist"),
        ("/nodes/0", json!({ "mesh": 0, "rotation": [0, 0, 0, 0] }), "nodes[0].rotation is zero"),
        (
            "/nodes/0",
            json!({ "mesh": 0, "translation": [1e30, 0, 0] }),
            "meshes[0].primitives[0]: the position of vertex",
        ),
        ("/asset/version", json!("1.0"), "has asset.version 1.0"),
    ];
    for (path, value, want) in cases {
        let error = edit(path, value);
        assert!(error.contains(want) && error.contains("test.glb"), "{path}: {error}");
    }

    let mut doc = triangle();
    let indices = doc.indices(&[0, 1, 3]);
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(doc.error().contains("it names vertex 3 of 3"));
    let mut doc = Doc::new();
    let positions = doc.vectors(&[TRIANGLE[0], TRIANGLE[1], [0.0, f32::NAN, 0.0]]);
    doc.show(json!({ "attributes": { "POSITION": positions } }));
    assert!(doc.error().contains("meshes[0].primitives[0]: the position of vertex 2 is not finite"));
    assert!(import(Path::new("/nowhere/at/all.glb")).unwrap_err().exit_status() == 2);
    assert!(import(Path::new("/")).unwrap_err().exit_status() == 2);
}

/// A few bytes must not stand for gigabytes.
#[test]
fn counts_without_data_are_bounded() {
    let mut doc = triangle();
    doc.json["accessors"][0] = json!({ "componentType": F32, "type": "VEC3", "count": 1 << 24 });
    assert!(doc.error().contains("accessors[0]: its 16777216 elements have no data"), "{}", doc.error());
    let mut doc = triangle();
    let zeros = doc.push("accessors", json!({ "componentType": U32, "type": "SCALAR", "count": 1 << 24 }));
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(zeros);
    assert!(doc.error().contains("elements have no data"), "{}", doc.error());
    let mut doc = triangle();
    let zeros = doc.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 1 << 24 }));
    let attributes = json!({ "TRANSLATION": zeros });
    doc.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    assert!(doc.error().contains("elements have no data"), "{}", doc.error());
}

#[test]
fn many_instances_end_in_an_error_and_deep_nesting_does_not() {
    let mut doc = Doc::new();
    let positions = doc.vectors(&vec![[0.0; 3]; 300_000]);
    let mesh = doc.mesh(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    for _ in 0..200 {
        doc.root(json!({ "mesh": mesh }));
    }
    assert!(doc.error().contains("the scene has more than"));

    let mut doc = triangle();
    doc.json["nodes"] = (0..20_000).map(|i| json!({ "children": [i + 1] })).collect();
    doc.push("nodes", json!({ "mesh": 0 }));
    assert_eq!(doc.scene().triangles.len(), 1);
}

/// A file that touches most of the importer.
fn rich() -> Doc {
    let mut doc = with_material(json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } } }));
    let indices = doc.view(&[1]);
    let values = doc.view(&[0; 12]);
    let positions = doc.vectors(&TETRAHEDRON);
    let normals = doc.vectors(&[[0.0, 0.0, 1.0]; 4]);
    let triangles = doc.indices(&TETRAHEDRON_INDICES);
    doc.json["accessors"][1]["sparse"] = json!({ "count": 1,
        "indices": { "bufferView": indices, "componentType": U8 }, "values": { "bufferView": values } });
    doc.show(
        json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": triangles, "material": 0 }),
    );
    doc.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    doc.root(json!({ "camera": 0, "children": [], "scale": [1, 2, 3] }));
    doc
}

#[test]
fn truncated_files_are_errors() {
    let bytes = rich().glb();
    import_bytes(&bytes, "whole.glb").unwrap();
    for length in 0..bytes.len() {
        let error = import_bytes(&bytes[..length], "cut.glb").expect_err("a cut file was accepted");
        assert_eq!(error.exit_status(), 2);
    }
}

#[test]
fn damaged_files_never_panic() {
    let bytes = rich().glb();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.glb");
    // A plain LCG: the same damage every time; the seed of a failing case is in the message.
    let mut state = 1u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    for case in 0..5000 {
        let mut damaged = bytes.clone();
        for _ in 0..=next(4) {
            let at = next(damaged.len());
            // Digits for digits keep the JSON valid, so that the damage reaches the importer.
            damaged[at] = match damaged[at] {
                b'0'..=b'9' if next(4) > 0 => b'0' + next(10) as u8,
                _ => next(256) as u8,
            };
        }
        std::fs::write(&path, &damaged).unwrap();
        let outcome = std::panic::catch_unwind(|| import(&path));
        match outcome.unwrap_or_else(|_| panic!("case {case} panicked")) {
            Ok(scene) => check(&scene),
            Err(error) => assert_eq!(error.exit_status(), 2, "case {case}: {error}"),
        }
    }
}
