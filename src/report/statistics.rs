//! The figures a render ends with.

use crate::ensemble::mixing::MixingStatistics;
use crate::ensemble::type_shares::TypeStatistics;
use crate::film::uncertainty::{Uncertainty, Y};

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
    /// What its mutations took on the device's own clock, work that is done for the kernel alone included; none where
    /// the device has no clock.
    pub device_s: Option<f64>,
}

/// How far the image may be from the truth, by its own account (docs/METHOD.md 5.10, film::uncertainty).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorStatistics {
    /// Root of the estimated relMSE of pixels, and of the means of 8x8 tiles.
    pub pixels: f64,
    pub tiles: f64,
    /// Mean luminance of the film, and half the width of its 95 % interval.
    pub film: f64,
    pub film_half_width: f64,
    /// Standard error of that mean.
    pub film_error: f64,
    /// Independent groups whose scatter told it; 0 for a path tracer's samples.
    pub groups: u32,
}

impl ErrorStatistics {
    pub fn new(uncertainty: &Uncertainty) -> Self {
        let film = &uncertainty.film[Y];
        Self {
            pixels: uncertainty.relative,
            tiles: uncertainty.relative_of_tiles,
            film: film.mean,
            film_half_width: film.half_width(0.05),
            film_error: film.standard_error(),
            groups: uncertainty.groups,
        }
    }
}

/// The figures of one render; fields that a method lacks stay at their default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Statistics {
    /// Name, driver and whether it is software.
    pub device: String,
    pub software_device: bool,
    /// Mutations (mlt, emlt) or samples (pt) in the image.
    pub samples: u64,
    /// Samples of the path tracer that made a part of the light apart from the mutations (--direct pt, auto).
    pub path_traced_samples: u64,
    /// Share of the image's luminance that they made; none where the figures were asked for without the image.
    pub path_traced_light: Option<f64>,
    pub rays: u64,
    /// Empty for pt.
    pub kernels: Vec<KernelStatistics>,
    /// Mean image luminance b and its standard error, without light that was path traced apart; none for pt.
    pub b: Option<(f64, f64)>,
    /// The image's own error; none where the figures were asked for without the image, or where it cannot be told.
    pub error: Option<ErrorStatistics>,
    /// How the light is shared among types of paths, the largest share first; empty for pt.
    pub types: Vec<TypeStatistics>,
    /// How well the chains mix; none for pt.
    pub mixing: Option<MixingStatistics>,
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
