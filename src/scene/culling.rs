//! Back faces that a camera does not see (glTF 2.0, section 3.9.5: doubleSided).
//!
//! They are culled on the camera's own edge of a path, from the camera to its first vertex, and nowhere else. So what lies
//! between two points stays the same from either, which paths made from both ends need.

use glam::{DVec3, Vec3};

use super::{Camera, Material, Scene};

impl Material {
    /// Whether no camera sees its triangles from the back. Glass is seen from both sides whatever the file says: it is the
    /// boundary of a solid, whose far side is a back, or a pane with the same glass on either.
    pub fn is_culled(&self) -> bool {
        !self.double_sided && self.transmission == 0.0
    }
}

impl Scene {
    /// Whether `camera` faces the back of some triangle that is culled, be it hidden or off the film. Where it does not,
    /// culling changes nothing.
    pub fn has_culled_back(&self, camera: &Camera) -> bool {
        let culled: Vec<bool> = self.materials.iter().map(Material::is_culled).collect();
        let eye = DVec3::from(Vec3::from(camera.world_from_camera.translation));
        let axis = DVec3::from(Vec3::from(camera.world_from_camera.matrix3.z_axis)).normalize_or_zero();
        let radius = camera.lens.map_or(0.0, |lens| 0.5 * f64::from(lens.aperture));
        // Positive where the camera, or all of its lens, is in front of the triangle.
        let facing = |[a, b, c]: [DVec3; 3]| {
            let normal = (b - a).cross(c - a);
            if camera.orthographic_height.is_some() {
                normal.dot(axis)
            } else {
                normal.dot(eye - a) - radius * normal.reject_from(axis).length()
            }
        };
        let corners = |triangle: &[u32; 3]| triangle.map(|i| self.positions[i as usize].as_dvec3());
        let mut triangles = self.triangles.iter().zip(&self.triangle_materials);
        triangles.any(|(triangle, &material)| culled[material as usize] && facing(corners(triangle)) < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;
    use glam::Affine3A;

    /// A triangle in the plane z = 0 whose front is towards +z, and a camera at `z` that looks along -z.
    fn seen_from(z: f32, change: impl Fn(&mut Material, &mut Camera)) -> bool {
        let mut material = Material::default();
        let mut camera = Camera {
            name: String::new(),
            world_from_camera: Affine3A::from_translation(Vec3::new(0.0, 0.0, z)),
            vertical_fov: 1.0,
            orthographic_height: None,
            lens: None,
            aspect: None,
        };
        change(&mut material, &mut camera);
        let scene = Scene {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            materials: vec![material],
            ..Scene::default()
        };
        scene.has_culled_back(&camera)
    }

    #[test]
    fn backs_are_culled_where_a_camera_faces_them() {
        assert!(!seen_from(1.0, |_, _| ()));
        assert!(seen_from(-1.0, |_, _| ()));
        assert!(!seen_from(-1.0, |material, _| material.double_sided = true));
        assert!(!seen_from(-1.0, |material, _| material.transmission = 0.5));
        // An orthographic camera sees along its axis, wherever it is.
        for z in [-1.0, 1.0] {
            assert!(!seen_from(z, |_, camera| camera.orthographic_height = Some(1.0)));
        }
        let back = Affine3A::from_rotation_y(std::f32::consts::PI);
        assert!(seen_from(1.0, |_, camera| {
            camera.world_from_camera *= back;
            camera.orthographic_height = Some(1.0);
        }));
    }

    /// A lens across the triangle's plane has points behind it, which a lens along the plane has not.
    #[test]
    fn a_lens_is_tested_as_a_whole() {
        let lens = |aperture| Some(Lens { aperture, focus: 1.0 });
        assert!(!seen_from(0.1, |_, camera| camera.lens = lens(1.0)));
        let aside = Affine3A::from_rotation_y(0.5 * std::f32::consts::PI);
        for (aperture, seen) in [(0.19, false), (0.21, true)] {
            let turned = seen_from(0.1, |_, camera| {
                camera.world_from_camera *= aside;
                camera.lens = lens(aperture);
            });
            assert_eq!(turned, seen, "{aperture}");
        }
    }
}
