//! Upload of materials: factors in a uniform buffer, textures, and neutral textures where there is none.

use super::texture::GpuTexture;
use crate::assets::{AlphaMode, AssetId, Material, Sampling, Texture};
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
    uv_rows: [Vec4; 14],
}

impl MaterialUniform {
    fn new(material: &Material) -> Self {
        let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
        let positive = |v: Vec3| if v.is_finite() { v.max(Vec3::ZERO) } else { Vec3::ZERO };
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
            uv_rows: material.uv_rows().map(Vec4::from),
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

/// A material on the device.
#[derive(Debug)]
pub(super) struct GpuMaterial {
    uniform: wgpu::Buffer,
    base_color: Arc<GpuTexture>,
    metallic_roughness: Arc<GpuTexture>,
    normal: Arc<GpuTexture>,
    emissive: Arc<GpuTexture>,
    specular: Arc<GpuTexture>,
    specular_color: Arc<GpuTexture>,
    transmission: Arc<GpuTexture>,
}

impl GpuMaterial {
    /// All that a shader may bind of it, by its name in WGSL.
    pub(super) fn bindings(&self) -> [(&'static str, Binding<'_>); 15] {
        [
            ("material", Binding::Buffer(&self.uniform)),
            ("base_color_texture", Binding::Texture(&self.base_color.view)),
            ("base_color_sampler", Binding::Sampler(&self.base_color.sampler)),
            ("metallic_roughness_texture", Binding::Texture(&self.metallic_roughness.view)),
            ("metallic_roughness_sampler", Binding::Sampler(&self.metallic_roughness.sampler)),
            ("normal_texture", Binding::Texture(&self.normal.view)),
            ("normal_sampler", Binding::Sampler(&self.normal.sampler)),
            ("emissive_texture", Binding::Texture(&self.emissive.view)),
            ("emissive_sampler", Binding::Sampler(&self.emissive.sampler)),
            ("specular_texture", Binding::Texture(&self.specular.view)),
            ("specular_sampler", Binding::Sampler(&self.specular.sampler)),
            ("specular_color_texture", Binding::Texture(&self.specular_color.view)),
            ("specular_color_sampler", Binding::Sampler(&self.specular_color.sampler)),
            ("transmission_texture", Binding::Texture(&self.transmission.view)),
            ("transmission_sampler", Binding::Sampler(&self.transmission.sampler)),
        ]
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
}

impl MaterialStore {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            materials: HashMap::new(),
            textures: HashMap::new(),
            white: Arc::new(GpuTexture::new(gpu, &single_texel("white", [255; 4]))),
            flat_normal: Arc::new(GpuTexture::new(gpu, &single_texel("flat normal", [128, 128, 255, 255]))),
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
        let find = |texture: Option<&Arc<Texture>>, neutral: &Arc<GpuTexture>| {
            texture.and_then(|t| self.textures.get(&t.id)).unwrap_or(neutral).clone()
        };
        let [base_color, metallic_roughness, normal, emissive, specular, specular_color, transmission] =
            material.textures().map(|(texture, _)| texture);
        GpuMaterial {
            uniform: gpu.uniform(&material.name, &MaterialUniform::new(material)),
            base_color: find(base_color, &self.white),
            metallic_roughness: find(metallic_roughness, &self.white),
            normal: find(normal, &self.flat_normal),
            emissive: find(emissive, &self.white),
            specular: find(specular, &self.white),
            specular_color: find(specular_color, &self.white),
            transmission: find(transmission, &self.white),
        }
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
