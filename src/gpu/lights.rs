//! The lights as shaders/light/*.wesl read them: an alias table over all of them, and what each is.

use glam::Vec3;

use super::layout::{NO_TRIANGLE, PUNCTUAL};
use crate::scene::light::{Environment, LightKind};
use crate::scene::{LUMINANCE, Scene};

/// Rows before the alias table where there are lights of several kinds: the weight of the sky; where the other rows are.
pub const HEADER_ROWS: usize = 2;

/// Selection weight (area * sides * luminance) and leaf position of every emissive triangle.
pub fn emitters(scene: &Scene, order: &[u32], corners: &[[Vec3; 3]], emission: &[f64]) -> (Vec<f64>, Vec<u32>) {
    let mut weights = Vec::new();
    let mut emitters = Vec::new();
    for (leaf, &source) in order.iter().enumerate() {
        let material = &scene.materials[scene.triangle_materials[source as usize] as usize];
        // As the device knows it, so that the density it states is the one it samples.
        let luminance = emission[source as usize] as f32;
        if luminance > 0.0 {
            let [a, b, c] = corners[source as usize];
            let area = 0.5 * f64::from((b - a).cross(c - a).length());
            let sides = if material.emits_on_both_sides() { 2.0 } else { 1.0 };
            weights.push(area * sides * f64::from(luminance));
            emitters.push(leaf as u32);
        }
    }
    (weights, emitters)
}

/// Rows (threshold, own triangle, other triangle, 0) of an alias table (Walker 1977; Vose 1991).
pub fn alias_table(weights: &[f64], emitters: &[u32]) -> Vec<[u32; 4]> {
    let n = weights.len();
    let total: f64 = weights.iter().sum();
    let mut share: Vec<f64> = weights.iter().map(|w| w * n as f64 / total).collect();
    let mut rows: Vec<[u32; 4]> = emitters.iter().map(|&e| [1f32.to_bits(), e, e, 0]).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| share[i] < 1.0);
    while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
        rows[s] = [(share[s] as f32).to_bits(), emitters[s], emitters[l], 0];
        share[l] -= 1.0 - share[s];
        if share[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    rows
}

/// Lights that are no triangles: their weights, which are powers over pi in units of the bounding sphere's radius, and
/// their rows.
pub struct Others {
    /// Weight and code of each.
    weights: Vec<(f32, u32)>,
    sky: f32,
    environment: Option<(u32, u32)>,
    punctual: usize,
    pub rows: Vec<[u32; 4]>,
}

/// What is not a triangle, of a scene that lies in a sphere of `radius`.
pub fn others(scene: &Scene, radius: f32) -> Others {
    let mut rows = Vec::new();
    let mut weights = Vec::new();
    let centre = scene.bounding_sphere().0;
    let place = |p: Vec3| ((p.as_dvec3() - centre.as_dvec3()) / f64::from(radius)).as_vec3();
    for (i, light) in scene.lights.iter().enumerate() {
        let near = light.intensity / (radius * radius);
        let (at, kind, intensity, axis, outer, slope, share) = match light.kind {
            LightKind::Point { position } => (place(position), 0.0, near, Vec3::ZERO, 0.0, 0.0, 4.0),
            LightKind::Spot { position, direction, inner_cosine, outer_cosine } => {
                let slope = 1.0 / (inner_cosine - outer_cosine).max(1e-6);
                (place(position), 1.0, near, direction, outer_cosine, slope, 2.0 * (1.0 - outer_cosine))
            }
            LightKind::Directional { direction } => (direction, 2.0, light.intensity, Vec3::ZERO, 0.0, 0.0, 1.0),
        };
        let weight = share * intensity.as_dvec3().dot(LUMINANCE) as f32;
        weights.push((weight, PUNCTUAL + i as u32));
        rows.extend(
            [
                [at.x, at.y, at.z, kind],
                [intensity.x, intensity.y, intensity.z, weight],
                [axis.x, axis.y, axis.z, outer],
                [slope, 0.0, 0.0, 0.0],
            ]
            .map(|row| row.map(f32::to_bits)),
        );
    }
    let mut sky = 0.0;
    if let Some(environment) = &scene.environment {
        let pixel_weights = environment.weights();
        let total: f64 = pixel_weights.iter().sum();
        rows.extend(environment_rows(environment, &pixel_weights, total));
        sky = total as f32;
        weights.push((sky, NO_TRIANGLE));
    }
    let environment = scene.environment.as_ref().map(|e| (e.width, e.height));
    Others { weights, sky, environment, punctual: scene.lights.len(), rows }
}

impl Others {
    /// Adds them to the lights that the alias table chooses from.
    pub fn add_to(&self, weights: &mut Vec<f64>, codes: &mut Vec<u32>) {
        // A scene of one kind of light has none of these.
        weights.extend(self.weights.iter().map(|(weight, _)| f64::from(*weight)));
        codes.extend(self.weights.iter().map(|(_, code)| code));
    }

    /// The rows before the alias table, where these lights' rows begin at `first`.
    pub fn header(&self, first: usize) -> [[u32; 4]; HEADER_ROWS] {
        let (width, height) = self.environment.unwrap_or((0, 0));
        [[self.sky.to_bits(), 0, 0, 0], [first as u32, (first + 4 * self.punctual) as u32, width, height]]
    }
}

/// Two rows a pixel: radiance and the density per solid angle; alias threshold and the other pixel.
fn environment_rows(environment: &Environment, weights: &[f64], total: f64) -> Vec<[u32; 4]> {
    let pixels: Vec<u32> = (0..weights.len() as u32).collect();
    let aliases = alias_table(weights, &pixels);
    let mut rows = Vec::with_capacity(2 * weights.len());
    for (i, (pixel, alias)) in environment.pixels.iter().zip(aliases).enumerate() {
        let density = weights[i] / total / environment.solid_angle(i as u32 / environment.width);
        rows.push([pixel[0], pixel[1], pixel[2], density as f32].map(f32::to_bits));
        rows.push([alias[0], alias[2], 0, 0]);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alias_table_gives_the_weights_back() {
        let weights = [3.0, 0.5, 0.25, 7.0, 1.25];
        let emitters = [10, 11, 12, 13, 14];
        let mut mass = [0.0f64; 5];
        for row in alias_table(&weights, &emitters) {
            let keep = f64::from(f32::from_bits(row[0]));
            mass[row[1] as usize - 10] += keep / 5.0;
            mass[row[2] as usize - 10] += (1.0 - keep) / 5.0;
        }
        for (m, w) in mass.iter().zip(weights) {
            assert!((m - w / 12.0).abs() < 1e-6, "{mass:?}");
        }
    }
}
