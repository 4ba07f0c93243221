//! Targets of key-framed tracks: named ones, and fields by path.

use super::KeyValue;
use serde::{Deserialize, Serialize};

/// The target of a key-framed track.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// Translation \[m\], (x, y, z).
    Translation,
    /// Rotation: (x, y, z) in degrees, applied Z first, then X, then Y; or a quaternion (x, y, z, w).
    Rotation,
    /// Scale: (x, y, z), or one number for all three.
    Scale,
    /// Intensity of the entity's light, a number.
    LightIntensity,
    /// Colour of the entity's light, linear (r, g, b).
    LightColor,
    /// Distance beyond which the entity's light does not reach \[m\], a number.
    LightRange,
    /// Half angle of full intensity of the entity's spot light \[degrees\], a number.
    LightInner,
    /// Half angle beyond which the entity's spot light does not shine \[degrees\], a number.
    LightOuter,
    /// Vertical field of view of the entity's camera \[degrees\], a number.
    CameraFov,
    /// Height of what the entity's orthographic camera sees \[m\], a number.
    CameraHeight,
    /// Radiance that the entity's own material emits [W/(m² sr)], linear (r, g, b).
    MaterialEmissive,
    /// Base colour of the entity's own material, linear (r, g, b).
    MaterialColor,
    /// Alpha of the entity's own material, a number.
    MaterialAlpha,
    /// Metallic of the entity's own material, a number.
    MaterialMetallic,
    /// Roughness of the entity's own material, a number.
    MaterialRoughness,
    /// Whether the entity's own mesh is drawn: where the number is ½ or more.
    Visible,
    /// Weight of a morph target of the model's node, by its number from 0; a number, usually from 0 to 1.
    MorphWeight(u32),
    /// Any number, vector, colour or switch by its path: `Field("light.casts_shadow")`, `Field("clpv.gain")`,
    /// `Field("transform.translation.y")`, `Field("Coin.value")` of a game's own component, or a setting of the whole
    /// scene, `Field("scene.sky")`, `Field("scene.environment.intensity")`. Values are numbers as in the field, whole
    /// ones rounded, or true and false, which change at their keys.
    Field(String),
}

/// Paths of what has a target of its own.
const NAMED: [(&str, Target); 18] = [
    ("transform.translation", Target::Translation),
    ("transform.rotation", Target::Rotation),
    ("transform.scale", Target::Scale),
    ("light.intensity", Target::LightIntensity),
    ("light.color", Target::LightColor),
    ("light.range", Target::LightRange),
    ("light.kind.inner", Target::LightInner),
    ("light.kind.outer", Target::LightOuter),
    ("camera.fov", Target::CameraFov),
    ("camera.projection.height", Target::CameraHeight),
    ("material.emissive", Target::MaterialEmissive),
    ("material.color", Target::MaterialColor),
    ("material.alpha", Target::MaterialAlpha),
    ("material.metallic", Target::MaterialMetallic),
    ("material.roughness", Target::MaterialRoughness),
    ("mesh.visible", Target::Visible),
    ("visible", Target::Visible),
    ("material.base_color", Target::MaterialColor),
];

/// A field of a material or of a mesh, which have no text of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::world) enum SurfaceField {
    /// Whether the mesh casts shadows.
    CastsShadow,
    /// Strength of the reflection of dielectrics.
    Specular,
    /// Colour of that reflection.
    SpecularColor,
    /// Share of light that passes.
    Transmission,
    /// Scale of the normal map.
    NormalScale,
    /// Alpha from which on a masked surface is drawn.
    AlphaCutoff,
    /// Whether back faces are drawn.
    DoubleSided,
    /// Share of the surface that a clear coat covers.
    Clearcoat,
    /// Its roughness.
    ClearcoatRoughness,
    /// Colour of the sheen.
    SheenColor,
    /// Its roughness.
    SheenRoughness,
    /// How much highlights are stretched.
    Anisotropy,
    /// Turn of the direction \[degrees\].
    AnisotropyRotation,
    /// Share of the surface that a film covers.
    Iridescence,
    /// Its thickness \[nm\].
    IridescenceThickness,
    /// How far colours part in glass.
    Dispersion,
}

const SURFACE: [(&str, SurfaceField); 17] = [
    ("mesh.casts_shadow", SurfaceField::CastsShadow),
    ("casts_shadow", SurfaceField::CastsShadow),
    ("material.specular", SurfaceField::Specular),
    ("material.specular_color", SurfaceField::SpecularColor),
    ("material.transmission", SurfaceField::Transmission),
    ("material.normal_scale", SurfaceField::NormalScale),
    ("material.alpha_mode.0", SurfaceField::AlphaCutoff),
    ("material.double_sided", SurfaceField::DoubleSided),
    ("material.clearcoat.factor", SurfaceField::Clearcoat),
    ("material.clearcoat.roughness", SurfaceField::ClearcoatRoughness),
    ("material.sheen.color", SurfaceField::SheenColor),
    ("material.sheen.roughness", SurfaceField::SheenRoughness),
    ("material.anisotropy.strength", SurfaceField::Anisotropy),
    ("material.anisotropy.rotation", SurfaceField::AnisotropyRotation),
    ("material.iridescence.factor", SurfaceField::Iridescence),
    ("material.iridescence.thickness", SurfaceField::IridescenceThickness),
    ("material.dispersion", SurfaceField::Dispersion),
];

/// Parts of a transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::world) enum Part {
    /// Translation \[m\].
    Translation,
    /// Angles about x, y and z \[degrees\].
    Rotation,
    /// Scale.
    Scale,
}

/// The meaning of a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::world) enum Meaning<'a> {
    /// A target that is no path.
    Named(Target),
    /// A number of the transform, and which.
    Lane(Part, usize),
    /// A field of the surface.
    Surface(SurfaceField),
    /// A field that is known as text alone.
    Text(&'a str),
}

impl Target {
    /// The meaning of the target: a path of a field that has a named target means that one.
    pub(in crate::world) fn meaning(&self) -> Meaning<'_> {
        let Self::Field(path) = self else { return Meaning::Named(self.clone()) };
        if let Some((_, named)) = NAMED.iter().find(|(known, _)| known == path) {
            return Meaning::Named(named.clone());
        }
        if let Some((_, field)) = SURFACE.iter().find(|(known, _)| known == path) {
            return Meaning::Surface(*field);
        }
        match lane(path) {
            Some((part, lane)) => Meaning::Lane(part, lane),
            None => Meaning::Text(path),
        }
    }

    /// Whether its values are rotations.
    pub(in crate::world) fn is_rotation(&self) -> bool {
        self.meaning() == Meaning::Named(Self::Rotation)
    }

    /// Names of the fields of a component whose paths have a meaning without its text: of the transform, the mesh and the
    /// material.
    pub fn fields_without_text(component: &str) -> Vec<&'static str> {
        let paths = NAMED.iter().map(|(path, _)| *path).chain(SURFACE.iter().map(|(path, _)| *path));
        let of = paths.filter_map(|path| path.strip_prefix(component)?.strip_prefix('.'));
        if matches!(component, "transform" | "mesh" | "material") { of.collect() } else { Vec::new() }
    }

    /// The path, if the field is known as text alone.
    pub fn text_path(&self) -> Option<&str> {
        if let Meaning::Text(path) = self.meaning() { Some(path) } else { None }
    }

    /// The thing of an own target that a path lies within, which is keyed as a whole.
    pub fn whole_of(path: &str) -> Option<&'static str> {
        let within = |whole: &str| path.strip_prefix(whole).is_some_and(|rest| rest.starts_with('.'));
        NAMED.iter().map(|(whole, _)| *whole).find(|whole| within(whole))
    }
}

fn lane(path: &str) -> Option<(Part, usize)> {
    let (part, lane) = path.strip_prefix("transform.")?.split_once('.')?;
    let part = match part {
        "translation" => Part::Translation,
        "rotation" => Part::Rotation,
        "scale" => Part::Scale,
        _ => return None,
    };
    let letter = ["x", "y", "z"].iter().position(|name| *name == lane);
    letter.or_else(|| lane.parse().ok().filter(|lane| *lane < 3)).map(|lane| (part, lane))
}

impl SurfaceField {
    /// Whether its values are colours, not single numbers or switches.
    pub(super) fn is_color(self) -> bool {
        matches!(self, Self::SpecularColor | Self::SheenColor)
    }
}

impl KeyValue {
    /// How many numbers it has.
    pub fn count(self) -> usize {
        match self {
            Self::Scalar(_) | Self::Flag(_) => 1,
            Self::Pair(_) => 2,
            Self::Vector(_) => 3,
            Self::Quaternion(_) => 4,
        }
    }

    /// Its numbers, the rest zero; a switch is 0 or 1.
    pub fn numbers(self) -> [f64; 4] {
        let [x, y, z, w] = match self {
            Self::Scalar(v) => [v, 0.0, 0.0, 0.0],
            Self::Flag(on) => [f32::from(u8::from(on)), 0.0, 0.0, 0.0],
            Self::Pair(v) => [v.x, v.y, 0.0, 0.0],
            Self::Vector(v) => [v.x, v.y, v.z, 0.0],
            Self::Quaternion(q) => q.to_array(),
        };
        [x, y, z, w].map(f64::from)
    }
}
