//! The scene as plain data: what a renderer needs to know, in the file's own units, independent of file format and device.

pub mod camera;
pub mod features;
pub mod import;
pub mod material;

use glam::Vec3;

pub use camera::Camera;
pub use features::Features;
pub use material::Material;

/// A triangle soup with materials, cameras and an optional uniform sky.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Name for messages and metadata: the file's stem.
    pub name: String,
    /// World positions, in the file's units.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise seen from the front; indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials`, one per triangle.
    pub triangle_materials: Vec<u32>,
    pub materials: Vec<Material>,
    /// The file's perspective cameras; never empty after import (a framed one is made).
    pub cameras: Vec<Camera>,
    /// Radiance of a uniform sky around the scene (linear Rec.709); set only where the file has no light at all.
    pub sky: Option<Vec3>,
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
