//! emlt: Ensemble Metropolis light transport as WGSL compute shaders over Vulkan.
//!
//! The map of the code; data flows one way, top to bottom:
//! - [`scene`]: glTF file to plain scene data and the features it needs
//! - [`film`]: images, EXR and PNG files, error metrics
mod error;

pub mod film;
pub mod scene;

pub use error::{Error, Result};
