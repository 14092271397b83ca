//! The files that a render leaves.

use std::path::{Path, PathBuf};

use super::metadata;
use crate::film::{Channel, exr, png};
use crate::methods::{Outcome, Settings};
use crate::scene::Scene;
use crate::{Error, Result};

/// Where the outputs go.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    pub exr: PathBuf,
    pub png: PathBuf,
    pub maps: Option<PathBuf>,
}

impl Outputs {
    /// The PNGs lie beside the EXR, under its name.
    pub fn new(exr: PathBuf, maps: bool) -> Self {
        let maps = maps.then(|| exr.with_extension("maps.png"));
        Self { png: exr.with_extension("png"), maps, exr }
    }
}

/// Writes every output and returns their paths; the EXR first, as it is the one that cannot be made from another.
pub fn write(outputs: &Outputs, scene: &Scene, settings: &Settings, outcome: &Outcome) -> Result<Vec<PathBuf>> {
    let Outcome { image, channels, uncertainty, statistics } = outcome;
    let mut all = channels.clone();
    if let Some(uncertainty) = uncertainty {
        all.extend(["Error.R", "Error.G", "Error.B"].into_iter().enumerate().map(|(c, name)| Channel {
            name: name.into(),
            values: uncertainty.pixels.pixels.iter().map(|pixel| pixel[c]).collect(),
        }));
    }
    exr::write(&outputs.exr, image, &all, &metadata::attributes(scene, settings, statistics))?;
    png::write_preview(&outputs.png, image)?;
    let mut files = vec![outputs.exr.clone(), outputs.png.clone()];
    if let Some(path) = &outputs.maps {
        let horizontal = layer(channels, "Maps.Horizontal", path)?;
        let vertical = layer(channels, "Maps.Vertical", path)?;
        png::write_directions(path, image.width, image.height, horizontal, vertical)?;
        files.push(path.clone());
    }
    Ok(files)
}

fn layer<'a>(channels: &'a [Channel], name: &str, path: &Path) -> Result<&'a [f32]> {
    let found = channels.iter().find(|c| c.name == name);
    found
        .map(|c| c.values.as_slice())
        .ok_or_else(|| Error::runtime(format!("cannot write {}: the render has no {name} layer", path.display())))
}
