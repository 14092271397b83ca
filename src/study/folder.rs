//! The folder of a study: its settings, the runs that are finished, and their images.
//!
//! A finished run is a row, or some, at the end of `runs.csv`, written in one piece. What an interrupted write has left of
//! a row is cut off; a run is only taken for finished where its last row is there, and its image where it is kept.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::plan::{KEY_COLUMNS, Kind, Plan, Run, budget_name};
use crate::film::file::write_whole;
use crate::{Error, Result};

/// What a run has been measured to do, at its end or on the way. What is not known is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Figures {
    /// Mutations (mlt, emlt) or samples (pt).
    pub samples: Option<f64>,
    pub samples_per_pixel: Option<f64>,
    /// Seconds of finding start paths and b.
    pub start_s: Option<f64>,
    pub render_s: Option<f64>,
    /// Against the reference, whose own noise is subtracted (but not of FLIP).
    pub mse: Option<f64>,
    pub rel_mse: Option<f64>,
    /// Of means of 4x4 pixels.
    pub rel_mse_4x4: Option<f64>,
    pub flip: Option<f64>,
    /// Mean luminance of the reference.
    pub luminance: Option<f64>,
    /// Root of relMSE as the image tells it of itself.
    pub estimated_error: Option<f64>,
    /// Accepted share of guided lens perturbations.
    pub guided_acceptance: Option<f64>,
    /// The system's load average of the last minute.
    pub load: Option<f64>,
}

const FIGURES: usize = 12;
const FIGURE_COLUMNS: &str = "samples,samples_per_pixel,start_s,render_s,mse,rel_mse,rel_mse_4x4,flip,luminance,estimated_error,guided_acceptance,load";

impl Figures {
    fn fields(&self) -> [Option<f64>; FIGURES] {
        let Self { samples, samples_per_pixel, start_s, render_s, mse, rel_mse, .. } = *self;
        let Self { rel_mse_4x4, flip, luminance, estimated_error, guided_acceptance, load, .. } = *self;
        [
            samples,
            samples_per_pixel,
            start_s,
            render_s,
            mse,
            rel_mse,
            rel_mse_4x4,
            flip,
            luminance,
            estimated_error,
            guided_acceptance,
            load,
        ]
    }

    fn from_fields(fields: [Option<f64>; FIGURES]) -> Self {
        let [samples, samples_per_pixel, start_s, render_s, mse, rel_mse, ..] = fields;
        let [.., rel_mse_4x4, flip, luminance, estimated_error, guided_acceptance, load] = fields;
        Self {
            samples,
            samples_per_pixel,
            start_s,
            render_s,
            mse,
            rel_mse,
            rel_mse_4x4,
            flip,
            luminance,
            estimated_error,
            guided_acceptance,
            load,
        }
    }

    /// Mutations or samples a second of rendering.
    pub fn rate(&self) -> Option<f64> {
        Some(self.samples? / self.render_s?)
    }

    /// Seconds of start and rendering, without what is compiled once.
    pub fn seconds(&self) -> Option<f64> {
        Some(self.start_s? + self.render_s?)
    }
}

/// A run with what came of it.
#[derive(Debug, Clone)]
pub struct Finished {
    pub run: Run,
    /// In order of growing numbers of samples; never empty.
    pub figures: Vec<Figures>,
    /// Where its image is, if that is kept.
    pub image: Option<PathBuf>,
}

impl Finished {
    /// At its end.
    pub fn last(&self) -> &Figures {
        self.figures.last().expect("a finished run has figures")
    }
}

/// The folder, open for a study.
pub struct Folder {
    pub path: PathBuf,
    /// Whole rows of the runs file, without its header.
    rows: Vec<String>,
}

const SETTINGS: &str = "settings.txt";
const RUNS: &str = "runs.csv";
const IMAGES: &str = "images";
const REFERENCES: &str = "references";

impl Folder {
    /// Opens the folder or makes it. One that holds anything but the same study with the same settings is refused; other
    /// seeds and scenes may join.
    pub fn open(plan: &Plan, device: &str) -> Result<Self> {
        let path = plan.asked.out.clone();
        let settings = settings(plan, device);
        let file = path.join(SETTINGS);
        if let Ok(old) = fs::read_to_string(&file) {
            check_settings(&path, &old, &settings)?;
        } else {
            let occupied = fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_some());
            if occupied || path.is_file() {
                return Err(Error::input(format!(
                    "{} is there already and holds no study: choose another folder with -o",
                    path.display()
                )));
            }
            for folder in [path.clone(), path.join(IMAGES), path.join(REFERENCES)] {
                fs::create_dir_all(&folder)
                    .map_err(|e| Error::input(format!("cannot make the folder {}: {e}", folder.display())))?;
            }
            write_whole(&path.join(RUNS), format!("{}\n", header()).as_bytes())?;
            write_whole(&file, settings.as_bytes())?;
        }
        Self { path, rows: Vec::new() }.with_rows()
    }

    /// Reads the runs file and cuts off what is not whole.
    fn with_rows(mut self) -> Result<Self> {
        let file = self.path.join(RUNS);
        let text = fs::read_to_string(&file).map_err(|e| {
            Error::input(format!("cannot read {} ({e}): choose another folder with -o", file.display()))
        })?;
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole.lines();
        if lines.next() != Some(header().as_str()) {
            return Err(Error::input(format!(
                "{} has other columns than this version writes: choose another folder with -o",
                file.display()
            )));
        }
        self.rows = lines.map(str::to_string).collect();
        if whole.len() < text.len() {
            write_whole(&file, whole.as_bytes())?;
        }
        Ok(self)
    }

    /// What is there of a run, if it is finished.
    pub fn finished(&self, run: &Run, scene_hash: u64) -> Option<Finished> {
        let key = run.key(scene_hash) + ",";
        let mut figures = Vec::new();
        let mut ended = false;
        for rest in self.rows.iter().filter_map(|row| row.strip_prefix(&key)) {
            let (look, numbers) = rest.split_once(',')?;
            let fields: Vec<Option<f64>> = numbers.split(',').map(|field| field.parse().ok()).collect();
            figures.push(Figures::from_fields(fields.try_into().ok()?));
            ended |= look == "end";
        }
        let image = (run.kind == Kind::Image { kept: true }).then(|| self.image(run));
        let whole = ended && image.as_ref().is_none_or(|image| image.is_file());
        whole.then(|| Finished { run: run.clone(), figures, image })
    }

    /// Appends a finished run, whose image is written already.
    pub fn append(&mut self, run: &Run, scene_hash: u64, figures: &[Figures]) -> Result<()> {
        let key = run.key(scene_hash);
        let rows: Vec<String> = figures
            .iter()
            .enumerate()
            .map(|(number, row)| {
                let look = if number + 1 == figures.len() { "end" } else { "way" };
                let numbers = row.fields().map(|f| f.map_or(String::new(), |v| format!("{v:.9e}")));
                format!("{key},{look},{}", numbers.join(","))
            })
            .collect();
        let file = self.path.join(RUNS);
        let text: String = rows.iter().map(|row| format!("{row}\n")).collect();
        let written = OpenOptions::new()
            .append(true)
            .open(&file)
            .and_then(|mut open| open.write_all(text.as_bytes()).and_then(|()| open.sync_all()));
        written.map_err(|e| Error::runtime(format!("cannot write {}: {e}", file.display())))?;
        self.rows.extend(rows);
        Ok(())
    }

    /// Where the image of a run goes.
    pub fn image(&self, run: &Run) -> PathBuf {
        self.path.join(IMAGES).join(format!("{}.exr", run.label().replace([' ', '/'], "-")))
    }

    /// Where the reference of a scene goes.
    pub fn reference(&self, scene: &str) -> PathBuf {
        self.path.join(REFERENCES).join(format!("{scene}.exr"))
    }
}

fn header() -> String {
    format!("{KEY_COLUMNS},look,{FIGURE_COLUMNS}")
}

/// What must agree for runs to be told together.
fn settings(plan: &Plan, device: &str) -> String {
    let asked = &plan.asked;
    let [width, height] = asked.size;
    format!(
        "study: {}\nsize: {width}x{height}\nbudget: {}\nreference: {} per pixel\ndevice: {}\nversion: {}\n",
        plan.study.name,
        budget_name(asked.budget),
        asked.reference_spp,
        device.split_whitespace().collect::<Vec<_>>().join(" "),
        env!("CARGO_PKG_VERSION")
    )
}

/// Names the first line that differs.
fn check_settings(folder: &Path, old: &str, new: &str) -> Result<()> {
    let differing = new.lines().zip(old.lines().chain(std::iter::repeat(""))).find(|(new, old)| new != old);
    differing.map_or(Ok(()), |(new, old)| {
        Err(Error::input(format!(
            "{} holds a study of other settings ('{old}', not '{new}'): choose another folder with -o, or remove it",
            folder.display()
        )))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::{Budget, Method};
    use crate::study::{Asked, STUDIES};

    fn plan(out: &Path, spp: u32) -> Plan<'static> {
        let asked = Asked {
            scenes: vec!["ajar".into()],
            scene_folder: "scenes".into(),
            size: [16, 12],
            budget: Budget::SamplesPerPixel(spp),
            seeds: vec![1, 2],
            reference_spp: 8,
            device: None,
            out: out.to_path_buf(),
            command_line: String::new(),
        };
        let runs = vec![
            Run { kind: Kind::Curve, ..asked.run("ajar", "mlt", Method::Mlt, 1) },
            asked.run("ajar", "mlt", Method::Mlt, 12),
        ];
        Plan { study: STUDIES[0], asked, runs }
    }

    #[test]
    fn finished_runs_are_found_again_and_torn_ones_are_not() {
        let place = tempfile::tempdir().unwrap();
        let plan = plan(&place.path().join("out"), 8);
        let mut folder = Folder::open(&plan, "GPU").unwrap();
        let [curve, image] = [&plan.runs[0], &plan.runs[1]];
        let figures = [1.0, 2.0].map(|n| Figures { samples: Some(n), mse: Some(0.1), ..Default::default() });
        folder.append(curve, 7, &figures).unwrap();
        let again = Folder::open(&plan, "GPU").unwrap();
        assert_eq!(again.finished(curve, 7).unwrap().figures, figures);
        assert!(again.finished(image, 7).is_none() && again.finished(curve, 8).is_none());
        // A row that was cut short, and a run without its last row.
        let runs = folder.path.join(RUNS);
        let whole = fs::read_to_string(&runs).unwrap();
        fs::write(&runs, format!("{whole}{},end,1.0", image.key(7))).unwrap();
        let again = Folder::open(&plan, "GPU").unwrap();
        assert!(again.finished(image, 7).is_none() && again.finished(curve, 7).is_some());
        assert_eq!(fs::read_to_string(&runs).unwrap(), whole);
        fs::write(&runs, &whole[..whole.trim_end().rfind('\n').unwrap() + 1]).unwrap();
        assert!(Folder::open(&plan, "GPU").unwrap().finished(curve, 7).is_none());
    }

    #[test]
    fn other_settings_and_other_folders_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let out = place.path().join("out");
        Folder::open(&plan(&out, 8), "GPU").unwrap();
        for refused in [Folder::open(&plan(&out, 9), "GPU"), Folder::open(&plan(&out, 8), "other")] {
            let error = refused.err().unwrap();
            assert!(error.exit_status() == 2 && error.to_string().contains("other settings"), "{error}");
        }
        let error = Folder::open(&plan(place.path(), 8), "GPU").err().unwrap();
        assert!(error.to_string().contains("holds no study"), "{error}");
    }
}
