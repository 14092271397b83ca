//! Perspective cameras, with a pinhole or a lens, and orthographic ones.

use glam::{Affine3A, DVec3, Vec3};

use crate::{Error, Result};

/// A thin lens about a camera's place and across its axis, in the file's units, both above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Diameter.
    pub aperture: f32,
    /// How far the plane that is sharp lies from the camera, along its axis.
    pub focus: f32,
}

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
    /// In place of a pinhole; perspective cameras only.
    pub lens: Option<Lens>,
    /// Width over height that the file asks for, if it does; the default image size follows it.
    pub aspect: Option<f32>,
}

impl Camera {
    /// The same camera through `lens`, or through its own where that is none.
    pub fn through(&self, lens: Option<Lens>) -> Result<Self> {
        if lens.is_some() && self.orthographic_height.is_some() {
            return Err(Error::input(format!(
                "the camera '{}' is orthographic and takes no --aperture: choose a perspective camera, or leave the aperture out",
                self.name
            )));
        }
        Ok(Self { lens: lens.or(self.lens), ..self.clone() })
    }

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
