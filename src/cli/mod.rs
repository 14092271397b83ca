//! The command line: one file per command, and how anything is said to the user.
//!
//! Every failure is one line on standard error that begins with `error: `, and an exit status: 2 for bad usage or
//! input, 1 for anything else. Nothing a user can cause shows a panic or a backtrace.

mod compare;
mod devices;
mod info;
mod options;
mod render;
mod study;
#[cfg(feature = "viewer")]
mod view;

use std::env;
use std::io::{self, Write};
use std::panic;
use std::path::Path;
use std::process::{self, ExitCode};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

use crate::{Error, Result, panics};

/// Ensemble Metropolis light transport: renders glTF scenes on any Vulkan device, software included.
#[derive(Debug, Parser)]
#[command(name = "emlt", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Arguments),
    #[cfg(feature = "viewer")]
    View(view::Arguments),
    Compare(compare::Arguments),
    Study(study::Arguments),
    Info(info::Arguments),
    Devices(devices::Arguments),
}

/// Runs the program on this process's arguments.
pub fn main() -> ExitCode {
    panic::set_hook(Box::new(report_panic));
    silence_device_select();
    let done = match Cli::try_parse() {
        Ok(cli) => match cli.command {
            Command::Render(arguments) => render::run(&arguments),
            #[cfg(feature = "viewer")]
            Command::View(arguments) => view::run(&arguments),
            Command::Compare(arguments) => compare::run(&arguments),
            Command::Study(arguments) => study::run(&arguments),
            Command::Info(arguments) => info::run(&arguments),
            Command::Devices(arguments) => devices::run(&arguments),
        },
        Err(e) if matches!(e.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            print(&e.render().to_string())
        }
        Err(e) => Err(Error::input(usage_sentence(&e))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say("error", &error.to_string());
            ExitCode::from(error.exit_status())
        }
    }
}

/// Keeps Mesa's device-select layer out where no desktop session runs: it looks for one and then says
/// "error: XDG_RUNTIME_DIR is invalid or not set" on our standard error. emlt chooses its device itself.
fn silence_device_select() {
    let session = env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_absolute());
    if !session && env::var_os("NODEVICE_SELECT").is_none() {
        // SAFETY: this is the start of the program, so no other thread reads the environment.
        unsafe { env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// One line on standard error. A standard error that is closed is no reason to fail.
fn say(kind: &str, sentence: &str) {
    let _ = writeln!(io::stderr(), "{kind}: {}", one_line(sentence));
}

/// Text on standard output. A reader that has seen enough (`emlt info scene.glb | head -1`) is no error.
fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::runtime(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Without line breaks and other control characters, which may come from a file's name or a driver.
fn one_line(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The parser's message without its usage block, and where to find out more.
fn usage_sentence(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "no command given: try 'emlt render SCENE', or see 'emlt --help'".into();
    }
    let text = error.render().to_string();
    let end = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|s| text.find(s)).min();
    let message = &text[..end.unwrap_or(text.len())];
    let message = one_line(message.strip_prefix("error: ").unwrap_or(message));
    format!("{message} (see 'emlt --help')")
}

/// Says a panic as one sentence and ends the process; of several threads that panic, the first one speaks.
/// One that is going to be caught is left to who catches it.
fn report_panic(info: &panic::PanicHookInfo<'_>) {
    if panics::caught_here() {
        return;
    }
    static SAID: AtomicBool = AtomicBool::new(false);
    if SAID.swap(true, Ordering::SeqCst) {
        return;
    }
    let payload = info.payload();
    let message = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown");
    let place = info.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
    say("error", &format!("internal fault{place} ({message}): please report it with the command line"));
    process::exit(1);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn a_sentence_stays_on_one_line() {
        assert_eq!(one_line("a\nfile\u{1b}[31m  name"), "a file [31m name");
    }

    #[test]
    fn usage_errors_become_one_sentence() {
        let sentence = |arguments: &[&str]| usage_sentence(&Cli::try_parse_from(arguments).unwrap_err());
        assert_eq!(
            sentence(&["emlt", "render"]),
            "the following required arguments were not provided: <SCENE> (see 'emlt --help')"
        );
        assert!(sentence(&["emlt"]).starts_with("no command given"));
        assert!(sentence(&["emlt", "render", "a.glb", "--sead", "1"]).contains("'--seed'"));
        let size = sentence(&["emlt", "render", "a.glb", "--size", "3by4"]);
        assert!(size.contains("640x480"), "{size}");
    }
}
