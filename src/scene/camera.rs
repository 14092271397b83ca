//! Pinhole and orthographic cameras.

use glam::{Affine3A, DVec3, Vec3};

/// A camera looking along its own -z, +y up (glTF 2.0, section 3.10).
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    pub name: String,
    /// Rigid: rotation and translation only.
    pub world_from_camera: Affine3A,
    /// Full vertical field of view in radians, in (0, pi).
    pub vertical_fov: f32,
    /// Where it is orthographic instead: the height of what it sees, in the file's units. It sees nothing behind the plane
    /// through its place.
    pub orthographic_height: Option<f32>,
    /// Width over height that the file asks for, if it does; the default image size follows it.
    pub aspect: Option<f32>,
}

impl Camera {
    /// The same camera, upright at `eye` and looking at `target` (world positions in the file's units). None where these
    /// are one point, or straight above each other: then there is no upright.
    pub fn looking(&self, eye: Vec3, target: Vec3) -> Option<Self> {
        let back = (DVec3::from(eye) - DVec3::from(target)).try_normalize()?;
        let right = DVec3::Y.cross(back).try_normalize().filter(|_| back.y.abs() < 0.999_999)?;
        let up = back.cross(right);
        let [x, y, z] = [right, up, back].map(|axis| axis.as_vec3a());
        let world_from_camera = Affine3A::from_cols(x, y, z, eye.into());
        Some(Self { name: self.name.clone(), world_from_camera, ..*self })
    }
}
