//! `emlt render`: a scene file to an image.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use crate::ensemble::guidance::{Guidance, MOST_GUIDES};
use crate::ensemble::mix::Mix;
use crate::film::{Channel, exr, file, png};
use crate::methods::{self, Budget, Direct, Method, Outcome, Settings};
use crate::report::metadata;
use crate::report::progress::Progress;
use crate::report::summary::{Summary, peak_memory_bytes};
use crate::scene::import::import;
use crate::scene::{Camera, Scene};
use crate::{Error, Result};

/// Image height without --size where the camera has an aspect of its own.
const DEFAULT_HEIGHT: u32 = 480;

/// The most pixels on a side that are accepted; the device may allow fewer.
const MAX_SIDE: u32 = 16384;

/// Render a scene to an EXR image, with a PNG preview beside it
#[derive(Debug, Args)]
pub struct Arguments {
    /// The scene: a glTF 2.0 file (.glb or .gltf)
    scene: PathBuf,

    /// The image; a PNG preview of the same name is written beside it [default: SCENE's name with .exr, here]
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,

    /// How to render
    #[arg(long, value_enum, default_value_t = Method::Emlt)]
    method: Method,

    /// Image size in pixels [default: 640x480, or 480 high where the camera has an aspect of its own]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,

    /// Mutations per pixel (mlt, emlt) or samples per pixel (pt)
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,

    /// Render for this long instead of to a number of samples
    #[arg(long, value_name = "SECONDS", conflicts_with = "spp", value_parser = parse_seconds)]
    time: Option<f64>,

    /// Random seed: the same one gives the same image on the same device
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,

    /// Longest path, in edges from camera to light
    #[arg(long, value_name = "K", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=31))]
    max_depth: u32,

    /// Camera by name [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,

    /// Also write the mutation-direction maps: OUT.maps.png, and Maps.* in the EXR (mlt, emlt)
    #[arg(long)]
    maps: bool,

    /// Paths in the ensemble, an even number (mlt, emlt)
    #[arg(long, value_name = "N", default_value_t = 16384, value_parser = parse_ensemble)]
    ensemble: u32,

    /// Kernels with their weights, as in independence=0.1,lens=1 (mlt, emlt); 'emlt info SCENE' lists them
    #[arg(long, value_name = "NAME=WEIGHT,...")]
    kernels: Option<String>,

    /// Guides that a guided kernel looks at, M of the supplement (emlt)
    #[arg(long, value_name = "M", default_value_t = Guidance::default().guides, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_GUIDES)))]
    guides: u32,

    /// Size of guided steps in spreads of the guides, the same for all [default: 0.05 to 0.5, the larger the more the
    /// guides resemble the path] (emlt)
    #[arg(long, value_name = "A", value_parser = parse_alpha)]
    alpha: Option<f32>,

    /// What makes guides resemble a path (emlt)
    #[arg(long, value_enum, default_value_t = Resemblance::Positions)]
    similarity: Resemblance,

    /// Who renders direct light, paths of at most 2 edges (mlt, emlt)
    #[arg(long, value_enum, default_value_t = Direct::Mcmc)]
    direct: Direct,

    /// Give dark parts more samples: as many as luminance to the power 1 - GAMMA, from 0 to 1 (mlt, emlt)
    #[arg(long, value_name = "GAMMA", value_parser = parse_gamma)]
    two_stage: Option<f64>,

    /// Device by a part of its name [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,

    /// Show neither progress nor statistics
    #[arg(short, long)]
    quiet: bool,
}

/// What the similarity of paths compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Resemblance {
    Positions,
    /// Positions and normals; the supplement finds this worse
    Normals,
}

/// Where the outputs go.
#[derive(Debug, PartialEq)]
struct Outputs {
    exr: PathBuf,
    png: PathBuf,
    maps: Option<PathBuf>,
}

/// Renders and writes; success means that every file was written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = outputs(arguments)?;
    for path in [Some(&outputs.exr), Some(&outputs.png), outputs.maps.as_ref()].into_iter().flatten() {
        file::check_writable(path)?;
    }
    let scene = import(&arguments.scene)?;
    for warning in &scene.warnings {
        super::say("warning", warning);
    }
    let settings = settings(arguments, scene.camera(arguments.camera.as_deref())?)?;
    let outcome = {
        // Dropped before anything else is printed, which clears the bar.
        let mut progress = Progress::new(arguments.quiet);
        progress.stop_on_interrupt();
        methods::render(&scene, &settings, &mut progress)?
    };
    let files = write(&outputs, &scene, &settings, &outcome)?;
    if arguments.quiet {
        for note in &outcome.statistics.notes {
            super::say("warning", note);
        }
    } else {
        let summary = Summary {
            method: settings.method,
            pixels: u64::from(settings.width) * u64::from(settings.height),
            statistics: &outcome.statistics,
            peak_memory_bytes: peak_memory_bytes(),
            files: &files,
        };
        let _ = write!(io::stderr(), "{summary}");
    }
    Ok(())
}

/// The output paths, checked for what can be said without touching the disk.
fn outputs(arguments: &Arguments) -> Result<Outputs> {
    if arguments.maps && arguments.method == Method::Pt {
        return Err(Error::input("--maps needs --method emlt or mlt: path tracing makes no mutations"));
    }
    if arguments.method == Method::Pt {
        if arguments.direct == Direct::Pt {
            return Err(Error::input(
                "--direct pt needs --method emlt or mlt: with --method pt all light is path traced",
            ));
        }
        if arguments.two_stage.is_some() {
            return Err(Error::input("--two-stage needs --method emlt or mlt: path tracing has no chains to steer"));
        }
    }
    let exr = match &arguments.output {
        Some(path) => path.clone(),
        None => {
            let stem = arguments.scene.file_stem().ok_or_else(|| {
                Error::input(format!("{} is not a scene file: give a .glb or .gltf file", arguments.scene.display()))
            })?;
            // Appended, not set, so that a name with dots keeps them.
            let mut name = stem.to_os_string();
            name.push(".exr");
            PathBuf::from(name)
        }
    };
    let extension = exr.extension().map(|e| e.to_string_lossy().to_lowercase());
    if extension.as_deref() != Some("exr") && !exr.is_dir() {
        return Err(Error::input(format!(
            "the output {} must end in .exr: it is an EXR image, and a PNG preview is written beside it",
            exr.display()
        )));
    }
    let maps = arguments.maps.then(|| exr.with_extension("maps.png"));
    Ok(Outputs { png: exr.with_extension("png"), maps, exr })
}

fn settings(arguments: &Arguments, camera: &Camera) -> Result<Settings> {
    let (width, height) = arguments.size.unwrap_or_else(|| default_size(camera.aspect));
    Ok(Settings {
        method: arguments.method,
        width,
        height,
        budget: match arguments.time {
            Some(seconds) => Budget::Seconds(seconds),
            None => Budget::SamplesPerPixel(arguments.spp),
        },
        seed: arguments.seed,
        max_depth: arguments.max_depth,
        camera: arguments.camera.clone(),
        ensemble: arguments.ensemble,
        kernels: arguments.kernels.as_deref().map(Mix::parse).transpose()?,
        guidance: Guidance {
            guides: arguments.guides,
            alpha: arguments.alpha.map_or(Guidance::default().alpha, |alpha| [alpha; 2]),
            normals: arguments.similarity == Resemblance::Normals,
        },
        direct: arguments.direct,
        two_stage: arguments.two_stage,
        maps: arguments.maps,
        device: arguments.device.clone(),
        ..Settings::default()
    })
}

fn default_size(aspect: Option<f32>) -> (u32, u32) {
    match aspect {
        Some(a) => (((a * DEFAULT_HEIGHT as f32).round() as u32).clamp(1, MAX_SIDE), DEFAULT_HEIGHT),
        None => (Settings::default().width, Settings::default().height),
    }
}

/// Writes every output and returns their paths; the EXR first, as it is the one that cannot be made from another.
fn write(outputs: &Outputs, scene: &Scene, settings: &Settings, outcome: &Outcome) -> Result<Vec<PathBuf>> {
    let Outcome { image, channels, statistics } = outcome;
    exr::write(&outputs.exr, image, channels, &metadata::attributes(scene, settings, statistics))?;
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

fn parse_size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("give width and height from 1 to {MAX_SIDE} pixels, as in 640x480"))
}

fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0);
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
}

fn parse_alpha(text: &str) -> std::result::Result<f32, String> {
    let alpha = text.parse().ok().filter(|a: &f32| *a > 0.0 && *a <= 1.0);
    alpha.ok_or_else(|| "give a number above 0 and at most 1, such as 0.05 or 0.5".into())
}

fn parse_gamma(text: &str) -> std::result::Result<f64, String> {
    let gamma = text.parse().ok().filter(|g: &f64| (0.0..=1.0).contains(g));
    gamma.ok_or_else(|| "give a number from 0 (as without) to 1 (all parts of the image alike)".into())
}

fn parse_ensemble(text: &str) -> std::result::Result<u32, String> {
    let paths = text.parse().ok().filter(|n: &u32| (16..=1 << 22).contains(n) && n.is_multiple_of(2));
    paths.ok_or_else(|| "give an even number from 16 to 4194304".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Wrapper {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn arguments(words: &str) -> Arguments {
        Wrapper::parse_from(["render"].into_iter().chain(words.split_whitespace())).arguments
    }

    fn camera(aspect: Option<f32>) -> Camera {
        Camera { name: "c".into(), world_from_camera: glam::Affine3A::IDENTITY, vertical_fov: 1.0, aspect }
    }

    #[test]
    fn no_flags_give_the_default_settings() {
        let settings = settings(&arguments("a.glb"), &camera(None)).unwrap();
        assert_eq!(format!("{settings:?}"), format!("{:?}", Settings::default()));
    }

    #[test]
    fn the_size_follows_the_camera_unless_given() {
        let size = |words, aspect| {
            let settings = settings(&arguments(words), &camera(aspect)).unwrap();
            (settings.width, settings.height)
        };
        assert_eq!(size("a.glb", Some(16.0 / 9.0)), (853, 480));
        assert_eq!(size("a.glb", Some(1e9)), (MAX_SIDE, 480));
        assert_eq!(size("a.glb", Some(1e-9)), (1, 480));
        assert_eq!(size("a.glb --size 32x16", Some(2.5)), (32, 16));
    }

    #[test]
    fn outputs_lie_beside_each_other() {
        let names = outputs(&arguments("dir/a.b.glb --maps")).unwrap();
        assert_eq!(names.exr, Path::new("a.b.exr"));
        assert_eq!(names.png, Path::new("a.b.png"));
        assert_eq!(names.maps.unwrap(), Path::new("a.b.maps.png"));
        assert_eq!(outputs(&arguments("a.glb -o x/y.EXR")).unwrap().png, Path::new("x/y.png"));
        for bad in [
            "a.glb -o a.png",
            "a.glb -o a",
            "..",
            "a.glb --maps --method pt",
            "a.glb --direct pt --method pt",
            "a.glb --two-stage 0.5 --method pt",
        ] {
            assert_eq!(outputs(&arguments(bad)).unwrap_err().exit_status(), 2, "{bad}");
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in ["", "x", "0x4", "4x0", "4x", "-1x3", "4.5x3", "99999x2", "1x2x3", "4 x 3"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert_eq!(parse_size("1X16384"), Ok((1, 16384)));
        for text in ["0", "-1", "nan", "inf", "", "1s"] {
            assert!(parse_seconds(text).is_err(), "{text}");
        }
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
        for text in ["0", "14", "17", "4194306", "many"] {
            assert!(parse_ensemble(text).is_err(), "{text}");
        }
        assert_eq!(parse_ensemble("16"), Ok(16));
        for text in ["0", "-0.1", "1.1", "nan", ""] {
            assert!(parse_alpha(text).is_err(), "{text}");
        }
        assert_eq!(parse_alpha("0.05"), Ok(0.05));
        for text in ["-0.1", "1.1", "nan", "", "half"] {
            assert!(parse_gamma(text).is_err(), "{text}");
        }
        assert_eq!([parse_gamma("0"), parse_gamma("1")], [Ok(0.0), Ok(1.0)]);
    }
}
