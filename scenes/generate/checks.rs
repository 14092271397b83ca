//! The small scenes of the tests.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::shapes::{cuboid, icosphere, quad};
use glam::Vec3;

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

    let half = Vec3::new(0.28, 0.4, 0.28);
    let block = cuboid(-half, half).turned(25.0).at(-0.4, 0.401, -0.35);
    scene.object("block", &block.closed(), metal);
    let gem = icosphere(2).scaled(0.32).at(0.4, 0.45, 0.1).faceted();
    scene.object("gem", &gem.closed(), glass);
    scene.camera("main", Vec3::new(0.0, 1.0, 1.95), Vec3::new(0.0, 0.85, 0.0), 55.0);
    scene
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
