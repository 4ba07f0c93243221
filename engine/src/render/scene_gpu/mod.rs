//! The scene's geometry and materials on the device, and how the raster passes draw them.
//!
//! Primitives with the same pipeline class, material and mesh form a batch whose instances lie together, so that
//! each run of visible instances is one draw. Batches are ordered by the least
//! [`SceneId`](crate::scene::SceneId) in them, never by the identity of an asset, and those of moving primitives come
//! after all others: where two surfaces coincide, the same one wins after every reload, and whether the moving ones are
//! drawn with the others or over a kept image of them.

mod batch;
mod blended;
mod block;
mod class;
pub(super) mod light_uniform;
mod material;
pub(in crate::render) mod media;
mod mesh;
mod scene_draws;
pub(in crate::render) mod sky;
mod submit;
pub(in crate::render) mod surfels;
mod sync;
mod texture;

pub use batch::{DrawFilter, Motion};
pub use blended::Side;
pub use class::{MaterialClass, vertex_layout};
pub(in crate::render) use scene_draws::{FilterOf, PipelineOf, SceneDraws};

use crate::assets::AssetId;
use crate::gpu::{Binding, Gpu, Pipeline, RasterKey};
use crate::graph::{PassBindings, PassContext, PassError};
use crate::scene::{Aabb, Primitive, is_mirrored};
use batch::{Batch, Member};
use block::Blocks;
use bytemuck::{Pod, Zeroable};
use material::{GpuMaterial, MaterialStore};
pub(super) use material::{MaterialLayers, alpha_cutoff};
use media::GpuMedia;
use mesh::MeshStore;
use sky::GpuSky;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use sync::{Mover, Synced};

#[cfg(test)]
pub(crate) use material::MaterialUniform;

/// `Instance` of `lib/mesh.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Instance {
    rows: [[f32; 4]; 3],
    id: u32,
    /// −1 if the transform mirrors, else 1.
    handedness: f32,
    padding: [u32; 2],
}

impl Instance {
    fn new(primitive: &Primitive) -> Self {
        let m = primitive.world_from_object;
        let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]];
        let handedness = if is_mirrored(&m) { -1.0 } else { 1.0 };
        Self { rows: [row(0), row(1), row(2)], id: primitive.id.0 as u32, handedness, padding: [0; 2] }
    }
}

/// The bindings of a pass so far.
#[derive(Default)]
struct Bound {
    /// Materials by what their pipeline uses of them.
    groups: HashMap<(MaterialClass, AssetId), Option<wgpu::BindGroup>>,
    material: Option<AssetId>,
    /// Page of meshes, and whether without their extras.
    page: Option<(usize, bool)>,
}

/// The scene on the device.
pub struct GpuScene {
    meshes: MeshStore,
    materials: MaterialStore,
    instances: wgpu::Buffer,
    batches: Vec<Batch>,
    blocks: Blocks,
    /// The data of each instance.
    members: Vec<Member>,
    /// Moving primitives in the order of their instances.
    movers: Vec<Mover>,
    /// Bounds of all that does not move.
    still_bounds: Aabb,
    sky: GpuSky,
    media: Option<GpuMedia>,
    /// Of the scene whose media they are.
    media_revision: [u64; 2],
    synced: Option<Synced>,
}

impl GpuScene {
    /// An empty scene.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            meshes: MeshStore::default(),
            materials: MaterialStore::new(gpu),
            instances: gpu.storage("instances", &[Instance::zeroed()], wgpu::BufferUsages::empty()),
            batches: Vec::new(),
            blocks: Blocks::default(),
            members: Vec::new(),
            movers: Vec::new(),
            still_bounds: Aabb::EMPTY,
            sky: GpuSky::new(gpu),
            media: None,
            media_revision: [0; 2],
            synced: None,
        }
    }

    /// Whether any primitive passes the filter.
    pub fn any_visible(&self, filter: &DrawFilter) -> bool {
        self.passing(filter).any(|block| self.any_passes(block, filter))
    }

    /// Draws all that passes the filter. `key` gives the pipeline of a class, and `group` what it binds as group 0 beside the
    /// `instances`; of the material it binds what the shader declares.
    ///
    /// # Errors
    /// A shader that does not compile, or that declares a binding that is not there.
    pub(in crate::render) fn draw(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        group: &[(&str, Binding<'_>)],
        filter: &DrawFilter,
        key: impl Fn(MaterialClass) -> RasterKey,
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let mut bound = Bound::default();
        let mut current = None;
        let list = self.draw_list(gpu, filter);
        self.note_drawn(gpu, filter);
        for segment in &list.segments {
            let batch = segment.batch;
            if current.as_ref().is_none_or(|(class, _)| *class != batch.class) {
                current = Some((batch.class, self.set_pipeline(gpu, pass, group, &key(batch.class))?));
                bound.material = None;
            }
            let Some((_, pipeline)) = &current else { continue };
            self.set_batch(gpu, pass, pipeline, batch, segment.page, &mut bound)?;
            list.record(pass, segment, cx.counts());
        }
        Ok(())
    }

    /// Notes what a pass draws, for an audit of its key.
    fn note_drawn(&self, gpu: &Gpu, filter: &DrawFilter) {
        if gpu.audit.is_on() {
            let batches = self.batches.iter().filter(|batch| batch.passes(filter));
            let drawn = batches.flat_map(|batch| batch.of(&self.members)).filter(|member| member.visible(filter));
            gpu.audit.note("drawn primitives", &drawn.map(|member| (member.id, member.revisions)).collect::<Vec<_>>());
        }
    }

    fn set_pipeline(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        group: &[(&str, Binding<'_>)],
        key: &RasterKey,
    ) -> Result<Arc<Pipeline>, PassError> {
        let pipeline = gpu.pipelines.raster(gpu, key)?;
        if let Some(raster) = pipeline.raster() {
            pass.set_pipeline(raster);
        }
        let instances = ("instances", Binding::Buffer(&self.instances));
        let group: Vec<_> = group.iter().cloned().chain([instances]).collect();
        pass.set_bind_group(0, &pipeline.bind(gpu, 0, &group)?, &[]);
        Ok(pipeline)
    }

    /// Material and buffers of a batch, unless they are bound already.
    fn set_batch(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &Pipeline,
        batch: &Batch,
        page: usize,
        bound: &mut Bound,
    ) -> Result<(), PassError> {
        if bound.material != Some(batch.material) {
            if let Some(group) = self.material_group(gpu, pipeline, batch, bound)? {
                pass.set_bind_group(1, group, &[]);
            }
            bound.material = Some(batch.material);
        }
        if bound.page != Some((page, batch.class.plain)) {
            self.meshes.bind(pass, page, batch.class.plain);
            bound.page = Some((page, batch.class.plain));
        }
        Ok(())
    }

    /// What the pipeline uses of a batch's material, made once a pass; none if it uses nothing.
    fn material_group<'b>(
        &self,
        gpu: &Gpu,
        pipeline: &Pipeline,
        batch: &Batch,
        bound: &'b mut Bound,
    ) -> Result<Option<&'b wgpu::BindGroup>, PassError> {
        Ok(match bound.groups.entry((batch.class, batch.material)) {
            Entry::Occupied(known) => known.into_mut().as_ref(),
            Entry::Vacant(unknown) => {
                let bindings = self.materials.get(batch.material).map(GpuMaterial::bindings);
                let used: Vec<_> =
                    bindings.into_iter().flatten().filter(|(name, _)| pipeline.declares(1, name)).collect();
                let group = if used.is_empty() { None } else { Some(pipeline.bind(gpu, 1, &used)?) };
                unknown.insert(group).as_ref()
            }
        })
    }

    /// The sky by direction; one black texel if it is the same everywhere.
    pub fn sky(&self) -> &wgpu::TextureView {
        self.sky.view()
    }

    /// Binds the media to a pass, if there are any.
    pub(in crate::render) fn bind_media(&self, pass: &mut PassBindings) {
        if let Some(media) = &self.media {
            media.bind(pass);
        }
    }

    /// Whether any surface is of glass.
    pub fn has_glass(&self) -> bool {
        self.batches.iter().any(|batch| batch.class.glass)
    }

    /// Whether any surface has a lobe that is drawn apart.
    pub fn has_second_lobes(&self) -> bool {
        self.batches.iter().any(|batch| batch.class.second_lobe)
    }

    /// Bytes of textures on the device.
    pub fn texture_bytes(&self) -> u64 {
        self.materials.texture_bytes()
    }
}
