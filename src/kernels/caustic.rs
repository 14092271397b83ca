//! Caustic perturbation: a turn before the specular vertices that light the visible point (METHOD.md 2.4; Veach 1997,
//! section 11.4.3).

use super::{Family, Kernel, light_sweep_start, useless_without_mirrors};
use crate::ensemble::pool::TypeKey;
use crate::scene::Features;

/// Applies to (L|D) S+ D E, and under a sky to D S+ D E alone.
pub const KERNEL: Kernel = Kernel {
    name: "caustic",
    about: "a turn before the specular vertices that light the visible point",
    pass: "light_side",
    flags: &[],
    family: Family::LightSide,
    applies,
    useless: useless_without_mirrors,
    guided: false,
};

/// Whether the diffuse vertex next to the camera is lit by a specular one.
pub fn applies(key: TypeKey, features: Features) -> bool {
    light_sweep_start(key, features).is_some()
}
