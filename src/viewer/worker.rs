//! The renderer's thread: does what the window asks, and sends it pictures.
//!
//! It has a device of its own. On one that it shares with the window, the window's frames queue behind the renderer's
//! work, and waiting for the renderer's results holds up the window's submissions: see `launch`.

use std::collections::HashMap;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::messages::{ByKernel, Command, ErrorPoint, Event, Job, Opened, Outbox, OwnError, Picture};
use super::preview::Preview;
use crate::film::uncertainty::Uncertainty;
use crate::film::{Channel, Image, exr, metrics};
use crate::gpu::context::Context;
use crate::gpu::shader::Sources;
use crate::methods::{ACCEPTANCE, Outcome, Prepared, Session, Settings, Stage};
use crate::scene::environment;
use crate::scene::import::import;
use crate::scene::light::Environment;
use crate::scene::{Camera, Features, Scene};
use crate::{Error, Result};

/// A step of rendering takes about as long, so that commands are heard soon.
const STEP: Duration = Duration::from_millis(40);
/// Least time between pictures, and the largest share of time spent on making them.
const BETWEEN_PICTURES: Duration = Duration::from_millis(150);
const PICTURES_SHARE: f64 = 0.1;
/// Least time between estimates of an image's own error, and the largest share of time spent on them.
const BETWEEN_ESTIMATES: Duration = Duration::from_secs(1);
const ESTIMATES_SHARE: f64 = 0.05;
/// Least time between messages of progress.
const BETWEEN_PROGRESS: Duration = Duration::from_millis(100);

/// A scene with what was made of it for the device.
pub(super) struct Loaded {
    pub(super) scene: Scene,
    path: PathBuf,
    /// By the bits of the threshold below which lobes are specular.
    prepared: HashMap<u32, Prepared>,
}

impl Loaded {
    fn prepared(&mut self, settings: &Settings, camera: &Camera) -> Result<&Prepared> {
        let key = settings.specular_threshold().to_bits();
        if !self.prepared.contains_key(&key) {
            self.prepared
                .insert(key, Prepared::new(&self.scene, &Settings { camera: None, lens: None, ..settings.clone() })?);
        }
        let prepared = self.prepared.get_mut(&key).expect("just made");
        prepared.aim(&self.scene, camera, settings.width, settings.height);
        Ok(prepared)
    }
}

/// One picture on its way.
pub(super) struct Track<'a> {
    pub(super) settings: Settings,
    pub(super) session: Session<'a>,
    /// Time spent on it: tracks take turns by this, so that their images are of equal time.
    spent: Duration,
    shown: Option<Instant>,
    /// What it took to show it last.
    showing: Duration,
    own: Option<Arc<OwnError>>,
    acceptance: Option<Arc<ByKernel>>,
    /// When these two were told last, and how long that took.
    told: Option<(Instant, Duration)>,
}

/// What a renderer needs to go on where another left off: all but what lives on the device.
pub struct State {
    inbox: Receiver<Command>,
    pub out: Outbox,
    pub(super) loaded: Option<Loaded>,
    job: Option<Job>,
    moving: bool,
    paused: bool,
    reference: Option<Arc<Image>>,
    sky: Option<(PathBuf, Environment)>,
    pub(super) saves: Vec<JoinHandle<()>>,
}

impl State {
    pub fn new(inbox: Receiver<Command>, out: Outbox) -> Self {
        Self {
            inbox,
            out,
            loaded: None,
            job: None,
            moving: false,
            paused: false,
            reference: None,
            sky: None,
            saves: Vec::new(),
        }
    }

    /// Waits for what is being saved.
    pub fn finish(self) {
        for save in self.saves {
            // It has said itself what went wrong.
            let _ = save.join();
        }
    }
}

/// The renderer between two steps.
pub struct Worker<'a> {
    context: &'a Context,
    pub(super) state: State,
    /// Empty before the first step of a job, and while the camera moves.
    pub(super) tracks: Vec<Track<'a>>,
    preview: Option<Preview<'a>>,
    /// The job cannot go on; the window has heard why.
    failed: bool,
    progressed: Option<Instant>,
}

impl<'a> Worker<'a> {
    pub fn new(context: &'a Context, state: State) -> Self {
        Self { context, state, tracks: Vec::new(), preview: None, failed: false, progressed: None }
    }

    /// Works until the window is gone, then waits for what is being saved; or until the device is lost, and returns what
    /// another renderer needs to go on.
    pub fn run(mut self) -> Option<State> {
        loop {
            let command = if self.has_work() {
                match self.state.inbox.try_recv() {
                    Ok(command) => Some(command),
                    Err(TryRecvError::Empty) => None,
                    Err(TryRecvError::Disconnected) => break,
                }
            } else {
                match self.state.inbox.recv() {
                    Ok(command) => Some(command),
                    Err(_) => break,
                }
            };
            let done = match command {
                Some(command) => self.obey(command),
                None => self.step(),
            };
            if let Err(error) = done {
                self.state.out.send(Event::Failed(error.to_string()));
                if self.context.is_lost() {
                    return Some(self.state);
                }
            }
        }
        self.state.finish();
        None
    }

    /// Whether a step would do anything.
    fn has_work(&self) -> bool {
        if self.failed || self.state.job.is_none() || self.state.loaded.is_none() {
            return false;
        }
        let previews = self.needs_preview() && self.preview.as_ref().is_none_or(|preview| !preview.is_enough());
        let renders = !self.state.moving && (!self.state.paused || self.tracks.is_empty());
        previews || renders
    }

    fn needs_preview(&self) -> bool {
        self.state.moving || self.tracks.is_empty() || self.tracks.iter().any(|track| track.shown.is_none())
    }

    fn obey(&mut self, command: Command) -> Result<()> {
        match command {
            Command::Open(path) => self.open(&path)?,
            Command::Render(job) => {
                self.state.job = Some(*job);
                self.restart();
            }
            Command::Look(camera) => {
                if let Some(job) = &mut self.state.job {
                    job.camera = camera;
                    self.restart();
                }
            }
            Command::Moving(moving) => {
                self.state.moving = moving;
                // A camera that stands still deserves a finer one.
                self.preview = None;
            }
            Command::Pause(paused) => self.state.paused = paused,
            Command::Save(path) => self.save(&path)?,
            Command::Reference(path) => self.compare_with(&path, exr::read(&path)?)?,
            Command::Shaders(path) => {
                self.context.set_sources(Sources::read(&path)?)?;
                self.restart();
                self.state.out.send(Event::Note(format!("shaders of {} at work", path.display())));
            }
            Command::Sky(path) => self.set_sky(&path)?,
            Command::Image(path) => self.take_image(&path)?,
        }
        Ok(())
    }

    /// The scene that is shown stays where the new one cannot be read.
    fn open(&mut self, path: &Path) -> Result<()> {
        let mut scene = import(path)?;
        if let Some((_, environment)) = &self.state.sky {
            scene.set_environment(environment.clone());
        }
        self.show_scene(scene, path.to_path_buf());
        Ok(())
    }

    /// The scene that is shown gets another sky, as all that are opened later.
    fn set_sky(&mut self, path: &Path) -> Result<()> {
        let environment = environment::read(path)?;
        self.state.sky = Some((path.to_path_buf(), environment.clone()));
        if let Some(Loaded { mut scene, path, .. }) = self.state.loaded.take() {
            scene.set_environment(environment);
            self.show_scene(scene, path);
        }
        Ok(())
    }

    /// An image without a name for what it is: twice as wide as high it is a sky, unless it has the size of the picture;
    /// any other is a reference.
    fn take_image(&mut self, path: &Path) -> Result<()> {
        let file = exr::read(path)?;
        let film = self.state.job.as_ref().map(|job| (job.settings.width, job.settings.height));
        if file.width == 2 * file.height && film != Some((file.width, file.height)) {
            return self.set_sky(path);
        }
        self.compare_with(path, file)
    }

    fn show_scene(&mut self, scene: Scene, path: PathBuf) {
        let opened = Opened {
            path: path.clone(),
            files: scene.files.clone(),
            name: scene.name.clone(),
            sky: self.state.sky.as_ref().map(|(path, _)| path.clone()),
            triangles: scene.triangles.len(),
            cameras: scene.cameras.clone(),
            sphere: scene.bounding_sphere(),
            features: Features::of(&scene),
            warnings: scene.warnings.clone(),
        };
        self.state.loaded = Some(Loaded { scene, path, prepared: HashMap::new() });
        self.state.job = None;
        self.restart();
        self.state.out.send(Event::Opened(Box::new(opened)));
    }

    fn restart(&mut self) {
        self.tracks.clear();
        self.preview = None;
        self.failed = false;
    }

    fn step(&mut self) -> Result<()> {
        let mut done = self.preview_step();
        // Something to see comes before anything else.
        if done.is_ok() && self.preview.as_ref().is_none_or(Preview::has_image) {
            done = self.render_step();
        }
        self.failed = done.is_err();
        done
    }

    /// A little of the preview, while it is what there is to see.
    fn preview_step(&mut self) -> Result<()> {
        if !self.needs_preview() {
            self.preview = None;
            return Ok(());
        }
        let (Some(loaded), Some(job)) = (&mut self.state.loaded, &self.state.job) else { return Ok(()) };
        if self.preview.is_none() {
            let settings = Preview::settings(&job.settings, self.state.moving);
            let prepared = loaded.prepared(&settings, &job.camera)?;
            self.preview = Some(Preview::start(self.context, prepared, &settings)?);
        }
        let Some(preview) = &mut self.preview else { return Ok(()) };
        if let Some(image) = preview.step()? {
            let image = Arc::new(image);
            for slot in 0..job.pictures().len() {
                if self.tracks.get(slot).is_none_or(|track| track.shown.is_none()) {
                    let picture = Picture { image: Some(Arc::clone(&image)), preview: true, ..Picture::default() };
                    self.state.out.send(Event::Picture { slot, picture: Box::new(picture), error: None });
                }
            }
        }
        Ok(())
    }

    /// A step of the picture that has had the least time.
    fn render_step(&mut self) -> Result<()> {
        if self.state.moving {
            return Ok(());
        }
        let (Some(loaded), Some(job)) = (&mut self.state.loaded, &self.state.job) else { return Ok(()) };
        if self.tracks.is_empty() {
            for settings in job.pictures() {
                let prepared = loaded.prepared(&settings, &job.camera)?;
                let session = Session::start(self.context, prepared, &settings)?;
                let (spent, showing) = (Duration::ZERO, Duration::ZERO);
                let (own, acceptance) = (None, None);
                let track = Track { settings, session, spent, shown: None, showing, own, acceptance, told: None };
                self.tracks.push(track);
            }
        }
        if self.state.paused {
            return Ok(());
        }
        // The slowest set-up first: nobody's time runs meanwhile.
        let order = |track: &Track| (track.session.stage(), track.spent);
        let Some(slot) = (0..self.tracks.len()).min_by_key(|slot| order(&self.tracks[*slot])) else { return Ok(()) };
        let track = &mut self.tracks[slot];
        let start = Instant::now();
        let stage = track.session.stage();
        track.session.advance(Some(STEP))?;
        if stage == Stage::Rendering {
            track.spent += start.elapsed();
        } else if self.progressed.is_none_or(|at| at.elapsed() > BETWEEN_PROGRESS) {
            self.progressed = Some(Instant::now());
            let share = track.session.share();
            self.state.out.send(Event::Progress { slot, stage, share });
        }
        let wait = BETWEEN_PICTURES.max(track.showing.div_f64(PICTURES_SHARE));
        let due = track.shown.is_none_or(|at| at.elapsed() > wait);
        if due && track.session.has_image() && track.session.is_whole() {
            self.show(slot)?;
        }
        Ok(())
    }

    /// Sends a picture as it stands.
    fn show(&mut self, slot: usize) -> Result<()> {
        let track = &mut self.tracks[slot];
        let start = Instant::now();
        let wait =
            |(at, took): (Instant, Duration)| at.elapsed() > BETWEEN_ESTIMATES.max(took.div_f64(ESTIMATES_SHARE));
        let tell = track.told.is_none_or(wait);
        let outcome = if tell { track.session.snapshot()? } else { track.session.glance()? };
        let Outcome { image, mut channels, uncertainty, statistics } = outcome;
        if tell {
            let of_kernel = |channel: &mut Channel| {
                let kernel = channel.name.strip_prefix(ACCEPTANCE)?.to_string();
                Some((kernel, mem::take(&mut channel.values)))
            };
            let all: Vec<_> = channels.iter_mut().filter_map(of_kernel).collect();
            track.acceptance = (!all.is_empty()).then(|| Arc::new(all));
            track.told = Some((Instant::now(), start.elapsed()));
            let told =
                |u: Uncertainty| OwnError { seconds: statistics.render_s, relative: u.relative, pixels: u.pixels };
            track.own = uncertainty.map(told).map(Arc::new);
        }
        let error = self.state.reference.as_ref().and_then(|reference| {
            // Of another size: that was said when it was loaded, or will be by the window.
            let errors = metrics::compare(&image, reference, None).ok()?;
            let seconds = statistics.render_s;
            Some(ErrorPoint { seconds, rel_mse: errors.rel_mse, rel_mse_blocks: errors.rel_mse_blocks })
        });
        let mut layer = |name: &str| channels.iter_mut().find(|c| c.name == name).map(|c| mem::take(&mut c.values));
        let maps = layer("Maps.Horizontal").zip(layer("Maps.Vertical")).map(|(h, v)| Arc::new([h, v]));
        let (own, acceptance) = (track.own.clone(), track.acceptance.clone());
        let picture = Picture { image: Some(Arc::new(image)), maps, statistics, acceptance, own, preview: false };
        if !tell {
            track.showing = start.elapsed();
        }
        track.shown = Some(Instant::now());
        self.state.out.send(Event::Picture { slot, picture: Box::new(picture), error });
        Ok(())
    }

    fn compare_with(&mut self, path: &Path, file: exr::ExrFile) -> Result<()> {
        let image = file.image("").ok_or_else(|| {
            Error::input(format!("{} has no channels R, G, B: choose another reference", path.display()))
        })?;
        let image = Arc::new(image);
        self.state.reference = Some(Arc::clone(&image));
        self.state.out.send(Event::Reference { path: path.to_path_buf(), image });
        // A paused picture is measured too.
        for slot in 0..self.tracks.len() {
            if self.tracks[slot].shown.is_some() && self.tracks[slot].session.is_whole() {
                self.show(slot)?;
            }
        }
        Ok(())
    }
}
