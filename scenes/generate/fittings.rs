//! What kitchens and bathrooms have: tiles, taps, handles, vessels.

use crate::mesh::Mesh;
use crate::random::Random;
use crate::shapes::{Profile, ellipsoid, lathe, rod, rounded_box, smooth_profile, spline};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// What is left over at a border and narrower than this gets no tile: its bevels would cross.
const SMALLEST: f32 = 0.012;

/// Tiles with bevelled edges, each set a little askew, over the parallelogram of `u` and `v` from `corner`; it faces
/// `u x v`. Rows run along `u`; `shift` of a tile moves every other row. What lies between them is left open.
pub struct Tiling {
    pub size: Vec2,
    pub gap: f32,
    pub shift: f32,
    pub askew: f32,
}

impl Tiling {
    /// The tiles, dealt out to as many meshes as there are glazes.
    pub fn lay<const N: usize>(&self, corner: Vec3, u: Vec3, v: Vec3, random: &mut Random) -> [Mesh; N] {
        let (along, up) = (u.normalize(), v.normalize());
        let out = along.cross(up);
        let (length, height) = (u.length(), v.length());
        let mut meshes: [Mesh; N] = std::array::from_fn(|_| Mesh::default());
        for row in 0..(height / self.size.y).ceil() as u32 {
            let low = row as f32 * self.size.y;
            let high = (low + self.size.y).min(height);
            let mut start = if row % 2 == 1 { self.shift * self.size.x - self.size.x } else { 0.0 };
            while start < length - SMALLEST {
                let end = (start + self.size.x).min(length);
                let glaze = (random.unit() * N as f32) as usize;
                let lean = Vec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) * self.askew;
                if end > SMALLEST && high - low > SMALLEST {
                    let half_gap = Vec2::splat(0.5 * self.gap);
                    let (a, b) = (Vec2::new(start.max(0.0), low) + half_gap, Vec2::new(end, high) - half_gap);
                    let middle = 0.5 * (a + b);
                    let at = |p: Vec2, lift: f32| {
                        let lift = lift + lean.dot(p - middle);
                        corner + p.x * along + p.y * up + lift * out
                    };
                    tile(&mut meshes[glaze], a, b, at);
                }
                start = end;
            }
        }
        meshes
    }
}

/// A raised face with four sloping edges.
fn tile(mesh: &mut Mesh, a: Vec2, b: Vec2, at: impl Fn(Vec2, f32) -> Vec3) {
    let bevel = 0.003;
    let corners = |inset: f32, lift: f32| {
        let (a, b) = (a + Vec2::splat(inset), b - Vec2::splat(inset));
        [a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)].map(|p| at(p, lift))
    };
    let (foot, face) = (corners(0.0, -0.002), corners(bevel, 0.003));
    mesh.polygon(&face);
    for i in 0..4 {
        let j = (i + 1) % 4;
        mesh.polygon(&[foot[i], foot[j], face[j], face[i]]);
    }
}

/// A swan-necked tap that stands on y = 0 and pours towards +z, with a lever at its right.
pub fn tap(height: f32, reach: f32) -> Mesh {
    let r = 0.011;
    let bend = 0.5 * reach;
    let neck = spline(
        &[
            [0.0, 0.03, 0.0, r],
            [0.0, 0.5 * height, 0.0, r],
            [0.0, height - bend, 0.0, r],
            [0.0, height - 0.30 * bend, 0.29 * bend, r],
            [0.0, height, bend, r],
            [0.0, height - 0.30 * bend, 1.71 * bend, r],
            [0.0, height - bend, reach, r],
            [0.0, height - bend - 0.03, reach, r],
        ],
        8,
    );
    let foot = rod(&[[0.0, -0.002, 0.0, 0.027], [0.0, 0.008, 0.0, 0.026]], 32);
    let body = rod(&[[0.0, 0.0, 0.0, 0.019], [0.0, 0.06, 0.0, 0.018]], 32);
    let shaft = rod(&[[0.0, 0.038, 0.0, 0.011], [0.045, 0.038, 0.0, 0.011]], 20);
    let lever = rod(&[[0.040, 0.038, 0.0, 0.006], [0.052, 0.105, 0.012, 0.0045]], 16);
    let mouth = rod(&[[0.0, height - bend - 0.045, reach, 0.014], [0.0, height - bend - 0.02, reach, 0.014]], 24);
    Mesh::joined(&[rod(&neck, 24), foot, body, shaft, lever, mouth])
}

/// A bar handle of a door in the plane z = 0: lying along x, or standing where `standing`.
pub fn bar_handle(length: f32, standing: bool) -> Mesh {
    let half = 0.5 * length;
    let end = |t: f32, z: f32, r: f32| if standing { [0.0, t, z, r] } else { [t, 0.0, z, r] };
    let bar = rod(&[end(-half, 0.032, 0.006), end(half, 0.032, 0.006)], 16);
    let post = |t: f32| rod(&[end(t, -0.002, 0.005), end(t, 0.032, 0.005)], 12);
    Mesh::joined(&[bar, post(-0.8 * half), post(0.8 * half)])
}

/// A turned vessel from its outline; the outline runs along the outside up and comes back inside.
fn turned(outline: &[[f32; 2]], segments: u32) -> Mesh {
    lathe(&smooth_profile(outline, 3), segments)
}

/// A wide bowl of 26 cm.
pub fn bowl() -> Mesh {
    let outside = [[0.0, 0.0], [0.044, 0.0], [0.050, 0.006], [0.085, 0.028], [0.118, 0.070], [0.131, 0.108]];
    let inside = [[0.1285, 0.111], [0.125, 0.108], [0.110, 0.070], [0.078, 0.034], [0.040, 0.016], [0.0, 0.012]];
    turned(&[&outside[..], &inside[..]].concat(), 56)
}

/// A wash basin of 44 cm that stands on a board: a thick round dish.
pub fn basin() -> Mesh {
    let outside = [[0.0, 0.0], [0.120, 0.0], [0.135, 0.008], [0.178, 0.050], [0.207, 0.100], [0.218, 0.140]];
    let inside = [[0.213, 0.147], [0.206, 0.142], [0.192, 0.100], [0.155, 0.050], [0.085, 0.022], [0.0, 0.015]];
    turned(&[&outside[..], &inside[..]].concat(), 96)
}

/// A wine glass of 21 cm, one closed skin.
pub fn wine_glass() -> Mesh {
    let outside = [
        [0.0, 0.0],
        [0.030, 0.0],
        [0.036, 0.0025],
        [0.022, 0.007],
        [0.0065, 0.016],
        [0.0042, 0.050],
        [0.0060, 0.088],
        [0.024, 0.105],
        [0.0405, 0.138],
        [0.0385, 0.175],
        [0.0322, 0.210],
    ];
    let inside = [[0.0314, 0.2115], [0.0306, 0.210], [0.0368, 0.175], [0.0386, 0.138], [0.022, 0.108], [0.0, 0.099]];
    turned(&[&outside[..], &inside[..]].concat(), 44)
}

/// A bottle with straight sides and a rounded shoulder, `height` tall, of wall 3 mm and open at the mouth: one closed
/// skin.
pub fn bottle(radius: f32, height: f32, neck: f32) -> Mesh {
    let (r, h, n) = (radius, height, neck);
    let shoulder = 0.62 * h;
    let outside = [
        [0.0, 0.0],
        [r - 0.006, 0.0],
        [r, 0.006],
        [r, 0.3 * h],
        [r, shoulder],
        [0.80 * r + 0.2 * n, shoulder + 0.10 * h],
        [n + 0.001, 0.82 * h],
        [n, 0.90 * h],
        [n, 0.975 * h],
        [n + 0.002, 0.983 * h],
        [n + 0.002, 0.995 * h],
    ];
    let (r, n) = (r - 0.003, n - 0.003);
    let inside = [
        [n + 0.002, h],
        [n, 0.99 * h],
        [n, 0.90 * h],
        [n + 0.001, 0.82 * h],
        [0.80 * r + 0.2 * n, shoulder + 0.09 * h],
        [r, shoulder - 0.01 * h],
        [r, 0.3 * h],
        [r - 0.001, 0.018],
        [r - 0.010, 0.010],
        [0.0, 0.009],
    ];
    turned(&[&outside[..], &inside[..]].concat(), 44)
}

/// A cooking pot with two handles, then its lid with a knob: `radius` wide, `height` tall without the lid.
pub fn cooking_pot(radius: f32, height: f32) -> Mesh {
    let (r, h) = (radius, height);
    let level = Vec2::new(0.0, -1.0);
    let side = Vec2::new(1.0, 0.0);
    let mut profile: Profile = vec![(Vec2::ZERO, level), (Vec2::new(r - 0.012, 0.0), level)];
    profile.push((Vec2::new(r - 0.0035, 0.0035), Vec2::new(1.0, -1.0).normalize()));
    profile.push((Vec2::new(r, 0.012), side));
    profile.push((Vec2::new(r, h - 0.002), side));
    profile.push((Vec2::new(r + 0.004, h), Vec2::new(1.0, 1.0).normalize()));
    // The lid: a shallow dome over the rim.
    for i in 0..=10 {
        let (sin, cos) = (i as f32 / 40.0 * TAU).sin_cos();
        let normal = Vec2::new(cos / (r + 0.002), sin / 0.028).normalize();
        profile.push((Vec2::new((r + 0.002) * cos.max(0.0), h + 0.003 + 0.028 * sin), normal));
    }
    let last = profile.len() - 1;
    profile[last] = (Vec2::new(0.0, h + 0.031), Vec2::Y);
    let pot = lathe(&profile, 72);
    let knob_foot = rod(&[[0.0, h + 0.025, 0.0, 0.008], [0.0, h + 0.045, 0.0, 0.006]], 20);
    let knob = ellipsoid(Vec3::new(0.019, 0.010, 0.019), 3).at(0.0, h + 0.052, 0.0);
    let grip = |s: f32| {
        let y = 0.78 * h;
        let path = [
            [s * (r - 0.004), y, -0.045, 0.0055],
            [s * (r + 0.030), y + 0.004, -0.042, 0.0055],
            [s * (r + 0.042), y + 0.006, 0.0, 0.0055],
            [s * (r + 0.030), y + 0.004, 0.042, 0.0055],
            [s * (r - 0.004), y, 0.045, 0.0055],
        ];
        rod(&spline(&path, 6), 14)
    };
    Mesh::joined(&[pot, knob_foot, knob, grip(1.0), grip(-1.0)])
}

/// An open saucepan with a long handle to +x.
pub fn saucepan(radius: f32, height: f32) -> Mesh {
    let (r, h) = (radius, height);
    let outline = [
        [0.0, 0.0],
        [r - 0.010, 0.0],
        [r - 0.002, 0.006],
        [r, 0.5 * h],
        [r + 0.001, h],
        [r - 0.001, h + 0.0015],
        [r - 0.003, h],
        [r - 0.003, 0.5 * h],
        [r - 0.006, 0.010],
        [r - 0.016, 0.005],
        [0.0, 0.004],
    ];
    let grip = [[r - 0.002, 0.75 * h, 0.0, 0.007], [r + 0.07, 0.86 * h, 0.0, 0.0075], [r + 0.19, 1.0 * h, 0.0, 0.010]];
    Mesh::joined(&[turned(&outline, 56), rod(&spline(&grip, 6), 16)])
}

/// A flat front of a cupboard or drawer in the plane z = 0, from `low` to `high`, with soft edges and a seam of 4 mm
/// around it.
pub fn front(low: Vec2, high: Vec2) -> Mesh {
    let half = 0.5 * (high - low) - Vec2::splat(0.002);
    let middle = 0.5 * (low + high);
    rounded_box(Vec3::new(half.x, half.y, 0.010), 0.003, 2).at(middle.x, middle.y, 0.0)
}
