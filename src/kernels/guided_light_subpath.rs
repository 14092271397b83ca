//! Guided light subpath mutation: half of the directions come from a mixture about those of caustic paths of the
//! complementary ensemble (our design over the supplement's frame: M guides of one type, chosen by ID).

use super::{Kernel, light_subpath};

/// Applies as the unguided one.
pub const KERNEL: Kernel = Kernel {
    name: "guided-light-subpath",
    about: "as light-subpath, half of the directions towards where caustics of the other half begin",
    flags: &["segment", "subpath", "light_side", "guided"],
    guided: true,
    ..light_subpath::KERNEL
};
