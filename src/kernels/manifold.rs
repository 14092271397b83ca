//! Manifold perturbation: a step on the film, and the direction at the first diffuse vertex for which the specular ones
//! after it lead to the same vertex as before (METHOD.md 2.6; Jakob and Marschner 2012).

use super::{Family, Kernel, multi_chain, useless_without_mirrors};
use crate::ensemble::pool::TypeKey;
use crate::scene::Features;

/// Applies where the multi-chain perturbation does and the chain does not end in a sky.
pub const KERNEL: Kernel = Kernel {
    name: "manifold",
    about: "a step on the film, and specular vertices solved for so that the vertex beyond them stays",
    pass: "camera_side",
    flags: &["multi_chain", "manifold"],
    family: Family::CameraSide,
    applies,
    useless: useless_without_mirrors,
    guided: false,
};

/// Whether the first diffuse vertex from the camera is lit by specular ones, and these by a surface.
pub fn applies(key: TypeKey, features: Features) -> bool {
    let mut diffuse = (1..key.edges()).rev().filter(|&i| key.is_diffuse(i));
    let kept = diffuse.nth(1);
    // With other lights than a sky, x_0 may be a surface.
    multi_chain::applies(key, features) && (kept.is_some() || !features.sky || features.mixed)
}
