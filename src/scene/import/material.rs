//! Materials as the renderer knows them, and notes of what they ask for beyond that.

use glam::Vec3;
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

use super::notes::{Feature, MATERIAL_EXTENSIONS, Notes};
use crate::scene::Material;

/// Whether light passes a transmissive material refracted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refraction {
    /// The file says so, or there is no transmission.
    Thin,
    /// The file says so: KHR_materials_volume with a thickness.
    Solid,
    /// The file leaves it open: it refracts where the surface is closed.
    WhereClosed,
}

/// `materials[index]` with `thin` as far as the file decides it, and what is to decide it.
pub fn convert(material: &json::Material, index: usize, notes: &mut Notes) -> Result<(Material, Refraction), String> {
    let extensions = material.extensions.as_ref();
    let pbr = &material.pbr_metallic_roughness;
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    let volume = extensions.and_then(|e| e.volume.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let emissive_strength =
        extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);

    let [red, green, blue, _] = pbr.base_color_factor.0;
    let mut converted = Material {
        name: material.name.clone().unwrap_or_else(|| format!("material {index}")),
        base_color: Vec3::new(red, green, blue),
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        ior: extensions.and_then(|e| e.ior.as_ref()).map_or(1.5, |e| e.ior.0),
        specular: specular.map_or(1.0, |s| s.specular_factor.0),
        specular_color: specular.map_or(Vec3::ONE, |s| Vec3::from_array(s.specular_color_factor.0)),
        transmission: transmission.map_or(0.0, |t| t.transmission_factor.0),
        thin: true,
        emission: emissive_strength * Vec3::from_array(material.emissive_factor.0),
        double_sided: material.double_sided,
    };
    if extensions.is_some_and(|e| e.unlit.is_some()) {
        notes.add(Feature::Unlit, index);
        converted = Material {
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            transmission: 0.0,
            emission: Vec3::ZERO,
            ..converted
        };
    }
    if material.emissive_texture.is_some() && converted.emits() {
        // The factor alone would make all of the surface a light, where the texture lights a few spots.
        notes.add(Feature::EmissiveTexture, index);
        converted.emission = Vec3::ZERO;
    }
    check(&mut converted)?;
    note_unsupported(material, index, notes);

    let refraction = match volume {
        _ if converted.transmission == 0.0 => Refraction::Thin,
        Some(volume) if volume.thickness_factor.0 > 0.0 => Refraction::Solid,
        Some(_) => Refraction::Thin,
        None => Refraction::WhereClosed,
    };
    converted.thin = refraction != Refraction::Solid;
    Ok((converted, refraction))
}

/// Refuses what is no number and brings the rest into the ranges of glTF.
fn check(material: &mut Material) -> Result<(), String> {
    let values = [
        ("pbrMetallicRoughness.baseColorFactor", material.base_color.is_finite()),
        ("pbrMetallicRoughness.metallicFactor", material.metallic.is_finite()),
        ("pbrMetallicRoughness.roughnessFactor", material.roughness.is_finite()),
        ("emissiveFactor times emissiveStrength", material.emission.is_finite()),
        ("KHR_materials_ior", material.ior.is_finite()),
        ("KHR_materials_specular", material.specular.is_finite() && material.specular_color.is_finite()),
        ("KHR_materials_transmission", material.transmission.is_finite()),
    ];
    if let Some((what, _)) = values.iter().find(|(_, finite)| !finite) {
        return Err(format!("{what} is not a finite number: correct it"));
    }
    material.base_color = material.base_color.clamp(Vec3::ZERO, Vec3::ONE);
    material.emission = material.emission.max(Vec3::ZERO);
    material.specular_color = material.specular_color.max(Vec3::ZERO);
    for unit in [&mut material.metallic, &mut material.roughness, &mut material.specular, &mut material.transmission] {
        *unit = unit.clamp(0.0, 1.0);
    }
    // KHR_materials_ior: 0 means full reflection at every angle, which only an opaque surface can mean; else 1 and up.
    if material.ior != 0.0 || material.transmission > 0.0 {
        material.ior = material.ior.max(1.0);
    }
    Ok(())
}

/// Notes every part of `material` that rendering will ignore.
fn note_unsupported(material: &json::Material, index: usize, notes: &mut Notes) {
    let extensions = material.extensions.as_ref();
    let pbr = &material.pbr_metallic_roughness;
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    let volume = extensions.and_then(|e| e.volume.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let textures = [
        pbr.base_color_texture.as_ref(),
        pbr.metallic_roughness_texture.as_ref(),
        material.emissive_texture.as_ref(),
        transmission.and_then(|t| t.transmission_texture.as_ref()),
        volume.and_then(|v| v.thickness_texture.as_ref()),
        specular.and_then(|s| s.specular_texture.as_ref()),
        specular.and_then(|s| s.specular_color_texture.as_ref()),
    ];
    // Normal and occlusion textures are of other types, whose extensions the parser leaves untyped.
    let normal = material.normal_texture.as_ref().map(|t| t.extensions.as_ref().map(|e| &e.others));
    let occlusion = material.occlusion_texture.as_ref().map(|t| t.extensions.as_ref().map(|e| &e.others));
    let untyped = [normal, occlusion];
    let transformed =
        textures.iter().flatten().any(|t| t.extensions.as_ref().is_some_and(|e| e.texture_transform.is_some()))
            || untyped.iter().flatten().flatten().any(|others| others.contains_key("KHR_texture_transform"));
    let attenuates = |v: &&json::extensions::material::Volume| {
        v.attenuation_distance.0.is_finite() && v.attenuation_color.0 != [1.0; 3]
    };
    let features = [
        (Feature::Texture, textures.iter().any(Option::is_some) || untyped.iter().any(Option::is_some)),
        (Feature::TextureTransform, transformed),
        (Feature::Alpha, material.alpha_mode != Checked::Valid(AlphaMode::Opaque)),
        (Feature::Attenuation, volume.filter(attenuates).is_some()),
    ];
    for (feature, _) in features.iter().filter(|(_, present)| *present) {
        notes.add(*feature, index);
    }
    for (name, _) in MATERIAL_EXTENSIONS {
        if extensions.is_some_and(|e| e.others.contains_key(name)) {
            notes.add(Feature::MaterialExtension(name), index);
        }
    }
}
