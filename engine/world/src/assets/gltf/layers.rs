//! Layers of materials: `KHR_materials_clearcoat`, `_sheen`, `_anisotropy`, `_iridescence` and `_dispersion`. The loader has no types
//! for them: they are read from the extensions as they are written.

use super::texture_use::{TextureUse, Textures, affine};
use crate::assets::{Anisotropy, Clearcoat, Iridescence, Material, Sheen, Texture, UvMap};
use glam::Vec3;
use gltf::json::Value;
use std::sync::Arc;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";
const IRIDESCENCE: &str = "KHR_materials_iridescence";
const DISPERSION: &str = "KHR_materials_dispersion";

/// Their textures: the extension, the name there, and whether colours are sRGB.
const TEXTURES: [(&str, &str, bool); 8] = [
    (CLEARCOAT, "clearcoatTexture", false),
    (CLEARCOAT, "clearcoatRoughnessTexture", false),
    (CLEARCOAT, "clearcoatNormalTexture", false),
    (SHEEN, "sheenColorTexture", true),
    (SHEEN, "sheenRoughnessTexture", false),
    (ANISOTROPY, "anisotropyTexture", false),
    (IRIDESCENCE, "iridescenceTexture", false),
    (IRIDESCENCE, "iridescenceThicknessTexture", false),
];

/// A field of an extension of a material.
pub(super) fn field<'m>(m: &'m gltf::Material, extension: &str, name: &str) -> Option<&'m Value> {
    m.extension_value(extension)?.get(name)
}

pub(super) fn number(value: Option<&Value>, usual: f32) -> f32 {
    value.and_then(Value::as_f64).map_or(usual, |value| value as f32)
}

/// Numbers of an array; the usual ones where it has none.
pub(super) fn numbers<const N: usize>(value: Option<&Value>, usual: [f32; N]) -> [f32; N] {
    std::array::from_fn(|i| number(value.and_then(|value| value.get(i)), usual[i]))
}

/// The textures that the layers of a material use. References to what is not there were taken away before.
pub(super) fn textures(m: &gltf::Material) -> Vec<TextureUse> {
    let index = |info: &Value| usize::try_from(info.get("index")?.as_u64()?).ok();
    let found = |(extension, name, srgb)| Some((index(field(m, extension, name)?)?, srgb));
    TEXTURES.into_iter().filter_map(found).collect()
}

/// Gives the material its layers.
pub(super) fn add(material: &mut Material, m: &gltf::Material, textures: &Textures) {
    let value = |extension, name, usual| number(field(m, extension, name), usual);
    material.clearcoat = Clearcoat {
        factor: value(CLEARCOAT, "clearcoatFactor", 0.0),
        roughness: value(CLEARCOAT, "clearcoatRoughnessFactor", 0.0),
        normal_scale: number(field(m, CLEARCOAT, "clearcoatNormalTexture").and_then(|info| info.get("scale")), 1.0),
    };
    let color = field(m, SHEEN, "sheenColorFactor");
    material.sheen =
        Sheen { color: Vec3::from(numbers(color, [0.0; 3])), roughness: value(SHEEN, "sheenRoughnessFactor", 0.0) };
    material.anisotropy = Anisotropy {
        strength: value(ANISOTROPY, "anisotropyStrength", 0.0),
        rotation: value(ANISOTROPY, "anisotropyRotation", 0.0),
    };
    material.iridescence = Iridescence {
        factor: value(IRIDESCENCE, "iridescenceFactor", 0.0),
        ior: value(IRIDESCENCE, "iridescenceIor", 1.3),
        least_thickness: value(IRIDESCENCE, "iridescenceThicknessMinimum", 100.0),
        thickness: value(IRIDESCENCE, "iridescenceThicknessMaximum", 400.0),
    };
    material.dispersion = value(DISPERSION, "dispersion", 0.0);
    let of = |index: usize| used(m, textures, TEXTURES[index]);
    (material.clearcoat_texture, material.uv.clearcoat) = of(0);
    (material.clearcoat_roughness_texture, material.uv.clearcoat_roughness) = of(1);
    (material.clearcoat_normal_texture, material.uv.clearcoat_normal) = of(2);
    (material.sheen_color_texture, material.uv.sheen_color) = of(3);
    (material.sheen_roughness_texture, material.uv.sheen_roughness) = of(4);
    (material.anisotropy_texture, material.uv.anisotropy) = of(5);
    (material.iridescence_texture, material.uv.iridescence) = of(6);
    (material.iridescence_thickness_texture, material.uv.iridescence_thickness) = of(7);
}

/// A texture, and where it lies.
pub(super) fn used(
    m: &gltf::Material,
    textures: &Textures,
    (extension, name, srgb): (&str, &str, bool),
) -> (Option<Arc<Texture>>, UvMap) {
    let Some(info) = field(m, extension, name) else { return (None, UvMap::default()) };
    let index = info.get("index").and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
    let texture = index.and_then(|index| textures.get(&(index, srgb)).cloned());
    let set = info.get("texCoord").and_then(Value::as_u64).and_then(|set| u32::try_from(set).ok()).unwrap_or(0);
    let transform = info.get("extensions").and_then(|extensions| extensions.get("KHR_texture_transform"));
    (texture, transform.map_or(UvMap { set, ..Default::default() }, |transform| transformed(transform, set)))
}

/// `KHR_texture_transform` as it is written, of a texture that lies by a set.
pub(super) fn transformed(t: &Value, set: u32) -> UvMap {
    let pair = |name: &str, usual: f32| [0, 1].map(|i| number(t.get(name).and_then(|v| v.get(i)), usual));
    let set = t.get("texCoord").and_then(Value::as_u64).and_then(|v| u32::try_from(v).ok()).unwrap_or(set);
    UvMap { set, transform: affine(pair("offset", 0.0), number(t.get("rotation"), 0.0), pair("scale", 1.0)) }
}

/// Takes all layers away, with their textures.
pub(super) fn remove(m: &mut Material) {
    (m.clearcoat, m.sheen) = (Clearcoat::default(), Sheen::default());
    (m.anisotropy, m.iridescence) = (Anisotropy::default(), Iridescence::default());
    m.dispersion = 0.0;
    (m.clearcoat_texture, m.clearcoat_roughness_texture, m.clearcoat_normal_texture) = (None, None, None);
    (m.sheen_color_texture, m.sheen_roughness_texture, m.anisotropy_texture) = (None, None, None);
    (m.iridescence_texture, m.iridescence_thickness_texture) = (None, None);
}

/// Brings numbers that are out of range back.
pub(super) fn make_finite(m: &mut Material) {
    let within = |x: f32, least: f32, most: f32| if x.is_nan() { least } else { x.clamp(least, most) };
    let unit = |x: f32| within(x, 0.0, 1.0);
    let coat = m.clearcoat;
    m.clearcoat = Clearcoat {
        factor: unit(coat.factor),
        roughness: unit(coat.roughness),
        normal_scale: if coat.normal_scale.is_finite() { coat.normal_scale } else { 1.0 },
    };
    m.sheen = Sheen { color: m.sheen.color.map(unit), roughness: unit(m.sheen.roughness) };
    let rotation = if m.anisotropy.rotation.is_finite() { m.anisotropy.rotation } else { 0.0 };
    m.anisotropy = Anisotropy { strength: unit(m.anisotropy.strength), rotation };
    let film = m.iridescence;
    m.iridescence = Iridescence {
        factor: unit(film.factor),
        ior: within(film.ior, 1.0, 10.0),
        least_thickness: within(film.least_thickness, 0.0, 1e5),
        thickness: within(film.thickness, 0.0, 1e5),
    };
    m.dispersion = within(m.dispersion, 0.0, 100.0);
}

/// Where the tangents of a mesh are needed that has no normal map of the base: by the coat's normal map, or by the direction in
/// which highlights are stretched.
pub(super) fn tangents_of(m: &Material) -> Option<UvMap> {
    let coat = m.clearcoat_normal_texture.is_some().then_some(m.uv.clearcoat_normal);
    coat.or((m.anisotropy.strength > 0.0).then_some(m.uv.anisotropy))
}
