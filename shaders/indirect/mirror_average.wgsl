// The mean over frames of what mirrors show. A mirror shows an image that lies as far behind it as what it shows lies before
// it: a pixel asks what was seen of that point in the frame before (Stachowiak 2015, "Stochastic screen-space reflections").
// On curved mirrors that is only about right. Where anything moves, what is remembered may therefore not leave what the
// pixels around show now, by more than their noise explains (Salvi 2016, "An excursion in temporal supersampling").
//   MOVED    there are objects that are elsewhere than in the frame before

#import lightwell::gbuffer::{decode_normal, decode_radiance, encode_radiance, world_position}
#ifdef MOVED
#import lightwell::motion::place_before
#endif
#import lightwell::view::{View, toward_eye}

struct MirrorAverage {
    view: View,
    clip_from_world_before: mat4x4f,
    most: f32,             // frames before that count at most
    is_known: u32,         // there is a frame before
    is_still: u32,         // the camera is where it was
    is_bounded: u32,       // something moves
}

@group(0) @binding(0) var<uniform> average: MirrorAverage;
@group(0) @binding(1) var normal: texture_2d<u32>;
@group(0) @binding(2) var object: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
// Radiance [W/(m² sr)], and how far off is what is shown [m]; 0: the pixel mirrors nothing.
@group(0) @binding(4) var mirrored: texture_2d<f32>;
// Radiance with shared exponent; octahedral normal; the object in 20 bits and the number of frames in 12.
@group(0) @binding(5) var before: texture_2d<u32>;
@group(0) @binding(6) var now: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(7) var averaged: texture_storage_2d<rgba32float, write>;

const OBJECT: u32 = 0xfffffu;
// Least cosine between normals of one mirror.
const LEAST_COSINE: f32 = 0.9;
// How many standard deviations of the pixels around what is remembered may be off their mean.
const BOUND: f32 = 1.5;

const FRAMES_BY_ROUGHNESS: f32 = 28.0;

struct Past {
    radiance: vec3f,
    frames: f32,           // in it; 0: nothing is known
}

// The mirror as a pixel shows it.
struct Seen {
    position: vec3f,       // in the frame before [m]
    normal: vec3f,
    id: u32,
    is_moved: bool,
}

fn seen_at(pixel: vec2u, z: f32) -> Seen {
    let position = world_position(pixel, average.view.size, z, average.view.world_from_clip);
    let n = decode_normal(textureLoad(normal, pixel, 0));
    let id = textureLoad(object, pixel, 0).x;
#ifdef MOVED
    let place = place_before(id, position, n);
    return Seen(place.position, place.normal, id, place.is_moved);
#else
    return Seen(position, n, id, false);
#endif
}

fn recalled(at: vec2i, seen: Seen) -> Past {
    if any(at < vec2i(0)) || any(at >= vec2i(average.view.size)) {
        return Past(vec3f(0.0), 0.0);
    }
    let texel = textureLoad(before, at, 0);
    let other = decode_normal(vec4u(texel.z & 0xffffu, texel.z >> 16u, 0u, 0u));
    if (texel.w & OBJECT) != (seen.id & OBJECT) || dot(other, seen.normal) < LEAST_COSINE {
        return Past(vec3f(0.0), 0.0);
    }
    return Past(decode_radiance(texel.xy), f32(texel.w >> 20u));
}

// What is remembered of a point, from the four pixels around where it was.
fn around(point: vec3f, seen: Seen) -> Past {
    let clip = average.clip_from_world_before * vec4f(point, 1.0);
    let ndc = clip.xy / max(clip.w, 1e-30);
    if clip.w <= 0.0 || any(abs(ndc) > vec2f(1.1)) {
        return Past(vec3f(0.0), 0.0);
    }
    let at = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * vec2f(average.view.size) - 0.5;
    let low = floor(at);
    let part = at - low;
    var sum = Past(vec3f(0.0), 0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let found = recalled(vec2i(low) + corner, seen);
        let weight = select(0.0, share.x * share.y, found.frames > 0.0);
        sum.radiance += weight * found.radiance;
        sum.frames += weight * found.frames;
        weights += weight;
    }
    if weights <= 0.01 {
        return Past(vec3f(0.0), 0.0);
    }
    return Past(sum.radiance / weights, sum.frames / weights);
}

fn past_of(pixel: vec2u, seen: Seen, distance: f32) -> Past {
    if average.is_known == 0u {
        return Past(vec3f(0.0), 0.0);
    }
    if average.is_still != 0u && !seen.is_moved {
        return recalled(vec2i(pixel), seen);
    }
    let away = -normalize(toward_eye(average.view, seen.position));
    return around(seen.position + away * distance, seen);
}

// What is remembered, within what the pixels around show.
fn bounded(past: vec3f, pixel: vec2u) -> vec3f {
    var mean = vec3f(0.0);
    var spread = vec3f(0.0);
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let around = vec2i(pixel) + vec2i(i % 3 - 1, i / 3 - 1);
        let texel = textureLoad(mirrored, clamp(around, vec2i(0), vec2i(average.view.size) - 1), 0);
        if texel.a > 0.0 {
            // Running sums of squares about the mean (Welford 1962): no cancellation.
            count += 1.0;
            let off = texel.rgb - mean;
            mean += off / count;
            spread += off * (texel.rgb - mean);
        }
    }
    let reach = BOUND * sqrt(max(spread, vec3f(0.0)) / max(count, 1.0));
    return clamp(past, mean - reach, mean + reach);
}

// Frames before that count at most. While anything moves the smoothest mirrors, whose frames have hardly any noise, go on with
// one, and rough ones with all that are allowed.
fn most_frames(roughness: f32) -> f32 {
    let by_noise = clamp(FRAMES_BY_ROUGHNESS * roughness, 1.0, average.most);
    return select(average.most, by_noise, average.is_bounded != 0u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= average.view.size) {
        return;
    }
    let shown = textureLoad(mirrored, pixel, 0);
    var radiance = vec3f(0.0);
    var kept = vec4u(0u);
    if shown.a > 0.0 {
        let drawn = textureLoad(normal, pixel, 0);
        let seen = seen_at(pixel, textureLoad(depth, pixel, 0));
        let past = past_of(pixel, seen, shown.a);
        let frames = min(past.frames, most_frames(f32(drawn.z) / 65535.0));
        var light = past.radiance;
        if average.is_bounded != 0u && frames > 0.0 {
            light = bounded(light, pixel);
        }
        radiance = mix(light, shown.rgb, 1.0 / (frames + 1.0));
        let count = u32(round(frames)) + 1u;
        kept = vec4u(encode_radiance(radiance), drawn.x | (drawn.y << 16u), (seen.id & OBJECT) | (count << 20u));
    }
    textureStore(now, pixel, kept);
    textureStore(averaged, pixel, vec4f(radiance, 1.0));
}
