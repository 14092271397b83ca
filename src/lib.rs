//! emlt: Ensemble Metropolis light transport as WGSL compute shaders over Vulkan.
//!
//! The map of the code; data flows one way, top to bottom:
//! - [`scene`]: glTF file to plain scene data and the features it needs
//! - [`methods`]: what `pt`, `mlt` and `emlt` are made of, and [`methods::render`]
//! - [`ensemble`]: the pool of guides, built on the host from the types of one half
//! - [`film`]: images, EXR and PNG files, error metrics
//! - [`report`]: progress while it runs, statistics at the end
//! - [`reference`]: f64 twins of shader functions, for tests
mod error;

pub mod ensemble;
pub mod film;
pub mod methods;
pub mod reference;
pub mod report;
pub mod scene;

pub use error::{Error, Result};
