//! emlt: Ensemble Metropolis light transport as WGSL compute shaders over Vulkan.
//!
//! The map of the code; data flows one way, top to bottom:
//! - [`scene`]: glTF file to plain scene data and the features it needs
//! - [`accel`]: triangles to a compressed wide BVH
//! - [`gpu`]: device, scene buffers, shader composition, recorded dispatches
//! - [`methods`]: what `pt`, `mlt` and `emlt` are made of, and [`methods::render`]
//! - [`film`]: images, EXR and PNG files, error metrics
//! - [`report`]: progress while it runs, statistics at the end, metadata in the file
//! - [`cli`]: the commands
mod error;

pub mod accel;

pub mod cli;
pub mod film;
pub mod gpu;
pub mod methods;
pub mod report;
pub mod scene;

pub use error::{Error, Result};
