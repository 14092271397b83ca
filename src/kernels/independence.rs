//! Independence kernel: a fresh bidirectional path (METHOD.md 2.1). The only move that changes a path's type.

use super::Kernel;

/// Applies to every path.
pub const KERNEL: Kernel =
    Kernel { name: "independence", pass: "independence", flags: &[], applies: |_| true, guided: false };
