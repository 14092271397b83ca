//! Cameras of the file, and a framed one for files that have none.

use glam::{Affine3A, DAffine3, DVec3, Vec3};
use gltf::json;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use crate::scene::{Camera, Scene};

/// Vertical field of view of a made camera, in radians.
const DEFAULT_FOV: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// Where a made camera stands: degrees from +z (the front of glTF's assets) towards +x, and degrees above the horizon.
const AZIMUTH_DEG: f64 = 30.0;
const ELEVATION_DEG: f64 = 20.0;
/// Room around the scene, so that it does not touch the image's edge.
const MARGIN: f64 = 1.1;
/// A scene is flat where its smallest extent is below this share of its largest.
const FLAT: f32 = 1e-3;

/// The camera of a node. Errors end with what is wrong and begin with nothing.
///
/// An orthographic camera's magnifications are scaled with its node, as the file's axes are; half of what it sees.
pub fn convert(camera: &json::Camera, name: String, world_from_node: DAffine3) -> Result<Camera, String> {
    let (vertical_fov, aspect, orthographic_height) = match camera.type_ {
        Checked::Valid(Type::Orthographic) => {
            let Some(orthographic) = &camera.orthographic else {
                return Err("it has no orthographic: export the file again".into());
            };
            let axes = world_from_node.matrix3;
            let half_width = f64::from(orthographic.xmag).abs() * axes.x_axis.length();
            let half_height = f64::from(orthographic.ymag).abs() * axes.y_axis.length();
            let (height, aspect) = ((2.0 * half_height) as f32, (half_width / half_height) as f32);
            if !(height > 0.0 && height.is_finite() && aspect > 0.0 && aspect.is_finite()) {
                return Err("its xmag and ymag are not above 0: set them".into());
            }
            (DEFAULT_FOV as f32, Some(aspect), Some(height))
        }
        Checked::Valid(Type::Perspective) => {
            let Some(perspective) = &camera.perspective else {
                return Err("it has no perspective: export the file again".into());
            };
            let fov = perspective.yfov;
            if !(fov > 0.0 && fov < std::f32::consts::PI) {
                return Err(format!("its yfov is {fov}: set it between 0 and pi radians"));
            }
            let aspect = perspective.aspect_ratio;
            if aspect.is_some_and(|aspect| !(aspect > 0.0 && aspect.is_finite())) {
                return Err("its aspectRatio is not above 0: set or remove it".into());
            }
            (fov, aspect, None)
        }
        Checked::Invalid => return Err("its type is unknown: export the file again".into()),
    };
    let back = world_from_node.matrix3.z_axis;
    let up = world_from_node.matrix3.y_axis;
    let world_from_camera =
        rigid(back, up, world_from_node.translation).ok_or("its node's scale is zero: give it a scale of 1")?;
    Ok(Camera { name, world_from_camera, vertical_fov, orthographic_height, lens: None, aspect })
}

/// A camera that sees the whole scene: from the front, a little from the side and above; a flat scene face-on.
pub fn framed(scene: &Scene) -> Camera {
    let low = scene.positions.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let high = scene.positions.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
    let extent = high - low;
    let flat = extent.min_element() <= FLAT * extent.max_element();
    let (back, up) = if flat {
        let axis = if extent.z == extent.min_element() {
            DVec3::Z
        } else if extent.x == extent.min_element() {
            DVec3::X
        } else {
            DVec3::Y
        };
        let back = if facing(scene).dot(axis) < 0.0 { -axis } else { axis };
        // Looking down on a floor, -z is at the top, as on a map whose north is the back of the scene.
        (back, if axis == DVec3::Y { -back.y * DVec3::Z } else { DVec3::Y })
    } else {
        let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
        let level = DVec3::new(azimuth.sin(), 0.0, azimuth.cos());
        (elevation.cos() * level + elevation.sin() * DVec3::Y, DVec3::Y)
    };
    // The directions above are never parallel.
    let turned = rigid(back, up, DVec3::ZERO).unwrap_or(Affine3A::IDENTITY);
    let [right, up] = [turned.matrix3.x_axis, turned.matrix3.y_axis].map(|axis| axis.as_dvec3());
    Camera {
        name: "default".into(),
        world_from_camera: rigid(back, up, eye(scene, right, up, back)).unwrap_or(turned),
        vertical_fov: DEFAULT_FOV as f32,
        orthographic_height: None,
        lens: None,
        aspect: None,
    }
}

/// The nearest place, looking along -`back`, from which every vertex is inside a square image.
///
/// A vertex at (x, y, z) in the camera's axes is inside if |x - cx| <= (d - z) t, and likewise in y, for an eye at
/// (cx, cy, d) and t the tangent of half the angle. With A = max(x + z t) and B = max(-x + z t) over all vertices the
/// least d is (A + B) / 2t, at cx = (A - B) / 2.
fn eye(scene: &Scene, right: DVec3, up: DVec3, back: DVec3) -> DVec3 {
    let t = (0.5 * DEFAULT_FOV).tan() / MARGIN;
    let farthest = |direction: DVec3| {
        scene.positions.iter().map(|p| p.as_dvec3().dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    };
    let fit = |axis: DVec3| (farthest(axis + t * back), farthest(-axis + t * back));
    let ((a, b), (c, d)) = (fit(right), fit(up));
    let distance = (a + b).max(c + d) / (2.0 * t);
    0.5 * (a - b) * right + 0.5 * (c - d) * up + distance * back
}

/// Sum of all triangles' normals, weighted by area: the side that a flat scene shows.
fn facing(scene: &Scene) -> DVec3 {
    let corner = |vertex: u32| scene.positions[vertex as usize].as_dvec3();
    let normal = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
    scene.triangles.iter().map(|&triangle| normal(triangle)).sum()
}

/// The frame that looks along `-back` with `up` in its vertical plane; None where these do not span a plane.
/// Made from two axes, it is right-handed even where a parent mirrors.
fn rigid(back: DVec3, up: DVec3, eye: DVec3) -> Option<Affine3A> {
    let z = back.try_normalize()?;
    let y = up.try_normalize()?.reject_from_normalized(z);
    // Axes this close to parallel are a scale of zero that rounding hides.
    let y = (y.length() > 1e-6).then(|| y.normalize())?;
    let frame = Affine3A::from_cols(y.cross(z).as_vec3a(), y.as_vec3a(), z.as_vec3a(), eye.as_vec3a());
    frame.is_finite().then_some(frame)
}
