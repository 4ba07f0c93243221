//! Upload of materials: factors in a uniform buffer, textures, and neutral textures where there is none.

use super::texture::GpuTexture;
use crate::assets::{AlphaMode, AssetId, Material, Sampling, TEXTURE_COUNT, Texture};
use crate::gpu::{Binding, Gpu};
use encase::ShaderType;
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::sync::Arc;

/// `Material` of `lib/mesh.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MaterialUniform {
    base_color: Vec4,
    emissive: Vec3,
    metallic: f32,
    specular_color: Vec3,
    roughness: f32,
    specular: f32,
    alpha_cutoff: f32,
    normal_scale: f32,
    double_sided: u32,
    transmission: f32,
    clearcoat: f32,
    clearcoat_roughness: f32,
    clearcoat_normal_scale: f32,
    sheen_color: Vec3,
    sheen_roughness: f32,
    anisotropy: Vec3,
    iridescence: f32,
    film: Vec3,
    even_layers: Vec4,
    uv_rows: [Vec4; 30],
}

impl MaterialUniform {
    fn new(material: &Material) -> Self {
        let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
        let positive = |v: Vec3| if v.is_finite() { v.max(Vec3::ZERO) } else { Vec3::ZERO };
        let layers = MaterialLayers::of(material);
        let even = material.even_layers(1.0, Vec3::ONE);
        Self {
            base_color: if material.base_color.is_finite() {
                material.base_color.clamp(Vec4::ZERO, Vec4::ONE)
            } else {
                Vec4::W
            },
            emissive: positive(material.emissive),
            metallic: unit(material.metallic),
            specular_color: positive(material.dielectric_reflectance()),
            roughness: unit(material.roughness),
            specular: unit(material.specular),
            alpha_cutoff: alpha_cutoff(material),
            // Eight bits have no exact zero: a neutral texel would tilt the normal by 0.2°.
            normal_scale: match &material.normal_texture {
                Some(_) if material.normal_scale.is_finite() => material.normal_scale,
                _ => 0.0,
            },
            double_sided: u32::from(material.double_sided),
            transmission: if material.is_glass() { unit(material.transmission) } else { 0.0 },
            clearcoat: layers.clearcoat[0],
            clearcoat_roughness: layers.clearcoat[1],
            clearcoat_normal_scale: layers.clearcoat[2],
            sheen_color: Vec3::from_slice(&layers.sheen),
            sheen_roughness: layers.sheen[3],
            anisotropy: layers.anisotropy.into(),
            iridescence: layers.iridescence[0],
            film: Vec3::from_slice(&layers.iridescence[1..]),
            even_layers: even.1.extend(even.0),
            uv_rows: material.uv_rows().map(Vec4::from),
        }
    }
}

/// The layers of a material as shaders have them, within their ranges. A surface that shows what lies behind has none but a film.
pub(in crate::render) struct MaterialLayers {
    /// Factor, roughness, and the scale of the normal map; 0 without one.
    pub clearcoat: [f32; 3],
    /// Colour and roughness.
    pub sheen: [f32; 4],
    /// Strength, and cosine and sine of the turn.
    pub anisotropy: [f32; 3],
    /// Factor, index of refraction, and the range of the thickness \[nm\].
    pub iridescence: [f32; 4],
}

impl MaterialLayers {
    /// Indices of refraction, and thicknesses \[nm\], beyond which no film is.
    const MOST_IOR: f32 = 10.0;
    const MOST_THICKNESS: f32 = 1e5;

    pub(in crate::render) fn of(material: &Material) -> Self {
        let within =
            |value: f32, least: f32, most: f32| if value.is_finite() { value.clamp(least, most) } else { least };
        let unit = |value: f32| within(value, 0.0, 1.0);
        let (coat, sheen) = (&material.clearcoat, &material.sheen);
        let (stretch, film) = (&material.anisotropy, &material.iridescence);
        let only = |is_there: bool, value: f32| if is_there { value } else { 0.0 };
        let has_layers = material.has_layers();
        let is_opaque = has_layers && !material.is_see_through();
        let has_map = material.clearcoat_normal_texture.is_some() && coat.normal_scale.is_finite();
        let color = sheen.color.to_array().map(|c| only(is_opaque, unit(c)));
        let turn = if stretch.rotation.is_finite() { stretch.rotation } else { 0.0 };
        Self {
            clearcoat: [only(is_opaque, unit(coat.factor)), unit(coat.roughness), only(has_map, coat.normal_scale)],
            sheen: [color[0], color[1], color[2], unit(sheen.roughness)],
            anisotropy: [only(is_opaque, unit(stretch.strength)), turn.cos(), turn.sin()],
            iridescence: [
                only(has_layers, unit(film.factor)),
                within(film.ior, 1.0, Self::MOST_IOR),
                within(film.least_thickness, 0.0, Self::MOST_THICKNESS),
                within(film.thickness, 0.0, Self::MOST_THICKNESS),
            ],
        }
    }
}

/// `BLENDED` of `lib/mesh.wgsl`.
const BLENDED: f32 = 2.0;
/// `OPAQUE_ALPHA` of `lib/mesh.wgsl`.
const OPAQUE_ALPHA: f32 = 0.998;

/// Alpha below which nothing is drawn; negative: everything is; 2: the surface is blended.
pub(in crate::render) fn alpha_cutoff(material: &Material) -> f32 {
    match material.alpha_mode {
        AlphaMode::Opaque => -1.0,
        // A cutoff above 1 leaves nothing of the surface, however far above.
        AlphaMode::Mask(cutoff) => cutoff.min(1.5),
        AlphaMode::Blend => BLENDED,
    }
}

/// Whether no point of the surface hides what lies behind: textures and vertex colours only take from alpha.
pub(super) fn is_nowhere_opaque(material: &Material) -> bool {
    material.is_glass() || material.alpha_mode == AlphaMode::Blend && material.base_color.w < OPAQUE_ALPHA
}

/// Names of the textures of a material in WGSL, with those of their samplers, in the order of `Material::textures`.
const TEXTURE_NAMES: [[&str; 2]; TEXTURE_COUNT] = [
    ["base_color_texture", "base_color_sampler"],
    ["metallic_roughness_texture", "metallic_roughness_sampler"],
    ["normal_texture", "normal_sampler"],
    ["emissive_texture", "emissive_sampler"],
    ["specular_texture", "specular_sampler"],
    ["specular_color_texture", "specular_color_sampler"],
    ["transmission_texture", "transmission_sampler"],
    ["clearcoat_texture", "clearcoat_sampler"],
    ["clearcoat_roughness_texture", "clearcoat_roughness_sampler"],
    ["clearcoat_normal_texture", "clearcoat_normal_sampler"],
    ["sheen_color_texture", "sheen_color_sampler"],
    ["sheen_roughness_texture", "sheen_roughness_sampler"],
    ["anisotropy_texture", "anisotropy_sampler"],
    ["iridescence_texture", "iridescence_sampler"],
    ["iridescence_thickness_texture", "iridescence_thickness_sampler"],
];
/// Which of them are normal maps.
const NORMAL_MAPS: [usize; 2] = [2, 9];
/// Which of them holds a direction.
const DIRECTIONS: usize = 12;

/// A material on the device.
#[derive(Debug)]
pub(super) struct GpuMaterial {
    uniform: wgpu::Buffer,
    textures: [Arc<GpuTexture>; TEXTURE_COUNT],
}

impl GpuMaterial {
    /// All that a shader may bind of it, by its name in WGSL.
    pub(super) fn bindings(&self) -> Vec<(&'static str, Binding<'_>)> {
        let textures = TEXTURE_NAMES.iter().zip(&self.textures).flat_map(|([name, sampler], texture)| {
            [(*name, Binding::Texture(&texture.view)), (*sampler, Binding::Sampler(&texture.sampler))]
        });
        std::iter::once(("material", Binding::Buffer(&self.uniform))).chain(textures).collect()
    }
}

/// Bytes of textures that are on their way to the device at a time.
const MAX_PENDING: u64 = 16 << 20;

/// Materials and textures on the device, by asset.
#[derive(Debug)]
pub(super) struct MaterialStore {
    materials: HashMap<AssetId, GpuMaterial>,
    textures: HashMap<AssetId, Arc<GpuTexture>>,
    white: Arc<GpuTexture>,
    flat_normal: Arc<GpuTexture>,
    /// Along the tangent, at full strength.
    along: Arc<GpuTexture>,
}

impl MaterialStore {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            materials: HashMap::new(),
            textures: HashMap::new(),
            white: Arc::new(GpuTexture::new(gpu, &single_texel("white", [255; 4]))),
            flat_normal: Arc::new(GpuTexture::new(gpu, &single_texel("flat normal", [128, 128, 255, 255]))),
            along: Arc::new(GpuTexture::new(gpu, &single_texel("along the tangent", [255, 128, 255, 255]))),
        }
    }

    pub(super) fn get(&self, id: AssetId) -> Option<&GpuMaterial> {
        self.materials.get(&id)
    }

    /// Uploads what is new among the scene's materials and lets go of what is not used any more.
    pub(super) fn update<'a>(&mut self, gpu: &Gpu, used: impl Iterator<Item = &'a Arc<Material>>) {
        let used: HashMap<AssetId, &Arc<Material>> = used.map(|m| (m.id, m)).collect();
        self.materials.retain(|id, _| used.contains_key(id));
        let textures: HashMap<AssetId, &Arc<Texture>> =
            used.values().flat_map(|m| m.textures()).filter_map(|(t, _)| t).map(|t| (t.id, t)).collect();
        self.textures.retain(|id, _| textures.contains_key(id));
        let mut pending = 0;
        for (&id, texture) in &textures {
            self.textures.entry(id).or_insert_with(|| {
                let uploaded = Arc::new(GpuTexture::new(gpu, texture));
                pending += uploaded.bytes;
                uploaded
            });
            // Texels on their way to the device lie in memory of their own until they are sent.
            if pending > MAX_PENDING {
                gpu.submit(None);
                gpu.wait();
                pending = 0;
            }
        }
        for (&id, material) in &used {
            if !self.materials.contains_key(&id) {
                let uploaded = self.upload(gpu, material);
                self.materials.insert(id, uploaded);
            }
        }
    }

    fn upload(&self, gpu: &Gpu, material: &Material) -> GpuMaterial {
        let mut index = 0;
        let textures = material.textures().map(|(texture, _)| {
            let neutral = match index {
                index if NORMAL_MAPS.contains(&index) => &self.flat_normal,
                DIRECTIONS => &self.along,
                _ => &self.white,
            };
            index += 1;
            texture.and_then(|t| self.textures.get(&t.id)).unwrap_or(neutral).clone()
        });
        GpuMaterial { uniform: gpu.uniform(&material.name, &MaterialUniform::new(material)), textures }
    }

    /// Bytes of all textures on the device.
    pub(super) fn texture_bytes(&self) -> u64 {
        self.textures.values().map(|t| t.bytes).sum()
    }
}

fn single_texel(name: &str, texel: [u8; 4]) -> Texture {
    Texture {
        id: AssetId::fresh(),
        name: name.into(),
        width: 1,
        height: 1,
        rgba: texel.to_vec(),
        srgb: false,
        sampling: Sampling::default(),
    }
}
