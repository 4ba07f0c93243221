//! The cross bilateral filter over what was gathered, and the reflected radiance. See `indirect/light_volumes/sweep/gather_filter.wgsl`.

use super::gather_upsample;
use super::interleave::{Interleave, InterleaveUniform};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;

/// What the rays brought, rgba32float: what a white diffuse surface reflects, and what the specular lobe does.
#[derive(Clone, Copy)]
pub(super) struct Gathered {
    pub diffuse: Handle<Texture>,
    pub specular: Handle<Texture>,
}

/// How many times as bright as all that is next to it light of a sparse frame may be: while light changes, and at rest,
/// where the mean of many frames is right only if nothing is cut off.
const STRAY: f32 = 2.0;
const ANY: f32 = 1e6;

/// `Reach` of `indirect/light_volumes/sweep/gather_filter.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ReachUniform {
    radius: i32,
    weight: f32,
    stray: f32,
    #[shader(align(16))]
    interleave: InterleaveUniform,
}

/// How far the filter reaches, over which pixels.
#[derive(Clone, Copy)]
struct Reach {
    /// \[texels\]
    radius: u32,
    interleave: Interleave,
}

/// Declares the filter, and where not all pixels were gathered at the light of those between; the result is reflected
/// radiance. `radius` is that of the filter \[pixels\]; 0: none.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    interleave: Interleave,
    radius: u32,
) -> Handle<Texture> {
    let reach = Reach { radius: interleave.radius(radius), interleave };
    let half = match reach.radius {
        0 | 1 => gathered,
        _ => horizontal(graph, frame, gbuffer, gathered, reach),
    };
    match interleave.is_sparse() {
        true => {
            let filtered = if reach.radius > 1 { vertical_sparse(graph, frame, gbuffer, half, reach) } else { half };
            gather_upsample::declare(graph, frame, gbuffer, filtered, interleave)
        }
        false => vertical(graph, frame, gbuffer, half, reach),
    }
}

fn vertical<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    half: Gathered,
    reach: Reach,
) -> Handle<Texture> {
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let mut pass = graph.pass("gather filter, vertical");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth, half.diffuse, half.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let indirect = pass.write(indirect);
    pass.key(&(reach.radius, reach.interleave.key(), frame.view_key(), frame.history.is_changing()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let [base_color, normal, depth, diffuse, specular] = inputs.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        run(
            cx,
            &frame,
            reach,
            "vertical",
            &[
                ("base_color", Binding::Texture(&base_color)),
                ("normal", Binding::Texture(&normal)),
                ("depth", Binding::Texture(&depth)),
                ("diffuse", Binding::Texture(&diffuse)),
                ("specular", Binding::Texture(&specular)),
                ("indirect", Binding::Texture(&target)),
            ],
        )
    });
    indirect
}

fn horizontal<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    reach: Reach,
) -> Gathered {
    let half = ["gathered diffuse, filtered along rows", "gathered specular, filtered along rows"];
    along(graph, frame, gbuffer, gathered, half, ("gather filter, horizontal", "horizontal"), reach)
}

fn vertical_sparse<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    half: Gathered,
    reach: Reach,
) -> Gathered {
    let filtered = ["gathered diffuse, filtered", "gathered specular, filtered"];
    along(graph, frame, gbuffer, half, filtered, ("gather filter, vertical", "vertical_sparse"), reach)
}

/// Declares a pass by its name and entry point that filters along one axis.
fn along<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    [diffuse, specular]: [&'static str; 2],
    (name, entry): (&'static str, &'static str),
    reach: Reach,
) -> Gathered {
    let desc = reach.interleave.image_desc(frame);
    let filtered = Gathered { diffuse: graph.texture(diffuse, desc.clone()), specular: graph.texture(specular, desc) };
    let mut pass = graph.pass(name);
    let inputs = [gbuffer.normal, gbuffer.depth, gathered.diffuse, gathered.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let filtered = Gathered { diffuse: pass.write(filtered.diffuse), specular: pass.write(filtered.specular) };
    pass.key(&(reach.radius, reach.interleave.key(), frame.view_key(), frame.history.is_changing()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let [normal, depth, diffuse, specular] = inputs.map(|handle| cx.view(handle));
        let [diffuse_out, specular_out] = [filtered.diffuse, filtered.specular].map(|handle| cx.view(handle));
        run(
            cx,
            &frame,
            reach,
            entry,
            &[
                ("normal", Binding::Texture(&normal)),
                ("depth", Binding::Texture(&depth)),
                ("diffuse", Binding::Texture(&diffuse)),
                ("specular", Binding::Texture(&specular)),
                ("diffuse_out", Binding::Texture(&diffuse_out)),
                ("specular_out", Binding::Texture(&specular_out)),
            ],
        )
    });
    filtered
}

fn run(
    cx: &mut PassContext,
    frame: &Frame,
    Reach { radius, interleave }: Reach,
    entry: &'static str,
    bindings: &[(&str, Binding)],
) -> Result<(), PassError> {
    let [width, height] = interleave.texels();
    let view = frame.view_uniform(cx.gpu);
    // Not a constant of the pipeline: the radius shrinks while a view comes to rest.
    let uniform = ReachUniform {
        radius: radius.max(1) as i32,
        weight: interleave.weight(),
        stray: if frame.history.is_changing() { STRAY } else { ANY },
        interleave: interleave.uniform(),
    };
    let reach = cx.gpu.uniform("reach", &uniform);
    let mut group = vec![("view", Binding::Buffer(&view)), ("reach", Binding::Buffer(&reach))];
    group.extend_from_slice(bindings);
    cx.counts().texels += u64::from(width) * u64::from(height);
    let key = ComputeKey::new("indirect/light_volumes/sweep/gather_filter.wgsl", entry);
    cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
}
