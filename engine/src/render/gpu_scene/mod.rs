//! The scene's geometry and materials on the device, and how the raster passes draw them.
//!
//! Primitives with the same pipeline class, material and mesh form a batch whose instances lie together, so that
//! each run of visible instances is one draw. Batches are ordered by the least [`SceneId`] in them, never by the
//! identity of an asset: where two surfaces coincide, the same one wins after every reload.

mod batch;
mod blended;
mod class;
mod material;
mod texture;

pub use batch::DrawFilter;
pub use blended::Side;
pub use class::{MaterialClass, vertex_layout};

use super::sky::{GpuSky, SkyReflections};
use crate::assets::{AssetId, Mesh, VertexExtra};
use crate::gpu::{Binding, Gpu, Pipeline, RasterKey};
use crate::graph::{PassContext, PassError};
use crate::scene::{Primitive, Scene, SceneId};
use batch::{Batch, Member};
use bytemuck::{Pod, Zeroable};
pub(super) use material::alpha_cutoff;
use material::is_nowhere_opaque;
use material::{GpuMaterial, MaterialStore};
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

#[cfg(test)]
pub(crate) use material::MaterialUniform;

/// `Instance` of `lib/mesh.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Instance {
    rows: [[f32; 4]; 3],
    id: u32,
    padding: [u32; 3],
}

impl Instance {
    fn new(primitive: &Primitive) -> Self {
        let m = primitive.world_from_object;
        let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]];
        Self { rows: [row(0), row(1), row(2)], id: primitive.id.0 as u32, padding: [0; 3] }
    }
}

struct GpuMesh {
    topology: AssetId,
    vertices: wgpu::Buffer,
    /// For draws that are not plain.
    extras: Option<wgpu::Buffer>,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl GpuMesh {
    fn new(gpu: &Gpu, mesh: &Mesh) -> Self {
        Self {
            topology: mesh.topology(),
            vertices: gpu.storage(
                &mesh.name,
                &mesh.vertices,
                wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            ),
            extras: None,
            indices: gpu.storage(&mesh.name, &mesh.indices, wgpu::BufferUsages::INDEX),
            index_count: mesh.indices.len() as u32,
        }
    }

    /// The buffers with another pose of the same mesh in them.
    fn posed(self, gpu: &Gpu, mesh: &Mesh) -> Self {
        gpu.queue.write_buffer(&self.vertices, 0, bytemuck::cast_slice(&mesh.vertices));
        self
    }

    fn add_extras(&mut self, gpu: &Gpu, mesh: &Mesh) {
        self.extras.get_or_insert_with(|| {
            let neutral;
            let extras = match &mesh.extras {
                Some(extras) => extras.as_slice(),
                None => {
                    neutral = vec![VertexExtra::NEUTRAL; mesh.vertices.len()];
                    &neutral
                }
            };
            gpu.storage(&mesh.name, extras, wgpu::BufferUsages::VERTEX)
        });
    }
}

/// What a pass has bound so far.
#[derive(Default)]
struct Bound {
    /// Materials by what their pipeline uses of them.
    groups: HashMap<(MaterialClass, AssetId), Option<wgpu::BindGroup>>,
    material: Option<AssetId>,
    /// And whether without its extras.
    mesh: Option<(AssetId, bool)>,
}

/// The scene on the device.
pub struct GpuScene {
    meshes: HashMap<AssetId, GpuMesh>,
    materials: MaterialStore,
    instances: wgpu::Buffer,
    batches: Vec<Batch>,
    sky: GpuSky,
    synced: Option<(u64, u64, u64)>,
}

impl GpuScene {
    /// An empty scene.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            meshes: HashMap::new(),
            materials: MaterialStore::new(gpu),
            instances: gpu.storage("instances", &[Instance::zeroed()], wgpu::BufferUsages::empty()),
            batches: Vec::new(),
            sky: GpuSky::new(gpu),
            synced: None,
        }
    }

    /// Brings the device up to date with the scene; costs nothing if no primitive changed.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) {
        self.sky.update(gpu, scene);
        let state = (scene.identity, scene.revisions.geometry, scene.revisions.materials);
        if self.synced == Some(state) {
            return;
        }
        self.materials.update(gpu, scene.primitives.iter().map(|p| &p.material));
        self.update_meshes(gpu, scene);
        self.update_batches(gpu, scene);
        self.synced = Some(state);
    }

    fn update_meshes(&mut self, gpu: &Gpu, scene: &Scene) {
        let used: HashMap<AssetId, &Mesh> = scene.primitives.iter().map(|p| (p.mesh.id, &*p.mesh)).collect();
        // Poses that are gone leave their buffers to those that come.
        let gone: Vec<AssetId> = self.meshes.keys().filter(|id| !used.contains_key(id)).copied().collect();
        let mut free: HashMap<AssetId, Vec<GpuMesh>> = HashMap::new();
        for mesh in gone.iter().filter_map(|id| self.meshes.remove(id)) {
            free.entry(mesh.topology).or_default().push(mesh);
        }
        for (&id, mesh) in used.iter().filter(|(_, mesh)| !mesh.indices.is_empty()) {
            self.meshes.entry(id).or_insert_with(|| match free.get_mut(&mesh.topology()).and_then(Vec::pop) {
                Some(old) => old.posed(gpu, mesh),
                None => GpuMesh::new(gpu, mesh),
            });
        }
        for primitive in scene.primitives.iter().filter(|p| !MaterialClass::of(p).plain) {
            if let Some(mesh) = self.meshes.get_mut(&primitive.mesh.id) {
                mesh.add_extras(gpu, &primitive.mesh);
            }
        }
    }

    fn update_batches(&mut self, gpu: &Gpu, scene: &Scene) {
        let mut groups: BTreeMap<(MaterialClass, AssetId, AssetId), Vec<&Primitive>> = BTreeMap::new();
        for primitive in scene.primitives.iter().filter(|p| !p.mesh.indices.is_empty()) {
            let key = (MaterialClass::of(primitive), primitive.material.id, primitive.mesh.id);
            groups.entry(key).or_default().push(primitive);
        }
        let mut groups: Vec<_> = groups.into_iter().collect();
        groups.sort_by_key(|(_, members)| members.iter().map(|p| p.id).min().unwrap_or(SceneId::default()));
        let mut instances = Vec::with_capacity(scene.primitives.len());
        self.batches.clear();
        for ((class, material, mesh), members) in groups {
            let first_instance = instances.len() as u32;
            instances.extend(members.iter().map(|p| Instance::new(p)));
            let nowhere_opaque = members.iter().any(|p| is_nowhere_opaque(&p.material));
            let members = members.iter().map(|p| Member::new(p)).collect();
            self.batches.push(Batch { class, nowhere_opaque, material, mesh, first_instance, members });
        }
        if instances.is_empty() {
            instances.push(Instance::zeroed());
        }
        let bytes: &[u8] = bytemuck::cast_slice(&instances);
        if self.instances.size() == bytes.len() as u64 {
            gpu.queue.write_buffer(&self.instances, 0, bytes);
        } else {
            self.instances = gpu.storage("instances", &instances, wgpu::BufferUsages::COPY_DST);
        }
    }

    /// Whether any primitive passes the filter.
    pub fn any_visible(&self, filter: &DrawFilter) -> bool {
        self.batches.iter().flat_map(|b| &b.members).any(|m| m.visible(filter))
    }

    /// Draws all that passes the filter. `key` gives the pipeline of a class; the shader finds the view's uniform
    /// under the name `view` and, where it declares them, `instances` and the material's bindings.
    ///
    /// # Errors
    /// A shader that does not compile, or that declares a binding that is not there.
    pub fn draw(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        view: &wgpu::Buffer,
        filter: &DrawFilter,
        key: impl Fn(MaterialClass) -> RasterKey,
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let mut bound = Bound::default();
        let mut current = None;
        for batch in &self.batches {
            if filter.opaque_only && batch.nowhere_opaque {
                continue;
            }
            let mut runs = batch.visible_runs(filter).peekable();
            let Some(mesh) = self.meshes.get(&batch.mesh).filter(|_| runs.peek().is_some()) else { continue };
            if current.as_ref().is_none_or(|(class, _)| *class != batch.class) {
                current = Some((batch.class, self.set_pipeline(gpu, pass, view, &key(batch.class))?));
                bound.material = None;
            }
            let Some((_, pipeline)) = &current else { continue };
            self.set_batch(gpu, pass, pipeline, batch, mesh, &mut bound)?;
            for run in runs {
                draw_run(cx, pass, mesh, run);
            }
        }
        Ok(())
    }

    fn set_pipeline(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        view: &wgpu::Buffer,
        key: &RasterKey,
    ) -> Result<Arc<Pipeline>, PassError> {
        let pipeline = gpu.pipelines.raster(gpu, key)?;
        if let Some(raster) = pipeline.raster() {
            pass.set_pipeline(raster);
        }
        let group = [("view", Binding::Buffer(view)), ("instances", Binding::Buffer(&self.instances))];
        pass.set_bind_group(0, &pipeline.bind(gpu, 0, &group)?, &[]);
        Ok(pipeline)
    }

    /// Material and mesh of a batch, unless they are bound already.
    fn set_batch(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &Pipeline,
        batch: &Batch,
        mesh: &GpuMesh,
        bound: &mut Bound,
    ) -> Result<(), PassError> {
        if bound.material != Some(batch.material) {
            if let Some(group) = self.material_group(gpu, pipeline, batch, bound)? {
                pass.set_bind_group(1, group, &[]);
            }
            bound.material = Some(batch.material);
        }
        if bound.mesh != Some((batch.mesh, batch.class.plain)) {
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            if let Some(extras) = mesh.extras.as_ref().filter(|_| !batch.class.plain) {
                pass.set_vertex_buffer(1, extras.slice(..));
            }
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            bound.mesh = Some((batch.mesh, batch.class.plain));
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

    /// What glossy surfaces reflect of a sky that differs by direction, once [`GpuScene::update_sky_reflections`] made it.
    pub(in crate::render) fn sky_reflections(&self) -> Option<&SkyReflections> {
        self.sky.reflections()
    }

    /// Makes what glossy surfaces reflect of the sky, unless it is there.
    pub fn update_sky_reflections(&mut self, gpu: &Gpu, scene: &Scene) {
        self.sky.update_reflections(gpu, scene);
    }

    /// Bytes of textures on the device.
    pub fn texture_bytes(&self) -> u64 {
        self.materials.texture_bytes()
    }
}

fn draw_run(cx: &mut PassContext, pass: &mut wgpu::RenderPass<'_>, mesh: &GpuMesh, run: Range<u32>) {
    let instances = run.len() as u64;
    pass.draw_indexed(0..mesh.index_count, 0, run);
    let counts = cx.counts();
    counts.draws += 1;
    counts.triangles += instances * u64::from(mesh.index_count / 3);
}
