//! A small room with every kind of texture, made by code.

use emlt::scene::light::{Environment, Light, LightKind};
use emlt::scene::material::{AlphaMode, Anisotropy, Coat, Sheen, Textures};
use emlt::scene::texture::{IDENTITY, Image, Texture, Wrap};
use emlt::scene::{Camera, Material, Scene};
use glam::{Affine3A, Vec2, Vec3, Vec4, vec3};

/// Deterministic noise.
fn noise(n: u32) -> u8 {
    (n.wrapping_mul(0x9e37_79b9).rotate_left(11).wrapping_mul(0x85eb_ca6b) >> 24) as u8
}

fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let texels = (0..width * height).map(|i| u32::from_le_bytes(texel(i % width, i / width))).collect();
    Image { width, height, texels }
}

fn texture(image: u32, srgb: bool) -> Texture {
    Texture { image, srgb, linear: true, wrap: [Wrap::Repeat; 2], slot: 0, transform: IDENTITY }
}

/// A floor of metal and plastic, polished in places, bumpy walls of two colours, and a lamp with dark spots.
pub fn room() -> Scene {
    let images = vec![
        image(8, 8, |x, y| [noise(x + 8 * y), noise(x + 8 * y + 100), noise(x + 8 * y + 200), 255]),
        image(8, 4, |x, y| [0, 96 + noise(x + 8 * y + 300) / 2, noise(x + 8 * y + 400), 255]),
        image(16, 16, |x, y| [128 + noise(x + 16 * y) / 4 - 32, 128 + noise(x + 16 * y + 50) / 4 - 32, 240, 255]),
        image(4, 2, |x, y| if (x + y) % 2 == 0 { [255, 220, 160, 255] } else { [8, 8, 30, 255] }),
    ];
    let turned = Texture { transform: [[0.0, 2.0, 0.1], [-1.5, 0.3, 0.0]], ..texture(0, true) };
    let floor = Material {
        name: "floor".into(),
        metallic: 1.0,
        roughness: 0.5,
        textures: Textures {
            base_color: Some(turned),
            metallic_roughness: Some(Texture { wrap: [Wrap::Mirror, Wrap::Clamp], ..texture(1, false) }),
            ..Textures::default()
        },
        mapped_alpha: Some([0.09, 0.19]),
        ..Material::default()
    };
    let wall = Material {
        name: "wall".into(),
        metallic: 0.0,
        roughness: 0.7,
        base_color: vec3(0.9, 0.8, 0.7),
        vertex_colored: true,
        textures: Textures {
            base_color: Some(Texture { linear: false, slot: 1, wrap: [Wrap::Clamp, Wrap::Mirror], ..texture(0, true) }),
            normal: Some((texture(2, false), 0.8)),
            specular: Some(texture(1, false)),
            specular_color: Some(texture(0, true)),
            ..Textures::default()
        },
        ..Material::default()
    };
    let lamp = Material {
        name: "lamp".into(),
        base_color: Vec3::ZERO,
        metallic: 0.0,
        specular: 0.0,
        emission: vec3(6.0, 5.0, 4.0),
        textures: Textures { emissive: Some(Texture { linear: false, ..texture(3, true) }), ..Textures::default() },
        ..Material::default()
    };
    let mut scene = Scene {
        name: "textured room".into(),
        materials: vec![floor, wall, lamp],
        images,
        cameras: vec![Camera {
            name: "front".into(),
            world_from_camera: Affine3A::from_translation(vec3(0.0, 1.0, 3.2)),
            vertical_fov: 0.8,
            orthographic_height: None,
            lens: None,
            aspect: None,
        }],
        ..Scene::default()
    };
    quads(&mut scene);
    scene
}

/// The room with its lamp behind a pane of glass, a block of it, and a leaning mirror, whose roughness is the floor's texture:
/// alpha from 0.035 to 0.25 in reflection and transmission, on both sides of what is treated as specular.
pub fn polished_room() -> Scene {
    let mut scene = room();
    scene.name = "polished room".into();
    let floor = scene.materials[0].clone();
    let metallic_roughness = floor.textures.metallic_roughness.clone();
    let frosted = Material {
        name: "frosted glass".into(),
        metallic: 0.0,
        transmission: 1.0,
        thin: false,
        textures: Textures { metallic_roughness, ..Textures::default() },
        ..floor.clone()
    };
    let pane = Material { name: "pane".into(), thin: true, double_sided: true, ..frosted.clone() };
    scene.materials.extend([frosted, Material { name: "mirror".into(), ..floor }, pane]);
    block(&mut scene, vec3(-0.7, 0.05, -0.4), 0.6, 3);
    quad(&mut scene, vec3(0.0, 0.1, 0.1), vec3(0.8, 0.0, 0.3), vec3(0.1, 1.2, -0.4), 4);
    // It stays clear of the walls: where an edge is short, little is left of the half-vectors at its ends.
    quad(&mut scene, vec3(-0.9, 1.5, -0.9), 1.8 * Vec3::X, 1.8 * Vec3::Z, 5);
    scene
}

/// The room without its lamp, before an uneven sky, with a light of every kind.
pub fn lit_room() -> Scene {
    let mut scene = room();
    scene.name = "lit room".into();
    scene.materials[2].emission *= 0.2;
    let light = |kind, intensity| Light { kind, intensity };
    scene.lights = vec![
        light(LightKind::Point { position: vec3(0.3, 1.2, 0.4) }, vec3(0.9, 0.8, 0.5)),
        light(
            LightKind::Spot {
                position: vec3(-0.5, 1.6, 0.9),
                direction: vec3(0.3, -0.9, -0.6).normalize(),
                inner_cosine: 0.95,
                outer_cosine: 0.85,
            },
            vec3(1.0, 2.0, 3.0),
        ),
        light(LightKind::Directional { direction: vec3(0.2, -0.3, -0.9).normalize() }, vec3(0.3, 0.2, 0.1)),
    ];
    let pixels =
        (0..16 * 8u32).map(|i| if i == 69 { [9.0, 4.0, 2.0] } else { [0.1, 0.1, f32::from(noise(i)) / 512.0] });
    scene.environment = Some(Environment { width: 16, height: 8, pixels: pixels.collect() });
    scene
}

/// The room with layers: clear coats, smooth over the floor, uneven and bumpy over the walls, on the lamp, and on a block
/// of dark metal brushed unevenly; sheen on the walls and on a cloth; an unlit picture.
pub fn layered_room() -> Scene {
    let mut scene = room();
    scene.name = "layered room".into();
    let coat = |factor, roughness| Coat { factor, roughness, mapped_alpha: None };
    scene.materials[0].coat = coat(1.0, 0.1);
    scene.materials[1].coat = Coat { mapped_alpha: Some(0.2), ..coat(0.9, 0.8) };
    scene.materials[1].textures.coat = Some(texture(0, false));
    scene.materials[1].textures.coat_roughness = Some(texture(1, false));
    scene.materials[1].textures.coat_normal = Some((texture(2, false), 0.3));
    scene.materials[2].coat = coat(0.7, 0.6);
    scene.materials[1].sheen = Sheen { color: vec3(0.8, 0.7, 1.0), roughness: 0.9 };
    scene.materials[1].textures.sheen_color = Some(texture(0, true));
    let dark =
        Material { name: "block".into(), base_color: vec3(0.2, 0.1, 0.3), roughness: 0.2, ..Material::default() };
    let mut dark = Material { coat: coat(1.0, 0.25), anisotropy: Anisotropy { strength: 0.7, rotation: 0.5 }, ..dark };
    dark.textures.anisotropy = Some(texture(0, false));
    let cloth = Material { metallic: 0.0, base_color: vec3(0.1, 0.2, 0.4), ..Material::default() };
    let sheen = Sheen { color: vec3(0.9, 0.9, 0.5), roughness: 0.3 };
    scene.materials.extend([dark, Material { name: "cloth".into(), sheen, ..cloth }]);
    // And a picture that nothing lights.
    let mut picture = Material {
        name: "picture".into(),
        unlit: true,
        double_sided: true,
        base_color: Vec3::ZERO,
        emission: vec3(0.8, 0.9, 1.0),
        vertex_colored: true,
        ..scene.materials[2].clone()
    };
    picture.coat = Coat::default();
    picture.textures.emissive = Some(texture(0, true));
    scene.materials.push(picture);
    block(&mut scene, vec3(-0.7, 0.05, -0.7), 0.6, 3);
    quad(&mut scene, vec3(0.0, 0.2, 0.5), vec3(0.9, 0.0, 0.3), 0.9 * Vec3::Y, 4);
    quad(&mut scene, vec3(0.1, 0.9, -0.6), 0.5 * Vec3::X, vec3(0.0, 0.5, 0.2), 5);
    scene
}

/// The room with a screen with holes, a veil and a block of tinted glass, in an uneven sky.
pub fn veiled_room() -> Scene {
    let mut scene = lit_room();
    scene.name = "veiled room".into();
    scene.lights.clear();
    let coat = Material { metallic: 0.0, roughness: 0.25, vertex_colored: false, ..scene.materials[1].clone() };
    scene
        .images
        .push(image(8, 8, |x, y| [200, 60, 90, if (x + y) % 3 == 0 { 20 } else { noise(x + 8 * y) / 2 + 127 }]));
    let painted = |linear| Textures { base_color: Some(Texture { linear, ..texture(4, true) }), ..Textures::default() };
    let screen =
        Material { name: "screen".into(), alpha_mode: AlphaMode::Mask(0.4), textures: painted(false), ..coat.clone() };
    let veil = Material {
        name: "veil".into(),
        alpha_mode: AlphaMode::Blend,
        base_alpha: 0.7,
        textures: painted(true),
        ..coat
    };
    scene.materials.extend([screen, veil, tinted_glass()]);
    block(&mut scene, vec3(-0.7, 0.05, -0.7), 0.6, 5);
    quad(&mut scene, vec3(-0.9, 0.1, 0.1), Vec3::X, 1.1 * Vec3::Y, 3);
    quad(&mut scene, vec3(0.0, 0.2, 0.5), vec3(0.9, 0.0, 0.3), 1.2 * Vec3::Y, 4);
    scene
}

fn tinted_glass() -> Material {
    Material {
        name: "tinted glass".into(),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        thin: false,
        absorption: vec3(0.5, 2.0, 5.0),
        ..Material::default()
    }
}

/// The lit room with a block of tinted glass and a wall that is a mirror: every kind of light makes caustics, of which path
/// tracing knows none that points, spots and directions make.
pub fn glazed_room() -> Scene {
    let mut scene = lit_room();
    scene.name = "glazed room".into();
    let mirror = Material { name: "mirror".into(), base_color: vec3(0.9, 0.8, 0.6), ..Material::default() };
    scene.materials.extend([tinted_glass(), Material { roughness: 0.0, ..mirror }]);
    block(&mut scene, vec3(-0.7, 0.05, -0.4), 0.6, 3);
    quad(&mut scene, vec3(-0.99, 0.01, 0.99), vec3(0.02, 0.0, -1.9), vec3(0.05, 1.9, 0.0), 4);
    scene
}

/// The same without what comes from infinitely far: caustics start at points.
pub fn room_of_points() -> Scene {
    let mut scene = glazed_room();
    scene.name = "room of points".into();
    scene.environment = None;
    scene.lights.truncate(2);
    scene
}

/// The room with a veil and glass, by an orthographic camera beside which the sky is seen.
pub fn orthographic_room() -> Scene {
    let mut scene = veiled_room();
    scene.name = "orthographic room".into();
    scene.cameras[0].orthographic_height = Some(2.4);
    scene.cameras[0].world_from_camera = Affine3A::from_rotation_y(0.2) * scene.cameras[0].world_from_camera;
    scene
}

/// Nothing but a wall whose colour is its radiance, seen from behind, before a bright sky.
pub fn unlit_wall() -> Scene {
    let mut scene = Scene { name: "unlit wall".into(), cameras: room().cameras, ..Scene::default() };
    scene.materials.push(Material {
        unlit: true,
        double_sided: true,
        base_color: Vec3::ZERO,
        metallic: 0.0,
        specular: 0.0,
        emission: vec3(0.7, 0.2, 0.4),
        ..Material::default()
    });
    scene.environment = Some(Environment { width: 2, height: 1, pixels: vec![[5.0; 3]; 2] });
    quad(&mut scene, vec3(9.0, -9.0, 0.0), -18.0 * Vec3::X, 18.0 * Vec3::Y, 0);
    scene
}

/// A cube.
fn block(scene: &mut Scene, low: Vec3, size: f32, material: u32) {
    for axis in 0..3 {
        let [n, a, b] = [0, 1, 2].map(|i| size * Vec3::AXES[(axis + i) % 3]);
        quad(scene, low + n, a, b, material);
        quad(scene, low, b, a, material);
    }
}

fn quad(scene: &mut Scene, corner: Vec3, across: Vec3, up: Vec3, material: u32) {
    let first = scene.positions.len() as u32;
    let normal = across.cross(up).normalize();
    for (u, v) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)] {
        scene.positions.push(corner + u * across + (1.0 - v) * up);
        scene.normals.push(normal);
        scene.coordinates.push([Vec2::new(1.3 * u - 0.2, 2.1 * v - 0.4), Vec2::new(3.0 * u - 1.0, 1.7 * v)]);
        scene.tangents.push(across.normalize().extend(1.0));
        scene.colors.push(Vec4::new(1.0 - 0.5 * u, 0.4 + 0.6 * v, 0.9, 1.0));
    }
    for triangle in [[0, 1, 2], [0, 2, 3]] {
        scene.triangles.push(triangle.map(|i| first + i));
        scene.triangle_materials.push(material);
    }
}

fn quads(scene: &mut Scene) {
    quad(scene, vec3(-1.0, 0.0, 1.0), 2.0 * Vec3::X, -2.0 * Vec3::Z, 0);
    quad(scene, vec3(-1.0, 0.0, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Y, 1);
    quad(scene, vec3(-1.0, 0.0, 1.0), -2.0 * Vec3::Z, 2.0 * Vec3::Y, 1);
    quad(scene, vec3(1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::Y, 1);
    quad(scene, vec3(-0.6, 1.9, -0.5), 1.2 * Vec3::X, Vec3::Z, 2);
}
