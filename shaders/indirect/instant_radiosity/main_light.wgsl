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
    bias: f32,             // b_s [texels, or metres]
    slope_bias: f32,       // b_dmax [texels, or metres]
    samples: u32,          // S
    offset: f32,           // off [texels, or metres]
    in_space: u32,         // 1: metres, as published
    pad_a: u32,
    pad_b: u32,
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

// Where the shadow map is read for a point.
struct Place {
    at: vec2f,             // [texels]
    face: i32,
    inside: bool,
    depth: f32,            // what the map holds if nothing is nearer to the light: 1 − d/far, or a directional light's own
}

fn place_of(point: vec3f) -> Place {
    let offset = point - shadow.view.eye;
    var place: Place;
    place.face = select(0, cube_face(offset), shadow.view.kind == POINT_SHADOW);
    let clip = shadow.faces[place.face].clip_from_world * vec4f(point, 1.0);
    let ndc = clip.xyz / clip.w;
    place.at = (vec2f(0.5, -0.5) * ndc.xy + 0.5) * shadow.view.size;
    place.inside = clip.w > 0.0 && all(abs(ndc.xy) <= vec2f(1.0));
    place.depth = select(1.0 - length(offset) / shadow.view.far, ndc.z, shadow.view.kind == DIRECTIONAL_SHADOW);
    return place;
}

// 1 where the map has something nearer to the light than that depth.
fn hides(at: vec2f, face: i32, depth: f32) -> f32 {
    let texel = clamp(vec2i(floor(at)), vec2i(0), vec2i(i32(shadow.view.size) - 1));
    return select(0.0, 1.0, textureLoad(shadow_map, texel, face, 0) > depth);
}

// Width of a texel at the point [m].
fn texel_width(position: vec3f) -> f32 {
    let offset = position - shadow.view.eye;
    if shadow.view.kind == SPOT_SHADOW {
        return shadow.view.texel * max(dot(offset, shadow.view.axis), 0.0);
    }
    if shadow.view.kind == POINT_SHADOW {
        return shadow.view.texel * max(abs(offset.x), max(abs(offset.y), abs(offset.z)));
    }
    return shadow.view.texel;
}

// The i-th random offset oᵢ in [−1, 1]³; none where a single lookup is made.
fn random_offset(pixel: vec2u, i: u32) -> vec3f {
    if main_light.samples <= 1u {
        return vec3f(0.0);
    }
    let random = hash_pair(pixel.x | (pixel.y << 16u), i);
    let at = vec3f(unit_float(random), unit_float(hash_pair(random, 1u)), unit_float(hash_pair(random, 2u)));
    return at * 2.0 - 1.0;
}

// Share of the lookups that find something nearer to the light than the point, bias included. The map holds 1 − d/far,
// so a bias in metres is one over the far plane: ‖l‖ − bias > d is the same as 1 − d/far > 1 − ‖l‖/far + bias/far.
fn shadowed(position: vec3f, n: vec3f, to_light: vec3f, pixel: vec2u) -> f32 {
    let own = place_of(position);
    if shadow.view.kind == NO_SHADOW || !own.inside {
        return 0.0;
    }
    let in_space = main_light.in_space == 1u;
    let unit = select(texel_width(position), 1.0, in_space);
    // b_s + b_dmax·(1 − n·l)
    let bias = unit / shadow.view.far * (main_light.bias + main_light.slope_bias * (1.0 - saturate(dot(n, to_light))));
    var hidden = 0.0;
    for (var i = 0u; i < main_light.samples; i++) {
        let offset = random_offset(pixel, i) * main_light.offset;
        var place = own;
        if in_space {
            // From the light this is the direction −l + off·oᵢ.
            place = place_of(position + offset);
        } else {
            place.at += offset.xy;
        }
        hidden += select(0.0, hides(place.at, place.face, own.depth + bias), place.inside);
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
