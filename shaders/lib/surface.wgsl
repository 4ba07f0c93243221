#define_import_path lightwell::surface

// What the camera sees of a surface: its vertices and its material's textures, for all passes that draw the view.
//   LAYERED   the surface has layers, see lib/layers.wgsl: what they reflect diffusely is in the base colour, and what they take
//             is out of the base; a film shows in F0. Second lobes are drawn apart, by geometry/second_lobe.wgsl
//   FORWARD   of the layers there is only the film: what shows what lies behind has no others

#ifdef LAYERED
#import lightwell::brdf::fresnel_schlick
#import lightwell::layers::{stretched_alpha, coat_reflectance, film_reflectance, left_by_sheen, reflectance_of_film, albedo_of_sheen}
#endif
#import lightwell::mesh::{Vertex, VertexExtra, Instance, Material, world_from_object_point, world_from_object_tangent, world_from_object_normal, shading_normal, texture_point, mapped, emission_color}
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
#ifdef LAYERED
@group(1) @binding(15) var iridescence_texture: texture_2d<f32>;
@group(1) @binding(16) var iridescence_sampler: sampler;
@group(1) @binding(17) var iridescence_thickness_texture: texture_2d<f32>;
@group(1) @binding(18) var iridescence_thickness_sampler: sampler;
#ifndef FORWARD
@group(1) @binding(19) var clearcoat_texture: texture_2d<f32>;
@group(1) @binding(20) var clearcoat_sampler: sampler;
@group(1) @binding(21) var clearcoat_roughness_texture: texture_2d<f32>;
@group(1) @binding(22) var clearcoat_roughness_sampler: sampler;
@group(1) @binding(23) var clearcoat_normal_texture: texture_2d<f32>;
@group(1) @binding(24) var clearcoat_normal_sampler: sampler;
@group(1) @binding(25) var sheen_color_texture: texture_2d<f32>;
@group(1) @binding(26) var sheen_color_sampler: sampler;
@group(1) @binding(27) var sheen_roughness_texture: texture_2d<f32>;
@group(1) @binding(28) var sheen_roughness_sampler: sampler;
@group(1) @binding(29) var anisotropy_texture: texture_2d<f32>;
@group(1) @binding(30) var anisotropy_sampler: sampler;
#endif
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
    out.tangent = world_from_object_tangent(instance, in.tangent);
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
#ifdef LAYERED
    lobe_normal: vec3f,    // F0 and F90 of a stretched lobe, which the surface then has not itself
    lobe_grazing: f32,
    alpha_along: f32,      // its GGX α along its direction
#endif
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
#ifdef LAYERED
    let layers = sample_layers(in, flip);
    add_layers(&out, layers, normalize(toward_eye(view, in.position)));
#endif
    return out;
}

#ifdef LAYERED
struct Layers {
    film: f32,             // share of the surface
    film_thickness: f32,   // [nm]
    coat: f32,             // share of the surface
    coat_roughness: f32,
    coat_normal: vec3f,    // world, unit
    sheen: vec3f,
    sheen_roughness: f32,
    stretch: f32,          // strength of the anisotropy
    stretch_turn: vec2f,   // its direction from the tangent, not of unit length
}

// The layers as the material and its textures have them.
fn sample_layers(in: Varying, flip: bool) -> Layers {
    var out: Layers;
    out.film = material.iridescence;
    out.film_thickness = material.film.z;
#ifndef FORWARD
    out.coat = material.clearcoat;
    out.coat_roughness = material.clearcoat_roughness;
    out.sheen = material.sheen_color;
    out.sheen_roughness = material.sheen_roughness;
    out.stretch = material.anisotropy.x;
    out.stretch_turn = material.anisotropy.yz;
#endif
    var coat_bend = vec3f(0.5, 0.5, 1.0);
#ifndef PLAIN
    let first = texture_point(in.uv);
    let second = texture_point(in.second_uv);
    let film_at = mapped(material.uv_rows[26], material.uv_rows[27], first, second);
    let thickness_at = mapped(material.uv_rows[28], material.uv_rows[29], first, second);
    out.film *= textureSampleGrad(iridescence_texture, iridescence_sampler, film_at.uv, film_at.dx, film_at.dy).r;
    let thickness = textureSampleGrad(
        iridescence_thickness_texture, iridescence_thickness_sampler, thickness_at.uv, thickness_at.dx, thickness_at.dy,
    ).g;
    out.film_thickness = mix(material.film.y, material.film.z, thickness);
#ifndef FORWARD
    let coat_at = mapped(material.uv_rows[14], material.uv_rows[15], first, second);
    let rough_at = mapped(material.uv_rows[16], material.uv_rows[17], first, second);
    let bend_at = mapped(material.uv_rows[18], material.uv_rows[19], first, second);
    let sheen_at = mapped(material.uv_rows[20], material.uv_rows[21], first, second);
    let fibre_at = mapped(material.uv_rows[22], material.uv_rows[23], first, second);
    let stretch_at = mapped(material.uv_rows[24], material.uv_rows[25], first, second);
    out.coat *= textureSampleGrad(clearcoat_texture, clearcoat_sampler, coat_at.uv, coat_at.dx, coat_at.dy).r;
    out.coat_roughness *=
        textureSampleGrad(clearcoat_roughness_texture, clearcoat_roughness_sampler, rough_at.uv, rough_at.dx, rough_at.dy).g;
    coat_bend =
        textureSampleGrad(clearcoat_normal_texture, clearcoat_normal_sampler, bend_at.uv, bend_at.dx, bend_at.dy).xyz;
    out.sheen *= textureSampleGrad(sheen_color_texture, sheen_color_sampler, sheen_at.uv, sheen_at.dx, sheen_at.dy).rgb;
    out.sheen_roughness *=
        textureSampleGrad(sheen_roughness_texture, sheen_roughness_sampler, fibre_at.uv, fibre_at.dx, fibre_at.dy).a;
    let stretch = textureSampleGrad(anisotropy_texture, anisotropy_sampler, stretch_at.uv, stretch_at.dx, stretch_at.dy).rgb;
    let d = stretch.rg * 2.0 - 1.0;
    let turn = material.anisotropy.yz;
    out.stretch *= stretch.b;
    out.stretch_turn = vec2f(d.x * turn.x - d.y * turn.y, d.x * turn.y + d.y * turn.x);
#endif
#endif
    out.coat_normal = shading_normal(
        in.normal, in.tangent, in.position, coat_bend, material.clearcoat_normal_scale, flip, toward_eye(view, in.position),
    );
    return out;
}

// Folds the layers into the base, seen from a unit direction.
fn add_layers(s: ptr<function, Sampled>, layers: Layers, to_eye: vec3f) {
    let n_dot_v = abs(dot((*s).normal, to_eye));
    if layers.film > 0.0 {
        let seen = film_reflectance((*s).normal_reflectance, material.film.x, layers.film_thickness, n_dot_v);
        let of_film = reflectance_of_film(seen, (*s).grazing_reflectance, n_dot_v);
        (*s).normal_reflectance = mix((*s).normal_reflectance, of_film, layers.film);
    }
    let above = 1.0 - coat_reflectance(layers.coat, abs(dot(layers.coat_normal, to_eye)));
    let sheen = albedo_of_sheen(layers.sheen_roughness, n_dot_v);
    let left = left_by_sheen(layers.sheen, sheen) * above;
    (*s).normal_reflectance *= left;
    (*s).grazing_reflectance *= left;
    (*s).emissive *= above;
    if any(layers.sheen > vec3f(0.0)) {
        // As a diffuse reflection: metals have one then. What the base's lobe takes from that is none of the sheen's.
        let f = (*s).normal_reflectance;
        let added = layers.sheen * (sheen * above / max(1.0 - max(f.r, max(f.g, f.b)), 0.25));
        (*s).base = vec4f(saturate((*s).base.rgb * ((1.0 - (*s).metallic) * left) + added), (*s).base.a);
        (*s).metallic = 0.0;
    } else {
        (*s).base = vec4f((*s).base.rgb * left, (*s).base.a);
    }
    // A round lobe as high as the stretched one.
    let alpha = max((*s).roughness * (*s).roughness, 1e-3);
    (*s).alpha_along = stretched_alpha(alpha, saturate(layers.stretch));
    if layers.stretch > 0.0 {
        (*s).roughness = sqrt(sqrt(alpha * (*s).alpha_along));
    }
    if has_stretched_lobe(layers) {
        take_lobe(s, n_dot_v);
    }
}

// Whether the base's lobe is drawn apart.
fn has_stretched_lobe(layers: Layers) -> bool {
    return layers.stretch > 0.0 && layers.coat <= 0.0;
}

// Leaves the diffuse part alone, less what the lobe takes from it.
fn take_lobe(s: ptr<function, Sampled>, n_dot_v: f32) {
    (*s).lobe_normal = (*s).normal_reflectance;
    (*s).lobe_grazing = (*s).grazing_reflectance;
    let f = fresnel_schlick((*s).lobe_normal, (*s).lobe_grazing, n_dot_v);
    (*s).base = vec4f((*s).base.rgb * (1.0 - max(f.r, max(f.g, f.b))), (*s).base.a);
    (*s).normal_reflectance = vec3f(0.0);
    (*s).grazing_reflectance = 0.0;
}
#endif
