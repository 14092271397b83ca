//! The interactive window: `emlt view`.
//!
//! Two threads and two channels: the window's, with all that is shown and asked for ([`app`] and its panels), and the
//! renderer's ([`worker`]); [`messages`] is what they say. The panels only change settings and say that they did; what
//! follows from it is in [`app`].

mod app;
mod canvas;
mod command_line;
mod curve;
mod display;
mod files;
mod keys;
mod launch;
mod legend;
mod messages;
mod orbit;
mod overlay;
mod preview;
#[cfg(test)]
mod renderer_tests;
mod saving;
mod screen;
mod settings;
mod slot;
mod statistics;
#[cfg(test)]
mod tests;
mod tone;
mod watch;
#[cfg(test)]
mod window;
#[cfg(test)]
mod window_tests;
mod worker;

pub use launch::{Launch, check_display, run};
