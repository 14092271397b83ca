//! A small path-traced image that is there at once: while a method starts, and while the camera moves.

use std::time::{Duration, Instant};

use crate::Result;
use crate::film::Image;
use crate::gpu::context::Context;
use crate::methods::{Budget, Direct, Method, Prepared, Session, Settings};

/// A step takes about as long.
const STEP: Duration = Duration::from_millis(25);
/// Pixels of the image, while the camera moves and while it stands still.
const PIXELS_MOVING: f64 = 8_000.0;
const PIXELS_STILL: f64 = 30_000.0;
/// More would not be seen before the method has an image of its own.
const ENOUGH_SAMPLES: u64 = 64;
/// Least time between images.
const BETWEEN_IMAGES: Duration = Duration::from_millis(100);

/// The preview on its way.
pub struct Preview<'a> {
    session: Session<'a>,
    pixels: u64,
    shown: Option<Instant>,
}

impl<'a> Preview<'a> {
    /// The settings of the preview for a render.
    pub fn settings(of: &Settings, moving: bool) -> Settings {
        let pixels = if moving { PIXELS_MOVING } else { PIXELS_STILL };
        let scale = (pixels / (f64::from(of.width) * f64::from(of.height))).sqrt().min(1.0);
        let side = |n: u32| ((f64::from(n) * scale).round() as u32).max(1);
        Settings {
            method: Method::Pt,
            direct: Direct::Mcmc,
            width: side(of.width),
            height: side(of.height),
            budget: Budget::ENDLESS,
            kernels: None,
            two_stage: None,
            maps: false,
            ..of.clone()
        }
    }

    pub fn start(context: &'a Context, prepared: &Prepared, settings: &Settings) -> Result<Self> {
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        Ok(Self { session: Session::start(context, prepared, settings)?, pixels, shown: None })
    }

    /// Whether it is as good as it needs to be.
    pub fn is_enough(&self) -> bool {
        self.session.samples() >= ENOUGH_SAMPLES * self.pixels
    }

    /// Whether it has been seen.
    pub fn has_image(&self) -> bool {
        self.shown.is_some()
    }

    /// A little more of it; the image where it is time for one.
    pub fn step(&mut self) -> Result<Option<Image>> {
        if self.is_enough() {
            return Ok(None);
        }
        self.session.advance(Some(STEP))?;
        let due = self.shown.is_none_or(|at| at.elapsed() > BETWEEN_IMAGES);
        if !(due && self.session.has_image() && self.session.is_whole()) {
            return Ok(None);
        }
        self.shown = Some(Instant::now());
        Ok(Some(self.session.glance()?.image))
    }
}
