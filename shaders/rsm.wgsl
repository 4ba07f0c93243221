// Reflective shadow maps (Dachsbacher and Stamminger 2005): what a light sees, as the sources of indirect light.
// The position follows from the depth, the flux from the light and the texel's solid angle.

#import lightwell::gbuffer::{encode_base_color, encode_normal}
#import lightwell::mesh::{Vertex, Instance, Material, world_from_object_point, world_from_object_vector, world_from_object_normal, shading_normal, texture_point}

struct RsmView {
    clip_from_world: mat4x4f,
    eye: vec3f,
}

@group(0) @binding(0) var<uniform> view: RsmView;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;
@group(1) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(4) var metallic_roughness_sampler: sampler;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
}

@vertex
fn vertex(in: Vertex, @builtin(instance_index) index: u32) -> Varying {
    let instance = instances[index];
    var out: Varying;
    out.position = world_from_object_point(instance, in.position);
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    out.normal = world_from_object_normal(instance, in.normal);
    out.uv = in.uv;
    return out;
}

struct Targets {
    @location(0) base_color: vec4u,
    @location(1) normal: vec4u,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let at = texture_point(in.uv);
    let base = material.base_color * textureSampleGrad(base_color_texture, base_color_sampler, at.uv, at.dx, at.dy);
    let metallic_roughness = textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, at.uv, at.dx, at.dy);
    let flip = material.double_sided != 0u && !front;
    let n = shading_normal(in.normal, vec4f(0.0), in.position, vec3f(0.5, 0.5, 1.0), 0.0, flip, view.eye - in.position);
    if base.a < material.alpha_cutoff {
        discard;
    }
    // The back of a one-sided surface stops light and returns none.
    let reflects = front || material.double_sided != 0u;
    var out: Targets;
    out.base_color = encode_base_color(select(vec3f(0.0), base.rgb, reflects), saturate(material.metallic * metallic_roughness.b));
    out.normal = encode_normal(n, material.roughness * metallic_roughness.g, 0.0);
    return out;
}
