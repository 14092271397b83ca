//! Punctual lights of nodes (KHR_lights_punctual).

use glam::{DAffine3, DVec3, Vec3};
use gltf::json::Value;

use super::file::File;
use crate::scene::light::{Light, LightKind};

/// `lights[index]` of the file at a node; None where it is dark.
pub fn convert(file: &File, index: usize, world_from_node: DAffine3) -> Result<Option<Light>, String> {
    let path = format!("extensions.KHR_lights_punctual.lights[{index}]");
    let again = |why: &str| format!("{path}{why}: export the file again");
    let lights = file.extension("KHR_lights_punctual").and_then(|e| e.get("lights")).and_then(Value::as_array);
    let json = lights.and_then(|lights| lights.get(index)).ok_or_else(|| again(" does not exist"))?;
    let number = |json: &Value, key: &str, default: f64| json.get(key).and_then(Value::as_f64).unwrap_or(default);
    let color = json.get("color").and_then(Value::as_array);
    let channel = |i: usize| color.and_then(|c| c.get(i)).and_then(Value::as_f64).unwrap_or(1.0);
    let intensity = (number(json, "intensity", 1.0) * DVec3::new(channel(0), channel(1), channel(2))).as_vec3();
    if !intensity.is_finite() {
        return Err(again(" is not finite"));
    }
    let intensity = intensity.max(Vec3::ZERO);
    if intensity == Vec3::ZERO {
        return Ok(None);
    }
    let position = world_from_node.translation.as_vec3();
    // Lights shine along their node's -z.
    let direction = || {
        let direction = (-world_from_node.matrix3.z_axis).try_normalize();
        direction.map(|d| d.as_vec3()).ok_or_else(|| again("'s node has a scale of zero"))
    };
    let kind = match json.get("type").and_then(Value::as_str) {
        Some("point") => LightKind::Point { position },
        Some("directional") => LightKind::Directional { direction: direction()? },
        Some("spot") => {
            let none = Value::Null;
            let spot = json.get("spot").unwrap_or(&none);
            let outer =
                number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4).clamp(1e-3, 0.5 * std::f64::consts::PI);
            let inner = number(spot, "innerConeAngle", 0.0).clamp(0.0, outer - 1e-4);
            let [inner_cosine, outer_cosine] = [inner, outer].map(|angle| angle.cos() as f32);
            LightKind::Spot { position, direction: direction()?, inner_cosine, outer_cosine }
        }
        _ => return Err(again(".type is unknown")),
    };
    if !position.is_finite() {
        return Err(again("'s node lies nowhere"));
    }
    Ok(Some(Light { kind, intensity }))
}
