//! Guided caustic perturbation: a turn shaped by similar paths of the complementary ensemble (METHOD.md 3.5; our design).

use super::{Family, Kernel, caustic, useless_without_mirrors};

/// Applies where the caustic perturbation does.
pub const KERNEL: Kernel = Kernel {
    name: "guided-caustic",
    about: "the caustic perturbation, its turn shaped by similar paths of the other half",
    pass: "light_side",
    flags: &["guided"],
    family: Family::LightSide,
    applies: caustic::applies,
    useless: useless_without_mirrors,
    guided: true,
};
