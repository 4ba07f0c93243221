//! Surface materials: glTF metallic-roughness with emission, `KHR_materials_specular`, `_transmission`, `_volume` and the
//! [`layers`](super::layers) over it.

use super::layers::{Anisotropy, Clearcoat, Iridescence, Sheen};
use super::{AssetId, Texture};
use glam::{Affine2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// How the alpha channel of the base colour is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// The surface is there only where alpha is at least the cutoff.
    Mask(f32),
    /// Alpha blends over what lies behind.
    Blend,
}

/// What the inside of a solid body takes of light (`KHR_materials_volume`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// What is left of white light (linear Rec. 709) after the distance.
    pub color: Vec3,
    /// That distance \[m\]; infinite: nothing is taken.
    pub distance: f32,
}

impl Attenuation {
    /// The inside of a body that takes nothing.
    pub const NONE: Self = Self { color: Vec3::ONE, distance: f32::INFINITY };
    /// Least share that is left after the distance: a logarithm has no zero.
    const LEAST: f32 = 1e-6;

    /// Absorption coefficient σ \[1/m\]: after a way of s metres e^(−σ·s) is left (Beer and Lambert).
    pub fn absorption(&self) -> Vec3 {
        let color = self.color.clamp(Vec3::splat(Self::LEAST), Vec3::ONE);
        let absorption = color.map(|left| -left.ln()) / self.distance.max(1e-6);
        if absorption.is_finite() { absorption } else { Vec3::ZERO }
    }
}

/// A surface material (glTF 2.0, section 3.9 and appendix B). Immutable once made; to edit, make a new one.
///
/// Every factor multiplies its texture, where there is one.
#[derive(Clone, Debug)]
pub struct Material {
    /// Identity for caches: no two materials of a process share it.
    pub id: AssetId,
    /// Name for messages and the inspector.
    pub name: String,
    /// Base colour (linear Rec. 709) and alpha.
    pub base_color: Vec4,
    /// 0: dielectric, 1: metal.
    pub metallic: f32,
    /// Perceptual roughness; the GGX α is its square.
    pub roughness: f32,
    /// `KHR_materials_specular` factor; 0 makes a purely diffuse dielectric.
    pub specular: f32,
    /// `KHR_materials_specular` colour (linear).
    pub specular_color: Vec3,
    /// Emitted radiance L \[W/(m² sr)\], emissive strength included.
    pub emissive: Vec3,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// `KHR_materials_transmission`: share of the light that is neither reflected nor a metal's which passes the surface, coloured
    /// by the base colour, instead of being scattered by it. What emits light passes none.
    pub transmission: f32,
    /// Index of refraction of the inside, relative to air. 0 stands for a dielectric that reflects all light
    /// (`KHR_materials_ior`); nothing is refracted below 1.
    pub ior: f32,
    /// `KHR_materials_volume`: the surface bounds a solid body, which refracts and absorbs light. Without, it is a thin wall,
    /// which light passes straight.
    pub volume: Option<Attenuation>,
    /// `KHR_materials_dispersion`: 20 over the Abbe number of the inside; 0: all colours are refracted alike. Counts in solid
    /// bodies alone.
    pub dispersion: f32,
    /// A clear layer over all others.
    pub clearcoat: Clearcoat,
    /// Fibres that stand off the surface.
    pub sheen: Sheen,
    /// What stretches the highlights of the base.
    pub anisotropy: Anisotropy,
    /// A thin film on the base.
    pub iridescence: Iridescence,
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
    /// Shows the emission whatever the light (`KHR_materials_unlit`); vertex colours multiply it.
    pub unlit: bool,
    /// Back faces are drawn too, with the normal flipped.
    pub double_sided: bool,
    /// Base colour texture (sRGB) and alpha.
    pub base_color_texture: Option<Arc<Texture>>,
    /// Roughness in G, metallic in B (linear).
    pub metallic_roughness_texture: Option<Arc<Texture>>,
    /// Tangent-space normal map (linear).
    pub normal_texture: Option<Arc<Texture>>,
    /// Emissive texture (sRGB).
    pub emissive_texture: Option<Arc<Texture>>,
    /// `KHR_materials_specular` factor in alpha.
    pub specular_texture: Option<Arc<Texture>>,
    /// `KHR_materials_specular` colour (sRGB).
    pub specular_color_texture: Option<Arc<Texture>>,
    /// `KHR_materials_transmission` factor in red.
    pub transmission_texture: Option<Arc<Texture>>,
    /// Clear coat factor in red.
    pub clearcoat_texture: Option<Arc<Texture>>,
    /// Clear coat roughness in green.
    pub clearcoat_roughness_texture: Option<Arc<Texture>>,
    /// Normal map of the clear coat (linear).
    pub clearcoat_normal_texture: Option<Arc<Texture>>,
    /// Sheen colour (sRGB).
    pub sheen_color_texture: Option<Arc<Texture>>,
    /// Sheen roughness in alpha.
    pub sheen_roughness_texture: Option<Arc<Texture>>,
    /// Direction of the anisotropy in red and green, as a normal map has x and y; its strength in blue.
    pub anisotropy_texture: Option<Arc<Texture>>,
    /// Share of the film in red.
    pub iridescence_texture: Option<Arc<Texture>>,
    /// Thickness of the film in green, from its least to its most.
    pub iridescence_thickness_texture: Option<Arc<Texture>>,
    /// Where each texture lies on the surface.
    pub uv: UvMaps,
}

/// Where a texture lies on the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvMap {
    /// Texture coordinate set, 0 or 1.
    pub set: u32,
    /// Texture coordinates of the texture from those of the set (`KHR_texture_transform`).
    pub transform: Affine2,
}

impl UvMap {
    /// Texture coordinates in the texture, of a vertex whose two sets are given.
    pub fn apply(&self, sets: [[f32; 2]; 2]) -> [f32; 2] {
        let uv = Vec2::from(sets[usize::from(self.set == 1)]);
        if self.transform == Affine2::IDENTITY { uv.to_array() } else { self.transform.transform_point2(uv).to_array() }
    }

    /// The rows as shaders have them: u and v are their dot products with (u, v, 1); the set is the first row's w.
    pub fn rows(&self) -> [[f32; 4]; 2] {
        let (m, t) = (self.transform.matrix2, self.transform.translation);
        [[m.x_axis.x, m.y_axis.x, t.x, self.set as f32], [m.x_axis.y, m.y_axis.y, t.y, 0.0]]
    }
}

/// Where the textures of a material lie.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvMaps {
    /// Base colour.
    pub base_color: UvMap,
    /// Metallic and roughness.
    pub metallic_roughness: UvMap,
    /// Normal map.
    pub normal: UvMap,
    /// Emission.
    pub emissive: UvMap,
    /// Specular factor.
    pub specular: UvMap,
    /// Specular colour.
    pub specular_color: UvMap,
    /// Transmission.
    pub transmission: UvMap,
    /// Clear coat factor.
    pub clearcoat: UvMap,
    /// Clear coat roughness.
    pub clearcoat_roughness: UvMap,
    /// Normal map of the clear coat.
    pub clearcoat_normal: UvMap,
    /// Sheen colour.
    pub sheen_color: UvMap,
    /// Sheen roughness.
    pub sheen_roughness: UvMap,
    /// Anisotropy.
    pub anisotropy: UvMap,
    /// Share of the film.
    pub iridescence: UvMap,
    /// Thickness of the film.
    pub iridescence_thickness: UvMap,
}

impl UvMaps {
    /// All of them, in the order of [`Material::textures`].
    pub(crate) fn all_mut(&mut self) -> [&mut UvMap; TEXTURE_COUNT] {
        [
            &mut self.base_color,
            &mut self.metallic_roughness,
            &mut self.normal,
            &mut self.emissive,
            &mut self.specular,
            &mut self.specular_color,
            &mut self.transmission,
            &mut self.clearcoat,
            &mut self.clearcoat_roughness,
            &mut self.clearcoat_normal,
            &mut self.sheen_color,
            &mut self.sheen_roughness,
            &mut self.anisotropy,
            &mut self.iridescence,
            &mut self.iridescence_thickness,
        ]
    }
}

/// Number of textures of a material.
#[doc(hidden)]
pub const TEXTURE_COUNT: usize = 15;

impl Material {
    /// A white, rough, opaque dielectric with the glTF default of a 4 % reflection at normal incidence.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            id: AssetId::fresh(),
            name: name.into(),
            base_color: Vec4::ONE,
            metallic: 0.0,
            roughness: 1.0,
            specular: 1.0,
            specular_color: Vec3::ONE,
            emissive: Vec3::ZERO,
            normal_scale: 1.0,
            transmission: 0.0,
            ior: 1.5,
            volume: None,
            dispersion: 0.0,
            clearcoat: Clearcoat::default(),
            sheen: Sheen::default(),
            anisotropy: Anisotropy::default(),
            iridescence: Iridescence::default(),
            alpha_mode: AlphaMode::Opaque,
            unlit: false,
            double_sided: false,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
            specular_texture: None,
            specular_color_texture: None,
            transmission_texture: None,
            clearcoat_texture: None,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            sheen_color_texture: None,
            sheen_roughness_texture: None,
            anisotropy_texture: None,
            iridescence_texture: None,
            iridescence_thickness_texture: None,
            uv: UvMaps::default(),
        }
    }

    /// All textures and where they lie, in the order in which shaders have them.
    #[doc(hidden)]
    pub fn textures(&self) -> [(Option<&Arc<Texture>>, UvMap); TEXTURE_COUNT] {
        [
            (self.base_color_texture.as_ref(), self.uv.base_color),
            (self.metallic_roughness_texture.as_ref(), self.uv.metallic_roughness),
            (self.normal_texture.as_ref(), self.uv.normal),
            (self.emissive_texture.as_ref(), self.uv.emissive),
            (self.specular_texture.as_ref(), self.uv.specular),
            (self.specular_color_texture.as_ref(), self.uv.specular_color),
            (self.transmission_texture.as_ref(), self.uv.transmission),
            (self.clearcoat_texture.as_ref(), self.uv.clearcoat),
            (self.clearcoat_roughness_texture.as_ref(), self.uv.clearcoat_roughness),
            (self.clearcoat_normal_texture.as_ref(), self.uv.clearcoat_normal),
            (self.sheen_color_texture.as_ref(), self.uv.sheen_color),
            (self.sheen_roughness_texture.as_ref(), self.uv.sheen_roughness),
            (self.anisotropy_texture.as_ref(), self.uv.anisotropy),
            (self.iridescence_texture.as_ref(), self.uv.iridescence),
            (self.iridescence_thickness_texture.as_ref(), self.uv.iridescence_thickness),
        ]
    }

    /// The textures of the layers.
    #[doc(hidden)]
    pub fn layer_textures(&self) -> [&Option<Arc<Texture>>; 8] {
        [
            &self.clearcoat_texture,
            &self.clearcoat_roughness_texture,
            &self.clearcoat_normal_texture,
            &self.sheen_color_texture,
            &self.sheen_roughness_texture,
            &self.anisotropy_texture,
            &self.iridescence_texture,
            &self.iridescence_thickness_texture,
        ]
    }

    /// [`UvMap::rows`] of all textures. The last word of the emission's says whether it takes vertex colours.
    #[doc(hidden)]
    pub fn uv_rows(&self) -> [[f32; 4]; 2 * TEXTURE_COUNT] {
        let rows = self.textures().map(|(_, map)| map.rows());
        let mut rows: [[f32; 4]; 2 * TEXTURE_COUNT] = std::array::from_fn(|i| rows[i / 2][i % 2]);
        rows[7][3] = f32::from(u8::from(self.unlit));
        rows
    }

    /// Whether every point of the surface stops every ray: it is neither of glass nor has an alpha that counts.
    pub fn is_opaque(&self) -> bool {
        self.alpha_mode == AlphaMode::Opaque && !self.is_glass()
    }

    /// Whether light passes the surface without being scattered by it.
    pub fn is_glass(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0 && self.emissive == Vec3::ZERO
    }

    /// Whether there is a lobe beside that of the base which frames draw apart: of a clear coat, or a stretched one in its place.
    #[doc(hidden)]
    pub fn has_second_lobe(&self) -> bool {
        let is_any = self.clearcoat.factor > 0.0 || self.anisotropy.strength > 0.0;
        is_any && !self.unlit && !self.is_see_through()
    }

    /// Whether there is anything beyond the metallic-roughness base that is opaque: a clear coat, sheen, a film or anisotropy.
    pub fn has_layers(&self) -> bool {
        let has_sheen = self.sheen.color.max_element() > 0.0;
        let is_stretched = self.anisotropy.strength > 0.0;
        let has_film = self.iridescence.factor > 0.0;
        !self.unlit
            && (has_film || (self.clearcoat.factor > 0.0 || has_sheen || is_stretched) && !self.is_see_through())
    }

    /// What the layers make of the diffuse reflection of even light: what they leave of the base's, and the sheen's own.
    /// `coat` and `sheen` are what textures leave of the factor and the colour.
    #[doc(hidden)]
    pub fn even_layers(&self, coat: f32, sheen: Vec3) -> (f32, Vec3) {
        if !self.has_layers() || self.is_see_through() {
            return (1.0, Vec3::ZERO);
        }
        let above = 1.0 - self.clearcoat.mean_reflectance() * coat.clamp(0.0, 1.0);
        let color = (self.sheen.color * sheen).clamp(Vec3::ZERO, Vec3::ONE);
        let albedo = self.sheen.mean_albedo();
        (above * (1.0 - color.max_element() * albedo), color * (above * albedo))
    }

    /// Whether what lies behind shows through the surface: it has no layers but a film.
    #[doc(hidden)]
    pub fn is_see_through(&self) -> bool {
        self.is_glass() || self.alpha_mode == AlphaMode::Blend
    }

    /// Whether all textures lie by the first set as it is, and all are those of the metallic-roughness base: what shaders do
    /// faster.
    #[doc(hidden)]
    pub fn is_plain(&self) -> bool {
        let textures = self.textures();
        textures.iter().all(|(texture, map)| texture.is_none() || *map == UvMap::default())
            && textures[4..].iter().all(|(texture, _)| texture.is_none())
    }

    /// Reflectance at normal incidence where the surface is no metal, in units of 4 %: its specular colour by what follows from
    /// its index of refraction, F0 = ((n − 1)/(n + 1))², which is 4 % for 1.5 (`KHR_materials_ior`).
    pub fn dielectric_reflectance(&self) -> Vec3 {
        if self.ior == 1.5 {
            return self.specular_color;
        }
        let color = self.specular_color * (((self.ior - 1.0) / (self.ior + 1.0)).powi(2) / 0.04);
        color.max(Vec3::ZERO).min(Vec3::splat(25.0))
    }

    /// A purely diffuse (Lambert) material of the given linear reflectance.
    pub fn diffuse(name: impl Into<String>, albedo: Vec3) -> Self {
        Self { base_color: albedo.extend(1.0), specular: 0.0, ..Self::new(name) }
    }
}
