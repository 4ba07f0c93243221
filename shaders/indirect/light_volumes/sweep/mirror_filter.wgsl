// A filter over what mirrors show, about half as wide as their specular lobes blur it: the noise of few rays becomes less, and
// the image hardly less sharp. The lobe of a GGX α turns reflected rays by up to about 2α. What lies at a distance t behind a
// mirror at a distance d is blurred by the angle 2α·t/(d + t) as the eye sees it: nothing at contacts, all of it far off.

#import lightwell::gbuffer::{decode_normal, world_position}
#import lightwell::sampling::{TAU, hash, unit_float}
#import lightwell::view::{View, eye_distance}

struct MirrorFilter {
    view: View,
    width: f32,            // of the filter over that of the lobe
}

@group(0) @binding(0) var<uniform> mirror_filter: MirrorFilter;
@group(0) @binding(1) var normal: texture_2d<u32>;
@group(0) @binding(2) var object: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
// Radiance [W/(m² sr)], and how far off is what is shown [m]; 0: the pixel mirrors nothing.
@group(0) @binding(4) var mirrored: texture_2d<f32>;
@group(0) @binding(5) var filtered: texture_storage_2d<rgba32float, write>;

const TAPS: u32 = 16u;
const MOST: f32 = 12.0;
// Least cosine between normals of one mirror.
const LEAST_COSINE: f32 = 0.98;
// Turn from one tap to the next [rad]: the golden angle (Vogel 1979).
const GOLDEN: f32 = 2.39996323;

// How far off is what the pixels around show, which of few rays is noise: the harmonic mean [m].
fn shown_distance(pixel: vec2u) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let around = vec2i(pixel) + vec2i(i % 3 - 1, i / 3 - 1);
        let found = textureLoad(mirrored, clamp(around, vec2i(0), vec2i(mirror_filter.view.size) - 1), 0).a;
        if found > 0.0 {
            sum += 1.0 / found;
            count += 1.0;
        }
    }
    return count / max(sum, 1e-30);
}

// Radius of the filter [pixels].
fn radius_at(pixel: vec2u, roughness: f32, t: f32) -> f32 {
    let size = mirror_filter.view.size;
    let z = textureLoad(depth, pixel, 0);
    let here = world_position(pixel, size, z, mirror_filter.view.world_from_clip);
    let beside = world_position(pixel + vec2u(1u, 0u), size, z, mirror_filter.view.world_from_clip);
    let d = eye_distance(mirror_filter.view, here);
    let pixel_angle = max(distance(here, beside) / max(d, 1e-30), 1e-6);
    let spread = 2.0 * roughness * roughness * t / max(d + t, 1e-30);
    return min(mirror_filter.width * spread / pixel_angle, MOST);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    let size = vec2i(mirror_filter.view.size);
    if any(vec2i(pixel) >= size) {
        return;
    }
    let own = textureLoad(mirrored, pixel, 0);
    var sum = own.rgb;
    var t = own.a;
    if own.a > 0.0 {
        t = shown_distance(pixel);
        let drawn = textureLoad(normal, pixel, 0);
        let n = decode_normal(drawn);
        let id = textureLoad(object, pixel, 0).x;
        let radius = radius_at(pixel, f32(drawn.z) / 65535.0, t);
        let turn = TAU * unit_float(hash(pixel.x ^ hash(pixel.y)));
        var weights = 1.0;
        for (var i = 0u; i < select(0u, TAPS, radius >= 0.75); i++) {
            let part = sqrt((f32(i) + 0.5) / f32(TAPS));
            let angle = turn + f32(i) * GOLDEN;
            let at = vec2i(pixel) + vec2i(round(radius * part * vec2f(cos(angle), sin(angle))));
            if any(at < vec2i(0)) || any(at >= size) {
                continue;
            }
            let found = textureLoad(mirrored, at, 0);
            let is_same = found.a > 0.0 && textureLoad(object, at, 0).x == id
                && dot(n, decode_normal(textureLoad(normal, at, 0))) >= LEAST_COSINE;
            let weight = select(0.0, exp(-2.0 * part * part), is_same);
            sum += weight * found.rgb;
            weights += weight;
        }
        sum /= weights;
    }
    textureStore(filtered, pixel, vec4f(sum, t));
}
