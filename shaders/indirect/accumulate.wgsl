// The mean of indirect light over frames. Each pixel asks where the point that it shows was seen in the last frame, and
// takes the light that was there with it, if what was seen is the same surface: on its plane, and turned like it (Nehab et
// al. 2007). With n frames before, the new one counts 1/(n + 1): the mean of all. That number is bounded where light
// changes, which makes the mean an exponential one.
//
// What is kept is light over reflectance, so that textures stay sharp where the camera moves.

#import lightwell::gbuffer::{decode_albedo, decode_normal, decode_normal_reflectance, world_position}
#import lightwell::view::View

struct Average {
    view: View,
    clip_from_world_before: mat4x4f,
    world_from_clip_before: mat4x4f,
    most: f32,             // frames before that count at most
    most_glossy: f32,      // the same for what mirrors
    is_first: u32,         // there is no frame before
    is_still: u32,         // the camera is where it was
}

@group(0) @binding(0) var<uniform> average: Average;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var object: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(5) var indirect: texture_2d<f32>;
// Light over reflectance [W/(m² sr)] with the number of frames in it; depth and octahedral normal.
@group(0) @binding(6) var light_before: texture_2d<f32>;
@group(0) @binding(7) var surface_before: texture_2d<u32>;
@group(0) @binding(8) var light_now: texture_storage_2d<rgba32float, write>;
@group(0) @binding(9) var surface_now: texture_storage_2d<rg32uint, write>;
@group(0) @binding(10) var averaged: texture_storage_2d<rgba32float, write>;

// Least reflectance that light is divided by.
const LEAST: f32 = 0.01;
// Roughness below which a surface shows an image, which does not stay where it is when the camera moves.
const GLOSSY: f32 = 0.5;
// How far off the plane of a surface, in pixels at its distance, a point still belongs to it; and the least cosine
// between their normals, 6°: an object that turns by more from frame to frame has light of its own in each.
const OFF_PLANE: f32 = 1.5;
const LEAST_COSINE: f32 = 0.995;

// What was seen before: light, and the number of frames in it; none: 0.
fn recalled(at: vec2i, position: vec3f, n: vec3f, pixel: f32) -> vec4f {
    if any(at < vec2i(0)) || any(at >= vec2i(average.view.size)) {
        return vec4f(0.0);
    }
    let surface = textureLoad(surface_before, at, 0).xy;
    let z = bitcast<f32>(surface.x);
    if z <= 0.0 {
        return vec4f(0.0);
    }
    let other = world_position(vec2u(at), average.view.size, z, average.world_from_clip_before);
    let other_n = decode_normal(vec4u(surface.y & 0xffffu, surface.y >> 16u, 0u, 0u));
    let is_same = abs(dot(other - position, n)) <= OFF_PLANE * pixel && dot(other_n, n) >= LEAST_COSINE;
    return select(vec4f(0.0), textureLoad(light_before, at, 0), is_same);
}

// Light of a point in the last frame, from the four pixels around it.
fn history(pixel: vec2u, position: vec3f, n: vec3f, footprint: f32) -> vec4f {
    if average.is_still != 0u {
        return recalled(vec2i(pixel), position, n, footprint);
    }
    let clip = average.clip_from_world_before * vec4f(position, 1.0);
    if clip.w <= 0.0 {
        return vec4f(0.0);
    }
    let ndc = clip.xy / clip.w;
    if any(abs(ndc) > vec2f(1.1)) {
        return vec4f(0.0);
    }
    let at = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * vec2f(average.view.size) - 0.5;
    let low = floor(at);
    let part = at - low;
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let found = recalled(vec2i(low) + corner, position, n, footprint);
        let weight = select(0.0, share.x * share.y, found.a > 0.0);
        sum += weight * found;
        weights += weight;
    }
    return select(vec4f(0.0), sum / max(weights, 1e-20), weights > 0.01);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= average.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    let drawn = textureLoad(normal, pixel, 0);
    var mean = vec4f(0.0);
    var reflectance = vec3f(0.0);
    if z > 0.0 {
        let size = average.view.size;
        let position = world_position(pixel, size, z, average.view.world_from_clip);
        let n = decode_normal(drawn);
        let beside = world_position(pixel + vec2u(1u, 0u), size, z, average.view.world_from_clip);
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        reflectance = max(albedo + decode_normal_reflectance(textureLoad(object, pixel, 0).xy), vec3f(LEAST));
        let light = textureLoad(indirect, pixel, 0).rgb / reflectance;
        var before = vec4f(0.0);
        if average.is_first == 0u {
            before = history(pixel, position, n, distance(beside, position));
        }
        let is_glossy = f32(drawn.z) / 65535.0 < GLOSSY;
        let frames = min(before.a, select(average.most, average.most_glossy, is_glossy));
        mean = vec4f(mix(before.rgb, light, 1.0 / (frames + 1.0)), frames + 1.0);
    }
    textureStore(light_now, pixel, mean);
    textureStore(surface_now, pixel, vec4u(bitcast<u32>(z), drawn.x | (drawn.y << 16u), 0u, 0u));
    textureStore(averaged, pixel, vec4f(mean.rgb * reflectance, 1.0));
}
