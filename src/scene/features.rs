//! What a scene needs, and so what is compiled into its shaders: untaken branches cost full price on software Vulkan.

use super::Scene;

/// One flag per optional part of the shaders; each is a condition of the same name there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Features {
    /// Some material has a GGX lobe with a density (alpha at least [`DELTA_ALPHA`]).
    pub glossy: bool,
    /// Some material has a delta reflection: smooth metal, smooth coat, or glass.
    pub mirror: bool,
    /// Some material has a delta transmission.
    pub glass: bool,
    /// Some material has a GGX lobe in transmission.
    pub rough_glass: bool,
    /// Light comes from a uniform sky, and from nothing else.
    pub sky: bool,
}

impl Features {
    /// The features that the materials and lights of `scene` use.
    pub fn of(scene: &Scene) -> Self {
        let mut features = Self { sky: scene.sky.is_some(), ..Self::default() };
        let mut used = vec![false; scene.materials.len()];
        for &m in &scene.triangle_materials {
            used[m as usize] = true;
        }
        for (material, _) in scene.materials.iter().zip(&used).filter(|(_, used)| **used) {
            let smooth = material.alpha() == 0.0;
            let transmits = material.transmission > 0.0;
            let specular = material.metallic > 0.0 || material.specular > 0.0 || transmits;
            features.glass |= transmits && smooth;
            features.rough_glass |= transmits && !smooth;
            features.mirror |= specular && smooth;
            features.glossy |= specular && !smooth;
        }
        features
    }

    /// Every flag with its name, as the shaders call it.
    pub fn flags(&self) -> [(&'static str, bool); 5] {
        [
            ("glossy", self.glossy),
            ("mirror", self.mirror),
            ("glass", self.glass),
            ("rough_glass", self.rough_glass),
            ("sky", self.sky),
        ]
    }
}
