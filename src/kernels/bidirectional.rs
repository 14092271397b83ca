//! Bidirectional mutation: a stretch of the path is replaced by one of another length (METHOD.md 2.2; Veach 1997,
//! section 11.4.2).

use super::{Family, Kernel, never_useless};

/// Applies to every path.
pub const KERNEL: Kernel = Kernel {
    name: "bidirectional",
    about: "a new stretch between two kept ends",
    pass: "bidirectional",
    flags: &["segment"],
    family: Family::Structural,
    applies: |_, _| true,
    useless: never_useless,
    guided: false,
};
