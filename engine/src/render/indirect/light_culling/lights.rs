//! Virtual lights from reflective shadow maps, the error bound δ, and the lights' ranges.

use super::{Method, Sources, particle_lights};
use crate::assets::SkyMap;
use crate::gpu::{ComputeKey, Gpu};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::light_view::light_views;
use crate::render::shadows::reflective::{self, Rsm, RsmLayerUniform};
use crate::scene::SceneLight;
use crate::world::{Delta, LightBounds, LightChances, LightShow, StochasticLightCulling};
use encase::ShaderType;
use glam::{UVec2, Vec3};
use std::hash::Hash;
use wgpu::BufferUsages;

/// Bytes of `VirtualLight` of `lib/slc.wgsl`.
pub(super) const LIGHT_BYTES: u64 = 96;
/// Bytes of `LightRange` of `lib/slc.wgsl`.
pub(super) const RANGE_BYTES: u64 = 64;
/// Lights in a row of the image that shading reads, and its layers: `LIGHTS_A_ROW` and the layers of `lib/slc.wgsl`.
pub(super) const LIGHTS_A_ROW: u32 = 4096;
const LIGHT_TEXELS: u32 = 8;
/// Rays to the sky of all subsets together.
const SKY_RAYS: u32 = 256;

/// `Place` of `indirect/light_culling/lights.wgsl`.
#[derive(ShaderType)]
pub(crate) struct PlaceUniform {
    light: LightUniform,
    rsm: RsmLayerUniform,
    first: u32,
    lights: u32,
    interleave: u32,
    pad: u32,
}

/// `Culling` of `lib/slc.wgsl`.
#[derive(ShaderType)]
pub(crate) struct CullingUniform {
    view: ViewUniform,
    lights: u32,
    interleave: u32,
    words: u32,
    tiles: UVec2,
    seed: u32,
    root: u32,
    filter_radius: u32,
    show: u32,
    first_subset: u32,
    sky: Vec3,
    sky_rays: u32,
    sky_turn: f32,
}

/// `Delta` of `indirect/light_culling/delta.wgsl`.
#[derive(ShaderType)]
pub(crate) struct DeltaUniform {
    relative: f32,
    absolute: f32,
}

/// `Chances` of `indirect/light_culling/range.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ChancesUniform {
    lights: u32,
    seed: u32,
    bounds: u32,
    lobes: u32,
    independent: u32,
}

impl Method {
    /// The settings for the shaders that look at pixels; `first_subset` is where a dispatch begins.
    pub(super) fn uniform(&self, gpu: &Gpu, frame: &Frame, first_subset: u32) -> wgpu::Buffer {
        gpu.uniform("culling", &self.values(frame, first_subset))
    }

    /// The contents of that buffer.
    pub(super) fn values(&self, frame: &Frame, first_subset: u32) -> CullingUniform {
        let s = &self.settings;
        let show = match s.show {
            LightShow::Light => 0,
            LightShow::Candidates => 1,
            LightShow::FalsePositives => 2,
        };
        CullingUniform {
            view: frame.view_values(),
            lights: self.lights,
            interleave: s.interleave,
            words: self.words(),
            tiles: self.tiles.into(),
            seed: self.seed,
            root: self.root,
            filter_radius: s.filter_radius,
            show,
            first_subset,
            sky: self.sky,
            sky_rays: (SKY_RAYS / self.subsets()).clamp(4, 64),
            sky_turn: self.sky_map(frame).map_or(0.0, |map| map.turn),
        }
    }

    /// Changes with all that [`Method::uniform`] holds.
    pub(super) fn key(&self, frame: &Frame) -> impl Hash + use<> {
        let sky = (self.sky.to_array().map(f32::to_bits), self.sky_map(frame).map(|map| map.id));
        let settings = format!("{:?}", self.settings);
        (frame.view_key(), settings, self.lights, self.tiles, self.seed, self.root, sky)
    }

    /// The sky's map, where rays are cast and the sky differs by direction.
    pub(super) fn sky_map<'a>(&self, frame: &Frame<'a>) -> Option<&'a SkyMap> {
        frame.scene.sky_map.as_deref().filter(|_| self.sky != Vec3::ZERO)
    }

    fn delta_uniform(&self) -> DeltaUniform {
        match self.settings.delta {
            Delta::Relative(share) => DeltaUniform { relative: share, absolute: 0.0 },
            Delta::Absolute(delta) => DeltaUniform { relative: 0.0, absolute: delta },
        }
    }

    fn chances_uniform(&self) -> ChancesUniform {
        let bounds = match self.settings.bounds {
            LightBounds::Ellipsoid => 0,
            LightBounds::CentredSphere => 1,
            LightBounds::EnclosingSphere => 2,
        };
        let [diffuse, specular] = self.lobes().map(u32::from);
        let independent = u32::from(self.settings.chances == LightChances::Independent);
        ChancesUniform { lights: self.lights, seed: self.seed, bounds, lobes: diffuse | specular << 1, independent }
    }
}

/// The maps of all lights that feed indirect light. Each light has an equal share of the texels, and a point light
/// spreads its share over its faces.
pub(super) fn maps<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, settings: &StochasticLightCulling) -> Vec<Rsm<'a>> {
    let feeds = |light: &SceneLight| light.indirect && light.intensity != Vec3::ZERO;
    let count = frame.scene.lights.iter().filter(|light| feeds(light)).count().max(1);
    let n = settings.interleave;
    let declare = |(light, index): (&'a SceneLight, u32)| {
        let views = light_views(light, &frame.bounds).len().max(1) * count;
        let edge = f64::from(settings.rsm_size) / (views as f64).sqrt();
        // Whole subsets.
        let size = ((edge / f64::from(n)).round() as u32).max(1) * n;
        reflective::declare_sized(graph, frame, light, index, &frame.bounds, size)
    };
    frame.scene.lights.iter().zip(0..).filter_map(declare).collect()
}

/// Virtual lights of a map in one subset.
pub(super) fn lights_of(map: &Rsm, interleave: u32) -> u64 {
    let edge = u64::from(map.size / interleave);
    map.views.len() as u64 * edge * edge
}

/// Declares the lights, the error bound and the ranges.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, maps: &[Rsm<'a>], method: &Method) -> Sources {
    let lights = declare_lights(graph, frame, maps, method);
    let bound = declare_bound(graph, method, lights);
    let (ranges, texels) = declare_ranges(graph, method, lights, bound);
    Sources { ranges, texels, bound }
}

fn declare_lights<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, maps: &[Rsm<'a>], method: &Method) -> Handle<Buffer> {
    let count = u64::from(method.lights) * u64::from(method.subsets());
    let buffer = graph.retained_buffer("virtual lights", BufferDesc::new(LIGHT_BYTES * count, BufferUsages::STORAGE));
    let mut pass = graph.compute("virtual lights", ComputeKey::new("indirect/light_culling/lights.wgsl", "main"));
    let buffer = pass.write("virtual_lights", buffer);
    let (n, lights) = (method.settings.interleave, method.lights);
    let mut first = 0;
    for map in maps {
        for layer in 0..map.views.len() {
            let (light, rsm) = (LightUniform::new(map.light), map.layer_uniform(layer, 1.0));
            let mut step = pass.step("main");
            step.uniform("place", &PlaceUniform { light, rsm, first, lights, interleave: n, pad: 0 });
            step.read("base_color", map.base_color);
            step.read("normal", map.normal);
            step.read("specular", map.specular);
            step.read("depth", map.depth);
            step.count(Counts { lights: map.layer_texels(), ..Counts::default() });
            step.over_uncounted([map.size; 2]);
            first += (map.size / n) * (map.size / n);
        }
    }
    particle_lights::declare_step(&mut pass, frame.scene, [first, lights, n * n]);
    pass.finish();
    buffer
}

fn declare_bound(graph: &mut Graph, method: &Method, lights: Handle<Buffer>) -> Handle<Buffer> {
    let bound = graph.retained_buffer("slc error bound", BufferDesc::new(16, BufferUsages::STORAGE));
    let mut pass = graph.compute("slc error bound", ComputeKey::new("indirect/light_culling/delta.wgsl", "main"));
    pass.uniform("wanted", &method.delta_uniform());
    pass.read("virtual_lights", lights);
    let bound = pass.write("bound", bound);
    pass.dispatch_groups([1, 1, 1]);
    bound
}

fn declare_ranges(
    graph: &mut Graph,
    method: &Method,
    lights: Handle<Buffer>,
    bound: Handle<Buffer>,
) -> (Handle<Buffer>, Handle<Texture>) {
    let count = method.lights.saturating_mul(method.subsets());
    let desc = BufferDesc::new(RANGE_BYTES * u64::from(count), BufferUsages::STORAGE);
    let ranges = graph.retained_buffer("slc ranges", desc);
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let (width, height) = (count.clamp(1, LIGHTS_A_ROW), count.div_ceil(LIGHTS_A_ROW).max(1));
    let desc = TextureDesc::d2_array(width, height, LIGHT_TEXELS, wgpu::TextureFormat::Rgba32Float, usage);
    let texels = graph.retained_texture("slc light texels", desc);
    let mut pass = graph.compute("slc ranges", ComputeKey::new("indirect/light_culling/range.wgsl", "main"));
    pass.uniform("chances", &method.chances_uniform());
    pass.read("virtual_lights", lights);
    pass.read("bound", bound);
    let (ranges, texels) = (pass.write("ranges", ranges), pass.write("light_texels", texels));
    pass.count(Counts { lights: count.into(), ..Counts::default() });
    pass.dispatch_items(count);
    (ranges, texels)
}
