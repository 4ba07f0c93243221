#define LAYERED
// Lobes beside those of the geometry buffer, as a second surface of the pixels that show them: a geometry buffer of its own (see
// lib/gbuffer.wgsl) of black surfaces that have a specular lobe alone. A pixel has one: that of the clear coat, or where there is
// none the stretched one of the base.
//   The coat's F0 and F90 are both what it reflects towards the eye, so that its lobe is D·V times that, as
//   KHR_materials_clearcoat has it.
//   The stretched lobe's base colour holds its direction and the GGX α along it; its roughness is that of a round lobe as high, for
//   passes that know no others.

#import lightwell::gbuffer::{encode_base_color, encode_normal, encode_object, encode_stretch}
#import lightwell::layers::{coat_reflectance, stretch_direction}
#import lightwell::mesh::{Vertex, VertexExtra, is_cut_out}
#import lightwell::surface::{Varying, has_stretched_lobe, material, sample_layers, sample_material, varying_of, view}
#import lightwell::view::toward_eye

// What of the scene's own geometry buffer each pixel shows.
@group(0) @binding(2) var seen: texture_2d<u32>;

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
    @location(2) object: vec2u,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let layers = sample_layers(in, material.double_sided != 0u && !front);
    let s = sample_material(in, front);
    let is_hidden = textureLoad(seen, vec2u(in.clip.xy), 0).x != in.id || is_cut_out(material, s.base.a);
    if is_hidden || (layers.coat <= 0.0 && !has_stretched_lobe(layers)) {
        discard;
    }
    var out: Targets;
    if layers.coat > 0.0 {
        let reflectance = coat_reflectance(layers.coat, abs(dot(layers.coat_normal, normalize(toward_eye(view, in.position)))));
        out.base_color = encode_base_color(vec3f(0.0), 0.0);
        out.normal = encode_normal(layers.coat_normal, layers.coat_roughness, reflectance);
        out.object = encode_object(in.id, vec3f(reflectance));
    } else {
        let along = stretch_direction(s.normal, in.tangent.xyz, in.tangent.w, layers.stretch_turn);
        out.base_color = encode_stretch(along, s.alpha_along);
        out.normal = encode_normal(s.normal, s.roughness, s.lobe_grazing);
        out.object = encode_object(in.id, s.lobe_normal);
    }
    return out;
}
