//! KHR_materials_pbrSpecularGlossiness, turned into the parameters that replaced it.
//!
//! The archived extension has a diffuse colour, a reflectance at normal incidence and a glossiness. An index of refraction
//! of 0 with KHR_materials_specular says the same in today's terms without a loss (KHR_materials_ior, "Interaction with
//! other extensions"): reflectance specular, 1 at grazing angles, and beneath it the diffuse colour times
//! 1 - max(specular). Guessing metals instead, as older converters do, would change how the material looks.

use glam::{DVec3, Vec3};
use gltf::json::Value;

use super::material::{mapped_alpha, number};
use super::texture::Reader;
use crate::scene::Material;
use crate::scene::texture::{IDENTITY, Image, SRGB, Texture};

const PATH: &str = "/extensions/KHR_materials_pbrSpecularGlossiness";

/// Whether the material is one.
pub fn given(raw: &Value) -> bool {
    raw.pointer(PATH).is_some_and(Value::is_object)
}

/// Its factors, in place of those of the metallic-roughness model.
pub fn factors(material: Material, raw: &Value) -> Material {
    let of = |name: &str, default| number(raw, &format!("{PATH}/{name}"), default);
    let color = |name: &str| Vec3::from([0, 1, 2].map(|i| of(&format!("{name}/{i}"), 1.0)));
    let specular = color("specularFactor").clamp(Vec3::ZERO, Vec3::ONE);
    Material {
        // What the reflectance leaves of it comes with the textures.
        base_color: color("diffuseFactor"),
        base_alpha: of("diffuseFactor/3", 1.0),
        metallic: 0.0,
        roughness: 1.0 - of("glossinessFactor", 1.0).clamp(0.0, 1.0),
        ior: 0.0,
        specular: 1.0,
        specular_color: specular,
        transmission: 0.0,
        ..material
    }
}

/// Its textures, and what they do to the diffuse colour and the roughness: images made of the file's.
pub fn textures(material: &mut Material, raw: &Value, reader: &mut Reader) -> Result<(), String> {
    let mut read = |name: &str| {
        let pointer = format!("{PATH}/{name}");
        reader.texture(raw.pointer(&pointer), &pointer.replace('/', "."), true)
    };
    let diffuse = read("diffuseTexture")?;
    let gloss = read("specularGlossinessTexture")?;
    let Some(gloss) = gloss else {
        material.textures.base_color = diffuse;
        material.base_color *= 1.0 - material.specular_color.max_element();
        return Ok(());
    };
    let images = &mut reader.images.images;
    let texels = |texture: &Texture| images[texture.image as usize].texels.len() as u64;
    let made = texels(&gloss) + texels(diffuse.as_ref().unwrap_or(&gloss));
    reader.file.take_room(&format!("materials[{}]", reader.material), 4 * made)?;

    let rough = roughness(&images[gloss.image as usize], 1.0 - material.roughness);
    material.roughness = 1.0;
    material.mapped_alpha = Some(mapped_alpha(&rough, 1.0));
    let base = darkened(diffuse.as_ref(), &gloss, material.specular_color, images);
    let mut add = |image: Image| {
        images.push(image);
        images.len() as u32 - 1
    };
    material.textures.metallic_roughness = Some(Texture { image: add(rough), srgb: false, ..gloss.clone() });
    let like = diffuse.unwrap_or_else(|| gloss.clone());
    material.textures.base_color = Some(Texture { image: add(base), ..like });
    material.textures.specular_color = Some(gloss);
    Ok(())
}

/// Roughness in the green channel, out of glossiness in alpha.
fn roughness(gloss: &Image, factor: f32) -> Image {
    let texel = |texel: &u32| {
        let glossiness = factor * f32::from(texel.to_le_bytes()[3]) / 255.0;
        u32::from_le_bytes([0, (255.0 * (1.0 - glossiness)).round() as u8, 0, 255])
    };
    Image { texels: gloss.texels.iter().map(texel).collect(), ..*gloss }
}

/// The diffuse texture times what its reflectance leaves, at the same coordinates; where the two textures lie differently
/// on the surface, the mean of that.
fn darkened(diffuse: Option<&Texture>, gloss: &Texture, specular: Vec3, images: &[Image]) -> Image {
    let left = |[r, g, b, _]: [f64; 4]| 1.0 - (specular.as_dvec3() * DVec3::new(r, g, b)).max_element().min(1.0);
    let linear = |texel: u32| texel.to_le_bytes().map(|c| f64::from(SRGB[c as usize]));
    let own = &images[gloss.image as usize];
    let like = diffuse.map_or(own, |diffuse| &images[diffuse.image as usize]);
    let same = |other: &Texture| (other.slot, other.transform) == (gloss.slot, gloss.transform);
    let mean = match diffuse {
        Some(diffuse) if !same(diffuse) => {
            Some(own.texels.iter().map(|t| left(linear(*t))).sum::<f64>() / own.texels.len() as f64)
        }
        _ => None,
    };
    let upright = Texture { transform: IDENTITY, ..gloss.clone() };
    let texel = |(i, texel): (usize, &u32)| {
        let (x, y) = (i as u32 % like.width, i as u32 / like.width);
        let at = [(f64::from(x) + 0.5) / f64::from(like.width), (f64::from(y) + 0.5) / f64::from(like.height)];
        let left = mean.unwrap_or_else(|| left(upright.sample(images, at)));
        let (color, alpha) = match diffuse {
            Some(_) => (linear(*texel), texel.to_le_bytes()[3]),
            None => ([1.0; 4], 255),
        };
        let [r, g, b] = [0, 1, 2].map(|c| code(left * color[c]));
        u32::from_le_bytes([r, g, b, alpha])
    };
    Image { texels: like.texels.iter().enumerate().map(texel).collect(), ..*like }
}

/// The sRGB code of a linear value (IEC 61966-2-1).
fn code(linear: f64) -> u8 {
    let coded = if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * coded).round() as u8
}
