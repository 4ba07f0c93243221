// Reflective shadow maps (Dachsbacher and Stamminger 2005): what a light sees, as the sources of indirect light.
// The position follows from the depth, the flux from the light and the texel's solid angle.

#import lightwell::gbuffer::{encode_base_color, encode_normal, encode_object}
#import lightwell::mesh::{Vertex, VertexExtra, Instance, Material, world_from_object_point, world_from_object_vector, world_from_object_normal, shading_normal, texture_point, mapped, is_cut_out_for_lights}

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
#ifndef PLAIN
@group(1) @binding(5) var specular_texture: texture_2d<f32>;
@group(1) @binding(6) var specular_sampler: sampler;
@group(1) @binding(7) var specular_color_texture: texture_2d<f32>;
@group(1) @binding(8) var specular_color_sampler: sampler;
#endif

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
#ifndef PLAIN
    @location(3) second_uv: vec2f,
    @location(4) color: vec4f,
#endif
}

@vertex
fn vertex(
    in: Vertex,
#ifndef PLAIN
    extra: VertexExtra,
#endif
    @builtin(instance_index) index: u32,
) -> Varying {
    let instance = instances[index];
    var out: Varying;
    out.position = world_from_object_point(instance, in.position);
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    out.normal = world_from_object_normal(instance, in.normal);
    out.uv = in.uv;
#ifndef PLAIN
    out.second_uv = extra.second_uv;
    out.color = extra.color;
#endif
    return out;
}

struct Targets {
    @location(0) base_color: vec4u,
    @location(1) normal: vec4u,
    @location(2) specular: u32,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let first = texture_point(in.uv);
#ifdef PLAIN
    let base_at = first;
    let rough_at = first;
    let color = vec4f(1.0);
    let specular = material.specular;
    let specular_color = material.specular_color;
#else
    let second = texture_point(in.second_uv);
    let base_at = mapped(material.uv_rows[0], material.uv_rows[1], first, second);
    let rough_at = mapped(material.uv_rows[2], material.uv_rows[3], first, second);
    let color = in.color;
    let s = mapped(material.uv_rows[8], material.uv_rows[9], first, second);
    let c = mapped(material.uv_rows[10], material.uv_rows[11], first, second);
    let specular = material.specular * textureSampleGrad(specular_texture, specular_sampler, s.uv, s.dx, s.dy).a;
    let specular_color = material.specular_color
        * textureSampleGrad(specular_color_texture, specular_color_sampler, c.uv, c.dx, c.dy).rgb;
#endif
    let base = material.base_color * color
        * textureSampleGrad(base_color_texture, base_color_sampler, base_at.uv, base_at.dx, base_at.dy);
    let metallic_roughness =
        textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, rough_at.uv, rough_at.dx, rough_at.dy);
    let flip = material.double_sided != 0u && !front;
    let n = shading_normal(in.normal, vec4f(0.0), in.position, vec3f(0.5, 0.5, 1.0), 0.0, flip, view.eye - in.position);
    if is_cut_out_for_lights(material, base.a) {
        discard;
    }
    // The back of a one-sided surface stops light and returns none.
    let reflects = front || material.double_sided != 0u;
    var out: Targets;
    let metallic = saturate(material.metallic * metallic_roughness.b);
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    let share = select(0.0, 1.0, reflects);
    // Without the layers' textures, and for all directions alike: the flux goes to all.
    let diffuse = base.rgb * material.even_layers.a + material.even_layers.rgb;
    out.base_color = encode_base_color(share * diffuse, metallic);
    out.normal = encode_normal(n, material.roughness * metallic_roughness.g, share * mix(specular, 1.0, metallic));
    out.specular = encode_object(0u, share * mix(dielectric, base.rgb, metallic)).y;
    return out;
}
