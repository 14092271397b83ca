//! What the import leaves out, collected while it runs and said once per feature.

use std::collections::{BTreeMap, BTreeSet};

/// Something in a file that is not rendered as the file asks. The order is the order of the warnings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// Materials with a texture whose image is in no format that is read.
    UnreadImage,
    /// Materials whose textures use more sets of coordinates than vertices keep.
    ManyCoordinates,
    /// Materials.
    GlassAlpha,
    /// Materials with an extension of this name.
    MaterialExtension(&'static str),
    /// Meshes.
    PointsOrLines,
}

/// Extensions that add something to a material that the renderer does not have yet, and what they add.
pub const MATERIAL_EXTENSIONS: [(&str, &str); 4] = [
    ("KHR_materials_diffuse_transmission", "Diffuse transmission"),
    ("KHR_materials_dispersion", "Dispersion"),
    ("KHR_materials_iridescence", "Iridescence"),
    ("KHR_materials_subsurface", "Subsurface scattering"),
];

/// Which elements each feature concerns.
#[derive(Default)]
pub struct Notes {
    seen: BTreeMap<Feature, BTreeSet<usize>>,
    /// Triangles dropped because they have no area.
    pub flat_triangles: u64,
}

impl Notes {
    /// Notes that element `index` (of the kind the feature counts) has the feature.
    pub fn add(&mut self, feature: Feature, index: usize) {
        self.seen.entry(feature).or_default().insert(index);
    }

    /// One sentence per feature.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        for (&feature, elements) in &self.seen {
            let n = elements.len();
            let materials = counted(n as u64, "material");
            let meshes = counted(n as u64, "mesh");
            let sentence = match feature {
                Feature::UnreadImage => {
                    format!("Images other than PNG, JPEG and WebP are not read: {materials} without such textures.")
                }
                Feature::ManyCoordinates => {
                    format!(
                        "More than two sets of texture coordinates for one material are not supported: {materials} \
                         without some textures."
                    )
                }
                Feature::GlassAlpha => {
                    format!("Alpha blending of glass (alphaMode BLEND with transmission) is ignored in {materials}.")
                }
                Feature::MaterialExtension(name) => {
                    let what = MATERIAL_EXTENSIONS.iter().find(|(key, _)| *key == name).map_or(name, |(_, what)| what);
                    format!("{what} ({name}) is not supported yet: left out of {materials}.")
                }
                Feature::PointsOrLines => {
                    format!("Points and lines are not rendered: left out of {meshes}.")
                }
            };
            sentences.push(sentence);
        }
        if self.flat_triangles > 0 {
            sentences.push(format!("{} without area left out.", counted(self.flat_triangles, "triangle")));
        }
        sentences
    }
}

/// "1 mesh", "2 meshes".
fn counted(n: u64, noun: &str) -> String {
    let plural = if noun.ends_with('h') { "es" } else { "s" };
    format!("{n} {noun}{}", if n == 1 { "" } else { plural })
}
