//! A scene in a folder of its own, and what is checked of every refusal.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use tempfile::TempDir;

/// One emissive triangle and a camera called `Main` that sees it, as a glTF with its data inside.
fn write_scene(path: &Path) {
    use base64::Engine;
    let corners: [f32; 9] = [-1.0, -1.0, -3.0, 1.0, -1.0, -3.0, 0.0, 1.0, -3.0];
    let normals: [f32; 9] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = corners.iter().chain(&normals).flat_map(|v| v.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let scene = serde_json::json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "name": "Main", "camera": 0 }],
        "cameras": [{
            "name": "Main",
            "type": "perspective",
            "perspective": { "yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5 }
        }],
        "materials": [{
            "name": "light",
            "emissiveFactor": [1.0, 1.0, 1.0],
            "pbrMetallicRoughness": { "metallicFactor": 0.0 }
        }],
        "meshes": [{
            "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "material": 0 }]
        }],
        "buffers": [{
            "byteLength": 72,
            "uri": format!("data:application/octet-stream;base64,{data}")
        }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 36 }
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [-1.0, -1.0, -3.0], "max": [1.0, 1.0, -3.0]
            },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" }
        ]
    });
    fs::write(path, scene.to_string()).unwrap();
}

/// A folder of its own for one test, with `scene.gltf` in it; commands run there.
pub struct Place {
    pub folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_scene(&folder.path().join("scene.gltf"));
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("emlt").unwrap();
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Every file and folder here, at any depth, sorted.
    pub fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, list: &mut Vec<String>) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                list.push(path.strip_prefix(root).unwrap().to_string_lossy().into_owned());
                if path.is_dir() {
                    walk(&path, root, list);
                }
            }
        }
        let mut list = Vec::new();
        walk(self.folder.path(), self.folder.path(), &mut list);
        list.sort();
        list
    }

    /// The command must fail with `status`, say `words` in one sentence, and leave the folder as it was.
    #[track_caller]
    pub fn refuses(&self, arguments: &[&str], status: i32, words: &str) {
        let before = self.files();
        let output = self.run(arguments);
        check_failure(&output, status, words);
        assert_eq!(self.files(), before, "files after {arguments:?}");
    }
}

#[track_caller]
pub fn check_failure(output: &Output, status: i32, words: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{said}");
    assert!(said.starts_with("error: ") && said.ends_with('\n'), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.contains(words), "{words:?} is not in: {said}");
    assert!(!said.contains("panicked") && !said.contains("internal fault"), "{said}");
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
}
