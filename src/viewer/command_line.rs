//! The `emlt render` that makes the same image, without a window.

use eframe::egui;

use super::app::{Note, Viewer};
use super::messages::Opened;
use super::orbit::Orbit;
use super::overlay::Layer;
use crate::methods::{Method, Settings, default_direct, default_two_stage};

impl Viewer {
    pub(super) fn copy_command_line(&mut self, ctx: &egui::Context) {
        let (Some(scene), Some(orbit)) = (&self.scene, &self.orbit) else { return };
        let samples = self.slots.first().map_or(0, |slot| slot.picture.statistics.samples);
        let maps = matches!(self.layer, Some(Layer::Directions | Layer::Acceptance(_)));
        let text = command_line(scene, &self.settings, orbit, samples, maps);
        self.note = Some(Note { text: format!("copied: {text}"), error: false });
        ctx.copy_text(text);
    }
}

/// As many samples a pixel as there are now, rounded up; only what differs from the defaults is written.
pub fn command_line(scene: &Opened, settings: &Settings, orbit: &Orbit, samples: u64, maps: bool) -> String {
    let default = Settings::default();
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let mut words = vec!["emlt".to_string(), "render".into(), quoted(&scene.path.to_string_lossy())];
    let mut flag = |name: &str, value: String| words.extend([format!("--{name}"), value]);
    flag("method", settings.method.name().into());
    flag("size", format!("{}x{}", settings.width, settings.height));
    flag("spp", samples.div_ceil(pixels).max(1).to_string());
    if scene.cameras.first().is_none_or(|first| first.name != orbit.name()) {
        flag("camera", quoted(orbit.name()));
    }
    if let Some((eye, target)) = orbit.look() {
        flag("look-from", format!("{},{},{}", eye.x, eye.y, eye.z));
        flag("look-at", format!("{},{},{}", target.x, target.y, target.z));
    }
    if let Some(lens) = orbit.lens() {
        flag("aperture", lens.aperture.to_string());
        flag("focus", lens.focus.to_string());
    }
    if let Some(sky) = &scene.sky {
        flag("env", quoted(&sky.to_string_lossy()));
    }
    if settings.seed != default.seed {
        flag("seed", settings.seed.to_string());
    }
    if settings.max_depth != default.max_depth {
        flag("max-depth", settings.max_depth.to_string());
    }
    if let Some(name) = &settings.device {
        flag("device", quoted(name));
    }
    if settings.method != Method::Pt {
        // Both follow the budget and the device elsewhere.
        flag("ensemble", settings.ensemble.to_string());
        flag("candidates", settings.candidates.to_string());
        if settings.groups != default.groups {
            flag("groups", settings.groups.to_string());
        }
        if settings.direct != default_direct(settings.method, maps || settings.kernels.is_some()) {
            flag("direct", settings.direct.name().into());
        }
        if settings.two_stage != default_two_stage(settings.method) {
            flag("two-stage", settings.two_stage.unwrap_or(0.0).to_string());
        }
        if settings.guidance.guides != default.guidance.guides {
            flag("guides", settings.guidance.guides.to_string());
        }
        if settings.guidance.alpha != default.guidance.alpha {
            flag("alpha", settings.guidance.alpha[1].to_string());
        }
        if settings.guidance.normals {
            flag("similarity", "normals".into());
        }
        if let Some(mix) = &settings.kernels {
            flag("kernels", mix_words(mix));
        }
        if maps {
            words.push("--maps".into());
        }
    }
    words.join(" ")
}

/// A mix as --kernels reads it.
pub fn mix_words(mix: &[(&'static crate::kernels::Kernel, f64)]) -> String {
    let parts: Vec<String> = mix.iter().map(|(kernel, weight)| format!("{}={weight}", kernel.name)).collect();
    parts.join(",")
}

/// As a shell takes it for one word.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Direct;
    use crate::scene::{Camera, Features, Lens};
    use glam::{Affine3A, Vec3};

    fn opened(names: &[&str]) -> Opened {
        let camera = |name: &&str| Camera {
            name: (*name).into(),
            world_from_camera: Affine3A::from_translation(Vec3::Z),
            vertical_fov: 1.0,
            orthographic_height: None,
            lens: None,
            aspect: None,
        };
        Opened {
            path: "scenes/my box.glb".into(),
            files: vec![],
            name: "my box".into(),
            sky: None,
            triangles: 1,
            cameras: names.iter().map(camera).collect(),
            sphere: (Vec3::ZERO, 1.0),
            features: Features::default(),
            warnings: vec![],
        }
    }

    #[test]
    fn defaults_that_hold_everywhere_are_left_out() {
        let scene = opened(&["Main"]);
        let orbit = Orbit::new(scene.cameras[0].clone(), scene.sphere);
        let two_stage = default_two_stage(Settings::default().method);
        let direct = Direct::Auto;
        let settings = Settings { width: 100, height: 10, two_stage, direct, ..Settings::default() };
        let text = command_line(&scene, &settings, &orbit, 1999, false);
        assert_eq!(
            text,
            "emlt render 'scenes/my box.glb' --method emlt --size 100x10 --spp 2 --ensemble 16384 --candidates 1048576"
        );
    }

    #[test]
    fn whatever_was_changed_is_there() {
        let scene = opened(&["Main", "Bob's"]);
        let mut orbit =
            Orbit::new(scene.cameras[1].through(Some(Lens { aperture: 0.05, focus: 2.5 })).unwrap(), scene.sphere);
        orbit.place(Vec3::new(0.1, -2.0, 3.5), Vec3::ZERO);
        let settings = Settings {
            method: Method::Mlt,
            seed: 7,
            max_depth: 5,
            ensemble: 1024,
            groups: 4,
            direct: Direct::Pt,
            two_stage: Some(0.5),
            kernels: Some(crate::ensemble::mix::Mix::parse("independence=0.1,lens=1").unwrap()),
            ..Settings::default()
        };
        assert_eq!(
            command_line(&scene, &settings, &orbit, 0, true),
            r"emlt render 'scenes/my box.glb' --method mlt --size 640x480 --spp 1 --camera 'Bob'\''s' --look-from 0.1,-2,3.5 --look-at 0,0,0 --aperture 0.05 --focus 2.5 --seed 7 --max-depth 5 --ensemble 1024 --candidates 1048576 --groups 4 --direct pt --two-stage 0.5 --kernels independence=0.1,lens=1 --maps"
        );
    }
}
