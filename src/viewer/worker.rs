//! The renderer's thread: does what the window asks, and sends it pictures.
//!
//! It has a device of its own. On one that it shares with the window, the window's frames queue behind the renderer's
//! work, and waiting for the renderer's results holds up the window's submissions: see `launch`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::messages::{Command, ErrorPoint, Event, Job, Opened, Outbox, Picture};
use super::preview::Preview;
use super::statistics::own_error;
use crate::film::{Image, exr, metrics};
use crate::gpu::context::Context;
use crate::methods::{Method, Outcome, Prepared, Session, Settings, Stage};
use crate::report::outputs::{self, Outputs};
use crate::scene::import::import;
use crate::scene::{Camera, Features, Scene};
use crate::{Error, Result};

/// A step of rendering takes about as long, so that commands are heard soon.
const STEP: Duration = Duration::from_millis(40);
/// Least time between pictures, and the largest share of time spent on making them.
const BETWEEN_PICTURES: Duration = Duration::from_millis(150);
const PICTURES_SHARE: f64 = 0.1;
/// Least time between messages of progress.
const BETWEEN_PROGRESS: Duration = Duration::from_millis(100);

/// A scene with what was made of it for the device.
struct Loaded {
    scene: Scene,
    /// By the bits of the threshold below which lobes are specular.
    prepared: HashMap<u32, Prepared>,
}

impl Loaded {
    fn prepared(&mut self, settings: &Settings, camera: &Camera) -> Result<&Prepared> {
        let key = settings.specular_threshold().to_bits();
        if !self.prepared.contains_key(&key) {
            self.prepared.insert(key, Prepared::new(&self.scene, &Settings { camera: None, ..settings.clone() })?);
        }
        let prepared = self.prepared.get_mut(&key).expect("just made");
        prepared.aim(camera, settings.width, settings.height);
        Ok(prepared)
    }
}

/// One picture on its way.
struct Track<'a> {
    settings: Settings,
    session: Session<'a>,
    /// Time spent on it: tracks take turns by this, so that their images are of equal time.
    spent: Duration,
    shown: Option<Instant>,
    /// What it took to show it last.
    showing: Duration,
}

/// The renderer between two steps.
pub struct Worker<'a> {
    context: &'a Context,
    inbox: Receiver<Command>,
    out: Outbox,
    loaded: Option<Loaded>,
    job: Option<Job>,
    /// Empty before the first step of a job, and while the camera moves.
    tracks: Vec<Track<'a>>,
    preview: Option<Preview<'a>>,
    /// The job cannot go on; the window has heard why.
    failed: bool,
    moving: bool,
    paused: bool,
    reference: Option<Arc<Image>>,
    progressed: Option<Instant>,
    saves: Vec<JoinHandle<()>>,
}

impl<'a> Worker<'a> {
    pub fn new(context: &'a Context, inbox: Receiver<Command>, out: Outbox) -> Self {
        Self {
            context,
            inbox,
            out,
            loaded: None,
            job: None,
            tracks: Vec::new(),
            preview: None,
            failed: false,
            moving: false,
            paused: false,
            reference: None,
            progressed: None,
            saves: Vec::new(),
        }
    }

    /// Works until the window is gone, then waits for what is being saved.
    pub fn run(mut self) {
        loop {
            let command = if self.has_work() {
                match self.inbox.try_recv() {
                    Ok(command) => Some(command),
                    Err(TryRecvError::Empty) => None,
                    Err(TryRecvError::Disconnected) => break,
                }
            } else {
                match self.inbox.recv() {
                    Ok(command) => Some(command),
                    Err(_) => break,
                }
            };
            let done = match command {
                Some(command) => self.obey(command),
                None => self.step(),
            };
            if let Err(error) = done {
                self.out.send(Event::Failed(error.to_string()));
            }
        }
        for save in self.saves {
            // It has said itself what went wrong.
            let _ = save.join();
        }
    }

    /// Whether a step would do anything.
    fn has_work(&self) -> bool {
        if self.failed || self.job.is_none() || self.loaded.is_none() {
            return false;
        }
        let previews = self.needs_preview() && self.preview.as_ref().is_none_or(|preview| !preview.is_enough());
        let renders = !self.moving && (!self.paused || self.tracks.is_empty());
        previews || renders
    }

    fn needs_preview(&self) -> bool {
        self.moving || self.tracks.is_empty() || self.tracks.iter().any(|track| track.shown.is_none())
    }

    fn obey(&mut self, command: Command) -> Result<()> {
        match command {
            Command::Open(path) => self.open(&path)?,
            Command::Render(job) => {
                self.job = Some(*job);
                self.restart();
            }
            Command::Look(camera) => {
                if let Some(job) = &mut self.job {
                    job.camera = camera;
                    self.restart();
                }
            }
            Command::Moving(moving) => {
                self.moving = moving;
                // A camera that stands still deserves a finer one.
                self.preview = None;
            }
            Command::Pause(paused) => self.paused = paused,
            Command::Save(path) => self.save(&path)?,
            Command::Reference(path) => self.compare_with(&path)?,
        }
        Ok(())
    }

    /// The scene that is shown stays where the new one cannot be read.
    fn open(&mut self, path: &Path) -> Result<()> {
        let scene = import(path)?;
        let opened = Opened {
            path: path.to_path_buf(),
            name: scene.name.clone(),
            triangles: scene.triangles.len(),
            cameras: scene.cameras.clone(),
            sphere: scene.bounding_sphere(),
            features: Features::of(&scene),
            warnings: scene.warnings.clone(),
        };
        self.loaded = Some(Loaded { scene, prepared: HashMap::new() });
        self.job = None;
        self.restart();
        self.out.send(Event::Opened(Box::new(opened)));
        Ok(())
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
        let (Some(loaded), Some(job)) = (&mut self.loaded, &self.job) else { return Ok(()) };
        if self.preview.is_none() {
            let settings = Preview::settings(&job.settings, self.moving);
            let prepared = loaded.prepared(&settings, &job.camera)?;
            self.preview = Some(Preview::start(self.context, prepared, &settings)?);
        }
        let Some(preview) = &mut self.preview else { return Ok(()) };
        if let Some(image) = preview.step()? {
            let image = Arc::new(image);
            for slot in 0..job.pictures().len() {
                if self.tracks.get(slot).is_none_or(|track| track.shown.is_none()) {
                    let picture = Picture { image: Some(Arc::clone(&image)), preview: true, ..Picture::default() };
                    self.out.send(Event::Picture { slot, picture: Box::new(picture), error: None });
                }
            }
        }
        Ok(())
    }

    /// A step of the picture that has had the least time.
    fn render_step(&mut self) -> Result<()> {
        if self.moving {
            return Ok(());
        }
        let (Some(loaded), Some(job)) = (&mut self.loaded, &self.job) else { return Ok(()) };
        if self.tracks.is_empty() {
            for settings in job.pictures() {
                let prepared = loaded.prepared(&settings, &job.camera)?;
                let session = Session::start(self.context, prepared, &settings)?;
                let (spent, showing) = (Duration::ZERO, Duration::ZERO);
                self.tracks.push(Track { settings, session, spent, shown: None, showing });
            }
        }
        if self.paused {
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
            self.out.send(Event::Progress { slot, stage, share });
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
        let Outcome { image, channels, statistics, .. } = track.session.glance()?;
        let error = self.reference.as_ref().and_then(|reference| {
            // Of another size: that was said when it was loaded, or will be by the window.
            let errors = metrics::compare(&image, reference, None).ok()?;
            let seconds = statistics.render_s;
            Some(ErrorPoint { seconds, rel_mse: errors.rel_mse, rel_mse_blocks: errors.rel_mse_blocks })
        });
        let layer = |name: &str| channels.iter().find(|c| c.name == name).map(|c| c.values.clone());
        let maps = layer("Maps.Horizontal").zip(layer("Maps.Vertical")).map(|(h, v)| Arc::new([h, v]));
        let own_error = own_error(&image, &channels);
        let picture = Picture { image: Some(Arc::new(image)), maps, statistics, own_error, preview: false };
        track.showing = start.elapsed();
        track.shown = Some(Instant::now());
        self.out.send(Event::Picture { slot, picture: Box::new(picture), error });
        Ok(())
    }

    fn compare_with(&mut self, path: &Path) -> Result<()> {
        let image = exr::read(path)?.image("").ok_or_else(|| {
            Error::input(format!("{} has no channels R, G, B: choose another reference", path.display()))
        })?;
        let image = Arc::new(image);
        self.reference = Some(Arc::clone(&image));
        self.out.send(Event::Reference(image));
        // A paused picture is measured too.
        for slot in 0..self.tracks.len() {
            if self.tracks[slot].shown.is_some() && self.tracks[slot].session.is_whole() {
                self.show(slot)?;
            }
        }
        Ok(())
    }

    /// Takes the pictures as they stand; the files are written on a thread of their own, which outlives the window.
    fn save(&mut self, path: &Path) -> Result<()> {
        let Some(loaded) = &self.loaded else { return Ok(()) };
        if self.tracks.is_empty() || self.tracks.iter().any(|track| !track.session.has_image()) {
            return Err(Error::input("there is no image to save yet: wait until the preview has gone"));
        }
        let several = self.tracks.len() > 1;
        let mut writes: Vec<(Outputs, Settings, Outcome)> = Vec::new();
        for track in &mut self.tracks {
            while !track.session.is_whole() {
                track.session.advance(None)?;
            }
            let path = if several { with_method(path, track.settings.method) } else { path.to_path_buf() };
            let outcome = track.session.snapshot()?;
            writes.push((Outputs::new(path, track.settings.maps), track.settings.clone(), outcome));
        }
        // The file's header needs the name alone.
        let scene = Scene { name: loaded.scene.name.clone(), ..Scene::default() };
        let out = self.out.clone();
        self.saves.retain(|save| !save.is_finished());
        self.saves.push(thread::spawn(move || {
            for (outputs, settings, outcome) in writes {
                out.send(match outputs::write(&outputs, &scene, &settings, &outcome) {
                    Ok(_) => Event::Note(format!("saved {} with its preview", outputs.exr.display())),
                    Err(error) => Event::Failed(error.to_string()),
                });
            }
        }));
        Ok(())
    }
}

/// `a.exr` becomes `a.mlt.exr`.
fn with_method(path: &Path, method: Method) -> PathBuf {
    path.with_extension(format!("{}.exr", method.name()))
}
