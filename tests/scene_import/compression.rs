//! Compressed meshes: EXT_meshopt_compression and KHR_draco_mesh_compression, whole and damaged.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
    PointIndex,
};

use super::*;

const MESHOPT: &str = "EXT_meshopt_compression";
const DRACO: &str = "KHR_draco_mesh_compression";

/// Vertex data by the codec of version 0.
fn attributes(stride: usize, bytes: &[u8]) -> Vec<u8> {
    let mut encoded = vec![0xa0];
    let most = ((8192 / stride) & !15).min(256);
    let mut last = bytes[..stride].to_vec();
    for block in bytes.chunks(most * stride) {
        for (k, last) in last.iter_mut().enumerate() {
            let mut deltas: Vec<u8> = Vec::new();
            for byte in block.iter().skip(k).step_by(stride) {
                let delta = byte.wrapping_sub(std::mem::replace(last, *byte));
                deltas.push((delta << 1) ^ ((delta as i8) >> 7) as u8);
            }
            deltas.resize(deltas.len().next_multiple_of(16), 0);
            let mut headers = vec![0u8; (deltas.len() / 16).div_ceil(4)];
            let mut body = Vec::new();
            for (i, group) in deltas.chunks(16).enumerate() {
                let wide = group.iter().filter(|d| **d >= 15).count();
                let header = if group.iter().all(|d| *d == 0) { 0 } else { 2 + u8::from(wide >= 8) };
                headers[i / 4] |= header << (i % 4 * 2);
                match header {
                    0 => {}
                    2 => {
                        body.extend(group.chunks(2).map(|pair| pair[0].min(15) << 4 | pair[1].min(15)));
                        body.extend(group.iter().filter(|d| **d >= 15));
                    }
                    _ => body.extend(group),
                }
            }
            encoded.extend(headers);
            encoded.extend(body);
        }
    }
    encoded.resize(encoded.len() + 32usize.saturating_sub(stride), 0);
    encoded.extend(&bytes[..stride]);
    encoded
}

/// A number in groups of seven bits.
fn varint(mut v: u32, encoded: &mut Vec<u8>) {
    while v > 127 {
        encoded.push(v as u8 | 128);
        v >>= 7;
    }
    encoded.push(v as u8);
}

/// A triangle list, every index written out.
fn triangle_list(indices: &[u32]) -> Vec<u8> {
    let mut encoded = vec![0xe1];
    encoded.resize(1 + indices.len() / 3, 0xff);
    let mut last = 0;
    for (i, &index) in indices.iter().enumerate() {
        if i % 3 == 0 {
            encoded.push(0xff);
        }
        let delta = index as i32 - std::mem::replace(&mut last, index as i32);
        varint(((delta << 1) ^ (delta >> 31)) as u32, &mut encoded);
    }
    encoded.extend([0; 16]);
    encoded
}

/// Any indices, all by the first of the two baselines.
fn index_sequence(indices: &[u32]) -> Vec<u8> {
    let mut encoded = vec![0xd1];
    let mut last = 0;
    for &index in indices {
        let delta = index as i32 - std::mem::replace(&mut last, index as i32);
        varint((((delta << 1) ^ (delta >> 31)) as u32) << 1, &mut encoded);
    }
    encoded.extend([0; 4]);
    encoded
}

impl Doc {
    /// Compressed data for a view of `count` elements in the second buffer, which has no data.
    fn compressed(&mut self, data: &[u8], (mode, filter): (&str, &str), stride: usize, count: usize) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(data);
        let mut view = json!({ "buffer": 1, "byteLength": stride * count, "extensions": { MESHOPT: { "buffer": 0,
            "byteOffset": offset, "byteLength": data.len(), "byteStride": stride, "count": count, "mode": mode } } });
        if mode == "ATTRIBUTES" {
            view["byteStride"] = json!(stride);
        }
        if filter != "NONE" {
            view["extensions"][MESHOPT]["filter"] = json!(filter);
        }
        let fallback = json!({ "byteLength": 1 << 20, "extensions": { MESHOPT: { "fallback": true } } });
        self.json["buffers"] = json!([{ "byteLength": self.bin.len() }, fallback]);
        self.push("bufferViews", view)
    }

    fn accessor_of(&mut self, view: usize, component: u32, kind: &str, count: usize) -> usize {
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }
}

/// 300 squares side by side, 100 units wide, in quantised positions, filtered normals and 16-bit triangles.
pub fn meshopt() -> Doc {
    let mut doc = Doc::new();
    let corners = || (0..300u16).flat_map(|i| SQUARE.map(|[x, y, _]| [100 * (i + x as u16), 100 * y as u16, 0, 0]));
    let positions: Vec<u8> = corners().flatten().flat_map(u16::to_le_bytes).collect();
    let normals: Vec<u8> = (0..1200).flat_map(|_| [0, 0, 63, 0]).collect();
    let triangles: Vec<u32> = (0..300).flat_map(|i| [0, 1, 2, 2, 1, 3].map(|corner| 4 * i + corner)).collect();
    let view = doc.compressed(&attributes(8, &positions), ("ATTRIBUTES", "NONE"), 8, 1200);
    let positions = doc.accessor_of(view, U16, "VEC3", 1200);
    let view = doc.compressed(&attributes(4, &normals), ("ATTRIBUTES", "OCTAHEDRAL"), 4, 1200);
    let normals = doc.accessor_of(view, I8, "VEC3", 1200);
    doc.json["accessors"][normals]["normalized"] = json!(true);
    let view = doc.compressed(&triangle_list(&triangles), ("TRIANGLES", "NONE"), 2, 1800);
    let indices = doc.accessor_of(view, U16, "SCALAR", 1800);
    doc.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices }));
    doc.json["extensionsRequired"] = json!([MESHOPT, "KHR_mesh_quantization"]);
    doc
}

#[test]
fn meshopt_views_are_decoded() {
    let mut doc = meshopt();
    doc.root(json!({ "mesh": 0, "scale": [0.01, 0.01, 0.01] }));
    let scene = doc.scene();
    assert!(scene.warnings.iter().all(|warning| !warning.contains("extension")), "{:?}", scene.warnings);
    assert_eq!((scene.triangles.len(), scene.positions.len()), (1200, 2400));
    assert!(scene.normals.iter().all(|n| *n == Vec3::Z));
    assert_eq!(
        corners(&scene, 599),
        [[29900.0, 100.0], [30000.0, 0.0], [30000.0, 100.0]].map(|[x, y]| vec3(x, y, 0.0))
    );
    assert!(corners(&scene, 1199)[2].abs_diff_eq(vec3(300.0, 1.0, 0.0), 1e-4));

    // The other name of the extension, in which the fallback need not be marked.
    let text = doc.json.to_string().replace(MESHOPT, "KHR_meshopt_compression");
    doc.json = serde_json::from_str(&text).unwrap();
    doc.json["buffers"][1].as_object_mut().unwrap().remove("extensions");
    assert_eq!(doc.scene().positions, scene.positions);
}

#[test]
fn meshopt_floats_and_strips() {
    let mut doc = Doc::new();
    // 1.0 is 512 * 2^-9.
    let mantissa = |x: f32| ((-9i32 << 24) | ((x * 512.0) as i32 & 0xff_ffff)).to_le_bytes();
    let positions: Vec<u8> = SQUARE.map(|p| p.map(|x| x - 0.5)).iter().flatten().flat_map(|x| mantissa(*x)).collect();
    let view = doc.compressed(&attributes(12, &positions), ("ATTRIBUTES", "EXPONENTIAL"), 12, 4);
    let positions = doc.accessor_of(view, F32, "VEC3", 4);
    let view = doc.compressed(&index_sequence(&[0, 1, 2, 3]), ("INDICES", "NONE"), 4, 4);
    let indices = doc.accessor_of(view, U32, "SCALAR", 4);
    doc.show(json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": 5 }));
    let scene = doc.scene();
    assert_eq!(scene.triangles.len(), 2);
    assert_eq!(corners(&scene, 0), [SQUARE[0], SQUARE[1], SQUARE[2]].map(|p| Vec3::from_array(p) - 0.5));
}

/// Vertices of a Draco mesh, with an unused attribute before the others so that their numbers are not their places.
pub fn draco(method: i32, bits: Option<i32>) -> Vec<u8> {
    let mut mesh = Mesh::new();
    let mut add = |kind, id, components: u8, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, values.len() / usize::from(components));
        attribute.buffer_mut().update_f32s_le(0, values);
        attribute.set_unique_id(id);
        mesh.add_attribute_preserve_unique_id(attribute)
    };
    add(GeometryAttributeType::Generic, 1, 1, &[5.0; 4]);
    let normals = TETRAHEDRON.map(|p| (Vec3::from_array(p) - 0.25).normalize().to_array());
    add(GeometryAttributeType::Generic, 7, 3, normals.as_flattened());
    let positions = add(GeometryAttributeType::Position, 3, 3, TETRAHEDRON.as_flattened());
    mesh.set_num_faces(4);
    for (i, face) in TETRAHEDRON_INDICES.chunks(3).enumerate() {
        mesh.set_face(FaceIndex(i as u32), [face[0], face[1], face[2]].map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_encoding_method(method);
    options.set_compression_level(if bits.is_some() { 10 } else { 5 });
    if let Some(bits) = bits {
        options.set_attribute_quantization(positions, bits);
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut encoded = EncoderBuffer::new();
    encoder.encode(&options, &mut encoded).unwrap();
    encoded.data().to_vec()
}

/// A tetrahedron in Draco data only.
pub fn draco_doc(data: &[u8]) -> Doc {
    let mut doc = Doc::new();
    let view = doc.view(data);
    let vectors = json!({ "componentType": F32, "type": "VEC3", "count": 4 });
    let positions = doc.push("accessors", vectors.clone());
    let normals = doc.push("accessors", vectors);
    let indices = doc.push("accessors", json!({ "componentType": U16, "type": "SCALAR", "count": 12 }));
    doc.show(json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices,
        "extensions": { DRACO: { "bufferView": view, "attributes": { "POSITION": 3, "NORMAL": 7 } } } }));
    doc.json["extensionsRequired"] = json!([DRACO]);
    doc
}

/// The triangles' corners in an order that does not depend on how they are stored.
fn sorted(scene: &Scene) -> Vec<[[i32; 3]; 3]> {
    let round = |p: Vec3| (p * 1000.0).round().as_ivec3().to_array();
    let mut triangles: Vec<_> = (0..scene.triangles.len())
        .map(|t| {
            let mut corners = corners(scene, t).map(round);
            let first = (0..3).min_by_key(|i| corners[*i]).unwrap();
            corners.rotate_left(first);
            corners
        })
        .collect();
    triangles.sort();
    triangles
}

#[test]
fn draco_primitives_are_decoded() {
    let mut plain = Doc::new();
    let (positions, indices) = (plain.vectors(&TETRAHEDRON), plain.indices(&TETRAHEDRON_INDICES));
    plain.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    let want = sorted(&plain.scene());
    // One triangle after the other, and connected; floats as they are, and quantised.
    for (method, bits) in [(0, None), (0, Some(14)), (1, None), (1, Some(14))] {
        let mut doc = draco_doc(&draco(method, bits));
        let scene = doc.scene();
        assert_eq!((sorted(&scene), scene.positions.len()), (want.clone(), 4), "{method} {bits:?}");
        assert!(scene.warnings.iter().all(|warning| !warning.contains("extension")), "{:?}", scene.warnings);
        for (p, n) in scene.positions.iter().zip(&scene.normals) {
            assert!((*p - 0.25).normalize().dot(*n) > 0.999, "{method} {bits:?}: {p} {n}");
        }
        // A strip's indices are another number.
        doc.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
        doc.json["accessors"][2]["count"] = json!(6);
        assert_eq!(sorted(&doc.scene()), want);
    }
    // An attribute that is not in the Draco data is read from its accessor.
    let mut doc = draco_doc(&draco(0, None));
    let normals = doc.vectors(&[[0.0, 0.0, 1.0]; 4]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    doc.json["meshes"][0]["primitives"][0]["extensions"][DRACO]["attributes"] = json!({ "POSITION": 3 });
    assert!(doc.scene().normals.iter().all(|n| *n == Vec3::Z));
}

#[test]
fn wrong_compression_is_named() {
    let draco = draco_doc(&draco(1, Some(14)));
    let meshopt = meshopt();
    let in_draco = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let in_view = "/bufferViews/0/extensions/EXT_meshopt_compression";
    let cases = [
        (&draco, in_draco, "/bufferView", json!("x"), "names no bufferView"),
        (&draco, in_draco, "/bufferView", json!(9), "bufferViews[9] does not exist"),
        (&draco, in_draco, "/attributes/POSITION", json!(2), "attributes.POSITION 2 is not in the data"),
        (&draco, in_draco, "/attributes/POSITION", json!(1), "accessors[0]: its Draco data is of another type"),
        (&draco, "/bufferViews/0", "/byteLength", json!(9), "cannot be decoded from bufferViews[0]"),
        (&draco, "/accessors/0", "/count", json!(5), "it has 5 elements, but its Draco data has 4"),
        (&draco, "/accessors/0", "/count", json!(0), "bufferViews[0] (it has more data than the accessors say)"),
        (&draco, "/accessors/0", "/type", json!("VEC2"), "accessors[0]: its type"),
        (&draco, "/accessors/2", "/count", json!(9), "bufferViews[0] (it has more data than the accessors say)"),
        (&draco, "/accessors/2", "/count", json!(15), "has 4 triangles, but its accessors have 5"),
        (&meshopt, in_view, "/buffer", json!(1), "buffers[1] has neither a uri nor a BIN chunk"),
        (&meshopt, in_view, "/buffer", json!(-1), "buffer is not a whole number"),
        (&meshopt, in_view, "/byteOffset", json!("0"), "byteOffset is not a whole number"),
        (&meshopt, in_view, "/byteLength", json!(1 << 30), "reaches beyond buffers[0]"),
        (&meshopt, in_view, "/byteLength", json!(40), "its data ends too early"),
        (&meshopt, in_view, "/byteStride", json!(6), "its byteStride does not fit"),
        (&meshopt, in_view, "/count", json!(1201), "has more elements than its buffer view's 9600 bytes"),
        (&meshopt, in_view, "/count", json!(u64::MAX), "has more elements than its buffer view's"),
        (&meshopt, in_view, "/count", json!(600), "it has more data than elements"),
        (&meshopt, in_view, "/mode", json!("TRIANGLES"), "its byteStride does not fit"),
        (&meshopt, in_view, "/mode", json!("NEW"), "mode is unknown"),
        (&meshopt, "/bufferViews/1/extensions/EXT_meshopt_compression", "/filter", json!("NEW"), "filter is unknown"),
        (&meshopt, "/bufferViews/0", "/extensions", json!({}), "buffers[1] has neither a uri nor a BIN chunk"),
    ];
    for (doc, at, key, value, want) in cases {
        let mut doc = Doc { json: doc.json.clone(), bin: doc.bin.clone() };
        *doc.json.pointer_mut(&format!("{at}{key}")).unwrap_or_else(|| panic!("{at}{key}")) = value;
        let error = doc.error();
        let element = if at == in_view { "bufferViews[0].extensions" } else { "meshes[0].primitives[0]: " };
        assert!(error.contains(want) && error.contains(element), "{at}{key}: {error}");
        assert!(error.contains("test.glb: ") && error.ends_with(": export the file again"), "{at}{key}: {error}");
    }
    // A claim of gigabytes, which the data could well stand for.
    let mut doc = Doc { json: meshopt.json.clone(), bin: meshopt.bin.clone() };
    doc.json["bufferViews"][0]["byteLength"] = json!(1u64 << 40);
    *doc.json.pointer_mut(&format!("{in_view}/count")).unwrap() = json!(1u64 << 30);
    assert!(doc.error().contains("has more data than can be rendered"), "{}", doc.error());
}

/// Damages the binary data of `doc` at random, and cuts it at every length.
fn damage(doc: &Doc, cases: usize, shorten: impl Fn(&mut Value, usize)) {
    let mut state = 1u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let try_import = |doc: &Doc, case: &str| match std::panic::catch_unwind(|| doc.import()) {
        Ok(Ok(scene)) => check(&scene),
        Ok(Err(error)) => assert_eq!(error.exit_status(), 2, "{case}: {error}"),
        Err(_) => panic!("{case} panicked"),
    };
    let copy = || Doc { json: doc.json.clone(), bin: doc.bin.clone() };
    for case in 0..cases {
        let mut damaged = copy();
        for _ in 0..=next(4) {
            let at = next(damaged.bin.len());
            damaged.bin[at] = if next(2) == 0 { damaged.bin[at] ^ 1 << next(8) } else { next(256) as u8 };
        }
        try_import(&damaged, &format!("case {case}"));
    }
    for length in 0..doc.bin.len().min(600) {
        let mut cut = copy();
        shorten(&mut cut.json, length);
        try_import(&cut, &format!("length {length}"));
    }
}

#[test]
fn damaged_meshopt_data_never_panics() {
    damage(&meshopt(), 3000, |json, length| {
        for view in json["bufferViews"].as_array_mut().unwrap() {
            let whole = view["extensions"][MESHOPT]["byteLength"].as_u64().unwrap();
            view["extensions"][MESHOPT]["byteLength"] = json!(whole.min(length as u64));
        }
    });
}

#[test]
fn damaged_draco_data_never_panics() {
    for (method, bits) in [(0, None), (0, Some(14)), (1, None), (1, Some(14))] {
        let doc = draco_doc(&draco(method, bits));
        damage(&doc, 3000, |json, length| json["bufferViews"][0]["byteLength"] = json!(length));
    }
}
