// Geometry buffer: what each pixel sees. Encoding: lib/gbuffer.wgsl.

#import lightwell::gbuffer::{encode_base_color, encode_normal, encode_object, encode_radiance}
#import lightwell::mesh::{Vertex, VertexExtra, Instance, Material, is_cut_out}
#import lightwell::surface::{Varying, varying_of, sample_material, material}
#import lightwell::view::View

@vertex
fn vertex(
    in: Vertex,
#ifndef PLAIN
    extra: VertexExtra,
#endif
    @builtin(instance_index) index: u32,
) -> Varying {
#ifdef PLAIN
    return varying_of(in, index);
#else
    return varying_of(in, extra, index);
#endif
}

struct Targets {
    @location(0) base_color: vec4u,
    @location(1) normal: vec4u,
    @location(2) emissive: vec2u,
    @location(3) object: vec2u,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let s = sample_material(in, front);
    if is_cut_out(material, s.base.a) {
        discard;
    }
    var out: Targets;
    out.base_color = encode_base_color(s.base.rgb, s.metallic);
    out.normal = encode_normal(s.normal, s.roughness, s.grazing_reflectance);
    out.emissive = encode_radiance(s.emissive);
    out.object = encode_object(in.id, s.normal_reflectance);
    return out;
}
