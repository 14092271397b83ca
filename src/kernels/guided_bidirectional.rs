//! Guided bidirectional mutation: half of the new directions aim where a path of the complementary ensemble goes
//! (METHOD.md 3.6a; our design).

use super::{Family, Kernel, never_useless};

/// Applies to every path.
pub const KERNEL: Kernel = Kernel {
    name: "guided-bidirectional",
    about: "a new stretch between two kept ends, aimed where a path of the other half goes",
    pass: "bidirectional",
    flags: &["segment", "guided"],
    family: Family::Structural,
    applies: |_, _| true,
    useless: never_useless,
    guided: true,
};
