//! `KHR_materials_pbrSpecularGlossiness`, archived but common in older files: diffuse and specular colour in place of base colour and
//! metal.
//!
//! Such a material is a dielectric whose reflectance at normal incidence is its specular colour, as `KHR_materials_specular`
//! describes in its section on conversions. So nothing is guessed, other than by a split into metal and dielectric. Gloss becomes
//! roughness by a texture of its own, since it is one minus a product.

use super::layers::{field, number, numbers, used};
use super::texture_use::{TextureUse, Textures};
use crate::assets::{AssetId, Material, Texture};
use glam::{Vec3, Vec4};
use gltf::Document;
use gltf::json::Value;
use std::collections::HashMap;
use std::sync::Arc;

const NAME: &str = "KHR_materials_pbrSpecularGlossiness";
const DIFFUSE: (&str, &str, bool) = (NAME, "diffuseTexture", true);
/// Specular colour, and gloss in alpha.
const GLOSS: (&str, &str, bool) = (NAME, "specularGlossinessTexture", true);

/// Reflectance at normal incidence that a specular colour of 1 stands for, of an index of refraction of 1.5.
const UNIT: f32 = 0.04;

/// Maps of roughness, by the texture with the gloss and the bits of the factor.
pub(super) type RoughnessMaps = HashMap<(usize, u32), Arc<Texture>>;

/// The textures that a material uses.
pub(super) fn textures(m: &gltf::Material) -> Vec<TextureUse> {
    let index = |(extension, name, srgb)| Some((index(field(m, extension, name)?)?, srgb));
    [DIFFUSE, GLOSS].into_iter().filter_map(index).collect()
}

fn index(info: &Value) -> Option<usize> {
    usize::try_from(info.get("index")?.as_u64()?).ok()
}

/// Key of a material's map of roughness; `None` if it needs none.
fn roughness_key(m: &gltf::Material) -> Option<(usize, u32)> {
    let texture = index(field(m, NAME, GLOSS.1)?)?;
    Some((texture, glossiness(m).to_bits()))
}

fn glossiness(m: &gltf::Material) -> f32 {
    number(field(m, NAME, "glossinessFactor"), 1.0).clamp(0.0, 1.0)
}

/// Makes the maps of roughness that the materials need, each once.
pub(super) fn roughness_maps(document: &Document, textures: &Textures) -> RoughnessMaps {
    let mut maps = RoughnessMaps::new();
    for m in document.materials() {
        let Some(key) = roughness_key(&m) else { continue };
        if let Some(texture) = textures.get(&(key.0, GLOSS.2)) {
            maps.entry(key).or_insert_with(|| Arc::new(roughness_map(texture, glossiness(&m))));
        }
    }
    maps
}

/// Roughness in green, no metal in blue.
fn roughness_map(texture: &Texture, glossiness: f32) -> Texture {
    let roughness = |alpha: u8| (255.0 - glossiness * f32::from(alpha)).round() as u8;
    let rgba = texture.rgba.chunks_exact(4).flat_map(|texel| [0, roughness(texel[3]), 0, 255]).collect();
    Texture { id: AssetId::fresh(), name: format!("{} (roughness)", texture.name), rgba, srgb: false, ..*texture }
}

/// Turns the material into what its extension says.
pub(super) fn apply(material: &mut Material, m: &gltf::Material, textures: &Textures, roughness: &RoughnessMaps) {
    if m.extension_value(NAME).is_none() {
        return;
    }
    material.base_color = Vec4::from(numbers(field(m, NAME, "diffuseFactor"), [1.0; 4]));
    (material.base_color_texture, material.uv.base_color) = used(m, textures, DIFFUSE);
    material.metallic = 0.0;
    material.ior = 1.5;
    material.specular = 1.0;
    material.specular_texture = None;
    let specular = Vec3::from(numbers(field(m, NAME, "specularFactor"), [1.0; 3]));
    material.specular_color = specular.map(|s| if s.is_nan() { 0.0 } else { s.clamp(0.0, 1.0) }) / UNIT;
    (material.specular_color_texture, material.uv.specular_color) = used(m, textures, GLOSS);
    material.metallic_roughness_texture = roughness_key(m).and_then(|key| roughness.get(&key).cloned());
    material.uv.metallic_roughness = material.uv.specular_color;
    let is_mapped = material.metallic_roughness_texture.is_some();
    material.roughness = if is_mapped { 1.0 } else { 1.0 - glossiness(m) };
}
