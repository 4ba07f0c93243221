// Sums what a pixel shows: direct and indirect light, emission and sky, and blended surfaces over them; or one layer of
// the frame for itself.

#import lightwell::gbuffer::{decode_base_color, decode_normal, decode_radiance, world_position}
#ifdef SECOND_LOBE
#import lightwell::layers::tint_seen
#import lightwell::view::toward_eye
#endif
#ifdef HAZE
#import lightwell::haze_lookup::veil
#endif
#import lightwell::sky::sky_radiance
#import lightwell::view::{View, eye_distance}

struct Compose {
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the map [rad]
    sun_toward: vec3f,     // unit
    sun_cosine: f32,       // of half its angle; above 1: no disc is seen
    sun_radiance: vec3f,   // [W/(m² sr)]
}

const TOTAL: u32 = 0u;
const DIRECT: u32 = 1u;
const INDIRECT: u32 = 2u;
const ALBEDO: u32 = 3u;
const NORMAL: u32 = 4u;
const DEPTH: u32 = 5u;

// Known when the shader is compiled. Where a branch hangs on a uniform alone, Mesa's software driver (22.3) compiles the
// shader anew for each set of uniforms, every frame that the camera moves, and keeps all of them.
#ifdef LAYER
const LAYER: u32 = #{LAYER}u;
#else
const LAYER: u32 = TOTAL;
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> compose: Compose;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var emissive: texture_2d<u32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var direct: texture_2d_array<f32>;
@group(0) @binding(7) var indirect: texture_2d<f32>;
@group(0) @binding(9) var sky: texture_2d<f32>;
// What mirrors reflect, where that is no part of `indirect`.
@group(0) @binding(12) var mirrored: texture_2d<f32>;
#ifdef SECOND_LOBE
// What second lobes reflect beside the lights, over their tint, and what is in their geometry buffer.
@group(0) @binding(13) var second_lobe: texture_2d<f32>;
@group(0) @binding(14) var lobe_normal: texture_2d<u32>;
@group(0) @binding(15) var lobe_object: texture_2d<u32>;
#endif
#ifdef PARTICLES
// Particles: premultiplied radiance, and how much they hide of what lies behind.
@group(0) @binding(16) var particles: texture_2d<f32>;
#endif
// What surfaces reflect of the sky, where the indirect method has no light of it.
@group(0) @binding(11) var sky_light: texture_2d<f32>;
// Blended surfaces: premultiplied radiance, and how much they hide of what lies behind.
@group(0) @binding(10) var blended: texture_2d<f32>;
@group(0) @binding(8) var radiance: texture_storage_2d<rgba32float, write>;

// Sums over lights stay finite for any number of lights.
const MAX_RADIANCE: f32 = 1e32;

fn sky_at(pixel: vec2u) -> vec3f {
#ifdef SKY_MAP
    // The point at infinity, or on the far plane, in homogeneous coordinates.
    let at = (vec2f(pixel) + 0.5) / vec2f(view.size);
    let far = view.world_from_clip * vec4f(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0);
    let ahead = select(-view.eye.xyz, far.xyz - view.eye.xyz * far.w, view.eye.w > 0.0);
    let d = normalize(ahead);
    let is_sun = dot(d, compose.sun_toward) >= compose.sun_cosine;
    return sky_radiance(sky, d, compose.sky_turn) + select(vec3f(0.0), compose.sun_radiance, is_sun);
#else
    return compose.sky;
#endif
}

// What the pixel's second lobe reflects beside the lights.
fn of_second_lobe(pixel: vec2u, z: f32) -> vec3f {
#ifdef SECOND_LOBE
    let object = textureLoad(lobe_object, pixel, 0);
    if object.x == 0u {
        return vec3f(0.0);
    }
    let to_eye = toward_eye(view, world_position(pixel, view.size, z, view.world_from_clip));
    return textureLoad(second_lobe, pixel, 0).rgb * tint_seen(textureLoad(lobe_normal, pixel, 0), object, to_eye);
#else
    return vec3f(0.0);
#endif
}

fn shown(pixel: vec2u) -> vec3f {
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        return select(vec3f(0.0), sky_at(pixel), LAYER == TOTAL || LAYER == DIRECT);
    }
    let reflected = vec3f(
        textureLoad(direct, pixel, 0, 0).r, textureLoad(direct, pixel, 1, 0).r, textureLoad(direct, pixel, 2, 0).r,
    );
    let emitted = decode_radiance(textureLoad(emissive, pixel, 0).xy);
    let bounced = textureLoad(indirect, min(pixel, textureDimensions(indirect) - 1u), 0).rgb
        + textureLoad(mirrored, min(pixel, textureDimensions(mirrored) - 1u), 0).rgb
        + textureLoad(sky_light, min(pixel, textureDimensions(sky_light) - 1u), 0).rgb
        + of_second_lobe(pixel, z);
    switch LAYER {
        case DIRECT: { return reflected + emitted; }
        case INDIRECT: { return bounced; }
        case ALBEDO: { return decode_base_color(textureLoad(base_color, pixel, 0)); }
        case NORMAL: { return decode_normal(textureLoad(normal, pixel, 0)) * 0.5 + 0.5; }
        case DEPTH: { return vec3f(eye_distance(view, world_position(pixel, view.size, z, view.world_from_clip))); }
        default: { return reflected + emitted + bounced; }
    }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let over = textureLoad(blended, min(thread.xy, textureDimensions(blended) - 1u), 0);
    var seen = shown(thread.xy);
#ifdef HAZE
    let z = textureLoad(depth, thread.xy, 0);
    let position = world_position(thread.xy, view.size, max(z, 1e-30), view.world_from_clip);
    let between = veil(view, vec2f(thread.xy) + 0.5, position, z <= 0.0);
    seen = seen * between.passing + between.added;
#endif
#ifdef PARTICLES
    let discs = textureLoad(particles, thread.xy, 0);
    seen = seen * (1.0 - discs.a) + discs.rgb;
#endif
    let all = seen * (1.0 - over.a) + over.rgb;
    textureStore(radiance, thread.xy, vec4f(min(all, vec3f(MAX_RADIANCE)), 1.0));
}
