//! What a scene needs, and so what is compiled into its shaders: untaken branches cost full price on software Vulkan.

use glam::Vec3;

use super::light::LightKind;
use super::material::{AlphaMode, GLOSSY_AS_SPECULAR_ALPHA};
use super::{Camera, Scene};

/// The most triangles whose corners and edges, 48 bytes each, lie in one buffer: 128 MiB are what every device binds.
pub const SPLIT_TRIANGLES: usize = (128 << 20) / 48;

/// One flag per optional part of the shaders; each is a condition of the same name there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Features {
    /// Some material has a GGX lobe among what is connected to.
    pub glossy: bool,
    /// Some material reflects specularly, by a delta or a narrow lobe: smooth metal, smooth coat, or glass.
    pub mirror: bool,
    /// Some material transmits specularly, by a delta or a narrow lobe.
    pub glass: bool,
    /// Some material has a GGX lobe in transmission among what is connected to.
    pub rough_glass: bool,
    /// Some specular lobe is not a delta but narrow ([`GLOSSY_AS_SPECULAR_ALPHA`]).
    pub narrow: bool,
    /// The camera is orthographic; not known from the scene, which may have several.
    pub orthographic: bool,
    /// The camera has a lens of some width; likewise.
    pub aperture: bool,
    /// The camera faces backs that it does not see; likewise.
    pub culled: bool,
    /// There are more triangles than one buffer need hold ([`SPLIT_TRIANGLES`]).
    pub split: bool,
    /// Light comes from infinitely far: from a sky, an environment or a direction.
    pub sky: bool,
    /// Other light than that of emissive triangles alone, or of a uniform sky alone.
    pub mixed: bool,
    /// The sky is an image.
    pub environment: bool,
    /// Some material has a texture, or is multiplied by vertex colours.
    pub textured: bool,
    /// Some texture uses a second set of coordinates.
    pub second_coordinates: bool,
    /// Some material has a normal texture.
    pub normal_mapped: bool,
    /// Some material is multiplied by vertex colours.
    pub vertex_colored: bool,
    /// Some emissive material has an emissive texture.
    pub emission_mapped: bool,
    /// Some unlit material is multiplied by vertex colours.
    pub emission_colored: bool,
    /// Some material is there in places only (alphaMode MASK).
    pub masked: bool,
    /// Some material covers in part what lies behind (alphaMode BLEND).
    pub blended: bool,
    /// Some solid glass absorbs light inside.
    pub absorbing: bool,
    /// Some material has a clear coat.
    pub coated: bool,
    /// Some material has sheen.
    pub sheen: bool,
    /// Some material is anisotropic.
    pub anisotropic: bool,
}

impl Scene {
    /// Below which GGX alpha lobes are treated as specular, where that is wanted below `threshold`. Under points, spots and
    /// directions no lobe is: what only specular vertices lie between such a light and the camera cannot be connected, nor
    /// is the light ever hit, and a highlight in a narrow lobe is no delta that would be black for everyone.
    pub fn specular_threshold(&self, threshold: f32) -> f32 {
        if self.lights.is_empty() { threshold } else { 0.0 }
    }
}

impl Features {
    /// The features that the materials and lights of `scene` use.
    pub fn of(scene: &Scene) -> Self {
        Self::with_threshold(scene, GLOSSY_AS_SPECULAR_ALPHA)
    }

    /// The same where lobes with alpha below `threshold` are treated as specular, if `scene` allows.
    pub fn with_threshold(scene: &Scene, threshold: f32) -> Self {
        let threshold = scene.specular_threshold(threshold);
        let directions = scene.lights.iter().any(|light| matches!(light.kind, LightKind::Directional { .. }));
        let environment = scene.environment.is_some();
        let mut features = Self {
            split: scene.triangles.len() > SPLIT_TRIANGLES,
            sky: scene.sky.is_some() || environment || directions,
            mixed: environment || !scene.lights.is_empty(),
            environment,
            ..Self::default()
        };
        let mut used = vec![false; scene.materials.len()];
        for &m in &scene.triangle_materials {
            used[m as usize] = true;
        }
        for (material, _) in scene.materials.iter().zip(&used).filter(|(_, used)| **used) {
            let narrow = material.is_narrow(threshold);
            let smooth = narrow || material.alpha() == 0.0;
            let transmits = material.transmission > 0.0;
            let specular = material.is_specular();
            features.narrow |= narrow;
            features.glass |= transmits && smooth;
            features.rough_glass |= transmits && !smooth;
            features.mirror |= specular && smooth;
            features.glossy |= specular && !smooth;
            features.textured |= !material.is_plain();
            features.second_coordinates |= material.textures.all().any(|texture| texture.slot > 0);
            features.normal_mapped |= material.tangent_slot().is_some();
            features.vertex_colored |= material.vertex_colored;
            features.absorbing |= transmits && !material.thin && material.absorption != Vec3::ZERO;
            features.sheen |= material.sheen.color != Vec3::ZERO;
            features.anisotropic |= material.anisotropy.strength > 0.0 && material.alpha() > 0.0;
            if material.coat_factor() > 0.0 {
                let narrow = material.coat_alpha() < threshold;
                features.coated = true;
                features.narrow |= narrow;
                features.mirror |= narrow;
                features.glossy |= !narrow;
            }
            // An alpha that is the same everywhere is decided at import.
            features.masked |= matches!(material.alpha_mode, AlphaMode::Mask(_)) && !material.is_plain();
            if material.alpha_mode == AlphaMode::Blend {
                // Light goes past a surface as it goes through glass, as a delta.
                features.blended = true;
                features.mirror = true;
                features.glass = true;
            }
            features.emission_mapped |= material.has_uneven_emission();
            features.emission_colored |= material.emits() && material.unlit && material.vertex_colored;
        }
        features
    }

    /// The same for what `camera` sees of `scene`.
    pub fn seen_by(self, scene: &Scene, camera: &Camera) -> Self {
        let (orthographic, aperture) = (camera.orthographic_height.is_some(), camera.lens.is_some());
        Self { orthographic, aperture, culled: scene.has_culled_back(camera), ..self }
    }

    /// Whether materials have more than factors: rows of textures and coverage.
    pub fn extended(&self) -> bool {
        self.textured || self.masked || self.blended || self.absorbing || self.has_layer_rows()
    }

    /// Whether some material has a layer over it.
    pub fn layered(&self) -> bool {
        self.coated || self.sheen
    }

    /// Whether materials have rows for layers and anisotropy.
    pub fn has_layer_rows(&self) -> bool {
        self.layered() || self.anisotropic
    }

    /// Every flag with its name, as the shaders call it.
    pub fn flags(&self) -> [(&'static str, bool); 27] {
        [
            ("glossy", self.glossy),
            ("mirror", self.mirror),
            ("glass", self.glass),
            ("rough_glass", self.rough_glass),
            ("narrow", self.narrow),
            ("orthographic", self.orthographic),
            ("aperture", self.aperture),
            ("culled", self.culled),
            ("split", self.split),
            ("sky", self.sky),
            ("mixed", self.mixed),
            ("environment", self.environment),
            ("textured", self.textured),
            ("second_coordinates", self.second_coordinates),
            ("normal_mapped", self.normal_mapped),
            ("vertex_colored", self.vertex_colored),
            ("emission_mapped", self.emission_mapped),
            ("emission_colored", self.emission_colored),
            ("masked", self.masked),
            ("blended", self.blended),
            ("absorbing", self.absorbing),
            ("coated", self.coated),
            ("sheen", self.sheen),
            ("anisotropic", self.anisotropic),
            ("layered", self.layered()),
            ("layer_rows", self.has_layer_rows()),
            ("extended", self.extended()),
        ]
    }
}
