// Shadow maps. Perspective views (spot, point) store 1 − distance/far, so that one texel of depth means the same
// length everywhere; directional views store their linear, reversed depth. Nearer is larger in both.

#import lightwell::mesh::{Vertex, VertexExtra, Instance, Material, world_from_object_point, texture_point, mapped, is_cut_out_for_lights}

struct ShadowView {
    clip_from_world: mat4x4f,
    eye: vec3f,
    far: f32,
}

@group(0) @binding(0) var<uniform> view: ShadowView;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) uv: vec2f,
#ifndef PLAIN
    @location(2) second_uv: vec2f,
    @location(3) color: vec4f,
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
    var out: Varying;
    out.position = world_from_object_point(instances[index], in.position);
    out.clip = view.clip_from_world * vec4f(out.position, 1.0);
    out.uv = in.uv;
#ifndef PLAIN
    out.second_uv = extra.second_uv;
    out.color = extra.color;
#endif
    return out;
}

fn drop_transparent(in: Varying) {
#ifdef PLAIN
    let at = texture_point(in.uv);
    let vertex_alpha = 1.0;
#else
    let second = texture_point(in.second_uv);
    let at = mapped(material.uv_rows[0], material.uv_rows[1], texture_point(in.uv), second);
    let vertex_alpha = in.color.a;
#endif
    let texel = textureSampleGrad(base_color_texture, base_color_sampler, at.uv, at.dx, at.dy);
    let alpha = material.base_color.a * vertex_alpha * texel.a;
    if is_cut_out_for_lights(material, alpha) {
        discard;
    }
}

fn stored_distance(position: vec3f) -> f32 {
    return saturate(1.0 - distance(position, view.eye) / view.far);
}

@fragment
fn perspective_opaque(in: Varying) -> @builtin(frag_depth) f32 {
    return stored_distance(in.position);
}

@fragment
fn perspective_masked(in: Varying) -> @builtin(frag_depth) f32 {
    drop_transparent(in);
    return stored_distance(in.position);
}

@fragment
fn directional_masked(in: Varying) {
    drop_transparent(in);
}
