//! Multi-chain perturbation: a step on the film, and turns at the diffuse vertices between specular ones
//! (METHOD.md 2.5; Veach 1997, section 11.4.3).

use super::{Family, Kernel, sees_the_sweep_end, useless_without_mirrors};
use crate::ensemble::pool::TypeKey;
use crate::scene::Features;

/// Applies where the lens perturbation does not: where light comes to the first diffuse vertex by specular ones.
pub const KERNEL: Kernel = Kernel {
    name: "multi-chain",
    about: "a step on the film, and turns at the diffuse vertices between specular ones",
    pass: "camera_side",
    flags: &["multi_chain"],
    family: Family::CameraSide,
    applies,
    useless: useless_without_mirrors,
    guided: false,
};

/// Whether the camera's sweep passes a diffuse vertex.
pub fn applies(key: TypeKey, _: Features) -> bool {
    !sees_the_sweep_end(key)
}
