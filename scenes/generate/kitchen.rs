//! A kitchen in the morning: daylight comes in by a window at the left, from a bright wide panel outside, and a small
//! warm lamp hangs over the worktop. Nearly everything is glossy: steel, polished stone, lacquer, glazed tiles.

use crate::crockery;
use crate::fittings::{Tiling, bar_handle, bottle, bowl, cooking_pot, front, saucepan, tap, wine_glass};
use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{block, ellipsoid, icosphere, lathe, quad, rod, rounded_box, smooth_profile};
use glam::{Quat, Vec2, Vec3};

const LEFT: f32 = -1.75;
const RIGHT: f32 = 1.28;
const BACK: f32 = -1.5;
const FRONT: f32 = 1.9;
const CEILING: f32 = 2.5;
const WALL: f32 = 0.28;
// The window, in the left wall.
const SILL: f32 = 1.06;
const LINTEL: f32 = 2.16;
const WINDOW: [f32; 2] = [-1.36, 0.14];
// The worktop runs along the back wall.
const TOP: f32 = 0.92;
const DEPTH: f32 = 0.64;
const EDGE: f32 = BACK + DEPTH;
const FRIDGE: f32 = 0.60;
const SINK_X: [f32; 2] = [-1.38, -0.82];
const SINK_Z: [f32; 2] = [BACK + 0.14, BACK + 0.54];
const SHELF: f32 = 1.56;

pub fn build() -> Document {
    let mut scene = Document::default();
    room(&mut scene);
    window(&mut scene);
    units(&mut scene);
    sink(&mut scene);
    shelf(&mut scene);
    lamp(&mut scene);
    worktop_things(&mut scene);
    scene.camera("main", Vec3::new(0.60, 1.46, 0.72), Vec3::new(-0.37, 1.17, -1.3), 46.0);
    scene
}

fn room(scene: &mut Document) {
    let plaster = scene.material(Material::lambert("plaster", [0.84, 0.80, 0.72]));
    let ceiling = scene.material(Material::lambert("ceiling", [0.82, 0.80, 0.76]));
    let floor = scene.material(Material::lambert("grout", [0.45, 0.42, 0.38]));
    let (wide, tall, deep) = ([LEFT - WALL, RIGHT + WALL], [-0.1, CEILING + 0.1], [BACK - WALL, FRONT + WALL]);
    let side = [LEFT - WALL, LEFT];
    let walls = Mesh::joined(&[
        block(wide, tall, [deep[0], BACK]),
        block(wide, tall, [FRONT, deep[1]]),
        block([RIGHT, wide[1]], tall, deep),
        block(side, tall, [deep[0], WINDOW[0]]),
        block(side, tall, [WINDOW[1], deep[1]]),
        block(side, [tall[0], SILL], [WINDOW[0] - 0.01, WINDOW[1] + 0.01]),
        block(side, [LINTEL, tall[1]], [WINDOW[0] - 0.01, WINDOW[1] + 0.01]),
    ]);
    scene.object("walls", &walls, plaster);
    scene.object("ceiling", &block(wide, [CEILING, CEILING + 0.1], deep), ceiling);
    scene.object("floor", &block(wide, [-0.1, -0.001], deep), floor);
    let clay = [[0.46, 0.38, 0.31], [0.50, 0.42, 0.34], [0.43, 0.36, 0.29]]
        .map(|rgb| scene.material(Material::glossy("floor tile", rgb, 0.28)));
    let tiling = Tiling { size: Vec2::new(0.45, 0.45), gap: 0.005, shift: 0.0, askew: 0.001 };
    let tiles: [Mesh; 3] =
        tiling.lay(Vec3::new(LEFT, 0.0, FRONT), Vec3::X * (RIGHT - LEFT), Vec3::NEG_Z * (FRONT - BACK), &mut Random(3));
    for (i, (mesh, glaze)) in tiles.iter().zip(clay).enumerate() {
        scene.object(&format!("floor tiles {i}"), mesh, glaze);
    }

    // Glazed tiles in bond, over the worktop.
    let glazes = [[0.74, 0.75, 0.68], [0.70, 0.73, 0.67], [0.77, 0.76, 0.70]]
        .map(|rgb| scene.material(Material::glossy("glazed tile", rgb, 0.15)));
    let tiling = Tiling { size: Vec2::new(0.20, 0.10), gap: 0.004, shift: 0.5, askew: 0.012 };
    let low = Vec3::new(LEFT, TOP, BACK + 0.003);
    let tiles: [Mesh; 3] = tiling.lay(low, Vec3::X * (FRIDGE - LEFT), Vec3::Y * (CEILING - 0.22 - TOP), &mut Random(8));
    for (i, (mesh, glaze)) in tiles.iter().zip(glazes).enumerate() {
        scene.object(&format!("wall tiles {i}"), mesh, glaze);
    }
}

/// A casement of four lights, its sill, and the day outside.
fn window(scene: &mut Document) {
    let white = scene.material(Material::glossy("window paint", [0.80, 0.79, 0.75], 0.35));
    let day = scene.material(Material::lamp("daylight", [0.88, 0.95, 1.0], 7.5));
    let x = [LEFT - 0.17, LEFT - 0.12];
    let middle = 0.5 * (WINDOW[0] + WINDOW[1]);
    let bar = |z: [f32; 2], y: [f32; 2]| block(x, y, z);
    let frame = Mesh::joined(&[
        bar([WINDOW[0] - 0.01, WINDOW[0] + 0.05], [SILL - 0.01, LINTEL + 0.01]),
        bar([WINDOW[1] - 0.05, WINDOW[1] + 0.01], [SILL - 0.01, LINTEL + 0.01]),
        bar([middle - 0.03, middle + 0.03], [SILL - 0.01, LINTEL + 0.01]),
        block([x[0] + 0.001, x[1] - 0.001], [SILL - 0.01, SILL + 0.05], WINDOW),
        block([x[0] + 0.001, x[1] - 0.001], [LINTEL - 0.05, LINTEL + 0.01], WINDOW),
        block([x[0] + 0.01, x[1] - 0.01], [1.70, 1.73], WINDOW),
        block([LEFT - 0.12, LEFT + 0.03], [SILL - 0.02, SILL + 0.012], [WINDOW[0] - 0.04, WINDOW[1] + 0.04]),
    ]);
    scene.object("window frame", &frame, white);
    // Wide and high, so that the window shows nothing else.
    let panel = quad(Vec3::new(LEFT - 0.8, 0.4, 1.6), Vec3::NEG_Z * 4.4, Vec3::Y * 2.8);
    scene.object("daylight", &panel, day);
}

/// Cupboards below the worktop, the worktop around the sink, and the tall refrigerator.
fn units(scene: &mut Document) {
    let lacquer = scene.material(Material::glossy("lacquer", [0.085, 0.25, 0.265], 0.22));
    let carcass = scene.material(Material::lambert("carcass", [0.05, 0.06, 0.06]));
    let steel = scene.material(Material::metal("brushed steel", [0.66, 0.65, 0.63], 0.42));
    let bars = scene.material(Material::metal("handle steel", [0.74, 0.73, 0.71], 0.3));
    let stone = scene.material(Material::glossy("polished stone", [0.13, 0.125, 0.12], 0.12));

    let body = block([LEFT, FRIDGE], [0.10, TOP - 0.045], [BACK, EDGE - 0.045]);
    let plinth = block([LEFT, FRIDGE], [0.0, 0.11], [BACK, EDGE - 0.09]);
    scene.object("cupboards", &Mesh::joined(&[body, plinth]), carcass);
    let (mut doors, mut handles) = (Mesh::default(), Mesh::default());
    let z = EDGE - 0.035;
    let columns = [LEFT, -1.16, -0.58, 0.0, FRIDGE];
    for (i, pair) in columns.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let ends: &[f32] = if i == 2 { &[0.11, 0.37, 0.62, TOP - 0.05] } else { &[0.11, 0.70, TOP - 0.05] };
        for rows in ends.windows(2) {
            doors.append(&front(Vec2::new(a, rows[0]), Vec2::new(b, rows[1])).at(0.0, 0.0, z));
            handles.append(&bar_handle(0.20, false).at(0.5 * (a + b), rows[1] - 0.05, z + 0.01));
        }
    }
    scene.object("cupboard fronts", &doors, lacquer);
    scene.object("cupboard handles", &handles, bars);

    let slab = [TOP - 0.04, TOP];
    let worktop = Mesh::joined(&[
        block([LEFT, SINK_X[0]], slab, [BACK, EDGE]),
        block([SINK_X[1], FRIDGE], slab, [BACK, EDGE]),
        block(SINK_X, slab, [BACK, SINK_Z[0]]),
        block(SINK_X, slab, [SINK_Z[1], EDGE]),
    ]);
    scene.object("worktop", &worktop, stone);

    let (x, z) = ([FRIDGE + 0.004, RIGHT - 0.004], EDGE + 0.02);
    scene.object("refrigerator", &block(x, [0.02, 2.14], [BACK, z - 0.03]), carcass);
    let lower = front(Vec2::new(x[0], 0.04), Vec2::new(x[1], 0.78));
    let upper = front(Vec2::new(x[0], 0.79), Vec2::new(x[1], 2.14));
    let leaves = Mesh::joined(&[lower.at(0.0, 0.0, z - 0.02), upper.at(0.0, 0.0, z - 0.02)]);
    scene.object("refrigerator doors", &leaves, steel);
    let grips = Mesh::joined(&[
        bar_handle(0.55, true).at(x[0] + 0.06, 1.18, z - 0.01),
        bar_handle(0.32, true).at(x[0] + 0.06, 0.56, z - 0.01),
    ]);
    scene.object("refrigerator handles", &grips, bars);
    let top = front(Vec2::new(x[0], 2.15), Vec2::new(x[1], CEILING - 0.01));
    let wall_top = block([FRIDGE, RIGHT], [2.141, CEILING], [BACK, z - 0.03]);
    scene.object("cupboard over the refrigerator", &wall_top, carcass);
    scene.object("front over the refrigerator", &top.at(0.0, 0.0, z - 0.02), lacquer);
}

/// A steel trough under the worktop, with the tap behind it.
fn sink(scene: &mut Document) {
    let steel = scene.material(Material::metal("sink steel", [0.66, 0.65, 0.63], 0.35));
    let chrome = scene.material(Material::metal("chrome", [0.80, 0.80, 0.80], 0.10));
    let (x, z, floor) = (SINK_X, SINK_Z, TOP - 0.21);
    let sheet = 0.012;
    let trough = Mesh::joined(&[
        block([x[0] - sheet, x[1] + sheet], [floor - sheet, floor], [z[0] - sheet, z[1] + sheet]),
        block([x[0] - sheet, x[0]], [floor, TOP - 0.002], [z[0], z[1]]),
        block([x[1], x[1] + sheet], [floor, TOP - 0.002], [z[0], z[1]]),
        block([x[0] - sheet, x[1] + sheet], [floor, TOP - 0.002], [z[0] - sheet, z[0]]),
        block([x[0] - sheet, x[1] + sheet], [floor, TOP - 0.002], [z[1], z[1] + sheet]),
    ]);
    scene.object("sink", &trough, steel);
    let at = Vec3::new(0.5 * (x[0] + x[1]), TOP, BACK + 0.085);
    scene.object("tap", &tap(0.33, 0.20).moved(Quat::from_rotation_y(0.25), at), chrome);
}

/// An oak board on two brackets, with glasses, bowls and jars on it.
fn shelf(scene: &mut Document) {
    let oak = scene.material(Material::glossy("oak", [0.47, 0.28, 0.14], 0.45));
    let glass = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let white = scene.material(Material::glossy("white glaze", [0.78, 0.76, 0.70], 0.2));
    let ochre = scene.material(Material::glossy("ochre glaze", [0.66, 0.36, 0.10], 0.2));
    let brass = scene.material(Material::metal("brass", [0.88, 0.70, 0.38], 0.25));
    let half = Vec3::new(0.70, 0.016, 0.12);
    let (x, z) = (-0.16, BACK + 0.13);
    scene.object("shelf", &rounded_box(half, 0.004, 2).at(x, SHELF - 0.016, z), oak);
    let bracket = |x: f32| {
        let arm = rod(&[[x, SHELF - 0.038, BACK, 0.006], [x, SHELF - 0.038, BACK + 0.22, 0.006]], 14);
        let strut = rod(&[[x, SHELF - 0.20, BACK, 0.006], [x, SHELF - 0.04, BACK + 0.18, 0.006]], 14);
        Mesh::joined(&[arm, strut])
    };
    scene.object("brackets", &Mesh::joined(&[bracket(x - 0.52), bracket(x + 0.52)]), brass);
    let top = SHELF + 0.0005;
    for (i, dx) in [0.36, 0.46, 0.57].into_iter().enumerate() {
        let mesh = wine_glass().at(x + dx, top, z + 0.02 - 0.03 * (i % 2) as f32);
        scene.object(&format!("wine glass {i}"), &mesh.closed(), glass);
    }
    let bowls = [0.0, 0.034, 0.068].map(|y| bowl().scaled(0.62).at(x - 0.08, top + y, z));
    scene.object("stack of bowls", &Mesh::joined(&bowls), white);
    scene.object("jug", &crockery::jug().scaled(0.78).turned(-145.0).at(x - 0.36, top, z), ochre);
    scene.object("jar", &jar().at(x - 0.58, top, z), white);
    scene.object("tumbler", &crockery::tumbler().at(x + 0.2, top, z + 0.02).closed(), glass);
}

/// A lidded jar of 22 cm.
fn jar() -> Mesh {
    let body = [[0.0, 0.0], [0.060, 0.0], [0.068, 0.008], [0.072, 0.05], [0.072, 0.13], [0.066, 0.160], [0.066, 0.166]];
    let lid = [[0.072, 0.170], [0.070, 0.182], [0.040, 0.193], [0.014, 0.198], [0.017, 0.212], [0.010, 0.221]];
    lathe(&smooth_profile(&[&body[..], &lid[..], &[[0.0, 0.222]]].concat(), 3), 48)
}

/// A small lamp over the worktop: a bulb in an enamelled shade.
fn lamp(scene: &mut Document) {
    let enamel = scene.material(Material::glossy("enamel", [0.62, 0.13, 0.06], 0.25));
    let bulb = scene.material(Material::lamp("bulb", [1.0, 0.74, 0.46], 420.0));
    let cord = scene.material(Material::lambert("cord", [0.06, 0.06, 0.06]));
    let (x, y, z) = (0.10, 1.76, BACK + 0.48);
    let inside = [[0.0, 0.126], [0.018, 0.124], [0.031, 0.111], [0.057, 0.076], [0.107, 0.031], [0.1405, -0.002]];
    let outside = [[0.1425, -0.004], [0.144, -0.002], [0.111, 0.036], [0.061, 0.081], [0.035, 0.116], [0.021, 0.129]];
    let skin = smooth_profile(&[&inside[..], &outside[..], &[[0.0, 0.131]]].concat(), 3);
    scene.object("lamp shade", &lathe(&skin, 48).at(x, y, z), enamel);
    scene.object("lamp bulb", &icosphere(2).scaled(0.030).at(x, y + 0.045, z), bulb);
    let socket = rod(&[[x, y + 0.07, z, 0.014], [x, y + 0.15, z, 0.016]], 20);
    let wire = rod(&[[x, y + 0.14, z, 0.003], [x, CEILING + 0.01, z, 0.003]], 10);
    scene.object("lamp cord", &Mesh::joined(&[socket, wire]), cord);
}

fn worktop_things(scene: &mut Document) {
    let steel = scene.material(Material::metal("pot steel", [0.72, 0.71, 0.69], 0.16));
    let copper = scene.material(Material::metal("copper", [0.93, 0.58, 0.42], 0.22));
    let hob = scene.material(Material::glossy("hob", [0.012, 0.012, 0.013], 0.08));
    let oil = scene.material(Material::glass("oil bottle", [0.80, 0.93, 0.55], 1.5));
    let glass = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let wood = scene.material(Material::glossy("board wood", [0.50, 0.31, 0.17], 0.5));
    let bowl_glaze = scene.material(Material::glossy("blue glaze", [0.10, 0.25, 0.42], 0.15));
    let lemon = scene.material(Material::glossy("lemon", [0.85, 0.62, 0.06], 0.45));
    let lime = scene.material(Material::glossy("lime", [0.30, 0.48, 0.07], 0.45));
    let top = TOP + 0.0005;

    let plate = rounded_box(Vec3::new(0.29, 0.004, 0.245), 0.003, 2);
    scene.object("hob", &plate.at(0.27, TOP + 0.003, BACK + 0.31), hob);
    let heat = TOP + 0.0075;
    scene.object("cooking pot", &cooking_pot(0.115, 0.145).turned(28.0).at(0.39, heat, BACK + 0.23), steel);
    scene.object("saucepan", &saucepan(0.085, 0.085).turned(-52.0).at(0.12, heat, BACK + 0.36), copper);

    let fruit_bowl = bowl().at(-0.36, top, BACK + 0.36);
    scene.object("fruit bowl", &fruit_bowl, bowl_glaze);
    let fruit = |x: f32, y: f32, z: f32, turn: f32| {
        let mesh = ellipsoid(Vec3::new(0.040, 0.032, 0.032), 3).turned(turn);
        mesh.at(-0.36 + x, TOP + y, BACK + 0.36 + z)
    };
    let lemons = [
        fruit(-0.05, 0.060, 0.03, 20.0),
        fruit(0.045, 0.060, 0.035, 100.0),
        fruit(0.005, 0.060, -0.05, -30.0),
        fruit(0.0, 0.108, 0.012, 55.0),
    ];
    scene.object("lemons", &Mesh::joined(&lemons), lemon);
    let limes = [fruit(-0.072, 0.092, -0.025, 70.0), fruit(0.070, 0.090, -0.028, 10.0)];
    scene.object("limes", &Mesh::joined(&limes), lime);

    let board = rounded_box(Vec3::new(0.15, 0.21, 0.010), 0.006, 3);
    let lean = Quat::from_rotation_x(-0.16);
    scene.object("cutting board", &board.moved(lean, Vec3::new(-0.50, TOP + 0.208, BACK + 0.055)), wood);
    scene.object("oil bottle", &bottle(0.034, 0.29, 0.014).at(-0.12, top, BACK + 0.20).closed(), oil);
    for (i, (x, z)) in [(-0.62, 0.44), (-0.70, 0.33)].into_iter().enumerate() {
        scene.object(&format!("water glass {i}"), &crockery::tumbler().at(x, top, BACK + z).closed(), glass);
    }
}
