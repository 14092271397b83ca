//! The window's start and end.

use std::env;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};

use eframe::egui::{self, Vec2, ViewportBuilder};
use glam::Vec3;

use super::app::{Viewer, title};
use super::messages::{Command, Event, Outbox};
use super::screen;
use super::worker::{State, Worker};
use crate::gpu::context::Context;
use crate::methods::Settings;
use crate::{Error, Result};

/// What to show first.
#[derive(Debug, Clone)]
pub struct Launch {
    pub scene: PathBuf,
    /// Where to stand and what to look at, instead of where the scene's camera is.
    pub look: Option<(Vec3, Vec3)>,
    /// The film's size, where it was asked for.
    pub size: Option<(u32, u32)>,
    pub reference: Option<PathBuf>,
    /// A map around the scene.
    pub env: Option<PathBuf>,
    /// A folder of shaders to use, and again whenever one of them changes.
    pub shaders: Option<PathBuf>,
    /// The budget in it is not looked at.
    pub settings: Settings,
}

/// What to do where no window can be opened.
const NO_WINDOW: &str = "use 'emlt render SCENE' to make an image without one";

/// Whether a window can be opened at all, as far as the environment tells.
pub fn check_display() -> Result<()> {
    let desktop = cfg!(any(target_os = "macos", target_os = "windows"));
    let set = |name: &str| env::var_os(name).is_some_and(|value| !value.is_empty());
    if desktop || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set) {
        return Ok(());
    }
    Err(Error::runtime(format!(
        "there is no display to open a window on (DISPLAY and WAYLAND_DISPLAY are not set): {NO_WINDOW}"
    )))
}

/// A renderer on a thread of its own.
pub struct Renderer {
    pub commands: Sender<Command>,
    pub events: Receiver<Event>,
    pub thread: JoinHandle<()>,
}

/// Starts the renderer; `wake` is called whenever it has something to say.
///
/// It opens a device of its own, on a thread with a lower priority. Measured on lavapipe with two busy cores, the window
/// painting all the time and `cornell` rendering: over the window's device the median frame took 32 to 36 ms and one in
/// twenty 74 to 98 ms, although steps were cut to 8 ms, since frames queue behind the renderer's work; with a device of
/// its own, whose threads inherit the lower priority, 20 to 24 ms and 28 to 36 ms, at the same rate of mutations.
///
/// An error says why no device could be opened.
pub fn start(device: Option<String>, wake: Arc<dyn Fn() + Send + Sync>) -> Result<Renderer> {
    let (commands, inbox) = mpsc::channel();
    let (sender, events) = mpsc::channel();
    let (opened, open) = mpsc::channel();
    let spawned = thread::Builder::new().name("renderer".into()).spawn(move || {
        yield_to_others();
        match Context::open(device.as_deref()) {
            Ok(context) => {
                let _ = opened.send(Ok(()));
                let state = State::new(inbox, Outbox { events: sender, wake });
                work(context, state, || Context::open(device.as_deref()));
            }
            Err(error) => {
                let _ = opened.send(Err(error));
            }
        }
    });
    let thread = spawned.map_err(|e| Error::runtime(format!("the renderer's thread could not be started: {e}")))?;
    open.recv().unwrap_or_else(|_| Err(Error::runtime("the renderer's thread ended early: please report it")))?;
    Ok(Renderer { commands, events, thread })
}

/// Renders on `context`, and should it be lost, once more on another: the scene, the settings and what is compared stay,
/// the image begins anew.
pub(super) fn work(context: Context, state: State, another: impl FnOnce() -> Result<Context>) {
    let Some(state) = Worker::new(&context, state).run() else { return };
    let sources = context.sources();
    drop(context);
    match another().and_then(|context| context.set_sources(sources).map(|()| context)) {
        Ok(context) => {
            state.out.send(Event::Note("the device was lost and opened again: the image begins anew".into()));
            if let Some(state) = Worker::new(&context, state).run() {
                let sentence = "the device was lost again: close this window, and start anew with another --device";
                state.out.send(Event::Failed(sentence.into()));
                state.finish();
            }
        }
        Err(error) => {
            state.out.send(Event::Failed(error.to_string()));
            state.finish();
        }
    }
}

/// Lowers this thread's priority, and so that of the threads that a software driver starts from it.
fn yield_to_others() {
    #[cfg(target_os = "linux")]
    // SAFETY: takes numbers alone. On Linux the priority is the calling thread's; a refusal changes nothing.
    unsafe {
        libc::setpriority(libc::PRIO_PROCESS, 0, 5);
    }
}

/// Opens the window and returns once it is closed and everything that was to be saved is written.
///
/// An [`Error::Runtime`] says why no window could be opened.
pub fn run(launch: Launch) -> Result<()> {
    check_display()?;
    let ctx: Arc<OnceLock<egui::Context>> = Arc::default();
    let waked = Arc::clone(&ctx);
    let wake = Arc::new(move || {
        if let Some(ctx) = waked.get() {
            ctx.request_repaint();
        }
    });
    let Renderer { commands, events, thread } = start(launch.settings.device.clone(), wake)?;
    let options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title(title(&launch.scene))
            .with_app_id("emlt")
            .with_inner_size(Vec2::new(1280.0, 800.0))
            .with_min_inner_size(Vec2::new(480.0, 320.0)),
        dithering: false,
        ..Default::default()
    };
    let done = eframe::run_native(
        "emlt",
        options,
        Box::new(move |creation| {
            creation.egui_ctx.set_theme(egui::Theme::Dark);
            if let Some(state) = &creation.wgpu_render_state {
                screen::install(state);
            }
            let _ = ctx.set(creation.egui_ctx.clone());
            let Launch { scene, look, size, reference, env, shaders, settings } = launch;
            if let Some(path) = env {
                let _ = commands.send(Command::Sky(path));
            }
            let mut viewer =
                Viewer::new(commands, events, &scene, settings, look, size.is_some(), reference.as_deref());
            if let Some(folder) = shaders {
                viewer.use_shaders(&folder);
            }
            Ok(Box::new(viewer))
        }),
    );
    // The window, and with it the sending end, is gone: the renderer ends after what it is saving.
    let _ = thread.join();
    done.map_err(|error| {
        let why = match error {
            // Their texts name places in the window library's source.
            eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => "the display does not answer".into(),
            error => error.to_string(),
        };
        Error::runtime(format!("no window could be opened ({why}): {NO_WINDOW}"))
    })
}
