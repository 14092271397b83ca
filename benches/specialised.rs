//! What it is worth to compile only what a scene needs: a scene as it is, and with a speck of every other material, texture
//! and light hidden in it, so that every part of the shaders is compiled in. Printed are the seconds to the first mutation
//! with no shader cached, and mutations a second.
//!
//!     cargo bench --bench specialised -- [--spp 64] [cornell ajar ...]

mod shared;

use std::path::Path;

use clap::Parser;
use emlt::gpu::context::Context;
use emlt::methods::{Budget, Method, Settings, Silent, render_on};
use emlt::scene::import::import;
use emlt::scene::light::LightKind;
use emlt::scene::material::{AlphaMode, Anisotropy, Coat, Sheen, Textures};
use emlt::scene::texture::{IDENTITY, Wrap};
use emlt::scene::{Environment, Image, Light, Material, Scene, Texture};
use glam::{Vec2, Vec3, Vec4};

#[derive(Parser)]
struct Arguments {
    #[arg(default_values_t = ["cornell", "ajar", "shards", "mirrors", "slit"].map(String::from))]
    scenes: Vec<String>,
    /// Mutations per pixel of 96x72
    #[arg(long, default_value_t = 64)]
    spp: u32,
    #[arg(long, value_enum, default_value_t = Method::Emlt)]
    method: Method,
}

fn main() {
    shared::main(run);
}

fn run(arguments: &Arguments) -> emlt::Result<()> {
    println!("{} at 96x72, {} per pixel", arguments.method.name(), arguments.spp);
    println!("scene      shaders       start s   million/s");
    for name in &arguments.scenes {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let scene = import(&root.join("scenes").join(name).with_extension("glb"))?;
        let mut rows = Vec::new();
        for (what, scene) in [("specialised", scene.clone()), ("everything", with_everything(scene))] {
            let row = measure(arguments, &scene)?;
            println!("{name:<10} {what:<12} {:>8.1} {:>11.3}", row[0], row[1]);
            rows.push(row);
        }
        println!("{name:<10} {:<12} {:>8.2} {:>11.2}", "ratio", rows[1][0] / rows[0][0], rows[0][1] / rows[1][1]);
    }
    Ok(())
}

/// Seconds to the first mutation, and million mutations a second.
fn measure(arguments: &Arguments, scene: &Scene) -> emlt::Result<[f64; 2]> {
    let cache = std::env::temp_dir().join(format!("emlt-specialised-{}", std::process::id()));
    // An empty one is no error.
    let _ = std::fs::remove_dir_all(&cache);
    // SAFETY: no other thread of this program runs between two renders.
    unsafe { std::env::set_var("MESA_SHADER_CACHE_DIR", &cache) };
    let context = Context::open(None)?;
    let settings = Settings {
        method: arguments.method,
        width: 96,
        height: 72,
        budget: Budget::SamplesPerPixel(arguments.spp),
        ..Settings::default()
    };
    let s = render_on(&context, scene, &settings, &mut Silent)?.statistics;
    let _ = std::fs::remove_dir_all(&cache);
    Ok([s.setup_s + s.compile_s + s.seeding_s, 1e-6 * s.samples as f64 / s.render_s])
}

/// The scene with specks of everything, at the edge of its bounding sphere and a ten-thousandth of its size, and with
/// lights a billion times weaker than any.
fn with_everything(mut scene: Scene) -> Scene {
    let n = scene.positions.len();
    scene.coordinates.resize(n, [Vec2::ZERO; 2]);
    scene.tangents.resize(n, Vec4::X);
    scene.colors.resize(n, Vec4::ONE);
    let image = scene.images.len() as u32;
    let texel = |i: u32| 0x80ff_8080 | ((i * 40) & 0x7f);
    scene.images.push(Image { width: 2, height: 2, texels: (0..4).map(texel).collect() });
    let texture =
        |slot| Texture { image, srgb: false, linear: true, wrap: [Wrap::Repeat; 2], slot, transform: IDENTITY };
    let plain = Material { metallic: 0.0, roughness: 0.5, ..Material::default() };
    let glass = Material { transmission: 1.0, thin: false, absorption: Vec3::ONE, ..plain.clone() };
    let painted = Textures { base_color: Some(texture(1)), normal: Some((texture(0), 1.0)), ..Textures::default() };
    let materials = [
        Material {
            coat: Coat { factor: 0.5, roughness: 0.5, mapped_alpha: None },
            sheen: Sheen { color: Vec3::splat(0.5), roughness: 0.5 },
            anisotropy: Anisotropy { strength: 0.5, rotation: 0.0 },
            vertex_colored: true,
            textures: painted.clone(),
            ..plain.clone()
        },
        Material {
            emission: Vec3::splat(1e-9),
            textures: Textures { emissive: Some(texture(0)), ..painted.clone() },
            ..plain.clone()
        },
        Material { alpha_mode: AlphaMode::Mask(0.5), textures: painted.clone(), ..plain.clone() },
        Material { alpha_mode: AlphaMode::Blend, base_alpha: 0.5, ..plain.clone() },
        Material { roughness: 0.2, metallic: 1.0, ..plain },
        Material { roughness: 0.0, ..glass.clone() },
        glass,
    ];
    let (centre, radius) = scene.bounding_sphere();
    for (i, material) in materials.into_iter().enumerate() {
        let size = 1e-4 * radius;
        let corner = centre + radius * Vec3::new(0.57, -0.57, 0.57) + 4.0 * size * i as f32 * Vec3::X;
        let first = scene.positions.len() as u32;
        for (offset, at) in [(Vec3::ZERO, Vec2::ZERO), (size * Vec3::X, Vec2::X), (size * Vec3::Z, Vec2::Y)] {
            scene.positions.push(corner + offset);
            scene.normals.push(Vec3::NEG_Y);
            scene.coordinates.push([at; 2]);
            scene.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
            scene.colors.push(Vec4::ONE);
        }
        scene.triangles.push([first, first + 1, first + 2]);
        scene.triangle_materials.push(scene.materials.len() as u32);
        scene.materials.push(Material { name: format!("speck {i}"), ..material });
    }
    scene.lights.push(Light { kind: LightKind::Point { position: centre }, intensity: Vec3::splat(1e-9) });
    scene.set_environment(Environment { width: 2, height: 1, pixels: vec![[1e-9; 3], [2e-9; 3]] });
    scene
}
