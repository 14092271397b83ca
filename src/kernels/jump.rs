//! Jump to a guide: an independent pixel from a density estimate over guides (METHOD.md 3.6f; our design).

use super::{Family, Kernel, lens, never_useless};

/// Applies where the lens perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "jump",
    about: "a new place on the film near some guide",
    pass: "camera_side",
    flags: &["jump"],
    family: Family::CameraSide,
    applies: lens::applies,
    useless: never_useless,
    guided: true,
};
