//! Host twins of shader functions.

pub mod guide;
pub mod rng;
