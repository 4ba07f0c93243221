//! Materials and the textures they use.

use super::source;
use crate::assets::{AlphaMode, AssetError, Material, Sampling, Texture, Wrap, image, parallel};
use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use gltf::Document;
use gltf::texture::{Info, MagFilter, TextureTransform, WrappingMode};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which texture coordinates a material's textures use. A mesh carries one set, so all must agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvSource {
    pub set: u32,
    /// `KHR_texture_transform`, put into the vertices.
    pub transform: Affine2,
}

impl Default for UvSource {
    fn default() -> Self {
        Self { set: 0, transform: Affine2::IDENTITY }
    }
}

impl UvSource {
    /// Bits for use in keys.
    pub fn key(&self) -> (u32, [u32; 6]) {
        (self.set, self.transform.to_cols_array().map(f32::to_bits))
    }
}

/// A texture as a material uses it.
type TextureUse = (usize, bool);

/// All materials of a document; the last one is glTF's default material.
pub(super) struct Materials {
    pub all: Vec<(Arc<Material>, UvSource)>,
}

impl Materials {
    /// The material of an index; the default one for none.
    pub fn get(&self, index: Option<usize>) -> (Arc<Material>, UvSource) {
        let (material, uv) = &self.all[index.unwrap_or(self.all.len() - 1)];
        (material.clone(), *uv)
    }
}

/// Loads the images that the materials use, in parallel, and makes the materials.
pub(super) fn load(
    path: &Path,
    document: &Document,
    image_bytes: &dyn Fn(&gltf::buffer::View) -> Result<Vec<u8>, AssetError>,
    files: &mut Vec<PathBuf>,
    warnings: &mut Vec<String>,
) -> Result<Materials, AssetError> {
    let mut wanted: BTreeSet<TextureUse> = BTreeSet::new();
    for m in document.materials() {
        let pbr = m.pbr_metallic_roughness();
        wanted.extend(pbr.base_color_texture().map(|t| (t.texture().index(), true)));
        wanted.extend(m.emissive_texture().map(|t| (t.texture().index(), true)));
        wanted.extend(pbr.metallic_roughness_texture().map(|t| (t.texture().index(), false)));
        wanted.extend(m.normal_texture().map(|t| (t.texture().index(), false)));
    }
    let textures = load_textures(path, document, &wanted, image_bytes, files)?;
    let mut all: Vec<_> = document.materials().map(|m| convert(&m, &textures, warnings)).collect();
    all.push((Arc::new(Material { metallic: 1.0, ..Material::new("default") }), UvSource::default()));
    Ok(Materials { all })
}

/// Images are decoded once each; textures that differ in nothing are one.
fn load_textures(
    path: &Path,
    document: &Document,
    wanted: &BTreeSet<TextureUse>,
    image_bytes: &dyn Fn(&gltf::buffer::View) -> Result<Vec<u8>, AssetError>,
    files: &mut Vec<PathBuf>,
) -> Result<HashMap<TextureUse, Arc<Texture>>, AssetError> {
    let by_index: Vec<_> = document.textures().collect();
    let mut by_image: BTreeMap<usize, Vec<TextureUse>> = BTreeMap::new();
    for (texture, srgb) in wanted {
        let source = document.as_json().textures[*texture].source.value();
        by_image.entry(source).or_default().push((*texture, *srgb));
    }
    let mut encoded = Vec::new();
    for (index, uses) in &by_image {
        let json = &document.as_json().images[*index];
        let label = json.name.as_deref().or(json.uri.as_deref().filter(|u| !u.starts_with("data:")));
        let place = label.map_or(format!("image {index}"), |l| format!("image {index} \"{l}\""));
        let bytes = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => source::fetch(path, &place, uri, files)?,
            (None, Some(view)) => match document.views().nth(view.value()) {
                Some(view) => image_bytes(&view)?,
                None => {
                    return Err(AssetError::format(path, place, "its buffer view is not there"));
                }
            },
            (None, None) => {
                return Err(AssetError::format(path, place, "has neither a URI nor a buffer view"));
            }
        };
        encoded.push((place, label.map_or(format!("image {index}"), str::to_string), bytes, uses));
    }
    let decoded = parallel::map(&encoded, |(place, _, bytes, _)| image::decode(path, place, bytes));
    let mut textures = HashMap::new();
    for ((_, name, _, uses), pixels) in encoded.iter().zip(decoded) {
        let mut pixels = Some(pixels?);
        let mut same: HashMap<(Sampling, bool), Arc<Texture>> = HashMap::new();
        let kinds: BTreeSet<_> = uses.iter().map(|(t, srgb)| (sampling_key(&by_index[*t]), *srgb)).collect();
        let mut left = kinds.len();
        for usage in uses.iter() {
            let sampling = sampling(&by_index[usage.0]);
            let texture = same.entry((sampling, usage.1)).or_insert_with(|| {
                left = left.saturating_sub(1);
                // The last texture takes the pixels, those before it copy them.
                let taken = if left == 0 { pixels.take() } else { pixels.clone() };
                let taken = taken.unwrap_or(image::Pixels { width: 1, height: 1, rgba: vec![255; 4] });
                Arc::new(Texture::from_pixels(name.clone(), taken, usage.1, sampling))
            });
            textures.insert(*usage, texture.clone());
        }
    }
    Ok(textures)
}

fn sampling(texture: &gltf::Texture) -> Sampling {
    let wrap = |mode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    let sampler = texture.sampler();
    Sampling {
        wrap_u: wrap(sampler.wrap_s()),
        wrap_v: wrap(sampler.wrap_t()),
        nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
    }
}

fn sampling_key(texture: &gltf::Texture) -> (u8, u8, bool) {
    let s = sampling(texture);
    (s.wrap_u as u8, s.wrap_v as u8, s.nearest)
}

fn convert(
    m: &gltf::Material,
    textures: &HashMap<TextureUse, Arc<Texture>>,
    warnings: &mut Vec<String>,
) -> (Arc<Material>, UvSource) {
    let index = m.index().unwrap_or(0);
    let name = m.name().map_or(format!("material {index}"), str::to_string);
    let pbr = m.pbr_metallic_roughness();
    let texture = |index: Option<usize>, srgb| index.and_then(|i| textures.get(&(i, srgb)).cloned());
    let of = |info: &Option<Info>| info.as_ref().map(|t| t.texture().index());
    let (base, rough, normal, glow) =
        (pbr.base_color_texture(), pbr.metallic_roughness_texture(), m.normal_texture(), m.emissive_texture());
    let (specular, specular_color) = specular(m, &name, warnings);
    let mut material = Material {
        base_color: Vec4::from(pbr.base_color_factor()),
        metallic: pbr.metallic_factor(),
        roughness: pbr.roughness_factor(),
        specular,
        specular_color,
        emissive: Vec3::from(m.emissive_factor()) * m.emissive_strength().unwrap_or(1.0).max(0.0),
        normal_scale: normal.as_ref().map_or(1.0, |n| n.scale()),
        alpha_mode: match m.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => AlphaMode::Mask(m.alpha_cutoff().unwrap_or(0.5)),
            gltf::material::AlphaMode::Blend => AlphaMode::Blend,
        },
        double_sided: m.double_sided(),
        base_color_texture: texture(of(&base), true),
        metallic_roughness_texture: texture(of(&rough), false),
        normal_texture: texture(normal.as_ref().map(|n| n.texture().index()), false),
        emissive_texture: texture(of(&glow), true),
        ..Material::new(name.clone())
    };
    if m.unlit() {
        make_unlit(&mut material);
    }
    make_finite(&mut material, &name, warnings);
    let infos = [&base, &rough, &glow].into_iter().flatten().map(uv_source);
    let normal_source = normal.as_ref().map(|n| normal_uv(m, n.tex_coord()));
    let sources: Vec<_> = infos.chain(normal_source).collect();
    let chosen = sources.first().copied().unwrap_or_default();
    if sources.iter().any(|s| *s != chosen) {
        warnings.push(format!(
            "material {index} \"{name}\": its textures use different texture coordinates; all take those of the first"
        ));
    }
    (Arc::new(material), chosen)
}

/// `KHR_materials_specular`, and `KHR_materials_ior` folded into its colour: F0 = ((n − 1)/(n + 1))², where 4 % is n = 1.5.
fn specular(m: &gltf::Material, name: &str, warnings: &mut Vec<String>) -> (f32, Vec3) {
    let (mut factor, mut color) = (1.0, Vec3::ONE);
    if let Some(s) = m.specular() {
        factor = s.specular_factor();
        color = Vec3::from(s.specular_color_factor());
        if s.specular_texture().is_some() || s.specular_color_texture().is_some() {
            warnings.push(format!("material \"{name}\": the textures of KHR_materials_specular are not used"));
        }
    }
    if let Some(ior) = m.ior().filter(|n| n.is_finite() && *n >= 0.0) {
        color *= ((ior - 1.0) / (ior + 1.0)).powi(2) / 0.04;
    }
    (factor, color.max(Vec3::ZERO).min(Vec3::splat(25.0)))
}

/// `KHR_materials_unlit`: shows its base colour whatever the light, so it is taken as light of its own.
fn make_unlit(m: &mut Material) {
    m.emissive = m.base_color.truncate();
    m.emissive_texture = m.base_color_texture.clone();
    m.base_color = Vec3::ZERO.extend(m.base_color.w);
    m.metallic = 0.0;
    m.metallic_roughness_texture = None;
    m.specular = 0.0;
}

/// Numbers beyond the range of floats, and factors outside their range, are brought back.
fn make_finite(m: &mut Material, name: &str, warnings: &mut Vec<String>) {
    let before = format!("{:?}", (m.base_color, m.metallic, m.roughness, m.specular, m.emissive, m.normal_scale));
    let bring = |x: f32, most: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, most) };
    m.base_color = Vec4::from(m.base_color.to_array().map(|x| bring(x, 1.0)));
    m.metallic = bring(m.metallic, 1.0);
    m.roughness = bring(m.roughness, 1.0);
    m.specular = bring(m.specular, 1.0);
    m.emissive = Vec3::from(m.emissive.to_array().map(|x| bring(x, 1e30)));
    m.normal_scale = if m.normal_scale.is_finite() { m.normal_scale } else { 1.0 };
    let after = format!("{:?}", (m.base_color, m.metallic, m.roughness, m.specular, m.emissive, m.normal_scale));
    if before != after {
        warnings.push(format!("material \"{name}\": factors out of range were clamped"));
    }
}

fn uv_source(info: &Info) -> UvSource {
    let Some(t) = info.texture_transform() else {
        return UvSource { set: info.tex_coord(), ..Default::default() };
    };
    UvSource { set: t.tex_coord().unwrap_or(info.tex_coord()), transform: affine(&t) }
}

fn affine(t: &TextureTransform) -> Affine2 {
    // The extension rotates counter-clockwise in a space whose v points down.
    let (sin, cos) = t.rotation().sin_cos();
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let transform =
        Affine2::from_mat2_translation(rotation * Mat2::from_diagonal(Vec2::from(t.scale())), Vec2::from(t.offset()));
    if transform.is_finite() { transform } else { Affine2::IDENTITY }
}

/// The loader has no typed transform for normal textures: they share that of the base colour where they use its set.
fn normal_uv(m: &gltf::Material, set: u32) -> UvSource {
    let base = m.pbr_metallic_roughness().base_color_texture().map(|t| uv_source(&t));
    base.filter(|b| b.set == set).unwrap_or(UvSource { set, ..Default::default() })
}
