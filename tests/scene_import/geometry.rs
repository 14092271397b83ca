//! Nodes, triangles and vertex data.

use super::*;

#[test]
fn hierarchy_applies_parents_matrices_and_trs() {
    let mut doc = triangle();
    doc.json["nodes"] = json!([
        { "children": [1], "matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 10,0,0,1] },
        { "children": [2], "translation": [0, 1, 0] },
        { "mesh": 0, "rotation": [0, 0, (FRAC_PI_2 / 2.0).sin(), (FRAC_PI_2 / 2.0).cos()], "scale": [3, 1, 1] },
    ]);
    let scene = doc.scene();
    let want = [vec3(10.0, 2.0, 0.0), vec3(10.0, 8.0, 0.0), vec3(8.0, 2.0, 0.0)];
    for (have, want) in corners(&scene, 0).iter().zip(want) {
        assert!(have.abs_diff_eq(want, 1e-5), "{have} {want}");
    }
}

#[test]
fn normals_follow_the_inverse_transpose() {
    let mut doc = Doc::new();
    let positions = doc.vectors(&[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0]]);
    let s = 0.5f32.sqrt();
    let normals = doc.vectors(&[[-s, s, 0.0]; 3]);
    doc.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    for scale in [[4.0, 1.0, 1.0], [-4.0, 1.0, 1.0], [4.0, -1.0, -1.0]] {
        doc.json["nodes"][0]["scale"] = json!(scale);
        let scene = doc.scene();
        let want = vec3(-s / scale[0], s / scale[1], 0.0).normalize();
        assert!(scene.normals[0].abs_diff_eq(want, 1e-5), "{scale:?} {}", scene.normals[0]);
        assert!(face_normal(&scene, 0).dot(scene.normals[0]) > 0.99, "{scale:?}");
    }
}

#[test]
fn mirrored_nodes_keep_their_front_outside() {
    let mut doc = triangle();
    doc.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let scene = doc.scene();
    assert!(face_normal(&scene, 0).abs_diff_eq(Vec3::Z, 1e-6));
    assert!(scene.normals[0].abs_diff_eq(Vec3::Z, 1e-6));
}

#[test]
fn indices_of_every_width_and_none() {
    for (component, bytes) in [
        (U8, vec![0u8, 1, 2, 2, 1, 3]),
        (U16, [0u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
        (U32, [0u32, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
    ] {
        let mut doc = Doc::new();
        let positions = doc.vectors(&SQUARE);
        let normals = doc.vectors(&[[0.0, 0.0, 1.0]; 4]);
        let indices = doc.accessor(&bytes, component, "SCALAR", 6);
        doc.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices }));
        let scene = doc.scene();
        assert_eq!((scene.triangles.len(), scene.positions.len()), (2, 4));
        assert_eq!(corners(&scene, 1), [vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0)]);
    }
    assert_eq!(triangle().scene().triangles.len(), 1);
}

#[test]
fn strips_and_fans_face_one_way_and_points_are_left_out() {
    let mut doc = Doc::new();
    let strip = doc.vectors(&SQUARE);
    let fan = doc.vectors(&[SQUARE[0], SQUARE[1], SQUARE[3], SQUARE[2]]);
    doc.show(json!({ "attributes": { "POSITION": strip }, "mode": 5 }));
    doc.show(json!({ "attributes": { "POSITION": fan }, "mode": 6 }));
    doc.show(json!({ "attributes": { "POSITION": fan }, "mode": 0 }));
    doc.show(json!({ "attributes": { "POSITION": fan }, "mode": 3 }));
    let scene = doc.scene();
    assert_eq!(scene.triangles.len(), 4);
    assert!((0..4).all(|t| face_normal(&scene, t).z > 0.99));
    assert!(warned(&scene, "Points and lines are not rendered: left out of 2 meshes"));
}

#[test]
fn missing_or_zero_normals_are_flat_and_flat_triangles_dropped() {
    let mut doc = Doc::new();
    let positions = doc.vectors(&TETRAHEDRON);
    let mut indices = TETRAHEDRON_INDICES.to_vec();
    indices.extend([0, 1, 1, 0, 0, 0]);
    let indices = doc.indices(&indices);
    doc.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    let scene = doc.scene();
    assert_eq!((scene.triangles.len(), scene.positions.len()), (4, 12));
    for t in 0..4 {
        for v in scene.triangles[t] {
            assert!(scene.normals[v as usize].abs_diff_eq(face_normal(&scene, t), 1e-6));
        }
    }
    assert!(warned(&scene, "2 triangles without area"));

    let normals = doc.vectors(&[[0.0, 0.0, -1.0], [0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let scene = doc.scene();
    let [a, b, c] = scene.triangles[0].map(|v| scene.normals[v as usize]);
    assert_eq!([a, b, c], [-Vec3::Z; 3]);
    let [_, b, d] = scene.triangles[1].map(|v| scene.normals[v as usize]);
    assert_eq!([b, d], [-Vec3::Y, Vec3::Z]);
}

#[test]
fn quantised_positions_and_normals() {
    let mut doc = Doc::new();
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let bytes: Vec<u8> = [0u16, 0, 0, 9, 65535, 0, 0, 9, 0, 65535, 0, 9].iter().flat_map(|x| x.to_le_bytes()).collect();
    let positions = doc.accessor(&bytes, U16, "VEC3", 3);
    doc.json["bufferViews"][0]["byteStride"] = json!(8);
    doc.json["accessors"][0]["normalized"] = json!(true);
    let normals = doc.accessor(&[0, 0, 127, 0, 0, 0, 129, 0, 0, 0, 128, 0], I8, "VEC3", 3);
    doc.json["bufferViews"][1]["byteStride"] = json!(4);
    doc.json["accessors"][1]["normalized"] = json!(true);
    doc.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    let scene = doc.scene();
    assert_eq!(corners(&scene, 0), TRIANGLE.map(Vec3::from_array));
    assert_eq!(scene.normals, [Vec3::Z, -Vec3::Z, -Vec3::Z]);
    doc.json["accessors"][0]["normalized"] = json!(false);
    assert_eq!(corners(&doc.scene(), 0)[1], vec3(65535.0, 0.0, 0.0));
    assert!(!doc.scene().warnings.iter().any(|w| w.contains("quantization")));
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    let mut doc = triangle();
    let indices = doc.view(&[1, 2]);
    let values: Vec<u8> = [5.0f32, 0.0, 0.0, 0.0, 7.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let values = doc.view(&values);
    let sparse = json!({ "count": 2, "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values } });
    doc.json["accessors"][0]["sparse"] = sparse;
    let want = [Vec3::ZERO, vec3(5.0, 0.0, 0.0), vec3(0.0, 7.0, 0.0)];
    assert_eq!(corners(&doc.scene(), 0), want);
    doc.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(corners(&doc.scene(), 0), want);
    doc.json["accessors"][0]["count"] = json!(2);
    assert!(doc.error().contains("accessors[0]: its sparse index 2 is beyond its 2 elements"));
    doc.json["accessors"][0]["count"] = json!(u64::MAX / 2);
    assert!(doc.error().contains("elements have no data"));
}

#[test]
fn morph_targets_apply_their_default_weights() {
    let mut doc = triangle();
    let target = doc.vectors(&[[0.0, 0.0, 2.0]; 3]);
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }, {}]);
    doc.json["meshes"][0]["weights"] = json!([0.5, 1.0]);
    assert_eq!(corners(&doc.scene(), 0)[1], vec3(1.0, 0.0, 1.0));
    doc.json["nodes"][0]["weights"] = json!([1.0]);
    assert_eq!(corners(&doc.scene(), 0)[1], vec3(1.0, 0.0, 2.0));
}

#[test]
fn the_default_scene_else_the_first_else_all_roots() {
    let mut doc = triangle();
    doc.push("nodes", json!({ "mesh": 0, "translation": [5, 0, 0] }));
    doc.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }, {}]);
    let x = |doc: &Doc| doc.scene().positions[0].x;
    doc.json["scene"] = json!(1);
    assert_eq!(x(&doc), 5.0);
    doc.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(x(&doc), 0.0);
    doc.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(doc.scene().triangles.len(), 2);
    doc.json["scene"] = json!(4);
    assert!(doc.error().contains("scene 4 does not exist"));
    doc.json["scene"] = json!(2);
    doc.json["scenes"] = json!([{}, {}, {}]);
    assert!(doc.error().contains("has no triangles"));
}

#[test]
fn instances_are_drawn_each() {
    let mut doc = triangle();
    let translations = doc.vectors(&[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let scales = doc.vectors(&[[1.0; 3], [-3.0, 1.0, 1.0]]);
    let attributes = json!({ "TRANSLATION": translations, "SCALE": scales });
    doc.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let scene = doc.scene();
    assert_eq!(corners(&scene, 0)[1], vec3(2.0, 0.0, 0.0));
    assert_eq!(corners(&scene, 1)[2], vec3(-1.0, 0.0, 0.0));
    assert!((0..2).all(|t| face_normal(&scene, t).z > 0.99));
    doc.json["accessors"][scales]["count"] = json!(1);
    assert!(doc.error().contains("nodes[0] has instance attributes of different lengths"));
}
