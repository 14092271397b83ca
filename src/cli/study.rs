//! `emlt study`: the supplement's experiments.

use std::env;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValue;

use super::options::parse_size;
use super::render::parse_seconds;
use crate::methods::Budget;
use crate::study::{self, Asked, STUDIES, Study};
use crate::{Error, Result};

/// Repeat one of the supplement's experiments: renders, tables, plots and a report in a folder. Ctrl-C keeps what is
/// finished, and the same command goes on from there
#[derive(Debug, Args)]
pub struct Arguments {
    /// The experiment
    #[arg(value_name = "NAME")]
    name: Name,

    /// Folder for report, plots and figures of every run [default: study-NAME]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Scenes by name, without folder and extension [default: the supplement's]
    #[arg(long, value_name = "SCENE")]
    scene: Vec<String>,

    /// Where the scenes are
    #[arg(long, value_name = "DIR", default_value = "scenes")]
    scenes: PathBuf,

    /// Image size in pixels; where the repository has a reference of that size, it is used [default: the study's own]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,

    /// Mutations (pt: samples) per pixel of each run [default: the study's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,

    /// Render each run for this long instead
    #[arg(long, value_name = "SECONDS", conflicts_with = "spp", value_parser = parse_seconds)]
    time: Option<f64>,

    /// Independent repeats, whose scatter tells what can be decided [default: the study's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,

    /// The first of their seeds
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=1_000_000_000))]
    first_seed: u32,

    /// Mutations per pixel of references that have to be rendered [default: the study's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    reference_spp: Option<u32>,

    /// Device by a part of its name [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,

    /// Show no progress
    #[arg(short, long)]
    quiet: bool,
}

/// A study, as an argument.
#[derive(Clone, Copy)]
struct Name(&'static Study);

impl std::fmt::Debug for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name)
    }
}

impl clap::ValueEnum for Name {
    fn value_variants<'a>() -> &'a [Self] {
        const NAMES: [Name; STUDIES.len()] = {
            let mut names = [Name(STUDIES[0]); STUDIES.len()];
            let mut i = 0;
            while i < names.len() {
                names[i] = Name(STUDIES[i]);
                i += 1;
            }
            names
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name).help(self.0.about))
    }
}

/// Runs the study and says on standard output where its report is, and what has come of the supplement's claims.
pub fn run(arguments: &Arguments) -> Result<()> {
    let Name(study) = arguments.name;
    let defaults = &study.defaults;
    if !arguments.scenes.is_dir() {
        return Err(Error::input(format!(
            "there is no folder {}: say with --scenes DIR where the scenes are",
            arguments.scenes.display()
        )));
    }
    let mut scenes = arguments.scene.clone();
    if let Some(name) = scenes.iter().find(|name| name.is_empty() || name.contains(['/', '\\', ',', '"', '\n'])) {
        return Err(Error::input(format!(
            "'{name}' is not the name of a scene: leave out folder and extension, and give the folder as --scenes"
        )));
    }
    if scenes.is_empty() {
        scenes = defaults.scenes.iter().map(|name| (*name).to_string()).collect();
    }
    let mut seen = std::collections::HashSet::new();
    scenes.retain(|scene| seen.insert(scene.clone()));
    let budget = match (arguments.spp, arguments.time) {
        (Some(count), _) => Budget::SamplesPerPixel(count),
        (None, Some(seconds)) => Budget::Seconds(seconds),
        (None, None) => defaults.budget,
    };
    let first = arguments.first_seed;
    let asked = Asked {
        scenes,
        scene_folder: arguments.scenes.clone(),
        size: arguments.size.map_or(defaults.size, Into::into),
        budget,
        seeds: (first..first + arguments.seeds.unwrap_or(defaults.seeds)).collect(),
        reference_spp: arguments.reference_spp.unwrap_or(defaults.reference_spp),
        device: arguments.device.clone(),
        out: arguments.output.clone().unwrap_or_else(|| format!("study-{}", study.name).into()),
        command_line: command_line(),
    };
    let said = study::perform(study, asked, arguments.quiet)?;
    super::print(&said.iter().map(|sentence| super::one_line(sentence) + "\n").collect::<String>())
}

/// As typed, but for the program's folder.
fn command_line() -> String {
    let words = env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let quoted = |word: String| if word.contains(' ') { format!("'{word}'") } else { word };
    super::one_line(&std::iter::once("emlt".into()).chain(words.map(quoted)).collect::<Vec<_>>().join(" "))
}
