//! Splinters of glass on a pale ground under one small bright lamp: caustics, and little else.

use crate::glb::{Document, Material};
use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{hull_triangles, quad};
use glam::{Quat, Vec2, Vec3};

pub fn build() -> Document {
    let mut scene = Document::default();
    let ground = scene.material(Material::lambert("ground", [0.62, 0.6, 0.57]));
    let tints = [
        ("clear", [1.0, 1.0, 1.0]),
        ("amber", [1.0, 0.87, 0.62]),
        ("sea", [0.68, 0.93, 0.95]),
        ("rose", [1.0, 0.76, 0.78]),
    ]
    .map(|(name, tint)| scene.material(Material::glass(name, tint, 1.5)));
    let lamp = scene.material(Material::lamp("lamp", [1.0, 0.93, 0.82], 60.0));
    let panel = scene.material(Material::lamp("soft panel", [0.55, 0.75, 1.0], 0.5));

    scene.object("ground", &backdrop(), ground);
    let half = 0.22;
    let square = quad(Vec3::new(-half, 0.0, -half), Vec3::X * 2.0 * half, Vec3::Z * 2.0 * half);
    let tilt = Quat::from_rotation_x(0.35) * Quat::from_rotation_z(0.3);
    scene.object("lamp", &square.moved(tilt, Vec3::new(-0.9, 3.0, -0.9)), lamp);
    // A dim panel out of view that only gives the facets something to reflect.
    let side = quad(Vec3::new(3.4, 0.3, 1.6), Vec3::Y * 2.0, Vec3::new(-0.6, 0.0, 2.6));
    scene.object("soft panel", &side, panel);

    let mut random = Random(20);
    let mut count = 0;
    // Standing splinters on a loose spiral: the golden angle keeps them apart.
    for i in 0..13 {
        let r = 0.30 + 0.062 * i as f32;
        let angle = 2.399_963 * i as f32 + random.between(-0.2, 0.2);
        let spot = Vec2::from_angle(angle) * r * Vec2::new(1.25, 0.8);
        let height = random.between(0.3, 0.78) * (1.15 - 0.5 * r);
        let shard = splinter(&mut random, height, 0.13 * height.sqrt());
        let lean = Quat::from_axis_angle(
            Vec3::new(random.between(-1.0, 1.0), 0.0, random.between(-1.0, 1.0)).normalize(),
            random.between(0.05, 0.32),
        );
        let placed = rest(shard.moved(lean, Vec3::ZERO)).at(spot.x, 0.0, spot.y);
        count += 1;
        scene.object(&format!("shard {count}"), &placed.closed(), tints[[0, 1, 2, 0, 3, 0, 2][i % 7]]);
    }
    // Splinters in the air, turning.
    for i in 0..8 {
        let shard = splinter(&mut random, 0.3, 0.07);
        let turn = Quat::from_rotation_arc(Vec3::Y, random.direction());
        let angle = i as f32 * 0.785 + 0.3;
        let place = Vec3::new(0.95 * angle.cos(), random.between(0.75, 1.15), 0.55 * angle.sin());
        count += 1;
        let mesh = shard.at(0.0, -0.15, 0.0).moved(turn, place);
        scene.object(&format!("shard {count}"), &mesh.closed(), tints[[0, 2, 1, 0, 3, 1, 0, 2][i]]);
    }
    scene.camera("main", Vec3::new(0.15, 1.35, 3.7), Vec3::new(0.0, 0.42, 0.0), 32.0);
    scene
}

/// A splinter along +y from the origin: the hull of a few slanted polygons and two tips, all facets flat.
fn splinter(random: &mut Random, height: f32, radius: f32) -> Mesh {
    let sides = 5;
    let flat = random.between(0.55, 1.0);
    let phase = random.between(0.0, std::f32::consts::TAU);
    let mut points = vec![
        Vec3::new(random.between(-0.4, 0.4) * radius, 0.0, random.between(-0.4, 0.4) * radius),
        Vec3::new(random.between(-0.5, 0.5) * radius, height, random.between(-0.5, 0.5) * radius),
    ];
    for (level, width) in [(0.08, 0.72), (0.62, 1.0)] {
        for s in 0..sides {
            let angle = phase + (s as f32 + random.between(-0.3, 0.3)) / sides as f32 * std::f32::consts::TAU;
            let r = radius * width * random.between(0.85, 1.1);
            let y = height * (level + random.between(-0.07, 0.12));
            points.push(Vec3::new(r * angle.cos(), y, flat * r * angle.sin()));
        }
    }
    let triangles = hull_triangles(&points);
    Mesh { normals: vec![Vec3::Y; points.len()], positions: points, triangles }.faceted()
}

/// Set down so that the lowest point is just above the ground.
fn rest(mesh: Mesh) -> Mesh {
    let lowest = mesh.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    mesh.at(0.0, 0.001 - lowest, 0.0)
}

/// A ground that bends up into a wall behind, as photographers use, smooth in the bend.
fn backdrop() -> Mesh {
    let (half_width, front, back, bend, top) = (9.0, 9.0, -3.2, 1.5, 6.0);
    let steps = 24;
    let mut section = vec![(Vec2::new(front, 0.0), Vec2::new(0.0, 1.0))];
    for k in 0..=steps {
        let angle = k as f32 / steps as f32 * std::f32::consts::FRAC_PI_2;
        let normal = Vec2::new(angle.sin(), angle.cos());
        section.push((Vec2::new(back + bend, bend) - bend * normal, normal));
    }
    section.push((Vec2::new(back, top), Vec2::new(1.0, 0.0)));
    let mut mesh = Mesh::default();
    for &(p, n) in &section {
        for x in [-half_width, half_width] {
            mesh.vertex(Vec3::new(x, p.y, p.x), Vec3::new(0.0, n.y, n.x));
        }
    }
    for i in 0..section.len() as u32 - 1 {
        let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}
