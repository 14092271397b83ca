//! Crossover: a path of either half exchange their parts on the light's side (METHOD.md 3.6b; evolutionary Monte Carlo,
//! Liang and Wong 2000). The one kernel that moves both halves.

use super::{Family, Kernel, never_useless};

/// Applies to every pair of paths; those without a cut rest.
pub const KERNEL: Kernel = Kernel {
    name: "crossover",
    about: "a path of either half exchange their parts on the light's side",
    pass: "crossover",
    flags: &[],
    family: Family::Pair,
    applies: |_, _| true,
    useless: never_useless,
    guided: false,
};
