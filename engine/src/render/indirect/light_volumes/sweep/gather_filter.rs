//! The cross bilateral filter over what was gathered, and the reflected radiance. See `indirect/light_volumes/sweep/gather_filter.wgsl`.

use super::interleave::{Interleave, InterleaveUniform};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::RayScene;
use encase::ShaderType;

/// The contributions of the rays, rgba32float: what a white diffuse surface reflects, and what the specular lobe does.
#[derive(Clone, Copy)]
pub(super) struct Gathered {
    pub diffuse: Handle<Texture>,
    pub specular: Handle<Texture>,
}

/// How many times as bright as all that is next to it the light of a sparse frame may be while light changes; at rest
/// anything goes, for the mean of many frames is right only if nothing is cut off.
const STRAY: f32 = 2.0;
const ANY: f32 = 1e6;

/// `Reach` of `indirect/light_volumes/sweep/gather_filter.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ReachUniform {
    radius: f32,
    weight: f32,
    stray: f32,
    #[shader(align(16))]
    interleave: InterleaveUniform,
}

/// How far the filter reaches, over which pixels.
#[derive(Clone, Copy)]
struct Reach {
    /// Distance at which weights are zero \[texels\]; up to 1 nothing is filtered.
    radius: f32,
    interleave: Interleave,
}

/// Declares the filter where all pixels were gathered at; the result is reflected radiance. `radius` is that of the filter
/// \[pixels\]; up to 1 nothing is filtered.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    interleave: Interleave,
    radius: f32,
) -> Handle<Texture> {
    let reach = Reach { radius: interleave.radius(radius), interleave };
    let half = if reach.radius > 1.0 { horizontal(graph, frame, gbuffer, gathered, reach) } else { gathered };
    vertical(graph, frame, gbuffer, half, reach)
}

/// Declares the filter alone, for images that take their light from the gathered pixels. It is kept, for there may be many.
pub(super) fn declare_apart<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    interleave: Interleave,
    radius: f32,
) -> Gathered {
    let reach = Reach { radius: interleave.radius(radius), interleave };
    if reach.radius <= 1.0 {
        return gathered;
    }
    let half = horizontal(graph, frame, gbuffer, gathered, reach);
    vertical_apart(graph, frame, gbuffer, half, reach)
}

fn vertical<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    half: Gathered,
    reach: Reach,
) -> Handle<Texture> {
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let inputs = [("base_color", gbuffer.base_color)].into_iter().chain(along_axis(gbuffer, half));
    let inputs = inputs.chain(tint(frame, gbuffer)).collect();
    let [indirect] =
        pass(graph, frame, ["gather filter, vertical", "vertical"], inputs, [("indirect", indirect)], reach);
    indirect
}

fn horizontal<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    reach: Reach,
) -> Gathered {
    let names = ["gathered diffuse, filtered along rows", "gathered specular, filtered along rows"];
    let [diffuse, specular] = names.map(|name| graph.texture(name, reach.interleave.image_desc(frame)));
    let which = ["gather filter, horizontal", "horizontal"];
    apart(graph, frame, gbuffer, gathered, Gathered { diffuse, specular }, which, reach)
}

fn vertical_apart<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    half: Gathered,
    reach: Reach,
) -> Gathered {
    let names = ["gathered diffuse, filtered", "gathered specular, filtered"];
    let desc = reach.interleave.image_desc(frame);
    let is_kept = !reach.interleave.is_sparse();
    let [diffuse, specular] =
        names.map(
            |name| if is_kept { graph.retained_texture(name, desc.clone()) } else { graph.texture(name, desc.clone()) },
        );
    let which = ["gather filter, vertical", "vertical_apart"];
    apart(graph, frame, gbuffer, half, Gathered { diffuse, specular }, which, reach)
}

/// Declares a pass that leaves diffuse and specular light apart.
fn apart<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    filtered: Gathered,
    which: [&'static str; 2],
    reach: Reach,
) -> Gathered {
    let outputs = [("diffuse_out", filtered.diffuse), ("specular_out", filtered.specular)];
    let inputs = along_axis(gbuffer, gathered).into();
    let [diffuse, specular] = pass(graph, frame, which, inputs, outputs, reach);
    Gathered { diffuse, specular }
}

/// Inputs of every pass of the filter, by the shader's names.
fn along_axis(gbuffer: &GBuffer, gathered: Gathered) -> [(&'static str, Handle<Texture>); 4] {
    let Gathered { diffuse, specular } = gathered;
    [("normal", gbuffer.normal), ("depth", gbuffer.depth), ("diffuse", diffuse), ("specular", specular)]
}

/// Whether specular light is told over the tint of its lobe.
pub(super) fn is_tinted(frame: &Frame) -> bool {
    frame.rays.is_some_and(RayScene::has_layers)
}

/// What specular light has to be multiplied by in the end, where it is told over the tint of its lobe.
pub(super) fn tint(frame: &Frame, gbuffer: &GBuffer) -> Option<(&'static str, Handle<Texture>)> {
    is_tinted(frame).then_some(("object", gbuffer.object))
}

/// The shader that is to find that.
pub(super) fn tinted(frame: &Frame, key: ComputeKey) -> ComputeKey {
    if is_tinted(frame) { key.def("TINTED", ShaderDef::Flag(true)) } else { key }
}

/// Declares a pass by its name and entry point.
fn pass<'a, const N: usize>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    [name, entry]: [&'static str; 2],
    inputs: Vec<(&'static str, Handle<Texture>)>,
    outputs: [(&'static str, Handle<Texture>); N],
    reach: Reach,
) -> [Handle<Texture>; N] {
    let mut pass = graph.pass(name);
    inputs.iter().for_each(|(_, input)| pass.read(*input));
    let outputs = outputs.map(|(name, output)| (name, pass.write(output)));
    let is_unlit = is_unlit(frame);
    pass.key(&(reach.radius.to_bits(), reach.interleave.key(), frame.view_key(), frame.history.is_changing(), is_unlit));
    pass.key(&is_tinted(frame));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let views: Vec<_> = inputs.iter().chain(&outputs).map(|(name, handle)| (*name, cx.view(*handle))).collect();
        let bindings: Vec<_> = views.iter().map(|(name, view)| (*name, Binding::Texture(view))).collect();
        run(cx, &frame, reach, entry, &bindings)
    });
    outputs.map(|(_, output)| output)
}

/// Whether no surface that rays meet emits light.
fn is_unlit(frame: &Frame) -> bool {
    frame.rays.is_none_or(|rays| rays.emitter_count == 0)
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
        radius: radius.max(1.0),
        weight: interleave.weight(),
        stray: if frame.history.is_changing() { STRAY } else { ANY },
        interleave: interleave.uniform(),
    };
    let reach = cx.gpu.uniform("reach", &uniform);
    let mut group = vec![("view", Binding::Buffer(&view)), ("reach", Binding::Buffer(&reach))];
    group.extend_from_slice(bindings);
    cx.counts().texels += u64::from(width) * u64::from(height);
    let mut key = tinted(frame, ComputeKey::new("indirect/light_volumes/sweep/gather_filter.wgsl", entry));
    if is_unlit(frame) {
        key = key.def("UNLIT", ShaderDef::Flag(true));
    }
    cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
}
