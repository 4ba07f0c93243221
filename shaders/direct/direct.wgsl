// Direct light of one light, added to the radiance of the pixels that it can reach.
//   SHADOW_RAYS  the scene is there for rays: where the shadow map cannot tell, one ray does

#import lightwell::direct::{is_lit, reflected_light, through_media}
#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::lights::{Light, light_incidence}
#ifdef SHADOW_RAYS
#import lightwell::shadow_rays::{UNKNOWN, passing_on_way}
#endif
#import lightwell::shadow_lookup::{Shadow, NO_SHADOW, distance_along_view, shadow_coordinate, shadow_receiver}
#import lightwell::view::{View, pixel_width, toward_eye}

struct Region {
    origin: vec2u,         // first pixel
    size: vec2u,           // [pixels]
    root: u32,             // of the hierarchy for rays
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
    if shadow.view.kind == NO_SHADOW {
        return 1.0;
    }
    let receiver = shadow_receiver(shadow.view, position, n, to_light);
    let at = shadow_coordinate(shadow.view, shadow.faces[receiver.face].clip_from_world, receiver);
    if !at.inside {
        return 1.0;
    }
#ifdef SHADOW_RAYS
    // Things that are smaller than a texel may be missing in the map.
    if shadow.view.texel * distance_along_view(shadow.view, position) > COARSE * pixel_width(view, position) {
        return UNKNOWN;
    }
    // Filtered lookups around the point see all texels up to two from it. Where they agree it is lit, or not.
    let step = 1.0 / shadow.view.size;
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv + step * corner, at.face, at.depth);
    }
    return select(UNKNOWN, 0.25 * sum, sum == 0.0 || sum == 4.0);
#else
    return textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv, at.face, at.depth);
#endif
}

#ifdef SHADOW_RAYS
// Texels that are wider than so many pixels do not tell what the pixels need to know.
const COARSE: f32 = 4.0;
#endif

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
    let incidence = through_media(light_incidence(light, position), position);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    if !is_lit(surface, incidence) {
        return;
    }
    var lit = vec3f(visibility(position, surface.normal, incidence.to_light));
#ifdef SHADOW_RAYS
    lit = passing_on_way(view, region.root, position, surface.normal, incidence, lit.x);
#endif
    if all(lit <= vec3f(0.0)) {
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
