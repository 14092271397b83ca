//! The renderer's thread without a window.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use super::launch;
use super::messages::{Command, Event, Job, Outbox};
use super::worker::State;
use crate::film::{Image, exr};
use crate::gpu::context::Context;
use crate::gpu::shader::Sources;
use crate::methods::{Method, Settings};

/// The first of its events that is wanted.
fn wait_for<T>(events: &Receiver<Event>, what: &str, mut wanted: impl FnMut(Event) -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(120) {
        let event = events.recv_timeout(Duration::from_millis(100));
        if let Some(found) = event.ok().and_then(&mut wanted) {
            return found;
        }
    }
    panic!("no {what} came");
}

/// Previews, pictures, another method, a pause, a save that outlives the window, and an unreadable file in between.
#[test]
fn the_renderer_works_without_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let woken = Arc::new(Mutex::new(0));
    let counter = Arc::clone(&woken);
    let renderer = launch::start(None, Arc::new(move || *counter.lock().unwrap() += 1)).unwrap();
    let send = |command| renderer.commands.send(command).unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.glb");
    send(Command::Open(scene));
    let opened = wait_for(&renderer.events, "scene", |event| match event {
        Event::Opened(opened) => Some(opened),
        event => panic!("{event:?}"),
    });
    let settings = Settings { width: 48, height: 36, maps: true, ensemble: 1024, ..Settings::default() };
    let job = Job { settings, camera: opened.cameras[0].clone(), second: Some(Method::Pt) };
    send(Command::Render(Box::new(job)));
    let picture = |slot: usize, preview: bool| {
        move |event| match event {
            Event::Picture { slot: s, picture, .. } if s == slot && picture.preview == preview => Some(picture),
            Event::Failed(sentence) => panic!("{sentence}"),
            _ => None,
        }
    };
    let first = wait_for(&renderer.events, "preview", picture(0, true)).image.unwrap();
    assert!(first.pixels.iter().flatten().all(|v| v.is_finite()));
    // One sample a pixel tells nothing of its error; the estimate comes with a later picture.
    let traced = wait_for(&renderer.events, "picture by pt that tells its error", |event| {
        picture(1, false)(event).filter(|picture| picture.own.is_some())
    });
    assert!(traced.own.is_some_and(|own| own.relative > 0.0 && own.pixels.width == 48) && traced.maps.is_none());
    let chains = wait_for(&renderer.events, "picture by emlt", picture(0, false));
    assert!(chains.statistics.samples > 0 && chains.maps.is_some());
    // An unreadable file changes nothing but the status line.
    send(Command::Open(PathBuf::from("absent.glb")));
    let sentence = wait_for(&renderer.events, "sentence", |event| match event {
        Event::Failed(sentence) => Some(sentence),
        _ => None,
    });
    assert!(sentence.contains("absent.glb"), "{sentence}");
    let later = wait_for(&renderer.events, "later picture", picture(0, false));
    assert!(later.statistics.samples > chains.statistics.samples);
    send(Command::Pause(true));
    let path = folder.path().join("a.exr");
    send(Command::Save(path.clone()));
    // The window closes at once; the files are whole all the same.
    drop(renderer.commands);
    renderer.thread.join().unwrap();
    for name in ["a.emlt.exr", "a.emlt.png", "a.emlt.maps.png", "a.pt.exr", "a.pt.png"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    let saved = exr::read(&path.with_extension("emlt.exr")).unwrap();
    assert_eq!((saved.width, saved.height), (48, 36));
    assert!(*woken.lock().unwrap() > 4);
}

/// An image twice as wide as high is a sky, and the scene that is shown gets it; one of the picture's size is a reference.
#[test]
fn skies_and_references_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = launch::start(None, Arc::new(|| {})).unwrap();
    let send = |command| renderer.commands.send(command).unwrap();
    let opened = || {
        wait_for(&renderer.events, "scene", |event| match event {
            Event::Opened(opened) => Some(opened),
            Event::Failed(sentence) => panic!("{sentence}"),
            _ => None,
        })
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    send(Command::Open(root.join("tests/scenes/sphere_over_plane.glb")));
    let first = opened();
    assert_eq!((first.sky, first.features.environment), (None, false));
    let write = |name: &str, width: u32, height: u32| {
        let path = folder.path().join(name);
        let image = Image { width, height, pixels: vec![[0.5; 3]; (width * height) as usize] };
        exr::write(&path, &image, &[], &[]).unwrap();
        path
    };
    let settings = Settings { width: 32, height: 16, method: Method::Pt, ..Settings::default() };
    let job = Job { settings, camera: first.cameras[0].clone(), second: None };
    send(Command::Render(Box::new(job)));
    send(Command::Image(write("same.exr", 32, 16)));
    wait_for(&renderer.events, "reference", |event| match event {
        Event::Reference { image, .. } => Some(image),
        Event::Failed(sentence) => panic!("{sentence}"),
        _ => None,
    });
    let sky = write("sky.exr", 64, 32);
    send(Command::Image(sky.clone()));
    let lit = opened();
    assert!(lit.sky == Some(sky) && lit.features.environment);
    drop(renderer.commands);
    renderer.thread.join().unwrap();
}

/// The device goes while it renders: the window hears of it, and pictures of the same job come from another device.
#[test]
fn a_lost_device_is_opened_again() {
    let (commands, inbox) = mpsc::channel();
    let (sender, events) = mpsc::channel();
    let context = Context::open(None).unwrap();
    let device = context.device.clone();
    // Shaders of a folder, at half the light, are to be at work on the next device too.
    let folder = tempfile::tempdir().unwrap();
    copy_tree(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"), folder.path());
    let pass = folder.path().join("passes/path_trace.wesl");
    let text = fs::read_to_string(&pass).unwrap().replacen("let radiance = ", "let radiance = 0.5 * ", 1);
    fs::write(&pass, text).unwrap();
    context.set_sources(Sources::read(folder.path()).unwrap()).unwrap();
    let thread = thread::spawn(move || {
        let state = State::new(inbox, Outbox { events: sender, wake: Arc::new(|| {}) });
        launch::work(context, state, || Context::open(None));
    });
    let send = |command| commands.send(command).unwrap();
    send(Command::Open(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/sphere_over_plane.glb")));
    let opened = wait_for(&events, "scene", |event| match event {
        Event::Opened(opened) => Some(opened),
        event => panic!("{event:?}"),
    });
    let settings = Settings { width: 32, height: 24, method: Method::Pt, ..Settings::default() };
    send(Command::Render(Box::new(Job { settings, camera: opened.cameras[0].clone(), second: None })));
    let picture = |event| match event {
        Event::Picture { picture, .. } if !picture.preview && picture.statistics.samples > 64 * 32 * 24 => {
            picture.image.map(|image| image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>())
        }
        Event::Failed(sentence) => panic!("{sentence}"),
        _ => None,
    };
    let before = wait_for(&events, "picture", picture);
    device.destroy();
    let sentence = wait_for(&events, "sentence", |event| match event {
        Event::Failed(sentence) => Some(sentence),
        _ => None,
    });
    assert!(sentence.contains("lost"), "{sentence}");
    wait_for(&events, "note", |event| matches!(event, Event::Note(text) if text.contains("anew")).then_some(()));
    let after = wait_for(&events, "picture from another device", picture);
    assert!((after / before - 1.0).abs() < 0.05, "{before} {after}");
    drop(commands);
    thread.join().unwrap();
}

/// Shaders are read again; faulty ones are told in a sentence, and the render goes on with the last good ones.
#[test]
fn shaders_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    copy_tree(&root.join("shaders"), folder.path());
    let renderer = launch::start(None, Arc::new(|| {})).unwrap();
    let send = |command| renderer.commands.send(command).unwrap();
    send(Command::Open(root.join("tests/scenes/sphere_over_plane.glb")));
    let opened = wait_for(&renderer.events, "scene", |event| match event {
        Event::Opened(opened) => Some(opened),
        event => panic!("{event:?}"),
    });
    let settings = Settings { width: 32, height: 24, method: Method::Pt, ..Settings::default() };
    send(Command::Render(Box::new(Job { settings, camera: opened.cameras[0].clone(), second: None })));
    let mean = || {
        wait_for(&renderer.events, "picture", |event| match event {
            Event::Picture { picture, .. } if !picture.preview && picture.statistics.samples > 64 * 32 * 24 => {
                picture.image.map(|image| image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>())
            }
            _ => None,
        })
    };
    let before = mean();
    let pass = folder.path().join("passes/path_trace.wesl");
    let text = fs::read_to_string(&pass).unwrap();
    fs::write(&pass, text.replacen("fn main(", "fn main(,", 1)).unwrap();
    send(Command::Shaders(folder.path().into()));
    let sentence = wait_for(&renderer.events, "sentence", |event| match event {
        Event::Failed(sentence) => Some(sentence),
        _ => None,
    });
    assert!(sentence.contains("path_trace") && !sentence.contains('\n'), "{sentence}");
    assert!((mean() / before - 1.0).abs() < 0.05, "the last good shaders stay");
    let halved = text.replacen("let radiance = ", "let radiance = 0.5 * ", 1);
    assert_ne!(halved, text);
    fs::write(&pass, halved).unwrap();
    send(Command::Shaders(folder.path().into()));
    wait_for(&renderer.events, "note", |event| matches!(event, Event::Note(_)).then_some(()));
    let after = mean();
    assert!((after / before - 0.5).abs() < 0.05, "{before} {after}");
    drop(renderer.commands);
    renderer.thread.join().unwrap();
}

fn copy_tree(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_tree(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}
