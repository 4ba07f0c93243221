//! The scene as rays see it on the device: hierarchies, triangles, materials, textures, lights and emitters.
//!
//! Dynamic objects have boxes and triangles of their own, behind those of static objects: a frame in which something moved
//! encodes and uploads that alone.
//!
//! Passes that cast rays import `lightwell::rays` and are dispatched with group 1 bound by [`dispatch_rays`].

mod atlas;
mod box_list;
mod boxes;
mod emitters;
mod geometry;
mod lights;
mod materials;
mod moving_boxes;
mod nodes;
mod wide_nodes;
mod wide_tree;
mod words;

use crate::gpu::{BindError, Binding, ComputeKey, Gpu, Pipeline, ShaderDef};
use crate::graph::{Groups, PassBindings, PassContext, PassError, SharedGroup, hash};
use crate::render::scene_gpu::media::GpuMedia;
use crate::scene::SceneBvh;
use crate::scene::{Aabb, Scene};
use atlas::Atlas;
use emitters::{Emitters, Followed};
use encase::ShaderType;
use geometry::{GpuGeometry, Surfaces};
use glam::Vec3;
use materials::GpuMaterials;
use words::Words;

pub(in crate::render) use materials::{all_mirror_define, mirror_define};
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
        /// Its contents.
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

/// Which state of a scene the device holds.
#[derive(Clone, Copy, Debug)]
struct Synced {
    /// Identity, and revisions of geometry, materials, lights and statics.
    revisions: [u64; 5],
    /// Of the static part, of the moving part, and of their surfaces.
    versions: [u64; 3],
    is_plain: bool,
}

impl Synced {
    /// The scene's state; what is not known yet of its surfaces is that of an earlier one.
    fn new(scene: &Scene, then: Option<Self>) -> Self {
        let (versions, is_plain) = then.map_or(([0; 3], false), |then| (then.versions, then.is_plain));
        Self { revisions: Self::revisions_of(scene), versions, is_plain }
    }

    fn revisions_of(scene: &Scene) -> [u64; 5] {
        let revisions = &scene.revisions;
        [scene.identity, revisions.geometry, revisions.materials, revisions.lights, revisions.statics]
    }

    /// Changes with all that rays meet.
    fn surfaces(&self) -> [u64; 4] {
        let [identity, geometry, materials, _, statics] = self.revisions;
        [identity, geometry, materials, statics]
    }

    /// Changes with the lights.
    fn lights(&self) -> [u64; 2] {
        [self.revisions[0], self.revisions[3]]
    }

    fn has_materials_of(&self, other: &Self) -> bool {
        self.revisions[2] == other.revisions[2]
    }

    /// Whether the two states of a scene, which tells, differ by nothing but moving primitives.
    fn has_statics_of(&self, other: &Self) -> bool {
        self.revisions[4] != 0 && self.revisions[4] == other.revisions[4]
    }
}

/// `GlassBox` of `lib/ray_scene.wgsl`.
#[derive(ShaderType)]
pub(crate) struct GlassBoxUniform {
    low: Vec3,
    high: Vec3,
}

impl GlassBoxUniform {
    fn of(bounds: &Aabb) -> Self {
        Self { low: bounds.min, high: bounds.max }
    }
}

/// Where lists of boxes hold geometry that is not opaque: rays go along it after all that is, see `lib/walk.wgsl`.
#[derive(Clone, Copy, Default)]
struct Classes {
    /// Whether rays can go along what is opaque without meeting anything else.
    are_apart: bool,
    /// Whether static objects are of both classes.
    is_split: bool,
    /// Whether a dynamic object is not opaque.
    has_other_movers: bool,
}

impl Classes {
    fn of(scene: &Scene, bvh: &SceneBvh) -> Self {
        let others = |moving: bool| scene.primitives.iter().any(|p| p.moving == moving && !p.material.is_opaque());
        let (is_split, has_other_movers) = (bvh.statics.is_split, others(true));
        // Where nothing static is opaque there is nothing to go along first.
        Self { are_apart: is_split || (has_other_movers && !others(false)), is_split, has_other_movers }
    }
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
    emissive: Emitters,
    synced: Option<Synced>,
    /// Number of lights.
    pub light_count: u32,
    /// Number of triangles that emit light.
    pub emitter_count: u32,
    has_area_lights: bool,
    /// Around all that is of glass.
    glass: Aabb,
    classes: Classes,
    media: Option<GpuMedia>,
    /// Of the scene whose media they are.
    media_revision: [u64; 2],
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
            emissive: Emitters::default(),
            synced: None,
            light_count: 0,
            emitter_count: 0,
            has_area_lights: false,
            glass: Aabb::EMPTY,
            classes: Classes::default(),
            media: None,
            media_revision: [0; 2],
        }
    }

    /// Updates the device from the scene. Costs nothing if nothing changed, and follows dynamic objects alone if
    /// nothing else changed.
    ///
    /// # Errors
    /// If the scene is larger than the device can bind.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), RayError> {
        let media_revision = [scene.identity, scene.revisions.media];
        if self.media_revision != media_revision {
            (self.media, self.media_revision) = (GpuMedia::of(scene), media_revision);
        }
        let then = self.synced;
        if then.is_some_and(|then| then.revisions == Synced::revisions_of(scene)) {
            return Ok(());
        }
        self.synced = None;
        let mut now = Synced::new(scene, then);
        if then.is_none_or(|then| then.surfaces() != now.surfaces()) {
            self.update_surfaces(gpu, scene, then, &mut now)?;
        }
        if then.is_none_or(|then| then.lights() != now.lights()) {
            self.light_count = scene.lights.len() as u32;
            self.has_area_lights = scene.lights.iter().any(|light| light.shape.is_area());
            let texels = lights::texels(&scene.lights);
            self.lights.reserve(gpu, "ray lights", "lights", texels.len().div_ceil(words::ROW as usize))?;
            self.lights.write(gpu, 0, &texels);
        }
        self.synced = Some(now);
        Ok(())
    }

    fn update_surfaces(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        then: Option<Synced>,
        now: &mut Synced,
    ) -> Result<(), RayError> {
        let glass = scene.primitives.iter().filter(|primitive| primitive.material.is_glass());
        self.glass = glass.fold(Aabb::EMPTY, |sum, primitive| sum.union(&primitive.bounds));
        self.bvh.update(scene);
        self.classes = Classes::of(scene, &self.bvh);
        let bvh = &self.bvh;
        let versions = [bvh.statics.version, bvh.movers.version, bvh.surfaces_version];
        let then = then.filter(|then| then.revisions[0] == now.revisions[0]);
        let has_materials = then.is_some_and(|then| then.has_materials_of(now) && then.versions[2] == versions[2]);
        if !has_materials {
            self.atlas.update(gpu, scene)?;
            self.materials.update(gpu, scene, &self.atlas)?;
        }
        now.versions = versions;
        now.is_plain = self.materials.is_plain();
        let has_other_emitters = !has_materials && self.emissive.collect(scene, bvh);
        let keeps = |then: Synced| {
            (then.has_materials_of(now) || then.has_statics_of(now))
                && then.versions[0] == versions[0]
                && then.is_plain == now.is_plain
                && self.geometry.nodes.suit(gpu, bvh)
        };
        let keeps_statics = then.is_some_and(keeps) && !has_other_emitters;
        if !keeps_statics && has_materials {
            self.emissive.collect(scene, bvh);
        }
        let known = then.filter(|_| keeps_statics && has_materials).map(|then| then.versions[1]);
        let followed = known.map_or(Followed::Triangles, |since| self.emissive.follow(bvh, since));
        let surfaces = Surfaces { scene, bvh, materials: &self.materials, emitters: &self.emissive };
        if !keeps_statics {
            self.geometry.update_statics(gpu, surfaces)?;
        }
        self.geometry.update_movers(gpu, surfaces, known.filter(|_| followed != Followed::Triangles));
        if followed != Followed::Nothing {
            let list = self.emissive.list(self.geometry.trees(bvh));
            self.emitter_count = list.len() as u32;
            self.emitters = gpu.storage("emitters", &list, wgpu::BufferUsages::empty());
        }
        Ok(())
    }

    /// What `trace` of `lib/walk.wgsl` is to know; 0 if there is nothing to meet.
    pub fn root(&self) -> u32 {
        self.geometry.nodes.root()
    }

    /// Whether any surface is smooth enough to show an image of what it reflects.
    pub fn has_mirrors(&self) -> bool {
        self.materials.any_mirror()
    }

    /// Whether any surface lets light pass.
    pub fn has_glass(&self) -> bool {
        self.materials.any_glass()
    }

    /// Whether any surface has more than the metallic-roughness base.
    pub fn has_layers(&self) -> bool {
        self.materials.any_layers()
    }

    /// Whether any light has an area: shaders that cast rays are compiled for that.
    pub fn has_area_lights(&self) -> bool {
        self.has_area_lights
    }

    /// A box around all surfaces that let light pass.
    pub fn glass_bounds(&self) -> &Aabb {
        &self.glass
    }

    /// The shader with all that this scene needs of `lib/ray_scene.wgsl`, and no more.
    pub fn shader(&self, file: &'static str, entry: &'static str) -> ComputeKey {
        self.defines().fold(ComputeKey::new(file, entry), |key, (name, value)| key.def(name, value))
    }

    /// Lets a pass cast rays that ask for surfaces, but not for lights: its group 1 is the scene.
    pub(in crate::render) fn bind_surfaces<'a>(&'a self, pass: &mut PassBindings<'_, 'a>) {
        self.bind_to(pass, false);
    }

    /// Lets a pass cast rays that ask for surfaces and lights: its group 1 is the scene.
    pub(in crate::render) fn bind_all<'a>(&'a self, pass: &mut PassBindings<'_, 'a>) {
        self.bind_to(pass, true);
    }

    fn bind_to<'a>(&'a self, pass: &mut PassBindings<'_, 'a>, lights: bool) {
        self.defines().for_each(|(name, value)| pass.define(name, value));
        pass.share(RayGroup { scene: self, lights });
    }

    fn defines(&self) -> impl Iterator<Item = (&'static str, ShaderDef)> {
        let (layers, nodes) = (self.materials.layers(), &self.geometry.nodes);
        let flags = [
            ("EXACT_BOXES", nodes.are_exact()),
            ("WIDE", nodes.are_wide()),
            ("CLASSES", self.classes.are_apart && !nodes.are_wide()),
            ("SPLIT", self.classes.is_split && !nodes.are_wide()),
            ("OTHER_MOVERS", self.classes.has_other_movers && !nodes.are_wide()),
            ("UNTEXTURED", !self.atlas.holds_textures()),
            ("OPAQUE", !self.materials.any_masked()),
            ("DIFFUSE", !self.materials.any_specular()),
            ("MOVERS", self.bvh.moving_triangles() > 0 && !nodes.are_wide()),
            ("UNLIT", self.emitter_count == 0),
            ("DARK", !self.materials.any_emissive()),
            ("PLAIN", self.materials.is_plain()),
            ("AREA_LIGHTS", self.has_area_lights),
            ("GLASS", self.has_glass()),
            ("LAYERED", self.materials.any_layers()),
            ("COATS", layers.coats),
            ("SHEEN", layers.sheen),
            ("FILMS", layers.films),
            ("ANISOTROPY", layers.anisotropy),
            ("DISPERSION", self.materials.any_dispersion()),
        ];
        let set = flags.into_iter().filter_map(|(name, is_set)| is_set.then_some(name));
        let names = set.chain(self.materials.texture_defines());
        let media = self.media.as_ref().map(|media| [media.define(), ("RAY_MEDIA", ShaderDef::Flag(true))]);
        names.map(|name| (name, ShaderDef::Flag(true))).chain(media.into_iter().flatten())
    }

    /// Binds as group 1 what the pipeline uses of the scene.
    ///
    /// # Errors
    /// If the shader declares something in that group that is not of the scene.
    pub fn bind(&self, gpu: &Gpu, pipeline: &Pipeline) -> Result<wgpu::BindGroup, BindError> {
        self.bind_where(gpu, pipeline, |_| true)
    }

    /// Binds what the pipeline uses of those that may be bound.
    fn bind_where(
        &self,
        gpu: &Gpu,
        pipeline: &Pipeline,
        may_be: impl Fn(&str) -> bool,
    ) -> Result<wgpu::BindGroup, BindError> {
        let is_used = |name: &str| pipeline.declares(1, name) && may_be(name);
        let mut used: Vec<_> = self.bindings().into_iter().filter(|(name, _)| is_used(name)).collect();
        for (name, _) in &used {
            gpu.audit.note(name, &self.content(name));
        }
        // Its content is noted where it is made.
        let media = self.media.as_ref().filter(|_| pipeline.declares(1, "media")).map(|media| media.buffer(gpu));
        used.extend(media.iter().map(|media| ("media", Binding::Buffer(media))));
        if pipeline.declares(1, "glass_box") {
            gpu.audit.note("glass_box", &self.content("glass_box"));
        }
        let glass = pipeline.declares(1, "glass_box").then(|| gpu.uniform("glass", &GlassBoxUniform::of(&self.glass)));
        used.extend(glass.iter().map(|glass| ("glass_box", Binding::Buffer(glass))));
        pipeline.bind(gpu, 1, &used)
    }

    /// Changes with what is bound under that name.
    fn content(&self, name: &str) -> Option<[u64; 3]> {
        let [identity, geometry, materials, lights, _] = self.synced?.revisions;
        Some(match name {
            "lights" => [identity, lights, 0],
            "nodes" => [identity, geometry, 0],
            _ => [identity, geometry, materials],
        })
    }

    /// Group 1 of all passes that cast rays.
    fn bindings(&self) -> [(&'static str, Binding<'_>); 8] {
        [
            ("nodes", self.geometry.nodes.binding()),
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

/// A scene as the group 1 of a pass.
struct RayGroup<'a> {
    scene: &'a RayScene,
    /// Whether the shader may ask for lights: a pass that does not need not run again where they change.
    lights: bool,
}

impl SharedGroup for RayGroup<'_> {
    fn key(&self) -> u64 {
        let contents = ["nodes", "triangles"].map(|name| self.scene.content(name));
        let lights = self.lights.then(|| self.scene.content("lights"));
        hash(&(contents, lights, self.scene.media.as_ref().map(GpuMedia::bytes)))
    }

    fn bind(&self, gpu: &Gpu, pipeline: &Pipeline) -> Result<wgpu::BindGroup, BindError> {
        self.scene.bind_where(gpu, pipeline, |name| self.lights || name != "lights")
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
/// Dispatches a shader that casts rays: group 0 as given, group 1 the scene.
pub(in crate::render) fn dispatch_rays<'g>(
    cx: &mut PassContext,
    key: &ComputeKey,
    group: &[(&str, Binding)],
    scene: &RayScene,
    groups: impl Into<Groups<'g>>,
) -> Result<(), PassError> {
    cx.dispatch_with(key, group, &|gpu, pipeline| scene.bind(gpu, pipeline), groups)
}
