//! Sharpening and grain of the display image: what is done last, to the values that the display shows. See
//! `post/film.wgsl`.

use super::tone_map::DISPLAY;
use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::world::Lens;
use encase::ShaderType;
use wgpu::{TextureFormat, TextureUsages};

/// `Film` of `post/film.wgsl`.
#[derive(Clone, Copy, ShaderType)]
pub(crate) struct FilmUniform {
    sharpening: f32,
    grain: f32,
    seed: u32,
}

/// Whether the lens asks for it.
pub(in crate::render) fn is_wanted(lens: &Lens) -> bool {
    lens.sharpening > 0.0 || lens.grain > 0.0
}

/// Declares the pass; the result is the display image, rgba8unorm, sRGB-encoded. Grain is another one at each moment.
pub(in crate::render) fn declare(
    graph: &mut Graph,
    lens: &Lens,
    moment: u64,
    image: Handle<Texture>,
    [width, height]: [u32; 2],
) -> Handle<Texture> {
    // Overlays are drawn into it.
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let display = graph.retained_texture(DISPLAY, TextureDesc::d2(width, height, TextureFormat::Rgba8Unorm, usage));
    let seed = if lens.grain > 0.0 { moment as u32 } else { 0 };
    let film = FilmUniform { sharpening: lens.sharpening, grain: lens.grain, seed };
    let mut pass = graph.compute("film", ComputeKey::new("post/film.wgsl", "main"));
    pass.uniform("film", &film);
    pass.read("image", image);
    let display = pass.write("display", display);
    pass.dispatch_over([width, height]);
    display
}
