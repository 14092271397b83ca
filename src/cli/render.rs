//! `emlt render`: a scene file to an image.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::options::Options;
use crate::film::{Image, exr, file, metrics};
use crate::gpu::context::Context;
use crate::methods::{self, Budget, Settings};
use crate::report::log::ErrorLog;
use crate::report::outputs::{self, Outputs};
use crate::report::progress::Progress;
use crate::report::summary::{Summary, peak_memory_bytes};
use crate::{Error, Result};

/// Render a scene to an EXR image, with a PNG preview beside it
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,

    /// The image; a PNG preview of the same name is written beside it [default: SCENE's name with .exr, here]
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,

    /// Mutations per pixel (mlt, emlt) or samples per pixel (pt)
    /// [default: 128, or no end with --target-error]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,

    /// Render for this long, the chains' start included, instead of to a number of samples
    #[arg(long, value_name = "SECONDS", conflicts_with = "spp", value_parser = parse_seconds)]
    time: Option<f64>,

    /// Render until the image's own estimate of its error a pixel is below this, as in 2% or 0.02; --spp or --time cap it
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    target_error: Option<f64>,

    /// Write error and time at growing numbers of mutations to this table
    #[arg(long, value_name = "FILE.csv")]
    log: Option<PathBuf>,

    /// What the image should be: the table of --log then has the errors against it
    #[arg(long, value_name = "REF.exr", requires = "log")]
    reference: Option<PathBuf>,

    /// Also write the mutation-direction maps: OUT.maps.png, and Maps.* in the EXR; there too, by kernel, the share of
    /// proposals accepted from every pixel, Acceptance.* (mlt, emlt)
    #[arg(long)]
    maps: bool,

    /// Show neither progress nor statistics
    #[arg(short, long)]
    quiet: bool,
}

/// Renders and writes; success means that every file was written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = outputs(arguments)?;
    let written = [Some(&outputs.exr), Some(&outputs.png), outputs.maps.as_ref(), arguments.log.as_ref()];
    for path in written.into_iter().flatten() {
        file::check_writable(path)?;
    }
    let mut scene = arguments.options.read_scene()?;
    for warning in &scene.warnings {
        super::say("warning", warning);
    }
    let camera = arguments.options.view(&scene)?;
    let budget = match (arguments.time, arguments.spp, arguments.target_error) {
        (Some(seconds), _, _) => Budget::Seconds(seconds),
        (None, Some(count), _) => Budget::SamplesPerPixel(count),
        (None, None, Some(_)) => Budget::ENDLESS,
        (None, None, None) => Settings::default().budget,
    };
    let start = Instant::now();
    let context = Context::open(arguments.options.device.as_deref())?;
    let settings = Settings {
        target_error: arguments.target_error,
        camera: None,
        ..arguments.options.settings(&camera, budget, context.software, arguments.maps)?
    };
    scene.cameras.insert(0, camera);
    let reference = arguments.reference.as_deref().map(|path| reference(path, &settings)).transpose()?;
    let log = arguments.log.clone().map(|path| ErrorLog::new(path, reference)).transpose()?;
    let outcome = {
        // Dropped before anything else is printed, which clears the bar.
        let mut progress = Progress::new(arguments.quiet);
        if settings.target_error.is_some() {
            progress.show_error();
        }
        if let Some(log) = log {
            progress.keep_log(log);
        }
        progress.stop_on_interrupt();
        methods::render_since(start, &context, &scene, &settings, &mut progress)?
    };
    let mut files = outputs::write(&outputs, &scene, &settings, &outcome)?;
    files.extend(arguments.log.clone());
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

/// The image to compare with, checked before anything is rendered.
fn reference(path: &Path, settings: &Settings) -> Result<Image> {
    let image = exr::read(path)?
        .image("")
        .ok_or_else(|| Error::input(format!("{} has no channels R, G, B: choose another reference", path.display())))?;
    metrics::check_sizes([settings.width, settings.height], image.size())?;
    // Whether relative errors exist.
    metrics::compare(&image, &image, None)?;
    Ok(image)
}

/// The output paths, checked for what can be said without touching the disk.
fn outputs(arguments: &Arguments) -> Result<Outputs> {
    arguments.options.check(arguments.maps)?;
    let exr = match &arguments.output {
        Some(path) => path.clone(),
        None => {
            let stem = arguments.options.scene.file_stem().ok_or_else(|| {
                Error::input(format!(
                    "{} is not a scene file: give a .glb or .gltf file",
                    arguments.options.scene.display()
                ))
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
    Ok(Outputs::new(exr, arguments.maps))
}

/// 2% or 0.02.
fn parse_share(text: &str) -> std::result::Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let share = number.trim().parse().ok().map(|n: f64| n * unit).filter(|s| *s > 0.0 && *s < 1.0);
    share.ok_or_else(|| "give a share above 0 and below 1, as in 2% or 0.02".into())
}

pub fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0);
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
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
    fn shares_are_percent_or_below_1() {
        for text in ["0", "0%", "-1%", "2", "100%", "nan", "inf%", "", "%", "2 percent"] {
            assert!(parse_share(text).is_err(), "{text}");
        }
        assert_eq!(["2%", "0.02", "0.5 %"].map(parse_share), [Ok(0.02), Ok(0.02), Ok(0.005)]);
    }

    #[test]
    fn seconds_are_above_0() {
        for text in ["0", "-1", "nan", "inf", "", "1s"] {
            assert!(parse_seconds(text).is_err(), "{text}");
        }
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
    }
}
