// Light of all pixels from one pixel of each square of four: each takes that of the four gathered ones around it, as far as
// they show the same surface (joint bilateral upsampling: Kopf et al. 2007), and says by its weight how much that counts. A
// pixel whose surface none of them shows has rays of its own, see lib/strays.wgsl.
//   TINTED    specular light is told over the tint of the lobe, see gather_filter.wgsl

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::interleave::{Interleave, pixel_of}
#import lightwell::inverse_distance::has_diffuse
#ifdef TINTED
#import lightwell::layers::tint_seen
#import lightwell::view::toward_eye
#endif
#import lightwell::strays::push_stray
#import lightwell::view::View

struct Upsample {
    view: View,
    @align(16) interleave: Interleave,
}

@group(0) @binding(0) var<uniform> upsample: Upsample;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
#ifdef TINTED
@group(0) @binding(7) var object: texture_2d<u32>;
#endif
@group(0) @binding(4) var diffuse: texture_2d<f32>;
@group(0) @binding(5) var specular: texture_2d<f32>;
// Reflected radiance [W/(m² sr)], and how much it counts beside that of other frames: 1 where all of it is the surface's own.
@group(0) @binding(6) var indirect: texture_storage_2d<rgba32float, write>;

// Weights of pixels of the same surface that suffice, so that no rays are cast. With more rays, the few of a frame replace what
// neighbours have filtered: at rest the error grows again from .6 on.
const ENOUGH: f32 = 0.05;
// Least weight by distance.
const LEAST: f32 = 1e-4;

struct Upsampled {
    diffuse: vec3f,
    specular: vec3f,
    like: f32,             // weights of pixels of the same surface
    mirrored: f32,         // of those whose light another pass brings
}

fn upsampled(pixel: vec2u, z: f32) -> Upsampled {
    let view = upsample.view;
    let grid = upsample.interleave;
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let n = decode_normal(textureLoad(normal, pixel, 0));
    let at = (vec2f(pixel) - vec2f(grid.offset)) / f32(grid.stride);
    let low = floor(at);
    let part = at - low;
    var sum = Upsampled(vec3f(0.0), vec3f(0.0), 0.0, 0.0);
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let texel = vec2u(clamp(vec2i(low) + corner, vec2i(0), vec2i(grid.texels) - 1));
        let other = pixel_of(grid, texel, view.size);
        let other_z = textureLoad(depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let share = select(1.0 - part, part, corner == vec2i(1));
        let other_position = world_position(other, view.size, other_z, view.world_from_clip);
        let like = likeness(position, n, other_position, decode_normal(textureLoad(normal, other, 0)));
        let weight = max(share.x * share.y, LEAST) * like;
        let found_diffuse = textureLoad(diffuse, texel, 0);
        let found_specular = textureLoad(specular, texel, 0);
        if has_diffuse(vec2f(found_diffuse.a, found_specular.a)) {
            sum.diffuse += weight * found_diffuse.rgb;
            sum.specular += weight * found_specular.rgb;
            sum.like += weight;
        } else {
            sum.mirrored += weight;
        }
    }
    let scale = 1.0 / max(sum.like, 1e-30);
    return Upsampled(scale * sum.diffuse, scale * sum.specular, sum.like, sum.mirrored);
}

fn reflected(pixel: vec2u, z: f32, light: Upsampled) -> vec3f {
    var specular_light = light.specular;
#ifdef TINTED
    let view = upsample.view;
    let to_eye = toward_eye(view, world_position(pixel, view.size, z, view.world_from_clip));
    specular_light *= tint_seen(textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0), to_eye);
#endif
    return min(decode_albedo(textureLoad(base_color, pixel, 0)) * light.diffuse + specular_light, vec3f(1e32));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= upsample.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    var radiance = vec4f(0.0, 0.0, 0.0, 1.0);
    if z > 0.0 {
        let light = upsampled(pixel, z);
        if light.like + light.mirrored < ENOUGH {
            push_stray(pixel);
        } else if light.like > light.mirrored {
            radiance = vec4f(reflected(pixel, z, light), min(light.like, 1.0));
        }
    }
    textureStore(indirect, pixel, radiance);
}
