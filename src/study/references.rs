//! What images of a study should be: a reference that comes with the scene, or one that the study renders.
//!
//! References lie in the study's folder, with the variance of every pixel value, which is subtracted from what images differ
//! from them.

use std::path::{Path, PathBuf};

use super::plan::{Asked, budget_name};
use crate::film::exr::Attribute;
use crate::film::{Channel, Image, exr, metrics};
use crate::methods::{Budget, Direct, Method, Outcome, Settings};
use crate::{Error, Result};

/// No seed that anybody asks for, so that the reference is independent of what it is compared with.
const SEED: u32 = 4_000_000_007;

/// Where references that other renderers have made lie, from the folder of the scenes.
const KNOWN: &str = "../tests/references";

/// What the images of a scene should be.
pub struct Reference {
    pub scene: String,
    pub image: Image,
    /// Of each of its values.
    pub variance: Image,
    /// Where it is from, in words.
    pub source: String,
    /// Mean luminance.
    pub luminance: f64,
}

impl Reference {
    /// Root of the relMSE that its own noise amounts to.
    pub fn own_error(&self) -> f64 {
        let root = |v: f32| v.max(0.0).sqrt();
        let pixels = self.image.pixels.iter().zip(&self.variance.pixels);
        let pixels = pixels.map(|(p, v)| std::array::from_fn(|c| p[c] + root(v[c]))).collect();
        let moved = Image { pixels, ..self.image };
        metrics::compare(&moved, &self.image, None).map_or(f64::NAN, |errors| errors.rel_mse.sqrt())
    }

    /// How far `image` is from it.
    pub fn compare(&self, image: &Image) -> Result<metrics::Errors> {
        metrics::compare(image, &self.image, Some(&self.variance))
    }
}

/// The file of another renderer, where there is one of the right size for a scene of the repository.
pub fn known(asked: &Asked, scene: &str) -> Option<PathBuf> {
    let path = asked.scene_folder.join(KNOWN).join(format!("{scene}.exr"));
    let file = exr::read(&path).ok()?;
    let fits = [file.width, file.height] == asked.size && file.image("Variance.").is_some();
    fits.then_some(path)
}

/// Scenes of which path tracing tells half the error of its own that chains tell in equal time: nearly all light is direct.
const BY_PATH_TRACING: [&str; 1] = ["displaced_wall"];

/// How a study renders a reference: by path tracing where that is better, else by chains for indirect light, with more
/// candidates for b than usual, and path tracing for the rest.
pub fn settings(asked: &Asked, scene: &str) -> Settings {
    let method = if BY_PATH_TRACING.contains(&scene) { Method::Pt } else { Method::Emlt };
    let usual = asked.run(scene, "reference", method, SEED).settings;
    let budget = Budget::SamplesPerPixel(asked.reference_spp);
    if method == Method::Pt {
        return Settings { budget, ..usual };
    }
    Settings { budget, direct: Direct::Pt, candidates: 4 * usual.candidates, ..usual }
}

/// Copies another renderer's file into the study's folder.
pub fn take(known: &Path, to: &Path, scene_hash: u64) -> Result<()> {
    let file = exr::read(known)?;
    let source = format!("{}, which another renderer made", known.file_name().unwrap_or_default().to_string_lossy());
    let (Some(image), Some(variance)) = (file.image(""), file.image("Variance.")) else {
        return Err(Error::input(format!("{} has no channels R, G, B with their variances", known.display())));
    };
    write(to, &image, &variance, &source, scene_hash)
}

/// Keeps a finished render as the reference.
pub fn keep(outcome: &Outcome, settings: &Settings, to: &Path, scene_hash: u64) -> Result<()> {
    let uncertainty = outcome.uncertainty.as_ref().ok_or_else(|| {
        Error::input("a reference needs to know its own noise: choose a smaller --size or a larger --reference-spp")
    })?;
    let pixels = uncertainty.pixels.pixels.iter().map(|p| p.map(|e| e * e)).collect();
    let variance = Image { pixels, ..outcome.image };
    let chains = match settings.method {
        Method::Pt => String::new(),
        _ => format!(" with path-traced direct light and {} start candidates", settings.candidates),
    };
    let (method, budget) = (settings.method.name(), budget_name(settings.budget));
    let source = format!("by this study: {method}{chains}, {budget}, seed {}", settings.seed);
    write(to, &outcome.image, &variance, &source, scene_hash)
}

fn write(to: &Path, image: &Image, variance: &Image, source: &str, scene_hash: u64) -> Result<()> {
    let names = ["Variance.R", "Variance.G", "Variance.B"];
    let channel = |(c, name): (usize, &str)| Channel {
        name: name.into(),
        values: variance.pixels.iter().map(|p| p[c]).collect(),
    };
    let channels: Vec<Channel> = names.into_iter().enumerate().map(channel).collect();
    let hash = format!("{scene_hash:016x}");
    let attributes =
        [("source".to_string(), Attribute::from(source)), ("sceneHash".to_string(), Attribute::from(hash.as_str()))];
    exr::write(to, image, &channels, &attributes)
}

/// The reference of a scene in the study's folder; none where there is none yet, or one of another state of the scene.
pub fn read(path: &Path, scene: &str, scene_hash: u64) -> Result<Option<Reference>> {
    if !path.is_file() {
        return Ok(None);
    }
    let file = exr::read(path)?;
    let (Some(image), Some(variance)) = (file.image(""), file.image("Variance.")) else { return Ok(None) };
    let Some(Attribute::Text(source)) = file.attribute("source").cloned() else { return Ok(None) };
    if file.attribute("sceneHash") != Some(&Attribute::Text(format!("{scene_hash:016x}"))) {
        return Ok(None);
    }
    let luminance = metrics::mean_luminance(&image);
    if luminance.is_nan() || luminance <= 0.0 {
        return Err(Error::input(format!("scene {scene} is black: turn its camera, or leave it out with --scene")));
    }
    Ok(Some(Reference { scene: scene.into(), image, variance, source, luminance }))
}
