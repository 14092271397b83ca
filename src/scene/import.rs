//! From a glTF 2.0 file to a [`Scene`].
//!
//! The `gltf` crate gives the JSON its types; its validation is not used, since it refuses files whose geometry is fine.
//! Instead, everything that is read is checked where it is read: [`accessor`] bounds, [`nodes`] cycles, [`mesh`] indices.

mod accessor;
mod camera;
mod closed;
mod draco;
mod file;
mod glossiness;
mod image;
mod image_light;
mod light;
mod material;
mod mesh;
mod meshopt;
mod nodes;
mod notes;
mod place;
mod tangents;
mod texture;
mod view;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DAffine3, Vec3};
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;

use self::file::File;
use self::material::{Converted, Refraction};
use self::mesh::{Triangles, Wanted};
use self::nodes::Instances;
use self::notes::{Feature, Notes};
use self::texture::{Images, Reader};
use crate::Error;
use crate::scene::{Environment, Material, Scene};

/// Said where a sky is made up.
pub(super) const NO_LIGHT: &str = "The file has no light that can be rendered: a white sky of radiance 1 is added.";
/// Most triangles in a scene, so that a small file of many instances cannot fill the memory: 1.4 GiB at worst.
const MAX_TRIANGLES: u64 = 1 << 24;
/// Extensions that a file may require: the import either honours them or has a sentence of its own about them.
const KNOWN: [&str; 20] = [
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

/// Reads a .gltf or .glb file: the default scene with its cameras and materials, in world space and the file's units.
///
/// What the renderer cannot do yet is left out and said in [`Scene::warnings`].
/// A file without a camera gets a framed one called "default"; a file without a light gets a white sky.
///
/// # Errors
/// [`Error::Input`] with one sentence that names the file and the element: unreadable or malformed files, damaged
/// compressed data or images, degenerate cameras, positions that are not finite, no triangles at all, or more than can be rendered.
pub fn import(path: &Path) -> crate::Result<Scene> {
    let of_file = |why| Error::input(format!("{} {why}", path.display()));
    let of_element = |why| Error::input(format!("{}: {why}", path.display()));
    let file = File::open(path).map_err(of_file)?;
    let mut importer = Importer::new(&file);
    importer.scene.name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    for node in nodes::placed(&file).map_err(of_element)? {
        importer.add_node(node.index, node.world_from_node).map_err(of_element)?;
    }
    importer.finish().map_err(of_file)
}

/// The scene as it grows, node by node.
struct Importer<'a> {
    file: &'a File,
    scene: Scene,
    notes: Notes,
    images: Images,
    /// The file's materials that are in use (None: glTF's default one), converted once.
    converted: HashMap<Option<usize>, Converted>,
    /// Those of vertices that have colours.
    colored: HashSet<Option<usize>>,
    /// Index into the scene's materials, by the file's material and whether it is thin.
    placed_materials: HashMap<(Option<usize>, bool), u32>,
    /// Whether the triangles of a mesh that have a material are closed.
    closed: HashMap<(usize, Option<usize>), bool>,
    /// Triangles read so far, dropped ones included.
    triangles_read: u64,
}

impl<'a> Importer<'a> {
    fn new(file: &'a File) -> Self {
        let primitives = file.root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let colored = primitives
            .filter(|p| p.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))))
            .map(|p| p.material.map(|material| material.value()))
            .collect();
        Self {
            file,
            scene: Scene::default(),
            notes: Notes::default(),
            images: Images::default(),
            converted: HashMap::new(),
            colored,
            placed_materials: HashMap::new(),
            closed: HashMap::new(),
            triangles_read: 0,
        }
    }

    /// Adds what a node of the file holds.
    fn add_node(&mut self, index: usize, world_from_node: DAffine3) -> Result<(), String> {
        let node = &self.file.root.nodes[index];
        if let Some(light) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) {
            self.scene.lights.extend(light::convert(self.file, light.light.value(), world_from_node)?);
        }
        if let Some(camera) = node.camera {
            self.add_camera(camera.value(), node.name.as_deref(), world_from_node)?;
        }
        if let Some(mesh) = node.mesh {
            let instances = Instances::new(self.file, index)?;
            for i in 0..instances.count {
                self.add_mesh(mesh.value(), node.weights.as_deref(), world_from_node * instances.at(i))?;
            }
        }
        Ok(())
    }

    fn add_camera(&mut self, index: usize, node_name: Option<&str>, world_from_node: DAffine3) -> Result<(), String> {
        let path = format!("cameras[{index}]");
        let Some(json) = self.file.root.cameras.get(index) else {
            return Err(format!("{path} does not exist: export the file again"));
        };
        let name = json.name.as_deref().or(node_name).filter(|name| !name.is_empty());
        let name = name.map_or_else(|| format!("camera {}", self.scene.cameras.len()), str::to_string);
        let called = format!("{path} ('{name}')");
        match camera::convert(json, self.unused_camera_name(name), world_from_node) {
            Ok(camera) => self.scene.cameras.push(camera),
            Err(why) => return Err(format!("{called}: {why}")),
        }
        Ok(())
    }

    /// `name`, numbered if another camera has it: cameras are chosen by name.
    fn unused_camera_name(&self, name: String) -> String {
        let taken = |name: &str| self.scene.cameras.iter().any(|camera| camera.name == name);
        let numbered = (2..).map(|n| format!("{name} {n}"));
        std::iter::once(name.clone()).chain(numbered).find(|name| !taken(name)).unwrap_or(name)
    }

    fn add_mesh(&mut self, index: usize, weights: Option<&[f32]>, world_from_mesh: DAffine3) -> Result<(), String> {
        let path = format!("meshes[{index}]");
        let Some(mesh) = self.file.root.meshes.get(index) else {
            return Err(format!("{path} does not exist: export the file again"));
        };
        let weights = weights.or(mesh.weights.as_deref()).unwrap_or(&[]);
        let mut parts = Vec::new();
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let path = format!("{path}.primitives[{i}]");
            let room = MAX_TRIANGLES.saturating_sub(self.triangles_read);
            let material = primitive.material.map(|material| material.value());
            let file = self.file;
            let converted = self.converted(material)?;
            let wanted = Wanted {
                coordinates: &converted.coordinates,
                tangents: converted.material.tangent_slot().is_some(),
                colors: converted.material.vertex_colored,
            };
            let triangles =
                mesh::triangles(file, primitive, weights, &wanted, room).map_err(|why| format!("{path}: {why}"))?;
            let Some(triangles) = triangles else {
                self.notes.add(Feature::PointsOrLines, index);
                continue;
            };
            self.triangles_read += triangles.corners.len() as u64;
            parts.push((path, triangles, material));
        }
        for (path, triangles, material) in &parts {
            let thin = match self.converted(*material)?.refraction {
                Refraction::Thin => true,
                Refraction::Solid => false,
                Refraction::WhereClosed => {
                    let parts = || parts.iter().map(|(_, triangles, material)| (triangles, *material));
                    let closed = || closed(parts().filter(|part| part.1 == *material)) || closed(parts());
                    !*self.closed.entry((index, *material)).or_insert_with(closed)
                }
            };
            let material = self.placed_material(*material, thin)?;
            let dropped = place::add_triangles(&mut self.scene, triangles, material, world_from_mesh);
            self.notes.flat_triangles += dropped.map_err(|why| format!("{path}: {why}"))?;
        }
        Ok(())
    }

    /// The file's material, converted.
    fn converted(&mut self, index: Option<usize>) -> Result<&Converted, String> {
        if !self.converted.contains_key(&index) {
            let colored = self.colored.contains(&index);
            let converted = match index {
                None => {
                    let material = Material { vertex_colored: colored, ..Material::default() };
                    Converted { material, refraction: Refraction::Thin, coordinates: Vec::new() }
                }
                Some(material) => {
                    let path = format!("materials[{material}]");
                    let (Some(json), Some(raw)) =
                        (self.file.root.materials.get(material), self.file.raw("materials").get(material))
                    else {
                        return Err(format!("{path} does not exist: export the file again"));
                    };
                    let (file, images, notes) = (self.file, &mut self.images, &mut self.notes);
                    let reader = Reader { file, images, notes, material, sets: Vec::new() };
                    material::convert(json, raw, colored, reader).map_err(|why| format!("{path}: {why}"))?
                }
            };
            self.converted.insert(index, converted);
        }
        Ok(&self.converted[&index])
    }

    /// Index of the scene's material; a material used both thin and solid becomes two.
    fn placed_material(&mut self, index: Option<usize>, thin: bool) -> Result<u32, String> {
        if let Some(&placed) = self.placed_materials.get(&(index, thin)) {
            return Ok(placed);
        }
        let mut material = Material { thin, ..self.converted(index)?.material.clone() };
        if self.placed_materials.contains_key(&(index, !thin)) {
            material.name += if thin { " (thin)" } else { " (solid)" };
        }
        let placed = self.scene.materials.len() as u32;
        self.scene.materials.push(material);
        self.placed_materials.insert((index, thin), placed);
        Ok(placed)
    }

    /// The scene with what only the whole of it tells: its lights, its warnings, a camera if it has none.
    fn finish(self) -> Result<Scene, String> {
        let Self { file, mut scene, notes, mut images, .. } = self;
        if scene.triangles.is_empty() {
            return Err("has no triangles to render in its default scene: export it with meshes".into());
        }
        scene.warnings = notes.sentences();
        scene.complete_attributes();
        let is_srgb = |image: u32| {
            let mut uses = scene.materials.iter().flat_map(|m| m.textures.all()).filter(|t| t.image == image);
            uses.all(|texture| texture.srgb)
        };
        let halved = images.fit(is_srgb);
        if halved > 0 {
            scene.warnings.push(format!(
                "The images have more than the {} million texels that can be rendered: {halved} of them made smaller.",
                texture::MAX_TEXELS >> 20
            ));
        }
        scene.images = images.images;
        match image_light::convert(file) {
            Ok(environment) => scene.environment = environment,
            Err(why) => {
                scene.warnings.push(format!("The image-based light (EXT_lights_image_based) is left out: {why}."));
            }
        }
        for name in &file.root.extensions_required {
            if !KNOWN.contains(&name.as_str()) && !notes::MATERIAL_EXTENSIONS.iter().any(|(known, _)| known == name) {
                scene.warnings.push(format!(
                    "The file needs the glTF extension {name}, which is not supported: it may look wrong."
                ));
            }
        }
        // Of the materials in use: one whose triangles were all dropped lights nothing. Unlit ones are not meant to.
        let material = |triangle: usize| &scene.materials[scene.triangle_materials[triangle] as usize];
        let emission = scene.mean_emission();
        let lit = |unlit: bool| emission.iter().enumerate().any(|(t, e)| *e > 0.0 && material(t).unlit == unlit);
        if scene.lights.is_empty() && scene.environment.is_none() && !lit(false) {
            if lit(true) {
                // A sky beside other light is an image.
                scene.environment = Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] });
            } else {
                scene.sky = Some(Vec3::ONE);
            }
            scene.warnings.push(NO_LIGHT.into());
        }
        if scene.cameras.is_empty() {
            scene.cameras.push(camera::framed(&scene));
            scene.warnings.push("The file has no camera: one that sees the whole scene is added.".into());
        }
        for path in file.read.take() {
            if !scene.files.contains(&path) {
                scene.files.push(path);
            }
        }
        Ok(scene)
    }
}

/// Whether the triangles of some primitives together enclose a volume.
fn closed<'a>(parts: impl Iterator<Item = (&'a Triangles<'a>, Option<usize>)> + Clone) -> bool {
    closed::is_closed(
        parts.flat_map(|(part, _)| part.corners.iter().map(|corners| corners.map(|vertex| part.positions.at(vertex)))),
    )
}
