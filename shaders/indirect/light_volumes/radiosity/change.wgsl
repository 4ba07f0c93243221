// How the light of each patch changed since the frame before. The mean over frames takes that for how the light of all
// points of the patch changed, which lets frames count that were drawn in other light.
//
// Light of patches is a sum over few links, and what changes is that some of them begin or cease to see a lit surface: patches
// around one are looked at together, as far as the filter of the gather reaches or so.
//   KNOWN  there is a frame before

#ifdef KNOWN
#import lightwell::patches::{NO_PATCH, patch_of_object}
#import lightwell::sampling::basis
#import lightwell::sweep::{Surfel, INDEX}
#endif

// Irradiance of patches [W/m²], now and in the frame before.
@group(0) @binding(0) var<storage, read> patch_light: array<vec4f>;
@group(0) @binding(1) var<storage, read> light_before: array<vec4f>;
// A copy of it for the next frame.
@group(0) @binding(2) var<storage, read_write> light_now: array<vec4f>;
// Light over that of before by channel, and how much frames before still count: 1 where nothing changed.
@group(0) @binding(3) var<storage, read_write> patch_change: array<vec4f>;
#ifdef KNOWN
// First surfel and number of surfels of a patch.
@group(0) @binding(4) var<storage, read> patches: array<vec2u>;
@group(0) @binding(5) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(6) var<uniform> spacing: f32;    // edge of a patch [m]

// Most that light may grow in a frame before what was known of it counts for nothing.
const MOST: f32 = 16.0;
// Patches to each side that are looked at, and the standard deviation of their weights.
const REACH: i32 = 2;
const WIDTH: f32 = 1.3;

struct Both {
    now: vec3f,
    before: vec3f,
}

// The mean light around a patch.
fn around(index: u32) -> Both {
    let range = patches[index];
    let surfel = surfels[range.x + range.y / 2u];
    let tangents = basis(surfel.normal);
    var sum = Both(vec3f(0.0), vec3f(0.0));
    for (var i = -REACH; i <= REACH; i++) {
        for (var k = -REACH; k <= REACH; k++) {
            let position = surfel.position + spacing * (f32(i) * tangents[0] + f32(k) * tangents[1]);
            var beside = patch_of_object(surfel.place & INDEX, position, surfel.normal);
            if i == 0 && k == 0 {
                beside = index;
            }
            if beside != NO_PATCH {
                let weight = exp(-f32(i * i + k * k) / (2.0 * WIDTH * WIDTH));
                sum.now += weight * patch_light[beside].rgb;
                sum.before += weight * light_before[beside].rgb;
            }
        }
    }
    return sum;
}

fn change(light: Both) -> vec4f {
    let both = light.now + light.before;
    let all = both.r + both.g + both.b;
    if !(all > 0.0) {
        return vec4f(1.0);
    }
    // A channel of next to nothing is as good as none.
    let least = vec3f(1e-4 * all);
    let ratio = min((light.now + least) / (light.before + least), vec3f(MOST));
    // Where there is more or less light it also comes from elsewhere.
    let difference = abs(light.now - light.before);
    return vec4f(ratio, 1.0 - min(1.0, 2.0 * (difference.r + difference.g + difference.b) / all));
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&patch_light) {
        return;
    }
#ifdef KNOWN
    patch_change[index] = change(around(index));
#else
    patch_change[index] = vec4f(1.0);
#endif
    light_now[index] = patch_light[index];
}
