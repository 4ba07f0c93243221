// Sums virtual lights over the G-buffer: all of them in one pass, so that a pixel's surface is read once.
//   UNSHADOWED  lights shine through everything; else a ray for each pixel and light (Keller's full method)
//   PUBLISHED   the report's formula
//   MATTE       as in lib/vpl.wgsl

#import lightwell::gbuffer::{Surface, decode_surface, world_position}
#import lightwell::view::{View, position_error, toward_eye}
#import lightwell::vpl::{VirtualLight, Connection, connect, connect_as_published, shadow_origin}
#ifndef UNSHADOWED
#import lightwell::ray_scene::NONE
#import lightwell::rays::{Ray, SHADOW}
#import lightwell::walk::{passed, trace}
#endif

struct Shade {
    first: u32,            // light of this dispatch
    end: u32,
    root: u32,             // of the hierarchy
    begin: u32,            // 1: nothing was summed before
    finish: u32,           // 1: the sum is complete
    scale: f32,            // of the finished sum
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> shade: Shade;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var object: texture_2d<u32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var<storage, read> virtual_lights: array<VirtualLight>;
@group(0) @binding(7) var sums: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(8) var indirect: texture_storage_2d<rgba32float, write>;

fn contribution(light: VirtualLight, surface: Surface, to_eye: vec3f, origin: vec3f) -> vec3f {
#ifdef PUBLISHED
    let c = connect_as_published(light, surface);
#else
    let c = connect(light, surface, to_eye);
#endif
#ifndef UNSHADOWED
    if all(c.radiance <= vec3f(0.0)) {
        return vec3f(0.0);
    }
    let ray = Ray(origin, select(c.end - origin, c.to_light, c.distant));
    let hit = trace(shade.root, ray, select(1.0, 3e38, c.distant), SHADOW);
    if hit.triangle != NONE {
        return vec3f(0.0);
    }
    return c.radiance * passed(ray, hit);
#else
    return c.radiance;
#endif
}

fn summed(pixel: vec2u) -> vec3f {
    var sum = vec3f(0.0);
    if shade.begin == 0u {
        sum = vec3f(textureLoad(sums, pixel, 0).r, textureLoad(sums, pixel, 1).r, textureLoad(sums, pixel, 2).r);
    }
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        return sum;
    }
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    let to_eye = normalize(toward_eye(view, position));
    let origin = shadow_origin(surface, position_error(view, position));
    // Added one by one: in whatever pieces, the sum gets the same bits.
    for (var i = shade.first; i < shade.end; i++) {
        sum += contribution(virtual_lights[i], surface, to_eye, origin);
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let sum = summed(thread.xy);
    if shade.finish == 0u {
        for (var channel = 0u; channel < 3u; channel++) {
            textureStore(sums, thread.xy, channel, vec4f(sum[channel], 0.0, 0.0, 0.0));
        }
    } else {
        textureStore(indirect, thread.xy, vec4f(sum * shade.scale, 1.0));
    }
}
