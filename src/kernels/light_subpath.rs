//! Light subpath mutation: a new direction from the light, or from the last diffuse vertex before the one that the camera
//! sees, through as many specular vertices as there are to a new such one (our own design, after Veach's lens subpaths).

use super::{Family, Kernel, useless_without_mirrors};

/// Applies to (L|D) S* D E.
pub const KERNEL: Kernel = Kernel {
    name: "light-subpath",
    about: "the diffuse vertex that the camera sees and the specular ones before it, by a new direction",
    pass: "subpath",
    flags: &["segment", "subpath", "light_side"],
    family: Family::Structural,
    applies: |_, _| true,
    useless: useless_without_mirrors,
    guided: false,
};
