// Geometry buffer: what each pixel sees. Encoding: lib/gbuffer.wgsl.

#import lightwell::gbuffer::{encode_base_color, encode_normal, encode_object, encode_radiance}
#import lightwell::mesh::{Vertex, Instance, Material, world_from_object_point, world_from_object_vector, world_from_object_normal, shading_normal, texture_point}
#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;
@group(1) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(4) var metallic_roughness_sampler: sampler;
@group(1) @binding(5) var normal_texture: texture_2d<f32>;
@group(1) @binding(6) var normal_sampler: sampler;
@group(1) @binding(7) var emissive_texture: texture_2d<f32>;
@group(1) @binding(8) var emissive_sampler: sampler;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) @interpolate(flat) id: u32,
}

@vertex
fn vertex(in: Vertex, @builtin(instance_index) index: u32) -> Varying {
    let instance = instances[index];
    var out: Varying;
    out.position = world_from_object_point(instance, in.position);
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    out.normal = world_from_object_normal(instance, in.normal);
    out.tangent = vec4f(world_from_object_vector(instance, in.tangent.xyz), in.tangent.w);
    out.uv = in.uv;
    out.id = instance.id;
    return out;
}

struct Targets {
    @location(0) base_color: vec4u,
    @location(1) normal: vec4u,
    @location(2) emissive: vec2u,
    @location(3) object: vec2u,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let at = texture_point(in.uv);
    // All textures are read before any branch, where derivatives are defined.
    let base = material.base_color * textureSampleGrad(base_color_texture, base_color_sampler, at.uv, at.dx, at.dy);
    let metallic_roughness = textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, at.uv, at.dx, at.dy);
    let bend = textureSampleGrad(normal_texture, normal_sampler, at.uv, at.dx, at.dy).xyz;
    let emissive = material.emissive * textureSampleGrad(emissive_texture, emissive_sampler, at.uv, at.dx, at.dy).rgb;
    let flip = material.double_sided != 0u && !front;
    let n = shading_normal(in.normal, in.tangent, in.position, bend, material.normal_scale, flip, view.eye - in.position);
    if base.a < material.alpha_cutoff {
        discard;
    }
    let metallic = saturate(material.metallic * metallic_roughness.b);
    let dielectric = min(0.04 * material.specular_color, vec3f(1.0)) * material.specular;
    let f0 = mix(dielectric, base.rgb, metallic);
    let f90 = mix(material.specular, 1.0, metallic);
    var out: Targets;
    out.base_color = encode_base_color(base.rgb, metallic);
    out.normal = encode_normal(n, material.roughness * metallic_roughness.g, f90);
    out.emissive = encode_radiance(emissive);
    out.object = encode_object(in.id, f0);
    return out;
}
