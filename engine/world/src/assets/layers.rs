//! Layers of a surface beyond the metallic-roughness base: a clear coat, sheen, a film, and what stretches highlights. All are
//! those of glTF's extensions of these names.

use glam::Vec3;

/// A thin clear layer over the surface, as on car paint (`KHR_materials_clearcoat`). Its index of refraction is 1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearcoat {
    /// Share of the surface that it covers, 0 to 1; 0: there is none.
    pub factor: f32,
    /// Its perceptual roughness.
    pub roughness: f32,
    /// Scale of its own normal map's x and y. Without a map it is as smooth as the mesh, whatever the base's map says.
    pub normal_scale: f32,
}

impl Default for Clearcoat {
    fn default() -> Self {
        Self { factor: 0.0, roughness: 0.0, normal_scale: 1.0 }
    }
}

impl Clearcoat {
    /// Share of even light from all around that it reflects: the mean of Schlick's term of 4 %, 0.04 + 0.96/21.
    #[doc(hidden)]
    pub fn mean_reflectance(&self) -> f32 {
        const SMOOTH: f32 = 0.04 + 0.96 / 21.0;
        if self.factor.is_finite() { SMOOTH * self.factor.clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Fibres that stand off the surface, as of cloth and velvet (`KHR_materials_sheen`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Colour of their reflection (linear Rec. 709); black: there are none.
    pub color: Vec3,
    /// Perceptual roughness: how far the fibres stand apart. Below [`Sheen::LEAST_ROUGHNESS`] it is taken as that.
    pub roughness: f32,
}

impl Sheen {
    /// Least roughness: below, the lobe reflects more light at grazing angles than arrives (Estevez and Kulla 2017 fit its
    /// shadowing for rough cloth).
    pub const LEAST_ROUGHNESS: f32 = 0.3;

    /// Share of even light from all around that white sheen of this roughness reflects: a fit to the integral of its lobe over
    /// both directions, within 0.001.
    #[doc(hidden)]
    pub fn mean_albedo(&self) -> f32 {
        let r = if self.roughness.is_finite() { self.roughness.clamp(Self::LEAST_ROUGHNESS, 1.0) } else { 1.0 };
        0.047_41 + r * (-0.155_74 + r * (0.973_62 - 0.566_28 * r))
    }
}

/// Highlights that are longer across than along a direction, as of brushed metal (`KHR_materials_anisotropy`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// How much longer, 0 to 1: the GGX α along the direction goes from that of the roughness to 1 with its square.
    pub strength: f32,
    /// Turn of the direction from the tangent towards the bitangent \[rad\].
    pub rotation: f32,
}

/// A film as thin as the waves of light, whose colours change with the angle (`KHR_materials_iridescence`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// Share of the surface that it covers, 0 to 1; 0: there is none.
    pub factor: f32,
    /// Its index of refraction.
    pub ior: f32,
    /// Its thickness where the thickness texture is black \[nm\].
    pub least_thickness: f32,
    /// The same where that is white, and without a texture \[nm\].
    pub thickness: f32,
}

impl Default for Iridescence {
    fn default() -> Self {
        Self { factor: 0.0, ior: 1.3, least_thickness: 100.0, thickness: 400.0 }
    }
}
