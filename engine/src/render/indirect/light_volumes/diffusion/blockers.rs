//! The geometry volume: blockers of transported radiance with their reflectance, from all that lights (and the camera) see.

use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, Step};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::texels;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use crate::world::Formulas;
use encase::ShaderType;
use wgpu::BufferUsages;

/// `CameraSamples` of `indirect/light_volumes/diffusion/blockers.wgsl`.
#[derive(ShaderType)]
pub(crate) struct CameraSamplesUniform {
    stride: u32,
    half_height: f32,
}

/// Most samples of the camera's view along an edge.
const CAMERA_SAMPLES: u32 = 128;

/// Where a cascade lies, and how it is filled.
#[derive(Clone, Copy)]
struct Grid {
    volume: Volume,
    formulas: Formulas,
}

impl Grid {
    fn shader(&self, entry: &'static str) -> ComputeKey {
        let printed = (self.formulas == Formulas::Printed).then_some(("PRINTED", ShaderDef::Flag(true)));
        ComputeKey {
            defs: printed.into_iter().collect(),
            ..ComputeKey::new("indirect/light_volumes/diffusion/blockers.wgsl", entry)
        }
    }

    /// A buffer of eight 32-bit numbers a corner.
    fn desc(&self) -> BufferDesc {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        BufferDesc::new(32 * u64::from(self.volume.corner_count()), usage)
    }
}

/// Declares the blockers of one cascade: every layer of an RSM is a view (a point light has up to six), and the
/// camera's G-buffer one more where given. Each view fills a volume of its own; these are merged in the scene's order
/// (Šefčík 2016, sections 5.2, 5.3.5 and 5.4).
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    rsms: &[Rsm<'a>],
    camera: Option<&GBuffer>,
    level: usize,
    volume: &Volume,
    formulas: Formulas,
) -> Handle<Buffer> {
    let grid = Grid { volume: *volume, formulas };
    let mut views = of_lights(graph, rsms, level, grid);
    views.extend(camera.map(|gbuffer| of_camera(graph, frame, gbuffer, level, grid)));
    merged(graph, views, level, grid)
}

/// Declares the injection of what the lights see; a volume a view.
fn of_lights<'a>(graph: &mut Graph<'a>, rsms: &[Rsm<'a>], level: usize, grid: Grid) -> Vec<Handle<Buffer>> {
    let name = format!("blockers of lights, cascade {level}");
    let count: usize = rsms.iter().map(|rsm| rsm.views.len()).sum();
    if count == 0 {
        return Vec::new();
    }
    let volumes: Vec<_> = (0..count).map(|view| graph.buffer(format!("{name}, view {view}"), grid.desc())).collect();
    let mut pass = graph.compute(name, grid.shader("from_rsm"));
    pass.uniform("volume", &grid.volume.uniform());
    let volumes: Vec<_> = volumes.into_iter().map(|volume| pass.write_in_steps(volume)).collect();
    let views = rsms.iter().flat_map(|rsm| (0..rsm.views.len()).map(move |layer| (rsm, layer)));
    for ((rsm, layer), &fixed) in views.zip(&volumes) {
        pass.clear(fixed);
        // The intensity is not bound: the blockers of a light that flickers stay as they are.
        let light = LightUniform::of_unit_intensity(rsm.light);
        let bind = |step: &mut Step<'_, '_, 'a>| step.read("fixed", fixed);
        texels::declare_steps(&mut pass, "from_rsm", (rsm, layer..layer + 1), (1.0, light), bind);
    }
    pass.finish();
    volumes
}

/// Pixels along an edge of a sample of the camera's view: the thesis halves its images until they are small enough.
fn camera_stride(size: [u32; 2], formulas: Formulas) -> u32 {
    let stride = size[0].max(size[1]).div_ceil(CAMERA_SAMPLES);
    if formulas == Formulas::Printed { stride.next_power_of_two() } else { stride }
}

/// Declares the injection of what the camera sees.
fn of_camera<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    level: usize,
    grid: Grid,
) -> Handle<Buffer> {
    let name = format!("blockers of the camera, cascade {level}");
    let volume = graph.buffer(name.as_str(), grid.desc());
    let stride = camera_stride(frame.view.size, grid.formulas);
    let samples = frame.view.size.map(|edge| edge.div_ceil(stride));
    let mut pass = graph.compute(name, grid.shader("from_camera"));
    pass.uniform("volume", &grid.volume.uniform());
    frame.bind_view(&mut pass);
    pass.uniform("camera", &CameraSamplesUniform { stride, half_height: frame.view.camera.half_height() });
    pass.read("camera_base_color", gbuffer.base_color);
    pass.read("camera_normal", gbuffer.normal);
    pass.read("camera_depth", gbuffer.depth);
    let volume = pass.write("fixed", volume);
    pass.clear(volume);
    pass.count(Counts { injections: u64::from(samples[0]) * u64::from(samples[1]), ..Counts::default() });
    pass.step("from_camera").over_uncounted(samples);
    pass.finish();
    volume
}

/// Declares the merging of all views.
fn merged(graph: &mut Graph, views: Vec<Handle<Buffer>>, level: usize, grid: Grid) -> Handle<Buffer> {
    let name = format!("blockers, cascade {level}");
    let merged = graph.retained_buffer(name.as_str(), grid.desc());
    let mut pass = graph.compute(name, grid.shader("merge"));
    pass.uniform("volume", &grid.volume.uniform());
    let merged = pass.write("merged", merged);
    pass.clear(merged);
    for &view in &views {
        let mut step = pass.step("merge");
        step.read("fixed", view);
        step.over_items(grid.volume.corner_count());
    }
    // The first view is no merge: it meets an empty volume.
    pass.count(Counts { merges: (views.len() as u64).saturating_sub(1), ..Counts::default() });
    // The thesis sets no limit.
    if grid.formulas != Formulas::Printed {
        pass.step("limit").over_items(grid.volume.corner_count());
    }
    pass.finish();
    merged
}
