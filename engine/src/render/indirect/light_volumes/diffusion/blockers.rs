//! The geometry volume: blockers of transported radiance with their reflectance, from all that lights (and the camera) see.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::texels::dispatch_texels;
use crate::render::indirect::light_volumes::volume::Volume;
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
    let mut pass = graph.pass(name);
    for rsm in rsms {
        [rsm.base_color, rsm.normal, rsm.depth].into_iter().for_each(|input| pass.read(input));
    }
    let volumes: Vec<_> = volumes.into_iter().map(|volume| pass.write(volume)).collect();
    // What the lights see says it all; how bright they are does not matter here.
    pass.key(&(grid.volume.key(), rsms.len(), grid.formulas));
    let (rsms, targets) = (rsms.to_vec(), volumes.clone());
    pass.execute(move |cx| {
        let views = rsms.iter().flat_map(|rsm| (0..rsm.views.len()).map(move |layer| (rsm, layer)));
        views.zip(&targets).try_for_each(|((rsm, layer), &target)| {
            let fixed = cleared(cx, target);
            dispatch_texels(cx, &grid.shader("from_rsm"), rsm, layer..layer + 1, &grid.volume, &fixed, 1.0)
        })
    });
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
    let mut pass = graph.pass(name);
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.depth];
    inputs.into_iter().for_each(|input| pass.read(input));
    let volume = pass.write(volume);
    pass.key(&(grid.volume.key(), frame.view_key(), grid.formulas));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let fixed = cleared(cx, volume);
        let [width, height] = frame.view.size;
        let stride = camera_stride(frame.view.size, grid.formulas);
        let half_height = frame.view.camera.half_height();
        let samples = gpu.uniform("camera samples", &CameraSamplesUniform { stride, half_height });
        let uniform = gpu.uniform("volume", &grid.volume.uniform());
        let [base_color, normal, depth] = inputs.map(|input| cx.view(input));
        let (columns, rows) = (width.div_ceil(stride), height.div_ceil(stride));
        cx.counts().injections += u64::from(columns) * u64::from(rows);
        cx.dispatch(
            &grid.shader("from_camera"),
            &[
                ("volume", Binding::Buffer(&uniform)),
                ("view", Binding::Buffer(&frame.view_uniform(gpu))),
                ("camera", Binding::Buffer(&samples)),
                ("camera_base_color", Binding::Texture(&base_color)),
                ("camera_normal", Binding::Texture(&normal)),
                ("camera_depth", Binding::Texture(&depth)),
                ("fixed", Binding::Buffer(&fixed)),
            ],
            [columns.div_ceil(8), rows.div_ceil(8), 1],
        )
    });
    volume
}

/// Declares the merging of all views.
fn merged(graph: &mut Graph, views: Vec<Handle<Buffer>>, level: usize, grid: Grid) -> Handle<Buffer> {
    let name = format!("blockers, cascade {level}");
    let merged = graph.retained_buffer(name.as_str(), grid.desc());
    let mut pass = graph.pass(name);
    views.iter().for_each(|&view| pass.read(view));
    let merged = pass.write(merged);
    pass.key(&(grid.volume.key(), views.len(), grid.formulas));
    pass.execute(move |cx| {
        let target = cx.buffer(merged).clone();
        cx.encoder().clear_buffer(&target, 0, None);
        let volume = cx.gpu.uniform("volume", &grid.volume.uniform());
        let groups = linear_groups(grid.volume.corner_count());
        for &view in &views {
            let fixed = cx.buffer(view).clone();
            cx.dispatch(
                &grid.shader("merge"),
                &[
                    ("volume", Binding::Buffer(&volume)),
                    ("fixed", Binding::Buffer(&fixed)),
                    ("merged", Binding::Buffer(&target)),
                ],
                groups,
            )?;
        }
        // The first view is no merge: it meets an empty volume.
        cx.counts().merges += (views.len() as u64).saturating_sub(1);
        if grid.formulas == Formulas::Printed {
            // The thesis sets no limit.
            return Ok(());
        }
        let bindings = [("volume", Binding::Buffer(&volume)), ("merged", Binding::Buffer(&target))];
        cx.dispatch(&grid.shader("limit"), &bindings, groups)
    });
    merged
}

fn cleared(cx: &mut PassContext, volume: Handle<Buffer>) -> wgpu::Buffer {
    let fixed = cx.buffer(volume).clone();
    cx.encoder().clear_buffer(&fixed, 0, None);
    fixed
}
