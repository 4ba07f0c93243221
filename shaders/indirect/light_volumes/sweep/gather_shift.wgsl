// Light of an image from what another one has gathered, whose pixel grid is shifted by parts of a pixel: each pixel takes that
// of the four gathered ones around it, as far as they show the same surface (joint bilateral upsampling: Kopf et al. 2007), or
// where none of them does, of those farther off. So edges are sampled at many places, and rays are cast for one. A pixel whose
// surface none of those shows has rays of its own, see lib/strays.wgsl.
//   TINTED    specular light is told over the tint of the lobe, see gather_filter.wgsl

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::inverse_distance::has_diffuse
#import lightwell::strays::push_stray
#ifdef TINTED
#import lightwell::layers::tint_seen
#import lightwell::view::toward_eye
#endif
#import lightwell::view::View

struct Shift {
    view: View,
    gathered: View,        // of the image that was gathered
}

@group(0) @binding(0) var<uniform> shift: Shift;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
#ifdef TINTED
@group(0) @binding(4) var object: texture_2d<u32>;
#endif
@group(0) @binding(5) var gathered_normal: texture_2d<u32>;
@group(0) @binding(6) var gathered_depth: texture_depth_2d;
@group(0) @binding(7) var diffuse: texture_2d<f32>;
@group(0) @binding(8) var specular: texture_2d<f32>;
// Reflected radiance [W/(m² sr)].
@group(0) @binding(9) var indirect: texture_storage_2d<rgba32float, write>;

// Weights of pixels of the same surface that suffice, so that none farther off is asked.
const ENOUGH: f32 = 0.05;
// How far off that is at most [pixels].
const FARTHEST: i32 = 4;
// Least weight by distance.
const LEAST: f32 = 1e-4;

struct Found {
    diffuse: vec3f,
    specular: vec3f,
    like: f32,             // weights of pixels of the same surface
    mirrored: f32,         // of those whose light another pass brings
}

// Where the gathered image shows a point [pixels].
fn place_in_gathered(position: vec3f) -> vec2f {
    let clip = shift.gathered.clip_from_world * vec4f(position, 1.0);
    let uv = clip.xy / max(clip.w, 1e-30) * vec2f(0.5, -0.5) + 0.5;
    return uv * vec2f(shift.gathered.size) - 0.5;
}

// What the pixels within a distance of a place know of the light of a surface there.
fn found_within(reach: i32, at: vec2f, position: vec3f, n: vec3f) -> Found {
    let low = vec2i(floor(at));
    var sum = Found(vec3f(0.0), vec3f(0.0), 0.0, 0.0);
    for (var i = 0; i < 4 * reach * reach; i++) {
        let texel = low + vec2i(i % (2 * reach), i / (2 * reach)) - (reach - 1);
        let other = vec2u(clamp(texel, vec2i(0), vec2i(shift.gathered.size) - 1));
        let other_z = textureLoad(gathered_depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let other_position = world_position(other, shift.gathered.size, other_z, shift.gathered.world_from_clip);
        let like = likeness(position, n, other_position, decode_normal(textureLoad(gathered_normal, other, 0)));
        let tent = max(1.0 - abs(vec2f(texel) - at) / f32(reach), vec2f(0.0));
        let weight = max(tent.x * tent.y, LEAST) * like;
        let found_diffuse = textureLoad(diffuse, other, 0);
        let found_specular = textureLoad(specular, other, 0);
        if has_diffuse(vec2f(found_diffuse.a, found_specular.a)) {
            sum.diffuse += weight * found_diffuse.rgb;
            sum.specular += weight * found_specular.rgb;
            sum.like += weight;
        } else {
            sum.mirrored += weight;
        }
    }
    return sum;
}

fn light_at(position: vec3f, n: vec3f) -> Found {
    let at = place_in_gathered(position);
    var found = found_within(1, at, position, n);
    for (var reach = 2; reach <= FARTHEST && found.like + found.mirrored < ENOUGH; reach++) {
        found = found_within(reach, at, position, n);
    }
    let scale = 1.0 / max(found.like, 1e-30);
    return Found(scale * found.diffuse, scale * found.specular, found.like, found.mirrored);
}

fn reflected(pixel: vec2u, position: vec3f, light: Found) -> vec3f {
    var specular_light = light.specular;
#ifdef TINTED
    let to_eye = toward_eye(shift.view, position);
    specular_light *= tint_seen(textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0), to_eye);
#endif
    return min(decode_albedo(textureLoad(base_color, pixel, 0)) * light.diffuse + specular_light, vec3f(1e32));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= shift.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    var radiance = vec3f(0.0);
    if z > 0.0 {
        let position = world_position(pixel, shift.view.size, z, shift.view.world_from_clip);
        let light = light_at(position, decode_normal(textureLoad(normal, pixel, 0)));
        if light.like + light.mirrored < ENOUGH {
            push_stray(pixel);
        } else if light.like > light.mirrored {
            radiance = reflected(pixel, position, light);
        }
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
