//! A basin of water under a lamp of four millimetres: the net of light on the tiles is seen through the waves that
//! made it. No path tracer finds that light within minutes: only hitting the lamp by chance would do.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{block, icosphere, quad};
use glam::{Vec2, Vec3};

const HALF_X: f32 = 0.80;
const HALF_Z: f32 = 0.60;
/// Tiles at y = 0, still water at DEPTH, the basin's edge at RIM.
const DEPTH: f32 = 0.36;
const RIM: f32 = 0.46;
const WALL: f32 = 0.14;
const TILE: f32 = 0.16;

/// With a square lamp of the given side, always of the same power: a wide one makes nearly the same picture, and a path
/// tracer can make a reference of it.
pub fn build(lamp_side: f32) -> Document {
    let mut scene = Document::default();
    let grout = scene.material(Material::lambert("grout", [0.62, 0.62, 0.58]));
    let stone = scene.material(Material::lambert("stone", [0.58, 0.50, 0.42]));
    let water = scene.material(Material::glass("water", [0.94, 0.985, 1.0], 1.33));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.90, 0.74], 5.44 / (lamp_side * lamp_side)));
    let glazes = [[0.16, 0.48, 0.60], [0.30, 0.62, 0.66], [0.10, 0.34, 0.52], [0.80, 0.52, 0.16]]
        .map(|rgb| scene.material(Material::lambert("glaze", rgb)));

    // The water reaches into walls and floor, which are opaque: so they are wet, with no air between that would
    // mirror. Its own sides and bottom are never seen.
    let (x, z) = (HALF_X + WALL, HALF_Z + WALL);
    let basin = Mesh::joined(&[
        block([-x, x], [-0.1, -0.001], [-z, z]),
        block([-x, -HALF_X], [-0.05, RIM], [-z, z]),
        block([HALF_X, x], [-0.05, RIM], [-z, z]),
        block([-HALF_X - 0.01, HALF_X + 0.01], [-0.05, RIM - 0.0005], [-z, -HALF_Z]),
        block([-HALF_X - 0.01, HALF_X + 0.01], [-0.05, RIM - 0.0005], [HALF_Z, z]),
    ]);
    scene.object("basin", &basin, stone);
    scene.object("grout", &quad(Vec3::new(-x, -0.0005, -z), Vec3::Z * 2.0 * z, Vec3::X * 2.0 * x), grout);
    let mut random = Random(9);
    let mut floor: [Mesh; 4] = Default::default();
    for row in 0..(2.0 * HALF_Z / TILE).ceil() as u32 {
        for column in 0..(2.0 * HALF_X / TILE).round() as u32 {
            let (x, z) = (TILE * column as f32 - HALF_X, TILE * row as f32 - HALF_Z);
            let side = TILE - 0.008;
            let corner = Vec3::new(x + 0.004, 0.0, z + 0.004);
            let depth = side.min(HALF_Z - corner.z);
            let glaze = if random.unit() < 0.12 { 3 } else { (random.unit() * 3.0) as usize };
            floor[glaze].append(&quad(corner, Vec3::Z * depth, Vec3::X * side));
        }
    }
    for (i, (tiles, glaze)) in floor.iter().zip(glazes).enumerate() {
        scene.object(&format!("tiles {i}"), tiles, glaze);
    }
    let (ground, red) = (
        scene.material(Material::lambert("ground", [0.34, 0.40, 0.24])),
        scene.material(Material::lambert("red", [0.74, 0.14, 0.10])),
    );
    scene.object("ground", &quad(Vec3::new(-3.0, -0.02, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0), ground);
    // One ball under water, one on the edge.
    scene.object("sunken ball", &icosphere(3).scaled(0.11).at(0.30, 0.1105, -0.14), red);
    scene.object("ball", &icosphere(3).scaled(0.075).at(-0.66, RIM + 0.075, -HALF_Z - 0.07), glazes[3]);
    scene.object("water", &waves(96, 72).closed(), water);

    // On the camera's side, so that no wave mirrors it into the camera: a glint would be one pixel brighter than all.
    let half = 0.5 * lamp_side;
    let square = quad(Vec3::new(-half, 0.0, -half), Vec3::X * 2.0 * half, Vec3::Z * 2.0 * half);
    scene.object("lamp", &square.at(-0.35, 1.55, 0.55), lamp);
    scene.camera("main", Vec3::new(0.24, 1.62, 1.30), Vec3::new(0.0, 0.16, -0.04), 40.0);
    scene
}

/// A closed body of water with a wavy top: columns x rows cells, normals of the waves themselves.
fn waves(columns: u32, rows: u32) -> Mesh {
    // Wave vectors (radians a metre), amplitudes and phases. Curved so that the crests focus near the floor
    // (curvature n / ((n - 1) depth), about 11 a metre), and none so steep that a glint could reach the camera.
    let mut random = Random(31);
    let trains: Vec<(Vec2, f32, f32)> = (0..9)
        .map(|i| {
            let length = 0.42 - 0.03 * i as f32;
            let angle = 2.4 * i as f32 + random.between(-0.4, 0.4);
            let k = std::f32::consts::TAU / length * Vec2::from_angle(angle);
            (k, 0.0085 * length, random.between(0.0, std::f32::consts::TAU))
        })
        .collect();
    let height = |p: Vec2| DEPTH + trains.iter().map(|(k, a, phase)| a * (k.dot(p) + phase).sin()).sum::<f32>();
    let slope = |p: Vec2| trains.iter().map(|(k, a, phase)| *k * (a * (k.dot(p) + phase).cos())).sum::<Vec2>();

    let (x, z) = (HALF_X + 0.02, HALF_Z + 0.02);
    let bottom = -0.02;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let p = Vec2::new(x, z) * (2.0 * Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32) - 1.0);
            let g = slope(p);
            mesh.vertex(Vec3::new(p.x, height(p), p.y), Vec3::new(-g.x, 1.0, -g.y).normalize());
        }
    }
    let at = |column: u32, row: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b, c, d] = [at(column, row), at(column, row + 1), at(column + 1, row + 1), at(column + 1, row)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    // Around the edge, counter-clockwise from above; below every piece of it a side and a slice of the bottom.
    let mut edge: Vec<u32> = (0..rows).map(|r| at(0, r)).collect();
    edge.extend((0..columns).map(|c| at(c, rows)));
    edge.extend((1..=rows).rev().map(|r| at(columns, r)));
    edge.extend((1..=columns).rev().map(|c| at(c, 0)));
    let top = mesh.positions.clone();
    let under = |i: u32| Vec3::new(top[i as usize].x, bottom, top[i as usize].z);
    for (k, &i) in edge.iter().enumerate() {
        let j = edge[(k + 1) % edge.len()];
        mesh.polygon(&[top[i as usize], under(i), under(j), top[j as usize]]);
        mesh.polygon(&[under(i), Vec3::new(0.0, bottom, 0.0), under(j)]);
    }
    mesh
}
