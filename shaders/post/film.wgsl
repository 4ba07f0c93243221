// Sharpening and grain, on the values that the display shows.

#import lightwell::color::luminance
#import lightwell::sampling::{hash, hash_pair}

struct Film {
    sharpening: f32,       // 0..1
    grain: f32,            // standard deviation at middle brightness, of the display's range
    seed: u32,
}

@group(0) @binding(0) var<uniform> film: Film;
@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var display: texture_storage_2d<rgba8unorm, write>;

fn load(pixel: vec2i) -> vec3f {
    return textureLoad(image, clamp(pixel, vec2i(0), vec2i(textureDimensions(image)) - 1), 0).rgb;
}

// An unsharp mask that stays in the range of the pixel and its four neighbours: edges become steeper, and get no halo.
fn sharpened(pixel: vec2i) -> vec3f {
    let center = load(pixel);
    let left = load(pixel + vec2i(-1, 0));
    let right = load(pixel + vec2i(1, 0));
    let above = load(pixel + vec2i(0, -1));
    let below = load(pixel + vec2i(0, 1));
    let lowest = min(center, min(min(left, right), min(above, below)));
    let highest = max(center, max(max(left, right), max(above, below)));
    let blurred = 0.25 * (left + right + above + below);
    return clamp(center + film.sharpening * (center - blurred), lowest, highest);
}

// About normal, of mean 0 and deviation 1: the sum of the four bytes of a hash.
fn noise(pixel: vec2u) -> f32 {
    let bits = hash_pair(pixel.x, hash_pair(pixel.y, film.seed));
    let bytes = vec4f(vec4u(bits, bits >> 8u, bits >> 16u, bits >> 24u) & vec4u(255u));
    // A byte has the variance (256² − 1)/12.
    return (dot(bytes, vec4f(1.0)) - 510.0) / 147.8;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(display)) {
        return;
    }
    let color = sharpened(vec2i(thread.xy));
    // Film has most grain at middle brightness, and none where it is clear or black.
    let level = saturate(luminance(color));
    let grain = film.grain * 4.0 * level * (1.0 - level) * noise(thread.xy);
    textureStore(display, thread.xy, vec4f(saturate(color + grain), 1.0));
}
