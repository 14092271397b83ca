//! Independence kernel: a fresh bidirectional path (METHOD.md 2.1). It reaches every path from every other one.

use super::{Family, Kernel, never_useless};

/// Applies to every path.
pub const KERNEL: Kernel = Kernel {
    name: "independence",
    about: "a fresh path, whatever the old one was",
    pass: "independence",
    flags: &[],
    family: Family::Structural,
    applies: |_, _| true,
    useless: never_useless,
    guided: false,
};
