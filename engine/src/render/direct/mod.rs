//! Direct light: a compute pass for each light that casts shadows, over the pixels that it can reach (the thesis's
//! stencil volumes, 5.3.2), and one for all others together ([`direct_tiled`]). Where the scene is there for rays, a shadow ray
//! decides at the borders of shadows, where a map's texels are too coarse to. Lights with a surface have passes of their own
//! ([`area`]).

pub(in crate::render) mod area;
pub(in crate::render) mod area_shadows;
pub(in crate::render) mod area_tiles;
pub(in crate::render) mod lamps;
pub(in crate::render) mod tiled;

use super::frame::Frame;
use super::geometry::gbuffer::GBuffer;
use super::shadows::shadow_map::{self, ShadowMap};
use crate::gpu::{ComputeKey, Gpu, ShaderDef};
use crate::graph::{Counts, Graph, Handle, Texture, TextureDesc};
use crate::render::rays::RayScene;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::scene::{Aabb, SceneLight, SceneView};
use encase::ShaderType;
use glam::{UVec2, Vec3};

/// `Region` of `direct/direct.wgsl`.
#[derive(ShaderType)]
pub(crate) struct RegionUniform {
    origin: UVec2,
    size: UVec2,
    root: u32,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::render) struct Region {
    pub origin: UVec2,
    pub size: UVec2,
}

/// Declares the passes of all lights. The result is radiance, red, green and blue as layers of r32float.
pub fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    direct_lights: &[DirectLight<'a>],
) -> Handle<Texture> {
    let radiance = declare_clear(graph, frame);
    add(graph, frame, gbuffer, radiance, direct_lights)
}

/// Declares the passes of all lights, which add to the radiance.
pub(in crate::render) fn add<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    mut radiance: Handle<Texture>,
    direct_lights: &[DirectLight<'a>],
) -> Handle<Texture> {
    let (area, points): (Vec<&DirectLight>, Vec<&DirectLight>) =
        direct_lights.iter().partition(|direct_light| direct_light.light.shape.is_area());
    for direct_light in area {
        radiance = area::declare(graph, frame, gbuffer, radiance, direct_light.clone());
    }
    let (shadowed, others): (Vec<&DirectLight>, Vec<&DirectLight>) =
        points.iter().partition(|light| light.shadow.is_some() || light.may_be_filtered(frame));
    let is_tiled = !frame.settings.each_light_alone && others.len() >= FEWEST;
    let (alone, tiled) = if is_tiled { (shadowed, others) } else { (points, Vec::new()) };
    for direct_light in alone {
        let name = gbuffer.surfaces.name(&format!("direct {}", direct_light.light.pass_name()));
        radiance = declare_light(graph, frame, gbuffer, radiance, &name, direct_light);
    }
    if tiled.is_empty() {
        return radiance;
    }
    tiled::declare(graph, frame, gbuffer, radiance, tiled.into_iter().cloned().collect())
}

/// Lights without shadows from which on they share a pass.
const FEWEST: usize = 4;

/// A light that reaches the view, with what the passes need that it lights.
#[derive(Clone)]
pub struct DirectLight<'a> {
    /// The light.
    pub light: &'a SceneLight,
    /// Its shadow map, if it casts shadows.
    pub shadow: Option<ShadowMap>,
    region: Region,
}

impl DirectLight<'_> {
    /// Whether glass may take a part of it.
    fn may_be_filtered(&self, frame: &Frame) -> bool {
        self.light.casts_shadow && frame.gpu_scene.has_glass()
    }
}

/// Declares the shadow maps of all lights that reach the view.
pub fn direct_lights<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> Vec<DirectLight<'a>> {
    let mut direct_lights = Vec::new();
    for light in &frame.scene.lights {
        let name = format!("direct {}", light.pass_name());
        if light.intensity == Vec3::ZERO {
            graph.skip(&name, "the light has no intensity");
        } else if let Some(region) = reached_region(light, frame.view) {
            let shadow = shadow_map::declare(graph, frame, light);
            direct_lights.push(DirectLight { light, shadow, region });
        } else {
            graph.skip(&name, "its reach lies outside the view");
        }
    }
    direct_lights
}

pub(in crate::render) fn declare_clear<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2_array(width, height, 3, wgpu::TextureFormat::R32Float, usage);
    let radiance = graph.retained_texture("direct radiance", desc);
    let mut pass = graph.compute("direct clear", ComputeKey::new("direct/direct.wgsl", "clear"));
    let radiance = pass.write("radiance", radiance);
    pass.dispatch_over([width, height]);
    radiance
}

fn declare_light<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
    name: &str,
    direct_light: &DirectLight<'a>,
) -> Handle<Texture> {
    let may_cast = direct_light.shadow.is_some() || direct_light.may_be_filtered(frame);
    let rays = frame.shadow_rays.filter(|_| may_cast);
    let mut pass = graph.compute(name, ComputeKey::new("direct/direct.wgsl", "add_light"));
    match rays {
        Some(rays) => {
            pass.define("SHADOW_RAYS", ShaderDef::Flag(true));
            rays.bind_surfaces(&mut pass);
        }
        None => frame.gpu_scene.bind_media(&mut pass),
    }
    gbuffer.surfaces.define_for(&mut pass);
    frame.bind_view(&mut pass);
    pass.uniform("light", &LightUniform::new(direct_light.light));
    let Region { origin, size } = direct_light.region;
    pass.uniform("region", &RegionUniform { origin, size, root: rays.map_or(0, RayScene::root) });
    gbuffer.bind(&mut pass);
    let shadow = direct_light.shadow.as_ref();
    pass.uniform("shadow", &shadow.map_or_else(ShadowMap::none_uniform, ShadowMap::uniform));
    pass.sampler("shadow_sampler", comparison());
    match shadow {
        Some(shadow) => pass.read_layers("shadow_map", shadow.map),
        None => pass.stand_in("shadow_map", no_shadow_map),
    }
    let radiance = pass.write("radiance", radiance);
    pass.count(Counts { lights: 1, ..Counts::default() });
    pass.dispatch_over(size.into());
    radiance
}

pub(in crate::render) fn layered_view(gpu: &Gpu, texture: &wgpu::Texture) -> wgpu::TextureView {
    gpu.view_of_layers(texture, wgpu::TextureViewDimension::D2Array, 0..texture.depth_or_array_layers())
}

/// Stands in where a light has no map; it is never read.
pub(in crate::render) fn no_shadow_map(gpu: &Gpu) -> wgpu::TextureView {
    gpu.stand_in("no shadow", 1, || {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("no shadow"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: super::geometry::gbuffer::DEPTH_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
    })
}

/// Lit where the receiver's reversed depth is not below the stored one.
pub(in crate::render) fn comparison_sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.sampler(&comparison())
}

fn comparison() -> wgpu::SamplerDescriptor<'static> {
    wgpu::SamplerDescriptor {
        label: Some("shadow comparison"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        compare: Some(wgpu::CompareFunction::GreaterEqual),
        ..Default::default()
    }
}

/// The pixels that a light of limited range can reach: the rectangle around its box. None if that is outside.
fn reached_region(light: &SceneLight, view: &SceneView) -> Option<Region> {
    let full = Region { origin: UVec2::ZERO, size: view.size.into() };
    let (Some(range), true) = (light.range, light.has_position()) else { return Some(full) };
    region_around(&Aabb { min: light.position - range, max: light.position + range }, view)
}

/// The pixels in which a box may be seen. None if it is outside the view.
pub(in crate::render) fn region_around(reach: &Aabb, view: &SceneView) -> Option<Region> {
    let full = Region { origin: UVec2::ZERO, size: view.size.into() };
    let clip_from_world = view.clip_from_world();
    if !crate::scene::Frustum::new(&clip_from_world).intersects(reach) {
        return None;
    }
    let corners = reach.corners().map(|corner| clip_from_world * corner.extend(1.0));
    // In an orthographic image w is 1, wherever the corner lies.
    if !view.camera.is_orthographic() && corners.iter().any(|corner| corner.w <= view.camera.near) {
        return Some(full);
    }
    let size = glam::Vec2::new(view.size[0] as f32, view.size[1] as f32);
    let pixels = corners.map(|c| (glam::Vec2::new(c.x, -c.y) / c.w * 0.5 + 0.5) * size);
    if !pixels.iter().all(|pixel| pixel.is_finite()) {
        return Some(full);
    }
    let low = pixels.iter().fold(size, |low, p| low.min(*p)).floor().max(glam::Vec2::ZERO);
    let high = pixels.iter().fold(glam::Vec2::ZERO, |high, p| high.max(*p)).ceil().min(size);
    let (low, high) = (low.as_uvec2(), high.as_uvec2());
    (low.x < high.x && low.y < high.y).then(|| Region { origin: low, size: high - low })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LightShape, SceneCamera, SceneId, ViewProjection};
    use glam::Affine3A;

    fn view() -> SceneView {
        let camera = SceneCamera {
            id: SceneId(1),
            name: "camera".into(),
            world_from_view: Affine3A::IDENTITY,
            projection: ViewProjection::Perspective { vertical_fov: 1.0 },
            near: 0.1,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
        };
        SceneView { camera, size: [128, 64], jitter: [0.0; 2] }
    }

    fn direct_light(position: Vec3, range: Option<f32>) -> SceneLight {
        SceneLight {
            id: SceneId(2),
            name: "lamp".into(),
            shape: LightShape::Point,
            intensity: Vec3::ONE,
            position,
            direction: Vec3::NEG_Z,
            axis: Vec3::X,
            range,
            casts_shadow: false,
            indirect: false,
            shadow_size: 1,
            rsm_size: 1,
            revision: 0,
        }
    }

    #[test]
    fn a_light_pays_only_for_pixels_in_its_reach() {
        let region = reached_region(&direct_light(Vec3::new(0.0, 0.0, -10.0), Some(1.0)), &view()).expect("in view");
        assert!(region.size.x < 24 && region.size.y < 24 && region.size.x > 4, "{region:?}");
        assert!(region.origin.x > 48 && region.origin.x + region.size.x < 80, "{region:?}");
        assert_eq!(reached_region(&direct_light(Vec3::new(0.0, 0.0, 10.0), Some(1.0)), &view()), None);
        let whole = reached_region(&direct_light(Vec3::new(0.0, 0.0, -10.0), None), &view()).expect("everywhere");
        assert_eq!(whole.size, UVec2::new(128, 64));
        let mut parallel = view();
        parallel.camera.projection = ViewProjection::Orthographic { height: 8.0 };
        for distance in [0.0, 2.0, 40.0] {
            let region =
                reached_region(&direct_light(Vec3::new(2.0, 0.0, -distance), Some(1.0)), &parallel).expect("in view");
            assert_eq!((region.origin, region.size), (UVec2::new(72, 24), UVec2::new(16, 16)), "at {distance} m");
        }
    }
}
