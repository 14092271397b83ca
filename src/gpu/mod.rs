//! The device: context, scene buffers, shaders and dispatch.

pub mod shader;
