//! Tiles of the image that lie wholly in the light or wholly in the shadow of a light with a surface. See
//! `direct/area_tiles.wgsl`.

use super::{DirectLight, Region};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::UVec2;

/// Edge of a tile \[pixels\], as in `lib/shadow_tiles.wgsl`.
const TILE: u32 = 8;
/// Tiles of a workgroup.
const WORKGROUP: u32 = 64;

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
    let mut pass = graph.pass(name);
    pass.read(samples);
    let buffer = pass.write(buffer);
    let Region { origin, size } = direct_light.region;
    pass.key(&(origin.to_array(), size.to_array(), image.to_array()));
    pass.execute(move |cx| {
        cx.counts().texels += u64::from(size.x) * u64::from(size.y);
        let region = cx.gpu.uniform("tiles", &TilesUniform { origin, size, image });
        let (samples, tiles) = (cx.view(samples), cx.buffer(buffer).clone());
        let group = [
            ("region", Binding::Buffer(&region)),
            ("samples", Binding::Texture(&samples)),
            ("tiles", Binding::Buffer(&tiles)),
        ];
        let seen = (origin + size - 1) / TILE - origin / TILE + 1;
        let groups = [(seen.x * seen.y).div_ceil(WORKGROUP), 1, 1];
        cx.dispatch(&ComputeKey::new("direct/area_tiles.wgsl", "main"), &group, groups)
    });
    buffer
}
