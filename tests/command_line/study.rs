//! Studies: a report in a folder, interrupted and gone on with, and what is refused.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;

use crate::outputs::interrupts_are_ignored;
use crate::place::{Place, check_failure};

/// A study of a few seconds.
const TINY: [&str; 15] = [
    "study",
    "alpha",
    "--scenes",
    ".",
    "--scene",
    "scene",
    "--size",
    "16x12",
    "--spp",
    "4",
    "--reference-spp",
    "4",
    "-q",
    "-o",
    "out",
];

#[cfg(unix)]
#[test]
fn an_interrupted_study_goes_on_where_it_was() {
    let place = Place::new();
    let arguments = [&TINY[..], &["--seeds", "2"]].concat();
    let mut command = Command::new("env");
    if interrupts_are_ignored() {
        command.arg("--default-signal=INT");
    }
    let mut child = command
        .arg(cargo_bin("emlt"))
        .args(&arguments)
        .current_dir(place.folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let runs = place.path("out/runs.csv");
    let rows = || fs::read_to_string(&runs).unwrap_or_default().lines().count().saturating_sub(1);
    let began = Instant::now();
    while rows() == 0 {
        assert!(child.try_wait().unwrap().is_none(), "the study ended before its first run");
        assert!(began.elapsed() < Duration::from_secs(300), "no run was finished");
        std::thread::sleep(Duration::from_millis(10));
    }
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    check_failure(&child.wait_with_output().unwrap(), 1, "the same command goes on from there");
    let kept = fs::read_to_string(&runs).unwrap();
    assert!((1..6).contains(&rows()), "{kept}");
    assert!(!place.path("out/report.md").exists());

    let output = place.run(&arguments);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("report: ") && said.contains("report.md"), "{said}");
    let all = fs::read_to_string(&runs).unwrap();
    assert!(all.starts_with(&kept) && rows() == 6, "kept:\n{kept}\nall:\n{all}");
    let report = fs::read_to_string(place.path("out/report.md")).unwrap();
    for words in ["| device and driver |", "| load average |", "| seeds | 1, 2 |", "static 0.05", "> The sigmoid"] {
        assert!(report.contains(words), "{words:?} is not in:\n{report}");
    }
    assert!(["alpha.csv", "alpha.png", "settings.txt"].iter().all(|name| place.path("out").join(name).is_file()));

    // Everything is there: nothing is rendered again, whatever the report.
    fs::remove_file(place.path("out/report.md")).unwrap();
    assert_eq!(place.run(&arguments).status.code(), Some(0));
    assert_eq!(fs::read_to_string(&runs).unwrap(), all);
    assert!(place.path("out/report.md").is_file());
    // Fewer seeds are there already; another budget is another study.
    assert_eq!(place.run(&[&TINY[..], &["--seeds", "1"]].concat()).status.code(), Some(0));
    assert_eq!(fs::read_to_string(&runs).unwrap(), all);
    let other: Vec<&str> = arguments.iter().map(|word| if *word == "16x12" { "16x13" } else { word }).collect();
    place.refuses(&other, 2, "other settings");
}

#[test]
fn what_is_no_study_is_refused() {
    let place = Place::new();
    place.refuses(&["study"], 2, "<NAME>");
    place.refuses(&["study", "paint"], 2, "ensemble-size");
    place.refuses(&["study", "alpha"], 2, "no folder scenes");
    let here = |flags: &[&'static str]| [&["study", "alpha", "--scenes", "."][..], flags].concat();
    place.refuses(&here(&[]), 2, "no ajar.glb");
    place.refuses(&here(&["--scene", "./scene.gltf"]), 2, "not the name of a scene");
    place.refuses(&here(&["--scene", "scene", "--scene", "other"]), 2, "one scene");
    place.refuses(&here(&["--scene", "scene", "-o", "."]), 2, "holds no study");
    place.refuses(&here(&["--scene", "scene", "-o", "scene.gltf"]), 2, "holds no study");
    place.refuses(&here(&["--scene", "scene", "--device", "abacus"]), 2, "abacus");
    for (flags, words) in [
        (&["--seeds", "0"][..], "--seeds"),
        (&["--spp", "0"], "--spp"),
        (&["--spp", "4", "--time", "1"], "cannot be used with"),
        (&["--size", "big"], "640x480"),
        (&["--reference-spp", "1"], "--reference-spp"),
    ] {
        place.refuses(&here(flags), 2, words);
    }
}
