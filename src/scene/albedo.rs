//! How much light layers scatter: the tables by which what is under them darkens, looked up by shaders/bsdf/albedo.wesl.
//! In f64, row by row of equal roughness, over the root of the cosine from 0 to 1.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::sheen;

/// Entries of a table each way.
pub const ALBEDO_ENTRIES: usize = 32;
/// Points of the quadrature each way.
const POINTS: usize = 48;

/// Of white sheen, from [`sheen::SHEEN_ROUGHNESS`] to 1.
pub static SHEEN_ALBEDO: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let least = f64::from(sheen::SHEEN_ROUGHNESS);
    table(|roughness, cosine| {
        let roughness = least + (1.0 - least) * roughness;
        sheen::albedo(roughness * roughness, cosine, POINTS)
    })
});

/// Of a whole clear coat, from roughness 0 to 1.
pub static COAT_ALBEDO: LazyLock<Vec<f32>> =
    LazyLock::new(|| table(|roughness, cosine| coat(roughness * roughness, cosine, POINTS)));

fn table(albedo: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let last = (ALBEDO_ENTRIES - 1) as f64;
    let entry = |n: usize| {
        let root = (n % ALBEDO_ENTRIES) as f64 / last;
        albedo((n / ALBEDO_ENTRIES) as f64 / last, (root * root).max(1e-4)) as f32
    };
    (0..ALBEDO_ENTRIES * ALBEDO_ENTRIES).map(entry).collect()
}

/// Light that GGX microfacets of index 1.5 (by Schlick) scatter towards `cosine` out of light of radiance 1 from all
/// around: the mean of Fresnel's term times the shadowing of the other direction, over the visible facets (Dupuy and
/// Benyoub 2023).
pub fn coat(alpha: f64, cosine: f64, points: usize) -> f64 {
    let alpha = alpha.max(1e-3);
    let sine = (1.0 - cosine * cosine).sqrt();
    let stretched = (alpha * sine).hypot(cosine);
    let (x, height) = (alpha * sine / stretched, cosine / stretched);
    let mut sum = 0.0;
    for i in 0..points {
        for j in 0..points {
            // Half the azimuths: the rest mirrors them.
            let phi = PI * (i as f64 + 0.5) / points as f64;
            let z = (1.0 - (j as f64 + 0.5) / points as f64) * (1.0 + height) - height;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let h = [alpha * (r * phi.cos() + x), alpha * r * phi.sin(), (z + height).max(1e-9)];
            let length = h.iter().map(|c| c * c).sum::<f64>().sqrt();
            let cos_h = (h[0] * sine + h[2] * cosine) / length;
            let other = 2.0 * cos_h * h[2] / length - cosine;
            if other > 0.0 {
                let shadowing = 2.0 * other / (other + (alpha * alpha * (1.0 - other * other) + other * other).sqrt());
                sum += (0.04 + 0.96 * (1.0 - cos_h.min(1.0)).powi(5)) * shadowing;
            }
        }
    }
    sum / (points * points) as f64
}
