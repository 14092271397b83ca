//! A wall of rough-hewn stone, a height field of some fifty thousand triangles: courses of blocks, each set a little
//! differently, with ridged faces and sunk joints. Made for light that grazes it, as that of `sky.hdr` does; the file
//! itself has no lamp, so that without `--env` it gets a uniform sky, an overcast day.

use crate::crockery;
use crate::fittings::{bottle, bowl};
use crate::glb::{Document, Material};
use crate::implicit::surface;
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{block, ellipsoid};
use glam::{Vec2, Vec3};

const HALF_WIDTH: f32 = 1.75;
const HEIGHT: f32 = 2.15;
const SEAT: f32 = 0.44;

pub fn build() -> Document {
    let mut scene = Document::default();
    let stone = scene.material(Material::lambert("stone", [0.56, 0.48, 0.38]));
    let gravel = scene.material(Material::lambert("ground", [0.42, 0.35, 0.27]));
    let masonry = Masonry::new(&mut Random(17));
    // Below its edge the wall goes on behind the ground.
    let wall = field([204, 126], |u| {
        let p = Vec2::new(HALF_WIDTH * (2.0 * u.x - 1.0), HEIGHT * u.y - 0.02);
        Vec3::new(p.x, p.y, masonry.height(p))
    });
    scene.object("wall", &wall, stone);
    scene.object("core of the wall", &block([-HALF_WIDTH, HALF_WIDTH], [-0.05, HEIGHT - 0.03], [-0.5, -0.06]), stone);
    let ground = field([76, 46], |u| {
        let p = Vec2::new(2.6 * (2.0 * u.x - 1.0), 2.9 - 3.0 * u.y);
        let bumps = 0.014 * fbm(p.extend(7.0) * Vec3::new(14.0, 14.0, 1.0), 3) + 0.02 * noise(p.extend(3.0) * 2.2);
        Vec3::new(p.x, bumps, p.y)
    });
    scene.object("ground", &ground, gravel);
    bench(&mut scene);
    scene.camera("main", Vec3::new(0.50, 1.03, 2.62), Vec3::new(0.015, 0.72, 0.0), 40.0);
    scene
}

/// A grid of quads over the unit square, with normals from the surface itself; it faces du x dv.
fn field(cells: [u32; 2], place: impl Fn(Vec2) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let step = Vec2::new(1.0 / cells[0] as f32, 1.0 / cells[1] as f32);
    for j in 0..=cells[1] {
        for i in 0..=cells[0] {
            let u = Vec2::new(i as f32, j as f32) * step;
            // Over two cells, which is the slope that the triangles around have.
            let (dx, dy) = (Vec2::X * step.x, Vec2::Y * step.y);
            let normal = (place(u + dx) - place(u - dx)).cross(place(u + dy) - place(u - dy)).normalize();
            mesh.vertex(place(u), normal);
        }
    }
    let row = cells[0] + 1;
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let a = j * row + i;
            let [b, c, d] = [a + 1, a + row + 1, a + row];
            let corner = |k: u32| mesh.positions[k as usize];
            // Along the shorter diagonal.
            if corner(a).distance(corner(c)) <= corner(b).distance(corner(d)) {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    mesh
}

/// Courses of blocks.
struct Masonry {
    courses: Vec<(f32, Vec<Block>)>,
}

/// A block from `start` to the next one's, standing out by `out`, leaning by `lean`.
struct Block {
    start: f32,
    out: f32,
    lean: Vec2,
    seed: f32,
}

impl Masonry {
    fn new(random: &mut Random) -> Self {
        let mut courses = Vec::new();
        let mut y = -0.15;
        while y < HEIGHT + 0.1 {
            let mut blocks = Vec::new();
            let mut x = -HALF_WIDTH - random.between(0.1, 0.6);
            while x < HALF_WIDTH + 0.1 {
                blocks.push(Block {
                    start: x,
                    out: random.between(-0.012, 0.022),
                    lean: Vec2::new(random.between(-0.07, 0.07), random.between(-0.06, 0.06)),
                    seed: random.between(0.0, 90.0),
                });
                x += random.between(0.26, 0.62);
            }
            courses.push((y, blocks));
            y += random.between(0.19, 0.31);
        }
        Self { courses }
    }

    /// How far the face of the wall stands out at `p`.
    fn height(&self, p: Vec2) -> f32 {
        // Joints are not straight.
        let q = p + 0.012 * Vec2::new(noise(p.extend(1.5) * 6.0), noise(p.extend(8.5) * 6.0));
        let course = self.courses.partition_point(|(y, _)| *y <= q.y).max(1) - 1;
        let (low, blocks) = &self.courses[course];
        let high = self.courses.get(course + 1).map_or(low + 1.0, |(y, _)| *y);
        let at = blocks.partition_point(|b| b.start <= q.x).max(1) - 1;
        let stone = &blocks[at];
        let end = blocks.get(at + 1).map_or(stone.start + 1.0, |b| b.start);
        let size = Vec2::new(end - stone.start, high - low);
        let local = q - Vec2::new(stone.start, *low);
        // Distance to the joint, rounded at the corners.
        let edge = local.min(size - local);
        let round = 0.05;
        let inside = (Vec2::splat(round) - edge).max(Vec2::ZERO).length();
        let depth = (round - inside).min(edge.min_element());
        let rise = smooth((depth - 0.008) / 0.036);
        let boss = 0.030 * smooth(depth / (0.45 * size.min_element()));
        let coarse = ridged(Vec3::new(7.0 * p.x, 9.0 * p.y, stone.seed), 4);
        let chips = fbm(Vec3::new(26.0 * p.x, 30.0 * p.y, stone.seed + 3.0), 2);
        let face = 0.040 + stone.out + stone.lean.dot(local - 0.5 * size) + boss + 0.042 * coarse + 0.007 * chips;
        let mortar = 0.006 * fbm(p.extend(4.0) * Vec3::new(30.0, 30.0, 1.0), 2);
        mortar + rise * (face - mortar)
    }
}

fn smooth(x: f32) -> f32 {
    let t = x.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Perlin's noise of 1985 with his quintic of 2002, in about [-1, 1].
fn noise(p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |x: f32, y: f32, z: f32| {
        let d = Vec3::new(x, y, z);
        let [i, j, k] = (cell + d).to_array().map(|v| (v as i64 as u64) & 0xffff);
        Random(i | j << 16 | k << 32).direction().dot(f - d)
    };
    let along = |y: f32, z: f32| corner(0.0, y, z) + w.x * (corner(1.0, y, z) - corner(0.0, y, z));
    let across = |z: f32| along(0.0, z) + w.y * (along(1.0, z) - along(0.0, z));
    1.5 * (across(0.0) + w.z * (across(1.0) - across(0.0)))
}

fn fbm(p: Vec3, octaves: u32) -> f32 {
    (0..octaves).map(|o| 0.5f32.powi(o as i32) * noise(p * 2f32.powi(o as i32) + 17.0 * o as f32)).sum()
}

/// Sharp crests, as where stone splits: in about [0, 1].
fn ridged(p: Vec3, octaves: u32) -> f32 {
    let octave = |o: u32| 0.5f32.powi(o as i32 + 1) * (1.0 - noise(p * 2f32.powi(o as i32) + 31.0 * o as f32).abs());
    (0..octaves).map(octave).sum()
}

/// A stone seat before the wall, and what was left on it.
fn bench(scene: &mut Document) {
    let seat = scene.material(Material::lambert("seat", [0.60, 0.54, 0.45]));
    let clay = scene.material(Material::glossy("clay", [0.52, 0.21, 0.10], 0.5));
    let green = scene.material(Material::glass("green glass", [0.55, 0.86, 0.66], 1.5));
    let copper = scene.material(Material::metal("copper", [0.93, 0.58, 0.42], 0.3));
    let lemon = scene.material(Material::glossy("lemon", [0.80, 0.55, 0.06], 0.45));
    // Flat on top, where things stand, and hewn elsewhere.
    let hewn = |middle: Vec3, half: Vec3, flat_top: bool| {
        let distance = move |p: Vec3| {
            let q = (p - middle).abs() - half + 0.014;
            let solid = q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - 0.014;
            let rough = 0.009 * fbm(p * 19.0, 3);
            if flat_top { (solid + rough).max(p.y - SEAT) } else { solid + rough }
        };
        surface(middle - half - 0.04, middle + half + 0.04, 0.021, distance)
    };
    let z = 0.38;
    let slab = hewn(Vec3::new(0.0, SEAT - 0.042, z), Vec3::new(0.92, 0.048, 0.21), true);
    let leg = |x: f32| hewn(Vec3::new(x, 0.17, z - 0.01), Vec3::new(0.10, 0.20, 0.15), false);
    scene.object("seat", &Mesh::joined(&[slab, leg(-0.62), leg(0.62)]), seat);
    let top = SEAT + 0.0005;
    scene.object("jug", &crockery::jug().scaled(1.5).turned(-160.0).at(-0.42, top, 0.36), clay);
    scene.object("bottle", &bottle(0.085, 0.41, 0.024).at(-0.02, top, 0.35).closed(), green);
    scene.object("bowl", &bowl().at(0.40, top, 0.40), copper);
    let fruit = |x: f32, y: f32, z: f32, turn: f32| {
        ellipsoid(Vec3::new(0.042, 0.033, 0.033), 3).turned(turn).at(0.40 + x, SEAT + y, 0.40 + z)
    };
    let lemons = [fruit(-0.045, 0.062, 0.03, 20.0), fruit(0.05, 0.062, 0.02, 110.0), fruit(0.0, 0.064, -0.05, -30.0)];
    scene.object("lemons", &Mesh::joined(&lemons), lemon);
}
