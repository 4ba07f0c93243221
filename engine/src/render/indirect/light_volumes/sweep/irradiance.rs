//! Irradiance from the swept volumes: at the surfels, for the next bounce, and at the visible surfaces.

use super::emit::Sources;
use super::opacity::Obstacles;
use super::{Irradiance, Level};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
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
pub(super) fn lookup_at_surfels(levels: &[Level], index: usize) -> LookupUniform {
    let volume = levels[index].volume;
    let bounds = volume.bounds();
    let snapped = Volume { fade_center: bounds.center(), fade_half: 0.5 * bounds.size(), ..volume };
    LookupUniform { cascade: CascadeUniform::new(&snapped, SURFEL_FADE) }
}

/// The shader for one of so many cascades, finest first.
fn shader(entry: &'static str, index: usize, count: usize) -> ComputeKey {
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
    let mut pass = graph.pass(name);
    pass.read(surfels);
    white.into_iter().for_each(|white| pass.read(white));
    let light: Vec<Irradiance> = levels.iter().map(|level| level.bounce).collect();
    for Irradiance { axes, facing } in &light {
        pass.read(*axes);
        pass.read(*facing);
    }
    let obstacles: Vec<_> = levels.iter().map(|level| level.obstacles).collect();
    for Obstacles { opacity, links, .. } in &obstacles {
        pass.read(*opacity);
        pass.read(*links);
    }
    let received = pass.write(received);
    let keys: Vec<_> = levels.iter().map(|level| level.volume.key()).collect();
    pass.key(&keys);
    let lookups: Vec<_> = (0..levels.len()).map(|i| lookup_at_surfels(levels, i)).collect();
    pass.execute(move |cx| {
        let [surfels, target] = [surfels, received].map(|handle| cx.buffer(handle).clone());
        for index in 0..lookups.len() {
            let links = cx.buffer(obstacles[index].links).clone();
            let opacity = obstacles[index].opacity;
            let at = Lookup { lookups: &lookups, index, light: light[index], opacity, white };
            look_up(cx, at, [&surfels, &links, &target], count)?;
        }
        Ok(())
    });
    received
}

/// A cascade to look light up in.
pub(super) struct Lookup<'l> {
    /// Of all cascades.
    pub lookups: &'l [LookupUniform],
    /// Which one it is, the finest is 0.
    pub index: usize,
    /// Its light.
    pub light: Irradiance,
    /// Opacity of its cells.
    pub opacity: Handle<Buffer>,
    /// Irradiance of the surfels in light that is even everywhere, where theirs is compared with it.
    pub white: Option<Handle<Buffer>>,
}

/// Looks up the light of a cascade at surfels, by their links to it, and adds it to what each receives.
pub(super) fn look_up(
    cx: &mut PassContext,
    Lookup { lookups, index, light, opacity, white }: Lookup<'_>,
    [surfels, links, received]: [&wgpu::Buffer; 3],
    count: u32,
) -> Result<(), PassError> {
    let lookup = cx.gpu.uniform("lookup", &lookups[index]);
    let [axes, facing, opacity] = [light.axes, light.facing, opacity].map(|handle| cx.buffer(handle).clone());
    let mut key = shader("at_surfels", index, lookups.len());
    let mut bindings = vec![
        ("lookup", Binding::Buffer(&lookup)),
        ("axes", Binding::Buffer(&axes)),
        ("facing", Binding::Buffer(&facing)),
        ("opacity", Binding::Buffer(&opacity)),
        ("surfels", Binding::Buffer(surfels)),
        ("links", Binding::Buffer(links)),
        ("received", Binding::Buffer(received)),
    ];
    // Once the light of all cascades is there.
    let white = white.filter(|_| index + 1 == lookups.len()).map(|handle| cx.buffer(handle).clone());
    if let Some(white) = &white {
        key = key.def("CALIBRATED", ShaderDef::Flag(true));
        bindings.push(("white", Binding::Buffer(white)));
    }
    cx.dispatch(&key, &bindings, linear_groups(count))
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
    let mut pass = graph.pass(names.pass);
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth];
    for input in inputs {
        pass.read(input);
    }
    let light: Vec<Irradiance> = levels.iter().map(Level::light).collect();
    for Irradiance { axes, facing } in &light {
        pass.read(*axes);
        pass.read(*facing);
    }
    let opacities: Vec<_> = levels.iter().map(|level| level.obstacles.opacity).collect();
    for opacity in &opacities {
        pass.read(*opacity);
    }
    let (indirect, partial) = (pass.write(indirect), pass.write(partial));
    let keys: Vec<_> = levels.iter().map(|level| (level.volume.key(), level.volume.fade_key())).collect();
    pass.key(&(keys, fade.to_bits(), frame.view_key()));
    let lookups: Vec<_> = (0..levels.len()).map(|i| lookup(levels, i, fade)).collect();
    let frame = frame.clone();
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let [base_color, normal, depth] = inputs.map(|handle| cx.view(handle));
        let (target, partial) = (cx.view(indirect), cx.buffer(partial).clone());
        cx.counts().texels += pixels;
        for (index, ((lookup, light), opacity)) in lookups.iter().zip(&light).zip(&opacities).enumerate() {
            let opacity = cx.buffer(*opacity).clone();
            let lookup = gpu.uniform("lookup", lookup);
            let [axes, facing] = [light.axes, light.facing].map(|handle| cx.buffer(handle).clone());
            cx.dispatch(
                &shader("relight", index, lookups.len()),
                &[
                    ("lookup", Binding::Buffer(&lookup)),
                    ("axes", Binding::Buffer(&axes)),
                    ("facing", Binding::Buffer(&facing)),
                    ("opacity", Binding::Buffer(&opacity)),
                    ("view", Binding::Buffer(&frame.view_uniform(gpu))),
                    ("base_color", Binding::Texture(&base_color)),
                    ("normal", Binding::Texture(&normal)),
                    ("depth", Binding::Texture(&depth)),
                    ("partial", Binding::Buffer(&partial)),
                    ("indirect", Binding::Texture(&target)),
                ],
                [width.div_ceil(8), height.div_ceil(8), 1],
            )?;
        }
        Ok(())
    });
    indirect
}
