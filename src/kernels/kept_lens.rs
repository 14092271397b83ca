//! Guided lens perturbation by kept vertices: the step's covariance comes from guides that resemble the part of the path
//! that does not move, the same for both ends of the step (METHOD.md 3.4, variant V1; our design).

use super::{Family, Kernel, lens, never_useless};

/// Applies where the lens perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "kept-lens",
    about: "a step on the film, shaped by guides that resemble what the step keeps",
    pass: "camera_side",
    flags: &["walk", "kept_weights"],
    family: Family::CameraSide,
    applies: lens::applies,
    useless: never_useless,
    guided: true,
};
