//! Virtual lights from reflective shadow maps, the error bound δ, and the lights' ranges.

use super::{Method, Sources, particle_lights};
use crate::assets::SkyMap;
use crate::gpu::{Binding, ComputeKey, Gpu};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError, Texture, TextureDesc};
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

/// Workgroups of 64 threads, one thread a light, in rows that every device dispatches.
pub(super) fn groups_of(lights: u32) -> [u32; 3] {
    let groups = lights.div_ceil(64).max(1);
    let x = groups.min(32_768);
    [x, groups.div_ceil(x), 1]
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
    let mut pass = graph.pass("virtual lights");
    for map in maps {
        for handle in [map.base_color, map.normal, map.specular, map.depth] {
            pass.read(handle);
        }
    }
    let buffer = pass.write(buffer);
    let n = method.settings.interleave;
    let revisions: Vec<u64> = maps.iter().map(|map| map.light.revision).collect();
    pass.key(&(frame.scene.identity, revisions, n, particle_lights::key(frame.scene)));
    let (maps, lights, scene) = (maps.to_vec(), method.lights, frame.scene);
    pass.execute(move |cx| {
        let target = cx.buffer(buffer).clone();
        let mut first = 0;
        for map in &maps {
            for layer in 0..map.views.len() {
                let light = LightUniform::new(map.light);
                let rsm = map.layer_uniform(layer, 1.0);
                let place = PlaceUniform { light, rsm, first, lights, interleave: n, pad: 0 };
                take_layer(cx, map, &place, &target)?;
                first += (map.size / n) * (map.size / n);
            }
        }
        particle_lights::place(cx, scene, &target, [first, lights, n * n])
    });
    buffer
}

fn take_layer(cx: &mut PassContext, map: &Rsm, place: &PlaceUniform, target: &wgpu::Buffer) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let [base_color, normal, specular, depth] =
        [map.base_color, map.normal, map.specular, map.depth].map(|handle| cx.view(handle));
    cx.counts().lights += map.layer_texels();
    let groups = map.size.div_ceil(8);
    cx.dispatch(
        &ComputeKey::new("indirect/light_culling/lights.wgsl", "main"),
        &[
            ("place", Binding::Buffer(&gpu.uniform("place", place))),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("specular", Binding::Texture(&specular)),
            ("depth", Binding::Texture(&depth)),
            ("virtual_lights", Binding::Buffer(target)),
        ],
        [groups, groups, 1],
    )
}

fn declare_bound(graph: &mut Graph, method: &Method, lights: Handle<Buffer>) -> Handle<Buffer> {
    let bound = graph.retained_buffer("slc error bound", BufferDesc::new(16, BufferUsages::STORAGE));
    let mut pass = graph.pass("slc error bound");
    pass.read(lights);
    let bound = pass.write(bound);
    let delta = method.delta_uniform();
    pass.key(&[delta.relative, delta.absolute].map(f32::to_bits));
    pass.execute(move |cx| {
        let [lights, target] = [lights, bound].map(|handle| cx.buffer(handle).clone());
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/delta.wgsl", "main"),
            &[
                ("wanted", Binding::Buffer(&cx.gpu.uniform("delta", &delta))),
                ("virtual_lights", Binding::Buffer(&lights)),
                ("bound", Binding::Buffer(&target)),
            ],
            [1, 1, 1],
        )
    });
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
    let mut pass = graph.pass("slc ranges");
    pass.read(lights);
    pass.read(bound);
    let (ranges, texels) = (pass.write(ranges), pass.write(texels));
    let chances = method.chances_uniform();
    pass.key(&(chances.lights, chances.seed, chances.bounds, chances.lobes, chances.independent));
    pass.execute(move |cx| {
        let [lights, bound, target] = [lights, bound, ranges].map(|handle| cx.buffer(handle).clone());
        cx.counts().lights += u64::from(count);
        let view = cx.view(texels);
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/range.wgsl", "main"),
            &[
                ("chances", Binding::Buffer(&cx.gpu.uniform("chances", &chances))),
                ("virtual_lights", Binding::Buffer(&lights)),
                ("bound", Binding::Buffer(&bound)),
                ("ranges", Binding::Buffer(&target)),
                ("light_texels", Binding::Texture(&view)),
            ],
            groups_of(count),
        )
    });
    (ranges, texels)
}
