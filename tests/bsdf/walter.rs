//! Rough glass by the formulas of Walter et al. 2007 ("Microfacet models for refraction through rough surfaces"), in f64
//! and written from the paper, apart from the shaders.

use glam::DVec3;

/// GGX (eq. 33) about z.
fn d(m: DVec3, alpha: f64) -> f64 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let cos2 = m.z * m.z;
    let tan2 = (1.0 - cos2) / cos2;
    alpha * alpha / (std::f64::consts::PI * cos2 * cos2 * (alpha * alpha + tan2).powi(2))
}

/// Smith's shadowing of one direction (eq. 34).
fn g1(v: DVec3, m: DVec3, alpha: f64) -> f64 {
    if v.dot(m) / v.z <= 0.0 {
        return 0.0;
    }
    let tan2 = (1.0 - v.z * v.z) / (v.z * v.z);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// Fresnel's reflectance (eq. 22) from index `from` into `to`.
fn fresnel(cosine: f64, from: f64, to: f64) -> f64 {
    let c = cosine.abs();
    let g2 = (to / from).powi(2) - 1.0 + c * c;
    if g2 <= 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    0.5 * ((g - c) / (g + c)).powi(2) * (1.0 + ((c * (g + c) - 1.0) / (c * (g - c) + 1.0)).powi(2))
}

/// BSDF for radiance that comes from `i` and leaves towards `o` (eq. 20, 21), and the density of half-vectors seen from
/// `o`, carried to `i` (eq. 14, 17), for a boundary of index `ior` below z = 0: (reflected, transmitted, density).
pub fn rough_glass(i: DVec3, o: DVec3, alpha: f64, ior: f64) -> (f64, f64, f64) {
    let index = |v: DVec3| if v.z > 0.0 { 1.0 } else { ior };
    let (eta_i, eta_o) = (index(i), index(o));
    if i.z * o.z > 0.0 {
        let m = (i + o).normalize() * o.z.signum();
        let f = fresnel(i.dot(m), eta_i, eta_i.mul_add(-1.0, 1.0 + ior));
        let masked = d(m, alpha) * g1(i, m, alpha) * g1(o, m, alpha);
        let density = g1(o, m, alpha) * d(m, alpha) * (o.dot(m) / o.z).abs() / (4.0 * i.dot(m).abs());
        (f * masked / (4.0 * i.z * o.z).abs(), 0.0, f * density)
    } else {
        let m = -(eta_i * i + eta_o * o).normalize();
        let m = m * m.z.signum();
        let f = fresnel(i.dot(m), eta_i, eta_o);
        let denominator = (eta_i * i.dot(m) + eta_o * o.dot(m)).powi(2);
        if i.dot(m) * o.dot(m) >= 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let masked = d(m, alpha) * g1(i, m, alpha) * g1(o, m, alpha);
        let facets = (i.dot(m) * o.dot(m) / (i.z * o.z)).abs();
        let value = facets * eta_o * eta_o * (1.0 - f) * masked / denominator;
        let seen = g1(o, m, alpha) * d(m, alpha) * (o.dot(m) / o.z).abs();
        (0.0, value, (1.0 - f) * seen * eta_i * eta_i * i.dot(m).abs() / denominator)
    }
}
