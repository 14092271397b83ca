//! Surface materials in glTF's own parameters.

use glam::Vec3;

use super::texture::Texture;

/// Below this GGX alpha (= roughness^2) a lobe is treated as a delta (METHOD.md section 6, item 1).
pub const DELTA_ALPHA: f32 = 1e-3;
/// Solid glass of less index contrast than this deflects nothing, however rough: its boundary is rendered smooth, since
/// directions on its two sides no longer tell the half-vector.
pub const DELTA_CONTRAST: f32 = 1e-3;

/// Below this alpha a lobe is of the same classes as a delta, unless a caller says otherwise (METHOD.md 2.7): connections
/// to it fail mostly, and perturbations pass it well by keeping its half-vector. Results do not depend on it.
pub const GLOSSY_AS_SPECULAR_ALPHA: f32 = 0.1;

/// glTF 2.0 metallic-roughness with the extensions the renderer knows. Colours are linear Rec.709.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub name: String,
    pub base_color: Vec3,
    pub metallic: f32,
    /// Perceptual roughness; alpha = roughness^2.
    pub roughness: f32,
    /// KHR_materials_ior, 1.5 by default.
    pub ior: f32,
    /// KHR_materials_specular: specularFactor; 0 with metallic 0 makes the material exactly Lambertian.
    pub specular: f32,
    /// KHR_materials_specular: specularColorFactor.
    pub specular_color: Vec3,
    /// KHR_materials_transmission: transmissionFactor; glass where above 0.
    pub transmission: f32,
    /// Transmission without refraction (KHR_materials_volume: thicknessFactor 0).
    pub thin: bool,
    /// KHR_materials_volume: absorption coefficient inside solid glass, per unit of the file.
    pub absorption: Vec3,
    /// Radiance: emissiveFactor * emissiveStrength.
    pub emission: Vec3,
    /// A camera sees it from both sides, and it emits on both; it reflects on both in any case.
    pub double_sided: bool,
    /// The base colour's fourth component, and what it means; opaque where there is glass.
    pub base_alpha: f32,
    pub alpha_mode: AlphaMode,
    /// Multiplied by the vertices' colours (COLOR_0).
    pub vertex_colored: bool,
    /// KHR_materials_unlit: the colour, textures and vertex colours included, is the radiance in all directions, and
    /// nothing is scattered.
    pub unlit: bool,
    /// KHR_materials_clearcoat.
    pub coat: Coat,
    pub sheen: Sheen,
    pub anisotropy: Anisotropy,
    pub textures: Textures,
    /// Mean and largest GGX alpha over the texels of the roughness texture, where there is one.
    pub mapped_alpha: Option<[f32; 2]>,
}

/// A clear layer over a material (KHR_materials_clearcoat).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coat {
    /// How much of it there is, 0 to 1.
    pub factor: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Mean GGX alpha over the texels of its roughness texture, where there is one.
    pub mapped_alpha: Option<f32>,
}

/// Fibres on a material (KHR_materials_sheen).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sheen {
    /// Black where there is none.
    pub color: Vec3,
    /// Perceptual roughness.
    pub roughness: f32,
}

/// Facets whose normals spread in one direction more than in the other (KHR_materials_anisotropy).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Anisotropy {
    /// 0, not at all, to 1.
    pub strength: f32,
    /// Of the direction in which they spread more, from the tangent towards the bitangent, in radians.
    pub rotation: f32,
}

/// What a material's alpha means (glTF 2.0, section 3.9.4).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    #[default]
    Opaque,
    /// There is nothing where alpha is below this.
    Mask(f32),
    /// Alpha is the share of the light behind that is covered.
    Blend,
}

/// The textures of a material, each multiplied with the factor of its name at every point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Textures {
    /// RGB: base colour; A: alpha.
    pub base_color: Option<Texture>,
    /// G: roughness; B: metallic.
    pub metallic_roughness: Option<Texture>,
    pub emissive: Option<Texture>,
    /// Tangent-space normals, with the scale of x and y.
    pub normal: Option<(Texture, f32)>,
    /// R: transmission.
    pub transmission: Option<Texture>,
    /// A: specular.
    pub specular: Option<Texture>,
    pub specular_color: Option<Texture>,
    /// R: how much of the coat there is.
    pub coat: Option<Texture>,
    /// G: the coat's roughness.
    pub coat_roughness: Option<Texture>,
    /// As `normal`.
    pub coat_normal: Option<(Texture, f32)>,
    /// RGB: the sheen's colour.
    pub sheen_color: Option<Texture>,
    /// A: the sheen's roughness.
    pub sheen_roughness: Option<Texture>,
    /// RG: the direction of anisotropy; B: its strength.
    pub anisotropy: Option<Texture>,
}

impl Textures {
    /// Those of the material itself but the normals, in the order of `SLOT_*` in shaders/bsdf/material.wesl.
    pub fn slots(&self) -> [Option<&Texture>; 6] {
        [
            &self.base_color,
            &self.metallic_roughness,
            &self.emissive,
            &self.transmission,
            &self.specular,
            &self.specular_color,
        ]
        .map(Option::as_ref)
    }

    /// Those of its layers but the normals, and of anisotropy, in the order that follows there.
    pub fn layer_slots(&self) -> [Option<&Texture>; 5] {
        [&self.coat, &self.coat_roughness, &self.sheen_color, &self.sheen_roughness, &self.anisotropy]
            .map(Option::as_ref)
    }

    /// Normals, of the material and of its coat.
    pub fn normals(&self) -> impl Iterator<Item = &Texture> {
        [&self.normal, &self.coat_normal].into_iter().flatten().map(|(texture, _)| texture)
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &Texture> {
        self.slots().into_iter().chain(self.layer_slots()).flatten().chain(self.normals())
    }
}

impl Default for Material {
    /// glTF's default material: white, fully metallic, fully rough.
    fn default() -> Self {
        Self {
            name: "default".into(),
            base_color: Vec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            thin: true,
            absorption: Vec3::ZERO,
            emission: Vec3::ZERO,
            double_sided: false,
            base_alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            vertex_colored: false,
            unlit: false,
            coat: Coat::default(),
            sheen: Sheen::default(),
            anisotropy: Anisotropy::default(),
            textures: Textures::default(),
            mapped_alpha: None,
        }
    }
}

impl Material {
    /// GGX alpha of the specular lobes (glTF 2.0, appendix B: roughness^2); 0 where they are deltas.
    ///
    /// A roughness texture makes no difference to what a lobe is taken for: that must be the same at every point of a
    /// material. It is the mean alpha over the texels that counts here, and the lobes are deltas only if all texels are
    /// that smooth; else no point has an alpha below [`DELTA_ALPHA`]. Neither has one under a coat, whose lobe is none (a
    /// class of reflections is a delta or a lobe, not both), or an anisotropic one.
    pub fn alpha(&self) -> f32 {
        let flat = self.roughness * self.roughness;
        let [mean, most] = self.mapped_alpha.unwrap_or([flat; 2]);
        let delta = most < DELTA_ALPHA && self.coat_factor() == 0.0 && self.anisotropy.strength == 0.0;
        if delta || self.is_matched() { 0.0 } else { mean.max(DELTA_ALPHA) }
    }

    /// Whether it is solid glass whose boundary cannot be rough.
    fn is_matched(&self) -> bool {
        self.transmission > 0.0 && !self.thin && self.ior - 1.0 < DELTA_CONTRAST
    }

    /// How much coat there is; none on glass whose boundary has to be smooth.
    pub fn coat_factor(&self) -> f32 {
        if self.is_matched() { 0.0 } else { self.coat.factor }
    }

    /// GGX alpha of the coat's lobe, at least [`DELTA_ALPHA`]; as for [`Material::alpha`], it is the mean that counts.
    pub fn coat_alpha(&self) -> f32 {
        self.coat.mapped_alpha.unwrap_or(self.coat.roughness * self.coat.roughness).max(DELTA_ALPHA)
    }

    /// Whether it has a specular lobe at all, delta or not.
    pub fn is_specular(&self) -> bool {
        self.metallic > 0.0 || self.specular > 0.0 || self.transmission > 0.0
    }

    /// Whether it has a lobe that is treated as specular for being narrower than `threshold`.
    pub fn is_narrow(&self, threshold: f32) -> bool {
        // Of the two alphas of anisotropy, the geometric mean.
        let along = self.alpha() + (1.0 - self.alpha()) * self.anisotropy.strength.powi(2);
        self.is_specular() && self.alpha() > 0.0 && (self.alpha() * along).sqrt() < threshold
    }

    /// Whether it is the same at every point of a triangle.
    pub fn is_plain(&self) -> bool {
        !self.vertex_colored && self.anisotropy.strength == 0.0 && self.textures.all().next().is_none()
    }

    /// Which of the vertices' coordinates its tangents follow; None where it needs no tangents.
    pub fn tangent_slot(&self) -> Option<usize> {
        let anisotropic =
            (self.anisotropy.strength > 0.0).then(|| self.textures.anisotropy.as_ref().map_or(0, |t| t.slot));
        self.textures.normals().next().map(|texture| texture.slot).or(anisotropic)
    }

    /// Whether there is nothing of it anywhere: alpha is below the mask's cutoff, and the same at all points.
    pub fn is_masked_out(&self) -> bool {
        matches!(self.alpha_mode, AlphaMode::Mask(cutoff) if self.base_alpha < cutoff)
    }

    /// Whether it emits otherwise from place to place.
    pub fn has_uneven_emission(&self) -> bool {
        self.emits() && (self.textures.emissive.is_some() || (self.unlit && self.vertex_colored))
    }

    /// Whether its light goes to both sides; an unlit surface's always does.
    pub fn emits_on_both_sides(&self) -> bool {
        self.double_sided || self.unlit
    }

    /// Whether triangles of this material are lights.
    pub fn emits(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}
