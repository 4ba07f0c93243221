//! The scene's surfels on the device.

use crate::gpu::{Changing, Gpu};
use crate::graph::{PassBindings, Tracked, hash};
use crate::scene::{Scene, Surfel, SurfelCloud, cells_from_world};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use std::hash::Hash;
use wgpu::BufferUsages;

/// Rows of a transform.
fn rows(m: &Affine3A) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]])
}

/// Identities in ascending order, filled up to whole vectors of four with the largest number. Buffers are that long, and
/// shaders search all that is in one: zeros after the last identity would be out of order.
fn searchable(ids: &[u32]) -> Vec<u32> {
    let mut all = ids.to_vec();
    all.resize(ids.len().next_multiple_of(4).max(4), u32::MAX);
    all
}

/// `PatchGrid` of `lib/patches.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct PatchGrid {
    rows: [[f32; 4]; 3],
    first: u32,
    places: u32,
    nodes: u32,
    padding: u32,
}

/// The patches of the surfels, and where they are looked for.
#[derive(Debug)]
pub(in crate::render) struct GpuPatches {
    ranges: wgpu::Buffer,
    table: wgpu::Buffer,
    place_of_primitive: wgpu::Buffer,
    grids: Changing<PatchGrid>,
}

impl GpuPatches {
    fn new(gpu: &Gpu) -> Self {
        let empty = |label: &str| gpu.storage(label, &[PatchGrid::default()], BufferUsages::empty());
        Self {
            ranges: empty("patches"),
            table: gpu.storage("patch table", &[[0_u32; 8]; 2], BufferUsages::empty()),
            place_of_primitive: empty("places of primitives"),
            grids: Changing::new(gpu, "patch grids", vec![PatchGrid::default()]),
        }
    }

    fn upload(&mut self, gpu: &Gpu, cloud: &SurfelCloud) {
        let or_empty = |places: &[u32]| if places.is_empty() { vec![0] } else { places.to_vec() };
        let ranges = if cloud.patches.ranges.is_empty() { &[[0_u32; 2]][..] } else { &cloud.patches.ranges };
        self.ranges = gpu.storage("patches", ranges, BufferUsages::empty());
        self.table = gpu.storage("patch table", &cloud.patches.table, BufferUsages::COPY_DST);
        let places = or_empty(&cloud.place_of_primitive);
        self.place_of_primitive = gpu.storage("places of primitives", &places, BufferUsages::empty());
        self.place(gpu, cloud);
    }

    fn place(&mut self, gpu: &Gpu, cloud: &SurfelCloud) {
        let grids = cloud.places.iter().enumerate().map(|(group, place)| {
            let table = cloud.patches.table_of(group);
            PatchGrid {
                rows: rows(&cells_from_world(place, cloud.patches.size)),
                first: table.first,
                places: table.places,
                nodes: table.nodes,
                padding: 0,
            }
        });
        self.grids.set(gpu, grids.collect());
    }

    /// Uploads where the patches of objects that bend are found.
    fn bend(&self, gpu: &Gpu, cloud: &SurfelCloud) {
        let (first, places) = cloud.patches.bending();
        if !places.is_empty() {
            gpu.write_buffer(&self.table, (first * size_of::<[u32; 8]>()) as u64, bytemuck::cast_slice(places));
        }
    }

    /// Binds them to a pass whose shader looks patches up, with the revision of the surfels.
    pub(in crate::render) fn bind<'a>(&'a self, pass: &mut PassBindings<'_, 'a>, revision: &impl Hash) {
        self.bind_grids(pass, revision);
        pass.tracked("place_of_primitive", Tracked::buffer(&self.place_of_primitive, revision));
    }

    /// The same of a shader that knows in which place it looks.
    pub(in crate::render) fn bind_grids<'a>(&'a self, pass: &mut PassBindings<'_, 'a>, revision: &impl Hash) {
        pass.tracked("patch_table", Tracked::buffer(&self.table, revision));
        pass.tracked("patch_grids", Tracked::buffer(self.grids.buffer(), revision));
    }
}

/// Surfels in object space and the places of their objects, as buffers.
#[derive(Debug)]
pub struct GpuSurfels {
    cloud: SurfelCloud,
    surfels: wgpu::Buffer,
    places: Changing<[[f32; 4]; 3]>,
    patches: GpuPatches,
    /// Revisions of the cloud: of its content, of what was uploaded as a whole, and of its layout.
    uploaded: u64,
    rebuilt: u64,
    layout: u64,
    placed: Vec<Affine3A>,
    /// Of the scene's primitives, in their order, here and on the device.
    ids: Vec<u32>,
    primitive_ids: wgpu::Buffer,
    is_moving: bool,
    is_replaced: bool,
}

impl GpuSurfels {
    /// No surfels yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            cloud: SurfelCloud::default(),
            surfels: gpu.storage("surfel cloud", &[Surfel::default()], BufferUsages::empty()),
            places: Changing::new(gpu, "surfel places", vec![[[0.0; 4]; 3]]),
            patches: GpuPatches::new(gpu),
            uploaded: 0,
            rebuilt: 0,
            layout: 0,
            is_moving: false,
            is_replaced: false,
            placed: Vec::new(),
            ids: Vec::new(),
            primitive_ids: gpu.storage("ids of primitives", &searchable(&[]), BufferUsages::empty()),
        }
    }

    /// Updates the surfels from the scene, as dense as the finest cells need them. Costs nothing if nothing
    /// changed; an object that only moved costs its transform, and one that only bent its own surfels.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene, finest_cell: f32) {
        self.cloud.update(scene, finest_cell);
        self.name_primitives(gpu, scene);
        self.is_replaced = self.layout != self.cloud.layout;
        self.layout = self.cloud.layout;
        let has_bent = self.uploaded != self.cloud.revision;
        self.is_moving = has_bent || self.placed != self.cloud.places;
        if self.rebuilt != self.cloud.rebuilt {
            self.upload(gpu);
        } else if has_bent {
            self.bend(gpu);
        }
        self.uploaded = self.cloud.revision;
        if self.placed != self.cloud.places {
            self.placed.clone_from(&self.cloud.places);
            self.places.set(gpu, self.placed.iter().map(rows).collect());
            self.patches.place(gpu, &self.cloud);
        }
    }

    fn upload(&mut self, gpu: &Gpu) {
        self.rebuilt = self.cloud.rebuilt;
        let none = [Surfel::default()];
        let surfels = if self.cloud.surfels.is_empty() { &none[..] } else { &self.cloud.surfels };
        self.surfels = gpu.storage("surfel cloud", surfels, BufferUsages::COPY_DST);
        self.patches.upload(gpu, &self.cloud);
    }

    /// Uploads what is elsewhere where objects have bent.
    fn bend(&self, gpu: &Gpu) {
        for range in self.cloud.bending().filter(|range| !range.is_empty()) {
            let first = (range.start * size_of::<Surfel>()) as u64;
            gpu.write_buffer(&self.surfels, first, bytemuck::cast_slice(&self.cloud.surfels[range]));
        }
        self.patches.bend(gpu, &self.cloud);
    }

    /// Tells the device the identities of the primitives, in their order.
    fn name_primitives(&mut self, gpu: &Gpu, scene: &Scene) {
        let ids = || scene.primitives.iter().map(|primitive| primitive.id.0 as u32);
        if !ids().eq(self.ids.iter().copied()) {
            self.ids = ids().collect();
            let named = searchable(&self.ids);
            self.primitive_ids = gpu.storage("ids of primitives", &named, BufferUsages::empty());
        }
    }

    /// Number of surfels in the buffer: at least one.
    pub fn count(&self) -> u32 {
        self.cloud.surfels.len().max(1) as u32
    }

    /// Whether any surface emits light.
    pub fn is_emissive(&self) -> bool {
        self.cloud.is_emissive
    }

    /// Flux that all emissive surfaces send out \[W\].
    pub fn emitted(&self) -> Vec3 {
        self.cloud.emitted
    }

    /// Area of all surfaces \[m²\].
    pub fn area(&self) -> f64 {
        self.cloud.area()
    }

    /// Mean reflectance of all surfaces.
    pub fn mean_albedo(&self) -> Vec3 {
        self.cloud.mean_albedo
    }

    /// Changes with the surfels in object space.
    pub(in crate::render) fn revision(&self) -> u64 {
        self.uploaded
    }

    /// Changes where surfels and patches are others than before; until then the same numbers stand for the same ones.
    pub(in crate::render) fn layout(&self) -> u64 {
        self.layout
    }

    /// Whether any surface is elsewhere than in the frame before.
    pub(in crate::render) fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// Whether the surfels are others than in the frame before: surfaces came or went.
    pub(in crate::render) fn is_replaced(&self) -> bool {
        self.is_replaced
    }

    /// Number of patches.
    pub fn patch_count(&self) -> u32 {
        self.cloud.patches.ranges.len() as u32
    }

    /// Edge of a patch \[m\].
    pub fn patch_size(&self) -> f32 {
        self.cloud.patches.size
    }

    /// The patches, see `lib/patches.wgsl`.
    pub(in crate::render) fn patches(&self) -> &GpuPatches {
        &self.patches
    }

    /// First surfel and number of surfels of each patch.
    pub(in crate::render) fn ranges(&self) -> Tracked<'_> {
        Tracked::buffer(&self.patches.ranges, &self.revision())
    }

    /// Identities of the scene's primitives, in their order.
    pub(in crate::render) fn primitive_ids(&self, geometry: &impl Hash) -> Tracked<'_> {
        Tracked::buffer(&self.primitive_ids, &(hash(geometry), self.revision()))
    }

    /// Binds them to the pass that places them, of a scene's geometry.
    pub(in crate::render) fn bind<'a>(&'a self, pass: &mut PassBindings<'_, 'a>, geometry: &impl Hash) {
        pass.tracked("cloud", Tracked::buffer(&self.surfels, &self.revision()));
        pass.tracked("places", Tracked::buffer(self.places.buffer(), &(hash(geometry), self.revision())));
    }
}
