//! A bathroom without a lamp in sight: strips of light lie on a ceiling panel that hangs below the ceiling, and behind
//! the mirror. A glass screen, chrome, glazed tiles, bottles; the mirror shows the half of the room behind the camera.

use crate::crockery;
use crate::fittings::{Tiling, bar_handle, basin, bottle, front, tap};
use crate::furniture::door;
use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{block, cuboid, ellipsoid, quad, rod, rounded_box, spline};
use glam::{Quat, Vec2, Vec3};

const LEFT: f32 = -1.15;
const RIGHT: f32 = 1.30;
const BACK: f32 = -1.3;
const FRONT: f32 = 2.0;
const CEILING: f32 = 2.50;
const WALL: f32 = 0.1;
// The ceiling panel.
const PANEL: f32 = 2.28;
// The board under the basin.
const TOP: f32 = 0.80;
const BASIN: Vec3 = Vec3::new(-0.30, TOP, BACK + 0.295);
// The glass screen of the shower.
const SCREEN: f32 = 0.46;

pub fn build() -> Document {
    let mut scene = Document::default();
    room(&mut scene);
    ceiling_panel(&mut scene);
    mirror(&mut scene);
    vanity(&mut scene);
    shower(&mut scene);
    behind_the_camera(&mut scene);
    scene.camera("main", Vec3::new(-0.28, 1.42, 1.52), Vec3::new(0.03, 1.10, -1.3), 43.0);
    scene
}

fn room(scene: &mut Document) {
    let plaster = scene.material(Material::lambert("plaster", [0.80, 0.77, 0.72]));
    let grout = scene.material(Material::lambert("grout", [0.62, 0.62, 0.58]));
    let (wide, tall, deep) = ([LEFT - WALL, RIGHT + WALL], [-WALL, CEILING + WALL], [BACK - WALL, FRONT + WALL]);
    let walls = Mesh::joined(&[
        block([wide[0], LEFT], tall, deep),
        block(wide, tall, [FRONT, deep[1]]),
        block(wide, [CEILING, tall[1]], deep),
    ]);
    scene.object("walls and ceiling", &walls, plaster);
    let tiled = Mesh::joined(&[
        block(wide, tall, [deep[0], BACK]),
        block([RIGHT, wide[1]], tall, deep),
        block(wide, [tall[0], 0.0], deep),
    ]);
    scene.object("walls and floor under tiles", &tiled, grout);

    let glazes = [[0.30, 0.57, 0.54], [0.25, 0.52, 0.51], [0.36, 0.61, 0.56], [0.28, 0.54, 0.57]]
        .map(|rgb| scene.material(Material::glossy("sea-green glaze", rgb, 0.16)));
    let tiling = Tiling { size: Vec2::new(0.1, 0.1), gap: 0.0035, shift: 0.0, askew: 0.018 };
    let mut random = Random(21);
    let height = Vec3::Y * CEILING;
    let back: [Mesh; 4] = tiling.lay(Vec3::new(LEFT, 0.0, BACK + 0.003), Vec3::X * (RIGHT - LEFT), height, &mut random);
    let right: [Mesh; 4] = tiling.lay(Vec3::new(RIGHT - 0.003, 0.0, BACK), Vec3::Z * 1.6, height, &mut random);
    for (i, glaze) in glazes.into_iter().enumerate() {
        scene.object(&format!("wall tiles {i}"), &Mesh::joined(&[back[i].clone(), right[i].clone()]), glaze);
    }
    let floor =
        [[0.66, 0.62, 0.55], [0.61, 0.58, 0.52]].map(|rgb| scene.material(Material::glossy("floor tile", rgb, 0.25)));
    let tiling = Tiling { size: Vec2::new(0.30, 0.30), gap: 0.004, shift: 0.5, askew: 0.001 };
    let across = Vec3::X * (RIGHT - LEFT);
    let tiles: [Mesh; 2] = tiling.lay(Vec3::new(LEFT, 0.0, FRONT), across, Vec3::NEG_Z * (FRONT - BACK), &mut random);
    for (i, (mesh, glaze)) in tiles.iter().zip(floor).enumerate() {
        scene.object(&format!("floor tiles {i}"), mesh, glaze);
    }
}

/// Hung below the ceiling and open all around: the strips on its back shine up, and its raised rim hides them.
fn ceiling_panel(scene: &mut Document) {
    let white = scene.material(Material::lambert("ceiling panel", [0.82, 0.80, 0.76]));
    let strip = scene.material(Material::lamp("ceiling strips", [1.0, 0.87, 0.70], 105.0));
    let (x, z) = ([LEFT + 0.26, RIGHT - 0.26], [BACK + 0.26, FRONT - 0.26]);
    let rim = [PANEL, PANEL + 0.055];
    let panel = Mesh::joined(&[
        block(x, [PANEL, PANEL + 0.02], z),
        block([x[0], x[0] + 0.012], rim, z),
        block([x[1] - 0.012, x[1]], rim, z),
        block(x, rim, [z[0], z[0] + 0.012]),
        block(x, rim, [z[1] - 0.012, z[1]]),
    ]);
    scene.object("ceiling panel", &panel, white);
    let y = PANEL + 0.024;
    let (inset, width) = (0.04, 0.035);
    let lying =
        |x: [f32; 2], z: [f32; 2]| quad(Vec3::new(x[0], y, z[0]), Vec3::Z * (z[1] - z[0]), Vec3::X * (x[1] - x[0]));
    let (x, z) = ([x[0] + inset, x[1] - inset], [z[0] + inset, z[1] - inset]);
    let strips = Mesh::joined(&[
        lying([x[0], x[0] + width], z),
        lying([x[1] - width, x[1]], z),
        lying([x[0] + width, x[1] - width], [z[0], z[0] + width]),
        lying([x[0] + width, x[1] - width], [z[1] - width, z[1]]),
    ]);
    scene.object("ceiling strips", &strips, strip);
}

/// A mirror held off the wall, with strips behind it that light the tiles around.
fn mirror(scene: &mut Document) {
    let silver = scene.material(Material::metal("mirror", [0.93, 0.94, 0.94], 0.0));
    let back = scene.material(Material::lambert("mirror back", [0.70, 0.68, 0.64]));
    let strip = scene.material(Material::lamp("mirror strips", [1.0, 0.83, 0.62], 45.0));
    let (low, high) = (Vec2::new(-0.86, 1.14), Vec2::new(0.26, 1.96));
    let z = BACK + 0.055;
    let size = high - low;
    scene.object("mirror", &quad(low.extend(z + 0.006), Vec3::X * size.x, Vec3::Y * size.y), silver);
    scene.object("mirror back", &cuboid(low.extend(z), high.extend(z + 0.0055)), back);
    // They face the wall.
    let (a, b) = (low + Vec2::splat(0.05), high - Vec2::splat(0.05));
    let width = 0.03;
    let strips = [
        (a, Vec2::new(b.x, a.y + width)),
        (Vec2::new(a.x, b.y - width), b),
        (Vec2::new(a.x, a.y + width), Vec2::new(a.x + width, b.y - width)),
        (Vec2::new(b.x - width, a.y + width), Vec2::new(b.x, b.y - width)),
    ];
    let strips = strips.map(|(a, b)| quad(a.extend(z - 0.002), Vec3::Y * (b.y - a.y), Vec3::X * (b.x - a.x)));
    scene.object("mirror strips", &Mesh::joined(&strips), strip);
}

/// The board with the basin and what stands on it, over two drawers.
fn vanity(scene: &mut Document) {
    let oak = scene.material(Material::glossy("oak", [0.46, 0.28, 0.15], 0.42));
    let dark = scene.material(Material::lambert("carcass", [0.12, 0.08, 0.05]));
    let stone = scene.material(Material::glossy("polished stone", [0.70, 0.68, 0.64], 0.14));
    let chrome = scene.material(Material::metal("chrome", [0.82, 0.82, 0.82], 0.08));
    let china = scene.material(Material::glossy("china", [0.84, 0.83, 0.80], 0.10));
    let x = [-1.02, 0.40];
    let depth = BACK + 0.54;
    scene.object(
        "board",
        &rounded_box(Vec3::new(0.5 * (x[1] - x[0]), 0.016, 0.27), 0.004, 3).at(
            0.5 * (x[0] + x[1]),
            TOP - 0.016,
            BACK + 0.27,
        ),
        stone,
    );
    scene.object("drawers", &block([x[0] + 0.02, x[1] - 0.02], [0.42, TOP - 0.03], [BACK, depth - 0.035]), dark);
    let middle = 0.5 * (x[0] + x[1]);
    let leaf = |a: f32, b: f32| front(Vec2::new(a, 0.42), Vec2::new(b, TOP - 0.045)).at(0.0, 0.0, depth - 0.03);
    let leaves = Mesh::joined(&[leaf(x[0] + 0.02, middle), leaf(middle, x[1] - 0.02)]);
    scene.object("drawer fronts", &leaves, oak);
    let grip = |x: f32| bar_handle(0.22, false).at(x, TOP - 0.10, depth - 0.02);
    scene.object("drawer handles", &Mesh::joined(&[grip(-0.67), grip(0.05)]), chrome);

    let top = 0.0005;
    scene.object("basin", &basin().at(BASIN.x, BASIN.y + top, BASIN.z), china);
    scene.object("tap", &tap(0.34, 0.17).at(BASIN.x, TOP, BACK + 0.055), chrome);
    let plug = ellipsoid(Vec3::new(0.022, 0.004, 0.022), 3);
    scene.object("plug", &plug.at(BASIN.x, BASIN.y + 0.019, BASIN.z), chrome);

    let amber = scene.material(Material::glass("amber glass", [0.93, 0.60, 0.20], 1.5));
    let green = scene.material(Material::glass("green glass", [0.62, 0.90, 0.72], 1.5));
    let clear = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let place = |mesh: Mesh, x: f32, z: f32| mesh.at(x, TOP + top, BACK + z);
    scene.object("amber bottle", &place(bottle(0.034, 0.20, 0.014), 0.02, 0.17).closed(), amber);
    scene.object("green bottle", &place(bottle(0.027, 0.26, 0.012), 0.11, 0.12).closed(), green);
    scene.object("flask", &place(bottle(0.045, 0.14, 0.018), 0.14, 0.26).closed(), clear);
    scene.object("tumbler", &place(crockery::tumbler(), -0.66, 0.16).closed(), clear);
    let brushes = [([0.55, 0.12, 0.10], -0.016, 0.035), ([0.12, 0.22, 0.45], 0.012, -0.04)];
    for (rgb, foot, tip) in brushes {
        let plastic = scene.material(Material::glossy("toothbrush", rgb, 0.3));
        // From the tumbler's floor over its rim.
        let path = spline(
            &[[foot, 0.022, 0.0, 0.0045], [0.5 * (foot + tip), 0.11, 0.01, 0.0035], [tip, 0.19, 0.02, 0.005]],
            5,
        );
        scene.object("toothbrush", &place(rod(&path, 12), -0.66, 0.16), plastic);
    }
    let soap = scene.material(Material::glossy("soap", [0.78, 0.60, 0.50], 0.4));
    let dish = rounded_box(Vec3::new(0.062, 0.006, 0.042), 0.005, 3).turned(-20.0);
    scene.object("soap dish", &place(dish, -0.70, 0.36).at(0.0, 0.006, 0.0), china);
    let bar = ellipsoid(Vec3::new(0.043, 0.015, 0.028), 3).turned(-20.0);
    scene.object("soap", &place(bar, -0.70, 0.36).at(0.0, 0.025, 0.0), soap);
    let towels = [[0.72, 0.50, 0.36], [0.80, 0.77, 0.70]];
    for (i, rgb) in towels.into_iter().enumerate() {
        let cloth = scene.material(Material::lambert("towel", rgb));
        let fold = rounded_box(Vec3::new(0.095, 0.027, 0.13), 0.024, 4).turned(6.0 - 9.0 * i as f32);
        scene.object(
            &format!("folded towel {i}"),
            &place(fold, -0.90, 0.24).at(0.0, 0.027 + 0.053 * i as f32, 0.0),
            cloth,
        );
    }
}

/// A pane on a raised tray, and a shower on the wall behind it.
fn shower(scene: &mut Document) {
    let pane = scene.material(Material::glass("shower screen", [0.965, 0.99, 0.98], 1.5));
    let chrome = scene.material(Material::metal("shower chrome", [0.82, 0.82, 0.82], 0.12));
    let tray = scene.material(Material::glossy("shower tray", [0.82, 0.81, 0.78], 0.25));
    let end = BACK + 1.0;
    let base = block([SCREEN - 0.03, RIGHT], [0.0, 0.06], [BACK, end + 0.05]);
    scene.object("shower tray", &base, tray);
    let glass = rounded_box(Vec3::new(0.005, 0.99, 0.5 * (end - BACK) - 0.01), 0.002, 2);
    scene.object("shower screen", &glass.at(SCREEN, 1.055, 0.5 * (BACK + end) + 0.005).closed(), pane);
    // Clear of the glass by some millimetres, so that no surface cuts another.
    let fitting = |y: f32| {
        let plate = |x: f32| rounded_box(Vec3::new(0.006, 0.025, 0.025), 0.003, 2).at(x, y, BACK + 0.06);
        Mesh::joined(&[plate(SCREEN - 0.0125), plate(SCREEN + 0.0125)])
    };
    let stay = rod(&[[SCREEN, 2.065, end - 0.06, 0.009], [RIGHT, 2.065, end - 0.06, 0.009]], 20);
    scene.object("screen fittings", &Mesh::joined(&[fitting(0.35), fitting(1.75), stay]), chrome);

    let (x, z) = (0.88, BACK + 0.055);
    let riser = rod(&[[x, 1.02, z, 0.011], [x, 1.98, z, 0.011]], 24);
    let arm = spline(
        &[
            [x, 1.96, z, 0.011],
            [x, 2.03, z + 0.02, 0.011],
            [x, 2.06, z + 0.09, 0.011],
            [x, 2.06, z + 0.34, 0.011],
            [x, 2.03, z + 0.38, 0.011],
            [x, 2.00, z + 0.385, 0.011],
        ],
        6,
    );
    let head = rod(&[[x, 1.975, z + 0.385, 0.105], [x, 1.99, z + 0.385, 0.105], [x, 2.005, z + 0.385, 0.03]], 48);
    let valve = rod(&[[x - 0.13, 1.02, z, 0.024], [x + 0.13, 1.02, z, 0.024]], 32);
    let knob = |s: f32| rod(&[[x + s * 0.13, 1.02, z, 0.029], [x + s * 0.19, 1.02, z, 0.027]], 32);
    let feet = |y: f32| rod(&[[x, y, BACK, 0.014], [x, y, z, 0.012]], 20);
    let parts = [riser, rod(&arm, 24), head, valve, knob(1.0), knob(-1.0), feet(1.08), feet(1.90)];
    scene.object("shower", &Mesh::joined(&parts), chrome);
    let hand = rod(
        &[[x + 0.06, 1.50, z + 0.05, 0.014], [x + 0.06, 1.66, z + 0.075, 0.016], [x + 0.06, 1.70, z + 0.10, 0.034]],
        24,
    );
    let hose = spline(
        &[
            [x + 0.06, 1.51, z + 0.05, 0.007],
            [x + 0.08, 1.20, z + 0.06, 0.007],
            [x + 0.05, 0.74, z + 0.05, 0.007],
            [x, 0.70, z + 0.03, 0.007],
            [x - 0.03, 0.80, z + 0.01, 0.007],
            [x, 1.01, z, 0.007],
        ],
        8,
    );
    let holder = rod(&[[x, 1.62, z, 0.012], [x + 0.06, 1.62, z + 0.065, 0.012]], 16);
    scene.object("hand shower", &Mesh::joined(&[hand, rod(&hose, 12), holder]), chrome);
}

/// What the mirror shows: a door, and a towel on a rail.
fn behind_the_camera(scene: &mut Document) {
    let paint = scene.material(Material::glossy("door paint", [0.62, 0.40, 0.22], 0.4));
    let brass = scene.material(Material::metal("door handle", [0.88, 0.70, 0.38], 0.25));
    let cloth = scene.material(Material::lambert("bath towel", [0.70, 0.32, 0.20]));
    let turn =
        |mesh: Mesh, x: f32| mesh.moved(Quat::from_rotation_y(std::f32::consts::PI), Vec3::new(x, 0.0, FRONT - 0.01));
    let (leaf, levers) = door(0.80, 2.0);
    scene.object("door", &turn(leaf, 0.95), paint);
    scene.object("door handles", &turn(levers, 0.95), brass);
    let x = LEFT + 0.09;
    let z = [0.55, 1.25];
    let rail = rod(&[[x, 1.25, z[0], 0.009], [x, 1.25, z[1], 0.009]], 20);
    let post = |z: f32| rod(&[[LEFT, 1.25, z, 0.012], [x, 1.25, z, 0.010]], 16);
    scene.object("towel rail", &Mesh::joined(&[rail, post(z[0] + 0.02), post(z[1] - 0.02)]), brass);
    let hang = |dx: f32, low: f32| {
        rounded_box(Vec3::new(0.008, 0.5 * (1.27 - low), 0.23), 0.007, 3).at(x + dx, 0.5 * (1.27 + low), 0.90)
    };
    scene.object("bath towel", &Mesh::joined(&[hang(0.015, 0.62), hang(-0.015, 0.72)]), cloth);
}
