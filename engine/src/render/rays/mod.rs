//! The scene as rays see it on the device: hierarchies, triangles, materials, textures, lights and emitters.
//!
//! Passes that cast rays import `lightwell::rays` and bind group 1 by [`RayScene::bind`].

mod atlas;
mod boxes;
mod emitters;
mod geometry;
mod lights;
mod materials;
mod words;

use crate::assets::AssetId;
use crate::bvh::SceneBvh;
use crate::gpu::{BindError, Binding, ComputeKey, Gpu, Pipeline, ShaderDef};
use crate::scene::Scene;
use atlas::Atlas;
use geometry::GpuGeometry;
use glam::Vec3;
use materials::GpuMaterials;
use std::collections::HashMap;
use words::Words;

#[cfg(test)]
pub(crate) use {emitters::Emitter, materials::RayMaterial};

/// Why a scene cannot be traced on this device.
#[derive(Debug, thiserror::Error)]
pub enum RayError {
    /// A buffer would be larger than the device can bind.
    #[error(
        "the scene's {what} take {needed} MiB, and this adapter binds at most {limit} MiB at once: use fewer or simpler models"
    )]
    TooLarge {
        /// What it holds.
        what: &'static str,
        /// Needed \[MiB\].
        needed: u64,
        /// Possible \[MiB\].
        limit: u64,
    },
    /// More textures than an array can hold.
    #[error("the scene's textures need {needed} layers of {size}² texels, and this adapter has at most {limit}")]
    Textures {
        /// Layers needed.
        needed: u32,
        /// Edge of a layer \[texels\].
        size: u32,
        /// Layers possible.
        limit: u32,
    },
}

/// A scene on the device, ready for rays.
pub struct RayScene {
    /// The same hierarchies on the CPU.
    pub bvh: SceneBvh,
    geometry: GpuGeometry,
    materials: GpuMaterials,
    atlas: Atlas,
    lights: Words,
    emitters: wgpu::Buffer,
    /// Mean colour of emissive textures, which takes its time to find.
    mean_colors: HashMap<AssetId, Vec3>,
    synced: Option<[u64; 4]>,
    /// Number of lights.
    pub light_count: u32,
    /// Number of triangles that emit light.
    pub emitter_count: u32,
}

impl RayScene {
    /// An empty scene.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            bvh: SceneBvh::default(),
            geometry: GpuGeometry::new(gpu),
            materials: GpuMaterials::new(gpu),
            atlas: Atlas::new(gpu),
            lights: Words::new(gpu, "ray lights", 1),
            emitters: gpu.storage("emitters", &[0.0_f32; 4], wgpu::BufferUsages::empty()),
            mean_colors: HashMap::new(),
            synced: None,
            light_count: 0,
            emitter_count: 0,
        }
    }

    /// Brings the device up to date with the scene. Costs nothing if nothing changed.
    ///
    /// # Errors
    /// If the scene is larger than the device can bind.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RayError> {
        let revisions = &scene.revisions;
        let state = [scene.identity, revisions.geometry, revisions.materials, revisions.lights];
        if self.synced == Some(state) {
            return Ok(());
        }
        let surfaces_changed = self.synced.is_none_or(|synced| synced[..3] != state[..3]);
        self.synced = None;
        if surfaces_changed {
            self.bvh.update(scene);
            self.atlas.update(gpu, scene)?;
            self.materials.update(gpu, scene, &self.atlas)?;
            let emitters = emitters::collect(scene, &self.bvh, &mut self.mean_colors);
            self.geometry.update(gpu, scene, &self.bvh, &self.materials, &emitters.of_triangle)?;
            self.emitter_count = emitters.list.len() as u32;
            self.emitters = gpu.storage("emitters", &emitters.list, wgpu::BufferUsages::empty());
        }
        self.light_count = scene.lights.len() as u32;
        self.lights.upload(gpu, "ray lights", "lights", &mut lights::texels(&scene.lights))?;
        self.synced = Some(state);
        Ok(())
    }

    /// What `trace` of `lib/rays.wgsl` is to know: the boxes of the hierarchy; 0 if there is nothing to meet.
    pub fn root(&self) -> u32 {
        self.geometry.box_count
    }

    /// The shader with all that this scene needs of `lib/rays.wgsl`, and no more.
    pub fn shader(&self, file: &'static str, entry: &'static str) -> ComputeKey {
        let flags = [
            ("EXACT_BOXES", self.geometry.exact_boxes),
            ("UNTEXTURED", !self.atlas.holds_textures()),
            ("OPAQUE", !self.materials.any_masked()),
            ("DIFFUSE", !self.materials.any_specular()),
            ("UNLIT", self.emitter_count == 0),
            ("DARK", !self.materials.any_emissive()),
            ("PLAIN", self.materials.is_plain()),
        ];
        let set = flags.into_iter().filter(|(_, set)| *set);
        set.fold(ComputeKey::new(file, entry), |key, (name, _)| key.def(name, ShaderDef::Flag(true)))
    }

    /// Binds as group 1 what the pipeline uses of the scene.
    ///
    /// # Errors
    /// If the shader declares something in that group that is not of the scene.
    pub fn bind(&self, gpu: &Gpu, pipeline: &Pipeline) -> Result<wgpu::BindGroup, BindError> {
        let used: Vec<_> = self.bindings().into_iter().filter(|(name, _)| pipeline.declares(1, name)).collect();
        for (name, _) in &used {
            gpu.audit.note(name, &self.content(name));
        }
        pipeline.bind(gpu, 1, &used)
    }

    /// Changes with what is bound under that name.
    fn content(&self, name: &str) -> Option<[u64; 3]> {
        let [identity, geometry, materials, lights] = self.synced?;
        Some(match name {
            "lights" => [identity, lights, 0],
            "nodes" => [identity, geometry, 0],
            _ => [identity, geometry, materials],
        })
    }

    /// Group 1 of all passes that cast rays.
    fn bindings(&self) -> [(&'static str, Binding<'_>); 8] {
        [
            ("nodes", Binding::Texture(self.geometry.nodes())),
            ("triangles", Binding::Texture(self.geometry.triangles())),
            ("attributes", Binding::Texture(self.geometry.attributes())),
            ("materials", Binding::Buffer(&self.materials.buffer)),
            ("emitters", Binding::Buffer(&self.emitters)),
            ("lights", Binding::Texture(self.lights.view())),
            ("atlas", Binding::Texture(self.atlas.view())),
            ("extras", Binding::Texture(self.geometry.extras())),
        ]
    }
}

/// Whether a buffer of so many bytes can be bound.
fn check_size(gpu: &Gpu, what: &'static str, bytes: u64) -> Result<(), RayError> {
    let limit = gpu.limits.max_storage_buffer_binding_size;
    if bytes > limit {
        return Err(RayError::TooLarge { what, needed: bytes.div_ceil(1 << 20), limit: limit >> 20 });
    }
    Ok(())
}
