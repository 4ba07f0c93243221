// The mean of indirect light over frames. Each pixel asks where the point that it shows was seen in the last frame, and
// takes the light that was there with it, if what was seen is the same surface: on its plane, and turned like it (Nehab et
// al. 2007). With n frames before, the new one counts 1/(n + 1): the mean of all. That number is bounded where light
// changes, which makes the mean an exponential one.
//
// Light that changes is followed in two ways. Where the light of patches is known, what is remembered changes as theirs does.
// And a quick mean over few frames runs beside the long one, which may not leave it by more than its noise explains: what
// patches do not resolve, such as the shadow of contact of something that moves (cf. the fast history of Zhdan 2021, "ReBLUR:
// a hierarchical recurrent denoiser").
//
// What is kept is light over reflectance, so that textures stay sharp where the camera moves.
//   MOVED    there are objects that are elsewhere than in the frame before
//   PATCHES  the light of patches is known
//   MIRRORS  roughness [%] up to which what metals reflect is none of this light, see lib/visible_surface.wgsl

#import lightwell::color::luminance
#import lightwell::gbuffer::{decode_albedo, decode_normal, decode_normal_reflectance, decode_radiance, encode_radiance, world_position}
#ifdef MOVED
#import lightwell::motion::place_before
#endif
#ifdef PATCHES
#import lightwell::patches::{NO_PATCH, patch_at}
#import lightwell::visible_patches::{NO_PRIMITIVE, primitive_with}
#endif
#import lightwell::view::View

struct Average {
    view: View,
    clip_from_world_before: mat4x4f,
    world_from_clip_before: mat4x4f,
    most: f32,             // frames before that count at most
    most_glossy: f32,      // the same for what mirrors
    is_first: u32,         // there is no frame before
    is_still: u32,         // the camera is where it was
    tolerance: f32,        // how far the long mean may be from the quick one [deviations of a frame]
}

@group(0) @binding(0) var<uniform> average: Average;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var object: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
// Radiance [W/(m² sr)], and where patches are known how much it counts beside that of other frames.
@group(0) @binding(5) var indirect: texture_2d<f32>;
// Light over reflectance [W/(m² sr)] with shared exponent; the bits of the luminance of its quick mean; the patch.
@group(0) @binding(6) var light_before: texture_2d<u32>;
// Bits of the depth; octahedral normal; bits of the mean deviation of a frame's luminance and of the number of frames.
@group(0) @binding(7) var surface_before: texture_2d<u32>;
@group(0) @binding(8) var light_now: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(9) var surface_now: texture_storage_2d<rgba32uint, write>;
// Radiance [W/(m² sr)]; alpha: standard deviation of the luminance of light over reflectance.
@group(0) @binding(10) var averaged: texture_storage_2d<rgba32float, write>;
#ifdef PATCHES
// See `light_volumes/radiosity/change.wgsl`.
@group(0) @binding(11) var<storage, read> patch_change: array<vec4f>;
#endif

// Least reflectance that light is divided by.
const LEAST: f32 = 0.01;
// Roughness below which a surface shows an image, which does not stay where it is when the camera moves.
const GLOSSY: f32 = 0.5;
// How far off the plane of a surface, in pixels at its distance, a point still belongs to it; and the least cosine
// between their normals, 6°: an object that bends by more from frame to frame has light of its own in each.
const OFF_PLANE: f32 = 1.5;
const LEAST_COSINE: f32 = 0.995;
// Least share of a new frame in the quick mean, and in the mean deviation.
const QUICK: f32 = 0.3;
const STEADY: f32 = 0.1;
// Of the quick mean, beside its noise: how far the long one may be from it.
const LEAST_TOLERANCE: f32 = 0.02;
// Frames that count where the long mean had to follow the quick one.
const AFTER_CHANGE: f32 = 1.0 / QUICK - 1.0;
// How many mean deviations above the quick mean a frame's light may be that is no stray, and the least of them, of that mean;
// where so many frames are known.
const STRAY: f32 = 4.0;
const LEAST_SPREAD: f32 = 0.25;
const FEW: f32 = 2.0;
// Noise of a frame's light, in mean deviations and at least of the light itself: it decides whether a change of the patch's
// light is followed; and the logarithm of the odds that it is where the pixel's own light says nothing.
const NOISE: f32 = 0.8;
const LEAST_NOISE: f32 = 0.03;
const TRUST: f32 = 3.0;

// Mean deviation over the light that the first frame is taken to have: anything may come. And the one that a filtered frame has
// in fact, which counts until KNOWN frames show it.
const FIRST_DEVIATION: f32 = 0.5;
const FILTERED_DEVIATION: f32 = 0.025;
const KNOWN: f32 = 3.0;
// Ratio of the standard to the mean deviation of normally distributed noise: √(π/2).
const STANDARD: f32 = 1.2533;

struct Past {
    light: vec3f,
    frames: f32,           // in it; 0: nothing is known
    quick: f32,            // luminance of the quick mean
    spread: f32,           // mean deviation of a frame's luminance
    change: vec3f,         // how its patch's light changed since: a factor
    doubt: f32,            // and the relative variance of how it did itself beside that
}

fn nothing() -> Past {
    return Past(vec3f(0.0), 0.0, 0.0, 0.0, vec3f(1.0), 0.0);
}

// What was kept of a pixel.
fn kept(at: vec2i, spread: f32, frames: f32) -> Past {
    let texel = textureLoad(light_before, at, 0);
    var past = Past(decode_radiance(texel.xy), frames, bitcast<f32>(texel.z), spread, vec3f(1.0), 0.0);
#ifdef PATCHES
    let patch_index = texel.w;
    if patch_index < min(NO_PATCH, arrayLength(&patch_change)) {
        let change = patch_change[patch_index];
        past.change = change.rgb;
        past.doubt = change.a;
    }
#endif
    return past;
}

// What is remembered of a point of a surface at a pixel of the frame before.
fn recalled(at: vec2i, position: vec3f, n: vec3f, footprint: f32) -> Past {
    if any(at < vec2i(0)) || any(at >= vec2i(average.view.size)) {
        return nothing();
    }
    let surface = textureLoad(surface_before, at, 0);
    let z = bitcast<f32>(surface.x);
    if z <= 0.0 {
        return nothing();
    }
    let other = world_position(vec2u(at), average.view.size, z, average.world_from_clip_before);
    let other_n = decode_normal(vec4u(surface.y & 0xffffu, surface.y >> 16u, 0u, 0u));
    let is_same = abs(dot(other - position, n)) <= OFF_PLANE * footprint && dot(other_n, n) >= LEAST_COSINE;
    if !is_same {
        return nothing();
    }
    return kept(at, bitcast<f32>(surface.z), bitcast<f32>(surface.w));
}

// What is remembered of a point, from the four pixels around where it was.
fn around(position: vec3f, n: vec3f, footprint: f32) -> Past {
    let clip = average.clip_from_world_before * vec4f(position, 1.0);
    if clip.w <= 0.0 {
        return nothing();
    }
    let ndc = clip.xy / clip.w;
    if any(abs(ndc) > vec2f(1.1)) {
        return nothing();
    }
    let at = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * vec2f(average.view.size) - 0.5;
    let low = floor(at);
    let part = at - low;
    var sum = nothing();
    var change = vec4f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let found = recalled(vec2i(low) + corner, position, n, footprint);
        let weight = select(0.0, share.x * share.y, found.frames > 0.0);
        sum.light += weight * found.light;
        sum.frames += weight * found.frames;
        sum.quick += weight * found.quick;
        sum.spread += weight * found.spread;
        change += weight * vec4f(found.change, found.doubt);
        weights += weight;
    }
    if weights <= 0.01 {
        return nothing();
    }
    let scale = 1.0 / weights;
    return Past(scale * sum.light, scale * sum.frames, scale * sum.quick, scale * sum.spread, scale * change.rgb, scale * change.a);
}

// What is remembered of the point that a pixel shows.
fn history(pixel: vec2u, id: u32, position: vec3f, n: vec3f, footprint: f32) -> Past {
    if average.is_first != 0u {
        return nothing();
    }
#ifdef MOVED
    let place = place_before(id, position, n);
    if place.is_moved {
        return around(place.position, place.normal, footprint);
    }
#endif
    if average.is_still != 0u {
        let same = recalled(vec2i(pixel), position, n, footprint);
        if same.frames > 0.0 {
            return same;
        }
    }
    return around(position, n, footprint);
}

fn is_changing() -> bool {
    return average.tolerance < 1e3;
}

// A frame's light, without what only a stray sample explains: a single path to something small and bright. Light that does
// change raises the limit with every frame, and where nothing changes any more the mean has all there is.
fn without_strays(past: Past, light: vec3f) -> vec3f {
    let limit = past.quick + STRAY * max(past.spread, LEAST_SPREAD * past.quick);
    let found = luminance(light);
    return select(light, light * (limit / max(found, 1e-37)), is_changing() && past.frames > FEW && found > limit);
}

// What is remembered, in the light of now. The light of a patch may change otherwise than that of a point of it: the change is
// followed as far as the pixel's own light does not speak against it, by the odds of the two for normally distributed noise. What
// is followed has an error then, of variance `doubt`, which frames do not average away: beside those of n frames with noise σ² each,
// as in a Kalman filter, it leaves n/(1 + n·doubt/σ²) of them.
fn followed(past: Past, fresh: f32) -> Past {
    let was = luminance(past.light);
    let would = luminance(past.light * past.change);
    let noise = max(NOISE * past.spread, LEAST_NOISE * max(was, would));
    let odds = (would - was) / max(noise, 1e-30) * ((fresh - 0.5 * (was + would)) / max(noise, 1e-30));
    let share = 1.0 / (1.0 + exp(-clamp(TRUST + odds, -20.0, 20.0)));
    var now = past;
    now.light *= mix(vec3f(1.0), past.change, share);
    let factor = luminance(now.light) / max(was, 1e-37);
    now.quick *= factor;
    now.spread *= factor;
    let relative = max(NOISE * past.spread / max(was, 1e-30), LEAST_NOISE);
    now.frames /= 1.0 + share * min(past.frames, average.most) * past.doubt / (relative * relative);
    return now;
}

// The new means, from what is remembered and a frame's light that counts so much.
fn updated(before: Past, all: vec3f, count: f32, most: f32) -> Past {
    let past = followed(before, luminance(all));
    let light = without_strays(past, all);
    let frames = min(past.frames, most);
    let share = count / (frames + count);
    let fresh = luminance(light);
    // From the quick mean: the long one may lag behind, and that is no noise. Nor is what a frame of other light is off by.
    let known = min(abs(fresh - past.quick), STRAY * max(past.spread, LEAST_NOISE * past.quick));
    let deviation = select(FIRST_DEVIATION * fresh, known, frames > 0.0);
    var now = Past(mix(past.light, light, share), frames + count, past.quick, past.spread, vec3f(1.0), 0.0);
    now.quick = mix(past.quick, fresh, max(min(1.0, QUICK * count), share));
    now.spread = mix(past.spread, deviation, max(min(1.0, STEADY * count), share));
    let mean = luminance(now.light);
    let allowed = average.tolerance * now.spread + LEAST_TOLERANCE * now.quick;
    let bounded = clamp(mean, now.quick - allowed, now.quick + allowed);
    if bounded != mean && is_changing() {
        // What was next to black has no colour to go by.
        now.light = select(light, now.light * (bounded / max(mean, 1e-37)), mean > 1e-3 * bounded);
        now.frames = min(now.frames, AFTER_CHANGE + count);
    }
    return now;
}

// Standard deviation of the mean's luminance, from the mean deviation of a frame. That began with a guess: what is left of
// it after n frames is taken away again.
fn deviation_of_mean(now: Past) -> f32 {
    let n = max(now.frames, 1.0);
    let guessed = select(1.0 / n, STEADY * pow(1.0 - STEADY, n - 1.0 / STEADY), n > 1.0 / STEADY);
    let measured = max(now.spread - FIRST_DEVIATION * now.quick * guessed, 0.0) / max(1.0 - guessed, 0.01);
    let deviation = select(FILTERED_DEVIATION * now.quick, measured, n >= KNOWN);
    // Its square has to stay in the range of floats.
    return min(STANDARD * deviation * inverseSqrt(n), 1e15);
}

fn patch_of(id: u32, position: vec3f, n: vec3f) -> u32 {
#ifdef PATCHES
    let primitive = primitive_with(id);
    if primitive == NO_PRIMITIVE {
        return NO_PATCH;
    }
    return patch_at(primitive, position, n);
#else
    return 0xfffffu;
#endif
}

// Whether nothing that the pixel shows is reflected diffusely, and all else is mirrored.
fn is_mirror_alone(pixel: vec2u, drawn: vec4u) -> bool {
#ifdef MIRRORS
    let is_smooth = f32(drawn.z) / 65535.0 <= f32(#{MIRRORS}u) / 100.0;
    return is_smooth && all(decode_albedo(textureLoad(base_color, pixel, 0)) <= vec3f(0.0));
#else
    return false;
#endif
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= average.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    let drawn = textureLoad(normal, pixel, 0);
    var now = nothing();
    var patch_index = 0xfffffu;
    var reflectance = vec3f(0.0);
    if z > 0.0 && !is_mirror_alone(pixel, drawn) {
        let size = average.view.size;
        let position = world_position(pixel, size, z, average.view.world_from_clip);
        let n = decode_normal(drawn);
        let footprint = distance(world_position(pixel + vec2u(1u, 0u), size, z, average.view.world_from_clip), position);
        let surface = textureLoad(object, pixel, 0).xy;
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        reflectance = max(albedo + decode_normal_reflectance(surface), vec3f(LEAST));
        let found = textureLoad(indirect, pixel, 0);
        let most = select(average.most, average.most_glossy, f32(drawn.z) / 65535.0 < GLOSSY);
        let past = history(pixel, surface.x, position, n, footprint);
#ifdef PATCHES
        let count = found.a;
#else
        let count = 1.0;
#endif
        now = updated(past, found.rgb / reflectance, count, most);
        patch_index = patch_of(surface.x, position, n);
    }
    let code = encode_radiance(now.light);
    textureStore(light_now, pixel, vec4u(code, bitcast<u32>(now.quick), patch_index));
    let kept_surface = vec4u(bitcast<u32>(z), drawn.x | (drawn.y << 16u), bitcast<u32>(now.spread), bitcast<u32>(now.frames));
    textureStore(surface_now, pixel, kept_surface);
    textureStore(averaged, pixel, vec4f(now.light * reflectance, deviation_of_mean(now)));
}
