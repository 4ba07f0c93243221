// A main light as the report shades it: (1/N)·(ρ/π)·(1 − s)·L·max(n·l, 0), without distance. s by its shadow map of
// world distance over the far plane, with a static bias and one that grows at grazing light, and percentage-closer
// filtering with random offsets.

#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::lights::{Light, SPOT, light_incidence, light_intensity_towards}
#import lightwell::sampling::{hash_pair, unit_float}
#import lightwell::shadow_lookup::{Shadow, NO_SHADOW, DIRECTIONAL_SHADOW, SPOT_SHADOW, POINT_SHADOW, cube_face}
#import lightwell::view::View

struct MainLight {
    weight: f32,           // 1/N
    bias: f32,             // b_s [texels]
    slope_bias: f32,       // b_dmax [texels]
    samples: u32,          // S
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> shadow: Shadow;
@group(0) @binding(3) var<uniform> main_light: MainLight;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
@group(0) @binding(8) var shadow_map: texture_depth_2d_array;
@group(0) @binding(9) var radiance: texture_storage_2d_array<r32float, read_write>;

const INVERSE_PI: f32 = 0.31830988618379;
// Half width of the filter [texels].
const FILTER_RADIUS: f32 = 1.5;

// Share of the lookups that find something nearer to the light than the point, bias included.
fn shadowed(position: vec3f, n: vec3f, to_light: vec3f, pixel: vec2u) -> f32 {
    if shadow.kind == NO_SHADOW {
        return 0.0;
    }
    let offset = position - shadow.eye;
    var along_axis = 1.0;
    if shadow.kind == SPOT_SHADOW {
        along_axis = max(dot(offset, shadow.axis), 0.0);
    } else if shadow.kind == POINT_SHADOW {
        along_axis = max(abs(offset.x), max(abs(offset.y), abs(offset.z)));
    }
    let face = select(0, cube_face(offset), shadow.kind == POINT_SHADOW);
    let clip = shadow.faces[face].clip_from_world * vec4f(position, 1.0);
    let ndc = clip.xyz / clip.w;
    if clip.w <= 0.0 || any(abs(ndc.xy) > vec2f(1.0)) {
        return 0.0;
    }
    // The map holds 1 − d/far: what is nearer to the light has the larger value.
    let stored_depth = select(1.0 - length(offset) / shadow.far, ndc.z, shadow.kind == DIRECTIONAL_SHADOW);
    // In texels, never in metres: the width of one at this distance over the far plane.
    let texel = shadow.texel * along_axis / shadow.far;
    let bias = texel * (main_light.bias + main_light.slope_bias * (1.0 - saturate(dot(n, to_light))));
    let at = (vec2f(0.5, -0.5) * ndc.xy + 0.5) * shadow.size;
    var hidden = 0.0;
    for (var i = 0u; i < main_light.samples; i++) {
        let random = hash_pair(pixel.x | (pixel.y << 16u), i);
        let shift = vec2f(unit_float(random), unit_float(hash_pair(random, 1u))) * 2.0 - 1.0;
        let place = at + select(vec2f(0.0), shift * FILTER_RADIUS, main_light.samples > 1u);
        let texel_at = clamp(vec2i(floor(place)), vec2i(0), vec2i(i32(shadow.size) - 1));
        hidden += select(0.0, 1.0, textureLoad(shadow_map, texel_at, face, 0) > stored_depth + bias);
    }
    return hidden / f32(main_light.samples);
}

@compute @workgroup_size(8, 8)
fn add_light(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        return;
    }
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    let to_light = light_incidence(light, position).to_light;
    let cosine = dot(surface.normal, to_light);
    if cosine <= 0.0 {
        return;
    }
    let lit = 1.0 - shadowed(position, surface.normal, to_light, pixel);
    let reflected = surface.albedo * light_intensity_towards(light, -to_light) * (INVERSE_PI * cosine * lit * main_light.weight);
    for (var channel = 0u; channel < 3u; channel++) {
        let before = textureLoad(radiance, pixel, channel).r;
        textureStore(radiance, pixel, channel, vec4f(before + reflected[channel], 0.0, 0.0, 0.0));
    }
}
