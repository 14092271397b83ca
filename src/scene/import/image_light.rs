//! The image-based light of a scene (EXT_lights_image_based) as an environment map.
//!
//! Its most detailed specular images are the radiance around the scene, on the faces of a cube; the others and the
//! irradiance are made of it, which rendering does itself.

use glam::{DQuat, DVec3};
use gltf::json::Value;

use super::file::File;
use crate::scene::light::Environment;
use crate::scene::texture::{Image, SRGB};

const NAME: &str = "EXT_lights_image_based";
/// Most rows of the map.
const MAX_ROWS: usize = 1024;
/// Look-ups a pixel, each way.
const LOOK_UPS: usize = 2;

/// What surrounds the file's scene; None where it names no such light.
///
/// # Errors
/// A sentence that says why the light cannot be used.
pub fn convert(file: &File) -> Result<Option<Environment>, String> {
    let index = file.root.scene.map_or(0, |scene| scene.value());
    let extensions = file.root.scenes.get(index).and_then(|scene| scene.extensions.as_ref());
    let Some(light) = extensions.and_then(|e| e.others.get(NAME)).and_then(|e| e.get("light")) else {
        return Ok(None);
    };
    let lights = file.extension(NAME).and_then(|e| e.get("lights"));
    let light = light.as_u64().and_then(|light| lights?.get(light as usize)).ok_or("it does not exist")?;
    let number = |value: Option<&Value>, default: f64| value.map_or(Some(default), Value::as_f64);
    let intensity = number(light.get("intensity"), 1.0).filter(|i| i.is_finite() && (0.0..=1e9).contains(i));
    let intensity = intensity.ok_or("its intensity is no number of 0 and up")?;
    let part = |i: usize| number(light.get("rotation").and_then(|q| q.get(i)), if i == 3 { 1.0 } else { 0.0 });
    let rotation = [part(0), part(1), part(2), part(3)].map(|part| part.unwrap_or(f64::NAN));
    let rotation = DQuat::from_array(rotation);
    if !(rotation.length_squared() > 0.0 && rotation.length_squared().is_finite()) {
        return Err("its rotation is no quaternion".into());
    }
    let faces = light.get("specularImages").and_then(|mips| mips.get(0)).and_then(Value::as_array);
    let faces = faces.filter(|faces| faces.len() == 6).ok_or("it has no six images")?;
    let mut cube = Vec::with_capacity(6);
    for face in faces {
        let index = face.as_u64().ok_or("its images are no numbers")?;
        let image = file.image(index as usize)?;
        cube.push(image.ok_or("its images are in no format that is read")?);
    }
    let environment = unrolled(&cube, rotation.normalize().inverse(), intensity);
    let lit = environment.pixels.as_flattened().iter().any(|value| *value > 0.0);
    if lit { Ok(Some(environment)) } else { Err("it is black".into()) }
}

/// The equirectangular map of a cube's faces, which `cube_from_world` turns, as fine as they are at their centres.
fn unrolled(cube: &[Image], cube_from_world: DQuat, intensity: f64) -> Environment {
    use std::f64::consts::PI;
    let size = cube.iter().map(|face| face.width as usize).max().unwrap_or(1);
    let height = (2 * size).clamp(2, MAX_ROWS);
    let width = 2 * height;
    let mut pixels = Vec::with_capacity(width * height);
    for i in 0..width * height {
        let mut sum = DVec3::ZERO;
        for look_up in 0..LOOK_UPS * LOOK_UPS {
            let part = |n: usize| (n as f64 + 0.5) / LOOK_UPS as f64;
            let u = ((i % width) as f64 + part(look_up % LOOK_UPS)) / width as f64;
            let v = ((i / width) as f64 + part(look_up / LOOK_UPS)) / height as f64;
            // As shaders/light/environment.wesl has it: the map's centre lies in -z.
            let ((sin, cos), phi) = ((PI * v).sin_cos(), 2.0 * PI * (u - 0.5));
            sum += radiance(cube, cube_from_world * DVec3::new(sin * phi.sin(), cos, -sin * phi.cos()));
        }
        let mean = intensity * sum / (LOOK_UPS * LOOK_UPS) as f64;
        pixels.push(mean.min(DVec3::splat(1e9)).as_vec3().to_array());
    }
    Environment { width: width as u32, height: height as u32, pixels }
}

/// Radiance from a direction. Faces are +X, -X, +Y, -Y, +Z, -Z, each as seen from inside the cube: the extension has the
/// images of a cube map flipped about their vertical axis. The faces +Y and -Y have -Z and +Z at their tops.
fn radiance(cube: &[Image], w: DVec3) -> DVec3 {
    let size = w.abs();
    let (face, depth, right, down) = if size.x >= size.y && size.x >= size.z {
        if w.x > 0.0 { (0, size.x, w.z, -w.y) } else { (1, size.x, -w.z, -w.y) }
    } else if size.y >= size.z {
        if w.y > 0.0 { (2, size.y, -w.x, w.z) } else { (3, size.y, -w.x, -w.z) }
    } else if w.z > 0.0 {
        (4, size.z, -w.x, -w.y)
    } else {
        (5, size.z, w.x, -w.y)
    };
    let image = &cube[face];
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let x = (0.5 * (right / depth + 1.0) * width - 0.5).clamp(0.0, width - 1.0);
    let y = (0.5 * (down / depth + 1.0) * height - 0.5).clamp(0.0, height - 1.0);
    let at = |x: f64, y: f64| {
        let texel = image.texels[(y.min(height - 1.0) * width + x.min(width - 1.0)) as usize];
        let [r, g, b, divisor] = texel.to_le_bytes();
        // RGBD; images without the fourth channel have 255 there.
        let scale = if divisor == 0 { 0.0 } else { 255.0 / f64::from(divisor) };
        scale * DVec3::from([r, g, b].map(|c| f64::from(SRGB[c as usize])))
    };
    let (left, top) = (x.floor(), y.floor());
    let row = |y: f64| at(left, y).lerp(at(left + 1.0, y), x - left);
    row(top).lerp(row(top + 1.0), y - top)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of one colour each, and a turn about y.
    #[test]
    fn faces_lie_where_the_extension_has_them() {
        let colors = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [0, 255, 255], [255, 0, 255]];
        let face =
            |[r, g, b]: [u8; 3]| Image { width: 4, height: 4, texels: vec![u32::from_le_bytes([r, g, b, 51]); 16] };
        let cube = colors.map(face);
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        for (axis, color) in axes.into_iter().zip(colors) {
            let expected = 5.0 * DVec3::from(color.map(f64::from)) / 255.0;
            assert!((radiance(&cube, axis) - expected).length() < 1e-9, "{axis}");
        }
        let quarter = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let map = unrolled(&cube, quarter.inverse(), 2.0);
        // The map's centre, -z, shows what lay in the direction that the turn brings there: +x.
        let centre = map.pixels[(map.height / 2 * map.width + map.width / 2) as usize];
        assert!((centre[0] - 10.0).abs() < 1e-4 && centre[1] == 0.0, "{centre:?}");
    }

    /// A face as seen from inside: its left column lies to the left of who looks at it, with y up.
    #[test]
    fn faces_are_seen_from_inside() {
        let halves = |x: u32| if x < 2 { [255, 0, 0, 255] } else { [0, 0, 255, 255] };
        let face = Image { width: 4, height: 4, texels: (0..16).map(|i| u32::from_le_bytes(halves(i % 4))).collect() };
        let cube: Vec<Image> = (0..6).map(|_| face.clone()).collect();
        for forward in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z] {
            let left = radiance(&cube, forward - 0.5 * forward.cross(DVec3::Y));
            assert!(left.x == 1.0 && left.z == 0.0, "{forward}: {left}");
        }
    }
}
