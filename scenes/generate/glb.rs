//! Writes glTF 2.0 binary files: one buffer, one node per object, everything in world space.

use crate::mesh::Mesh;
use glam::{Mat3, Quat, Vec3};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// What the renderer knows of glTF materials; the constructors are the only kinds the scenes use.
#[derive(Debug, Clone)]
pub struct Material {
    name: String,
    base_color: [f32; 3],
    metallic: f32,
    roughness: f32,
    emission: Option<([f32; 3], f32)>,
    extensions: Value,
    /// Slot, as the file calls it, and number of the texture.
    textures: Vec<(&'static str, usize)>,
}

impl Material {
    /// Exactly albedo/pi: metallic 0 and no specular lobe.
    pub fn lambert(name: &str, albedo: [f32; 3]) -> Self {
        let extensions = json!({"KHR_materials_specular": {"specularFactor": 0.0}});
        let (name, base_color) = (name.to_string(), albedo);
        Self { name, base_color, metallic: 0.0, roughness: 1.0, emission: None, extensions, textures: vec![] }
    }

    /// The default dielectric: diffuse below a GGX surface of ior 1.5 with alpha = roughness^2.
    pub fn glossy(name: &str, albedo: [f32; 3], roughness: f32) -> Self {
        let (name, base_color, extensions) = (name.to_string(), albedo, json!({}));
        Self { name, base_color, metallic: 0.0, roughness, emission: None, extensions, textures: vec![] }
    }

    /// A GGX conductor with alpha = roughness^2 and `tint` as its reflectance at normal incidence.
    pub fn metal(name: &str, tint: [f32; 3], roughness: f32) -> Self {
        let (name, base_color, extensions) = (name.to_string(), tint, json!({}));
        Self { name, base_color, metallic: 1.0, roughness, emission: None, extensions, textures: vec![] }
    }

    /// Smooth glass for closed meshes; `tint` multiplies once per interface that light crosses.
    pub fn glass(name: &str, tint: [f32; 3], ior: f32) -> Self {
        let extensions = json!({
            "KHR_materials_ior": {"ior": decimal(ior)},
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            // Any thickness above zero says "a volume, so refract"; nothing is absorbed inside.
            "KHR_materials_volume": {"thicknessFactor": 1.0},
        });
        let (name, base_color) = (name.to_string(), tint);
        Self { name, base_color, metallic: 0.0, roughness: 0.0, emission: None, extensions, textures: vec![] }
    }

    /// The same with a GGX surface of alpha = roughness^2 on both its reflection and its transmission.
    pub fn rough_glass(name: &str, tint: [f32; 3], ior: f32, roughness: f32) -> Self {
        Self { roughness, ..Self::glass(name, tint, ior) }
    }

    /// A black body of radiance `color * strength` on its front side; `color` is at most 1.
    pub fn lamp(name: &str, color: [f32; 3], strength: f32) -> Self {
        Self::lambert(name, [0.0; 3]).emitting(color, strength)
    }

    pub fn emitting(mut self, color: [f32; 3], strength: f32) -> Self {
        self.emission = Some((color, strength));
        self.extensions["KHR_materials_emissive_strength"] = json!({"emissiveStrength": decimal(strength)});
        self
    }

    /// The same with a texture in a slot such as "baseColorTexture".
    pub fn painted(mut self, slot: &'static str, texture: usize) -> Self {
        self.textures.push((slot, texture));
        self
    }

    /// The same with an extension's parameters.
    pub fn with(mut self, extension: &str, parameters: Value) -> Self {
        self.extensions[extension] = parameters;
        self
    }

    fn json(&self) -> Value {
        let [r, g, b] = self.base_color.map(decimal);
        let mut material = json!({
            "name": self.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": decimal(self.metallic),
                "roughnessFactor": decimal(self.roughness),
            },
        });
        if let Some((color, _)) = self.emission {
            material["emissiveFactor"] = json!(color.map(decimal));
        }
        for (slot, texture) in &self.textures {
            let owner = if *slot == "emissiveTexture" { &mut material } else { &mut material["pbrMetallicRoughness"] };
            owner[*slot] = json!({"index": texture});
        }
        if self.extensions.as_object().is_some_and(|e| !e.is_empty()) {
            material["extensions"] = self.extensions.clone();
        }
        material
    }
}

/// The f64 whose decimals are those of `x`: keeps 0.1 from being written as 0.10000000149.
fn decimal(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

/// A scene under construction.
#[derive(Debug, Default)]
pub struct Document {
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    bytes: Vec<u8>,
    triangles: usize,
}

impl Document {
    pub fn material(&mut self, material: Material) -> usize {
        self.materials.push(material.json());
        self.materials.len() - 1
    }

    /// A texture `width` texels wide, rows from the top, bytes as the file has them; `wrap` by the file's numbers.
    pub fn texture(&mut self, width: u32, texels: &[[u8; 3]], linear: bool, wrap: u32) -> usize {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, texels.len() as u32 / width);
        encoder.set_color(png::ColorType::Rgb);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(texels.as_flattened()));
        written.expect("whole rows are written to memory");
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": file.len()}));
        self.bytes.extend(file);
        pad(&mut self.bytes, 0);
        self.images.push(json!({"bufferView": self.views.len() - 1, "mimeType": "image/png"}));
        let filter = if linear { 9729 } else { 9728 };
        self.samplers.push(json!({"magFilter": filter, "minFilter": filter, "wrapS": wrap, "wrapT": wrap}));
        self.images.len() - 1
    }

    pub fn object(&mut self, name: &str, mesh: &Mesh, material: usize) {
        self.add(name, mesh, material, None);
    }

    /// The same with texture coordinates, by position and normal.
    pub fn painted_object(
        &mut self,
        name: &str,
        mesh: &Mesh,
        material: usize,
        coordinates: impl Fn(Vec3, Vec3) -> [f32; 2],
    ) {
        let all = mesh.positions.iter().zip(&mesh.normals).map(|(p, n)| coordinates(*p, *n)).collect();
        self.add(name, mesh, material, Some(all));
    }

    fn add(&mut self, name: &str, mesh: &Mesh, material: usize, coordinates: Option<Vec<[f32; 2]>>) {
        self.triangles += mesh.triangles.len();
        let flat = |v: &[Vec3]| -> Vec<u8> { v.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect() };
        let low = mesh.positions.iter().copied().reduce(Vec3::min).expect("a mesh has vertices");
        let high = mesh.positions.iter().copied().reduce(Vec3::max).expect("a mesh has vertices");
        let positions = self.accessor(&flat(&mesh.positions), 5126, mesh.positions.len(), "VEC3");
        self.accessors[positions]["min"] = json!(low.to_array());
        self.accessors[positions]["max"] = json!(high.to_array());
        let normals = self.accessor(&flat(&mesh.normals), 5126, mesh.normals.len(), "VEC3");
        let indices: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        // 65535 is the primitive-restart value, which glTF forbids as an index.
        let short = mesh.positions.len() <= 65535;
        let bytes: Vec<u8> = if short {
            indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect()
        } else {
            indices.iter().flat_map(|&i| i.to_le_bytes()).collect()
        };
        let indices = self.accessor(&bytes, if short { 5123 } else { 5125 }, indices.len(), "SCALAR");
        let mut attributes = json!({"POSITION": positions, "NORMAL": normals});
        if let Some(coordinates) = coordinates {
            let bytes: Vec<u8> = coordinates.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            attributes["TEXCOORD_0"] = json!(self.accessor(&bytes, 5126, coordinates.len(), "VEC2"));
        }
        self.meshes.push(json!({"name": name, "primitives": [{
            "attributes": attributes,
            "indices": indices,
            "material": material,
        }]}));
        self.nodes.push(json!({"name": name, "mesh": self.meshes.len() - 1}));
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, shape: &str) -> usize {
        let target = if shape == "SCALAR" { 34963 } else { 34962 };
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        pad(&mut self.bytes, 0);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": shape,
        }));
        self.accessors.len() - 1
    }

    /// A camera at `eye` that looks at `target`, 4:3, with the vertical field of view in degrees.
    pub fn camera(&mut self, name: &str, eye: Vec3, target: Vec3, vertical_fov_deg: f32) {
        let back = (eye - target).normalize();
        let right = upright(back).cross(back).normalize();
        let rotation = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back));
        self.cameras.push(json!({"name": name, "type": "perspective", "perspective": {
            "yfov": decimal(vertical_fov_deg.to_radians()), "aspectRatio": 4.0 / 3.0, "znear": 0.01,
        }}));
        self.nodes.push(json!({
            "name": name, "camera": self.cameras.len() - 1,
            "rotation": rotation.normalize().to_array().map(decimal),
            "translation": eye.to_array().map(decimal),
        }));
    }

    pub fn objects(&self) -> usize {
        self.meshes.len()
    }

    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// The whole file.
    pub fn finish(self) -> Vec<u8> {
        let used: BTreeSet<&String> =
            self.materials.iter().filter_map(|m| m["extensions"].as_object()).flat_map(|e| e.keys()).collect();
        let mut root = json!({
            "asset": {"version": "2.0", "generator": "emlt scenes/generate"},
            "scene": 0,
            "scenes": [{"nodes": (0..self.nodes.len()).collect::<Vec<_>>()}],
            "nodes": self.nodes, "meshes": self.meshes, "materials": self.materials,
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len()}],
        });
        if !used.is_empty() {
            root["extensionsUsed"] = json!(used);
        }
        if !self.images.is_empty() {
            let textures: Vec<Value> = (0..self.images.len()).map(|i| json!({"source": i, "sampler": i})).collect();
            root["textures"] = json!(textures);
            root["images"] = json!(self.images);
            root["samplers"] = json!(self.samplers);
        }
        if !self.cameras.is_empty() {
            root["cameras"] = json!(self.cameras);
        }
        let mut text = root.to_string().into_bytes();
        pad(&mut text, b' ');
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut file = Vec::with_capacity(total);
        file.extend(b"glTF");
        file.extend(2u32.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }
}

/// An up vector for a view along the unit vector `axis`: +y, or -z where the view is straight down.
fn upright(axis: Vec3) -> Vec3 {
    if axis.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y }
}

/// glTF wants chunks and accessors on four-byte boundaries.
fn pad(bytes: &mut Vec<u8>, with: u8) {
    while !bytes.len().is_multiple_of(4) {
        bytes.push(with);
    }
}
