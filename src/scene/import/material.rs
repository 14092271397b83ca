//! Materials as the renderer knows them, and notes of what they ask for beyond that.

use glam::Vec3;
use gltf::json;
use gltf::json::Value;
use gltf::json::material::AlphaMode as FileAlpha;
use gltf::json::validation::Checked;

use super::glossiness;
use super::notes::{Feature, MATERIAL_EXTENSIONS, Notes};
use super::texture::Reader;
use crate::scene::material::{AlphaMode, Anisotropy, Coat, Sheen, Textures};
use crate::scene::{Image, Material};

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

/// A material of the file, converted.
pub struct Converted {
    pub material: Material,
    pub refraction: Refraction,
    /// The sets of coordinates (TEXCOORD_n) that its textures use, by slot.
    pub coordinates: Vec<u32>,
}

/// `materials[index]` with `thin` as far as the file decides it, and what is to decide it. `raw` is the same as `material`,
/// untyped; `colored` says whether vertices with this material have colours.
pub fn convert(material: &json::Material, raw: &Value, colored: bool, mut reader: Reader) -> Result<Converted, String> {
    let index = reader.material;
    let extensions = material.extensions.as_ref();
    let pbr = &material.pbr_metallic_roughness;
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    let volume = extensions.and_then(|e| e.volume.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let emissive_strength =
        extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);

    let [red, green, blue, base_alpha] = pbr.base_color_factor.0;
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
        absorption: volume.map_or(Vec3::ZERO, absorption),
        emission: emissive_strength * Vec3::from_array(material.emissive_factor.0),
        double_sided: material.double_sided,
        base_alpha,
        alpha_mode: match material.alpha_mode {
            Checked::Valid(FileAlpha::Mask) => AlphaMode::Mask(material.alpha_cutoff.map_or(0.5, |c| c.0)),
            Checked::Valid(FileAlpha::Blend) => AlphaMode::Blend,
            _ => AlphaMode::Opaque,
        },
        vertex_colored: colored,
        unlit: false,
        coat: coat(raw),
        sheen: sheen(raw),
        anisotropy: anisotropy(raw),
        textures: Textures::default(),
        mapped_alpha: None,
    };
    let unlit = extensions.is_some_and(|e| e.unlit.is_some());
    if glossiness::given(raw) {
        converted = glossiness::factors(converted, raw);
    }
    if unlit {
        // Its radiance is its colour in all directions; it scatters nothing.
        converted = Material {
            unlit: true,
            emission: converted.base_color.clamp(Vec3::ZERO, Vec3::ONE),
            base_color: Vec3::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            transmission: 0.0,
            coat: Coat::default(),
            sheen: Sheen::default(),
            anisotropy: Anisotropy::default(),
            ..converted
        };
    }
    check(&mut converted)?;
    // Glass lets light through as it is; what covers it is not told apart.
    if converted.transmission > 0.0 && converted.alpha_mode == AlphaMode::Blend {
        converted.alpha_mode = AlphaMode::Opaque;
        reader.notes.add(Feature::GlassAlpha, index);
    }
    textures(&mut converted, raw, &mut reader)?;
    // Tangents follow the first coordinates where no texture asks for others.
    if converted.anisotropy.strength > 0.0 && reader.sets.is_empty() {
        reader.sets.push(0);
    }
    note_unsupported(material, index, reader.notes);

    let refraction = match volume {
        _ if converted.transmission == 0.0 => Refraction::Thin,
        Some(volume) if volume.thickness_factor.0 > 0.0 => Refraction::Solid,
        Some(_) => Refraction::Thin,
        None => Refraction::WhereClosed,
    };
    converted.thin = refraction != Refraction::Solid;
    Ok(Converted { material: converted, refraction, coordinates: reader.sets })
}

/// Reads the textures that make a difference to `material`.
///
/// The occlusion texture is not read: how much light reaches a point is what rendering computes. Neither is the texture of
/// KHR_materials_volume's thickness, which stands in for geometry that is there.
fn textures(material: &mut Material, raw: &Value, reader: &mut Reader) -> Result<(), String> {
    let coated = material.coat_factor() > 0.0;
    let (fibres, stretched) = (material.sheen.color != Vec3::ZERO, material.anisotropy.strength > 0.0);
    let mut read = |pointer: &str, srgb: bool, used: bool| {
        let info = raw.pointer(pointer).filter(|_| used);
        reader.texture(info, &pointer.replace('/', "."), srgb)
    };
    let specular = material.specular > 0.0;
    let colored = material.base_color != Vec3::ZERO || material.alpha_mode != AlphaMode::Opaque;
    let base_texture = if glossiness::given(raw) {
        "/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture"
    } else {
        "/pbrMetallicRoughness/baseColorTexture"
    };
    let extension = |name: &str| format!("/extensions/KHR_materials_{name}");
    let scale = |pointer: &str| {
        let scale = raw.pointer(&format!("{pointer}/scale")).and_then(Value::as_f64);
        scale.unwrap_or(1.0) as f32
    };
    let coat_normal = extension("clearcoat") + "/clearcoatNormalTexture";
    material.textures = Textures {
        base_color: read(base_texture, true, colored)?,
        metallic_roughness: read("/pbrMetallicRoughness/metallicRoughnessTexture", false, material.is_specular())?,
        emissive: read(if material.unlit { base_texture } else { "/emissiveTexture" }, true, material.emits())?,
        normal: read("/normalTexture", false, true)?.map(|texture| (texture, scale("/normalTexture"))),
        transmission: read(&(extension("transmission") + "/transmissionTexture"), false, material.transmission > 0.0)?,
        specular: read(&(extension("specular") + "/specularTexture"), false, specular)?,
        specular_color: read(&(extension("specular") + "/specularColorTexture"), true, specular)?,
        coat: read(&(extension("clearcoat") + "/clearcoatTexture"), false, coated)?,
        coat_roughness: read(&(extension("clearcoat") + "/clearcoatRoughnessTexture"), false, coated)?,
        coat_normal: read(&coat_normal, false, coated)?.map(|texture| (texture, scale(&coat_normal))),
        sheen_color: read(&(extension("sheen") + "/sheenColorTexture"), true, fibres)?,
        sheen_roughness: read(&(extension("sheen") + "/sheenRoughnessTexture"), false, fibres)?,
        anisotropy: read(&(extension("anisotropy") + "/anisotropyTexture"), false, stretched)?,
    };
    if glossiness::given(raw) && !material.unlit {
        material.textures.metallic_roughness = None;
        glossiness::textures(material, raw, reader)?;
    }
    let images = &reader.images.images;
    if let Some(texture) = &material.textures.metallic_roughness {
        material.mapped_alpha = Some(mapped_alpha(&images[texture.image as usize], material.roughness));
    }
    if let Some(texture) = &material.textures.coat_roughness {
        let [mean, _] = mapped_alpha(&images[texture.image as usize], material.coat.roughness);
        material.coat.mapped_alpha = Some(mean);
    }
    // A lamp whose texture is black all over is none.
    if let Some(texture) = &material.textures.emissive
        && images[texture.image as usize].texels.iter().all(|texel| texel & 0x00ff_ffff == 0)
    {
        material.emission = Vec3::ZERO;
        material.textures.emissive = None;
    }
    Ok(())
}

/// Mean and largest alpha over the texels, whose green is multiplied with `roughness`.
pub(super) fn mapped_alpha(image: &Image, roughness: f32) -> [f32; 2] {
    let (mut sum, mut most) = (0.0, 0u8);
    for texel in &image.texels {
        let [_, green, ..] = texel.to_le_bytes();
        most = most.max(green);
        sum += f64::from(green).powi(2);
    }
    let squared = roughness * roughness;
    let mean = (sum / (image.texels.len() as f64 * 255.0 * 255.0)) as f32;
    [squared * mean, squared * (f32::from(most) / 255.0).powi(2)]
}

/// A number in a material's extension, `default` where it does not say.
pub(super) fn number(raw: &Value, pointer: &str, default: f32) -> f32 {
    raw.pointer(pointer).and_then(Value::as_f64).map_or(default, |value| value as f32)
}

fn coat(raw: &Value) -> Coat {
    let of = |name: &str| number(raw, &format!("/extensions/KHR_materials_clearcoat/{name}"), 0.0);
    Coat { factor: of("clearcoatFactor"), roughness: of("clearcoatRoughnessFactor"), mapped_alpha: None }
}

fn sheen(raw: &Value) -> Sheen {
    let path = "/extensions/KHR_materials_sheen";
    let channel = |i: usize| number(raw, &format!("{path}/sheenColorFactor/{i}"), 0.0);
    let roughness = number(raw, &format!("{path}/sheenRoughnessFactor"), 0.0);
    Sheen { color: Vec3::new(channel(0), channel(1), channel(2)), roughness }
}

fn anisotropy(raw: &Value) -> Anisotropy {
    let of = |name: &str| number(raw, &format!("/extensions/KHR_materials_anisotropy/{name}"), 0.0);
    Anisotropy { strength: of("anisotropyStrength"), rotation: of("anisotropyRotation") }
}

/// Beer's law: after the attenuation distance, the attenuation colour is left. Black absorbs as good as all.
fn absorption(volume: &json::extensions::material::Volume) -> Vec3 {
    let (color, distance) = (volume.attenuation_color.0, volume.attenuation_distance.0);
    if !(distance > 0.0 && distance.is_finite()) {
        return Vec3::ZERO;
    }
    Vec3::from_array(color.map(|c| -c.clamp(1e-6, 1.0).ln() / distance)).max(Vec3::ZERO)
}

/// Refuses what is no number and brings the rest into the ranges of glTF.
fn check(material: &mut Material) -> Result<(), String> {
    let cutoff = match material.alpha_mode {
        AlphaMode::Mask(cutoff) => cutoff,
        _ => 0.0,
    };
    let values = [
        ("pbrMetallicRoughness.baseColorFactor", material.base_color.is_finite() && material.base_alpha.is_finite()),
        ("alphaCutoff", cutoff.is_finite()),
        ("pbrMetallicRoughness.metallicFactor", material.metallic.is_finite()),
        ("pbrMetallicRoughness.roughnessFactor", material.roughness.is_finite()),
        ("emissiveFactor times emissiveStrength", material.emission.is_finite()),
        ("KHR_materials_ior", material.ior.is_finite()),
        ("KHR_materials_specular", material.specular.is_finite() && material.specular_color.is_finite()),
        ("KHR_materials_volume", material.absorption.is_finite()),
        ("KHR_materials_transmission", material.transmission.is_finite()),
        ("KHR_materials_clearcoat", material.coat.factor.is_finite() && material.coat.roughness.is_finite()),
        ("KHR_materials_sheen", material.sheen.color.is_finite() && material.sheen.roughness.is_finite()),
        (
            "KHR_materials_anisotropy",
            material.anisotropy.strength.is_finite() && material.anisotropy.rotation.is_finite(),
        ),
    ];
    if let Some((what, _)) = values.iter().find(|(_, finite)| !finite) {
        return Err(format!("{what} is not a finite number: correct it"));
    }
    material.base_color = material.base_color.clamp(Vec3::ZERO, Vec3::ONE);
    material.sheen.color = material.sheen.color.clamp(Vec3::ZERO, Vec3::ONE);
    material.emission = material.emission.max(Vec3::ZERO);
    material.specular_color = material.specular_color.max(Vec3::ZERO);
    let (own, coat) = ([&mut material.metallic, &mut material.roughness], &mut material.coat);
    let further = [&mut material.specular, &mut material.transmission, &mut coat.factor, &mut coat.roughness];
    let others = [&mut material.sheen.roughness, &mut material.anisotropy.strength];
    for unit in own.into_iter().chain(further).chain(others) {
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
    for (name, _) in MATERIAL_EXTENSIONS {
        if extensions.is_some_and(|e| e.others.contains_key(name)) {
            notes.add(Feature::MaterialExtension(name), index);
        }
    }
}
