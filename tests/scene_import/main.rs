//! The glTF importer on small files made here, on damaged ones, and on the sample models where they are at hand.

use std::f32::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

mod allocations;
mod cameras;
mod compression;
mod damage;
mod extensions;
mod fuzz;
mod geometry;
mod materials;
mod textures;

use emlt::scene::{Scene, import::import};
use glam::{Vec3, vec3};
use serde_json::{Value, json};

const U8: u32 = 5121;
const I8: u32 = 5120;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// A glTF document with one binary buffer, built accessor by accessor.
struct Doc {
    json: Value,
    bin: Vec<u8>,
}

impl Doc {
    fn new() -> Self {
        let json = json!({ "asset": { "version": "2.0" }, "accessors": [], "bufferViews": [], "materials": [],
            "meshes": [], "nodes": [], "cameras": [], "scenes": [{ "nodes": [] }], "scene": 0 });
        Self { json, bin: Vec::new() }
    }

    fn push(&mut self, key: &str, value: Value) -> usize {
        let array = self.json[key].as_array_mut().unwrap();
        array.push(value);
        array.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, F32, "VEC3", vectors.len())
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, U32, "SCALAR", indices.len())
    }

    fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// A node at the scene's root.
    fn root(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    /// A root node with one mesh of one primitive.
    fn show(&mut self, primitive: Value) {
        let mesh = self.mesh(primitive);
        self.root(json!({ "mesh": mesh }));
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        glb(&json.to_string(), &self.bin)
    }

    fn import(&self) -> emlt::Result<Scene> {
        import_bytes(&self.glb(), "test.glb")
    }

    fn scene(&self) -> Scene {
        let scene = self.import().unwrap();
        check(&scene);
        scene
    }

    fn error(&self) -> String {
        match self.import() {
            Err(emlt::Error::Input(sentence)) => sentence,
            other => panic!("expected an input error, got {other:?}"),
        }
    }
}

fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

fn import_bytes(bytes: &[u8], name: &str) -> emlt::Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    import(&path)
}

/// What every imported scene promises.
fn check(scene: &Scene) {
    assert_eq!(scene.positions.len(), scene.normals.len());
    assert_eq!(scene.triangles.len(), scene.triangle_materials.len());
    assert!(!scene.triangles.is_empty() && !scene.cameras.is_empty());
    assert!(scene.positions.iter().all(|p| p.is_finite()));
    assert!(scene.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    assert!(scene.triangles.iter().flatten().all(|&v| (v as usize) < scene.positions.len()));
    assert!(scene.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()));
    for camera in &scene.cameras {
        let m = camera.world_from_camera.matrix3;
        assert!((m.determinant() - 1.0).abs() < 1e-5, "{camera:?}");
        assert!((m.transpose() * m).abs_diff_eq(glam::Mat3A::IDENTITY, 1e-5), "{camera:?}");
    }
    let mut said = scene.warnings.clone();
    said.sort();
    said.dedup();
    assert_eq!(said.len(), scene.warnings.len(), "{:?}", scene.warnings);
}

fn warned(scene: &Scene, part: &str) -> bool {
    scene.warnings.iter().filter(|w| w.contains(part)).count() == 1
}

/// World corners of a triangle.
fn corners(scene: &Scene, triangle: usize) -> [Vec3; 3] {
    scene.triangles[triangle].map(|v| scene.positions[v as usize])
}

fn face_normal(scene: &Scene, triangle: usize) -> Vec3 {
    let [a, b, c] = corners(scene, triangle);
    (b - a).cross(c - a).normalize()
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
const TETRAHEDRON: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TETRAHEDRON_INDICES: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

/// A document that shows one triangle in the xy plane.
fn triangle() -> Doc {
    let mut doc = Doc::new();
    let positions = doc.vectors(&TRIANGLE);
    doc.show(json!({ "attributes": { "POSITION": positions } }));
    doc
}

/// One triangle with one material.
fn with_material(material: Value) -> Doc {
    let mut doc = triangle();
    doc.push("materials", material);
    doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    doc
}

#[test]
fn buffers_from_data_uris_and_percent_encoded_files() {
    let doc = triangle();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.bin"), &doc.bin).unwrap();
    let text: String = doc.bin.iter().map(|b| format!("%{b:02x}")).collect();
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let write = |uri: String| {
        let mut json = doc.json.clone();
        json["buffers"] = json!([{ "byteLength": doc.bin.len(), "uri": uri }]);
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        import(&path)
    };
    for uri in [format!("data:application/octet-stream;base64,{base64}"), format!("data:,{text}"), "a%20b.bin".into()] {
        let scene = write(uri.clone()).unwrap();
        assert_eq!(corners(&scene, 0), TRIANGLE.map(Vec3::from_array), "{uri}");
        assert_eq!(scene.name, "scene");
        let beside = (uri == "a%20b.bin").then(|| folder.path().join("a b.bin"));
        assert_eq!(
            scene.files,
            [Some(folder.path().join("scene.gltf")), beside].into_iter().flatten().collect::<Vec<_>>()
        );
    }
    for uri in ["missing.bin", "https://example.com/a.bin", "data:;base64,!!", "data:none", "%ff.bin", "."] {
        let error = write(uri.into()).unwrap_err().to_string();
        assert!(error.contains("scene.gltf: ") && error.contains("buffers[0]"), "{error}");
    }
}

/// Every .gltf and .glb under `folder`, sorted.
fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(models(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Triangles that the sample models' default scenes draw.
const DRAWN: [(&str, usize); 24] = [
    ("AlphaBlendModeTest.glb", 61),
    ("AnimatedMorphCube.gltf", 12),
    ("AttenuationTest.glb", 292),
    ("ClearCoatTest.glb", 37116),
    ("DamagedHelmet.glb", 15452),
    ("EmissiveStrengthTest.glb", 90),
    ("Fox.glb", 576),
    ("GlassVaseFlowers.glb", 14036),
    ("LightsPunctualLamp.gltf", 6000),
    ("MorphPrimitivesTest.glb", 32),
    ("MultipleScenes.gltf", 2),
    ("NegativeScaleTest.glb", 7724),
    ("NormalTangentTest.glb", 7774),
    ("SheenChair.gltf", 39936),
    ("SimpleInstancing.glb", 1500),
    ("SimpleSparseAccessor.gltf", 12),
    ("SpecularTest.glb", 44828),
    ("TextureTransformTest.gltf", 24),
    ("ToyCar.gltf", 108936),
    ("TransmissionRoughnessTest.glb", 77792),
    ("TransmissionTest.glb", 128775),
    ("chess-board.glb", 178845),
    ("lumberjack.glb", 1538),
    ("pirate.glb", 5010),
];

#[test]
fn sample_models_import_where_they_are_at_hand() {
    for path in models(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets/models")) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let scene = import(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        check(&scene);
        if let Some((_, drawn)) = DRAWN.iter().find(|(known, _)| *known == name) {
            assert_eq!(scene.triangles.len(), *drawn, "{name}");
        }
        let low = scene.positions.iter().copied().reduce(Vec3::min).unwrap();
        let high = scene.positions.iter().copied().reduce(Vec3::max).unwrap();
        println!("{name}: {} triangles, extent {:.4}", scene.triangles.len(), high - low);
        let cameras: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
        println!("    cameras: {}", cameras.join(", "));
        scene.warnings.iter().for_each(|warning| println!("    {warning}"));
    }
}
