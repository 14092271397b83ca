//! Twins in f64 of shader functions, for tests: written from METHOD.md, not from the shaders.

pub mod guide;
