// Two images in one: a wipe from one to the other, or their difference.

struct Compare {
    mode: u32,
    value: f32,            // WIPE: share of the width; DIFFERENCE: mean error of full colour [W/(m² sr)]
}

const WIPE: u32 = 0u;

@group(0) @binding(0) var<uniform> compare: Compare;
@group(0) @binding(1) var drawn: texture_2d<f32>;
@group(0) @binding(2) var traced: texture_2d<f32>;
@group(0) @binding(3) var both: texture_storage_2d<rgba32float, write>;

// The colours of `measure::difference_picture`: red where the drawn image is too bright, blue where it is too dark;
// strength is the mean absolute error of the three channels.
fn difference_color(a: vec3f, r: vec3f) -> vec3f {
    let error = a - r;
    let strength = min(dot(abs(error), vec3f(1.0 / 3.0)) / compare.value, 1.0);
    let soft = strength * strength;
    if error.r + error.g + error.b < 0.0 {
        return vec3f(0.1 * soft, 0.4 * soft, strength);
    }
    return vec3f(strength, 0.3 * soft, 0.05 * soft);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let size = textureDimensions(drawn);
    if any(thread.xy >= size) {
        return;
    }
    let a = textureLoad(drawn, thread.xy, 0).rgb;
    let r = textureLoad(traced, thread.xy, 0).rgb;
    var shown = difference_color(a, r);
    if compare.mode == WIPE {
        shown = select(r, a, (f32(thread.x) + 0.5) < compare.value * f32(size.x));
    }
    textureStore(both, thread.xy, vec4f(shown, 1.0));
}
