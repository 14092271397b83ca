//! Differential evolution: a step along the difference of two guides (METHOD.md 3.6c; ter Braak 2006).

use super::{Family, Kernel, lens, never_useless};

/// Applies where the lens perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "difference",
    about: "a step on the film along the difference of two guides",
    pass: "camera_side",
    flags: &["difference"],
    family: Family::CameraSide,
    applies: lens::applies,
    useless: never_useless,
    guided: true,
};
