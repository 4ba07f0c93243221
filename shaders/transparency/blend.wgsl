// Blended surfaces over what lies behind them: α·L + (1 − α)·B, from the farthest to the nearest. The target holds
// Σ α·L and 1 − Π(1 − α), which compose puts over the opaque image.
//   PATCHED, SWEPT, PROPAGATED, AMBIENT   where the indirect light is looked up; none of them: there is none
//   GLASS                        the surface is of glass: what passes it and what it reflects is that of glass.wgsl
//   SEEN_THROUGH                 there are rays for it; without, what lies straight behind shows through
//   FORWARD                      set by the pass, for the bindings of the libraries

#import lightwell::brdf::eval_brdf_cosine
#import lightwell::direct::through_media
#import lightwell::lights::{Light, light_incidence}
#import lightwell::mesh::{BLENDED, Vertex, VertexExtra, OPAQUE_ALPHA}
#import lightwell::shadow_lookup::{Shadow, ShadowCoordinate, NO_SHADOW, shadow_coordinate, shadow_receiver}
#import lightwell::surface::{Varying, Sampled, material, varying_of, sample_material, view}
#import lightwell::view::toward_eye
#ifdef HAZE
#import lightwell::haze_lookup::veil
#endif
#ifdef PATCHED
#import lightwell::environment::lobe_reflectance
#import lightwell::visible_patches::irradiance_of_patches
#endif
#ifdef SWEPT
#import lightwell::environment::{lobe_reflectance, lobe_direction}
#import lightwell::sweep_lookup::{irradiance, irradiance_around}
#import lightwell::volume::Volume
#endif
#ifdef GLASS
#import lightwell::gbuffer::world_position
#endif
#ifdef PROPAGATED
#import lightwell::relight::propagated_irradiance
#endif

struct Blend {
    lights: array<Light, 4>,
    shadows: array<Shadow, 4>,
    light_count: u32,
    is_first: u32,         // of the draws of a surface: the one that covers what lies behind
    has_emission: u32,
    patch_size: f32,       // edge of a patch [m]
}

@group(2) @binding(0) var<uniform> blend: Blend;
@group(2) @binding(1) var shadow_first: texture_depth_2d_array;
@group(2) @binding(2) var shadow_second: texture_depth_2d_array;
@group(2) @binding(3) var shadow_third: texture_depth_2d_array;
@group(2) @binding(4) var shadow_fourth: texture_depth_2d_array;
@group(2) @binding(5) var shadow_sampler: sampler_comparison;
#ifdef SWEPT
@group(3) @binding(0) var<uniform> swept: Volume;
#endif
#ifdef SEEN_THROUGH
// Radiance, and how far from the near plane that glass is [m]; 0: there is none.
@group(3) @binding(20) var seen_through: texture_2d<f32>;
#endif
#ifdef AMBIENT
@group(3) @binding(0) var<storage, read> ambient: vec4f;
#endif

// How much farther than the nearest glass a surface may be that shows it.
const SAME_GLASS: f32 = 1e-3;
// As what compose writes: sums stay finite for whatever number of lights.
const MAX_RADIANCE: f32 = 1e32;

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

fn compare(index: u32, at: ShadowCoordinate) -> f32 {
    switch index {
        case 0u: { return textureSampleCompareLevel(shadow_first, shadow_sampler, at.uv, at.face, at.depth); }
        case 1u: { return textureSampleCompareLevel(shadow_second, shadow_sampler, at.uv, at.face, at.depth); }
        case 2u: { return textureSampleCompareLevel(shadow_third, shadow_sampler, at.uv, at.face, at.depth); }
        default: { return textureSampleCompareLevel(shadow_fourth, shadow_sampler, at.uv, at.face, at.depth); }
    }
}

fn direct_light(s: Sampled, position: vec3f, to_eye: vec3f) -> vec3f {
    let albedo = s.base.rgb * ((1.0 - s.metallic) * (1.0 - s.transmission));
    let alpha = max(s.roughness * s.roughness, 1e-3);
    var sum = vec3f(0.0);
    for (var i = 0u; i < blend.light_count; i++) {
        let incidence = through_media(light_incidence(blend.lights[i], position), position);
        if all(incidence.irradiance <= vec3f(0.0)) || dot(s.normal, incidence.to_light) <= 0.0 {
            continue;
        }
        var lit = 1.0;
        if blend.shadows[i].view.kind != NO_SHADOW {
            let receiver = shadow_receiver(blend.shadows[i].view, position, s.normal, incidence.to_light);
            let matrix = blend.shadows[i].faces[receiver.face].clip_from_world;
            let at = shadow_coordinate(blend.shadows[i].view, matrix, receiver);
            if at.inside {
                lit = compare(i, at);
            }
        }
        let response = eval_brdf_cosine(
            s.normal, to_eye, incidence.to_light, albedo, s.normal_reflectance, s.grazing_reflectance, alpha,
        );
        sum += response * incidence.irradiance * lit;
    }
    return sum;
}

fn indirect_light(s: Sampled, in: Varying, to_eye: vec3f) -> vec3f {
    let position = in.position;
    let albedo = s.base.rgb * ((1.0 - s.metallic) * (1.0 - s.transmission));
#ifdef PATCHED
    let share = lobe_reflectance(s.normal_reflectance, s.grazing_reflectance, s.roughness, max(dot(s.normal, to_eye), 1e-4));
    let kept = 1.0 - max(share.r, max(share.g, share.b));
    // What glass reflects comes by rays. Other surfaces reflect as if light were even around them.
    let reflectance = kept * albedo + select(share, vec3f(0.0), s.transmission > 0.0);
    let n = normalize(in.normal);
    let facing = select(-n, n, dot(n, to_eye) >= 0.0);
    return reflectance * irradiance_of_patches(in.id, position, facing, blend.patch_size) / 3.14159265;
#endif
#ifdef SWEPT
    let n_dot_v = max(dot(s.normal, to_eye), 1e-4);
    let share = lobe_reflectance(s.normal_reflectance, s.grazing_reflectance, s.roughness, n_dot_v);
    let around = irradiance_around(swept, position, s.normal, lobe_direction(s.normal, to_eye, s.roughness), to_eye);
    let kept = 1.0 - max(share.r, max(share.g, share.b));
    // What glass reflects comes by rays.
    let reflected = select(share * around, vec3f(0.0), s.transmission > 0.0);
    return (kept * albedo * irradiance(swept, position, s.normal, to_eye) + reflected) / 3.14159265;
#endif
#ifdef PROPAGATED
    return albedo * propagated_irradiance(position, s.normal) / 3.14159265;
#endif
#ifdef AMBIENT
    return albedo * ambient.rgb / 3.14159265;
#endif
    return vec3f(0.0);
}

// What a point does to what lies behind it.
struct Over {
    covers: f32,           // share of the pixel that the surface takes; 0: there is none
    hides: f32,            // share of what lies behind that is hidden
    seen_through: vec3f,   // and what is seen in its stead [W/(m² sr)]
}

#ifdef GLASS
fn over_what_lies_behind(s: Sampled, in: Varying) -> Over {
    let is_blended = material.alpha_cutoff >= BLENDED;
    let covers = select(select(1.0, 0.0, s.base.a < material.alpha_cutoff), s.base.a, is_blended);
#ifdef SEEN_THROUGH
    // Glass behind other glass is seen through that.
    let seen = textureLoad(seen_through, vec2u(in.clip.xy), 0);
    let start = world_position(vec2u(in.clip.xy), view.size, 1.0, view.world_from_clip);
    let is_seen = seen.a > 0.0 && distance(start, in.position) <= seen.a * (1.0 + SAME_GLASS);
    return Over(select(0.0, covers, is_seen), covers, seen.rgb);
#else
    let f = max(s.normal_reflectance.r, max(s.normal_reflectance.g, s.normal_reflectance.b));
    let color = max(s.base.r, max(s.base.g, s.base.b));
    let passes = color * s.transmission * (1.0 - s.metallic) * (1.0 - f);
    return Over(covers, covers * (1.0 - passes), vec3f(0.0));
#endif
}
#else
fn over_what_lies_behind(s: Sampled, in: Varying) -> Over {
    // What hides all that lies behind is among the opaque surfaces already.
    let alpha = select(s.base.a, 0.0, s.base.a >= OPAQUE_ALPHA);
    return Over(alpha, alpha, vec3f(0.0));
}
#endif

struct Targets {
    @location(0) color: vec4f, // premultiplied
    @location(1) object: u32,
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> Targets {
    let s = sample_material(in, front);
    let over = over_what_lies_behind(s, in);
    if over.covers <= 0.0 {
        discard;
    }
    let to_eye = normalize(toward_eye(view, in.position));
    var radiance = direct_light(s, in.position, to_eye);
    if blend.is_first != 0u {
        radiance += indirect_light(s, in, to_eye) + over.seen_through;
    }
    if blend.has_emission != 0u {
        radiance += s.emissive;
    }
#ifdef HAZE
    let between = veil(view, in.clip.xy, in.position, false);
    // What is scattered before it counts once.
    radiance = radiance * between.passing + select(vec3f(0.0), between.added, blend.is_first != 0u);
#endif
    var out: Targets;
    out.color = vec4f(min(radiance * over.covers, vec3f(MAX_RADIANCE)), select(0.0, over.hides, blend.is_first != 0u));
    out.object = in.id;
    return out;
}
