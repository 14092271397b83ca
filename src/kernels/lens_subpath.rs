//! Lens subpath mutation: from a new pixel through as many specular vertices as there are to the first or second diffuse
//! vertex, which is connected to what is kept (Veach 1997, section 11.4.4; the second one is our own design). A path
//! without diffuse vertices is made anew to the light.

use super::{Family, Kernel, useless_without_mirrors};

/// Applies to (L|D) D S* E and L S* E, or with two diffuse vertices to (L|D) D S* D S* E.
pub const KERNEL: Kernel = Kernel {
    name: "lens-subpath",
    about: "the camera's side up to its first or second diffuse vertex, from a new pixel",
    pass: "subpath",
    flags: &["segment", "subpath"],
    family: Family::Structural,
    applies: |_, _| true,
    useless: useless_without_mirrors,
    guided: false,
};
