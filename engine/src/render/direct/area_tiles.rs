//! Tiles of the image that lie wholly in the light or wholly in the shadow of a light with a surface. See
//! `direct/area_tiles.wgsl`.

use super::{DirectLight, Region};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, Texture};
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::UVec2;

/// Edge of a tile \[pixels\], as in `lib/shadow_tiles.wgsl`.
const TILE: u32 = 8;

/// `Tiles` of `direct/area_tiles.wgsl`.
#[derive(ShaderType)]
pub(crate) struct TilesUniform {
    origin: UVec2,
    size: UVec2,
    image: UVec2,
}

/// Declares the pass that looks at the first shadow rays of a light.
pub(super) fn declare(
    graph: &mut Graph,
    frame: &Frame,
    samples: Handle<Texture>,
    direct_light: &DirectLight,
    name: &str,
) -> Handle<Buffer> {
    let image = UVec2::from(frame.view.size);
    let tiles = image.map(|edge| edge.div_ceil(TILE));
    let bytes = u64::from(tiles.x) * u64::from(tiles.y) * 4;
    let buffer = graph.retained_buffer(name, BufferDesc::new(bytes, wgpu::BufferUsages::STORAGE));
    let Region { origin, size } = direct_light.region;
    let seen = (origin + size - 1) / TILE - origin / TILE + 1;
    let mut pass = graph.compute(name, ComputeKey::new("direct/area_tiles.wgsl", "main"));
    pass.uniform("region", &TilesUniform { origin, size, image });
    pass.read("samples", samples);
    let buffer = pass.write("tiles", buffer);
    pass.count(Counts { texels: u64::from(size.x) * u64::from(size.y), ..Counts::default() });
    pass.dispatch_items(seen.element_product());
    buffer
}
