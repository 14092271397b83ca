//! The options that `render` and `view` share: which scene, seen from where, rendered how.

use std::path::PathBuf;

use clap::Args;
use glam::Vec3;

use crate::ensemble::groups::MOST_GROUPS;
use crate::ensemble::guidance::{Guidance, MOST_GUIDES};
use crate::ensemble::mix::Mix;
use crate::ensemble::pool::MAX_EDGES;
use crate::methods::{
    Budget, Direct, MAX_SIDE, Method, Settings, default_candidates, default_direct, default_ensemble, default_size,
    default_two_stage,
};
use crate::scene::environment;
use crate::scene::import::import;
use crate::scene::{Camera, Lens, Scene};
use crate::{Error, Result};

// No doc comment: it would become the command's description.
#[derive(Debug, Args)]
pub struct Options {
    /// The scene: a glTF 2.0 file (.glb or .gltf)
    pub scene: PathBuf,

    /// Light from all around: an equirectangular map, .hdr or .exr, whose centre is where an unturned camera looks
    #[arg(long, value_name = "FILE")]
    pub env: Option<PathBuf>,

    /// How to render
    #[arg(long, value_enum, default_value_t = Method::Emlt)]
    pub method: Method,

    /// Image size in pixels [default: 640x480, or 480 high where the camera has an aspect of its own]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,

    /// Random seed: the same one gives the same image on the same device
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u32,

    /// Longest path, in edges from camera to light
    #[arg(long, value_name = "K", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_EDGES)))]
    pub max_depth: u32,

    /// Camera by name [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,

    /// Where to stand instead, in the scene's units; upright, with the camera's field of view
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_at", allow_hyphen_values = true)]
    pub look_from: Option<Vec3>,

    /// What to look at from there
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_from", allow_hyphen_values = true)]
    pub look_at: Option<Vec3>,

    #[command(flatten)]
    pub lens: LensOptions,

    /// Paths in the ensemble, an even number (mlt, emlt) [default: 16384; on a GPU up to 262144, as many as leave each
    /// path 320 mutations]
    #[arg(long, value_name = "N", value_parser = parse_ensemble)]
    pub ensemble: Option<u32>,

    /// Candidates among which the chains' starts are chosen, and which first tell the image's brightness (mlt, emlt)
    /// [default: a third of the mutations, at least a million]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(65536..=1 << 26))]
    pub candidates: Option<u32>,

    /// Independent groups into which the ensemble is split: their scatter tells the image's error (mlt, emlt)
    #[arg(long, value_name = "N", default_value_t = MOST_GROUPS, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_GROUPS)))]
    pub groups: u32,

    /// Kernels with their weights, as in independence=0.1,lens=1 (mlt, emlt); 'emlt info SCENE' lists them
    #[arg(long, value_name = "NAME=WEIGHT,...")]
    pub kernels: Option<String>,

    /// Guides that a guided kernel looks at, M of the supplement (emlt)
    #[arg(long, value_name = "M", default_value_t = Guidance::default().guides, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_GUIDES)))]
    pub guides: u32,

    /// Size of guided steps in spreads of the guides, the same for all [default: 0.05 to 0.5, the larger the more the
    /// guides resemble the path] (emlt)
    #[arg(long, value_name = "A", value_parser = parse_alpha)]
    pub alpha: Option<f32>,

    /// What makes guides resemble a path (emlt)
    #[arg(long, value_enum, default_value_t = Resemblance::Positions)]
    pub similarity: Resemblance,

    /// Who renders light that a path tracer finds easily: direct light, paths of at most 2 edges, or what the start finds easy (mlt,
    /// emlt) [default: auto for emlt, but mcmc where maps or a mix of kernels are asked for; mcmc for mlt]
    #[arg(long, value_enum)]
    pub direct: Option<Direct>,

    /// Give dark parts more samples: as many as luminance to the power 1 - GAMMA, from 0 to 1 (mlt, emlt) [default: 0.5 for
    /// emlt, 0 for mlt]
    #[arg(long, value_name = "GAMMA", value_parser = parse_gamma)]
    pub two_stage: Option<f64>,

    /// Device by a part of its name [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
}

/// A thin lens in place of the camera's pinhole.
#[derive(Debug, Args)]
pub struct LensOptions {
    /// Diameter of a thin lens in place of the camera's pinhole, in the scene's units (glTF: metres). A photographer's
    /// f-number N at focal length F is F/N: 0.0179 for 50 mm at f/2.8
    #[arg(long, value_name = "DIAMETER", value_parser = parse_length)]
    pub aperture: Option<f32>,

    /// Distance of the plane that is sharp, along the viewing axis, in the scene's units [default: that of --look-at]
    #[arg(long, value_name = "DISTANCE", value_parser = parse_length, requires = "aperture")]
    pub focus: Option<f32>,
}

impl LensOptions {
    /// The lens that is asked for; `distance` is that of what is looked at, if that is known.
    pub fn lens(&self, distance: Option<f32>) -> Result<Option<Lens>> {
        let Some(aperture) = self.aperture else { return Ok(None) };
        let focus = self.focus.or(distance).ok_or_else(|| {
            Error::input("--aperture needs --focus DISTANCE: say how far away the plane lies that is to be sharp")
        })?;
        Ok(Some(Lens { aperture, focus }))
    }
}

/// What the similarity of paths compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Resemblance {
    Positions,
    /// Positions and normals; the supplement finds this worse
    Normals,
}

impl Options {
    /// The scene, with the map around it that was asked for.
    pub fn read_scene(&self) -> Result<Scene> {
        let mut scene = import(&self.scene)?;
        if let Some(path) = &self.env {
            scene.set_environment(environment::read(path)?);
        }
        Ok(scene)
    }

    /// Refuses what a method cannot do; `maps` is whether the maps are asked for.
    pub fn check(&self, maps: bool) -> Result<()> {
        if self.method != Method::Pt {
            return Ok(());
        }
        if maps {
            return Err(Error::input("--maps needs --method emlt or mlt: path tracing makes no mutations"));
        }
        if self.direct.is_some_and(|direct| direct != Direct::Mcmc) {
            return Err(Error::input("--direct needs --method emlt or mlt: with --method pt all light is path traced"));
        }
        if self.two_stage.is_some() {
            return Err(Error::input("--two-stage needs --method emlt or mlt: path tracing has no chains to steer"));
        }
        Ok(())
    }

    /// Where to stand and what to look at, if that is asked for.
    pub fn look(&self) -> Option<(Vec3, Vec3)> {
        self.look_from.zip(self.look_at)
    }

    fn through(&self) -> Result<Option<Lens>> {
        self.lens.lens(self.look().map(|(eye, target)| eye.distance(target)))
    }

    /// The camera that is asked for. Its lens is in the settings: here it is only refused where none can be.
    pub fn view(&self, scene: &Scene) -> Result<Camera> {
        let camera = scene.camera(self.camera.as_deref())?;
        let camera = match self.look() {
            None => camera.clone(),
            Some((eye, target)) => camera.looking(eye, target).ok_or_else(|| {
                Error::input(
                    "--look-from and --look-at must lie apart, and not straight above each other: move one of them",
                )
            })?,
        };
        camera.through(self.through()?)?;
        Ok(camera)
    }

    /// The settings for a film that fits `camera`, on a software device or a GPU.
    /// `maps` is whether the maps of the chains are wanted.
    pub fn settings(&self, camera: &Camera, budget: Budget, software: bool, maps: bool) -> Result<Settings> {
        let (width, height) = self.size.unwrap_or_else(|| default_size(camera));
        Ok(Settings {
            budget,
            method: self.method,
            width,
            height,
            seed: self.seed,
            max_depth: self.max_depth,
            camera: self.camera.clone(),
            lens: self.through()?,
            ensemble: self.ensemble.unwrap_or_else(|| default_ensemble(software, budget, [width, height])),
            candidates: self.candidates.unwrap_or_else(|| default_candidates(software, budget, [width, height])),
            groups: self.groups,
            kernels: self.kernels.as_deref().map(Mix::parse).transpose()?,
            guidance: Guidance {
                guides: self.guides,
                alpha: self.alpha.map_or(Guidance::default().alpha, |alpha| [alpha; 2]),
                normals: self.similarity == Resemblance::Normals,
            },
            direct: self.direct.unwrap_or_else(|| default_direct(self.method, maps || self.kernels.is_some())),
            maps,
            two_stage: self.two_stage.or_else(|| default_two_stage(self.method)),
            device: self.device.clone(),
            ..Settings::default()
        })
    }
}

pub fn parse_size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("give width and height from 1 to {MAX_SIDE} pixels, as in 640x480"))
}

fn parse_point(text: &str) -> std::result::Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let point = <[f32; 3]>::try_from(numbers).ok().map(Vec3::from).filter(|p| p.is_finite());
    point.filter(|_| text.split(',').count() == 3).ok_or_else(|| "give three numbers, as in 1,0.5,-2".into())
}

fn parse_length(text: &str) -> std::result::Result<f32, String> {
    let length = text.parse().ok().filter(|l: &f32| l.is_finite() && *l > 0.0);
    length.ok_or_else(|| "give a length above 0, such as 0.05".into())
}

fn parse_alpha(text: &str) -> std::result::Result<f32, String> {
    let alpha = text.parse().ok().filter(|a: &f32| *a > 0.0 && *a <= 1.0);
    alpha.ok_or_else(|| "give a number above 0 and at most 1, such as 0.05 or 0.5".into())
}

fn parse_gamma(text: &str) -> std::result::Result<f64, String> {
    let gamma = text.parse().ok().filter(|g: &f64| (0.0..=1.0).contains(g));
    gamma.ok_or_else(|| "give a number from 0 (as without) to 1 (all parts of the image alike)".into())
}

fn parse_ensemble(text: &str) -> std::result::Result<u32, String> {
    let paths = text.parse().ok().filter(|n: &u32| (16..=1 << 22).contains(n) && n.is_multiple_of(2));
    paths.ok_or_else(|| "give an even number from 16 to 4194304".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Wrapper {
        #[command(flatten)]
        options: Options,
    }

    fn options(words: &str) -> Options {
        Wrapper::parse_from(["render"].into_iter().chain(words.split_whitespace())).options
    }

    fn camera(aspect: Option<f32>) -> Camera {
        let world_from_camera = glam::Affine3A::IDENTITY;
        Camera { name: "c".into(), world_from_camera, vertical_fov: 1.0, orthographic_height: None, lens: None, aspect }
    }

    #[test]
    fn no_flags_give_the_default_settings() {
        let settings = options("a.glb").settings(&camera(None), Settings::default().budget, true, false).unwrap();
        // Settings alone follow neither the budget nor the method.
        let two_stage = default_two_stage(Method::Emlt);
        let direct = default_direct(Method::Emlt, false);
        let default = Settings { candidates: 1 << 23, two_stage, direct, ..Settings::default() };
        assert_eq!(format!("{settings:?}"), format!("{default:?}"));
    }

    #[test]
    fn the_size_follows_the_camera_unless_given() {
        let size = |words, aspect| {
            let settings = options(words).settings(&camera(aspect), Budget::ENDLESS, true, false).unwrap();
            (settings.width, settings.height)
        };
        assert_eq!(size("a.glb", Some(16.0 / 9.0)), (853, 480));
        assert_eq!(size("a.glb", Some(1e9)), (MAX_SIDE, 480));
        assert_eq!(size("a.glb", Some(1e-9)), (1, 480));
        assert_eq!(size("a.glb --size 32x16", Some(2.5)), (32, 16));
    }

    #[test]
    fn a_camera_can_be_placed() {
        let scene = Scene { cameras: vec![camera(None)], ..Scene::default() };
        let view = |words: &str| options(words).view(&scene);
        assert_eq!(view("a.glb").unwrap(), scene.cameras[0]);
        let placed = view("a.glb --look-from -1,0,2.5 --look-at 3,0,2.5").unwrap();
        assert_eq!(Vec3::from(placed.world_from_camera.translation), Vec3::new(-1.0, 0.0, 2.5));
        assert!((Vec3::from(placed.world_from_camera.matrix3.z_axis) + Vec3::X).length() < 1e-6);
        assert_eq!(view("a.glb --look-from 1,2,3 --look-at 1,2,3").unwrap_err().exit_status(), 2);
        assert_eq!(view("a.glb --look-from 1,2,3 --look-at 1,9,3").unwrap_err().exit_status(), 2);
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,nan,2", "1,,2,3"] {
            assert!(parse_point(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_lens_is_focused_where_asked() {
        let flat = Camera { name: "flat".into(), orthographic_height: Some(1.0), ..camera(None) };
        let scene = Scene { cameras: vec![camera(None), flat], ..Scene::default() };
        let view = |words: &str| options(words).view(&scene);
        let asked = |words: &str| options(words).settings(&camera(None), Budget::ENDLESS, true, false).unwrap().lens;
        let lens = |aperture, focus| Some(Lens { aperture, focus });
        assert_eq!(asked("a.glb"), None);
        assert_eq!(asked("a.glb --aperture 0.02 --focus 3"), lens(0.02, 3.0));
        let placed = "a.glb --aperture 0.02 --look-from 0,3,4 --look-at 0,0,0";
        assert_eq!(asked(placed), lens(0.02, 5.0));
        assert_eq!(asked(&format!("{placed} --focus 2")), lens(0.02, 2.0));
        assert_eq!(view(placed).unwrap().lens, None);
        assert_eq!(view("a.glb --aperture 0.02").unwrap_err().exit_status(), 2);
        assert_eq!(view("a.glb --aperture 0.02 --focus 3 --camera flat").unwrap_err().exit_status(), 2);
        assert!(Wrapper::try_parse_from(["render", "a.glb", "--focus", "3"]).is_err());
        for text in ["0", "-1", "nan", "inf", "", "f/2.8"] {
            assert!(parse_length(text).is_err(), "{text}");
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in ["", "x", "0x4", "4x0", "4x", "-1x3", "4.5x3", "99999x2", "1x2x3", "4 x 3"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        assert_eq!(parse_size("1X16384"), Ok((1, 16384)));
        for text in ["0", "14", "17", "4194306", "many"] {
            assert!(parse_ensemble(text).is_err(), "{text}");
        }
        assert_eq!(parse_ensemble("16"), Ok(16));
        for text in ["0", "-0.1", "1.1", "nan", ""] {
            assert!(parse_alpha(text).is_err(), "{text}");
        }
        assert_eq!(parse_alpha("0.05"), Ok(0.05));
        for text in ["-0.1", "1.1", "nan", "", "half"] {
            assert!(parse_gamma(text).is_err(), "{text}");
        }
        assert_eq!([parse_gamma("0"), parse_gamma("1")], [Ok(0.0), Ok(1.0)]);
    }
}
