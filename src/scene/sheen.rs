//! Sheen in f64 from the formulas of KHR_materials_sheen (Estevez and Kulla 2017); shaders/bsdf/sheen.wesl evaluates them
//! on the device.

use std::f64::consts::PI;

/// Least roughness that is rendered.
pub const SHEEN_ROUGHNESS: f32 = 0.07;

/// How directions at this cosine are shadowed.
pub fn lambda(cosine: f64, alpha: f64) -> f64 {
    let t = (1.0 - alpha).powi(2);
    let between = |rough: f64, smooth: f64| rough + t * (smooth - rough);
    let [a, b, c] = [between(25.3245, 21.5473), between(3.32435, 3.82987), between(0.16801, 0.19823)];
    let [d, e] = [between(-1.27393, -1.97760), between(-4.85967, -4.32054)];
    let curve = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cosine < 0.5 { curve(cosine).exp() } else { (2.0 * curve(0.5) - curve(1.0 - cosine)).exp() }
}

/// Distribution of the fibres' normals, from the sine of the half-vector's angle.
pub fn distribution(sine: f64, alpha: f64) -> f64 {
    (2.0 + 1.0 / alpha) * sine.powf(1.0 / alpha) / (2.0 * PI)
}

/// Light scattered towards `cosine` out of light of radiance 1 from all around, by quadrature over the square root of the
/// other cosine and over half the azimuths.
pub fn albedo(alpha: f64, cosine: f64, points: usize) -> f64 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let seen = lambda(cosine, alpha);
    let mut sum = 0.0;
    for i in 0..points {
        let root = (i as f64 + 0.5) / points as f64;
        let other = root * root;
        let (other_sine, other_seen) = ((1.0 - other * other).sqrt(), lambda(other, alpha));
        let shadowed = 4.0 * (1.0 + seen + other_seen) * cosine * other;
        for j in 0..points {
            let phi = PI * (j as f64 + 0.5) / points as f64;
            let (x, y) = (sine + other_sine * phi.cos(), other_sine * phi.sin());
            let across = x * x + y * y;
            let height = cosine + other;
            let half_sine = (across / (across + height * height)).sqrt();
            sum += distribution(half_sine, alpha) / shadowed * other * 2.0 * root;
        }
    }
    2.0 * PI * sum / (points * points) as f64
}
