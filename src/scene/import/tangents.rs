//! Tangents for meshes without any: MikkTSpace's (Mikkelsen 2008), which is what normal textures are made for.
//!
//! Faces are split where coordinates are mirrored; vertices are one where place, normal and coordinates are the same.

use std::collections::HashMap;

use glam::{DVec2, DVec3, DVec4};

/// One corner of a triangle in the world.
#[derive(Clone, Copy)]
pub struct Corner {
    pub position: DVec3,
    pub normal: DVec3,
    pub coordinates: DVec2,
}

/// Unit tangent and the sign of the bitangent of every corner.
pub fn of(triangles: &[[Corner; 3]]) -> Vec<[DVec4; 3]> {
    let mut sums: HashMap<[u32; 9], DVec3> = HashMap::new();
    for corners in triangles {
        let (along, sign) = frame(corners);
        for i in 0..3 {
            let here = corners[i];
            let level = |v: DVec3| v.reject_from_normalized(here.normal).normalize_or_zero();
            let to = |j: usize| level(corners[j].position - here.position);
            let angle = to((i + 1) % 3).dot(to((i + 2) % 3)).clamp(-1.0, 1.0).acos();
            *sums.entry(key(&here, sign)).or_default() += angle * level(along);
        }
    }
    let tangent = |corner: &Corner, sign: f64| {
        let sum = sums.get(&key(corner, sign)).and_then(|sum| sum.try_normalize());
        sum.unwrap_or_else(|| corner.normal.any_orthonormal_vector()).extend(sign)
    };
    triangles.iter().map(|corners| corners.map(|corner| tangent(&corner, frame(corners).1))).collect()
}

/// Direction of increasing u (zero where the coordinates do not tell it), and the sign of the bitangent: glTF's second
/// coordinate points down where its bitangent points up.
fn frame([a, b, c]: &[Corner; 3]) -> (DVec3, f64) {
    let (p, q) = (b.position - a.position, c.position - a.position);
    let (s, t) = (b.coordinates - a.coordinates, c.coordinates - a.coordinates);
    let area = s.perp_dot(t);
    let along = (t.y * p - s.y * q) * area.signum();
    (if area == 0.0 { DVec3::ZERO } else { along.normalize_or_zero() }, if area > 0.0 { -1.0 } else { 1.0 })
}

/// Corners with the same key share their tangent.
fn key(corner: &Corner, sign: f64) -> [u32; 9] {
    let (p, n, t) = (corner.position.as_vec3(), corner.normal.as_vec3(), corner.coordinates.as_vec2());
    // Adding zero makes one of the two zeros.
    [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, sign as f32].map(|v| (v + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, u: f64, v: f64) -> Corner {
        Corner { position: DVec3::new(x, y, 0.0), normal: DVec3::Z, coordinates: DVec2::new(u, v) }
    }

    #[test]
    fn upright_turned_and_mirrored() {
        // An image upright on a wall that faces +z: u to the right, v down.
        let upright = [corner(0.0, 0.0, 0.0, 1.0), corner(1.0, 0.0, 1.0, 1.0), corner(0.0, 1.0, 0.0, 0.0)];
        let mirrored = upright.map(|c| Corner { coordinates: DVec2::new(-c.coordinates.x, c.coordinates.y), ..c });
        let turned = upright.map(|c| Corner { coordinates: DVec2::new(c.coordinates.y, -c.coordinates.x), ..c });
        let flat = upright.map(|c| Corner { coordinates: DVec2::ZERO, ..c });
        let made = of(&[upright, mirrored, turned, flat]);
        let near = |a: DVec4, b: DVec4| assert!((a - b).length() < 1e-12, "{a} {b}");
        near(made[0][0], DVec4::new(1.0, 0.0, 0.0, 1.0));
        near(made[1][1], DVec4::new(-1.0, 0.0, 0.0, -1.0));
        near(made[2][0], DVec4::new(0.0, -1.0, 0.0, 1.0));
        assert!(made[3][0].truncate().dot(DVec3::Z).abs() < 1e-12 && made[3][0].is_finite());
    }
}
