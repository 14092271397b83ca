//! The scene as plain data: what a renderer needs to know, in the file's own units, independent of file format and device.

pub mod albedo;
pub mod camera;
mod culling;
pub mod environment;
pub mod features;
pub mod import;
pub mod light;
pub mod material;
pub mod sheen;
pub mod texture;

use std::path::PathBuf;

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};

pub use camera::{Camera, Lens};
pub use features::Features;
pub use light::{Environment, Light};
pub use material::Material;
pub use texture::{Image, Texture};

/// Weights of linear Rec.709 in luminance.
pub const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// About so many look-ups find the means of all triangles whose emission is textured.
const MEAN_POINTS: f64 = 16e6;

/// A triangle soup with materials, cameras and an optional uniform sky.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Name for messages and metadata: the file's stem.
    pub name: String,
    /// What it was read from: the file itself first, then the buffers and images beside it.
    pub files: Vec<PathBuf>,
    /// World positions, in the file's units.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, two sets for each position; empty where no material has textures.
    pub coordinates: Vec<[Vec2; 2]>,
    /// Unit tangents and the sign of the bitangent (glTF 2.0, section 3.7.2.1), one per position; empty where no material
    /// has a normal texture.
    pub tangents: Vec<Vec4>,
    /// Linear colours, one per position; empty where no material is multiplied by them.
    pub colors: Vec<Vec4>,
    /// Counter-clockwise seen from the front; indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials`, one per triangle.
    pub triangle_materials: Vec<u32>,
    pub materials: Vec<Material>,
    /// What the materials' textures show.
    pub images: Vec<Image>,
    /// The file's cameras; never empty after import (a framed one is made).
    pub cameras: Vec<Camera>,
    /// Radiance of a uniform sky around the scene (linear Rec.709); set only where the file has no light at all.
    pub sky: Option<Vec3>,
    /// Radiance from all around instead of `sky`.
    pub environment: Option<Environment>,
    /// Points, spots and directions.
    pub lights: Vec<Light>,
    /// What the import left out or made up, one sentence each, each said once.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Centre and radius of a sphere around all positions (of the bounding box, so not the smallest one).
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let mut low = Vec3::splat(f32::INFINITY);
        let mut high = Vec3::splat(f32::NEG_INFINITY);
        for p in &self.positions {
            low = low.min(*p);
            high = high.max(*p);
        }
        (0.5 * (low + high), 0.5 * (high - low).length())
    }

    /// Puts an environment around the scene, in place of a sky that the import made up for want of a light.
    pub fn set_environment(&mut self, environment: Environment) {
        self.sky = None;
        self.environment = Some(environment);
        self.warnings.retain(|warning| warning != import::NO_LIGHT);
    }

    /// Gives attributes that only some vertices needed to all of them.
    fn complete_attributes(&mut self) {
        let n = self.positions.len();
        if !self.coordinates.is_empty() {
            self.coordinates.resize(n, [Vec2::ZERO; 2]);
        }
        if !self.tangents.is_empty() {
            self.tangents.resize(n, Vec4::ZERO);
        }
        if !self.colors.is_empty() {
            self.colors.resize(n, Vec4::ONE);
        }
    }

    /// Mean luminance of what each triangle emits, over its area and on a side that emits; in the units of
    /// [`Material::emission`].
    pub fn mean_emission(&self) -> Vec<f64> {
        let material = |triangle: usize| &self.materials[self.triangle_materials[triangle] as usize];
        let mapped = |m: &Material| m.emits() && m.textures.emissive.is_some();
        let count = (0..self.triangles.len()).filter(|&triangle| mapped(material(triangle))).count();
        let finest = (MEAN_POINTS / count.max(1) as f64).sqrt().clamp(4.0, 512.0);
        let of = |triangle: usize| {
            let factor = material(triangle).emission.as_dvec3() * self.emission_color(triangle);
            match &material(triangle).textures.emissive {
                Some(texture) if material(triangle).emits() => {
                    self.mean_textured_emission(triangle, texture, factor, finest)
                }
                _ => factor.dot(LUMINANCE),
            }
        };
        (0..self.triangles.len()).map(of).collect()
    }

    /// The mean of the vertices' colours where they are the light's; apart from the texture's, since any positive estimate
    /// serves for choosing lights.
    fn emission_color(&self, triangle: usize) -> DVec3 {
        let material = &self.materials[self.triangle_materials[triangle] as usize];
        if !(material.unlit && material.vertex_colored) {
            return DVec3::ONE;
        }
        let color = |vertex: u32| self.colors.get(vertex as usize).map_or(DVec3::ONE, |c| c.truncate().as_dvec3());
        self.triangles[triangle].map(color).into_iter().sum::<DVec3>() / 3.0
    }

    fn mean_textured_emission(&self, triangle: usize, texture: &Texture, factor: DVec3, finest: f64) -> f64 {
        let image = &self.images[texture.image as usize];
        let at = |vertex: u32| self.coordinates.get(vertex as usize).map_or(Vec2::ZERO, |c| c[texture.slot]);
        let [a, b, c] = self.triangles[triangle].map(|vertex| at(vertex).as_dvec2());
        // Points in a grid as fine as the texels, within reason; light of spots that it misses is found from the camera.
        let rows = texture.transform.map(|row| DVec2::new(row[0].into(), row[1].into()).abs());
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let covered = DVec2::new(rows[0].dot(high - low), rows[1].dot(high - low));
        let texels = covered * DVec2::new(image.width.into(), image.height.into());
        let n = (2.0 * texels.max_element()).ceil().max(48.0).min(finest) as usize;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n - i {
                // Centres of the upright small triangles of a regular subdivision, and of the others.
                for third in [1.0, 2.0] {
                    let (u, v) = ((i as f64 + third / 3.0) / n as f64, (j as f64 + third / 3.0) / n as f64);
                    if u + v < 1.0 {
                        let at = a + u * (b - a) + v * (c - a);
                        let [red, green, blue, _] = texture.sample(&self.images, at.to_array());
                        sum += (factor * DVec3::new(red, green, blue)).dot(LUMINANCE);
                    }
                }
            }
        }
        sum / (n * n) as f64
    }

    /// The camera called `name`, or the first one; an error names the cameras there are.
    pub fn camera(&self, name: Option<&str>) -> crate::Result<&Camera> {
        match name {
            None => self.cameras.first().ok_or_else(|| crate::Error::input(format!("{} has no camera", self.name))),
            Some(name) => self.cameras.iter().find(|c| c.name == name).ok_or_else(|| {
                let known: Vec<&str> = self.cameras.iter().map(|c| c.name.as_str()).collect();
                crate::Error::input(format!(
                    "{} has no camera called '{name}': choose one of {}",
                    self.name,
                    known.join(", ")
                ))
            }),
        }
    }
}
