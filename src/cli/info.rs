//! `emlt info`: what is in a scene file.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;

use super::options::LensOptions;
use crate::Result;
use crate::gpu::shader::{Variant, compose};
use crate::kernels::{self, Kernel};
use crate::methods::{Method, Settings, default_direct, default_mix};
use crate::scene::light::{Light, LightKind};
use crate::scene::{Features, Scene, environment, import::import};

/// Say what is in a scene: triangles, materials, cameras, lights, size, features
#[derive(Debug, Args)]
pub struct Arguments {
    /// The scene: a glTF 2.0 file (.glb or .gltf)
    scene: PathBuf,

    /// Light from all around, as for 'emlt render'
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,

    #[command(flatten)]
    lens: LensOptions,
}

/// Prints the summary on standard output and the import's warnings on standard error.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut scene = import(&arguments.scene)?;
    if let Some(path) = &arguments.env {
        scene.set_environment(environment::read(path)?);
    }
    for warning in &scene.warnings {
        super::say("warning", warning);
    }
    let lens = arguments.lens.lens(None)?;
    if let Some(camera) = scene.cameras.first_mut() {
        *camera = camera.through(lens)?;
    }
    super::print(&summary(&scene))
}

/// One line per subject, ended by a line feed.
fn summary(scene: &Scene) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<11}{}", super::one_line(&value));
    };
    row("scene", scene.name.clone());
    row("triangles", format!("{} with {} vertices", scene.triangles.len(), scene.positions.len()));
    let materials: Vec<String> = scene.materials.iter().map(|m| format!("'{}'", m.name)).collect();
    row("materials", counted(&materials));
    if !scene.images.is_empty() {
        let texels: usize = scene.images.iter().map(|image| image.texels.len()).sum();
        let mapped = scene.materials.iter().filter(|m| m.textures.all().next().is_some()).count();
        row("textures", format!("{} images of {texels} texels in {mapped} materials", scene.images.len()));
    }
    for (i, camera) in scene.cameras.iter().enumerate() {
        let aspect = camera.aspect.map(|a| format!(", aspect {a:.3}")).unwrap_or_default();
        let default = if i == 0 { " (the default)" } else { "" };
        row(
            "camera",
            match camera.orthographic_height {
                None => {
                    let fov = camera.vertical_fov.to_degrees();
                    let lens = camera.lens.map_or(String::new(), |lens| {
                        format!(", a lens of diameter {} sharp at distance {}", lens.aperture, lens.focus)
                    });
                    format!("'{}': vertical field of view {fov:.1} degrees{lens}{aspect}{default}", camera.name)
                }
                Some(height) => format!("'{}': orthographic, height {height}{aspect}{default}", camera.name),
            },
        );
    }
    row("lights", lights(scene));
    let (centre, radius) = scene.bounding_sphere();
    row("bounds", format!("centre {:.4} {:.4} {:.4}, radius {radius:.4}", centre.x, centre.y, centre.z));
    let methods = [Method::Mlt, Method::Emlt].map(|method| (method, features_by(scene, method)));
    // Those of all kernels that can be asked for.
    let features = methods[0].1;
    let flags = features.flags().into_iter().zip(methods[1].1.flags());
    let names: Vec<String> = flags
        .filter_map(|((name, in_mlt), (_, in_emlt))| match (in_mlt, in_emlt) {
            (true, true) => Some(name.into()),
            (true, false) => Some(format!("{name} (in mlt)")),
            (false, true) => Some(format!("{name} (in emlt)")),
            (false, false) => None,
        })
        .collect();
    row("features", if names.is_empty() { "diffuse only".into() } else { names.join(", ") });
    for kernel in kernels::ALL {
        let runs = methods
            .into_iter()
            .filter(|(_, features)| (kernel.useless)(*features).is_none())
            .filter(|(m, _)| default_mix(*m).iter().any(|(k, weight)| k.name == kernel.name && *weight > 0.0))
            .map(|(method, _)| method.name());
        let runs: Vec<&str> = runs.collect();
        let state = match (kernel.useless)(features) {
            Some(why) => format!("not used: {why}"),
            None if runs.is_empty() => "by --kernels alone".into(),
            None => format!("by default in {}", runs.join(" and ")),
        };
        let size = match (kernel.useless)(features) {
            None => format!("; a shader of {} KiB", shader_bytes(kernel, features).div_ceil(1024)),
            Some(_) => String::new(),
        };
        row("kernel", format!("{}, {state} ({}{size})", kernel.name, kernel.about));
    }
    text
}

/// What shaders of a method have to know of the scene by default, as its default camera sees it.
fn features_by(scene: &Scene, method: Method) -> Features {
    let settings = Settings { method, direct: default_direct(method, false), ..Settings::default() };
    let features = Features::with_threshold(scene, settings.specular_threshold());
    scene.cameras.first().map_or(features, |camera| features.seen_by(scene, camera))
}

/// The names after their number.
fn counted(names: &[String]) -> String {
    if names.is_empty() { "0".into() } else { format!("{}: {}", names.len(), names.join(", ")) }
}

fn lights(scene: &Scene) -> String {
    let emits = |m: u32| scene.materials.get(m as usize).is_some_and(|m| m.emits());
    let mut count = 0_usize;
    let mut area = 0.0_f64;
    for (triangle, &material) in scene.triangles.iter().zip(&scene.triangle_materials) {
        if emits(material) {
            let [a, b, c] = triangle.map(|i| scene.positions[i as usize].as_dvec3());
            count += 1;
            area += 0.5 * (b - a).cross(c - a).length();
        }
    }
    let kinds = [("point", 0), ("spot", 1), ("directional", 2)].map(|(name, kind)| {
        let of_kind = |light: &&Light| match light.kind {
            LightKind::Point { .. } => kind == 0,
            LightKind::Spot { .. } => kind == 1,
            LightKind::Directional { .. } => kind == 2,
        };
        let n = scene.lights.iter().filter(of_kind).count();
        (n > 0).then(|| format!("{n} {name} {}", if n == 1 { "light" } else { "lights" }))
    });
    let map = scene.environment.as_ref().map(|e| format!("an environment of {}x{} pixels", e.width, e.height));
    let sky = scene.sky.map(|s| format!("a uniform sky of radiance {:.3} {:.3} {:.3}", s.x, s.y, s.z));
    let triangles = (count > 0).then(|| format!("{count} emissive triangles of area {area:.4}"));
    let parts: Vec<String> = [triangles, sky, map].into_iter().chain(kinds).flatten().collect();
    if parts.is_empty() { "none".into() } else { parts.join(", ") }
}

/// Bytes of WGSL that a kernel is compiled from for such a scene, with paths of the default length; 0 if it does not
/// compose, which rendering would report.
fn shader_bytes(kernel: &Kernel, features: Features) -> usize {
    let max_edges = Settings::default().max_depth;
    compose(&Variant { pass: kernel.pass, features, max_edges, flags: kernel.flags.to_vec() })
        .map_or(0, |text| text.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Material};
    use glam::Vec3;

    #[test]
    fn the_summary_of_a_lit_triangle() {
        let light =
            Material { name: "light".into(), metallic: 0.0, specular: 0.0, emission: Vec3::ONE, ..Material::default() };
        let camera = Camera {
            name: "Main".into(),
            world_from_camera: glam::Affine3A::IDENTITY,
            vertical_fov: std::f32::consts::FRAC_PI_4,
            orthographic_height: None,
            lens: None,
            aspect: Some(1.5),
        };
        let scene = Scene {
            name: "one".into(),
            positions: vec![Vec3::ZERO, 2.0 * Vec3::X, 2.0 * Vec3::Y],
            normals: vec![Vec3::Z; 3],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            materials: vec![light],
            cameras: vec![camera.clone(), Camera { name: "Side".into(), aspect: None, ..camera }],
            ..Scene::default()
        };
        let expected = "\
scene      one
triangles  1 with 3 vertices
materials  1: 'light'
camera     'Main': vertical field of view 45.0 degrees, aspect 1.500 (the default)
camera     'Side': vertical field of view 45.0 degrees
lights     1 emissive triangles of area 2.0000
bounds     centre 1.0000 1.0000 0.0000, radius 1.4142
features   diffuse only
";
        let text = summary(&scene);
        let (rest, kernels): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| !line.starts_with("kernel "));
        assert_eq!(rest.join("\n") + "\n", expected);
        assert_eq!(kernels.len(), kernels::ALL.len());
        assert!(kernels.iter().any(|k| k.starts_with("kernel     lens, by default in mlt and emlt (")));
        assert!(kernels.iter().any(|k| k.contains("caustic, not used: no material is specular")));
        let sized = |k: &&&str| k.contains("; a shader of ") && k.ends_with(" KiB)");
        assert_eq!(kernels.iter().filter(sized).count(), kernels.iter().filter(|k| !k.contains("not used")).count());
    }
}
