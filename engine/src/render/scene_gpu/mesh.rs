//! Meshes on the device: vertices and indices of many of them lie in the same buffers, so that a pass binds buffers
//! once and then draws mesh after mesh.

use crate::assets::{AssetId, Mesh, Vertex, VertexExtra};
use crate::gpu::Gpu;
use crate::scene::Primitive;
use range_alloc::RangeAllocator;
use std::collections::HashMap;
use std::ops::Range;
use wgpu::BufferUsages;
use wgpu::util::DrawIndexedIndirectArgs;

/// Vertices of a page \[48 bytes each\]; a mesh of more has a page of its own.
const PAGE_VERTICES: u32 = 1 << 20;
/// Indices of a page \[4 bytes each\].
const PAGE_INDICES: u32 = 1 << 22;

/// Where a mesh lies.
pub(super) struct GpuMesh {
    topology: AssetId,
    /// See [`Mesh::winding`].
    winding: u64,
    page: usize,
    vertices: Range<u32>,
    /// Its indices, which count from its first vertex.
    indices: Range<u32>,
    has_extras: bool,
    /// Number of primitives of this mesh.
    uses: usize,
}

/// The same in short, for draws. It stays as it is while the mesh is there.
#[derive(Clone, Copy)]
pub(super) struct MeshPlace {
    /// The buffers that it lies in.
    pub page: usize,
    first_index: u32,
    index_count: u32,
    base_vertex: i32,
}

impl GpuMesh {
    /// Where it lies.
    pub fn place(&self) -> MeshPlace {
        MeshPlace {
            page: self.page,
            first_index: self.indices.start,
            index_count: self.indices.len() as u32,
            base_vertex: self.vertices.start as i32,
        }
    }
}

impl MeshPlace {
    /// The draw of some instances of it.
    pub fn draw(&self, instances: Range<u32>) -> DrawIndexedIndirectArgs {
        DrawIndexedIndirectArgs {
            index_count: self.index_count,
            instance_count: instances.len() as u32,
            first_index: self.first_index,
            base_vertex: self.base_vertex,
            first_instance: instances.start,
        }
    }
}

/// Buffers that meshes share.
struct Page {
    vertices: wgpu::Buffer,
    /// For draws that are not plain.
    extras: Option<wgpu::Buffer>,
    indices: wgpu::Buffer,
    free_vertices: RangeAllocator<u32>,
    free_indices: RangeAllocator<u32>,
}

impl Page {
    fn new(gpu: &Gpu, vertices: u32, indices: u32) -> Self {
        Self {
            vertices: buffer::<Vertex>(gpu, "vertices", vertices, BufferUsages::VERTEX),
            extras: None,
            indices: buffer::<u32>(gpu, "indices", indices, BufferUsages::INDEX),
            free_vertices: RangeAllocator::new(0..vertices),
            free_indices: RangeAllocator::new(0..indices),
        }
    }

    /// Room for so many vertices and indices, if there is any.
    fn allocate(&mut self, [vertices, indices]: [u32; 2]) -> Option<[Range<u32>; 2]> {
        let vertices = self.free_vertices.allocate_range(vertices).ok()?;
        match self.free_indices.allocate_range(indices) {
            Ok(indices) => Some([vertices, indices]),
            Err(_) => {
                self.free_vertices.free_range(vertices);
                None
            }
        }
    }
}

fn buffer<T>(gpu: &Gpu, label: &str, count: u32, usage: BufferUsages) -> wgpu::Buffer {
    gpu.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (u64::from(count) * size_of::<T>() as u64).max(16),
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn write<T: bytemuck::Pod>(gpu: &Gpu, buffer: &wgpu::Buffer, first: u32, values: &[T]) {
    gpu.write_buffer(buffer, u64::from(first) * size_of::<T>() as u64, bytemuck::cast_slice(values));
}

/// Whether there is anything of it to draw. Balls of light are drawn as what they are, not as the triangles that stand for them.
pub(super) fn is_drawable(mesh: &Mesh) -> bool {
    !mesh.indices.is_empty() && !mesh.vertices.is_empty() && mesh.balls.is_none()
}

fn counts(mesh: &Mesh) -> [u32; 2] {
    [mesh.vertices.len() as u32, mesh.indices.len() as u32]
}

/// The meshes of a scene.
#[derive(Default)]
pub(super) struct MeshStore {
    meshes: HashMap<AssetId, GpuMesh>,
    pages: Vec<Option<Page>>,
}

impl MeshStore {
    /// The mesh, unless it has no triangles.
    pub fn get(&self, id: AssetId) -> Option<&GpuMesh> {
        self.meshes.get(&id)
    }

    /// Binds the buffers of a page: vertices at 0, at 1 what only some meshes have unless `plain`.
    pub fn bind(&self, pass: &mut wgpu::RenderPass<'_>, page: usize, plain: bool) {
        let Some(page) = self.pages.get(page).and_then(Option::as_ref) else { return };
        pass.set_vertex_buffer(0, page.vertices.slice(..));
        if let Some(extras) = page.extras.as_ref().filter(|_| !plain) {
            pass.set_vertex_buffer(1, extras.slice(..));
        }
        pass.set_index_buffer(page.indices.slice(..), wgpu::IndexFormat::Uint32);
    }

    /// Uploads the meshes that are new and lets go of those that are gone. `is_plain` tells of which primitives the
    /// extras are not read.
    pub fn update(&mut self, gpu: &Gpu, primitives: &[Primitive], is_plain: impl Fn(&Primitive) -> bool) {
        let mut uses: HashMap<AssetId, usize> = HashMap::new();
        let mut order: Vec<&Mesh> = Vec::new();
        for primitive in primitives.iter().filter(|p| is_drawable(&p.mesh)) {
            let count = uses.entry(primitive.mesh.id).or_insert(0);
            if *count == 0 {
                order.push(&primitive.mesh);
            }
            *count += 1;
        }
        // Poses that are gone leave their place to those that come.
        let gone: Vec<AssetId> = self.meshes.keys().filter(|id| !uses.contains_key(id)).copied().collect();
        let mut free: HashMap<AssetId, Vec<GpuMesh>> = HashMap::new();
        for mesh in gone.iter().filter_map(|id| self.meshes.remove(id)) {
            free.entry(mesh.topology).or_default().push(mesh);
        }
        let mut new = Vec::new();
        order.retain(|mesh| !self.meshes.contains_key(&mesh.id));
        for mesh in order {
            match free.get_mut(&mesh.topology()).and_then(Vec::pop) {
                Some(old) => self.enter_pose(gpu, old, mesh),
                None => new.push(mesh),
            }
        }
        free.into_values().flatten().for_each(|mesh| self.release(&mesh));
        self.add(gpu, new);
        for (id, mesh) in &mut self.meshes {
            mesh.uses = uses.get(id).copied().unwrap_or(0);
        }
        for primitive in primitives.iter().filter(|p| !is_plain(p)) {
            self.add_extras(gpu, &primitive.mesh);
        }
    }

    /// Puts another pose of the same mesh in the place of one. False if that is of other triangles, or wanted by others.
    pub fn repose(&mut self, gpu: &Gpu, old: AssetId, mesh: &Mesh) -> bool {
        let fits = |old: &GpuMesh| old.uses == 1 && old.topology == mesh.topology();
        if !self.meshes.get(&old).is_some_and(fits) || self.meshes.contains_key(&mesh.id) {
            return false;
        }
        let Some(old) = self.meshes.remove(&old) else { return false };
        self.enter_pose(gpu, old, mesh);
        true
    }

    fn enter_pose(&mut self, gpu: &Gpu, mut place: GpuMesh, mesh: &Mesh) {
        if let Some(page) = &self.pages[place.page] {
            write(gpu, &page.vertices, place.vertices.start, &mesh.vertices);
            if place.winding != mesh.winding {
                write(gpu, &page.indices, place.indices.start, &mesh.indices);
                place.winding = mesh.winding;
            }
        }
        self.meshes.insert(mesh.id, place);
    }

    fn release(&mut self, mesh: &GpuMesh) {
        let slot = &mut self.pages[mesh.page];
        let Some(page) = slot else { return };
        page.free_vertices.free_range(mesh.vertices.clone());
        page.free_indices.free_range(mesh.indices.clone());
        if page.free_vertices.is_empty() {
            *slot = None;
        }
    }

    /// Uploads meshes, first into the room that there is.
    fn add(&mut self, gpu: &Gpu, meshes: Vec<&Mesh>) {
        let mut rest = Vec::new();
        for mesh in meshes {
            let mut pages = self.pages.iter_mut().enumerate();
            let place = pages.find_map(|(index, page)| Some((index, page.as_mut()?.allocate(counts(mesh))?)));
            match place {
                Some((page, place)) => self.place(gpu, mesh, page, place),
                None => rest.push(mesh),
            }
        }
        let mut rest = rest.into_iter().peekable();
        while let Some(first) = rest.next() {
            let (mut sum, mut members) = (counts(first), vec![first]);
            while let Some(mesh) = rest.next_if(|mesh| fits(sum, counts(mesh))) {
                let more = counts(mesh);
                sum = [sum[0] + more[0], sum[1] + more[1]];
                members.push(mesh);
            }
            let mut page = Page::new(gpu, sum[0], sum[1]);
            let places: Vec<_> = members.iter().filter_map(|mesh| page.allocate(counts(mesh))).collect();
            let index = self.pages.iter().position(Option::is_none).unwrap_or(self.pages.len());
            if index == self.pages.len() {
                self.pages.push(None);
            }
            self.pages[index] = Some(page);
            members.iter().zip(places).for_each(|(mesh, place)| self.place(gpu, mesh, index, place));
        }
    }

    fn place(&mut self, gpu: &Gpu, mesh: &Mesh, page: usize, [vertices, indices]: [Range<u32>; 2]) {
        if let Some(page) = &self.pages[page] {
            write(gpu, &page.vertices, vertices.start, &mesh.vertices);
            write(gpu, &page.indices, indices.start, &mesh.indices);
        }
        let placed = GpuMesh {
            topology: mesh.topology(),
            winding: mesh.winding,
            page,
            vertices,
            indices,
            has_extras: false,
            uses: 0,
        };
        self.meshes.insert(mesh.id, placed);
    }

    fn add_extras(&mut self, gpu: &Gpu, mesh: &Mesh) {
        let Some(placed) = self.meshes.get_mut(&mesh.id).filter(|placed| !placed.has_extras) else { return };
        let Some(page) = &mut self.pages[placed.page] else { return };
        let whole = (page.vertices.size() / size_of::<Vertex>() as u64) as u32;
        let buffer =
            page.extras.get_or_insert_with(|| buffer::<VertexExtra>(gpu, "extras", whole, BufferUsages::VERTEX));
        match &mesh.extras {
            Some(extras) => write(gpu, buffer, placed.vertices.start, extras),
            None => write(gpu, buffer, placed.vertices.start, &vec![VertexExtra::NEUTRAL; mesh.vertices.len()]),
        }
        placed.has_extras = true;
    }
}

/// Whether a page of meshes of that sum takes more.
fn fits(sum: [u32; 2], more: [u32; 2]) -> bool {
    let within = |i: usize, limit: u32| sum[i].checked_add(more[i]).is_some_and(|sum| sum <= limit);
    within(0, PAGE_VERTICES) && within(1, PAGE_INDICES)
}
