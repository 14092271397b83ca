//! Walk perturbation: a step with the spread of the guides' pixels, whatever the path (METHOD.md 3.4, variant V0; Goodman
//! and Weare 2010).

use super::{Family, Kernel, lens, never_useless};

/// Applies where the lens perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "walk",
    about: "a step on the film with the spread of guides, whatever the path",
    pass: "camera_side",
    flags: &["walk"],
    family: Family::CameraSide,
    applies: lens::applies,
    useless: never_useless,
    guided: true,
};
