//! The figures a render ends with.

use crate::ensemble::type_shares::TypeStatistics;

/// One transition kernel's counts over a render.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KernelStatistics {
    pub name: String,
    /// Mutations that this kernel made; a rejection or a null move is one too.
    pub mutations: u64,
    pub accepted: u64,
    /// Proposals whose contribution was not finite (they are rejected).
    pub non_finite: u64,
    /// Mean of acceptance times squared pixel distance, per mutation, in px^2.
    pub mean_squared_jump_px2: f64,
}

/// The figures of one render; fields that a method lacks stay at their default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Statistics {
    /// Name, driver and whether it is software.
    pub device: String,
    pub software_device: bool,
    /// Mutations (mlt, emlt) or samples (pt) in the image.
    pub samples: u64,
    /// Samples of the path tracer that made direct light apart from the mutations (--direct pt).
    pub direct_samples: u64,
    pub rays: u64,
    /// Empty for pt.
    pub kernels: Vec<KernelStatistics>,
    /// Mean image luminance b and its standard error, without direct light that was made apart; none for pt.
    pub b: Option<(f64, f64)>,
    /// How the light is shared among types of paths, the largest share first; empty for pt.
    pub types: Vec<TypeStatistics>,
    /// Total splatted luminance (over w of a two-stage target) over mutations, minus one; none for pt.
    pub integrity: Option<f64>,
    /// Loading and building the scene on the device.
    pub setup_s: f64,
    /// First dispatches, where the driver compiles.
    pub compile_s: f64,
    /// Bootstrap of b and the start paths.
    pub seeding_s: f64,
    /// Rendering proper.
    pub render_s: f64,
    /// Share of `render_s` in which the host worked between dispatches.
    pub host_share: f64,
    /// Ended before its budget because it was asked to.
    pub interrupted: bool,
    /// Sentences that the user should read.
    pub notes: Vec<String>,
}
