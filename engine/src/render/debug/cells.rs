//! The cells of a light volume: light and blockers by direction as spheres, and voxels in the colour of their surfaces.

use super::overlay::{self, DEPTH};
use super::{DebugView, skip};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Contents, Counts, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::{Volume, VolumeUniform};
use encase::ShaderType;
use wgpu::{BufferUsages, TextureUsages};

/// `Cells` of `debug/cells.wgsl`.
#[derive(Clone, Copy, ShaderType)]
pub(crate) struct CellsUniform {
    volume: VolumeUniform,
    content: u32,
    scale: f32,
    pad_a: u32,
    pad_b: u32,
}

/// The kind of values in a buffer: the constants of `debug/cells.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    LightHarmonics = 0,
    LightAxes = 1,
    Blockers = 2,
    Opacity = 3,
    VoxelsOfBlockers = 4,
    VoxelsOfSurfels = 5,
}

impl Content {
    fn is_voxels(self) -> bool {
        matches!(self, Self::VoxelsOfBlockers | Self::VoxelsOfSurfels)
    }

    fn is_on_corners(self) -> bool {
        matches!(self, Self::Blockers | Self::VoxelsOfBlockers)
    }
}

/// Declares the pass; the result is the display image with the cells.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    view: DebugView,
    volumes: &[Volume],
    display: Handle<Texture>,
) -> Handle<Texture> {
    let level = (frame.settings.debug.cascade as usize).min(volumes.len().saturating_sub(1));
    let found = volumes.get(level).and_then(|volume| Some((volume, find(graph, view, level)?)));
    let Some((volume, (content, buffer))) = found else {
        return skip(graph, view, "the method of indirect light fills no such volume", display);
    };
    let uniform = CellsUniform {
        volume: volume.uniform(),
        content: content as u32,
        scale: frame.settings.exposure_factor(&frame.view.camera.lens),
        pad_a: 0,
        pad_b: 0,
    };
    let buffer = match content {
        Content::VoxelsOfSurfels => declare_sums(graph, (buffer, frame.surfels.count()), volume, uniform),
        _ => buffer,
    };
    let [width, height] = frame.view.size;
    let name = format!("debug {view}");
    let own = TextureDesc::d2(width, height, DEPTH, TextureUsages::RENDER_ATTACHMENT);
    let own = graph.texture(format!("{name}, depth"), own);
    let instances = if content.is_on_corners() { volume.corner_count() } else { volume.cell_count() };
    let mut pass = graph.raster(name);
    let display = pass.color(display, Contents::Kept);
    let _ = pass.depth(own, Contents::Cleared);
    frame.bind_view(&mut pass);
    pass.uniform("cells", &uniform);
    pass.read("data", buffer);
    pass.read("depth", gbuffer.depth);
    let vertices = if content.is_voxels() { 36 } else { 6 };
    pass.step().draw(overlay::pipeline("debug/cells.wgsl", true), [vertices, instances]);
    pass.finish();
    display
}

/// The buffer of the frame that holds what the view shows.
fn find(graph: &Graph, view: DebugView, level: usize) -> Option<(Content, Handle<Buffer>)> {
    let buffer = |content: Content, name: &str| Some((content, graph.latest::<Buffer>(name)?));
    let blockers = format!("blockers, cascade {level}");
    match view {
        DebugView::Light => buffer(Content::LightHarmonics, &format!("propagate, cascade {level}"))
            .or_else(|| buffer(Content::LightAxes, &format!("axes, cascade {level}"))),
        DebugView::Blockers => buffer(Content::Blockers, &blockers)
            .or_else(|| buffer(Content::Opacity, &format!("opacity, cascade {level}"))),
        DebugView::Voxels => {
            buffer(Content::VoxelsOfBlockers, &blockers).or_else(|| buffer(Content::VoxelsOfSurfels, "surfels"))
        }
        _ => None,
    }
}

/// Declares the sums of the surfels in each cell.
fn declare_sums(
    graph: &mut Graph,
    (surfels, count): (Handle<Buffer>, u32),
    volume: &Volume,
    uniform: CellsUniform,
) -> Handle<Buffer> {
    let bytes = 16 * u64::from(volume.cell_count());
    let sums = graph.buffer("voxels", BufferDesc::new(bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST));
    let mut pass = graph.compute("voxels", ComputeKey::new("debug/cells.wgsl", "scatter"));
    let sums = pass.write_in_steps(sums);
    pass.clear(sums);
    pass.count(Counts { injections: count.into(), ..Counts::default() });
    let mut step = pass.step("scatter");
    step.uniform("cells", &uniform);
    step.read("surfels", surfels);
    step.read("sums", sums);
    step.over_items(count);
    pass.finish();
    sums
}
