//! Lens perturbation: an isotropic step on the film (METHOD.md 2.3; Veach 1997, section 11.4.3).

use super::{Family, Kernel, never_useless, sees_the_sweep_end};
use crate::ensemble::pool::TypeKey;
use crate::scene::Features;

/// Applies to (L|D) D S* E and L S* E.
pub const KERNEL: Kernel = Kernel {
    name: "lens",
    about: "a step on the film",
    pass: "camera_side",
    flags: &[],
    family: Family::CameraSide,
    applies,
    useless: never_useless,
    guided: false,
};

/// Whether the first diffuse vertex seen from the camera can be connected to its neighbour, or is the light.
pub fn applies(key: TypeKey, _: Features) -> bool {
    sees_the_sweep_end(key)
}
