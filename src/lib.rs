//! emlt: Ensemble Metropolis light transport as WGSL compute shaders over Vulkan.
//!
//! The map of the code; data flows one way, top to bottom:
//! - [`scene`]: glTF file to plain scene data and the features it needs
//! - [`accel`]: triangles to a compressed wide BVH
//! - [`gpu`]: device, scene buffers, shader composition, recorded dispatches
//! - [`ensemble`]: seeds, pool of guides, half-sweeps
//! - [`kernels`]: one transition kernel a file
//! - [`methods`]: what `pt`, `mlt` and `emlt` are made of, and [`methods::render`]
//! - [`film`]: images, EXR and PNG files, error metrics
//! - `panics`: what guards against panics in code that is not ours
//! - [`report`]: progress while it runs, statistics at the end, metadata in the file
//! - [`reference`]: host twins of shader functions, for tests
//! - [`study`]: the supplement's experiments, from renders to a report
//! - `viewer`: the interactive window, a cargo feature
//! - [`cli`]: the commands

pub mod accel;
pub mod cli;
pub mod ensemble;
mod error;
pub mod film;
pub mod gpu;
pub mod kernels;
pub mod methods;
mod panics;
pub mod reference;
pub mod report;
pub mod scene;
pub mod study;
#[cfg(feature = "viewer")]
pub mod viewer;

pub use error::{Error, Result};
