//! The cross bilateral filter over what was gathered, and the reflected radiance. See `indirect/light_volumes/sweep/gather_filter.wgsl`.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;

/// What the rays brought, rgba32float: what a white diffuse surface reflects, and what the specular lobe does.
#[derive(Clone, Copy)]
pub(super) struct Gathered {
    pub diffuse: Handle<Texture>,
    pub specular: Handle<Texture>,
}

/// Declares both passes; the result is reflected radiance. `radius` is that of the filter \[pixels\]; 0: none.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gathered: Gathered,
    radius: u32,
) -> Handle<Texture> {
    let indirect = graph.retained_texture("indirect radiance", frame.image_desc());
    let half = match radius {
        0 | 1 => gathered,
        _ => horizontal(graph, frame, gbuffer, gathered, radius),
    };
    let mut pass = graph.pass("gather filter, vertical");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth, half.diffuse, half.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let indirect = pass.write(indirect);
    pass.key(&(radius, frame.view_key()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let [base_color, normal, depth, diffuse, specular] = inputs.map(|handle| cx.view(handle));
        let target = cx.view(indirect);
        run(
            cx,
            &frame,
            radius,
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
    radius: u32,
) -> Gathered {
    let half = Gathered {
        diffuse: graph.texture("gathered diffuse, filtered along rows", frame.image_desc()),
        specular: graph.texture("gathered specular, filtered along rows", frame.image_desc()),
    };
    let mut pass = graph.pass("gather filter, horizontal");
    let inputs = [gbuffer.normal, gbuffer.depth, gathered.diffuse, gathered.specular];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    let half = Gathered { diffuse: pass.write(half.diffuse), specular: pass.write(half.specular) };
    pass.key(&(radius, frame.view_key()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let [normal, depth, diffuse, specular] = inputs.map(|handle| cx.view(handle));
        let [diffuse_out, specular_out] = [half.diffuse, half.specular].map(|handle| cx.view(handle));
        run(
            cx,
            &frame,
            radius,
            "horizontal",
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
    half
}

fn run(
    cx: &mut PassContext,
    frame: &Frame,
    radius: u32,
    entry: &'static str,
    bindings: &[(&str, Binding)],
) -> Result<(), PassError> {
    let [width, height] = frame.view.size;
    let view = frame.view_uniform(cx.gpu);
    // Not a constant of the pipeline: the radius shrinks while a view comes to rest.
    let reach = cx.gpu.uniform("reach", &(radius.max(1) as i32));
    let mut group = vec![("view", Binding::Buffer(&view)), ("reach", Binding::Buffer(&reach))];
    group.extend_from_slice(bindings);
    cx.counts().texels += u64::from(width) * u64::from(height);
    let key = ComputeKey::new("indirect/light_volumes/sweep/gather_filter.wgsl", entry);
    cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
}
