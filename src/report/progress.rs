//! The progress bar on standard error, and Ctrl-C.

use std::io::{self, Write};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Result;
use crate::methods::Outcome;
use crate::report::log::ErrorLog;
use crate::report::observer::Observer;
use crate::report::summary::percent;

/// Steps of the bar: finer than any terminal is wide, so that the estimate of the remaining time is smooth.
const STEPS: u64 = 10_000;

/// The exit status that shells give a process ended by Ctrl-C.
const INTERRUPTED: i32 = 130;

/// Shows stage, bar, elapsed and remaining time; shows nothing when quiet or when standard error is no terminal.
pub struct Progress {
    quiet: bool,
    shows_error: bool,
    log: Option<ErrorLog>,
    bar: Option<ProgressBar>,
    stop: Arc<AtomicBool>,
}

impl Progress {
    pub fn new(quiet: bool) -> Self {
        Self { quiet, shows_error: false, log: None, bar: None, stop: Arc::default() }
    }

    /// Shows the image's own error beside the stage.
    pub fn show_error(&mut self) {
        self.shows_error = !self.quiet;
    }

    /// Has every look at the image written down.
    pub fn keep_log(&mut self, log: ErrorLog) {
        self.log = Some(log);
    }

    /// From now on the first Ctrl-C asks the renderer to stop, and the second one quits at once.
    ///
    /// Works once per process; where the system refuses, Ctrl-C keeps ending the process.
    pub fn stop_on_interrupt(&self) {
        let (stop, quiet) = (Arc::clone(&self.stop), self.quiet);
        let _ = ctrlc::try_set_handler(move || {
            if stop.swap(true, Ordering::Relaxed) {
                process::exit(INTERRUPTED);
            }
            if !quiet {
                let words = "\nstopping after the current step to write the image; Ctrl-C again quits without it";
                let _ = writeln!(io::stderr(), "{words}");
            }
        });
    }

    fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn stage(&mut self, name: &str) {
        self.clear();
        if self.quiet {
            return;
        }
        // This target is hidden by itself where standard error is no terminal.
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        if let Ok(style) =
            ProgressStyle::with_template("{msg:18} [{bar:40}] {percent:>3} %  {elapsed} elapsed, {eta} left")
        {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(name.to_string());
        // A stage may report nothing for seconds (a driver compiling); the elapsed time still moves.
        bar.enable_steady_tick(Duration::from_millis(200));
        self.bar = Some(bar);
    }

    fn progress(&mut self, share: f64) {
        if let Some(bar) = &self.bar {
            bar.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
        }
    }

    fn looks(&self) -> bool {
        self.shows_error || self.log.is_some()
    }

    fn look(&mut self, outcome: &Outcome) -> Result<()> {
        if let (Some(bar), Some(error)) = (&self.bar, outcome.statistics.error) {
            bar.set_message(format!("rendering, {}", percent(error.pixels)));
        }
        self.log.as_mut().map_or(Ok(()), |log| log.row(outcome))
    }

    fn stop_requested(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quiet_has_no_bar() {
        let mut progress = Progress::new(true);
        progress.stage("rendering");
        progress.progress(0.5);
        assert!(progress.bar.is_none());
    }

    #[test]
    fn shares_outside_the_range_are_clipped() {
        let mut progress = Progress::new(false);
        progress.stage("rendering");
        for (share, position) in [(0.25, STEPS / 4), (2.0, STEPS), (-1.0, 0), (f64::NAN, 0)] {
            progress.progress(share);
            assert_eq!(progress.bar.as_ref().unwrap().position(), position, "{share}");
        }
    }

    #[test]
    fn a_stop_is_passed_on() {
        let progress = Progress::new(true);
        assert!(!progress.stop_requested());
        progress.stop.store(true, Ordering::Relaxed);
        assert!(progress.stop_requested());
    }
}
