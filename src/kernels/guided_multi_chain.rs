//! Guided multi-chain perturbation: step and turns shaped by similar paths of the complementary ensemble
//! (METHOD.md 3.5; our design).

use super::{Family, Kernel, multi_chain, useless_without_mirrors};

/// Applies where the multi-chain perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "guided-multi-chain",
    about: "the multi-chain perturbation, its step and turns shaped by similar paths of the other half",
    pass: "camera_side",
    flags: &["multi_chain", "guided"],
    family: Family::CameraSide,
    applies: multi_chain::applies,
    useless: useless_without_mirrors,
    guided: true,
};
