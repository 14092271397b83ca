//! What the commands print and write when all is well.

use std::process::{Command, Stdio};

use assert_cmd::cargo::cargo_bin;

use crate::place::Place;

#[test]
fn help_and_version() {
    let place = Place::new();
    for arguments in [&["--help"][..], &["help"], &["render", "--help"], &["info", "--help"], &["devices", "--help"]] {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(String::from_utf8_lossy(&output.stdout).contains("Usage:"));
        assert!(output.stderr.is_empty());
    }
    let output = place.run(&["--version"]);
    assert_eq!(output.status.code(), Some(0));
    let version = concat!("emlt ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(String::from_utf8_lossy(&output.stdout), version);
}

#[test]
fn info_describes_the_scene() {
    let place = Place::new();
    let output = place.run(&["info", "scene.gltf"]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stdout);
    for words in ["triangles  1 ", "'light'", "'Main'", "1 emissive", "radius"] {
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
}

/// Lobes that mlt treats as specular are none in emlt, which shares the light with the path tracer.
#[test]
fn info_tells_what_each_method_needs() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/rough_glass.glb");
    let output = Place::new().run(&["info", scene]);
    let said = String::from_utf8_lossy(&output.stdout);
    for words in ["narrow (in mlt)", "caustic, by default in mlt (", "guided-lens, by default in emlt ("] {
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
}

#[test]
fn devices_are_listed() {
    let output = Place::new().run(&["devices"]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.lines().count() > 0 && said.lines().all(|line| line.contains("Vulkan")), "{said}");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Place::new();
    let mut child = Command::new(cargo_bin("emlt"))
        .args(["info", "scene.gltf"])
        .current_dir(place.folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_quiet_render_leaves_an_image_and_its_preview() {
    let place = Place::new();
    let arguments =
        ["render", "scene.gltf", "--method", "pt", "--size", "12x8", "--spp", "2", "--seed", "5", "--quiet"];
    let output = place.run(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(output.stdout.is_empty() && said.is_empty(), "{said}");
    assert_eq!(place.files(), ["scene.exr", "scene.gltf", "scene.png"]);
    let file = emlt::film::exr::read(&place.path("scene.exr")).unwrap();
    assert_eq!((file.width, file.height), (12, 8));
    assert_eq!(file.attribute("seed"), Some(&5.0.into()));
    assert_eq!(file.attribute("samples"), Some(&(12.0 * 8.0 * 2.0).into()));
    assert_eq!(file.attribute("method"), Some(&"pt".into()));
}

#[test]
fn maps_are_written_when_asked_for() {
    let place = Place::new();
    let output = place.run(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "--size",
        "12x8",
        "--spp",
        "16",
        "--ensemble",
        "256",
        "--maps",
    ]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(output.stdout.is_empty());
    for words in ["device ", "mutations ", "written     a.exr", "written     a.maps.png"] {
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    assert_eq!(place.files(), ["a.exr", "a.maps.png", "a.png", "scene.gltf"]);
    let file = emlt::film::exr::read(&place.path("a.exr")).unwrap();
    for name in ["Maps.Horizontal", "Maps.Vertical"] {
        assert!(file.channel(name).is_some(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_image() {
    use std::time::{Duration, Instant};
    let place = Place::new();
    // A shell's background jobs ignore interrupts, and hand that on; emlt leaves it so, but here it is to hear one.
    let mut command = Command::new("env");
    if interrupts_are_ignored() {
        command.arg("--default-signal=INT");
    }
    let mut child = command
        .arg(cargo_bin("emlt"))
        .args(["render", "scene.gltf", "--method", "pt", "--size", "12x8", "--time", "600"])
        .current_dir(place.folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough to have loaded this scene, after which an interrupt is caught.
    std::thread::sleep(Duration::from_secs(2));
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    let asked = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if asked.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            panic!("the render did not stop");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("interrupted "), "{said}");
    assert_eq!(place.files(), ["scene.exr", "scene.gltf", "scene.png"]);
}

/// Whether this process was started with interrupts ignored (Linux; elsewhere nobody tells).
#[cfg(unix)]
pub fn interrupts_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 2 != 0))
}

/// The lines of a table as numbers; what is left empty is none.
fn table(path: &std::path::Path) -> Vec<Vec<Option<f64>>> {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.starts_with("render_s,total_s,samples_per_pixel,") && text.ends_with('\n'), "{text}");
    let line = |line: &str| line.split(',').map(|field| field.parse().ok()).collect();
    text.lines().skip(1).map(line).collect()
}

#[test]
fn a_render_tells_its_error_and_logs_it() {
    let place = Place::new();
    let first = ["render", "scene.gltf", "--method", "pt", "--size", "12x8", "--spp", "4", "-q", "-o", "ref.exr"];
    assert_eq!(place.run(&first).status.code(), Some(0));
    let arguments = [
        "render",
        "scene.gltf",
        "--method",
        "mlt",
        "--size",
        "12x8",
        "--spp",
        "400",
        "--ensemble",
        "64",
        "--log",
        "run.csv",
        "--reference",
        "ref.exr",
    ];
    let output = place.run(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("by the scatter of 8 groups; film mean") && said.contains("run.csv"), "{said}");
    let rows = table(&place.path("run.csv"));
    assert!(rows.len() > 4, "{rows:?}");
    assert!(rows.iter().all(|row| row.len() == 11 && row.iter().all(Option::is_some)), "{rows:?}");
    assert!(rows.is_sorted_by(|a, b| a[2] < b[2] && a[0] <= b[0] && a[0] < b[1]), "{rows:?}");
    assert!(rows.last().unwrap()[2] >= Some(400.0));
    let file = emlt::film::exr::read(&place.path("scene.exr")).unwrap();
    let errors = file.image("Error.").unwrap();
    assert!(errors.pixels.iter().flatten().all(|e| e.is_finite() && *e >= 0.0));
    for name in ["errorPixels", "errorTiles", "filmMean", "filmMeanStandardError"] {
        assert!(file.attribute(name).is_some(), "{name}");
    }
}

#[test]
fn a_render_stops_at_its_target() {
    let place = Place::new();
    for method in ["pt", "mlt"] {
        let arguments = ["render", "scene.gltf", "--size", "12x8", "--ensemble", "64", "--target-error", "10%"];
        let output = place.run(&[&arguments[..], &["--method", method, "--log", "run.csv"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let rows = table(&place.path("run.csv"));
        let (last, before) = rows.split_last().unwrap();
        assert!(last[3] <= Some(0.1), "{rows:?}");
        assert!(before.iter().all(|row| row[3] > Some(0.1)), "{rows:?}");
    }
    // A cap that comes first is said.
    let arguments = ["render", "scene.gltf", "--method", "mlt", "--size", "12x8", "--ensemble", "64", "--spp", "40"];
    let output = place.run(&[&arguments[..], &["--target-error", "0.0001"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("the target error of 0.01 % was not reached"), "{said}");
}

#[test]
fn images_are_compared() {
    use emlt::film::{Image, exr};
    let place = Place::new();
    let image = |value: f32| Image { width: 3, height: 2, pixels: vec![[value; 3]; 6] };
    for (name, value) in [("a.exr", 0.5), ("b.exr", 0.25)] {
        exr::write(&place.path(name), &image(value), &[], &[]).unwrap();
    }
    let output = place.run(&["compare", "a.exr", "b.exr"]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    // 0.25^2; over 0.25^2 with 0.01 of the mean's square.
    for words in ["MSE             6.250000e-2", "MAE             2.500000e-1", "relMSE          9.900990e-1", "FLIP"] {
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    assert_eq!(place.files(), ["a.difference.png", "a.exr", "b.exr", "scene.gltf"]);
    let output = place.run(&["compare", "a.exr", "b.exr", "-o", "d.exr"]);
    assert_eq!(output.status.code(), Some(0));
    let file = exr::read(&place.path("d.exr")).unwrap();
    assert_eq!(file.image("").unwrap().pixels, [[0.25; 3]; 6]);
    assert_eq!(file.channel("FLIP").unwrap().len(), 6);
    let same = place.run(&["compare", "a.exr", "a.exr", "-o", "d.exr"]);
    assert!(String::from_utf8_lossy(&same.stdout).contains("FLIP            0.000000"));
}
