// One virtual light over the whole scene, drawn once more and blended additively where the depth is equal: the
// report's accumulation. What it adds is computed as in shade.wgsl, so that both give the same image to rounding.
//   UNSHADOWED, PUBLISHED, MATTE as there

#import lightwell::gbuffer::{Surface, decode_surface, world_position}
#import lightwell::mesh::{Vertex, Instance, world_from_object_point}
#import lightwell::view::{View, position_error, toward_eye}
#import lightwell::vpl::{VirtualLight, Connection, connect, connect_as_published, shadow_origin}
#ifndef UNSHADOWED
#import lightwell::ray_scene::NONE
#import lightwell::rays::{Ray, SHADOW}
#import lightwell::walk::{passed, trace}
#endif

struct Letter {
    index: u32,            // of the light
    root: u32,             // of the hierarchy
    scale: f32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
// Group 1: the scene for rays.
@group(2) @binding(0) var base_color: texture_2d<u32>;
@group(2) @binding(1) var normal: texture_2d<u32>;
@group(2) @binding(2) var object: texture_2d<u32>;
@group(2) @binding(3) var depth: texture_depth_2d;
@group(2) @binding(4) var<storage, read> virtual_lights: array<VirtualLight>;
@group(3) @binding(0) var<uniform> letter: Letter;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) id: u32,
}

@vertex
fn vertex(in: Vertex, @builtin(instance_index) index: u32) -> Varying {
    let instance = instances[index];
    let position = world_from_object_point(instance, in.position);
    return Varying(view.clip_from_world * vec4f(position, 1.0), instance.id);
}

@fragment
fn add_light(in: Varying) -> @location(0) vec4f {
    let pixel = vec2u(in.clip.xy);
    // Where two objects meet at the same depth, the one that the G-buffer holds.
    if textureLoad(object, pixel, 0).x != in.id {
        return vec4f(0.0);
    }
    let z = textureLoad(depth, pixel, 0);
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    let light = virtual_lights[letter.index];
#ifdef PUBLISHED
    var c = connect_as_published(light, surface);
#else
    var c = connect(light, surface, normalize(toward_eye(view, position)));
#endif
#ifndef UNSHADOWED
    if any(c.radiance > vec3f(0.0)) {
        let origin = shadow_origin(surface, position_error(view, position));
        let ray = Ray(origin, select(c.end - origin, c.to_light, c.distant));
        let hit = trace(letter.root, ray, select(1.0, 3e38, c.distant), SHADOW);
        if hit.triangle != NONE {
            return vec4f(0.0);
        }
        c.radiance *= passed(ray, hit);
    }
#endif
    return vec4f(c.radiance * letter.scale, 0.0);
}
