//! Shadow maps: one layer a view, six for point lights (Williams 1978; for points Gerasimov, GPU Gems 2004).

use super::light_view::{LightView, light_views, sees_by_cube};
use crate::gpu::RasterKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{DEPTH_FORMAT, depth_state};
use crate::render::geometry::static_layers::{self, LayerView};
use crate::render::scene_gpu::{DrawFilter, MaterialClass, PipelineOf};
use crate::scene::{Aabb, Frustum, LightShape, SceneLight};
use encase::ShaderType;
use glam::{Mat4, Vec3};
use std::rc::Rc;

/// `ShadowView` of `shadows/shadow_map.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ShadowViewUniform {
    clip_from_world: Mat4,
    eye: Vec3,
    far: f32,
}

/// `Shadow` of `lib/shadow_lookup.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ShadowUniform {
    faces: [Mat4; 6],
    eye: Vec3,
    far: f32,
    axis: Vec3,
    texel: f32,
    size: f32,
    kind: u32,
    pad_a: u32,
    pad_b: u32,
}

/// A light's shadow map as the direct pass reads it.
#[derive(Clone)]
pub struct ShadowMap {
    /// One layer a view.
    pub map: Handle<Texture>,
    views: Vec<LightView>,
    kind: u32,
    size: u32,
}

impl ShadowMap {
    /// How to look a point up in the map.
    pub(in crate::render) fn uniform(&self) -> ShadowUniform {
        let face = |i: usize| self.views.get(i).map_or(Mat4::IDENTITY, |view| view.clip_from_world);
        let first = self.views.first();
        let texel = first.map_or(0.0, |view| 2.0 * view.half_extent / self.size as f32);
        ShadowUniform {
            faces: std::array::from_fn(face),
            eye: first.map_or(Vec3::ZERO, |view| view.eye),
            far: first.map_or(1.0, |view| view.far),
            axis: first.map_or(Vec3::NEG_Z, |view| view.direction),
            texel,
            size: self.size as f32,
            kind: self.kind,
            pad_a: 0,
            pad_b: 0,
        }
    }

    /// For a light without shadows: everything is lit.
    pub(in crate::render) fn none_uniform() -> ShadowUniform {
        ShadowUniform {
            faces: [Mat4::IDENTITY; 6],
            eye: Vec3::ZERO,
            far: 1.0,
            axis: Vec3::NEG_Z,
            texel: 0.0,
            size: 1.0,
            kind: 0,
            pad_a: 0,
            pad_b: 0,
        }
    }
}

/// Declares the light's shadow map; none, with the reason in the report, if it needs none.
pub fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, light: &'a SceneLight) -> Option<ShadowMap> {
    let name = pass_name(light);
    if !light.casts_shadow {
        graph.skip(&name, "the light casts no shadow");
        return None;
    }
    let views = light_views(light, &frame.bounds);
    if views.is_empty() {
        graph.skip(&name, "nothing lies in the light's reach");
        return None;
    }
    let size = light.shadow_size.clamp(1, 8192);
    let desc = TextureDesc::d2_array(
        size,
        size,
        views.len() as u32,
        DEPTH_FORMAT,
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
    );
    let kind = kind_of(light);
    let pipeline: PipelineOf = Rc::new(move |class| pipeline(class, kind == 1));
    // Not the light itself: a map does not change with a flickering light.
    let face = |(view, layer): (&LightView, u32)| LayerView {
        layer: Some(layer),
        frustum: Frustum::new(&view.clip_from_world),
        uniform: ShadowViewUniform { clip_from_world: view.clip_from_world, eye: view.eye, far: view.far },
        pipeline: Rc::clone(&pipeline),
    };
    let faces: Vec<_> = views.iter().zip(0..).map(face).collect();
    let targets = [(name.clone(), desc)];
    let [map] = static_layers::declare(graph, frame, &name, targets, DrawFilter::casters, &faces);
    Some(ShadowMap { map, views, kind, size })
}

/// The light's shadow map, if it was declared before.
pub(in crate::render) fn declared(graph: &Graph, frame: &Frame, light: &SceneLight) -> Option<ShadowMap> {
    let map = graph.latest(&pass_name(light))?;
    let size = light.shadow_size.clamp(1, 8192);
    Some(ShadowMap { map, views: light_views(light, &frame.bounds), kind: kind_of(light), size })
}

/// Width of a texel \[m\] above which small things lose their shadows, so that rays are asked for.
const COARSE: f32 = 0.02;

/// Whether the shadow map of any light is too coarse for small things: its light comes from far, or its scene is large.
pub(in crate::render) fn are_coarse(lights: &[SceneLight], bounds: &Aabb) -> bool {
    let width = |light: &SceneLight| match light.shape.is_distant() {
        true => light_views(light, bounds).first().map_or(0.0, |view| 2.0 * view.half_extent),
        false => 2.0 * bounds.distance(light.position),
    };
    let casters = lights.iter().filter(|light| light.casts_shadow && light.intensity != Vec3::ZERO);
    !bounds.is_empty()
        && casters.into_iter().any(|light| width(light) > COARSE * light.shadow_size.clamp(1, 8192) as f32)
}

fn pass_name(light: &SceneLight) -> String {
    format!("shadow {}", light.pass_name())
}

fn kind_of(light: &SceneLight) -> u32 {
    match light.shape {
        LightShape::Directional | LightShape::Sun { .. } => 1,
        LightShape::Spot { .. } if !sees_by_cube(&light.shape) => 2,
        _ => 3,
    }
}

fn pipeline(class: MaterialClass, directional: bool) -> RasterKey {
    let fragment = match (directional, class.masked) {
        (true, false) => None,
        (true, true) => Some("directional_masked"),
        (false, false) => Some("perspective_opaque"),
        (false, true) => Some("perspective_masked"),
    };
    RasterKey {
        shader: "shadows/shadow_map.wgsl",
        vertex: "vertex",
        fragment,
        defs: class.defs(),
        vertex_buffers: class.vertex_buffers(),
        // Both sides of a surface block light, whichever of them can be seen.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..class.primitive_state() },
        depth: Some(depth_state()),
        targets: Vec::new(),
    }
}
