//! Progress over the runs of a study, and Ctrl-C.

use std::io::{self, Write};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::folder::Figures;
use crate::Result;
use crate::methods::{Observer, Outcome};

/// Steps of the bar a run.
const STEPS: u64 = 1000;
/// The exit status that shells give a process ended by Ctrl-C.
const INTERRUPTED: i32 = 130;

/// A bar over all runs of a study; hidden when quiet, or where standard error is no terminal.
pub struct Bar {
    bar: ProgressBar,
    done: u64,
    stop: Arc<AtomicBool>,
}

impl Bar {
    /// From now on the first Ctrl-C asks to stop, and the second one quits at once.
    pub fn new(runs: usize, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(runs as u64 * STEPS), target);
        if let Ok(style) =
            ProgressStyle::with_template("[{bar:30}] {percent:>3} %  {elapsed} elapsed, {eta} left  {msg}")
        {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(500));
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let _ = ctrlc::try_set_handler(move || {
            if asked.swap(true, Ordering::Relaxed) {
                process::exit(INTERRUPTED);
            }
            if !quiet {
                let words = "\nstopping; what is finished is kept, Ctrl-C again quits at once";
                let _ = writeln!(io::stderr(), "{words}");
            }
        });
        Self { bar, done: 0, stop }
    }

    /// A run begins.
    pub fn begin(&self, label: &str) {
        self.bar.set_message(label.to_string());
    }

    /// A run is finished, or was so already.
    pub fn step(&mut self) {
        self.done += 1;
        self.bar.set_position(self.done * STEPS);
    }

    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

type Look<'a> = &'a dyn Fn(&Outcome) -> Result<Figures>;

/// Watches one run.
pub struct Watch<'a> {
    bar: &'a Bar,
    rendering: bool,
    look: Option<Look<'a>>,
    figures: Vec<Figures>,
}

impl<'a> Watch<'a> {
    pub fn new(bar: &'a Bar) -> Self {
        Self { bar, rendering: false, look: None, figures: Vec::new() }
    }

    /// Has the figures taken at growing numbers of samples.
    pub fn look_with(&mut self, look: Look<'a>) {
        self.look = Some(look);
    }

    /// Those that were taken.
    pub fn into_figures(self) -> Vec<Figures> {
        self.figures
    }
}

impl Observer for Watch<'_> {
    fn stage(&mut self, name: &str) {
        self.rendering = name == "rendering";
    }

    fn progress(&mut self, share: f64) {
        if self.rendering {
            self.bar.bar.set_position(self.bar.done * STEPS + (share.clamp(0.0, 1.0) * STEPS as f64) as u64);
        }
    }

    fn looks(&self) -> bool {
        self.look.is_some()
    }

    fn look(&mut self, outcome: &Outcome) -> Result<()> {
        if let Some(look) = self.look {
            let figures = look(outcome)?;
            if self.figures.last().and_then(|last| last.samples) != figures.samples {
                self.figures.push(figures);
            }
        }
        Ok(())
    }

    fn stop_requested(&self) -> bool {
        self.bar.is_interrupted()
    }
}
