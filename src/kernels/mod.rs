//! The transition kernels: what each is called, which shader it is, and which path types it applies to.
//!
//! The mathematics is in the file of the same name under `shaders/kernels`; acceptance, splatting and counting are in one
//! place for all (`shaders/transport/accept.wesl`).

pub mod guided_lens;
pub mod independence;
pub mod lens;

use crate::ensemble::pool::TypeKey;

/// One transition kernel.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// For statistics and metadata.
    pub name: &'static str,
    /// File stem under `shaders/passes`.
    pub pass: &'static str,
    /// Flags of the pass that make it this kernel.
    pub flags: &'static [&'static str],
    /// Whether it moves paths of this type; others rest for the pass, with their weight (METHOD.md C6a).
    pub applies: fn(TypeKey) -> bool,
    /// Whether it reads the complementary ensemble.
    pub guided: bool,
}

/// Index of the first diffuse vertex seen from the camera; 0, the light, if there is none.
pub fn first_diffuse(key: TypeKey) -> u32 {
    (1..key.edges()).rev().find(|&i| key.is_diffuse(i)).unwrap_or(0)
}
