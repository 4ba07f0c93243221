//! Materials as rays read them: factors, and where in the atlas their textures lie.

use super::atlas::Atlas;
use super::{RayError, check_size};
use crate::assets::{AssetId, Material, TEXTURE_COUNT, Texture};
use crate::gpu::{Gpu, ShaderDef};
use crate::render::scene_gpu::{MaterialLayers, alpha_cutoff};
use crate::scene::Scene;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// Perceptual roughness up to which a surface has rays of its own for what it reflects by its specular lobe. The gather's rays
/// follow that by chance, and its filter leaves the light of a narrow lobe alone.
const MIRROR_ROUGHNESS: f32 = 0.45;
/// The same where the gather's rays serve rough lobes: of surfaces that reflect more diffusely in windows, where rays are few and
/// what a rough lobe adds is faint; and of all where something emits light, which the gather samples and rays of mirrors meet by
/// chance alone.
const SMOOTH: f32 = 0.25;

/// How shaders know of which uses there are textures, in the order of [`Material::textures`]: see `lib/ray_textures.wgsl`.
const TEXTURE_DEFINES: [&str; TEXTURE_COUNT] = [
    "BASE_COLOR_TEXTURES",
    "METALLIC_ROUGHNESS_TEXTURES",
    "NORMAL_TEXTURES",
    "EMISSIVE_TEXTURES",
    "SPECULAR_TEXTURES",
    "SPECULAR_COLOR_TEXTURES",
    "TRANSMISSION_TEXTURES",
    "CLEARCOAT_TEXTURES",
    "CLEARCOAT_ROUGHNESS_TEXTURES",
    "CLEARCOAT_NORMAL_TEXTURES",
    "SHEEN_COLOR_TEXTURES",
    "SHEEN_ROUGHNESS_TEXTURES",
    "ANISOTROPY_TEXTURES",
    "IRIDESCENCE_TEXTURES",
    "IRIDESCENCE_THICKNESS_TEXTURES",
];

/// How shaders know which surfaces have rays of their own for what they mirror: those up to that roughness \[%\], or the
/// smooth ones alone.
pub(in crate::render) fn mirror_define(are_smooth: bool) -> (&'static str, ShaderDef) {
    let roughness = if are_smooth { SMOOTH } else { MIRROR_ROUGHNESS };
    ("MIRRORS", ShaderDef::Uint((roughness * 100.0).round() as u32))
}

/// The same where all of them have.
pub(in crate::render) fn all_mirror_define() -> (&'static str, ShaderDef) {
    ("MIRRORS", ShaderDef::Uint(100))
}

/// `Material` of `lib/ray_scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct RayMaterial {
    base_color: [f32; 4],
    emissive: [f32; 3],
    metallic: f32,
    specular_color: [f32; 3],
    roughness: f32,
    specular: f32,
    alpha_cutoff: f32,
    normal_scale: f32,
    double_sided: u32,
    /// \[1/m\]
    absorption: [f32; 3],
    transmission: f32,
    ior: f32,
    is_solid: u32,
    dispersion: f32,
    padding: u32,
    sheen: [f32; 4],
    iridescence: [f32; 4],
    clearcoat: [f32; 3],
    padding_of_clearcoat: u32,
    anisotropy: [f32; 3],
    padding_of_anisotropy: u32,
    /// In the order of [`Material::textures`].
    textures: [[u32; 4]; TEXTURE_COUNT],
    uv_rows: [[f32; 4]; 2 * TEXTURE_COUNT],
}

impl RayMaterial {
    fn new(material: &Material, atlas: &Atlas) -> Self {
        let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
        let positive = |v: Vec3| if v.is_finite() { v.max(Vec3::ZERO).min(Vec3::splat(1e30)) } else { Vec3::ZERO };
        let base_color = material.base_color;
        let layers = MaterialLayers::of(material);
        Self {
            base_color: if base_color.is_finite() { base_color.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::W }
                .to_array(),
            emissive: positive(material.emissive).to_array(),
            metallic: unit(material.metallic),
            specular_color: positive(material.dielectric_reflectance()).to_array(),
            roughness: unit(material.roughness),
            specular: unit(material.specular),
            alpha_cutoff: alpha_cutoff(material),
            normal_scale: if material.normal_scale.is_finite() { material.normal_scale } else { 0.0 },
            double_sided: u32::from(material.double_sided),
            absorption: positive(material.volume.map_or(Vec3::ZERO, |volume| volume.absorption())).to_array(),
            transmission: if material.is_glass() { unit(material.transmission) } else { 0.0 },
            ior: if material.ior.is_finite() { material.ior.clamp(1.0, 10.0) } else { 1.0 },
            is_solid: u32::from(material.volume.is_some()),
            dispersion: if material.dispersion.is_finite() { material.dispersion.clamp(0.0, 100.0) } else { 0.0 },
            padding: 0,
            sheen: layers.sheen,
            iridescence: layers.iridescence,
            clearcoat: layers.clearcoat,
            padding_of_clearcoat: 0,
            anisotropy: layers.anisotropy,
            padding_of_anisotropy: 0,
            textures: material.textures().map(|(texture, _)| texture.map_or([0; 4], |texture| atlas.slot(texture.id))),
            uv_rows: material.uv_rows(),
        }
    }
}

/// Which layers the materials of a scene have.
#[derive(Clone, Copy, Default)]
pub(super) struct Layers {
    pub coats: bool,
    pub sheen: bool,
    pub films: bool,
    pub anisotropy: bool,
}

impl Layers {
    fn of(scene: &Scene) -> Self {
        let layered = scene.primitives.iter().map(|p| &p.material).filter(|material| material.has_layers());
        layered.map(|material| MaterialLayers::of(material)).fold(Self::default(), |found, layers| Self {
            coats: found.coats || layers.clearcoat[0] > 0.0,
            sheen: found.sheen || layers.sheen[..3].iter().any(|channel| *channel > 0.0),
            films: found.films || layers.iridescence[0] > 0.0,
            anisotropy: found.anisotropy || layers.anisotropy[0] > 0.0,
        })
    }

    fn is_any(self) -> bool {
        self.coats || self.sheen || self.films || self.anisotropy
    }
}

/// Materials on the device.
pub(super) struct GpuMaterials {
    pub(super) buffer: wgpu::Buffer,
    indices: HashMap<AssetId, u32>,
    masked: Vec<bool>,
    specular: bool,
    mirror: bool,
    emissive: bool,
    plain: bool,
    /// Of which uses there are textures, in the order of [`Material::textures`].
    textured: [bool; TEXTURE_COUNT],
    has_glass: bool,
    layers: Layers,
    has_dispersion: bool,
    /// Least roughness of textures that were looked at.
    least_roughness: HashMap<AssetId, f32>,
}

impl GpuMaterials {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let buffer = gpu.storage("ray materials", &[RayMaterial::zeroed()], wgpu::BufferUsages::empty());
        Self {
            buffer,
            indices: HashMap::new(),
            masked: Vec::new(),
            specular: false,
            mirror: false,
            emissive: false,
            plain: true,
            textured: [false; TEXTURE_COUNT],
            has_glass: false,
            layers: Layers::default(),
            has_dispersion: false,
            least_roughness: HashMap::new(),
        }
    }

    /// Uploads all materials of the scene, those of dynamic objects last: the indices of the others do not depend on them.
    pub(super) fn update(&mut self, gpu: &Gpu, scene: &Scene, atlas: &Atlas) -> Result<(), RayError> {
        self.indices.clear();
        self.masked.clear();
        self.specular = scene.primitives.iter().any(|p| reflects_specularly(&p.material) || p.material.is_glass());
        self.mirror = self.find_mirrors(scene);
        self.emissive = scene.primitives.iter().any(|p| p.material.emissive != Vec3::ZERO);
        self.plain = scene.primitives.iter().all(|p| p.mesh.extras.is_none() && p.material.is_plain());
        self.textured = textured_uses(scene);
        self.has_glass = scene.primitives.iter().any(|p| p.material.is_glass());
        self.layers = Layers::of(scene);
        self.specular |= self.layers.is_any();
        self.has_dispersion = scene.primitives.iter().any(|p| parts_colors(&p.material));
        let mut list = Vec::new();
        let of_kind = |is_moving: bool| scene.primitives.iter().filter(move |p| p.moving == is_moving);
        for primitive in of_kind(false).chain(of_kind(true)) {
            let material = &primitive.material;
            self.indices.entry(material.id).or_insert_with(|| {
                list.push(RayMaterial::new(material, atlas));
                self.masked.push(alpha_cutoff(material) >= 0.0);
                list.len() as u32 - 1
            });
        }
        list.resize(list.len().max(1), RayMaterial::zeroed());
        check_size(gpu, "materials", size_of_val(list.as_slice()) as u64)?;
        self.buffer = gpu.storage("ray materials", &list, wgpu::BufferUsages::empty());
        Ok(())
    }

    fn find_mirrors(&mut self, scene: &Scene) -> bool {
        let before = std::mem::take(&mut self.least_roughness);
        let mut is_any = false;
        for material in scene.primitives.iter().map(|primitive| &primitive.material) {
            if !reflects_specularly(material) || material.is_glass() {
                continue;
            }
            let least = material.metallic_roughness_texture.as_ref().map_or(1.0, |texture| {
                let known = before.get(&texture.id).copied();
                *self.least_roughness.entry(texture.id).or_insert_with(|| known.unwrap_or_else(|| least_green(texture)))
            });
            is_any |= material.roughness * least <= MIRROR_ROUGHNESS;
        }
        is_any
    }

    pub(super) fn index(&self, material: AssetId) -> u32 {
        self.indices.get(&material).copied().unwrap_or(0)
    }

    pub(super) fn any_masked(&self) -> bool {
        self.masked.contains(&true)
    }

    /// Whether any material is not purely diffuse.
    pub(super) fn any_specular(&self) -> bool {
        self.specular
    }

    /// Whether any material is smooth enough to show an image of what it reflects.
    pub(super) fn any_mirror(&self) -> bool {
        self.mirror
    }

    /// Whether any surface lets light pass.
    pub(super) fn any_glass(&self) -> bool {
        self.has_glass
    }

    /// Whether any solid body of glass parts colours.
    pub(super) fn any_dispersion(&self) -> bool {
        self.has_dispersion
    }

    /// Whether any has more than the metallic-roughness base.
    pub(super) fn any_layers(&self) -> bool {
        self.layers.is_any()
    }

    /// Which layers there are.
    pub(super) fn layers(&self) -> Layers {
        self.layers
    }

    /// Whether any material emits light.
    pub(super) fn any_emissive(&self) -> bool {
        self.emissive
    }

    /// Whether all textures lie by one set of coordinates as it is, and no mesh has colours.
    pub(super) fn is_plain(&self) -> bool {
        self.plain
    }

    /// The defines of those uses of textures that there are.
    pub(super) fn texture_defines(&self) -> impl Iterator<Item = &'static str> {
        TEXTURE_DEFINES.into_iter().zip(self.textured).filter_map(|(define, is_used)| is_used.then_some(define))
    }

    pub(super) fn is_masked(&self, index: u32) -> bool {
        self.masked.get(index as usize).copied().unwrap_or(false)
    }
}

/// Of which uses any material has a texture.
fn textured_uses(scene: &Scene) -> [bool; TEXTURE_COUNT] {
    scene.primitives.iter().fold([false; TEXTURE_COUNT], |found, primitive| {
        let here = primitive.material.textures().map(|(texture, _)| texture.is_some());
        std::array::from_fn(|at| found[at] || here[at])
    })
}

fn parts_colors(material: &Material) -> bool {
    material.dispersion > 0.0 && material.volume.is_some() && material.is_glass()
}

fn reflects_specularly(material: &Material) -> bool {
    material.specular != 0.0 || material.metallic != 0.0
}

/// The least value of a texture's green channel, which holds roughness, 0 to 1.
fn least_green(texture: &Texture) -> f32 {
    let least = texture.rgba.chunks_exact(4).map(|texel| texel[1]).min();
    f32::from(least.unwrap_or(u8::MAX)) / 255.0
}
