//! The cross bilateral filter over what was gathered, and the reflected radiance. See `indirect/light_volumes/sweep/gather_filter.wgsl`.

use super::interleave::{Interleave, InterleaveUniform};
use crate::gpu::ComputeKey;
use crate::graph::{ComputeBuilder, Graph, Handle, PassBindings, Texture};
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
    let mut pass = begin(graph, frame, gbuffer, half, ["gather filter, vertical", "vertical"], reach);
    bind_tint(&mut pass, frame, gbuffer);
    pass.read("base_color", gbuffer.base_color);
    let indirect = pass.write("indirect", indirect);
    pass.dispatch_over(reach.interleave.texels());
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
    let mut pass = begin(graph, frame, gbuffer, gathered, which, reach);
    let diffuse = pass.write("diffuse_out", filtered.diffuse);
    let specular = pass.write("specular_out", filtered.specular);
    pass.dispatch_over(reach.interleave.texels());
    Gathered { diffuse, specular }
}

/// Whether specular light is told over the tint of its lobe.
fn is_tinted(frame: &Frame) -> bool {
    frame.rays.is_some_and(RayScene::has_layers)
}

/// Binds what specular light has to be multiplied by in the end, where it is told over the tint of its lobe.
pub(super) fn bind_tint(pass: &mut PassBindings, frame: &Frame, gbuffer: &GBuffer) {
    if is_tinted(frame) {
        pass.flag("TINTED", true);
        pass.read("object", gbuffer.object);
    }
}

/// Begins a pass by its name and entry point.
fn begin<'g, 'a>(
    graph: &'g mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    [name, entry]: [&'static str; 2],
    Reach { radius, interleave }: Reach,
) -> ComputeBuilder<'g, 'a> {
    let shader = ComputeKey::new("indirect/light_volumes/sweep/gather_filter.wgsl", entry);
    let mut pass = graph.compute(name, shader);
    pass.flag("UNLIT", is_unlit(frame));
    frame.bind_view(&mut pass);
    // Not a constant of the pipeline: the radius shrinks while a view comes to rest.
    let reach = ReachUniform {
        radius: radius.max(1.0),
        weight: interleave.weight(),
        stray: if frame.history.is_changing() { STRAY } else { ANY },
        interleave: interleave.uniform(),
    };
    pass.uniform("reach", &reach);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    pass.read("diffuse", gathered.diffuse);
    pass.read("specular", gathered.specular);
    pass
}

/// Whether no surface that rays meet emits light.
fn is_unlit(frame: &Frame) -> bool {
    frame.rays.is_none_or(|rays| rays.emitter_count == 0)
}
