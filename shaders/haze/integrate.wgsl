// What is scattered towards the eye up to each slice: S = Σ T·(1 − exp(−τ))·J over the slices before, with the light J that a
// slice scatters over its density, its optical depth τ, and the share T of light that passes from it to the eye.

#import lightwell::haze::{Haze, SLICES, haze_index, sight_through, slice_distance}
#import lightwell::media::{FARTHEST, optical_depth}
#import lightwell::view::View

@group(0) @binding(41) var<uniform> view: View;
@group(0) @binding(39) var<uniform> haze: Haze;
// Light, and optical depth.
@group(0) @binding(42) var<storage, read> scattered: array<vec4f>;
@group(0) @binding(43) var<storage, read_write> in_scattered: array<vec4f>;

// Light of a slice and those beside it, which is looked up at four depths: a tent over nine of them weighs all four alike. The
// optical depth is the column's own, so that the borders of media stay sharp.
fn light_of(column: vec2u, slice: u32) -> vec4f {
    var sum = vec3f(0.0);
    var weights = 0.0;
    let last = vec2i(haze.columns) - 1;
    for (var i = 0; i < 9; i++) {
        let offset = vec2i(i % 3, i / 3) - 1;
        let beside = vec2u(clamp(vec2i(column) + offset, vec2i(0), last));
        let here = scattered[haze_index(haze, beside, slice)];
        let weight = here.w / f32((1 + abs(offset.x)) * (1 + abs(offset.y)));
        sum += weight * here.rgb;
        weights += weight;
    }
    return vec4f(sum / max(weights, 1e-30), scattered[haze_index(haze, column, slice)].w);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= haze.columns.x * haze.columns.y {
        return;
    }
    let column = vec2u(index % haze.columns.x, index / haze.columns.x);
    var sum = vec3f(0.0);
    var depth = 0.0;
    var last = vec3f(0.0);
    for (var slice = 0u; slice < SLICES; slice++) {
        let at = haze_index(haze, column, slice);
        in_scattered[at] = vec4f(sum, 0.0);
        let here = light_of(column, slice);
        sum += exp(-depth) * (1.0 - exp(-here.w)) * here.rgb;
        depth += here.w;
        last = here.rgb;
    }
    in_scattered[haze_index(haze, column, SLICES)] = vec4f(sum, 0.0);
    // Beyond the last slice light is as it is there.
    let sight = sight_through(view, (vec2f(column) + 0.5 + haze.shift) * haze.tile);
    let end = slice_distance(haze, f32(SLICES));
    let rest = optical_depth(sight.origin + sight.direction * end, sight.direction, FARTHEST);
    sum += exp(-depth) * (1.0 - exp(-rest)) * last;
    in_scattered[haze_index(haze, column, SLICES + 1u)] = vec4f(sum, 0.0);
}
