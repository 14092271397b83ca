//! `emlt devices`: what --device can choose from.

use clap::Args;

use crate::gpu::context;
use crate::{Error, Result};

/// List the devices that can render, the one used by default first
#[derive(Debug, Args)]
pub struct Arguments {}

/// Prints one line a device on standard output; no device at all is an error that says what to install.
pub fn run(_: &Arguments) -> Result<()> {
    let devices = context::list();
    if devices.is_empty() {
        return Err(Error::runtime(context::NO_DEVICE));
    }
    let lines = devices.iter().map(|device| {
        let software = if device.software { ", software: runs on the processor" } else { "" };
        super::one_line(&format!("{} ({}, {}{software})", device.name, device.backend, device.driver)) + "\n"
    });
    super::print(&lines.collect::<String>())
}
