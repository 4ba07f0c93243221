//! The scene's surfels on the device.

use crate::gpu::{Binding, Gpu};
use crate::scene::{Scene, Surfel, SurfelCloud};
use glam::{Affine3A, Vec3};
use wgpu::BufferUsages;

/// Surfels in object space and the places of their objects, as buffers.
#[derive(Debug)]
pub struct GpuSurfels {
    cloud: SurfelCloud,
    surfels: wgpu::Buffer,
    places: wgpu::Buffer,
    uploaded: u64,
    placed: Vec<Affine3A>,
    emitted: Vec3,
}

impl GpuSurfels {
    /// No surfels yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            cloud: SurfelCloud::default(),
            surfels: gpu.storage("surfel cloud", &[Surfel::default()], BufferUsages::empty()),
            places: gpu.storage("surfel places", &[[0.0_f32; 12]], BufferUsages::empty()),
            uploaded: 0,
            placed: Vec::new(),
            emitted: Vec3::ZERO,
        }
    }

    /// Brings the surfels up to date with the scene, as dense as the finest cells need them. Costs nothing if nothing
    /// changed; an object that only moved costs its transform.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene, finest_cell: f32) {
        self.cloud.update(scene, finest_cell);
        if self.uploaded != self.cloud.revision {
            self.uploaded = self.cloud.revision;
            let none = [Surfel::default()];
            let surfels = if self.cloud.surfels.is_empty() { &none[..] } else { &self.cloud.surfels };
            self.surfels = gpu.storage("surfel cloud", surfels, BufferUsages::empty());
            let emitted = |s: &Surfel| std::f32::consts::PI * s.area * Vec3::from(s.emissive);
            self.emitted = self.cloud.surfels.iter().map(emitted).sum();
        }
        if self.placed != self.cloud.places {
            self.placed.clone_from(&self.cloud.places);
            let rows = self.placed.iter().map(|m| {
                let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], m.translation[i]];
                [row(0), row(1), row(2)]
            });
            self.places = gpu.storage("surfel places", &rows.collect::<Vec<_>>(), BufferUsages::empty());
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
        self.emitted
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

    /// What the pass that places them binds.
    pub(in crate::render) fn bindings(&self) -> [(&'static str, Binding<'_>); 2] {
        [("cloud", Binding::Buffer(&self.surfels)), ("places", Binding::Buffer(&self.places))]
    }
}
