//! Materials and the textures they use.

use super::remarks::Remarks;
use super::specular_glossiness::{self, RoughnessMaps};
use super::texture_use::{TextureUse, Textures, affine};
use super::{layers, source};
use crate::assets::{
    AlphaMode, AssetError, Attenuation, Levels, Material, Minification, Sampling, Texture, UvMap, UvMaps, Wrap,
};
use crate::assets::{image, parallel, pixels};
use glam::{Vec3, Vec4};
use gltf::Document;
use gltf::texture::{Info, MagFilter, MinFilter, WrappingMode};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

/// Requirements of a material on its meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvSource {
    /// The file's sets that become sets 0 and 1 of the mesh.
    pub sets: [u32; 2],
    /// Whether any texture lies by them.
    pub uses: [bool; 2],
    /// Where what needs tangents lies, a normal map or stretched highlights; none: there is nothing of it.
    pub normal: Option<UvMap>,
}

impl Default for UvSource {
    fn default() -> Self {
        Self { sets: [0, 1], uses: [false; 2], normal: None }
    }
}

impl UvSource {
    /// Bits for use in keys.
    pub fn key(&self) -> ([u32; 2], [bool; 2], Option<[u32; 8]>) {
        let rows = self.normal.map(|map| map.rows());
        (self.sets, self.uses, rows.map(|rows| std::array::from_fn(|i| rows[i / 4][i % 4].to_bits())))
    }
}

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
    beside: &mut source::Beside,
    remarks: &mut Remarks,
) -> Result<Materials, AssetError> {
    let mut wanted: BTreeSet<TextureUse> = BTreeSet::new();
    for m in document.materials() {
        let pbr = m.pbr_metallic_roughness();
        wanted.extend(pbr.base_color_texture().map(|t| (t.texture().index(), true)));
        wanted.extend(m.emissive_texture().map(|t| (t.texture().index(), true)));
        wanted.extend(pbr.metallic_roughness_texture().map(|t| (t.texture().index(), false)));
        wanted.extend(m.normal_texture().map(|t| (t.texture().index(), false)));
        if let Some(specular) = m.specular() {
            wanted.extend(specular.specular_texture().map(|t| (t.texture().index(), false)));
            wanted.extend(specular.specular_color_texture().map(|t| (t.texture().index(), true)));
        }
        let transmission = m.transmission().and_then(|t| t.transmission_texture());
        wanted.extend(transmission.map(|t| (t.texture().index(), false)));
        wanted.extend(layers::textures(&m));
        wanted.extend(specular_glossiness::textures(&m));
    }
    let textures = load_textures(path, document, &wanted, image_bytes, beside, remarks)?;
    let roughness = specular_glossiness::roughness_maps(document, &textures);
    let mut all: Vec<_> = document.materials().map(|m| convert(&m, &textures, &roughness, remarks)).collect();
    all.push((Arc::new(Material { metallic: 1.0, ..Material::new("default") }), UvSource::default()));
    Ok(Materials { all })
}

/// Images are decoded once each; textures that differ in nothing are one.
fn load_textures(
    path: &Path,
    document: &Document,
    wanted: &BTreeSet<TextureUse>,
    image_bytes: &dyn Fn(&gltf::buffer::View) -> Result<Vec<u8>, AssetError>,
    beside: &mut source::Beside,
    remarks: &mut Remarks,
) -> Result<Textures, AssetError> {
    let by_index: Vec<_> = document.textures().collect();
    let mut by_image: BTreeMap<usize, Vec<TextureUse>> = BTreeMap::new();
    for (texture, srgb) in wanted {
        let source = source_of(path, document, *texture);
        if let Some(image) = remarks.part(source, "drawn without it")? {
            by_image.entry(image).or_default().push((*texture, *srgb));
        }
    }
    let mut encoded = Vec::new();
    for (index, uses) in &by_image {
        let json = &document.as_json().images[*index];
        let label = json.name.as_deref().or(json.uri.as_deref().filter(|u| !u.starts_with("data:")));
        let place = label.map_or(format!("image {index}"), |l| format!("image {index} \"{l}\""));
        let embedded = json.buffer_view.and_then(|view| document.views().nth(view.value())).map(|v| image_bytes(&v));
        let bytes = match (&json.uri, embedded) {
            (None, Some(bytes)) => bytes,
            (None, None) => Err(AssetError::format(path, &place, "has neither a URI nor a buffer view")),
            (Some(uri), embedded) => match (source::fetch(path, &place, uri, beside, remarks), embedded) {
                (Err(error @ AssetError::Format { .. }), Some(Ok(bytes))) => {
                    remarks.broken(&error, "its buffer view is read in its place");
                    Ok(bytes)
                }
                (result, _) => result,
            },
        };
        let Some(bytes) = remarks.part(bytes, "drawn without it")? else { continue };
        encoded.push((place, label.map_or(format!("image {index}"), str::to_string), bytes, uses));
    }
    let meter = beside.meter;
    let decoded = parallel::map(&encoded, |(place, _, bytes, _)| image::decode(path, place, bytes, meter));
    let mut textures = HashMap::new();
    for ((_, name, _, uses), pixels) in encoded.iter().zip(decoded) {
        let Some(pixels) = remarks.part(pixels, "drawn without it")? else { continue };
        let mut pixels = Some(pixels);
        let mut same: HashMap<(Sampling, bool), Arc<Texture>> = HashMap::new();
        let kinds: HashSet<_> = uses.iter().map(|(t, srgb)| (sampling(&by_index[*t]), *srgb)).collect();
        let mut left = kinds.len();
        for usage in uses.iter() {
            let sampling = sampling(&by_index[usage.0]);
            let texture = same.entry((sampling, usage.1)).or_insert_with(|| {
                left = left.saturating_sub(1);
                // The last texture takes the pixels, those before it copy them.
                let taken = if left == 0 { pixels.take() } else { pixels.clone() };
                let taken = taken.unwrap_or(pixels::Pixels { width: 1, height: 1, rgba: vec![255; 4] });
                Arc::new(Texture::from_pixels(name.clone(), taken, usage.1, sampling))
            });
            textures.insert(*usage, texture.clone());
        }
    }
    Ok(textures)
}

/// The image of a texture: that of `KHR_texture_basisu` or `EXT_texture_webp` before the one for readers that do not
/// know them.
fn source_of(path: &Path, document: &Document, texture: usize) -> Result<usize, AssetError> {
    let json = document.as_json();
    let fail = |problem: String| Err(AssetError::format(path, format!("texture {texture}"), problem));
    let extensions = json.textures[texture].extensions.as_ref().map(|e| &e.others);
    let named = |name: &str| extensions.and_then(|e| e.get(name)).and_then(|e| e.get("source"));
    let packed = named("KHR_texture_basisu").or_else(|| named("EXT_texture_webp"));
    let plain = Some(json.textures[texture].source.value()).filter(|source| *source != u32::MAX as usize);
    match packed.and_then(gltf::json::Value::as_u64).map(|source| source as usize).or(plain) {
        Some(source) if source < json.images.len() => Ok(source),
        Some(source) => fail(format!("refers to image {source}, but there are {}", json.images.len())),
        None => fail("has no image (no `source`)".into()),
    }
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
        minification: sampler.min_filter().map(minification),
    }
}

fn minification(filter: MinFilter) -> Minification {
    let (nearest, levels) = match filter {
        MinFilter::Nearest => (true, Levels::Full),
        MinFilter::Linear => (false, Levels::Full),
        MinFilter::NearestMipmapNearest => (true, Levels::Nearest),
        MinFilter::LinearMipmapNearest => (false, Levels::Nearest),
        MinFilter::NearestMipmapLinear => (true, Levels::Blended),
        MinFilter::LinearMipmapLinear => (false, Levels::Blended),
    };
    Minification { nearest, levels }
}

fn convert(
    m: &gltf::Material,
    textures: &Textures,
    roughness: &RoughnessMaps,
    warnings: &mut Remarks,
) -> (Arc<Material>, UvSource) {
    let index = m.index().unwrap_or(0);
    let name = m.name().map_or(format!("material {index}"), str::to_string);
    let pbr = m.pbr_metallic_roughness();
    let texture =
        |info: &Option<Info>, srgb| info.as_ref().and_then(|t| textures.get(&(t.texture().index(), srgb)).cloned());
    let (base, rough, normal, glow) =
        (pbr.base_color_texture(), pbr.metallic_roughness_texture(), m.normal_texture(), m.emissive_texture());
    let gloss = m.specular().and_then(|s| s.specular_texture());
    let tint = m.specular().and_then(|s| s.specular_color_texture());
    let passing = m.transmission().and_then(|t| t.transmission_texture());
    let (specular, specular_color) = specular(m);
    let mut material = Material {
        base_color: Vec4::from(pbr.base_color_factor()),
        metallic: pbr.metallic_factor(),
        roughness: pbr.roughness_factor(),
        specular,
        specular_color,
        emissive: Vec3::from(m.emissive_factor()) * m.emissive_strength().unwrap_or(1.0).max(0.0),
        normal_scale: normal.as_ref().map_or(1.0, |n| n.scale()),
        transmission: m.transmission().map_or(0.0, |t| t.transmission_factor()),
        ior: m.ior().filter(|n| n.is_finite() && *n >= 0.0).unwrap_or(1.5),
        volume: volume(m),
        alpha_mode: match m.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => AlphaMode::Mask(m.alpha_cutoff().unwrap_or(0.5)),
            gltf::material::AlphaMode::Blend => AlphaMode::Blend,
        },
        double_sided: m.double_sided(),
        base_color_texture: texture(&base, true),
        metallic_roughness_texture: texture(&rough, false),
        normal_texture: normal.as_ref().and_then(|n| textures.get(&(n.texture().index(), false)).cloned()),
        emissive_texture: texture(&glow, true),
        specular_texture: texture(&gloss, false),
        specular_color_texture: texture(&tint, true),
        transmission_texture: texture(&passing, false),
        uv: UvMaps {
            base_color: uv_map(&base),
            metallic_roughness: uv_map(&rough),
            normal: normal.as_ref().map_or(UvMap::default(), |n| normal_map(m, n.tex_coord())),
            emissive: uv_map(&glow),
            specular: uv_map(&gloss),
            specular_color: uv_map(&tint),
            transmission: uv_map(&passing),
            ..Default::default()
        },
        ..Material::new(name.clone())
    };
    layers::add(&mut material, m, textures);
    if !m.unlit() {
        specular_glossiness::apply(&mut material, m, textures, roughness);
    } else {
        make_unlit(&mut material);
    }
    make_finite(&mut material, &name, warnings);
    let source = choose_sets(&mut material, warnings);
    (Arc::new(material), source)
}

/// A mesh has room for two sets of texture coordinates: those that the material uses take their places there.
fn choose_sets(m: &mut Material, warnings: &mut Remarks) -> UvSource {
    let used: BTreeSet<u32> = m.textures().iter().filter(|(t, _)| t.is_some()).map(|(_, map)| map.set).collect();
    let mut sets = [0, 1];
    if used.iter().any(|set| *set > 1) {
        let mut chosen = used.iter().copied();
        let first = chosen.next().unwrap_or(0);
        sets = [first, chosen.next().unwrap_or(if first == 1 { 0 } else { 1 })];
    }
    if used.len() > 2 {
        warnings.push(format!(
            "material \"{}\": its textures use {} sets of texture coordinates; only {sets:?} are kept",
            m.name,
            used.len()
        ));
    }
    for map in m.uv.all_mut() {
        map.set = u32::from(map.set == sets[1]);
    }
    let uses = [0, 1].map(|set| m.textures().iter().any(|(texture, map)| texture.is_some() && map.set == set));
    let normal = m.normal_texture.is_some().then_some(m.uv.normal).or_else(|| layers::tangents_of(m));
    UvSource { sets, uses, normal }
}

/// `KHR_materials_specular`: factor and colour.
fn specular(m: &gltf::Material) -> (f32, Vec3) {
    let Some(s) = m.specular() else { return (1.0, Vec3::ONE) };
    (s.specular_factor(), Vec3::from(s.specular_color_factor()).max(Vec3::ZERO).min(Vec3::splat(25.0)))
}

/// `KHR_materials_volume`. The distances that light goes are those in the mesh itself, whatever its thickness says; a thickness of
/// zero is a thin wall.
fn volume(m: &gltf::Material) -> Option<Attenuation> {
    let volume = m.volume().filter(|volume| volume.thickness_factor() > 0.0)?;
    let color = Vec3::from(volume.attenuation_color());
    let distance = volume.attenuation_distance();
    let is_any = color.is_finite() && distance > 0.0;
    Some(if is_any { Attenuation { color: color.clamp(Vec3::ZERO, Vec3::ONE), distance } } else { Attenuation::NONE })
}

/// `KHR_materials_unlit`: shows its base colour whatever the light, so it is taken as light of its own.
fn make_unlit(m: &mut Material) {
    m.emissive = m.base_color.truncate();
    m.emissive_texture = m.base_color_texture.clone();
    m.uv.emissive = m.uv.base_color;
    m.unlit = true;
    m.base_color = Vec3::ZERO.extend(m.base_color.w);
    m.metallic = 0.0;
    m.metallic_roughness_texture = None;
    m.normal_texture = None;
    m.specular_texture = None;
    m.specular_color_texture = None;
    m.specular = 0.0;
    m.transmission = 0.0;
    m.transmission_texture = None;
    layers::remove(m);
}

/// Numbers beyond the range of floats, and factors outside their range, are brought back.
fn make_finite(m: &mut Material, name: &str, warnings: &mut Remarks) {
    let factors = |m: &Material| {
        let base = (m.base_color, m.metallic, m.roughness, m.specular, m.emissive, m.normal_scale, m.transmission);
        format!("{:?}", (base, m.clearcoat, m.sheen, m.anisotropy, m.iridescence, m.dispersion))
    };
    let before = factors(m);
    let bring = |x: f32, most: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, most) };
    m.base_color = Vec4::from(m.base_color.to_array().map(|x| bring(x, 1.0)));
    m.metallic = bring(m.metallic, 1.0);
    m.roughness = bring(m.roughness, 1.0);
    m.specular = bring(m.specular, 1.0);
    m.emissive = Vec3::from(m.emissive.to_array().map(|x| bring(x, 1e30)));
    m.normal_scale = if m.normal_scale.is_finite() { m.normal_scale } else { 1.0 };
    m.transmission = bring(m.transmission, 1.0);
    layers::make_finite(m);
    if before != factors(m) {
        warnings.fault(format!("material \"{name}\": factors out of range were clamped"));
    }
}

fn uv_map(info: &Option<Info>) -> UvMap {
    let Some(info) = info else { return UvMap::default() };
    let Some(t) = info.texture_transform() else {
        return UvMap { set: info.tex_coord(), ..Default::default() };
    };
    UvMap { set: t.tex_coord().unwrap_or(info.tex_coord()), transform: affine(t.offset(), t.rotation(), t.scale()) }
}

/// The loader has no type for the transform of normal textures: it is read from the extension as it is written.
fn normal_map(m: &gltf::Material, set: u32) -> UvMap {
    let extensions = m.index().and(m.normal_texture()).and_then(|n| n.extensions().cloned());
    let Some(t) = extensions.as_ref().and_then(|e| e.get("KHR_texture_transform")) else {
        return UvMap { set, ..Default::default() };
    };
    layers::transformed(t, set)
}
