//! What the window and the renderer tell each other.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{SendError, Sender};

use glam::Vec3;

use crate::film::Image;
use crate::methods::{Method, Settings, Stage};
use crate::report::statistics::Statistics;
use crate::scene::{Camera, Features};

/// What to render, and how.
#[derive(Debug, Clone)]
pub struct Job {
    /// The camera's name, the budget and the device in it are not looked at: rendering goes on until something else is
    /// asked for.
    pub settings: Settings,
    pub camera: Camera,
    /// Another method to render beside the first one, in equal time.
    pub second: Option<Method>,
}

impl Job {
    /// The settings of each picture.
    pub fn pictures(&self) -> Vec<Settings> {
        let methods = [Some(self.settings.method), self.second];
        methods.into_iter().flatten().map(|method| self.of_method(method)).collect()
    }

    fn of_method(&self, method: Method) -> Settings {
        let chains = method != Method::Pt;
        Settings {
            method,
            camera: None,
            lens: None,
            // A mix is for the method it was made for.
            kernels: self.settings.kernels.clone().filter(|_| method == self.settings.method),
            maps: self.settings.maps && chains,
            two_stage: self.settings.two_stage.filter(|_| chains),
            ..self.settings.clone()
        }
    }
}

/// From the window to the renderer; later ones replace what earlier ones began.
#[derive(Debug)]
pub enum Command {
    /// Read a scene; on success the renderer waits for a job.
    Open(PathBuf),
    /// Begin anew.
    Render(Box<Job>),
    /// Begin anew with another camera.
    Look(Camera),
    /// While the camera is being moved only the quick preview is made.
    Moving(bool),
    Pause(bool),
    /// Write the pictures as they stand: an EXR of this name, and PNGs beside it.
    Save(PathBuf),
    /// Compare with an image from now on.
    Reference(PathBuf),
    /// Use a folder's shaders from now on, as they are now; faulty ones leave the last good ones at work.
    Shaders(PathBuf),
    /// Put a map around this scene and those that follow it.
    Sky(PathBuf),
    /// A sky or a reference, whichever the image's shape makes it: see `Worker::take_image`.
    Image(PathBuf),
}

/// A scene that was read.
#[derive(Debug, Clone)]
pub struct Opened {
    pub path: PathBuf,
    /// All that it was read from.
    pub files: Vec<PathBuf>,
    pub name: String,
    /// The map around it.
    pub sky: Option<PathBuf>,
    pub triangles: usize,
    pub cameras: Vec<Camera>,
    /// Centre and radius.
    pub sphere: (Vec3, f32),
    pub features: Features,
    pub warnings: Vec<String>,
}

/// A value for every pixel, by the names of kernels.
pub type ByKernel = Vec<(String, Vec<f32>)>;

/// A picture as it stands.
#[derive(Debug, Clone, Default)]
pub struct Picture {
    pub image: Option<Arc<Image>>,
    /// Horizontal and vertical motion by pixel (mlt, emlt).
    pub maps: Option<Arc<[Vec<f32>; 2]>>,
    pub statistics: Statistics,
    /// By the names of the kernels, the share of proposals from every pixel that was accepted, NaN where there were none
    /// (mlt, emlt); newer now and then.
    pub acceptance: Option<Arc<ByKernel>>,
    /// What the image tells of its own error; newer now and then.
    pub own: Option<Arc<OwnError>>,
    /// A quick small image by the path tracer, until the method has one.
    pub preview: bool,
}

/// A picture's error as it estimates it itself.
#[derive(Debug, Clone)]
pub struct OwnError {
    /// Of rendering, when it was told.
    pub seconds: f64,
    /// Of a pixel, relative: the root of the relMSE that is to be expected.
    pub relative: f64,
    /// Standard error of every pixel.
    pub pixels: Image,
}

/// One measurement of a picture's error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorPoint {
    /// Of rendering.
    pub seconds: f64,
    pub rel_mse: f64,
    pub rel_mse_blocks: f64,
}

/// From the renderer to the window. `slot` numbers the pictures.
#[derive(Debug)]
pub enum Event {
    Opened(Box<Opened>),
    Progress {
        slot: usize,
        stage: Stage,
        share: f64,
    },
    Picture {
        slot: usize,
        picture: Box<Picture>,
        error: Option<ErrorPoint>,
    },
    Reference {
        path: PathBuf,
        image: Arc<Image>,
    },
    /// Something went well.
    Note(String),
    /// Something went wrong: a sentence that says what to do.
    Failed(String),
}

/// Where events go; each wakes the window.
#[derive(Clone)]
pub struct Outbox {
    pub events: Sender<Event>,
    pub wake: Arc<dyn Fn() + Send + Sync>,
}

impl Outbox {
    /// A window that is gone hears nothing; what went wrong is then said where it was started.
    pub fn send(&self, event: Event) {
        if let Err(SendError(Event::Failed(sentence))) = self.events.send(event) {
            eprintln!("error: {sentence}");
        }
        (self.wake)();
    }
}
