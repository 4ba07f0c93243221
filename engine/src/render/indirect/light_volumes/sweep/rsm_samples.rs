//! Surface points that lights reach, which the final gather samples beside its rays. See `indirect/light_volumes/sweep/rsm_samples.wgsl`.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use crate::scene::Aabb;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// How many points: as many as neighbouring pixels must not all gather from the same few, or their noise would be alike.
pub(super) const POINTS: u32 = 8192;
/// Bytes of a point: `POINT_TEXELS` of `lib/rsm_samples.wgsl`.
const POINT_BYTES: u64 = 48;
/// `STRIP` of `indirect/light_volumes/sweep/rsm_samples.wgsl`.
const STRIP: u32 = 32;

/// `Draw` of `indirect/light_volumes/sweep/rsm_samples.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct DrawUniform {
    low: Vec3,
    first_strip: u32,
    high: Vec3,
    strips: u32,
    points: u32,
    seed: u32,
    scale: f32,
    light: u32,
}

/// The points of a frame.
#[derive(Clone, Copy)]
pub(super) struct RsmSamples {
    /// Three times four words a point.
    pub points: Handle<Buffer>,
    /// All points lie in this box, and are drawn from all that lies in it.
    pub reach: Aabb,
}

/// One view of a light.
struct Map<'a> {
    rsm: Rsm<'a>,
    layer: usize,
    first_strip: u32,
}

/// Declares the points; none, with the reason in the report, if no light has a map or no pixel asks for points.
///
/// Points are drawn within `reach`. The scale is that of [`super::emit::scale`]. Lights without shadows light what their map
/// does not see; they are left to the rays.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    rsms: &[Rsm<'a>],
    (reach, scale): (Aabb, f32),
    asked_for: u32,
) -> Option<RsmSamples> {
    let (mut maps, mut strips) = (Vec::new(), 0);
    // The map of a light with a surface is seen from its middle alone, and does not know the borders of its shadows.
    for rsm in rsms.iter().filter(|rsm| rsm.light.casts_shadow && !rsm.light.shape.is_area()) {
        for layer in 0..rsm.views.len() {
            maps.push(Map { rsm: rsm.clone(), layer, first_strip: strips });
            strips += strips_of(rsm);
        }
    }
    if maps.is_empty() || asked_for == 0 {
        let why = if asked_for == 0 {
            "no points are asked for"
        } else {
            "no light without a surface that casts shadows has a map"
        };
        graph.skip("RSM samples", why);
        return None;
    }
    let draw = DrawUniform {
        low: reach.min,
        first_strip: 0,
        high: reach.max,
        strips,
        points: POINTS,
        seed: frame.seed() ^ 0x5bd1_e995,
        scale,
        light: 0,
    };
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let cumulative = graph.retained_buffer("flux of lit texels", BufferDesc::new(4 * u64::from(strips), usage));
    let weights = graph.buffer("flux of strips", BufferDesc::new(4 * u64::from(strips), usage));
    let points = graph.retained_buffer("RSM samples", BufferDesc::new(POINT_BYTES * u64::from(POINTS), usage));
    let lights: Vec<(u64, u32)> = maps.iter().map(|map| (map.rsm.light.revision, map.rsm.index)).collect();
    let box_bits = [reach.min, reach.max].map(|corner| corner.to_array().map(f32::to_bits));

    let mut pass = graph.pass("flux of lit texels");
    read_maps(&maps, |texture| pass.read(texture));
    let (weights, cumulative) = (pass.write(weights), pass.write(cumulative));
    pass.key(&(&lights, box_bits, scale.to_bits(), strips));
    let weighed: Vec<Map> = maps.iter().map(|map| Map { rsm: map.rsm.clone(), ..*map }).collect();
    pass.execute(move |cx| {
        let [weights, cumulative] = [weights, cumulative].map(|handle| cx.buffer(handle).clone());
        for map in &weighed {
            let strips = strips_of(&map.rsm);
            dispatch(cx, "weigh", map, &draw, ("weights", &weights), &[], linear_groups(strips))?;
        }
        let uniform = cx.gpu.uniform("draw", &draw);
        let group = [
            ("draw", Binding::Buffer(&uniform)),
            ("weights", Binding::Buffer(&weights)),
            ("cumulative", Binding::Buffer(&cumulative)),
        ];
        cx.dispatch(&ComputeKey::new("indirect/light_volumes/sweep/rsm_samples.wgsl", "sum_up"), &group, [1, 1, 1])
    });

    let mut pass = graph.pass("RSM samples");
    read_maps(&maps, |texture| pass.read(texture));
    pass.read(cumulative);
    let points = pass.write(points);
    pass.key(&(lights, box_bits, scale.to_bits(), draw.seed));
    pass.execute(move |cx| {
        let [cumulative, points] = [cumulative, points].map(|handle| cx.buffer(handle).clone());
        cx.encoder().clear_buffer(&points, 0, None);
        for map in &maps {
            let more = [("points", &points)];
            dispatch(cx, "choose", map, &draw, ("cumulative", &cumulative), &more, linear_groups(POINTS))?;
        }
        Ok(())
    });
    Some(RsmSamples { points, reach })
}

/// Strips of one view.
fn strips_of(rsm: &Rsm) -> u32 {
    rsm.size.div_ceil(STRIP) * rsm.size
}

fn read_maps(maps: &[Map], mut read: impl FnMut(Handle<crate::graph::Texture>)) {
    for map in maps.iter().filter(|map| map.layer == 0) {
        [map.rsm.base_color, map.rsm.normal, map.rsm.specular, map.rsm.depth].into_iter().for_each(&mut read);
    }
}

/// Runs an entry point over a map.
fn dispatch(
    cx: &mut PassContext,
    entry: &'static str,
    map: &Map,
    draw: &DrawUniform,
    buffer: (&str, &wgpu::Buffer),
    more: &[(&str, &wgpu::Buffer)],
    groups: [u32; 3],
) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let draw = gpu.uniform("draw", &DrawUniform { first_strip: map.first_strip, light: map.rsm.index, ..*draw });
    let light = LightUniform::buffer(gpu, map.rsm.light);
    let rsm = gpu.uniform("rsm", &map.rsm.layer_uniform(map.layer, 1.0));
    let key = ComputeKey::new("indirect/light_volumes/sweep/rsm_samples.wgsl", entry);
    let textures = [
        ("base_color", map.rsm.base_color),
        ("normal", map.rsm.normal),
        ("specular", map.rsm.specular),
        ("depth", map.rsm.depth),
    ];
    let textures = textures.map(|(name, handle)| (name, cx.view(handle)));
    let mut group =
        vec![("draw", Binding::Buffer(&draw)), ("light", Binding::Buffer(&light)), ("rsm", Binding::Buffer(&rsm))];
    group.extend(textures.iter().map(|(name, view)| (*name, Binding::Texture(view))));
    group.extend([buffer].iter().chain(more).map(|&(name, buffer)| (name, Binding::Buffer(buffer))));
    cx.dispatch(&key, &group, groups)
}
