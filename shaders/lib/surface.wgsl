#define_import_path lightwell::surface

// What the camera sees of a surface: its vertices and its material's textures, for all passes that draw the view.

#import lightwell::mesh::{Vertex, VertexExtra, Instance, Material, world_from_object_point, world_from_object_vector, world_from_object_normal, shading_normal, texture_point, mapped, emission_color}
#import lightwell::view::{View, toward_eye}

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
#ifndef PLAIN
@group(1) @binding(9) var specular_texture: texture_2d<f32>;
@group(1) @binding(10) var specular_sampler: sampler;
@group(1) @binding(11) var specular_color_texture: texture_2d<f32>;
@group(1) @binding(12) var specular_color_sampler: sampler;
#ifdef GLASS
@group(1) @binding(13) var transmission_texture: texture_2d<f32>;
@group(1) @binding(14) var transmission_sampler: sampler;
#endif
#endif

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) @interpolate(flat) id: u32,
#ifndef PLAIN
    @location(5) second_uv: vec2f,
    @location(6) color: vec4f,
#endif
}

fn varying_of(
    in: Vertex,
#ifndef PLAIN
    extra: VertexExtra,
#endif
    index: u32,
) -> Varying {
    let instance = instances[index];
    var out: Varying;
    out.position = world_from_object_point(instance, in.position);
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    out.normal = world_from_object_normal(instance, in.normal);
    out.tangent = vec4f(world_from_object_vector(instance, in.tangent.xyz), in.tangent.w);
    out.uv = in.uv;
#ifndef PLAIN
    out.second_uv = extra.second_uv;
    out.color = extra.color;
#endif
    out.id = instance.id;
    return out;
}

struct Sampled {
    base: vec4f,           // linear base colour and alpha
    normal: vec3f,         // world, unit
    emissive: vec3f,       // radiance [W/(m² sr)]
    normal_reflectance: vec3f, // F0
    grazing_reflectance: f32,  // F90
    metallic: f32,
    roughness: f32,
    transmission: f32,     // of light that is neither reflected nor a metal's
}

fn sample_material(in: Varying, front: bool) -> Sampled {
    // All textures are read before any branch, where derivatives are defined.
    let first = texture_point(in.uv);
#ifdef PLAIN
    let base_at = first;
    let rough_at = first;
    let normal_at = first;
    let glow_at = first;
    let color = vec4f(1.0);
    let specular = material.specular;
    let specular_color = material.specular_color;
#else
    let second = texture_point(in.second_uv);
    let base_at = mapped(material.uv_rows[0], material.uv_rows[1], first, second);
    let rough_at = mapped(material.uv_rows[2], material.uv_rows[3], first, second);
    let normal_at = mapped(material.uv_rows[4], material.uv_rows[5], first, second);
    let glow_at = mapped(material.uv_rows[6], material.uv_rows[7], first, second);
    let color = in.color;
    let s = mapped(material.uv_rows[8], material.uv_rows[9], first, second);
    let c = mapped(material.uv_rows[10], material.uv_rows[11], first, second);
    let specular = material.specular * textureSampleGrad(specular_texture, specular_sampler, s.uv, s.dx, s.dy).a;
    let specular_color = material.specular_color
        * textureSampleGrad(specular_color_texture, specular_color_sampler, c.uv, c.dx, c.dy).rgb;
#endif
    var transmission = 0.0;
#ifdef GLASS
    transmission = material.transmission;
#ifndef PLAIN
    let t = mapped(material.uv_rows[12], material.uv_rows[13], first, second);
    transmission *= textureSampleGrad(transmission_texture, transmission_sampler, t.uv, t.dx, t.dy).r;
#endif
#endif
    let base = material.base_color * color
        * textureSampleGrad(base_color_texture, base_color_sampler, base_at.uv, base_at.dx, base_at.dy);
    let metallic_roughness =
        textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, rough_at.uv, rough_at.dx, rough_at.dy);
    let bend = textureSampleGrad(normal_texture, normal_sampler, normal_at.uv, normal_at.dx, normal_at.dy).xyz;
    let glow = material.emissive * emission_color(material.uv_rows[7], color);
    var out: Sampled;
    out.emissive = glow
        * textureSampleGrad(emissive_texture, emissive_sampler, glow_at.uv, glow_at.dx, glow_at.dy).rgb;
    let flip = material.double_sided != 0u && !front;
    out.normal = shading_normal(in.normal, in.tangent, in.position, bend, material.normal_scale, flip, toward_eye(view, in.position));
    out.base = base;
    out.transmission = transmission;
    out.metallic = saturate(material.metallic * metallic_roughness.b);
    out.roughness = saturate(material.roughness * metallic_roughness.g);
    let dielectric = min(0.04 * specular_color, vec3f(1.0)) * specular;
    out.normal_reflectance = mix(dielectric, base.rgb, out.metallic);
    out.grazing_reflectance = mix(specular, 1.0, out.metallic);
    return out;
}
