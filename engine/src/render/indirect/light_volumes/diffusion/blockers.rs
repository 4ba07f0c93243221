//! The geometry volume: blockers of transported radiance with their reflectance, from all that lights (and the camera) see.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
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

/// The two buffers of a cascade, where it lies, and how it is filled.
struct Grid {
    volume: Volume,
    formulas: Formulas,
    fixed: Handle<Buffer>,
    merged: Handle<Buffer>,
}

/// Declares the blockers of one cascade: every layer of an RSM is a view (a point light has up to six), and the
/// camera's G-buffer one more where given. The views are merged in the scene's order.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    rsms: &[Rsm<'a>],
    camera: Option<&GBuffer>,
    level: usize,
    volume: &Volume,
    formulas: Formulas,
) -> Handle<Buffer> {
    let name = format!("blockers, cascade {level}");
    // Eight 32-bit numbers a corner, in both buffers.
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = BufferDesc::new(32 * u64::from(volume.corner_count()), usage);
    let fixed = graph.buffer(format!("{name}, fixed point"), desc.clone());
    let merged = graph.retained_buffer(name.as_str(), desc);
    let mut pass = graph.pass(name.as_str());
    for rsm in rsms {
        pass.read(rsm.base_color);
        pass.read(rsm.normal);
        pass.read(rsm.depth);
    }
    if let Some(gbuffer) = camera {
        pass.read(gbuffer.base_color);
        pass.read(gbuffer.normal);
        pass.read(gbuffer.depth);
    }
    let grid = Grid { volume: *volume, formulas, fixed: pass.write(fixed), merged: pass.write(merged) };
    let merged = grid.merged;
    // What the lights see says it all; how bright they are does not matter here.
    pass.key(&(volume.key(), rsms.len(), camera.map(|_| frame.view_key()), formulas));
    let (rsms, camera, frame) = (rsms.to_vec(), camera.copied(), frame.clone());
    pass.execute(move |cx| {
        let target = cx.buffer(grid.merged).clone();
        cx.encoder().clear_buffer(&target, 0, None);
        for (rsm, layer) in rsms.iter().flat_map(|rsm| (0..rsm.views.len()).map(move |layer| (rsm, layer))) {
            from_rsm(cx, rsm, layer, &grid)?;
        }
        if let Some(gbuffer) = &camera {
            from_camera(cx, &frame, gbuffer, &grid)?;
        }
        // The first view is no merge: it meets an empty volume.
        let views = rsms.iter().map(|rsm| rsm.views.len() as u64).sum::<u64>() + u64::from(camera.is_some());
        cx.counts().merges += views.saturating_sub(1);
        // The thesis sets no limit.
        if formulas == Formulas::Corrected { limit(cx, &grid) } else { Ok(()) }
    });
    merged
}

impl Grid {
    fn shader(&self, entry: &'static str) -> ComputeKey {
        let printed = (self.formulas == Formulas::Printed).then_some(("PRINTED", ShaderDef::Flag(true)));
        ComputeKey {
            defs: printed.into_iter().collect(),
            ..ComputeKey::new("indirect/light_volumes/diffusion/blockers.wgsl", entry)
        }
    }
}

/// Pixels along an edge of a sample of the camera's view: the thesis halves its images until they are small enough.
fn camera_stride(size: [u32; 2], formulas: Formulas) -> u32 {
    let stride = size[0].max(size[1]).div_ceil(CAMERA_SAMPLES);
    if formulas == Formulas::Printed { stride.next_power_of_two() } else { stride }
}

fn from_rsm(cx: &mut PassContext, rsm: &Rsm, layer: usize, grid: &Grid) -> Result<(), PassError> {
    let fixed = cleared(cx, grid);
    dispatch_texels(cx, &grid.shader("from_rsm"), rsm, layer..layer + 1, &grid.volume, &fixed, 1.0)?;
    merge(cx, grid)
}

fn from_camera(cx: &mut PassContext, frame: &Frame, gbuffer: &GBuffer, grid: &Grid) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let fixed = cleared(cx, grid);
    let [width, height] = frame.view.size;
    let stride = camera_stride(frame.view.size, grid.formulas);
    let half_height = frame.view.camera.half_height();
    let samples = gpu.uniform("camera samples", &CameraSamplesUniform { stride, half_height });
    let volume = gpu.uniform("volume", &grid.volume.uniform());
    let (base_color, normal, depth) = (cx.view(gbuffer.base_color), cx.view(gbuffer.normal), cx.view(gbuffer.depth));
    let (columns, rows) = (width.div_ceil(stride), height.div_ceil(stride));
    cx.dispatch(
        &grid.shader("from_camera"),
        &[
            ("volume", Binding::Buffer(&volume)),
            ("view", Binding::Buffer(&frame.view_uniform(gpu))),
            ("camera", Binding::Buffer(&samples)),
            ("camera_base_color", Binding::Texture(&base_color)),
            ("camera_normal", Binding::Texture(&normal)),
            ("camera_depth", Binding::Texture(&depth)),
            ("fixed", Binding::Buffer(&fixed)),
        ],
        [columns.div_ceil(8), rows.div_ceil(8), 1],
    )?;
    cx.counts().injections += u64::from(columns) * u64::from(rows);
    merge(cx, grid)
}

fn cleared(cx: &mut PassContext, grid: &Grid) -> wgpu::Buffer {
    let fixed = cx.buffer(grid.fixed).clone();
    cx.encoder().clear_buffer(&fixed, 0, None);
    fixed
}

fn limit(cx: &mut PassContext, grid: &Grid) -> Result<(), PassError> {
    let volume = cx.gpu.uniform("volume", &grid.volume.uniform());
    let merged = cx.buffer(grid.merged).clone();
    cx.dispatch(
        &grid.shader("limit"),
        &[("volume", Binding::Buffer(&volume)), ("merged", Binding::Buffer(&merged))],
        linear_groups(grid.volume.corner_count()),
    )
}

fn merge(cx: &mut PassContext, grid: &Grid) -> Result<(), PassError> {
    let volume = cx.gpu.uniform("volume", &grid.volume.uniform());
    let (fixed, merged) = (cx.buffer(grid.fixed).clone(), cx.buffer(grid.merged).clone());
    cx.counts().cells += u64::from(grid.volume.corner_count());
    cx.dispatch(
        &grid.shader("merge"),
        &[
            ("volume", Binding::Buffer(&volume)),
            ("fixed", Binding::Buffer(&fixed)),
            ("merged", Binding::Buffer(&merged)),
        ],
        linear_groups(grid.volume.corner_count()),
    )
}
