//! The runs of a study, until they are done or interrupted.

use std::fs;
use std::path::{Path, PathBuf};

use super::folder::{Figures, Finished, Folder};
use super::plan::{Kind, Plan, Run};
use super::progress::{Bar, Watch};
use super::references::{self, Reference};
use super::report::Journal;
use super::{Findings, threads};
use crate::film::{exr, flip};
use crate::gpu::context::Context;
use crate::kernels::guided_lens;
use crate::methods::{Outcome, Settings, render_on};
use crate::report::statistics::Statistics;
use crate::scene::import::import;
use crate::scene::{Scene, environment};
use crate::{Error, Result};

/// The map that lights a scene which has no light of its own.
const SKIES: [(&str, &str); 1] = [("displaced_wall", "sky.hdr")];

/// Makes every run that is missing.
pub fn finish(plan: &Plan, quiet: bool) -> Result<(Findings, Journal)> {
    let files = scene_files(plan)?;
    let context = Context::open(plan.asked.device.as_deref())?;
    if plan.runs.iter().any(|run| matches!(run.kind, Kind::Threads(_))) {
        threads::check(&context)?;
    }
    let mut folder = Folder::open(plan, &context.description)?;
    let load_before = load();
    let mut journal = Journal::new(&context, load_before);
    let missing = plan.runs.len() - done(&folder, plan, &files);
    let mut bar = Bar::new(plan.runs.len() + files.len(), quiet);
    let mut references = Vec::new();
    let mut runs = Vec::new();
    for file in &files {
        let scene = file.read()?;
        let reference = if plan.study.compares {
            let found = reference(plan, &context, &folder, file, &scene, &mut bar)?;
            let Some(found) = found else { return Err(interrupted(&folder, plan, &files)) };
            Some(found)
        } else {
            None
        };
        bar.step();
        for run in plan.runs.iter().filter(|run| run.scene == file.name) {
            if folder.finished(run, file.hash).is_none() {
                bar.begin(&run.label());
                let work =
                    Work { context: &context, folder: &folder, file, scene: &scene, reference: reference.as_ref() };
                let made = work.perform(run, &mut bar).map_err(|error| named(error, run));
                let Some(figures) = made? else { return Err(interrupted(&folder, plan, &files)) };
                folder.append(run, file.hash, &figures)?;
            }
            runs.extend(folder.finished(run, file.hash));
            bar.step();
        }
        references.extend(reference);
    }
    if runs.len() < plan.runs.len() {
        return Err(Error::runtime(format!("{} has lost rows: run again", folder.path.display())));
    }
    // In the plan's order, not in that of the scenes.
    let place = |f: &Finished| plan.runs.iter().position(|run| run.label() == f.run.label());
    runs.sort_by_key(place);
    journal.ended(load(), missing, plan.runs.len());
    Ok((Findings { asked: plan.asked.clone(), runs, references, load: load_before }, journal))
}

fn named(error: Error, run: &Run) -> Error {
    let sentence = format!("{}: {error}", run.label());
    match error {
        Error::Input(_) => Error::Input(sentence),
        Error::Runtime(_) => Error::Runtime(sentence),
    }
}

/// How many runs of the plan are finished.
fn done(folder: &Folder, plan: &Plan, files: &[SceneFile]) -> usize {
    let is_finished = |run: &&Run| {
        let file = files.iter().find(|file| file.name == run.scene);
        file.is_some_and(|file| folder.finished(run, file.hash).is_some())
    };
    plan.runs.iter().filter(is_finished).count()
}

fn interrupted(folder: &Folder, plan: &Plan, files: &[SceneFile]) -> Error {
    Error::runtime(format!(
        "interrupted after {} of {} runs, which are kept in {}: the same command goes on from there",
        done(folder, plan, files),
        plan.runs.len(),
        folder.path.display()
    ))
}

/// The load average of the last minute, where the system tells.
pub fn load() -> Option<f64> {
    fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// A scene's file.
pub struct SceneFile {
    pub name: String,
    pub path: PathBuf,
    /// The map around it.
    pub sky: Option<PathBuf>,
    /// Of the bytes of both.
    hash: u64,
}

impl SceneFile {
    fn read(&self) -> Result<Scene> {
        let mut scene = import(&self.path)?;
        if let Some(sky) = &self.sky {
            scene.set_environment(environment::read(sky)?);
        }
        Ok(scene)
    }
}

/// The files of the plan's scenes.
fn scene_files(plan: &Plan) -> Result<Vec<SceneFile>> {
    let folder = &plan.asked.scene_folder;
    let file = |name: &String| {
        let mut candidates = ["glb", "gltf"].map(|extension| folder.join(format!("{name}.{extension}"))).into_iter();
        let path = candidates.find(|path| path.is_file()).ok_or_else(|| {
            Error::input(format!(
                "there is no {name}.glb in {}: say with --scenes DIR where the scenes are, or choose another --scene",
                folder.display()
            ))
        })?;
        let sky = SKIES.iter().find(|(scene, _)| scene == name).map(|(_, sky)| folder.join(sky));
        let mut hash = FNV_START;
        for part in [Some(&path), sky.as_ref()].into_iter().flatten() {
            let bytes = fs::read(part)
                .map_err(|e| Error::input(format!("cannot read {} ({e}): choose other --scenes", part.display())))?;
            hash = fnv(hash, &bytes);
        }
        Ok(SceneFile { name: name.clone(), path, sky, hash })
    };
    plan.asked.scenes.iter().map(file).collect()
}

const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// Fowler, Noll and Vo's hash (FNV-1a, 64 bits), which is the same in every version of everything.
fn fnv(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The reference of a scene, made where it is missing; none where that was interrupted.
fn reference(
    plan: &Plan,
    context: &Context,
    folder: &Folder,
    file: &SceneFile,
    scene: &Scene,
    bar: &mut Bar,
) -> Result<Option<Reference>> {
    let path = folder.reference(&file.name);
    if let Some(there) = references::read(&path, &file.name, file.hash)? {
        return Ok(Some(there));
    }
    if let Some(known) = references::known(&plan.asked, &file.name) {
        references::take(&known, &path, file.hash)?;
    } else {
        bar.begin(&format!("{} reference", file.name));
        let settings = references::settings(&plan.asked, &file.name);
        let outcome = render_on(context, scene, &settings, &mut Watch::new(bar))?;
        if outcome.statistics.interrupted || bar.is_interrupted() {
            return Ok(None);
        }
        references::keep(&outcome, &settings, &path, file.hash)?;
    }
    references::read(&path, &file.name, file.hash)
}

/// What a run needs.
struct Work<'a> {
    context: &'a Context,
    folder: &'a Folder,
    file: &'a SceneFile,
    scene: &'a Scene,
    reference: Option<&'a Reference>,
}

impl Work<'_> {
    /// The figures of the run, its image written; none where it was interrupted.
    fn perform(&self, run: &Run, bar: &mut Bar) -> Result<Option<Vec<Figures>>> {
        if let Kind::Threads(threads) = run.kind {
            let figures = threads::measure(self.file, run, threads, &self.folder.path)?;
            return Ok((!bar.is_interrupted()).then(|| vec![Figures { load: load(), ..figures }]));
        }
        let looks = |outcome: &Outcome| self.figures(outcome, &run.settings);
        let mut watch = Watch::new(bar);
        if run.kind == Kind::Curve {
            watch.look_with(&looks);
        }
        let outcome = render_on(self.context, self.scene, &run.settings, &mut watch)?;
        let mut figures = watch.into_figures();
        // An interrupt that came before there was an image ends the run all the same.
        if outcome.statistics.interrupted || bar.is_interrupted() {
            return Ok(None);
        }
        if figures.is_empty() {
            figures.push(self.figures(&outcome, &run.settings)?);
        }
        if run.kind == (Kind::Image { kept: true }) {
            exr::write(&self.folder.image(run), &outcome.image, &outcome.channels, &[])?;
        }
        Ok(Some(figures))
    }

    fn figures(&self, outcome: &Outcome, settings: &Settings) -> Result<Figures> {
        let s = &outcome.statistics;
        let pixels = f64::from(settings.width) * f64::from(settings.height);
        let mut figures = Figures {
            samples: Some(s.samples as f64),
            samples_per_pixel: Some(s.samples as f64 / pixels),
            start_s: Some(s.seeding_s),
            render_s: Some(s.render_s),
            estimated_error: s.error.map(|error| error.pixels),
            guided_acceptance: guided_acceptance(s),
            load: load(),
            ..Figures::default()
        };
        if let Some(reference) = self.reference {
            let errors = reference.compare(&outcome.image)?;
            figures.mse = Some(errors.mse);
            figures.rel_mse = Some(errors.rel_mse);
            figures.rel_mse_4x4 = Some(errors.rel_mse_blocks);
            figures.flip = Some(flip::mean_flip(&outcome.image, &reference.image)?);
            figures.luminance = Some(reference.luminance);
        }
        Ok(figures)
    }
}

/// Accepted share of guided lens perturbations.
fn guided_acceptance(statistics: &Statistics) -> Option<f64> {
    let guided = || statistics.kernels.iter().filter(|kernel| kernel.name == guided_lens::KERNEL.name);
    let made: u64 = guided().map(|kernel| kernel.mutations).sum();
    let accepted: u64 = guided().map(|kernel| kernel.accepted).sum();
    (made > 0).then(|| accepted as f64 / made as f64)
}

/// The image of a finished run that was kept.
pub fn image(finished: &Finished) -> Result<exr::ExrFile> {
    let path = finished.image.as_deref().unwrap_or(Path::new(""));
    exr::read(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        // Of the test suite of its authors (draft-eastlake-fnv).
        assert_eq!(fnv(FNV_START, b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv(FNV_START, b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv(FNV_START, b"foobar"), 0x8594_4171_f739_67e8);
    }
}
