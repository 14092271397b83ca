//! The ensemble: the pool of guides built from one half, and what is computed from it while it is frozen.

pub mod pool;
pub mod similarity;
mod type_key;
