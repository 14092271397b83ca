//! `emlt compare`: how far two images are apart.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::film::{Channel, Image, exr, file, flip, metrics, png};
use crate::{Error, Result};

/// Compare two EXR images of one size: figures, and a picture of where they differ
#[derive(Debug, Args)]
pub struct Arguments {
    /// The image
    #[arg(value_name = "A.exr")]
    image: PathBuf,

    /// What it should be
    #[arg(value_name = "B.exr")]
    reference: PathBuf,

    /// Write A - B here, with FLIP as a layer of its own, and the picture of FLIP beside it [default: the picture alone,
    /// as A's name with .difference.png, here]
    #[arg(short, long, value_name = "DIFF.exr")]
    output: Option<PathBuf>,
}

/// Prints the figures on standard output and writes the picture.
pub fn run(arguments: &Arguments) -> Result<()> {
    let picture = picture(arguments)?;
    for path in arguments.output.iter().chain([&picture]) {
        file::check_writable(path)?;
    }
    let (image, errors) = read(&arguments.image)?;
    let (reference, _) = read(&arguments.reference)?;
    let figures = metrics::compare(&image, &reference, None)?;
    let values = flip::flip(&image, &reference)?;
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    if let Some(path) = &arguments.output {
        let pairs = image.pixels.iter().zip(&reference.pixels);
        let pixels = pairs.map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]).collect();
        let layer = Channel { name: "FLIP".into(), values: values.iter().map(|v| *v as f32).collect() };
        exr::write(path, &Image { pixels, ..image }, &[layer], &[])?;
    }
    png::write_heat(&picture, image.width, image.height, &values)?;
    let mut text = String::new();
    let mut row = |name: &str, value: String| text.push_str(&format!("{name:<16}{value}\n"));
    row("MSE", format!("{:.6e}", figures.mse));
    row("MAE", format!("{:.6e}", figures.mae));
    row("relMSE", format!("{:.6e}  (root {:.2} %)", figures.rel_mse, 100.0 * figures.rel_mse.sqrt()));
    row(
        "relMSE of 4x4",
        format!("{:.6e}  (root {:.2} %)", figures.rel_mse_blocks, 100.0 * figures.rel_mse_blocks.sqrt()),
    );
    row("FLIP", format!("{mean:.6}  (mean; 0 is alike, 1 the most)"));
    if let Some(expected) = errors {
        row("expected MSE", format!("{expected:.6e}  (by A's own standard error)"));
    }
    super::print(&text)
}

/// The image of a file, and the MSE that its own standard errors let one expect.
fn read(path: &Path) -> Result<(Image, Option<f64>)> {
    let file = exr::read(path)?;
    let image = file
        .image("")
        .ok_or_else(|| Error::input(format!("{} has no channels R, G, B: give an image with them", path.display())))?;
    let mean = |values: Image, power: i32| {
        let count = 3.0 * values.pixels.len() as f64;
        values.pixels.iter().flatten().map(|v| f64::from(*v).powi(power)).sum::<f64>() / count
    };
    let expected = file.image("Error.").map(|e| mean(e, 2)).or_else(|| file.image("Variance.").map(|v| mean(v, 1)));
    Ok((image, expected))
}

/// Where the picture goes.
fn picture(arguments: &Arguments) -> Result<PathBuf> {
    if let Some(path) = &arguments.output {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        if extension.as_deref() != Some("exr") {
            return Err(Error::input(format!(
                "the output {} must end in .exr: a PNG picture is written beside it",
                path.display()
            )));
        }
        return Ok(path.with_extension("png"));
    }
    let stem = arguments.image.file_stem().ok_or_else(|| {
        Error::input(format!("{} is not an image file: give an .exr file", arguments.image.display()))
    })?;
    let mut name = stem.to_os_string();
    name.push(".difference.png");
    Ok(PathBuf::from(name))
}
