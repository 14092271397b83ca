//! References to textures in the file's materials: sampler, image, coordinates and their transform.

use std::collections::HashMap;

use gltf::json::Value;

use super::file::File;
use super::notes::{Feature, Notes};
use crate::scene::texture::{IDENTITY, Image, Texture, Wrap};

/// Most texels of a scene: 128 MiB, which every device binds, less the table of sRGB's codes.
pub const MAX_TEXELS: usize = (1 << 25) - 256;
/// Sets of coordinates that the textures of one material may use.
const SLOTS: usize = 2;

/// The images that materials use, each decoded once.
#[derive(Default)]
pub struct Images {
    pub images: Vec<Image>,
    /// Index into `images` of the file's images; None for those that cannot be read.
    known: HashMap<usize, Option<u32>>,
}

/// What reads the textures of one material.
pub struct Reader<'a> {
    pub file: &'a File,
    pub images: &'a mut Images,
    pub notes: &'a mut Notes,
    /// Index of the material.
    pub material: usize,
    /// The file's sets of coordinates (TEXCOORD_n) in use so far, by slot.
    pub sets: Vec<u32>,
}

impl Reader<'_> {
    /// The texture that `info` (a glTF textureInfo at `path` inside the material) names; None where there is none or it
    /// cannot be read, which is noted.
    pub fn texture(&mut self, info: Option<&Value>, path: &str, srgb: bool) -> Result<Option<Texture>, String> {
        let Some(info) = info.filter(|info| info.is_object()) else {
            return Ok(None);
        };
        let again = |why: String| format!("{path}{why}: export the file again");
        let whole = |value: Option<&Value>| value.and_then(Value::as_u64).and_then(|v| usize::try_from(v).ok());
        let Some(index) = whole(info.get("index")) else {
            return Err(again(".index is missing".into()));
        };
        let Some(texture) = self.file.raw("textures").get(index) else {
            return Err(again(format!(".index names textures[{index}], which does not exist")));
        };
        let webp = texture.pointer("/extensions/EXT_texture_webp/source");
        let Some(source) = whole(webp.or(texture.get("source"))) else {
            self.notes.add(Feature::UnreadImage, self.material);
            return Ok(None);
        };
        let Some(image) = self.image(source).map_err(|why| format!("{path}: {why}"))? else {
            self.notes.add(Feature::UnreadImage, self.material);
            return Ok(None);
        };
        let transform = info.pointer("/extensions/KHR_texture_transform");
        let set = transform.and_then(|t| t.get("texCoord")).or(info.get("texCoord"));
        let Some(slot) = self.slot(set.and_then(Value::as_u64).unwrap_or(0) as u32) else {
            self.notes.add(Feature::ManyCoordinates, self.material);
            return Ok(None);
        };
        let sampler = whole(texture.get("sampler")).and_then(|s| self.file.raw("samplers").get(s));
        let setting = |name| sampler.and_then(|s| s.get(name)).and_then(Value::as_u64);
        let wrap = |name| match setting(name) {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let transform = transform.map_or(IDENTITY, matrix);
        if !transform.as_flattened().iter().all(|v| v.is_finite()) {
            return Err(again(".extensions.KHR_texture_transform is not finite".into()));
        }
        Ok(Some(Texture {
            image,
            srgb,
            linear: setting("magFilter") != Some(9728),
            wrap: [wrap("wrapS"), wrap("wrapT")],
            slot,
            transform,
        }))
    }

    fn image(&mut self, source: usize) -> Result<Option<u32>, String> {
        if let Some(known) = self.images.known.get(&source) {
            return Ok(*known);
        }
        let decoded = self.file.image(source)?;
        let index = decoded.map(|image| {
            self.images.images.push(image);
            self.images.images.len() as u32 - 1
        });
        self.images.known.insert(source, index);
        Ok(index)
    }

    /// Where the vertices keep the file's set of coordinates `set`.
    fn slot(&mut self, set: u32) -> Option<usize> {
        let known = self.sets.iter().position(|s| *s == set);
        if known.is_none() && self.sets.len() < SLOTS {
            self.sets.push(set);
            return Some(self.sets.len() - 1);
        }
        known
    }
}

/// Rows of the matrix that KHR_texture_transform defines: translation * rotation * scale.
fn matrix(transform: &Value) -> [[f32; 3]; 2] {
    let pair = |key: &str, default: f64| {
        let at = |i: usize| transform.get(key).and_then(|v| v.get(i)).and_then(Value::as_f64).unwrap_or(default);
        [at(0), at(1)]
    };
    let ([x, y], [width, height]) = (pair("offset", 0.0), pair("scale", 1.0));
    let (sine, cosine) = transform.get("rotation").and_then(Value::as_f64).unwrap_or(0.0).sin_cos();
    [[cosine * width, sine * height, x], [-sine * width, cosine * height, y]].map(|row| row.map(|v| v as f32))
}

impl Images {
    /// Halves the largest images until all fit; returns how many were.
    pub fn fit(&mut self, is_srgb: impl Fn(u32) -> bool) -> usize {
        let mut halved = vec![false; self.images.len()];
        while self.images.iter().map(|image| image.texels.len()).sum::<usize>() > MAX_TEXELS {
            let sizes = self.images.iter().enumerate().map(|(i, image)| (image.texels.len(), i));
            let Some((size, largest)) = sizes.max() else { break };
            // So many images of a texel each are beyond help; the device will refuse them.
            if size == 1 {
                break;
            }
            halved[largest] = true;
            self.images[largest] = self.images[largest].halved(is_srgb(largest as u32));
        }
        halved.iter().filter(|h| **h).count()
    }
}
