//! Damaged files by the hundred thousand: no panic, no more than a stated time and memory for any.
//!
//! Whole small files that between them touch all of the importer are damaged with their structure in mind: values, keys
//! and elements of the JSON, numbers in the binary data, bytes of the container. A case is its number and nothing else.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use super::extensions::image_lit;
use super::textures::{png_bytes, textured};
use super::*;
use crate::allocations;

/// Most memory that an input of a few kilobytes may take: its own size, many times over, and what a few decoders take
/// before they look at their data.
const MOST_BYTES: usize = 96 << 20;
/// Longest time for one input, with room for a busy machine.
const LONGEST: Duration = Duration::from_secs(10);

/// A small generator (O'Neill 2014, PCG): the case is its stream.
struct Random(u64, u64);

impl Random {
    fn of(case: u64) -> Self {
        let mut random = Self(0, (case << 1) | 1);
        random.next();
        random.0 = random.0.wrapping_add(0x853c_49e6_748f_ea9b ^ case.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        random.next();
        random
    }

    fn next(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(6364136223846793005).wrapping_add(self.1);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.next()) * n.max(1) as u64) >> 32) as usize
    }

    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// Pointers to all parts of a document.
fn pointers(json: &Value, at: &str, found: &mut Vec<String>) {
    match json {
        Value::Object(object) => object.iter().for_each(|(key, value)| {
            let path = format!("{at}/{}", key.replace('~', "~0").replace('/', "~1"));
            pointers(value, &path, found);
            found.push(path);
        }),
        Value::Array(array) => array.iter().enumerate().for_each(|(i, value)| {
            let path = format!("{at}/{i}");
            pointers(value, &path, found);
            found.push(path);
        }),
        _ => {}
    }
}

fn number(random: &mut Random, old: f64) -> Value {
    match random.below(12) {
        0 => json!(old + 1.0),
        1 => json!(old - 1.0),
        2 => json!(old as i64 + 1),
        3 => json!((old as i64).wrapping_sub(1)),
        4 => json!(random.below(6)),
        5 => json!(*random.pick(&[5120u32, 5121, 5122, 5123, 5125, 5126, 33071, 33648, 9728])),
        6 => json!(*random.pick(&[u64::MAX, u64::MAX / 2, 1 << 32, (1 << 32) - 1, 1 << 31, 1 << 24, 1 << 16, 255])),
        7 => json!(-(random.below(1000) as f64)),
        8 => json!(*random.pick(&[1e38, -1e38, 1e39, 1e300, 1e-45, -0.0, 0.5, 1e15])),
        9 => json!(old * 1000.0),
        10 => json!(-old),
        _ => json!(random.next() >> random.below(32)),
    }
}

/// One change to the JSON.
fn damage_json(random: &mut Random, json: &mut Value) {
    let mut all = Vec::new();
    pointers(json, "", &mut all);
    let path = random.pick(&all).clone();
    let other = json.pointer(random.pick(&all).as_str()).cloned().unwrap_or(Value::Null);
    let (parent, key) = path.rsplit_once('/').unwrap();
    match random.below(10) {
        0 => match json.pointer_mut(parent) {
            Some(Value::Object(object)) => drop(object.remove(key)),
            Some(Value::Array(array)) => drop(array.remove(key.parse::<usize>().unwrap())),
            _ => {}
        },
        1 => *json.pointer_mut(&path).unwrap() = other,
        2 => {
            let made = [
                json!(null),
                json!("x"),
                json!([]),
                json!({}),
                json!(true),
                json!([[[[]]]]),
                json!("data:,"),
                json!(""),
            ];
            *json.pointer_mut(&path).unwrap() = random.pick(&made).clone();
        }
        3 => match json.pointer_mut(parent) {
            Some(Value::Array(array)) => array.push(other),
            Some(Value::Object(object)) => drop(object.insert("extra".into(), other)),
            _ => {}
        },
        4 => {
            if let Some(Value::Object(object)) = json.pointer_mut(parent) {
                let value = object.remove(key).unwrap_or(Value::Null);
                let to = random.pick(&all).rsplit_once('/').unwrap().1;
                object.insert(to.to_string(), value);
            }
        }
        _ => match json.pointer_mut(&path) {
            Some(value @ Value::Number(_)) => *value = number(random, value.as_f64().unwrap_or(0.0)),
            Some(Value::String(text)) => {
                let at = random.below(text.len() + 1);
                if text.is_char_boundary(at) {
                    text.insert(at, *random.pick(&['/', '.', '%', '\0', 'é', '~', ':', 'A']));
                }
            }
            Some(Value::Bool(value)) => *value = !*value,
            Some(Value::Array(array)) if !array.is_empty() => {
                let (from, to) = (random.below(array.len()), random.below(array.len()));
                array.swap(from, to);
            }
            _ => {}
        },
    }
}

fn damage_bytes(random: &mut Random, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    match random.below(6) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.next() as u8,
        3 => {
            let words = [f32::NAN.to_bits(), f32::INFINITY.to_bits(), f32::MAX.to_bits(), u32::MAX, 0x8000_0000, 0, 1];
            let word = random.pick(&words).to_le_bytes();
            bytes.iter_mut().skip(at & !3).zip(word).for_each(|(byte, new)| *byte = new);
        }
        4 => {
            let count = random.below(16);
            bytes.iter_mut().skip(at).take(count).for_each(|byte| *byte = random.next() as u8);
        }
        _ => {
            let piece = bytes[at..(at + 8).min(bytes.len())].to_vec();
            bytes.splice(at..at, piece);
        }
    }
}

/// The files to damage.
fn whole() -> Vec<Doc> {
    let texture = json!({ "index": 0, "texCoord": 3, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0.1],
        "rotation": 0.3, "scale": [2, 3], "texCoord": 0 } } });
    let extensions = json!({
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatTexture": texture, "clearcoatRoughnessFactor": 0.2,
            "clearcoatRoughnessTexture": texture, "clearcoatNormalTexture": texture },
        "KHR_materials_sheen": { "sheenColorFactor": [0.5, 0.1, 1], "sheenRoughnessFactor": 0.5, "sheenColorTexture": texture },
        "KHR_materials_anisotropy": { "anisotropyStrength": 0.5, "anisotropyRotation": 1, "anisotropyTexture": texture },
        "KHR_materials_transmission": { "transmissionFactor": 0.5, "transmissionTexture": texture },
        "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0] },
        "KHR_materials_ior": { "ior": 1.4 }, "KHR_materials_emissive_strength": { "emissiveStrength": 3 },
        "KHR_materials_specular": { "specularFactor": 0.5, "specularTexture": texture, "specularColorTexture": texture } });
    let mut everything = textured(
        &png_bytes(2, &[[255, 0, 0, 255], [0, 255, 0, 128]]),
        json!({ "pbrMetallicRoughness": { "baseColorTexture": texture, "metallicRoughnessTexture": texture },
            "normalTexture": texture, "emissiveTexture": texture, "emissiveFactor": [1, 1, 1], "alphaMode": "MASK",
            "alphaCutoff": 0.3, "doubleSided": true, "extensions": extensions }),
    );
    everything.json["samplers"] = json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 10497 }]);
    everything.json["textures"][0]["sampler"] = json!(0);

    let glossy = json!({ "diffuseTexture": texture, "specularGlossinessTexture": texture, "glossinessFactor": 0.5,
        "diffuseFactor": [1, 0.5, 0.5, 1], "specularFactor": [0.2, 0.2, 0.2] });
    let glossy = textured(
        &png_bytes(1, &[[200, 100, 50, 25]]),
        json!({ "alphaMode": "BLEND", "extensions": { "KHR_materials_pbrSpecularGlossiness": glossy } }),
    );

    let mut lights = triangle();
    lights.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "color": [1, 0.5, 0], "intensity": 4 },
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } }, { "type": "directional" }] } });
    for light in 0..3 {
        lights.root(json!({ "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8],
            "extensions": { "KHR_lights_punctual": { "light": light } } }));
    }
    lights.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    lights.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 1, "znear": 0, "zfar": 9 } }),
    );
    for camera in 0..2 {
        let child = lights.push("nodes", json!({ "camera": camera, "scale": [2, 2, 2] }));
        lights.root(json!({ "children": [child], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1] }));
    }
    let (offsets, scales) = (lights.vectors(&[[0.0; 3], [0.0, 2.0, 0.0]]), lights.vectors(&[[1.0; 3], [2.0; 3]]));
    lights.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": offsets, "SCALE": scales } } });

    let mut morphed = Doc::new();
    let positions = morphed.vectors(&TETRAHEDRON);
    let normals = morphed.vectors(&[[0.0, 0.0, 1.0]; 4]);
    let triangles = morphed.indices(&TETRAHEDRON_INDICES);
    let (indices, values) = (morphed.view(&[1]), morphed.view(&[0; 12]));
    morphed.json["accessors"][1]["sparse"] = json!({ "count": 1,
        "indices": { "bufferView": indices, "componentType": U8 }, "values": { "bufferView": values } });
    let mesh = morphed.mesh(json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": triangles,
        "mode": 4, "targets": [{ "POSITION": normals, "NORMAL": positions }] }));
    morphed.json["meshes"][mesh]["weights"] = json!([0.5]);
    morphed.root(json!({ "mesh": mesh, "weights": [0.25] }));

    vec![
        everything,
        glossy,
        lights,
        morphed,
        image_lit(),
        compression::meshopt(),
        compression::draco_doc(&compression::draco(1, Some(14))),
    ]
}

/// Case `n`: a file and its name's end.
fn case(n: u64, whole: &[Doc]) -> (Vec<u8>, &'static str) {
    let mut random = Random::of(n);
    let doc = &whole[random.below(whole.len())];
    let (mut json, mut bin) = (doc.json.clone(), doc.bin.clone());
    if json.get("buffers").is_none() {
        json["buffers"] = json!([{ "byteLength": bin.len() }]);
    }
    let changes = 1 + random.below(4);
    for _ in 0..changes {
        match random.below(4) {
            0 => damage_bytes(&mut random, &mut bin),
            _ => damage_json(&mut random, &mut json),
        }
    }
    let mut text = json.to_string();
    if random.below(8) == 0 {
        // Numbers that no serialiser writes, and cut or doubled text.
        let mut bytes = text.into_bytes();
        damage_bytes(&mut random, &mut bytes);
        text = String::from_utf8_lossy(&bytes).into_owned();
    }
    let mut bytes = glb(&text, &bin);
    match random.below(8) {
        0 => damage_bytes(&mut random, &mut bytes),
        1 => return (text.into_bytes(), "gltf"),
        _ => {}
    }
    (bytes, "glb")
}

/// The number of the case that runs, and when the watch began to see it.
static RUNNING: AtomicU64 = AtomicU64::new(u64::MAX);

/// Ends the process if a case does not end: a test cannot be stopped from outside itself.
fn watch() {
    std::thread::spawn(|| {
        let (mut seen, mut since) = (u64::MAX, Instant::now());
        loop {
            std::thread::sleep(Duration::from_millis(500));
            let running = RUNNING.load(Relaxed);
            if running != seen {
                (seen, since) = (running, Instant::now());
            }
            if running != u64::MAX && since.elapsed() > 3 * LONGEST {
                eprintln!("case {running} does not end");
                std::process::abort();
            }
        }
    });
}

/// Runs cases from `first` on, until `enough` says so.
fn run(first: u64, enough: impl Fn(u64, Duration) -> bool) {
    watch();
    let whole = whole();
    for doc in &whole {
        doc.scene();
    }
    let folder = tempfile::tempdir().unwrap();
    let start = Instant::now();
    let (mut slowest, mut largest, mut read) = ((Duration::ZERO, 0), (0, 0), 0);
    let mut n = first;
    while !enough(n - first, start.elapsed()) {
        let (bytes, ending) = case(n, &whole);
        let path = folder.path().join(format!("damaged.{ending}"));
        std::fs::write(&path, &bytes).unwrap();
        RUNNING.store(n, Relaxed);
        let begin = Instant::now();
        allocations::begin();
        let outcome = std::panic::catch_unwind(|| import(&path));
        let peak = allocations::peak();
        let took = begin.elapsed();
        match outcome.unwrap_or_else(|_| panic!("case {n} panicked")) {
            Ok(scene) => {
                read += 1;
                check(&scene);
            }
            Err(error) => assert_eq!(error.exit_status(), 2, "case {n}: {error}"),
        }
        slowest = slowest.max((took, n));
        largest = largest.max((peak, n));
        assert!(took < LONGEST, "case {n} took {took:?}");
        assert!(peak < MOST_BYTES, "case {n} took {} MiB", peak >> 20);
        n += 1;
    }
    RUNNING.store(u64::MAX, Relaxed);
    let count = n - first;
    println!("{count} damaged files in {:.0?}, {read} of them read", start.elapsed());
    println!("slowest: {:.0?} (case {}); largest: {} KiB (case {})", slowest.0, slowest.1, largest.0 >> 10, largest.1);
}

#[test]
fn damaged_files_take_little() {
    run(0, |cases, time| time > Duration::from_secs(15) || cases >= 100_000);
}

#[test]
#[ignore = "takes minutes; ./run test --long"]
fn long_damaged_files_take_little() {
    run(1 << 32, |cases, _| cases >= 1_200_000);
}
