//! `emlt study`: the supplement's experiments, each from its renders to a one-page report.
//!
//! A study is a plan of runs and what to make of them. [`perform`] makes the runs that are missing in the study's folder,
//! each a row of its runs file or some, and then has the study write tables, plots, pictures and claims into its report.
//! The parts:
//! - [`plan`]: what was asked for, and the runs that follow from it
//! - [`folder`]: the study's folder: its settings, the runs file, images
//! - [`references`]: what the images should be
//! - [`work`]: the runs themselves, with progress, until they are done or interrupted
//! - [`progress`]: the bar, and Ctrl-C
//! - [`statistics`]: scatter between seeds, ratios, slopes
//! - [`axes`], [`plot`], [`panels`], [`insets`]: line plots (SVG and PNG) and pictures side by side (PNG)
//! - [`report`]: the page
//! - one file a study

mod alpha;
mod axes;
mod caustics;
mod convergence;
mod detail;
mod ensemble_size;
mod folder;
mod insets;
mod maps;
mod normals;
mod panels;
mod plan;
mod plot;
mod progress;
mod references;
mod report;
mod statistics;
mod threads;
mod work;

pub use plan::{Asked, Defaults};

use crate::Result;
use folder::{Figures, Finished};
use plan::{Plan, Run};
use references::Reference;
use report::{Report, short};
use statistics::{Interval, mean};

/// One of the supplement's experiments.
pub struct Study {
    /// The name on the command line.
    pub name: &'static str,
    /// One line of what is compared.
    pub about: &'static str,
    pub defaults: Defaults,
    /// Whether images are compared with what they should be.
    compares: bool,
    /// The runs, in the order in which they are made.
    runs: fn(&Asked) -> Result<Vec<Run>>,
    /// Tables, plots, pictures and claims from the finished runs.
    conclude: fn(&Findings, &mut Report) -> Result<()>,
}

/// Every study.
pub const STUDIES: [&Study; 7] = [
    &alpha::STUDY,
    &ensemble_size::STUDY,
    &threads::STUDY,
    &maps::STUDY,
    &normals::STUDY,
    &caustics::STUDY,
    &convergence::STUDY,
];

/// What a study has to conclude from: its plan's runs, all finished.
struct Findings {
    asked: Asked,
    runs: Vec<Finished>,
    references: Vec<Reference>,
    /// The load average before the runs, where the system tells.
    load: Option<f64>,
}

/// The columns of [`Findings::errors`].
const ERRORS: [&str; 5] = ["MSE", "relMSE", "relMSE of 4x4", "FLIP", "guided lens steps accepted"];

/// A load average from which on other work is taken to slow the runs.
const BUSY: f64 = 0.5;

impl Findings {
    /// The runs of a scene (any, where none is named) and variant, by seed.
    fn of<'a>(&'a self, scene: Option<&'a str>, variant: &'a str) -> impl Iterator<Item = &'a Finished> {
        self.runs.iter().filter(move |f| scene.is_none_or(|scene| f.run.scene == scene) && f.run.variant == variant)
    }

    /// A figure at the end of each of those runs; what is not known is NaN.
    fn values(&self, scene: Option<&str>, variant: &str, figure: fn(&Figures) -> Option<f64>) -> Vec<f64> {
        self.of(scene, variant).map(|f| figure(f.last()).unwrap_or(f64::NAN)).collect()
    }

    /// A figure of one variant over that of another, seed by seed.
    fn ratio(&self, scene: &str, [a, b]: [&str; 2], figure: fn(&Figures) -> Option<f64>) -> Interval {
        Interval::of_ratio(&self.values(Some(scene), a, figure), &self.values(Some(scene), b, figure))
    }

    /// Means over the seeds, as [`ERRORS`] names them.
    fn errors(&self, scene: &str, variant: &str) -> [String; 5] {
        let value = |figure| mean(&self.values(Some(scene), variant, figure));
        [
            short(value(|f| f.mse)),
            short(value(|f| f.rel_mse)),
            short(value(|f| f.rel_mse_4x4)),
            short(value(|f| f.flip)),
            format!("{:.1} %", 100.0 * value(|f| f.guided_acceptance)),
        ]
    }

    /// A sentence for studies of time where the machine had other work when they began.
    fn busy(&self) -> Option<String> {
        let load = self.load.filter(|load| *load > BUSY)?;
        Some(format!(
            "The machine had other work (load average {load:.2} before the runs), so these times tell little."
        ))
    }

    /// What the images of a scene should be.
    fn reference(&self, scene: &str) -> Option<&Reference> {
        self.references.iter().find(|reference| reference.scene == scene)
    }
}

/// Makes what is missing of a study and writes its report; the returned sentences say where it is.
///
/// # Errors
/// [`crate::Error::Input`] for scenes that are not there and a folder that holds something else, [`crate::Error::Runtime`]
/// where device or disk fail, and where it was interrupted: finished runs are kept, and the same call goes on.
pub fn perform(study: &Study, asked: Asked, quiet: bool) -> Result<Vec<String>> {
    let runs = (study.runs)(&asked)?;
    let plan = Plan { study, asked, runs };
    let (findings, journal) = work::finish(&plan, quiet)?;
    let mut report = Report::new(study, &findings, journal)?;
    (study.conclude)(&findings, &mut report)?;
    report.write()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Runs are told apart by their key in the runs file and by their label among images.
    #[test]
    fn no_two_runs_of_a_study_are_alike() {
        for study in STUDIES {
            let defaults = &study.defaults;
            let asked = Asked {
                scenes: defaults.scenes.iter().map(|scene| (*scene).into()).collect(),
                scene_folder: "scenes".into(),
                size: defaults.size,
                budget: defaults.budget,
                seeds: (1..=defaults.seeds).collect(),
                reference_spp: defaults.reference_spp,
                device: None,
                out: "out".into(),
                command_line: String::new(),
            };
            let runs = (study.runs)(&asked).unwrap();
            let keys: HashSet<String> = runs.iter().map(|run| run.key(1)).collect();
            let labels: HashSet<String> = runs.iter().map(Run::label).collect();
            assert!(!runs.is_empty() && defaults.seeds > 1, "{}", study.name);
            assert_eq!([keys.len(), labels.len()], [runs.len(); 2], "{}", study.name);
            assert!(keys.iter().all(|key| key.split(',').count() == plan::KEY_COLUMNS.split(',').count()));
        }
    }
}
