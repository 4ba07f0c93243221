//! Surface materials: glTF metallic-roughness with `KHR_materials_specular` and emission.

use super::{AssetId, Texture};
use glam::{Vec3, Vec4};
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
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
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
}

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
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
        }
    }

    /// A purely diffuse (Lambert) material of the given linear reflectance.
    pub fn diffuse(name: impl Into<String>, albedo: Vec3) -> Self {
        Self { base_color: albedo.extend(1.0), specular: 0.0, ..Self::new(name) }
    }
}
