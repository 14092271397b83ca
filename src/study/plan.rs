//! What a study was asked for, and the runs that follow.

use std::path::PathBuf;

use super::Study;
use crate::methods::{Budget, Method, Settings, default_two_stage};
use crate::{Error, Result};

/// The scenes that studies over all scenes take.
pub const SCENES: [&str; 6] = ["cornell", "ajar", "shards", "kitchen", "displaced_wall", "bathroom"];

/// What a study takes unless told otherwise; with these it ends in less than 10 minutes on two idle cores.
pub struct Defaults {
    pub scenes: &'static [&'static str],
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub budget: Budget,
    pub seeds: u32,
    /// Mutations (by path tracing: samples) per pixel of references that have to be rendered.
    pub reference_spp: u32,
}

/// What was asked for, defaults filled in.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Names of scenes, without folder and extension.
    pub scenes: Vec<String>,
    /// Where they are.
    pub scene_folder: PathBuf,
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub budget: Budget,
    pub seeds: Vec<u32>,
    /// Mutations (by path tracing: samples) per pixel of references that the study renders.
    pub reference_spp: u32,
    pub device: Option<String>,
    /// Where everything goes.
    pub out: PathBuf,
    /// As typed, for the report.
    pub command_line: String,
}

impl Asked {
    /// A run over `scene`, which the caller changes as the study wants it.
    pub fn run(&self, scene: &str, variant: impl Into<String>, method: Method, seed: u32) -> Run {
        let [width, height] = self.size;
        let device = self.device.clone();
        let two_stage = default_two_stage(method);
        let settings =
            Settings { method, width, height, budget: self.budget, seed, device, two_stage, ..Settings::default() };
        Run { scene: scene.into(), variant: variant.into(), settings, kind: Kind::Image { kept: false } }
    }

    /// The same, with its image kept.
    pub fn kept(&self, scene: &str, variant: impl Into<String>, method: Method, seed: u32) -> Run {
        Run { kind: Kind::Image { kept: true }, ..self.run(scene, variant, method, seed) }
    }

    /// A run of every scene, seed and variant.
    pub fn runs<V: Copy, const N: usize>(&self, variants: [V; N], run: impl Fn(&str, V, u32) -> Run) -> Vec<Run> {
        let run = &run;
        let of_scene =
            |scene| self.seeds.iter().flat_map(move |seed| variants.map(|variant| run(scene, variant, *seed)));
        self.scenes.iter().flat_map(|scene| of_scene(scene.as_str())).collect()
    }

    /// The scene of a study of one scene.
    pub fn only_scene(&self, study: &str) -> Result<&str> {
        match self.scenes.as_slice() {
            [scene] => Ok(scene),
            _ => Err(Error::input(format!("study {study} takes one scene: give --scene once"))),
        }
    }
}

/// One render of a study.
#[derive(Debug, Clone)]
pub struct Run {
    pub scene: String,
    /// What is compared, in a word or two.
    pub variant: String,
    pub settings: Settings,
    pub kind: Kind,
}

/// What is wanted of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Its figures, and the image where it is kept.
    Image { kept: bool },
    /// Its figures at growing numbers of samples.
    Curve,
    /// Its speed on so many threads of the software driver, in a process of its own.
    Threads(u32),
}

/// The names of the columns of [`Run::key`].
pub const KEY_COLUMNS: &str =
    "scene,scene_hash,variant,method,size,budget,seed,ensemble,groups,alpha,similarity,max_depth,maps,threads";

impl Run {
    /// All settings that decide the result, as the first columns of a row of the runs file; `scene_hash` is of the scene's
    /// file.
    pub fn key(&self, scene_hash: u64) -> String {
        let s = &self.settings;
        let threads = if let Kind::Threads(n) = self.kind { n.to_string() } else { String::new() };
        let similarity = if s.guidance.normals { "normals" } else { "positions" };
        [
            self.scene.clone(),
            format!("{scene_hash:016x}"),
            self.variant.clone(),
            s.method.name().into(),
            format!("{}x{}", s.width, s.height),
            budget_name(s.budget),
            s.seed.to_string(),
            s.ensemble.to_string(),
            s.groups.to_string(),
            format!("{}..{}", s.guidance.alpha[0], s.guidance.alpha[1]),
            similarity.into(),
            s.max_depth.to_string(),
            s.maps.to_string(),
            threads,
        ]
        .join(",")
    }

    /// For progress and file names: unique in a plan.
    pub fn label(&self) -> String {
        let threads = if let Kind::Threads(n) = self.kind { format!(" {n} threads") } else { String::new() };
        format!("{} {} seed {}{threads}", self.scene, self.variant, self.settings.seed)
    }
}

/// A budget in words.
pub fn budget_name(budget: Budget) -> String {
    match budget {
        Budget::SamplesPerPixel(n) => format!("{n} per pixel"),
        Budget::Seconds(s) => format!("{s} s"),
    }
}

/// A study with its runs.
pub struct Plan<'a> {
    pub study: &'a Study,
    pub asked: Asked,
    pub runs: Vec<Run>,
}
