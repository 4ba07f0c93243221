// Edge-avoiding à-trous wavelet filter over the mean of frames, guided by the variance that is left in it (Dammertz, Sewtz,
// Hanika and Lensch 2010, "Edge-avoiding à-trous wavelet transform for fast global illumination filtering"; Schied et al.
// 2017, "Spatiotemporal variance-guided filtering"): neighbours count as far as they show the same surface and their light
// differs by no more than noise explains. Noise falls with every frame, and with it the filter fades out. It reads the mean and
// writes a separate image, so that no frame continues from filtered light.
//
// A level has 3×3 taps, `stride` pixels apart, in pairs on opposite sides that count alike: light that changes evenly stays as it
// is, and at the edge of a surface nothing is drawn towards its middle.

#import lightwell::bilateral::likeness
#import lightwell::color::luminance
#import lightwell::gbuffer::{decode_albedo, decode_normal, decode_normal_reflectance, world_position}
#import lightwell::view::View

struct VarianceFilter {
    view: View,
    stride: i32,           // between taps [pixels]
}

@group(0) @binding(0) var<uniform> variance_filter: VarianceFilter;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var object: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
// Radiance [W/(m² sr)]; alpha: standard deviation of the luminance of light over reflectance.
@group(0) @binding(5) var noisy: texture_2d<f32>;
@group(0) @binding(6) var filtered: texture_storage_2d<rgba32float, write>;

// Differences in light that noise explains [standard deviations of the mean], but no more of the light than MAX_DIFFERENCE: few
// frames are noisy, and what is wider is no noise to the eye.
const TOLERANCE: f32 = 3.0;
const MAX_DIFFERENCE: f32 = 0.06;
// Least reflectance that light is divided by, as in accumulate.wgsl.
const LEAST: f32 = 0.01;

fn reflectance_at(pixel: vec2u) -> vec3f {
    let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
    return max(albedo + decode_normal_reflectance(textureLoad(object, pixel, 0).xy), vec3f(LEAST));
}

// Share of the light that neighbours may replace: what a smooth specular lobe reflects is an image.
fn diffuse_share(pixel: vec2u, roughness: f32) -> f32 {
    let albedo = luminance(decode_albedo(textureLoad(base_color, pixel, 0)));
    let specular = luminance(decode_normal_reflectance(textureLoad(object, pixel, 0).xy));
    return (albedo + saturate(2.0 * roughness * roughness) * specular) / max(albedo + specular, 1e-30);
}

// The standard deviation around a pixel: that of few frames is itself noise.
fn deviation_around(pixel: vec2u) -> f32 {
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 9; i++) {
        let around = vec2i(i % 3, i / 3) - 1;
        let at = clamp(vec2i(pixel) + around, vec2i(0), vec2i(variance_filter.view.size) - 1);
        let weight = select(0.0, f32((2 - abs(around.x)) * (2 - abs(around.y))), textureLoad(depth, at, 0) > 0.0);
        let deviation = textureLoad(noisy, at, 0).a;
        sum += weight * deviation * deviation;
        weights += weight;
    }
    return sqrt(sum / max(weights, 1.0));
}

// A neighbour's light over reflectance, its deviation, and how much it counts.
struct Tap {
    light: vec3f,
    deviation: f32,
    weight: f32,
}

struct Center {
    position: vec3f,
    normal: vec3f,
    brightness: f32,       // luminance of its light over reflectance
    allowed: f32,          // difference of luminance that noise explains
}

fn tap_at(at: vec2i, center: Center) -> Tap {
    let view = variance_filter.view;
    if any(at < vec2i(0)) || any(at >= vec2i(view.size)) {
        return Tap(vec3f(0.0), 0.0, 0.0);
    }
    let z = textureLoad(depth, at, 0);
    if z <= 0.0 {
        return Tap(vec3f(0.0), 0.0, 0.0);
    }
    let found = textureLoad(noisy, at, 0);
    let light = found.rgb / reflectance_at(vec2u(at));
    let position = world_position(vec2u(at), view.size, z, view.world_from_clip);
    let like = likeness(center.position, center.normal, position, decode_normal(textureLoad(normal, at, 0)));
    let off = (luminance(light) - center.brightness) / center.allowed;
    return Tap(light, found.a, like * exp(-0.5 * off * off));
}

fn filtered_at(pixel: vec2u, z: f32, own: vec4f) -> vec4f {
    let view = variance_filter.view;
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let drawn = textureLoad(normal, pixel, 0);
    let reflectance = reflectance_at(pixel);
    let light = own.rgb / reflectance;
    let brightness = luminance(light);
    let allowed = min(TOLERANCE * deviation_around(pixel), MAX_DIFFERENCE * brightness) + 1e-4 * brightness + 1e-30;
    let center = Center(position, decode_normal(drawn), brightness, allowed);
    let share = diffuse_share(pixel, f32(drawn.z) / 65535.0);
    var sum = 4.0 * light;
    var variance = 16.0 * own.a * own.a;
    var weights = 4.0;
    for (var i = 0; i < 4; i++) {
        let along = select(vec2i(i - 1, 1), vec2i(1, 0), i == 3);
        let offset = variance_filter.stride * along;
        let first = tap_at(vec2i(pixel) + offset, center);
        let second = tap_at(vec2i(pixel) - offset, center);
        let weight = share * f32(3 - abs(along.x) - abs(along.y)) * min(first.weight, second.weight);
        sum += weight * (first.light + second.light);
        variance += weight * weight * (first.deviation * first.deviation + second.deviation * second.deviation);
        weights += 2.0 * weight;
    }
    return vec4f(reflectance * sum / weights, sqrt(variance) / weights);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= variance_filter.view.size) {
        return;
    }
    let center = textureLoad(noisy, pixel, 0);
    let z = textureLoad(depth, pixel, 0);
    var result = center;
    if z > 0.0 && center.a > 0.0 {
        result = filtered_at(pixel, z, center);
    }
    textureStore(filtered, pixel, result);
}
