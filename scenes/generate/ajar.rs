//! A still life in a room without a lamp, after Veach's "door ajar" in spirit (Veach and Guibas 1997):
//! all light comes from the walls of the next room through the gap of a door.
//! The lamp there is a bowl that shines up from above the door's height: whoever looks through the gap
//! looks up at its black underside. So light takes the way lamp, ceiling next door, gap, table, camera.

use crate::crockery;
use crate::furniture::{bookcase, door, picture, picture_frame, table};
use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{block, icosphere, rod, rounded_box};
use glam::{Quat, Vec3};

// This room: x from LEFT to RIGHT, z from BACK to FRONT; the next room lies behind BACK - WALL.
const LEFT: f32 = -2.0;
const RIGHT: f32 = 1.9;
const BACK: f32 = -2.2;
const FRONT: f32 = 2.1;
const CEILING: f32 = 2.5;
// The next room is higher, so that its lamp can hang above the door and still be far from its ceiling.
const FAR_CEILING: f32 = 3.2;
const WALL: f32 = 0.15;
const FAR: f32 = -5.4;
// The clear opening of the doorway.
const DOOR_LEFT: f32 = -1.45;
const DOOR_RIGHT: f32 = -0.60;
const DOOR_TOP: f32 = 2.0;
const DOOR_DEG: f32 = 24.0;
const TABLE_TOP: f32 = 0.74;

pub fn build() -> Document {
    let mut scene = Document::default();
    rooms(&mut scene);
    doorway(&mut scene);
    furnish(&mut scene);
    lay_table(&mut scene);
    scene.camera("main", Vec3::new(0.40, 1.40, 1.78), Vec3::new(0.03, 0.92, -0.9), 40.0);
    scene
}

/// Floor, ceiling and walls as solid overlapping blocks, so that no ray slips out or through.
fn rooms(scene: &mut Document) {
    let plaster = scene.material(Material::lambert("plaster", [0.80, 0.71, 0.57]));
    let ceiling = scene.material(Material::lambert("ceiling", [0.80, 0.77, 0.71]));
    let next = scene.material(Material::lambert("next room", [0.84, 0.79, 0.70]));
    let white = scene.material(Material::lambert("skirting", [0.76, 0.72, 0.64]));
    let planks = [[0.46, 0.29, 0.16], [0.52, 0.33, 0.19], [0.41, 0.25, 0.14]]
        .map(|rgb| scene.material(Material::lambert("plank", rgb)));

    let (out_left, out_right) = (LEFT - WALL, RIGHT + WALL);
    let tall = [-0.1, CEILING + 0.1];
    let partition_back = BACK - WALL;
    let walls = Mesh::joined(&[
        block([out_left, LEFT], tall, [partition_back + 0.01, FRONT + WALL]),
        block([RIGHT, out_right], tall, [partition_back + 0.01, FRONT + WALL]),
        block([LEFT - 0.05, RIGHT + 0.05], tall, [FRONT, FRONT + WALL]),
        block([out_left, DOOR_LEFT - 0.03], tall, [BACK - 0.07, BACK]),
        block([DOOR_RIGHT + 0.03, out_right], tall, [BACK - 0.07, BACK]),
        block([DOOR_LEFT - 0.03, DOOR_RIGHT + 0.03], [DOOR_TOP + 0.03, CEILING + 0.1], [BACK - 0.07, BACK]),
    ]);
    scene.object("walls", &walls, plaster);
    let (far_left, far_right) = (-3.2, 1.2);
    let tall = [-0.1, FAR_CEILING + 0.1];
    let beyond = Mesh::joined(&[
        block([far_left - WALL, DOOR_LEFT - 0.03], tall, [partition_back, BACK - 0.07]),
        block([DOOR_RIGHT + 0.03, out_right], tall, [partition_back, BACK - 0.07]),
        block([DOOR_LEFT - 0.03, DOOR_RIGHT + 0.03], [DOOR_TOP + 0.03, tall[1]], [partition_back, BACK - 0.07]),
        block([far_left - WALL, far_left], tall, [FAR - WALL, partition_back + 0.01]),
        block([far_right, far_right + WALL], tall, [FAR - WALL, partition_back + 0.01]),
        block([far_left - 0.05, far_right + 0.05], tall, [FAR - WALL, FAR]),
    ]);
    scene.object("walls of the next room", &beyond, next);
    let (wide, deep) = ([far_left - WALL, out_right], [FAR - WALL, FRONT + WALL]);
    let lids = Mesh::joined(&[
        block([out_left, out_right], [CEILING, CEILING + 0.1], [BACK - 0.06, FRONT + WALL]),
        block(wide, [FAR_CEILING, FAR_CEILING + 0.1], [FAR - WALL, partition_back + 0.05]),
    ]);
    scene.object("ceilings", &lids, ceiling);

    // Planks run along x in three browns over a slab, which keeps the floor closed.
    let mut floor = [block(wide, [-0.1, -0.004], deep), Mesh::default(), Mesh::default()];
    let mut random = Random(5);
    let width = 0.14;
    let rows = ((deep[1] - deep[0]) / width) as u32;
    for row in 0..rows {
        let z = [deep[0] + width * row as f32, deep[0] + width * (row as f32 + 1.0) - 0.003];
        let mut x = wide[0] - random.between(0.0, 1.0);
        while x < wide[1] {
            let end = x + random.between(0.9, 1.7);
            let shade = (random.unit() * 3.0) as usize;
            floor[shade].append(&block([x, end - 0.003], [-0.02, 0.0], z));
            x = end;
        }
    }
    for (i, (boards, shade)) in floor.iter().zip(planks).enumerate() {
        scene.object(&format!("floor {i}"), boards, shade);
    }
    let (skirt, out) = ([0.0, 0.11], 0.014);
    let skirting = Mesh::joined(&[
        block([LEFT - 0.01, LEFT + out], skirt, [BACK, FRONT]),
        block([RIGHT - out, RIGHT + 0.01], skirt, [BACK, FRONT]),
        block([LEFT, DOOR_LEFT - 0.08], skirt, [BACK - 0.01, BACK + out]),
        block([DOOR_RIGHT + 0.08, RIGHT], skirt, [BACK - 0.01, BACK + out]),
    ]);
    scene.object("skirting", &skirting, white);
    uplighter(scene);
}

/// The only light: a disc that faces up, sunk in a black bowl just above the height of the door.
fn uplighter(scene: &mut Document) {
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.80, 0.55], 14000.0));
    let bowl = scene.material(Material::lambert("bowl", [0.05, 0.045, 0.04]));
    let (x, y, z) = (-1.45, DOOR_TOP + 0.12, -4.2);
    let rim: Vec<Vec3> = (0..24)
        .map(|i| {
            let (sin, cos) = (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
            Vec3::new(x + 0.20 * cos, y, z - 0.20 * sin)
        })
        .collect();
    let mut disc = Mesh::default();
    disc.polygon(&rim);
    scene.object("lamp", &disc, lamp);
    let shell = rod(&[[x, y - 0.09, z, 0.05], [x, y - 0.05, z, 0.17], [x, y - 0.003, z, 0.21]], 24);
    let stem = rod(&[[x, y - 0.003, z, 0.012], [x, FAR_CEILING + 0.02, z, 0.012]], 12);
    // Cameras do not see a lamp's back: its edge is closed down to the bowl.
    let mut edge = Mesh::default();
    for (i, &from) in rim.iter().enumerate() {
        let (to, down) = (rim[(i + 1) % rim.len()], Vec3::Y * 0.003);
        edge.polygon(&[from - down, to - down, to, from]);
    }
    scene.object("bowl", &Mesh::joined(&[shell, stem, edge]), bowl);
}

/// The frame, the door ajar in it, and its handles.
fn doorway(scene: &mut Document) {
    let white = scene.material(Material::lambert("door frame", [0.78, 0.74, 0.66]));
    let paint = scene.material(Material::lambert("door paint", [0.27, 0.42, 0.44]));
    let brass = scene.material(Material::metal("brass", [0.90, 0.72, 0.40], 0.35));
    let reveal = [BACK - WALL - 0.02, BACK + 0.005];
    let front = [BACK - 0.005, BACK + 0.02];
    let frame = Mesh::joined(&[
        block([DOOR_LEFT - 0.04, DOOR_LEFT], [-0.01, DOOR_TOP + 0.04], reveal),
        block([DOOR_RIGHT, DOOR_RIGHT + 0.04], [-0.01, DOOR_TOP + 0.04], reveal),
        block(
            [DOOR_LEFT - 0.01, DOOR_RIGHT + 0.01],
            [DOOR_TOP, DOOR_TOP + 0.04],
            [reveal[0] + 0.001, reveal[1] - 0.001],
        ),
        block([DOOR_LEFT - 0.09, DOOR_LEFT - 0.001], [-0.01, DOOR_TOP + 0.09], front),
        block([DOOR_RIGHT + 0.001, DOOR_RIGHT + 0.09], [-0.01, DOOR_TOP + 0.09], front),
        block(
            [DOOR_LEFT - 0.05, DOOR_RIGHT + 0.05],
            [DOOR_TOP + 0.001, DOOR_TOP + 0.089],
            [front[0], front[1] - 0.001],
        ),
    ]);
    scene.object("door frame", &frame, white);
    let (leaf, levers) = door(DOOR_RIGHT - DOOR_LEFT - 0.008, DOOR_TOP - 0.006);
    let swing = |mesh: Mesh| {
        let hinge = Vec3::new(DOOR_LEFT + 0.003, 0.0, BACK + 0.012);
        mesh.moved(Quat::from_rotation_y(-DOOR_DEG.to_radians()), hinge)
    };
    scene.object("door", &swing(leaf), paint);
    scene.object("door handles", &swing(levers), brass);
}

fn furnish(scene: &mut Document) {
    let oak = scene.material(Material::lambert("oak", [0.50, 0.29, 0.14]));
    let walnut = scene.material(Material::lambert("walnut", [0.26, 0.15, 0.085]));
    scene.object("table", &table(0.78, 0.42, TABLE_TOP).at(0.12, 0.0, -0.35), oak);

    let at_wall = |mesh: Mesh| mesh.at(0.42, 1.62, BACK);
    let (half_x, half_y) = (0.36, 0.25);
    scene.object("picture frame", &at_wall(picture_frame(half_x, half_y)), walnut);
    let colours = [[0.66, 0.66, 0.58], [0.85, 0.45, 0.15], [0.32, 0.42, 0.40], [0.16, 0.25, 0.20]];
    for (i, (part, rgb)) in picture(half_x, half_y).into_iter().zip(colours).enumerate() {
        let ink = scene.material(Material::lambert(&format!("picture {i}"), rgb));
        scene.object(&format!("picture {i}"), &at_wall(part), ink);
    }
    let (case, books) = bookcase(0.9, 1.75, 5, &mut Random(11));
    scene.object("bookcase", &case.at(RIGHT - 0.02, 0.0, BACK + 0.06), walnut);
    let bindings = [[0.45, 0.10, 0.07], [0.10, 0.20, 0.30], [0.62, 0.50, 0.28], [0.16, 0.28, 0.16], [0.62, 0.56, 0.47]];
    for (i, (mesh, rgb)) in books.into_iter().zip(bindings).enumerate() {
        let cloth = scene.material(Material::lambert(&format!("books {i}"), rgb));
        scene.object(&format!("books {i}"), &mesh.at(RIGHT - 0.02, 0.0, BACK + 0.06), cloth);
    }
}

/// Glass, metal and clay on the table.
fn lay_table(scene: &mut Document) {
    let glass = scene.material(Material::glass("glass", [1.0; 3], 1.5));
    let copper = scene.material(Material::metal("copper", [0.93, 0.58, 0.42], 0.3));
    let clay = scene.material(Material::lambert("glaze", [0.80, 0.73, 0.60]));
    let orange = scene.material(Material::lambert("orange", [0.85, 0.36, 0.05]));
    let board = scene.material(Material::lambert("board", [0.62, 0.44, 0.26]));
    let top = TABLE_TOP + 0.0005;

    let big = 1.5;
    let place = |mesh: Mesh| mesh.scaled(big).turned(-24.0).at(0.0, top, -0.22);
    scene.object("teapot", &place(crockery::teapot(0.0042)).closed(), glass);
    scene.object("teapot's hollow", &place(crockery::teapot_hollow()).closed(), glass);
    let jug = crockery::jug().scaled(1.2).turned(-150.0).at(0.45, top, -0.46);
    scene.object("jug", &jug, copper);
    let pot = crockery::pot().scaled(1.25).at(-0.40, top, -0.46);
    scene.object("pot", &pot, clay);
    let plate = rounded_box(Vec3::new(0.17, 0.009, 0.11), 0.005, 3).turned(14.0);
    scene.object("board", &plate.at(0.60, top + 0.009, -0.14), board);
    let fruit = |x: f32, z: f32| icosphere(3).scaled(0.042).at(x, top + 0.018 + 0.042, z);
    let fruits = Mesh::joined(&[fruit(0.535, -0.13), fruit(0.632, -0.17), fruit(0.605, -0.083)]);
    scene.object("oranges", &fruits, orange);
    let tumbler = crockery::tumbler().scaled(1.15).at(0.33, top, -0.04);
    scene.object("tumbler", &tumbler.closed(), glass);
}
