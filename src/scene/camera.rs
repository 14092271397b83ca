//! Pinhole cameras.

use glam::Affine3A;

/// A pinhole camera looking along its own -z, +y up (glTF 2.0, section 3.10).
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    pub name: String,
    /// Rigid: rotation and translation only.
    pub world_from_camera: Affine3A,
    /// Full vertical field of view in radians, in (0, pi).
    pub vertical_fov: f32,
    /// Width over height that the file asks for, if it does; the default image size follows it.
    pub aspect: Option<f32>,
}
