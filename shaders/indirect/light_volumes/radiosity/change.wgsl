// How the light of each patch changed since the frame before. The mean over frames takes that for how the light of all
// points of the patch changed, which lets frames count that were drawn in other light.
//
// Light of patches is a sum over few links, and what changes is that some of them begin or cease to see a lit surface: patches
// around one are looked at together, as far as the filter of the gather reaches or so. Their change is the ratio q = Σwn/Σwb of
// light now and before, with the standard error √(Σw²(n − q·b)²)/Σwb (Cochran 1977, "Sampling Techniques", section 6.4): where
// they do not agree it is chance, and is not followed. What is not followed is kept, and fades as the mean over frames takes up
// what pixels see: light that changes a little in each frame is followed too.
//   KNOWN  there is a frame before

#ifdef KNOWN
#import lightwell::color::luminance
#import lightwell::patches::{NO_PATCH, patch_of_object}
#import lightwell::sampling::basis
#import lightwell::sweep::{Surfel, INDEX}
#endif

// A patch in a frame.
struct PatchHistory {
    light: vec4f,          // irradiance [W/m²]
    pending: vec4f,        // change by channel that was not followed so far: a factor
}

// Irradiance of patches [W/m²].
@group(0) @binding(0) var<storage, read> patch_light: array<vec4f>;
@group(0) @binding(1) var<storage, read> history_before: array<PatchHistory>;
// For the next frame.
@group(0) @binding(2) var<storage, read_write> history_now: array<PatchHistory>;
// Light over that of before by channel, and the relative variance of how the light of single points changed beside that: 1 and 0
// where nothing changed.
@group(0) @binding(3) var<storage, read_write> patch_change: array<vec4f>;
#ifdef KNOWN
// First surfel and number of surfels of a patch.
@group(0) @binding(4) var<storage, read> patches: array<vec2u>;
@group(0) @binding(5) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(6) var<uniform> spacing: f32;    // edge of a patch [m]

// Most that light may grow in a frame before what was known of it counts for nothing.
const MOST: f32 = 16.0;
// Patches to each side that are looked at, the standard deviation of their weights, and most of them.
const REACH: i32 = 2;
const WIDTH: f32 = 1.3;
const MOST_AROUND: u32 = 25u;
// Standard errors up to which a change is chance, and from which on it is none.
const CHANCE: f32 = 1.0;
const CERTAIN: f32 = 2.0;
// Deviation of a single patch's light by chance, over that light. The more patches there are, the less it is asked.
const DEVIATION: f32 = 0.5;
// Of a change, how much that of single points may differ from it: where there is more or less light it also comes from elsewhere.
const WITHIN: f32 = 0.5;
// How much of a change that was not followed is left after a frame.
const KEPT: f32 = 0.98;
// Luminances that are squared, over that of the patch.
const BRIGHTEST: f32 = 1e15;

struct Around {
    now: vec3f,
    before: vec3f,
    // Σw²n², Σw²b² and Σw²nb of luminances, over the square of what the patch itself has.
    squares: vec3f,
    unit: f32,
    // Number of patches, by their weights.
    count: f32,
}

// The light around a patch. Where a surface ends its last patch answers for what lies beyond: it counts once.
fn around(index: u32) -> Around {
    let range = patches[index];
    let surfel = surfels[range.x + range.y / 2u];
    let tangents = basis(surfel.normal);
    let unit = 1.0 / max(luminance(patch_light[index].rgb) + luminance(history_before[index].light.rgb), 1e-30);
    var sum = Around(vec3f(0.0), vec3f(0.0), vec3f(0.0), unit, 0.0);
    var weights = vec2f(0.0);
    var seen: array<u32, MOST_AROUND>;
    var found = 0u;
    for (var i = -REACH; i <= REACH; i++) {
        for (var k = -REACH; k <= REACH; k++) {
            let position = surfel.position + spacing * (f32(i) * tangents[0] + f32(k) * tangents[1]);
            var beside = index;
            if i != 0 || k != 0 {
                beside = patch_of_object(surfel.place & INDEX, position, surfel.normal);
            }
            var is_new = beside != NO_PATCH && (beside != index || (i == 0 && k == 0));
            for (var at = 0u; at < found; at++) {
                is_new = is_new && seen[at] != beside;
            }
            if is_new {
                seen[found] = beside;
                found++;
                let weight = exp(-f32(i * i + k * k) / (2.0 * WIDTH * WIDTH));
                let now = weight * patch_light[beside].rgb;
                let before = weight * history_before[beside].light.rgb;
                let both = min(unit * vec2f(luminance(now), luminance(before)), vec2f(BRIGHTEST));
                sum.now += now;
                sum.before += before;
                sum.squares += both.xyx * both.xyy;
                weights += vec2f(weight, weight * weight);
            }
        }
    }
    sum.count = weights.x * weights.x / weights.y;
    return sum;
}

// Light now over that of before. A channel of next to nothing is as good as none.
fn ratio(light: Around) -> vec3f {
    let both = light.now + light.before;
    let least = vec3f(max(1e-4 * (both.r + both.g + both.b), 1e-34));
    return min((light.now + least) / (light.before + least), vec3f(MOST));
}

struct Change {
    ratio: vec3f,          // of all that was not followed yet
    certainty: f32,        // how much of it is followed
    variance: f32,         // relative, of how the light of points changed beside it
}

// The change around a patch, with what was not followed before.
fn change(light: Around, pending: vec3f) -> Change {
    let now = min(light.unit * luminance(light.now), BRIGHTEST);
    let before = min(light.unit * luminance(light.before), BRIGHTEST);
    if !(now + before > 0.0) {
        return Change(vec3f(1.0), 0.0, 0.0);
    }
    let q = now / max(before, 1e-15);
    // Squared errors of the ratio, times that of the light before.
    let apart = max(light.squares.x - 2.0 * q * light.squares.z + q * q * light.squares.y, 0.0);
    let all = clamp(pending * ratio(light), vec3f(1.0 / MOST), vec3f(MOST));
    let followed = min(light.unit * luminance(light.now / all), BRIGHTEST);
    let by = abs(now - followed);
    let least = DEVIATION * max(now, followed) / (light.count * sqrt(light.count));
    let certainty = smoothstep(CHANCE, CERTAIN, by / max(sqrt(apart + least * least), 1e-30));
    let within = WITHIN * (now - before) / (now + before);
    let mean = max(now, 1e-3 * before);
    return Change(all, certainty, min(apart / (mean * mean) * light.count, 1.0) + within * within);
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&patch_light) {
        return;
    }
    var pending = vec3f(1.0);
#ifdef KNOWN
    let found = change(around(index), history_before[index].pending.rgb);
    let followed = mix(vec3f(1.0), found.ratio, found.certainty);
    patch_change[index] = vec4f(followed, found.certainty * found.variance);
    pending = mix(vec3f(1.0), found.ratio / followed, KEPT);
#else
    patch_change[index] = vec4f(1.0, 1.0, 1.0, 0.0);
#endif
    history_now[index] = PatchHistory(patch_light[index], vec4f(pending, 0.0));
}
