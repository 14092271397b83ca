//! The small scenes of the tests.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{cuboid, icosphere, quad};
use glam::Vec3;
use serde_json::json;

/// A closed box, every triangle a Lambertian emitter that faces inside: albedo (0.6, 0.5, 0.3) and
/// emission (0.5, 1, 0.25), so every pixel is e / (1 - rho) = (1.25, 2, 0.357142...); with paths of at
/// most k edges, e (1 - rho^k) / (1 - rho).
pub fn furnace() -> Document {
    let mut scene = Document::default();
    let glow = Material::lambert("glow", [0.6, 0.5, 0.3]).emitting([0.5, 1.0, 0.25], 1.0);
    let glow = scene.material(glow);
    let room = cuboid(Vec3::new(-1.0, 0.0, -1.5), Vec3::new(1.0, 2.0, 1.5)).flipped();
    scene.object("room", &room.closed(), glow);
    scene.camera("main", Vec3::new(0.3, 1.1, 1.0), Vec3::new(-0.2, 0.8, -1.0), 50.0);
    scene
}

/// A glowing ball of radius R = 0.2 about (0, 1, 0) with radiance L = (10, 8, 5) over a Lambertian plane
/// y = 0 of albedo (0.8, 0.5, 0.25), seen from straight above with the ball out of view.
/// Where the whole ball is above the horizon, the irradiance at distance d from its centre is
/// E = pi L (R/d)^2 cos(theta), so with cos(theta) = 1/d a pixel is rho L R^2 / d^3.
/// The ball has 5120 facets and the surface area 4 pi R^2, so (Cauchy) the right mean silhouette.
pub fn sphere_over_plane() -> Document {
    let mut scene = Document::default();
    let plane = scene.material(Material::lambert("plane", [0.8, 0.5, 0.25]));
    let lamp = scene.material(Material::lamp("L = (10, 8, 5)", [1.0, 0.8, 0.5], 10.0));
    let ground = quad(Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0);
    scene.object("plane y = 0", &ground, plane);
    let unit = icosphere(4);
    let inflate = (4.0 * std::f32::consts::PI / unit.area()).sqrt();
    let ball = unit.scaled(0.2 * inflate).at(0.0, 1.0, 0.0);
    scene.object("ball, R = 0.2, centre (0, 1, 0)", &ball.closed(), lamp);
    scene.camera("main", Vec3::new(1.0, 1.5, 0.0), Vec3::new(1.0, 0.0, 0.0), 50.0);
    scene
}

/// A closed coloured room for statistical tests: a lamp, a rough metal box, a coloured glass gem.
/// Everything is flat-shaded: then shading and geometric normals agree, and no renderer's rule for
/// their disagreement shows in a comparison. The lamp is large so that a path tracer resolves the caustic.
pub fn coloured_box() -> Document {
    let mut scene = Document::default();
    let white = scene.material(Material::lambert("white", [0.7, 0.7, 0.7]));
    let orange = scene.material(Material::lambert("orange", [0.75, 0.3, 0.08]));
    let blue = scene.material(Material::lambert("blue", [0.1, 0.25, 0.65]));
    let green = scene.material(Material::lambert("green", [0.25, 0.5, 0.2]));
    let metal = scene.material(Material::metal("copper", [0.93, 0.6, 0.45], 0.45));
    let glass = scene.material(Material::glass("rose glass", [0.95, 0.7, 0.75], 1.5));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.85, 0.6], 5.0));

    room(&mut scene, [white, orange, blue, green, lamp]);
    let half = Vec3::new(0.28, 0.4, 0.28);
    let block = cuboid(-half, half).turned(25.0).at(-0.4, 0.401, -0.35);
    scene.object("block", &block.closed(), metal);
    let gem = icosphere(2).scaled(0.32).at(0.4, 0.45, 0.1).faceted();
    scene.object("gem", &gem.closed(), glass);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.85, 0.0), 55.0);
    scene
}

/// The same room with lobes on both sides of the threshold below which they are treated as specular: brushed copper and
/// frosted glass of alpha 0.05, and the same two of alpha 0.2. A plate of the brushed copper covers the floor.
pub fn glossy_box() -> Document {
    let mut scene = Document::default();
    let white = scene.material(Material::lambert("white", [0.7, 0.7, 0.7]));
    let orange = scene.material(Material::lambert("orange", [0.75, 0.3, 0.08]));
    let blue = scene.material(Material::lambert("blue", [0.1, 0.25, 0.65]));
    let green = scene.material(Material::lambert("green", [0.25, 0.5, 0.2]));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.85, 0.6], 5.0));
    let roughness = [0.2236, 0.4472];
    let metals = roughness.map(|r| scene.material(Material::metal("copper", [0.93, 0.6, 0.45], r)));
    let glasses = roughness.map(|r| scene.material(Material::rough_glass("rose glass", [0.95, 0.7, 0.75], 1.5, r)));
    room(&mut scene, [white, orange, blue, green, lamp]);

    // Seen from steep to grazing angles: there the change of half-vectors to directions varies most.
    let plate = quad(Vec3::new(-0.9, 0.01, -0.9), Vec3::Z * 2.4, Vec3::X * 1.8);
    scene.object("brushed plate", &plate, metals[0]);
    let half = Vec3::new(0.22, 0.35, 0.22);
    let block = cuboid(-half, half);
    scene.object("brushed block", &block.clone().turned(25.0).at(-0.55, 0.371, -0.35).closed(), metals[0]);
    scene.object("dull block", &block.clone().turned(-10.0).at(0.1, 0.371, -0.6).closed(), metals[1]);
    let gem = icosphere(1).scaled(0.3).faceted();
    scene.object("frosted gem", &gem.clone().at(0.45, 0.45, 0.1).closed(), glasses[0]);
    scene.object("dull gem", &gem.scaled(0.7).at(-0.1, 0.25, 0.4).closed(), glasses[1]);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.85, 0.0), 55.0);
    scene
}

/// The same room with layers: a smooth coat over a matt plate, rough and smooth coats over brushed (anisotropic) copper, a
/// coat on frosted glass, and sheen, also under a coat. There are narrow lobes of every kind, and such as are not.
pub fn layered_box() -> Document {
    let mut scene = Document::default();
    let white = scene.material(Material::lambert("white", [0.7, 0.7, 0.7]));
    let orange = scene.material(Material::lambert("orange", [0.75, 0.3, 0.08]));
    let blue = scene.material(Material::lambert("blue", [0.1, 0.25, 0.65]));
    let green = scene.material(Material::lambert("green", [0.25, 0.5, 0.2]));
    let coat =
        |factor: f64, roughness: f64| json!({ "clearcoatFactor": factor, "clearcoatRoughnessFactor": roughness });
    let (coated, brushed) = ("KHR_materials_clearcoat", "KHR_materials_anisotropy");
    let lamp = Material::lamp("lamp", [1.0, 0.85, 0.6], 5.0).with(coated, coat(0.5, 0.5));
    let lamp = scene.material(lamp);
    room(&mut scene, [white, orange, blue, green, lamp]);

    let sheen = json!({ "sheenColorFactor": [0.9, 0.6, 0.3], "sheenRoughnessFactor": 0.4 });
    let plate = Material::lambert("lacquer", [0.5, 0.1, 0.1]).with(coated, coat(1.0, 0.2));
    let copper = |roughness| Material::metal("copper", [0.93, 0.6, 0.45], roughness);
    let grain = |strength: f64| json!({ "anisotropyStrength": strength, "anisotropyRotation": 0.7 });
    let narrow = copper(0.2).with(brushed, grain(0.3)).with(coated, coat(0.8, 0.25));
    let wide = copper(0.4).with(brushed, grain(0.7)).with(coated, coat(1.0, 0.5));
    let glass = Material::rough_glass("rose glass", [0.95, 0.7, 0.75], 1.5, 0.22).with(coated, coat(0.7, 0.3));
    let cloth = Material::lambert("cloth", [0.2, 0.25, 0.5]).with("KHR_materials_sheen", sheen.clone());
    let waxed =
        Material::lambert("waxed", [0.2, 0.4, 0.2]).with("KHR_materials_sheen", sheen).with(coated, coat(1.0, 0.1));
    let [plate, narrow, wide, glass, cloth, waxed] =
        [plate, narrow, wide, glass, cloth, waxed].map(|material| scene.material(material));
    let floor = quad(Vec3::new(-0.9, 0.01, -0.9), Vec3::Z * 2.4, Vec3::X * 1.8);
    scene.object("lacquered plate", &floor, plate);
    let half = Vec3::new(0.22, 0.35, 0.22);
    let block = cuboid(-half, half);
    scene.object("brushed block", &block.clone().turned(25.0).at(-0.55, 0.371, -0.35).closed(), narrow);
    scene.object("dull block", &block.clone().turned(-10.0).at(0.1, 0.371, -0.6).closed(), wide);
    scene.object("cloth", &block.clone().scaled(0.6).turned(40.0).at(-0.5, 0.231, 0.35).closed(), cloth);
    let gem = icosphere(1).scaled(0.3).faceted();
    scene.object("frosted gem", &gem.clone().at(0.45, 0.45, 0.1).closed(), glass);
    scene.object("waxed gem", &gem.scaled(0.6).at(-0.05, 0.22, 0.45).closed(), waxed);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.85, 0.0), 55.0);
    scene
}

/// The same room with textures of every filter and wrap on what an independent renderer maps exactly: Lambertian walls,
/// metal of uneven colour and roughness, and a lamp with dark spots (its coordinates once over the unit square, which is
/// what that renderer samples).
pub fn textured_box() -> Document {
    let (repeat, clamp, mirror) = (10497, 33071, 33648);
    let noise =
        |n: usize| ((n as u32 + 1).wrapping_mul(0x9e37_79b9).rotate_left(11).wrapping_mul(0x85eb_ca6b) >> 24) as u8;
    let mut scene = Document::default();
    let spots: Vec<[u8; 3]> =
        (0..64).map(|i| [noise(i), noise(i + 64), noise(i + 128)].map(|b| 110 + b / 9 * 5)).collect();
    let rings: Vec<[u8; 3]> = (0..32).map(|i| [150 + noise(i + 300) / 3, 170, 250 - noise(i + 400) / 3]).collect();
    // Green is roughness, blue metallic: alpha from 0.16 to 0.72.
    let rough: Vec<[u8; 3]> = (0..24).map(|i| [0, 102 + noise(i + 500) / 9 * 4, 255]).collect();
    let tint: Vec<[u8; 3]> =
        (0..12).map(|i| [255 - noise(i + 600) / 8, 180 + noise(i + 700) / 4, 90 + noise(i + 800) / 2]).collect();
    let glow: Vec<[u8; 3]> =
        (0..8).map(|i| if (i + i / 4) % 2 == 0 { [255, 225, 170] } else { [190, 90, 110] }).collect();
    let spots = scene.texture(8, &spots, true, repeat);
    let rings = scene.texture(4, &rings, false, mirror);
    let rough = scene.texture(6, &rough, true, mirror);
    let tint = scene.texture(4, &tint, true, clamp);
    let glow = scene.texture(4, &glow, false, repeat);
    let painted = |name, texture| Material::lambert(name, [0.9, 0.85, 0.8]).painted("baseColorTexture", texture);
    let floor = scene.material(painted("floor", spots));
    let wall = scene.material(painted("wall", rings));
    let blue = scene.material(Material::lambert("blue", [0.1, 0.25, 0.65]));
    let metal = Material::metal("metal", [0.95, 0.9, 0.9], 1.0)
        .painted("baseColorTexture", tint)
        .painted("metallicRoughnessTexture", rough);
    let metal = scene.material(metal);
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.9, 0.8], 7.0).painted("emissiveTexture", glow));

    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 3.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    let flat = |p: Vec3, _: Vec3| [0.7 * p.x + 0.4 * p.z, 0.3 * p.x - 0.8 * p.z];
    let upright = |p: Vec3, _: Vec3| [0.9 * p.x + 0.6 * p.z - 0.2, 0.5 - 1.1 * p.y];
    let shell = Mesh::joined(&[quad(corner, z, x), quad(corner + y, x, z)]);
    scene.painted_object("floor and ceiling", &shell, floor, flat);
    let walls = Mesh::joined(&[quad(corner, y, z), quad(corner, x, y), quad(corner + z, y, x)]);
    scene.painted_object("walls", &walls, wall, upright);
    scene.object("right wall", &quad(corner + x, z, y), blue);
    scene.painted_object("lamp", &quad(Vec3::new(-0.5, 1.99, -0.5), Vec3::X, Vec3::Z), lamp, |p, _| {
        [p.x + 0.5, p.z + 0.5]
    });
    let half = Vec3::new(0.28, 0.4, 0.28);
    let block = cuboid(-half, half);
    let around = |p: Vec3, n: Vec3| [2.0 * p.x + p.z + 0.3 * n.y, 1.5 * p.y - 0.8 * p.z + 0.2];
    scene.painted_object("block", &block.clone().turned(25.0).at(-0.4, 0.401, -0.35).closed(), metal, around);
    scene.painted_object("box", &block.scaled(0.7).turned(-30.0).at(0.45, 0.281, 0.2).closed(), metal, around);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.85, 0.0), 55.0);
    scene
}

/// A closed room under a large lamp: floor and ceiling, left wall, right wall, ends, lamp.
fn room(scene: &mut Document, [white, orange, blue, green, lamp]: [usize; 5]) {
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 3.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    let shell = Mesh::joined(&[quad(corner, z, x), quad(corner + y, x, z)]);
    scene.object("floor and ceiling", &shell, white);
    scene.object("left wall", &quad(corner, y, z), orange);
    scene.object("right wall", &quad(corner + x, z, y), blue);
    let ends = Mesh::joined(&[quad(corner, x, y), quad(corner + z, y, x)]);
    scene.object("back and front", &ends, green);
    let panel = quad(Vec3::new(-0.5, 1.99, -0.5), Vec3::X, Vec3::Z);
    scene.object("lamp", &panel, lamp);
}

/// A closed coloured room in which all light starts inside glass (so light and camera are in different media), and a
/// mirror whose shading normals lean away from its geometric ones: what METHOD.md's corrections C1 to C3 are about.
pub fn lamp_in_glass() -> Document {
    let mut scene = Document::default();
    let white = scene.material(Material::lambert("white", [0.7, 0.7, 0.7]));
    let orange = scene.material(Material::lambert("orange", [0.75, 0.3, 0.08]));
    let blue = scene.material(Material::lambert("blue", [0.1, 0.25, 0.65]));
    let glass = scene.material(Material::glass("rose glass", [0.95, 0.75, 0.8], 1.5));
    let mirror = scene.material(Material::metal("mirror", [1.0; 3], 0.0));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.85, 0.6], 9.0));

    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 3.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    let shell = [quad(corner, z, x), quad(corner + y, x, z), quad(corner, x, y), quad(corner + z, y, x)];
    scene.object("floor, ceiling, back and front", &Mesh::joined(&shell), white);
    scene.object("left wall", &quad(corner, y, z), orange);
    scene.object("right wall", &quad(corner + x, z, y), blue);
    let centre = Vec3::new(0.25, 0.95, 0.0);
    let gem = icosphere(2).scaled(0.45).faceted();
    scene.object("gem", &gem.at(centre.x, centre.y, centre.z).closed(), glass);
    let core = icosphere(1).scaled(0.2).faceted();
    scene.object("lamp", &core.at(centre.x, centre.y, centre.z).closed(), lamp);
    let mut pane = quad(Vec3::new(-0.85, 0.3, -0.8), Vec3::new(0.45, 0.0, -0.15), Vec3::Y * 1.2);
    for n in &mut pane.normals {
        *n = (*n + Vec3::new(0.12, 0.1, 0.0)).normalize();
    }
    scene.object("leaning mirror", &pane, mirror);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.9, 0.0), 55.0);
    scene
}
