//! The parts of entities in files: transforms, materials, images, models.

pub use crate::assets::ImportSettings;
use glam::{Quat, Vec3};
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeTuple, Serializer};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Place relative to the parent: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Transform")]
pub struct TransformFile {
    /// Translation (m).
    #[serde(skip_serializing_if = "is_zero")]
    pub translation: Vec3,
    /// Rotation; not together with `look_at`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// Turns −Z (where lights shine and cameras look) to this point in the parent's space (m), +Y upwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at: Option<Vec3>,
    /// Scale, one number or three.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
}

fn is_zero(v: &Vec3) -> bool {
    *v == Vec3::ZERO && v.to_array().iter().all(|c| c.is_sign_positive())
}

/// A rotation, as three angles or as a quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// Angles about x (pitch), y (heading) and z (roll) (degrees): roll first, then pitch, then heading.
    Euler(Vec3),
    /// Quaternion x, y, z, w.
    Quaternion(Quat),
}

impl Serialize for Rotation {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Euler(v) => serialize_tuple(s, &v.to_array()),
            Self::Quaternion(q) => serialize_tuple(s, &q.to_array()),
        }
    }
}

impl<'de> Deserialize<'de> for Rotation {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let numbers = d.deserialize_any(Numbers("three angles in degrees or a quaternion (x, y, z, w)"))?;
        match numbers[..] {
            [x, y, z] => Ok(Self::Euler(Vec3::new(x, y, z))),
            [x, y, z, w] => Ok(Self::Quaternion(Quat::from_xyzw(x, y, z, w))),
            _ => Err(de::Error::invalid_length(numbers.len(), &"three angles in degrees or a quaternion (x, y, z, w)")),
        }
    }
}

/// A scale: the same along all axes, or one each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// The same along x, y and z.
    Uniform(f32),
    /// Along x, y and z.
    Axes(Vec3),
}

impl Serialize for Scale {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Uniform(v) => s.serialize_f32(*v),
            Self::Axes(v) => serialize_tuple(s, &v.to_array()),
        }
    }
}

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let numbers = d.deserialize_any(Numbers("one number or three"))?;
        match numbers[..] {
            [s] => Ok(Self::Uniform(s)),
            [x, y, z] => Ok(Self::Axes(Vec3::new(x, y, z))),
            _ => Err(de::Error::invalid_length(numbers.len(), &"one number or three")),
        }
    }
}

fn serialize_tuple<S: Serializer>(s: S, values: &[f32]) -> Result<S::Ok, S::Error> {
    let mut tuple = s.serialize_tuple(values.len())?;
    for value in values {
        tuple.serialize_element(value)?;
    }
    tuple.end()
}

/// One number, or a short tuple of them.
struct Numbers(&'static str);

impl<'de> Visitor<'de> for Numbers {
    type Value = Vec<f32>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
    fn visit_f64<E>(self, v: f64) -> Result<Vec<f32>, E> {
        Ok(vec![v as f32])
    }
    fn visit_i64<E>(self, v: i64) -> Result<Vec<f32>, E> {
        Ok(vec![v as f32])
    }
    fn visit_u64<E>(self, v: u64) -> Result<Vec<f32>, E> {
        Ok(vec![v as f32])
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<f32>, A::Error> {
        let mut numbers = Vec::new();
        while let Some(v) = seq.next_element()? {
            if numbers.len() == 8 {
                return Err(de::Error::invalid_length(9, &self));
            }
            numbers.push(v);
        }
        Ok(numbers)
    }
}

/// A material: the name of one in the file's `materials`, or the thing itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MaterialRef {
    /// By name.
    Named(String),
    /// Written out.
    Inline(Box<MaterialFile>),
}

impl<'de> Deserialize<'de> for MaterialRef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = MaterialRef;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a material or a material (color: …)")
            }
            fn visit_str<E>(self, name: &str) -> Result<MaterialRef, E> {
                Ok(MaterialRef::Named(name.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MaterialRef, A::Error> {
                let material = MaterialFile::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(MaterialRef::Inline(Box::new(material)))
            }
            fn visit_unit<E>(self) -> Result<MaterialRef, E> {
                Ok(MaterialRef::Inline(Box::default()))
            }
        }
        d.deserialize_any(Either)
    }
}

/// A surface material, as glTF's metallic-roughness model with `KHR_materials_specular`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Material")]
pub struct MaterialFile {
    /// Base colour, linear RGB, 0..1.
    pub color: Vec3,
    /// Alpha, 0..1.
    pub alpha: f32,
    /// How alpha is used.
    pub alpha_mode: AlphaModeFile,
    /// 0: dielectric, 1: metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1.
    pub roughness: f32,
    /// Strength of the reflection of dielectrics, 0..1; 0 makes the surface purely diffuse.
    pub specular: f32,
    /// Colour of that reflection, linear RGB.
    pub specular_color: Vec3,
    /// Share of the light that passes the surface instead of being scattered by it, coloured by the base colour, 0..1: glass.
    pub transmission: f32,
    /// Index of refraction of the inside, 1..10: 1.5 for glass, 1.33 for water. Reflections follow it.
    pub ior: f32,
    /// The surface bounds a solid body, which refracts and absorbs light. Without, it is a thin wall.
    pub volume: Option<AttenuationFile>,
    /// How far colours part in a solid body of glass, 0..100: 20 over its Abbe number. 0.34 is window glass, 0.55 flint glass.
    pub dispersion: f32,
    /// A clear layer over the surface, as on car paint.
    pub clearcoat: Option<ClearcoatFile>,
    /// Fibres that stand off the surface, as of velvet.
    pub sheen: Option<SheenFile>,
    /// Highlights that are longer one way than the other, as of brushed metal.
    pub anisotropy: Option<AnisotropyFile>,
    /// A film as thin as the waves of light, as of soap or oil.
    pub iridescence: Option<IridescenceFile>,
    /// Emitted radiance (W/(m² sr)), linear RGB.
    pub emissive: Vec3,
    /// Back faces are drawn too.
    pub double_sided: bool,
    /// Image of base colour (sRGB) and alpha.
    pub color_texture: Option<TextureFile>,
    /// Image of roughness (G) and metallic (B).
    pub metallic_roughness_texture: Option<TextureFile>,
    /// Tangent-space normal map.
    pub normal_texture: Option<TextureFile>,
    /// Scale of the normal map.
    pub normal_scale: f32,
    /// Image of emission (sRGB).
    pub emissive_texture: Option<TextureFile>,
    /// Image of the transmission (R).
    pub transmission_texture: Option<TextureFile>,
}

/// A clear layer over a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Clearcoat")]
pub struct ClearcoatFile {
    /// Share of the surface that it covers, 0..1.
    pub factor: f32,
    /// Its perceptual roughness, 0..1.
    pub roughness: f32,
}

impl Default for ClearcoatFile {
    fn default() -> Self {
        Self { factor: 1.0, roughness: 0.0 }
    }
}

/// Fibres that stand off a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Sheen")]
pub struct SheenFile {
    /// Colour of their reflection, linear RGB, 0..1.
    pub color: Vec3,
    /// How far they stand apart, 0..1. Below 0.3 it is taken as that.
    pub roughness: f32,
}

impl Default for SheenFile {
    fn default() -> Self {
        Self { color: Vec3::ONE, roughness: 0.5 }
    }
}

/// What stretches highlights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Anisotropy")]
pub struct AnisotropyFile {
    /// How much, 0..1.
    pub strength: f32,
    /// Turn of the direction from the tangent (degrees).
    pub rotation: f32,
}

impl Default for AnisotropyFile {
    fn default() -> Self {
        Self { strength: 0.5, rotation: 0.0 }
    }
}

/// A film as thin as the waves of light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Iridescence")]
pub struct IridescenceFile {
    /// Share of the surface that it covers, 0..1.
    pub factor: f32,
    /// Its index of refraction, 1..10.
    pub ior: f32,
    /// Its thickness (nm), 0..100000.
    pub thickness: f32,
}

impl Default for IridescenceFile {
    fn default() -> Self {
        Self { factor: 1.0, ior: 1.3, thickness: 400.0 }
    }
}

/// What the inside of a solid body takes of light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Attenuation")]
pub struct AttenuationFile {
    /// What is left of white light after the distance, linear RGB.
    pub color: Vec3,
    /// That distance (m).
    pub distance: f32,
}

impl Default for AttenuationFile {
    fn default() -> Self {
        Self { color: Vec3::ONE, distance: 1.0 }
    }
}

impl Default for MaterialFile {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            alpha: 1.0,
            alpha_mode: AlphaModeFile::Opaque,
            metallic: 0.0,
            roughness: 1.0,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            ior: 1.5,
            volume: None,
            dispersion: 0.0,
            clearcoat: None,
            sheen: None,
            anisotropy: None,
            iridescence: None,
            emissive: Vec3::ZERO,
            double_sided: false,
            color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive_texture: None,
            transmission_texture: None,
        }
    }
}

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum AlphaModeFile {
    /// Not at all.
    #[default]
    Opaque,
    /// There where alpha is at least this, else not.
    Mask(f32),
    /// Blended over what lies behind.
    Blend,
}

/// An image, its path relative to the file or to the models' folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum TextureFile {
    /// With the usual sampling: repeated and filtered.
    Path(String),
    /// With its sampling said.
    Sampled(SampledTexture),
}

/// An image with its sampling.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Texture")]
pub struct SampledTexture {
    /// Path of the image.
    pub path: String,
    /// Beyond the borders along u.
    #[serde(default)]
    pub wrap_u: WrapFile,
    /// Beyond the borders along v.
    #[serde(default)]
    pub wrap_v: WrapFile,
    /// Nearest texel instead of bilinear filtering.
    #[serde(default)]
    pub nearest: bool,
}

impl<'de> Deserialize<'de> for TextureFile {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = TextureFile;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the path of an image or (path: …, wrap_u: …, wrap_v: …, nearest: …)")
            }
            fn visit_str<E>(self, path: &str) -> Result<TextureFile, E> {
                Ok(TextureFile::Path(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TextureFile, A::Error> {
                SampledTexture::deserialize(de::value::MapAccessDeserializer::new(map)).map(TextureFile::Sampled)
            }
        }
        d.deserialize_any(Either)
    }
}

/// How texture coordinates outside 0..1 are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WrapFile {
    /// Repeated.
    #[default]
    Repeat,
    /// Repeated, mirrored every other time.
    Mirror,
    /// The border texel is repeated.
    Clamp,
}

/// A glTF model: just its path, or with more to say.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ModelFile {
    /// The whole model.
    Path(String),
    /// With more to say.
    Detailed(ModelDetails),
}

/// A glTF model, or a part of one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Model")]
pub struct ModelDetails {
    /// Path of the `.gltf` or `.glb` file below the models' folder, or else beside this file.
    pub path: String,
    /// Only this node with what hangs on it, where it stands in the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// The model's punctual lights too.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lights: bool,
    /// The model's cameras too.
    #[serde(default, skip_serializing_if = "is_false")]
    pub cameras: bool,
    /// Where to get the model if it does not lie there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The scene that does without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand_in: Option<String>,
    /// Import settings of the model, in place of those in `NAME.import.ron` beside it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub import: Option<ImportSettings>,
}

impl ModelFile {
    /// With all that may be said.
    pub fn details(&self) -> ModelDetails {
        match self {
            Self::Path(path) => ModelDetails { path: path.clone(), ..Default::default() },
            Self::Detailed(details) => details.clone(),
        }
    }
}

impl<'de> Deserialize<'de> for ModelFile {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = ModelFile;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the path of a glTF file or (path: …, node: …, source: …, stand_in: …, import: …)")
            }
            fn visit_str<E>(self, path: &str) -> Result<ModelFile, E> {
                Ok(ModelFile::Path(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ModelFile, A::Error> {
                ModelDetails::deserialize(de::value::MapAccessDeserializer::new(map)).map(ModelFile::Detailed)
            }
        }
        d.deserialize_any(Either)
    }
}

pub(in crate::files) fn is_false(value: &bool) -> bool {
    !value
}
