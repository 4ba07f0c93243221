//! Reflective shadow maps: what each light sees, as the sources of indirect light (Dachsbacher and Stamminger 2005).

use super::light_view::{LightView, light_views};
use super::through_glass;
use crate::gpu::RasterKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{DEPTH_FORMAT, depth_state};
use crate::render::geometry::static_layers::{self, LayerView};
use crate::render::scene_gpu::{DrawFilter, MaterialClass};
use crate::scene::{Aabb, Frustum, MAX_RSM_SIZE, SceneLight};
use encase::ShaderType;
use glam::{Mat4, Vec3};
use std::rc::Rc;
use wgpu::TextureFormat;

/// `RsmView` of `shadows/reflective.wgsl`.
#[derive(ShaderType)]
pub(crate) struct RsmViewUniform {
    clip_from_world: Mat4,
    eye: Vec3,
}

/// `RsmLayer` of `lib/rsm.wgsl`.
#[derive(ShaderType)]
pub(crate) struct RsmLayerUniform {
    world_from_clip: Mat4,
    half_extent: f32,
    size: u32,
    layer: i32,
    scale: f32,
}

/// A light's reflective shadow map, one layer a view.
#[derive(Clone)]
pub struct Rsm<'a> {
    /// The light.
    pub light: &'a SceneLight,
    /// Its place in the scene's array.
    pub index: u32,
    /// Views that are drawn; a point light's faces that see nothing of use are left out.
    pub views: Vec<LightView>,
    /// Edge \[texels\].
    pub size: u32,
    /// Base colour and metallic, as in the G-buffer.
    pub base_color: Handle<Texture>,
    /// Normal, roughness and F90, as in the G-buffer.
    pub normal: Handle<Texture>,
    /// √F0, ten bits a channel, as in the G-buffer.
    pub specular: Handle<Texture>,
    /// Reversed depth.
    pub depth: Handle<Texture>,
}

impl Rsm<'_> {
    /// What the light's intensity is multiplied by for a bound on its flux: the area that it shines through \[m²\], or all
    /// directions \[sr\].
    pub(in crate::render) fn extent(&self) -> f32 {
        match self.light.shape.is_distant() {
            true => self.views.iter().map(|view| 4.0 * view.half_extent * view.half_extent).sum(),
            false => 4.0 * std::f32::consts::PI,
        }
    }

    /// Power of two that turns flux [W] into fixed point so that no sum over the whole map overflows: a lobe's
    /// coefficient is at most a third of its flux, and all flux together at most what the light sends into its views.
    ///
    /// A power of two leaves all bits of the flux in place: light of 2ᵏ times the intensity gives the same sums.
    pub(in crate::render) fn fixed_point_scale(&self) -> f32 {
        let intensity = self.light.intensity.max_element();
        let total = (intensity * self.extent()).clamp(1e-30, 1e36);
        (29.0 - total.log2().ceil()).exp2()
    }

    /// How a shader finds its way from a texel to the surface.
    pub(in crate::render) fn layer_uniform(&self, layer: usize, scale: f32) -> RsmLayerUniform {
        let view = &self.views[layer];
        RsmLayerUniform {
            world_from_clip: view.world_from_clip,
            half_extent: view.half_extent,
            size: self.size,
            layer: layer as i32,
            scale,
        }
    }

    /// Number of texels of a layer.
    pub(in crate::render) fn layer_texels(&self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }
}

/// Edge \[texels\] with which a texel is no larger than `spacing` \[m\] at the far end of the light's views: a power of
/// two times the light's own size, and at most 1024 or the light's own.
pub fn size_for_spacing(light: &SceneLight, bounds: &Aabb, spacing: f32) -> u32 {
    let is_distant = light.shape.is_distant();
    let width = |view: &LightView| 2.0 * view.half_extent * if is_distant { 1.0 } else { view.far };
    let widest = light_views(light, bounds).iter().map(width).fold(0.0, f32::max);
    let mut size = light.rsm_size;
    while size > 0 && 2 * size <= 1024 && (size as f32) * spacing < widest {
        size *= 2;
    }
    size
}

/// Declares the light's RSM of its own size; none, with the reason in the report, if it feeds no indirect light into `reach`.
pub fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    light: &'a SceneLight,
    index: u32,
    reach: &Aabb,
) -> Option<Rsm<'a>> {
    declare_sized(graph, frame, light, index, reach, light.rsm_size)
}

/// Declares the light's RSM as [`declare`] does, with that many texels along an edge.
pub fn declare_sized<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    light: &'a SceneLight,
    index: u32,
    reach: &Aabb,
    size: u32,
) -> Option<Rsm<'a>> {
    let name = format!("rsm {}", light.pass_name());
    let skip = |graph: &mut Graph<'a>, reason: &str| {
        graph.skip(name.as_str(), reason);
        None
    };
    if !light.indirect {
        return skip(graph, "the light is marked as not feeding indirect light");
    }
    if light.intensity == Vec3::ZERO {
        return skip(graph, "the light has no intensity");
    }
    let all = light_views(light, &frame.bounds);
    let faces = all.len();
    let useful = |view: &LightView| {
        let frustum = Frustum::new(&view.clip_from_world);
        frustum.intersects(reach) && frame.gpu_scene.any_visible(&DrawFilter::casters(&frustum))
    };
    let views: Vec<LightView> = all.into_iter().filter(useful).collect();
    if views.is_empty() {
        return skip(graph, "it lights no surface in reach of a volume");
    }
    if views.len() < faces {
        let left_out = format!("{} of {faces} faces see no surface or light no volume", faces - views.len());
        graph.skip(format!("{name}, faces"), left_out);
    }
    let size = size.clamp(1, MAX_RSM_SIZE);
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let target = |part: &str, format| {
        (format!("{name} {part}"), TextureDesc::d2_array(size, size, views.len() as u32, format, usage))
    };
    let targets = [
        target("base color", TextureFormat::Rgba16Uint),
        target("normal", TextureFormat::Rgba16Uint),
        target("specular", TextureFormat::R32Uint),
        target("depth", DEPTH_FORMAT),
    ];
    // Not the light itself: a map does not change with a flickering light.
    let face = |(view, layer): (&LightView, u32)| {
        let mirrors = view.is_mirrored();
        // Faces of a cube are mirror images: there the front of a triangle winds the other way.
        let seen_as = move |class: MaterialClass| MaterialClass { mirrored: class.mirrored != mirrors, ..class };
        LayerView {
            layer: Some(layer),
            frustum: Frustum::new(&view.clip_from_world),
            uniform: RsmViewUniform { clip_from_world: view.clip_from_world, eye: view.eye },
            pipeline: Rc::new(move |class| pipeline(seen_as(class))),
        }
    };
    let faces: Vec<_> = views.iter().zip(0..).map(face).collect();
    let [base_color, normal, specular, depth] =
        static_layers::declare(graph, frame, &name, targets, DrawFilter::casters, &faces);
    let rsm = Rsm { light, index, views, size, base_color, normal, specular, depth };
    Some(through_glass::declare(graph, frame, rsm))
}

fn pipeline(class: MaterialClass) -> RasterKey {
    RasterKey {
        shader: "shadows/reflective.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: class.defs(),
        vertex_buffers: class.vertex_buffers(),
        // Backs of surfaces stop light too.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..class.primitive_state() },
        depth: Some(depth_state()),
        targets: vec![
            Some(TextureFormat::Rgba16Uint.into()),
            Some(TextureFormat::Rgba16Uint.into()),
            Some(TextureFormat::R32Uint.into()),
        ],
    }
}
