//! What the device knows of materials and of the corners of triangles: packed as shaders/bsdf/material.wesl and
//! shaders/texture/*.wesl read it.

use glam::{Vec2, Vec3, Vec4};

use super::layout::{EXTENDED_ROWS, LAYERED_ROWS, MATERIAL_ROWS};
use crate::scene::albedo::{COAT_ALBEDO, SHEEN_ALBEDO};
use crate::scene::material::AlphaMode;
use crate::scene::texture::{SRGB, Texture, Wrap};
use crate::scene::{Features, Material, Scene};

/// Two 16-bit signed normalised octahedral coordinates (Cigolle et al. 2014); twin of `decode_octahedral`.
pub fn encode_octahedral(n: Vec3) -> u32 {
    let sum = n.x.abs() + n.y.abs() + n.z.abs();
    let (mut x, mut y) = (n.x / sum, n.y / sum);
    if n.z < 0.0 {
        (x, y) = ((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum());
    }
    let snorm = |v: f32| ((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16) as u32;
    snorm(x) | (snorm(y) << 16)
}

/// The rows of all materials, and the rows of their textures and of layers' albedos, which lie in the same table after
/// `lights` more.
pub fn materials(scene: &Scene, features: Features, threshold: f32, lights: usize) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
    let mut rows = Vec::new();
    let mut textures: Vec<[u32; 4]> = Vec::new();
    let rows_each = match (features.has_layer_rows(), features.extended()) {
        (true, _) => LAYERED_ROWS,
        (false, true) => EXTENDED_ROWS,
        (false, false) => MATERIAL_ROWS,
    };
    let first_texture = scene.materials.len() * rows_each + lights;
    let offsets = image_offsets(scene);
    // Row of a texture in the table; 0, which is a material's, for none.
    let mut row_of = |texture: Option<&Texture>, scale: f32| {
        let Some(texture) = texture else { return 0 };
        let row = first_texture + textures.len();
        textures.extend(pack_texture(texture, scene, &offsets, scale));
        row as u32
    };
    for material in &scene.materials {
        rows.extend(pack_material(material, threshold, features.extended()));
        if features.extended() {
            let [base, rough, emissive, transmission, specular, specular_color] =
                material.textures.slots().map(|texture| row_of(texture, 1.0));
            let normal = material.textures.normal.as_ref().map_or(0, |(texture, scale)| row_of(Some(texture), *scale));
            // 1 where vertex colours are the surface's, 2 where they are its light's.
            let colored = u32::from(material.vertex_colored) << u32::from(material.unlit);
            rows.push([base, rough, emissive, transmission]);
            rows.push([specular, specular_color, normal, colored]);
            let (cutoff, mode) = match material.alpha_mode {
                AlphaMode::Opaque => (0.0, 0.0),
                AlphaMode::Mask(cutoff) => (cutoff, 1.0),
                AlphaMode::Blend => (0.0, 2.0),
            };
            rows.push([material.base_alpha, cutoff, mode, 0.0].map(f32::to_bits));
            // Per unit of the sphere's radius.
            let sigma = material.absorption * scene.bounding_sphere().1;
            rows.push([sigma.x, sigma.y, sigma.z, 0.0].map(f32::to_bits));
        }
        if features.has_layer_rows() {
            let (sheen, anisotropy) = (material.sheen, material.anisotropy);
            let normal = material.textures.coat_normal.as_ref();
            let normal = normal.map_or(0, |(texture, scale)| row_of(Some(texture), *scale));
            let [coat, coat_roughness, sheen_color, sheen_roughness, stretch] =
                material.textures.layer_slots().map(|texture| row_of(texture, 1.0));
            let coat_alpha = coat_alpha(material, threshold);
            rows.push([material.coat_factor(), coat_alpha, anisotropy.strength, anisotropy.rotation].map(f32::to_bits));
            rows.push([sheen.color.x, sheen.color.y, sheen.color.z, sheen.roughness].map(f32::to_bits));
            rows.push([coat, coat_roughness, sheen_color, sheen_roughness]);
            rows.push([stretch, normal, 0, 0]);
        }
    }
    let mut add = |word: usize, albedo: &[f32]| {
        let table = (first_texture + textures.len()) as u32;
        for row in rows.chunks_exact_mut(rows_each) {
            row[rows_each - 1][word] = table;
        }
        textures.extend(albedo.as_chunks().0.iter().map(|entries: &[f32; 4]| entries.map(f32::to_bits)));
    };
    if features.sheen {
        add(2, &SHEEN_ALBEDO);
    }
    if features.coated {
        add(3, &COAT_ALBEDO);
    }
    (rows, textures)
}

/// Four rows as `material_at` in shaders/bsdf/material.wesl reads them.
fn pack_material(m: &Material, threshold: f32, extended: bool) -> [[u32; 4]; MATERIAL_ROWS] {
    let reflectance = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    // Where textures come in between, the shader does the rest.
    let raw = reflectance * m.specular_color;
    let f0 = if extended { raw } else { raw.min(Vec3::ONE) * m.specular };
    // A textured alpha is the roughness factor's times the texture's square; its sign and that it is no delta stay.
    let alpha = if m.alpha() > 0.0 && m.mapped_alpha.is_some() { m.roughness * m.roughness } else { m.alpha() };
    let alpha = if m.is_narrow(threshold) { -alpha } else { alpha };
    let sides = if m.emits_on_both_sides() { 2.0 } else { 1.0 };
    let thin = if m.thin { 1.0 } else { 0.0 };
    [
        [m.base_color.x, m.base_color.y, m.base_color.z, m.metallic],
        [f0.x, f0.y, f0.z, m.specular],
        [m.emission.x, m.emission.y, m.emission.z, alpha],
        [m.transmission, m.ior, thin, sides],
    ]
    .map(|row| row.map(f32::to_bits))
}

/// Alpha of the coat's lobe, negative where it is narrow; with a texture that of its factor.
fn coat_alpha(m: &Material, threshold: f32) -> f32 {
    let alpha = m.coat.roughness * m.coat.roughness;
    let alpha = if m.coat.mapped_alpha.is_some() { alpha } else { m.coat_alpha() };
    if m.coat_alpha() < threshold { -alpha } else { alpha }
}

/// Three rows as `lookup` in shaders/texture/lookup.wesl reads them: where the texels are, then the transform.
fn pack_texture(texture: &Texture, scene: &Scene, offsets: &[u32], scale: f32) -> [[u32; 4]; 3] {
    let image = &scene.images[texture.image as usize];
    let mode = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let flags = mode(texture.wrap[0])
        | mode(texture.wrap[1]) << 2
        | u32::from(texture.linear) << 4
        | u32::from(texture.srgb) << 5
        | (texture.slot as u32) << 6;
    let [a, b] = texture.transform.map(|row| row.map(f32::to_bits));
    [
        [offsets[texture.image as usize], image.width, image.height, flags],
        [a[0], a[1], a[2], scale.to_bits()],
        [b[0], b[1], b[2], 0],
    ]
}

/// First texel of every image in [`texels`].
fn image_offsets(scene: &Scene) -> Vec<u32> {
    let mut next = SRGB.len();
    let mut offsets = Vec::with_capacity(scene.images.len());
    for image in &scene.images {
        offsets.push(next as u32);
        next += image.texels.len();
    }
    offsets
}

/// The linear values of sRGB's codes, as bits, then the images one after another.
pub fn texels(scene: &Scene) -> Vec<u32> {
    SRGB.iter().map(|v| v.to_bits()).chain(scene.images.iter().flat_map(|image| image.texels.iter().copied())).collect()
}

/// What the corners of the triangles have, in leaf order: texture coordinates, a second set of them, the tangent with the
/// bitangent's sign as its lowest bit, the colour; each where `features` says so.
pub fn corners(scene: &Scene, features: Features, order: &[u32]) -> Vec<u32> {
    let mut words = Vec::new();
    if !features.textured {
        return words;
    }
    for &source in order {
        for vertex in scene.triangles[source as usize].map(|v| v as usize) {
            let coordinates = scene.coordinates.get(vertex).copied().unwrap_or([Vec2::ZERO; 2]);
            for at in &coordinates[..if features.second_coordinates { 2 } else { 1 }] {
                words.extend([at.x.to_bits(), at.y.to_bits()]);
            }
            if features.normal_mapped {
                let tangent = scene.tangents.get(vertex).copied().unwrap_or(Vec4::ZERO);
                let along = tangent.truncate().try_normalize().unwrap_or(Vec3::X);
                words.push(encode_octahedral(along) & !1 | u32::from(tangent.w < 0.0));
            }
            if features.vertex_colored {
                let color = scene.colors.get(vertex).copied().unwrap_or(Vec4::ONE);
                let unorm = |v: f32| (v.clamp(0.0, 1.0) * 65535.0).round() as u32;
                words.push(unorm(color.x) | unorm(color.y) << 16);
                words.push(unorm(color.z) | unorm(color.w) << 16);
            }
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octahedral_code_keeps_directions() {
        for i in 0..2000 {
            let (a, z) = (i as f32 * 2.399_963, 1.0 - (i as f32 + 0.5) / 1000.0);
            let r = (1.0 - z * z).sqrt();
            let n = Vec3::new(r * a.cos(), r * a.sin(), z);
            let word = encode_octahedral(n);
            let x = ((word & 0xffff) as u16 as i16) as f32 / 32767.0;
            let y = ((word >> 16) as u16 as i16) as f32 / 32767.0;
            let mut v = Vec3::new(x, y, 1.0 - x.abs() - y.abs());
            let t = (-v.z).max(0.0);
            v.x += if v.x >= 0.0 { -t } else { t };
            v.y += if v.y >= 0.0 { -t } else { t };
            assert!((v.normalize() - n).length() < 1e-4, "{n} {v}");
        }
    }
}
