//! The file itself: the .glb container, the JSON, and the buffers it points to, loaded when first asked for.

use std::cell::{Cell, OnceCell, RefCell};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use draco_core::Mesh;
use gltf::json::{self, Root, Value};

/// Parts of the JSON that are not read, or only by hand ([`File::raw`]). They are dropped before the JSON is typed, so that
/// nothing odd in them (a texture without a source, an animation that breaks a rule) can refuse a file whose geometry is
/// fine.
const UNTYPED: [&str; 6] = ["animations", "extensions", "images", "samplers", "skins", "textures"];

/// Most bytes that all compressed data of a file may become: twice what [`super::MAX_TRIANGLES`] need as a rule.
const MAX_UNPACKED: u64 = 1 << 31;

/// A parsed glTF file and its binary data.
pub struct File {
    pub root: Root,
    /// The JSON as it is, without its bulk: what [`File::raw`] looks up.
    json: Value,
    /// Folder that relative URIs start from.
    folder: PathBuf,
    /// The BIN chunk of a .glb.
    bin: Option<Vec<u8>>,
    /// One per buffer, filled on first use.
    buffers: Vec<OnceCell<Vec<u8>>>,
    /// One per buffer view, filled on first use of one that is compressed.
    pub(super) unpacked: Vec<OnceCell<Vec<u8>>>,
    /// One per buffer view, filled on first use of one that holds Draco data.
    pub(super) draco_meshes: Vec<OnceCell<Mesh>>,
    /// Bytes that decompression may still take, all of it together.
    pub(super) room: Cell<u64>,
    /// The files that were read, this one first; each time one was.
    pub(super) read: RefCell<Vec<PathBuf>>,
}

impl File {
    /// Reads and parses the file; errors are sentences without the file's name.
    pub fn open(path: &Path) -> Result<Self, String> {
        let bytes = read_at_most(path, u64::MAX)?;
        let (json, bin) = if bytes.starts_with(b"glTF") {
            split_glb(&bytes)?
        } else {
            (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes), None)
        };
        let (root, json) = parse(json)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(Self {
            folder,
            bin: bin.map(<[u8]>::to_vec),
            buffers: root.buffers.iter().map(|_| OnceCell::new()).collect(),
            unpacked: root.buffer_views.iter().map(|_| OnceCell::new()).collect(),
            draco_meshes: root.buffer_views.iter().map(|_| OnceCell::new()).collect(),
            room: Cell::new(MAX_UNPACKED),
            read: RefCell::new(vec![path.to_path_buf()]),
            root,
            json,
        })
    }

    /// The elements of a top-level array of the JSON, untyped: materials, textures, samplers or images.
    pub fn raw(&self, key: &str) -> &[Value] {
        self.json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// A top-level extension of the JSON, untyped.
    pub fn extension(&self, name: &str) -> Option<&Value> {
        self.json.get("extensions").and_then(|extensions| extensions.get(name))
    }

    /// The bytes of `buffers[index]`, which may be fewer or more than its byteLength says.
    pub fn buffer(&self, index: usize) -> Result<&[u8], String> {
        let (Some(buffer), Some(cell)) = (self.root.buffers.get(index), self.buffers.get(index)) else {
            return Err(format!("buffers[{index}] does not exist: export the file again"));
        };
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        match (&buffer.uri, &self.bin) {
            (Some(uri), _) => {
                let bytes = self.load(uri, buffer.byte_length.0).map_err(|why| format!("buffers[{index}]: {why}"))?;
                Ok(cell.get_or_init(|| bytes))
            }
            (None, Some(bin)) if index == 0 => Ok(bin),
            _ => Err(format!("buffers[{index}] has neither a uri nor a BIN chunk: export the file again")),
        }
    }

    /// The bytes of a buffer's URI: embedded data, or at most `length` bytes of a file beside this one.
    pub(super) fn load(&self, uri: &str, length: u64) -> Result<Vec<u8>, String> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (media, data) = data.split_once(',').ok_or("its data: URI has no comma: export the file again")?;
            if !media.ends_with(";base64") {
                return Ok(percent_decoded(data));
            }
            return base64::engine::general_purpose::STANDARD
                .decode(data)
                .map_err(|why| format!("its data: URI is not base64 ({why}): export the file again"));
        }
        if uri.contains("://") {
            return Err(format!("it lies at {uri}: put it beside the scene file and write its relative name"));
        }
        let name = String::from_utf8(percent_decoded(uri)).map_err(|_| format!("its uri '{uri}' is not UTF-8"))?;
        let path = self.folder.join(name);
        let bytes = read_at_most(&path, length).map_err(|why| format!("{} {why}", path.display()))?;
        self.read.borrow_mut().push(path);
        Ok(bytes)
    }
}

/// The first `length` bytes of a regular file; pipes and devices could block or never end, so they are refused.
fn read_at_most(path: &Path, length: u64) -> Result<Vec<u8>, String> {
    let readable = |why: std::io::Error| format!("cannot be read ({why})");
    if !fs::metadata(path).map_err(readable)?.is_file() {
        return Err("is not a file: name a regular file".into());
    }
    let mut bytes = Vec::new();
    fs::File::open(path).map_err(readable)?.take(length).read_to_end(&mut bytes).map_err(readable)?;
    Ok(bytes)
}

/// The JSON and BIN chunks of a .glb (glTF 2.0, section 4.4).
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let cut = || "is cut short: copy or export it again".to_string();
    let word = |at: usize| -> Result<u32, String> {
        let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        four.map(u32::from_le_bytes).ok_or_else(cut)
    };
    let version = word(4)?;
    if version != 2 {
        return Err(format!("is a version {version} .glb: export it as glTF 2.0"));
    }
    let length = word(8)? as usize;
    let bytes = bytes.get(..length).ok_or_else(cut)?;
    let chunk = |at: usize| -> Result<&[u8], String> {
        let length = word(at)? as usize;
        bytes.get(at + 8..).and_then(|rest| rest.get(..length)).ok_or_else(cut)
    };
    let json = chunk(12)?;
    if word(16)? != u32::from_le_bytes(*b"JSON") {
        return Err("does not begin with a JSON chunk: export it again".into());
    }
    let next = 20 + json.len().next_multiple_of(4);
    // A BIN chunk is always the second one; others may follow and are to be ignored.
    if next + 8 <= length && word(next + 4)? == u32::from_le_bytes(*b"BIN\0") {
        return Ok((json, Some(chunk(next)?)));
    }
    Ok((json, None))
}

/// The typed JSON and what [`File::raw`] needs of it untyped, or a sentence that says which element is wrong.
fn parse(json: &[u8]) -> Result<(Root, Value), String> {
    let mut value: Value = json::deserialize::from_slice(json)
        .map_err(|why| format!("is not JSON ({why}): export it as glTF 2.0 again"))?;
    strip_extras(&mut value);
    let Value::Object(object) = &mut value else {
        return Err("is not a JSON object: export it as glTF 2.0 again".into());
    };
    let version = object.get("asset").and_then(|asset| asset.get("version")).and_then(Value::as_str);
    if !version.is_some_and(|v| v.starts_with("2.")) {
        let found = version.map_or("none".into(), |v| format!("{v:.16}"));
        return Err(format!("has asset.version {found}, not 2.0: export it as glTF 2.0"));
    }
    let mut untyped = Value::Object(Default::default());
    for key in UNTYPED {
        if let Some(part) = object.remove(key) {
            untyped[key] = part;
        }
    }
    if let Some(materials) = object.get("materials") {
        untyped["materials"] = materials.clone();
    }
    // An empty scene may leave its nodes out; the parser insists on them.
    for scene in object.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Value::Object(scene) = scene {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let root = json::deserialize::from_value(value.clone()).map_err(|why| {
        let element = misfit(&value).unwrap_or_default();
        format!("has {element}contents that glTF 2.0 does not allow ({why}): export it again")
    })?;
    Ok((root, untyped))
}

/// `extras` is free-form, is never read, and trips the parser inside some extensions.
fn strip_extras(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.remove("extras");
            object.values_mut().for_each(strip_extras);
        }
        Value::Array(array) => array.iter_mut().for_each(strip_extras),
        _ => {}
    }
}

/// The path of the first element that does not parse on its own.
fn misfit(root: &Value) -> Option<String> {
    macro_rules! fits {
        ($kind:ty) => {
            |value| json::deserialize::from_value::<$kind>(value.clone()).is_ok()
        };
    }
    type Fits = fn(&Value) -> bool;
    let checks: [(&str, Fits); 8] = [
        ("accessors", fits!(json::Accessor)),
        ("bufferViews", fits!(json::buffer::View)),
        ("buffers", fits!(json::Buffer)),
        ("cameras", fits!(json::Camera)),
        ("materials", fits!(json::Material)),
        ("meshes", fits!(json::Mesh)),
        ("nodes", fits!(json::Node)),
        ("scenes", fits!(json::Scene)),
    ];
    checks.iter().find_map(|(key, fits)| {
        let index = root.get(key)?.as_array()?.iter().position(|element| !fits(element))?;
        Some(format!("in {key}[{index}] "))
    })
}

/// `text` with each %XX replaced by its byte.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let hex = |at: usize| bytes.get(at).and_then(|b| (*b as char).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], hex(at + 1), hex(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((16 * high + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    decoded
}
