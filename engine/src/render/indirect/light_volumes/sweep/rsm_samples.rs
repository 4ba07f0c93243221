//! Surface points that lights reach, which the final gather samples beside its rays. See `indirect/light_volumes/sweep/rsm_samples.wgsl`.

use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::rsm_draw::{Draw, Wanted, Weight};
use crate::render::shadows::reflective::Rsm;
use crate::scene::Aabb;
use wgpu::BufferUsages;

/// How many points: as many as neighbouring pixels must not all gather from the same few, or their noise would be alike.
pub(super) const POINTS: u32 = 8192;
/// Bytes of a point: `POINT_TEXELS` of `lib/rsm_samples.wgsl`.
const POINT_BYTES: u64 = 48;

/// The points of a frame.
#[derive(Clone, Copy)]
pub(super) struct RsmSamples {
    /// Three times four words a point.
    pub points: Handle<Buffer>,
    /// All points lie in this box, and are drawn from all that lies in it.
    pub reach: Aabb,
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
    // The map of a light with a surface is seen from its middle alone, and does not know the borders of its shadows.
    let mut maps = rsms.iter().filter(|rsm| rsm.light.casts_shadow && !rsm.light.shape.is_area()).peekable();
    if maps.peek().is_none() || asked_for == 0 {
        let why = if asked_for == 0 {
            "no points are asked for"
        } else {
            "no light without a surface that casts shadows has a map"
        };
        graph.skip("RSM samples", why);
        return None;
    }
    let seed = frame.seed() ^ 0x5bd1_e995;
    let wanted = Wanted { reach, scale, points: POINTS, seed, weight: Weight::Received };
    let draw = Draw::declare(graph, ["flux of lit texels", "flux of strips"], maps, wanted);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let points = graph.retained_buffer("RSM samples", BufferDesc::new(POINT_BYTES * u64::from(POINTS), usage));
    let shader = draw.shader("indirect/light_volumes/sweep/rsm_samples.wgsl", "choose");
    let mut pass = graph.compute("RSM samples", shader.clone());
    let points = pass.write("points", points);
    pass.clear(points);
    draw.declare_steps(&mut pass, &shader);
    pass.finish();
    Some(RsmSamples { points, reach })
}
