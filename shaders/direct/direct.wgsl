// Direct light of one light, added to the radiance of the pixels that it can reach.

#import lightwell::direct::{is_lit, reflected_light}
#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::lights::{Light, light_incidence}
#import lightwell::shadow_lookup::{Shadow, NO_SHADOW, shadow_coordinate}
#import lightwell::view::{View, toward_eye}

struct Region {
    origin: vec2u,         // first pixel
    size: vec2u,           // [pixels]
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> shadow: Shadow;
@group(0) @binding(3) var<uniform> region: Region;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
@group(0) @binding(8) var shadow_map: texture_depth_2d_array;
@group(0) @binding(9) var shadow_sampler: sampler_comparison;
// Red, green and blue as layers: r32float is the one float format that may be read and written everywhere.
@group(0) @binding(10) var radiance: texture_storage_2d_array<r32float, read_write>;

// Percentage-closer filtering (Reeves et al. 1987) of the four nearest texels. Wider filters were measured and
// left: against hard shadows each half texel of width adds a tenth to the error of the direct image.
fn visibility(position: vec3f, n: vec3f, to_light: vec3f) -> f32 {
    if shadow.kind == NO_SHADOW {
        return 1.0;
    }
    let at = shadow_coordinate(shadow, position, n, to_light);
    if !at.inside {
        return 1.0;
    }
    return textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv, at.face, at.depth);
}

@compute @workgroup_size(8, 8)
fn add_light(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= region.size) {
        return;
    }
    let pixel = region.origin + thread.xy;
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        return;
    }
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let incidence = light_incidence(light, position);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    if !is_lit(surface, incidence) {
        return;
    }
    let lit = visibility(position, surface.normal, incidence.to_light);
    if lit <= 0.0 {
        return;
    }
    let reflected = reflected_light(surface, toward_eye(view, position), incidence) * lit;
    for (var channel = 0u; channel < 3u; channel++) {
        let before = textureLoad(radiance, pixel, channel).r;
        textureStore(radiance, pixel, channel, vec4f(before + reflected[channel], 0.0, 0.0, 0.0));
    }
}

@compute @workgroup_size(8, 8)
fn clear(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(radiance)) {
        return;
    }
    for (var channel = 0u; channel < 3u; channel++) {
        textureStore(radiance, thread.xy, channel, vec4f(0.0));
    }
}
