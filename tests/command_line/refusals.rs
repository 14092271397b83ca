//! Bad usage, bad files, no device: one sentence, the right exit status, nothing left behind.

use std::fs;
use std::path::Path;

use crate::place::{Place, check_failure};

#[test]
fn bad_usage() {
    let place = Place::new();
    place.refuses(&[], 2, "no command given");
    place.refuses(&["paint"], 2, "paint");
    place.refuses(&["render"], 2, "<SCENE>");
    place.refuses(&["info"], 2, "<SCENE>");
    for (flags, words) in [
        (&["--size", "big"][..], "640x480"),
        (&["--size", "0x10"], "640x480"),
        (&["--size", "10x-5"], "640x480"),
        (&["--size", "999999x999999"], "640x480"),
        (&["--spp", "0"], "--spp"),
        (&["--spp", "-4"], "-4"),
        (&["--spp", "some"], "--spp"),
        (&["--spp", "4", "--time", "1"], "cannot be used with"),
        (&["--time", "0"], "seconds"),
        (&["--target-error", "0"], "2% or 0.02"),
        (&["--target-error", "200%"], "2% or 0.02"),
        (&["--target-error", "small"], "2% or 0.02"),
        (&["--target-error", "5%", "--groups", "1", "--size", "8x8"], "two groups"),
        (&["--groups", "0"], "--groups"),
        (&["--groups", "9"], "--groups"),
        (&["--reference", "a.exr"], "--log"),
        (&["--log", "no/folder/a.csv"], "no folder"),
        (&["--log", "a.csv", "--reference", "absent.exr"], "absent.exr"),
        (&["--time", "nan"], "seconds"),
        (&["--seed", "-1"], "-1"),
        (&["--max-depth", "0"], "--max-depth"),
        (&["--max-depth", "65"], "1..=64"),
        (&["--ensemble", "17"], "even"),
        (&["--ensemble", "8"], "even"),
        (&["--method", "best"], "pt"),
        (&["--maps", "--method", "pt"], "--maps"),
        (&["--direct", "light"], "mcmc"),
        (&["--direct", "pt", "--method", "pt"], "--direct"),
        (&["--two-stage", "2"], "from 0"),
        (&["--two-stage", "nan"], "from 0"),
        (&["--two-stage", "0.5", "--method", "pt"], "--two-stage"),
        (&["--camera"], "--camera"),
        (&["--sead", "1"], "--seed"),
        (&["another.glb"], "another.glb"),
    ] {
        place.refuses(&[&["render", "scene.gltf"], flags].concat(), 2, words);
    }
}

#[test]
fn bad_scene_files() {
    let place = Place::new();
    fs::create_dir(place.path("folder.glb")).unwrap();
    fs::write(place.path("empty.glb"), "").unwrap();
    fs::write(place.path("text.glb"), "A letter, not a scene.\n").unwrap();
    fs::write(place.path("text.gltf"), "A letter, not a scene.\n").unwrap();
    // A header that promises more than there is.
    let mut truncated = b"glTF\x02\0\0\0\0\x10\0\0\0\x08\0\0JSON".to_vec();
    truncated.extend_from_slice(br#"{"asset":{"version":"2.0"},"sce"#);
    fs::write(place.path("truncated.glb"), truncated).unwrap();
    let whole = fs::read(place.path("scene.gltf")).unwrap();
    fs::write(place.path("truncated.gltf"), &whole[..whole.len() / 2]).unwrap();
    for scene in [
        "absent.glb",
        "absent/scene.glb",
        "folder.glb",
        "empty.glb",
        "text.glb",
        "text.gltf",
        "truncated.glb",
        "truncated.gltf",
    ] {
        // Named by its file name at least, whatever else the sentence says.
        let name = Path::new(scene).file_name().unwrap().to_str().unwrap();
        place.refuses(&["info", scene], 2, name);
        place.refuses(&["render", scene], 2, name);
    }
}

#[test]
fn bad_output_paths() {
    let place = Place::new();
    fs::create_dir(place.path("folder.exr")).unwrap();
    fs::create_dir_all(place.path("taken/a.png")).unwrap();
    for (output, words) in [
        ("folder.exr", "is a folder"),
        (".", "is a folder"),
        ("absent/a.exr", "no folder absent"),
        ("scene.gltf/a.exr", "not a folder"),
        ("a.png", "must end in .exr"),
        ("a", "must end in .exr"),
        // The preview's place is taken.
        ("taken/a.exr", "is a folder"),
    ] {
        place.refuses(&["render", "scene.gltf", "-o", output], 2, words);
    }
}

#[cfg(unix)]
#[test]
fn an_output_folder_without_permission() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    let folder = place.path("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(folder.join("probe"), "").is_ok() {
        // The superuser may write anywhere, so there is nothing to refuse.
        return;
    }
    place.refuses(&["render", "scene.gltf", "-o", "locked/a.exr"], 2, "no permission");
}

#[test]
fn an_existing_image_survives_a_failure() {
    let place = Place::new();
    fs::write(place.path("a.exr"), "precious").unwrap();
    place.refuses(&["render", "absent.glb", "-o", "a.exr"], 2, "absent.glb");
    assert_eq!(fs::read(place.path("a.exr")).unwrap(), b"precious");
}

#[test]
fn an_unknown_camera() {
    let place = Place::new();
    place.refuses(&["render", "scene.gltf", "--camera", "Nobody's"], 2, "choose one of Main");
}

#[test]
fn no_vulkan_device() {
    let place = Place::new();
    let before = place.files();
    for arguments in [&["render", "scene.gltf", "--size", "8x8", "--spp", "1"][..], &["devices"]] {
        let mut command = place.command(arguments);
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, "/nonexistent");
        }
        check_failure(&command.output().unwrap(), 1, "mesa-vulkan-drivers");
    }
    assert_eq!(place.files(), before);
}

#[test]
fn an_unknown_device() {
    let place = Place::new();
    let arguments = ["render", "scene.gltf", "--size", "8x8", "--spp", "1", "--device", "abacus"];
    place.refuses(&arguments, 2, "abacus");
}

/// Neither where none is named nor where the named one does not answer.
#[cfg(all(feature = "viewer", target_os = "linux"))]
#[test]
fn a_window_without_a_display() {
    let place = Place::new();
    for display in ["", ":9876"] {
        let mut command = place.command(&["view", "scene.gltf"]);
        command.env("DISPLAY", display);
        for variable in ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "XDG_RUNTIME_DIR"] {
            command.env_remove(variable);
        }
        check_failure(&command.output().unwrap(), 1, "emlt render");
    }
}

#[cfg(feature = "viewer")]
#[test]
fn a_window_for_what_cannot_be_rendered() {
    let place = Place::new();
    for (flags, words) in [
        (&["absent.glb"][..], "absent.glb"),
        (&["scene.gltf", "--device", "abacus"], "abacus"),
        (&["scene.gltf", "--camera", "Nobody's"], "choose one of Main"),
        (&["scene.gltf", "--kernels", "lens"], "NAME=WEIGHT"),
        (&["scene.gltf", "--look-from", "0,0,0"], "--look-at"),
        (&["scene.gltf", "--reference", "scene.gltf"], "EXR"),
    ] {
        // A display that is never asked for anything.
        let output = place.command(&[&["view"], flags].concat()).env("DISPLAY", ":9876").output().unwrap();
        check_failure(&output, 2, words);
    }
}

#[test]
fn images_that_cannot_be_compared() {
    use emlt::film::{Channel, Image, exr};
    let place = Place::new();
    let write = |name: &str, width: u32, value: f32| {
        let image = Image { width, height: 2, pixels: vec![[value; 3]; 2 * width as usize] };
        exr::write(
            &place.path(name),
            &image,
            &[Channel { name: "A".into(), values: vec![1.0; 2 * width as usize] }],
            &[],
        )
        .unwrap();
    };
    write("a.exr", 2, 1.0);
    write("wide.exr", 3, 1.0);
    write("black.exr", 2, 0.0);
    fs::write(place.path("text.exr"), "not an image").unwrap();
    let before = place.files();
    for (arguments, words) in [
        (&["a.exr", "wide.exr"][..], "2x2 and 3x2"),
        (&["a.exr", "black.exr"], "black"),
        (&["a.exr", "text.exr"], "text.exr"),
        (&["absent.exr", "a.exr"], "absent.exr"),
        (&["a.exr"], "B.exr"),
        (&["a.exr", "a.exr", "-o", "d.png"], ".exr"),
        (&["a.exr", "a.exr", "-o", "no/d.exr"], "no folder"),
        (&["..", "a.exr"], ".exr"),
    ] {
        place.refuses(&[&["compare"], arguments].concat(), 2, words);
    }
    for reference in ["wide.exr", "black.exr", "text.exr"] {
        let arguments = ["render", "scene.gltf", "--size", "2x2", "--log", "a.csv", "--reference", reference];
        place.refuses(&arguments, 2, "");
    }
    assert_eq!(place.files(), before);
}
