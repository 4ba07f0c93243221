//! Irradiance from the swept volumes: at the surfels, for the next bounce, and at the visible surfaces.

use super::emit::Sources;
use super::{Irradiance, Level};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, PassBindings, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::diffusion::relight::CascadeUniform;
use crate::render::indirect::light_volumes::volume::Volume;
use encase::ShaderType;
use wgpu::BufferUsages;

/// `Lookup` of `indirect/light_volumes/sweep/irradiance.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct LookupUniform {
    cascade: CascadeUniform,
}

fn lookup(levels: &[Level], index: usize, fade_cells: f32) -> LookupUniform {
    LookupUniform { cascade: CascadeUniform::new(&levels[index].volume, fade_cells) }
}

/// How surfels look a cascade up: it fades along the box as it lies on the cells, so that their light changes only with
/// what is swept, and not with each step of the camera.
fn lookup_at_surfels(levels: &[Level], index: usize) -> LookupUniform {
    let volume = levels[index].volume;
    let bounds = volume.bounds();
    let snapped = Volume { fade_center: bounds.center(), fade_half: 0.5 * bounds.size(), ..volume };
    LookupUniform { cascade: CascadeUniform::new(&snapped, SURFEL_FADE) }
}

/// The shader for one of so many cascades, finest first.
pub(super) fn shader(entry: &'static str, index: usize, count: usize) -> ComputeKey {
    let mut key = ComputeKey::new("indirect/light_volumes/sweep/irradiance.wgsl", entry);
    if index == 0 {
        key = key.def("FIRST", ShaderDef::Flag(true));
    }
    if index + 1 == count {
        key = key.def("LAST", ShaderDef::Flag(true));
    }
    key
}

/// Width of the border between cascades at the surfels [cells].
const SURFEL_FADE: f32 = 2.0;

/// Declares the irradiance that the surfels receive in a bounce; the result is E [W/m²], a vector each. `white` is what they
/// have of light that is even everywhere; without it they are taken as they are.
pub(super) fn at_surfels<'a>(
    graph: &mut Graph<'a>,
    sources: &Sources<'_, 'a>,
    levels: &[Level],
    name: &str,
    white: Option<Handle<Buffer>>,
) -> Handle<Buffer> {
    let name = format!("receive, {name}");
    let surfels = sources.surfels;
    let count = sources.count;
    let received =
        graph.buffer(format!("{name}, irradiance"), BufferDesc::new(16 * u64::from(count), BufferUsages::STORAGE));
    let mut pass = graph.compute(name, shader("at_surfels", 0, levels.len()));
    pass.read("surfels", surfels);
    let received = pass.write("received", received);
    for (index, level) in levels.iter().enumerate() {
        let mut step = pass.step_of(shader("at_surfels", index, levels.len()));
        step.read("links", level.obstacles.links);
        look_up(&mut step, levels, index, level.bounce);
        // Once the light of all cascades is there.
        if let Some(white) = white.filter(|_| index + 1 == levels.len()) {
            step.flag("CALIBRATED", true);
            step.read("white", white);
        }
        step.over_items(count);
    }
    pass.finish();
    received
}

/// Binds a cascade with its light, which surfels look up.
pub(super) fn look_up(step: &mut PassBindings, levels: &[Level], index: usize, light: Irradiance) {
    step.uniform("lookup", &lookup_at_surfels(levels, index));
    step.read("axes", light.axes);
    step.read("facing", light.facing);
    step.read("opacity", levels[index].obstacles.opacity);
}

/// Names of the pass at the visible surfaces and of its image.
pub(super) struct Names {
    pub pass: &'static str,
    pub image: &'static str,
}

/// Declares the light of the visible surfaces; the result is reflected radiance. `fade` is the width of the border
/// between cascades \[cells\].
pub(super) fn relight<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    names: Names,
    fade: f32,
    levels: &[Level],
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture(names.image, desc);
    let pixels = u64::from(width) * u64::from(height);
    // One level needs no memory between levels.
    let between = if levels.len() > 1 { pixels } else { 1 };
    let partial =
        graph.buffer(format!("{}, between cascades", names.pass), BufferDesc::new(16 * between, BufferUsages::STORAGE));
    let mut pass = graph.compute(names.pass, shader("relight", 0, levels.len()));
    frame.bind_view(&mut pass);
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("depth", gbuffer.depth);
    let (indirect, _) = (pass.write("indirect", indirect), pass.write("partial", partial));
    pass.count(Counts { texels: pixels, ..Counts::default() });
    for (index, level) in levels.iter().enumerate() {
        let mut step = pass.step_of(shader("relight", index, levels.len()));
        let Irradiance { axes, facing } = level.light();
        step.uniform("lookup", &lookup(levels, index, fade));
        step.read("axes", axes);
        step.read("facing", facing);
        step.read("opacity", level.obstacles.opacity);
        step.over_uncounted([width, height]);
    }
    pass.finish();
    indirect
}
