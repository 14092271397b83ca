//! Guided lens perturbation: a step whose covariance comes from similar paths of the complementary ensemble
//! (METHOD.md 3.4, variant V2; our design over the supplement's frame).

use super::{Family, Kernel, lens, never_useless};

/// Applies where the lens perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "guided-lens",
    about: "a step on the film, shaped by similar paths of the other half",
    pass: "camera_side",
    flags: &["guided"],
    family: Family::CameraSide,
    applies: lens::applies,
    useless: never_useless,
    guided: true,
};
