//! The rendering methods: `pt`, `mlt` and `emlt` are mixes of the same parts.

mod chain_film;
mod chains;
mod direct;
mod pt;
mod render;
mod session;

use crate::ensemble::bootstrap::CANDIDATES;
use crate::ensemble::groups::MOST_GROUPS;
use crate::ensemble::guidance::Guidance;
pub use crate::ensemble::path_traced::Direct;
use crate::film::uncertainty::Uncertainty;
use crate::film::{Channel, Image};
use crate::kernels::{
    Kernel, bidirectional, caustic, guided_bidirectional, guided_lens, guided_light_subpath, independence, lens,
    lens_subpath, manifold, multi_chain,
};
pub use crate::report::observer::{Observer, Silent};
use crate::report::statistics::Statistics;
use crate::scene::material::GLOSSY_AS_SPECULAR_ALPHA;
use crate::scene::{Camera, Lens};
pub use chain_film::ACCEPTANCE;
pub(crate) use render::render_since;
pub use render::{render, render_on};
pub use session::{Prepared, Session, Stage};

/// Which mix of parts renders the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum Method {
    /// Ensemble Metropolis light transport: mlt with kernels guided by the complementary ensemble.
    Emlt,
    /// Metropolis light transport in path space (Veach 1997).
    Mlt,
    /// Path tracing with next-event estimation: the reference.
    Pt,
}

impl Method {
    /// The name on the command line and in metadata.
    pub fn name(self) -> &'static str {
        match self {
            Self::Emlt => "emlt",
            Self::Mlt => "mlt",
            Self::Pt => "pt",
        }
    }
}

/// Image height where nobody asks for a size and the camera has an aspect of its own.
const DEFAULT_HEIGHT: u32 = 480;

/// The most pixels on a side that are accepted; the device may allow fewer.
pub const MAX_SIDE: u32 = 16384;

/// Width and height in pixels where nobody asks for a size.
pub fn default_size(camera: &Camera) -> (u32, u32) {
    match camera.aspect {
        Some(a) => (((a * DEFAULT_HEIGHT as f32).round() as u32).clamp(1, MAX_SIDE), DEFAULT_HEIGHT),
        None => (Settings::default().width, Settings::default().height),
    }
}

/// How long to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// Mutations per pixel (mlt, emlt) or samples per pixel (pt).
    SamplesPerPixel(u32),
    /// Wall-clock seconds of rendering, the chains' start among them, set-up not counted. Chains have a quarter of it at
    /// least.
    Seconds(f64),
}

impl Budget {
    /// Until somebody stops it.
    pub const ENDLESS: Self = Self::SamplesPerPixel(u32::MAX);
}

/// What the user asked for.
#[derive(Debug, Clone)]
pub struct Settings {
    pub method: Method,
    pub width: u32,
    pub height: u32,
    pub budget: Budget,
    pub seed: u32,
    /// Path edges from camera to light, at least 1.
    pub max_depth: u32,
    /// Camera by name; the first one without.
    pub camera: Option<String>,
    /// What it sees through, in place of a pinhole.
    pub lens: Option<Lens>,
    /// Paths in the ensemble: both halves together.
    pub ensemble: u32,
    /// Independent groups into which it is split, whose scatter tells the image's error (mlt, emlt).
    pub groups: u32,
    /// Candidates from which the chains' start and b come (mlt, emlt).
    pub candidates: u32,
    /// Ends the render, within the budget, once the image's own error a pixel is below this share.
    pub target_error: Option<f64>,
    /// Kernels with their weights (mlt, emlt); the method's own mix without.
    pub kernels: Option<Vec<(&'static Kernel, f64)>>,
    /// How guided kernels look at the other half (emlt).
    pub guidance: Guidance,
    /// Who renders direct light, and whatever else is easy (mlt, emlt).
    pub direct: Direct,
    /// Exponent gamma from 0 to 1 of a two-stage target (mlt, emlt): chains spend their samples on the image's luminance
    /// to the power 1 - gamma.
    pub two_stage: Option<f64>,
    /// Accumulate the mutation-direction maps, and the acceptance by kernel and pixel (mlt, emlt).
    pub maps: bool,
    /// Part of a device's name; the best one without.
    pub device: Option<String>,
    /// Lobes of smaller GGX alpha are treated as specular by mlt and emlt (METHOD.md 2.7), but where the path tracer has a share
    /// of its choice. Changes noise, not results.
    pub glossy_as_specular_alpha: f32,
}

/// Paths in the ensemble of a software device, on which more would fill no more lanes.
const SOFTWARE_ENSEMBLE: u32 = 1 << 14;
/// The most that a GPU is given by default: a half of them leaves few of its threads idle.
const MOST_OF_A_GPU: u32 = 1 << 18;
/// Mutations that each path should make at least: as many as whole sweeps of some weight leave to a short render.
const FEWEST_MUTATIONS: f64 = 320.0;

/// Paths in the ensemble unless told otherwise. A GPU needs many to be busy, and has made the more mutations with them in
/// the same time; but few mutations a path would leave the image as the start has made it.
pub fn default_ensemble(software: bool, budget: Budget, [width, height]: [u32; 2]) -> u32 {
    let paths = match budget {
        _ if software => SOFTWARE_ENSEMBLE,
        Budget::Seconds(_) => MOST_OF_A_GPU,
        Budget::SamplesPerPixel(n) => (f64::from(n) * f64::from(width) * f64::from(height) / FEWEST_MUTATIONS)
            .min(f64::from(MOST_OF_A_GPU)) as u32,
    };
    // The largest power of two that is not above.
    (1 << paths.max(1).ilog2()).max(SOFTWARE_ENSEMBLE)
}

/// The kernels of a method with their weights (docs/kernels.md says how they were chosen).
pub fn default_mix(method: Method) -> Vec<(&'static Kernel, f64)> {
    let guided = method == Method::Emlt;
    let mut weights = vec![
        (&independence::KERNEL, 0.05),
        if guided { (&guided_bidirectional::KERNEL, 0.05) } else { (&bidirectional::KERNEL, 0.15) },
        (&lens::KERNEL, 1.0),
        (&multi_chain::KERNEL, 1.0),
        (&caustic::KERNEL, 1.0),
    ];
    if guided {
        weights.extend([
            (&guided_lens::KERNEL, 0.5),
            (&lens_subpath::KERNEL, 0.1),
            (&guided_light_subpath::KERNEL, 0.05),
            (&manifold::KERNEL, 0.5),
        ]);
    }
    weights
}

/// The exponent of the chains' target unless told otherwise: half of the way to even samples lowers emlt's relative error where
/// a picture has dark parts; mlt stays what Veach and others have (docs/kernels.md, "What two stages give").
pub fn default_two_stage(method: Method) -> Option<f64> {
    (method == Method::Emlt).then_some(0.5)
}

/// Who renders easy light unless told otherwise: in emlt the path tracer, but where the chains themselves are to be looked at.
pub fn default_direct(method: Method, shows_chains: bool) -> Direct {
    if method == Method::Emlt && !shows_chains { Direct::Auto } else { Direct::Mcmc }
}

/// Mutations for each candidate of the start, and the fewest and most candidates there are by default.
const MUTATIONS_A_CANDIDATE: f64 = 3.0;
const MOST_CANDIDATES: u32 = 1 << 25;
/// The fewest where the start is part of a time limit.
const FEWEST_IN_TIME: u32 = 1 << 17;
/// Mutations a second to expect where the budget is a time.
const SOFTWARE_RATE: f64 = 1e6;
const GPU_RATE: f64 = 5e7;

/// Candidates of the start unless told otherwise: a third of the mutations that will follow, at least a million; then the
/// start takes a fifth to a half of the time. What chains start from leaves most of the error of a render in which a path
/// makes hundreds of mutations (docs/kernels.md, "How large a start"); where the end is not known, it waits no longer than
/// an interactive one may.
pub fn default_candidates(software: bool, budget: Budget, [width, height]: [u32; 2]) -> u32 {
    let rate = if software { SOFTWARE_RATE } else { GPU_RATE };
    let mutations = match budget {
        Budget::ENDLESS if software => 0.0,
        Budget::ENDLESS => 0.4 * rate,
        // As many as there may be time for: the start ends when it has had its share.
        Budget::Seconds(s) => s * rate,
        Budget::SamplesPerPixel(n) => f64::from(n) * f64::from(width) * f64::from(height),
    };
    let candidates = (mutations / MUTATIONS_A_CANDIDATE).min(f64::from(MOST_CANDIDATES)) as u32;
    let fewest = if matches!(budget, Budget::Seconds(_)) { FEWEST_IN_TIME } else { CANDIDATES };
    (1 << candidates.max(1).ilog2()).max(fewest)
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Emlt,
            width: 640,
            height: 480,
            budget: Budget::SamplesPerPixel(128),
            seed: 1,
            max_depth: 12,
            camera: None,
            lens: None,
            ensemble: SOFTWARE_ENSEMBLE,
            groups: MOST_GROUPS,
            candidates: CANDIDATES,
            target_error: None,
            kernels: None,
            guidance: Guidance::default(),
            direct: Direct::Mcmc,
            two_stage: None,
            maps: false,
            device: None,
            glossy_as_specular_alpha: GLOSSY_AS_SPECULAR_ALPHA,
        }
    }
}

impl Settings {
    /// Below this GGX alpha a lobe is treated as specular. Path tracing has no use for classes: its lobes stay with the
    /// rest, under multiple importance sampling, and so do those of chains that share the light with it.
    pub(crate) fn specular_threshold(&self) -> f32 {
        if self.method == Method::Pt || self.direct == Direct::Auto { 0.0 } else { self.glossy_as_specular_alpha }
    }
}

/// A finished (or interrupted) render, or one as it stands.
#[derive(Debug, Clone)]
pub struct Outcome {
    pub image: Image,
    /// `Maps.*` and other layers that were asked for.
    pub channels: Vec<Channel>,
    /// How uncertain the image is, where it can be told.
    pub uncertainty: Option<Uncertainty>,
    pub statistics: Statistics,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ensembles_fit_the_device_and_the_budget() {
        let ensemble = |software, spp| default_ensemble(software, Budget::SamplesPerPixel(spp), [640, 480]);
        assert_eq!([1, 128, u32::MAX].map(|spp| ensemble(true, spp)), [16384; 3]);
        assert_eq!([1, 16, 32, 128, 1024].map(|spp| ensemble(false, spp)), [16384, 16384, 16384, 65536, 262_144]);
        assert_eq!(default_ensemble(false, Budget::ENDLESS, [1, 1]), 262_144);
        assert_eq!(default_ensemble(false, Budget::Seconds(0.1), [1, 1]), 262_144);
    }
    #[test]
    fn starts_grow_with_the_budget() {
        let million = 1 << 20;
        let candidates = |software, spp| default_candidates(software, Budget::SamplesPerPixel(spp), [640, 480]);
        assert_eq!([1, 27, 128, 100_000].map(|spp| candidates(true, spp)), [1, 2, 8, 32].map(|n| n * million));
        assert_eq!(candidates(false, 128), 8 * million);
        let unknown = [Budget::ENDLESS, Budget::Seconds(10.0), Budget::Seconds(60.0)];
        assert_eq!(default_candidates(true, Budget::Seconds(0.5), [1, 1]), million / 8);
        assert_eq!(unknown.map(|budget| default_candidates(true, budget, [1, 1])), [1, 2, 16].map(|n| n * million));
        assert_eq!(unknown.map(|budget| default_candidates(false, budget, [1, 1])), [4, 32, 32].map(|n| n * million));
    }
}
