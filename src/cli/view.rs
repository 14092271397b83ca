//! `emlt view`: a scene in a window, rendered while one looks.

use std::path::PathBuf;

use clap::Args;

use super::options::Options;
use crate::Result;
use crate::film::exr;
use crate::gpu::context;
use crate::gpu::shader::Sources;
use crate::methods::Budget;
use crate::viewer::{self, Launch};

/// Render a scene in a window, where settings and camera can be changed
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,

    /// An image to compare with: shows errors, and their course over time
    #[arg(long, value_name = "REF.exr")]
    reference: Option<PathBuf>,

    /// Use the shaders of this folder, as they are and whenever they change: for work on the renderer itself
    #[arg(long, value_name = "DIR")]
    shaders: Option<PathBuf>,
}

/// Opens the window and returns when it is closed. What is wrong with the files and the options is an error before.
pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { options, reference, shaders } = arguments;
    options.check(false)?;
    viewer::check_display()?;
    // Once more on the renderer's thread: here only so that a wrong name is said where it was typed.
    let scene = options.read_scene()?;
    let camera = options.view(&scene)?;
    let device = context::find(options.device.as_deref())?;
    // The window shows the maps.
    let settings = options.settings(&camera, Budget::ENDLESS, device.software, true)?;
    if let Some(path) = reference {
        exr::read(path)?;
    }
    if let Some(folder) = shaders {
        Sources::read(folder)?;
    }
    viewer::run(Launch {
        scene: options.scene.clone(),
        env: options.env.clone(),
        shaders: shaders.clone(),
        look: options.look(),
        size: options.size,
        reference: reference.clone(),
        settings,
    })
}
