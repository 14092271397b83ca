//! `emlt render`: a scene file to an image.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use super::options::Options;
use crate::film::file;
use crate::methods::{self, Budget, Settings};
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
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,

    /// Render for this long instead of to a number of samples
    #[arg(long, value_name = "SECONDS", conflicts_with = "spp", value_parser = parse_seconds)]
    time: Option<f64>,

    /// Also write the mutation-direction maps: OUT.maps.png, and Maps.* in the EXR (mlt, emlt)
    #[arg(long)]
    maps: bool,

    /// Show neither progress nor statistics
    #[arg(short, long)]
    quiet: bool,
}

/// Renders and writes; success means that every file was written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = outputs(arguments)?;
    for path in [Some(&outputs.exr), Some(&outputs.png), outputs.maps.as_ref()].into_iter().flatten() {
        file::check_writable(path)?;
    }
    let mut scene = arguments.options.read_scene()?;
    for warning in &scene.warnings {
        super::say("warning", warning);
    }
    let camera = arguments.options.view(&scene)?;
    let budget = match arguments.time {
        Some(seconds) => Budget::Seconds(seconds),
        None => Budget::SamplesPerPixel(arguments.spp),
    };
    let settings = Settings { budget, maps: arguments.maps, camera: None, ..arguments.options.settings(&camera)? };
    scene.cameras.insert(0, camera);
    let outcome = {
        // Dropped before anything else is printed, which clears the bar.
        let mut progress = Progress::new(arguments.quiet);
        progress.stop_on_interrupt();
        methods::render(&scene, &settings, &mut progress)?
    };
    let files = outputs::write(&outputs, &scene, &settings, &outcome)?;
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

fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0);
    seconds.ok_or_else(|| "give a number of seconds above 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::path::Path;

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
    fn seconds_are_above_0() {
        for text in ["0", "-1", "nan", "inf", "", "1s"] {
            assert!(parse_seconds(text).is_err(), "{text}");
        }
        assert_eq!(parse_seconds("0.5"), Ok(0.5));
    }
}
