//! Bloom: light that scatters in the lens, as a halo around all that is bright. A share of the light of each pixel is spread
//! over those around it and none is lost, so that the sum over the image stays: there is no threshold, and twice the light
//! has twice the halo.
//!
//! The halo is the mean of a pyramid's levels (Burt and Adelson 1983), each twice as wide as the one before and of the same
//! energy. Its radiance falls with about the square of the distance, as measured of the eye's glare (Spencer et al. 1995)
//! and of lenses. See `post/bloom.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::world::Bloom;
use encase::ShaderType;
use wgpu::{TextureFormat, TextureUsages};

/// Name of the retained image of radiance with bloom.
pub const BLOOMED: &str = "radiance with bloom";
/// Levels at most: the widest halo covers any image.
const MOST_LEVELS: u32 = 14;

/// `Bloom` of `post/bloom.wgsl`.
#[derive(ShaderType)]
pub(crate) struct BloomUniform {
    share: f32,
}

/// Declares the passes; the result is the radiance with the light that scatters, rgba32float.
pub(in crate::render) fn declare(
    graph: &mut Graph,
    bloom: &Bloom,
    radiance: Handle<Texture>,
    size: [u32; 2],
) -> Handle<Texture> {
    let levels = levels(bloom, size[1]);
    let mut down = vec![(radiance, size)];
    for level in 1..=levels {
        let (finer, size) = down[level as usize - 1];
        let size = size.map(|edge| edge.div_ceil(2));
        let image = graph.texture(format!("bloom level {level}"), desc(size));
        down.push((declare_down(graph, level, finer, image, size), size));
    }
    let mut wider = down[levels as usize].0;
    for level in (1..levels).rev() {
        let (image, size) = down[level as usize];
        // Of the levels from this one on each counts alike.
        let share = (levels - level) as f32 / (levels - level + 1) as f32;
        let sum = graph.texture(format!("bloom levels from {level}"), desc(size));
        wider = declare_up(graph, &format!("bloom up {level}"), share, [image, wider], sum, size);
    }
    let bloomed = graph.retained_texture(BLOOMED, desc(size));
    declare_up(graph, "bloom", bloom.scatter, [radiance, wider], bloomed, size)
}

/// So many that a texel of the last one is as wide as the widest halo's radius.
fn levels(bloom: &Bloom, height: u32) -> u32 {
    let pixels = (bloom.radius * height as f32).max(2.0);
    (pixels.log2().round() as u32).clamp(1, MOST_LEVELS)
}

fn desc([width, height]: [u32; 2]) -> TextureDesc {
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
    TextureDesc::d2(width, height, TextureFormat::Rgba32Float, usage)
}

fn declare_down(
    graph: &mut Graph,
    level: u32,
    finer: Handle<Texture>,
    image: Handle<Texture>,
    size: [u32; 2],
) -> Handle<Texture> {
    let mut pass = graph.compute(format!("bloom down {level}"), ComputeKey::new("post/bloom.wgsl", "down_main"));
    pass.read("finer", finer);
    let image = pass.write("result", image);
    pass.dispatch_over(size);
    image
}

/// Mixes an image with a share of a wider one.
fn declare_up(
    graph: &mut Graph,
    name: &str,
    share: f32,
    [image, wider]: [Handle<Texture>; 2],
    result: Handle<Texture>,
    size: [u32; 2],
) -> Handle<Texture> {
    let mut pass = graph.compute(name, ComputeKey::new("post/bloom.wgsl", "up_main"));
    pass.uniform("bloom", &BloomUniform { share });
    pass.read("finer", image);
    pass.read("wider", wider);
    let result = pass.write("result", result);
    pass.dispatch_over(size);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_halo_is_as_wide_at_any_size() {
        let of = |radius, height| levels(&Bloom { radius, ..Bloom::default() }, height);
        assert_eq!([of(0.25, 512), of(0.25, 1024), of(0.25, 2048)], [7, 8, 9]);
        assert_eq!([of(0.001, 512), of(1.0, 16_384), of(1.0, 1)], [1, 14, 1]);
    }
}
