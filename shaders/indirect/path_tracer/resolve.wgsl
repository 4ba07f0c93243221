// The mean of all samples so far, as an image of radiance.

struct Resolve {
    size: vec2u,           // [pixels]
    even: u32,             // number of even samples
    odd: u32,
    layer: u32,
}

const DIRECT: u32 = 1u;
const INDIRECT: u32 = 2u;

@group(0) @binding(0) var<uniform> params: Resolve;
@group(0) @binding(1) var<storage, read> sums: array<vec4f>;
@group(0) @binding(2) var radiance: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= params.size) {
        return;
    }
    let first = 4u * (thread.y * params.size.x + thread.x);
    let scale = 1.0 / f32(max(1u, params.even + params.odd));
    let direct = (sums[first].rgb + sums[first + 2u].rgb) * scale;
    let indirect = (sums[first + 1u].rgb + sums[first + 3u].rgb) * scale;
    var shown = direct + indirect;
    switch params.layer {
        case DIRECT: { shown = direct; }
        case INDIRECT: { shown = indirect; }
        default: {}
    }
    textureStore(radiance, thread.xy, vec4f(shown, 1.0));
}
