// How much of a light with a surface arrives at each pixel, by shadow rays to points of it: sums of what the points would bring
// and of what they do bring, for diffuse and for specular reflection. `direct/area.wgsl` filters their ratio.
//
// Where surfaces are glossy, rays along the specular lobe that meet the light count as well, by the balance heuristic (Veach
// and Guibas 1995): few points of a light lie in a narrow lobe.
//
// One ray a pixel comes first; more are sent where those of a tile do not agree.
//   SAMPLES  points of the light, and directions of a glossy surface's lobe, a pixel
//   FURTHER  those after the first

#import lightwell::area_lights::{meet_light, sample_incidence}
#import lightwell::brdf::{distribution_ggx, visibility_smith, visible_normal_density}
#import lightwell::gbuffer::{Surface, decode_surface, world_position}
#import lightwell::lights::{Incidence, Light}
#import lightwell::sampling::{Sampler, next_pair, visible_ggx_normal}
#import lightwell::shadow_rays::arriving
#ifdef FURTHER
#import lightwell::shadow_tiles::{MIXED, tile_of}
#endif
#import lightwell::view::{View, toward_eye}
#import lightwell::visible_surface::number_of

struct Shadows {
    origin: vec2u,         // first pixel
    size: vec2u,           // [pixels]
    root: u32,             // of the hierarchy for rays
    seed: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> shadows: Shadows;
@group(0) @binding(3) var base_color: texture_2d<u32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var object: texture_2d<u32>;
@group(0) @binding(6) var depth: texture_depth_2d;
// Diffuse light that arrives, and without shadows; the same of specular light. Relative to the light's intensity.
@group(0) @binding(7) var arrived: texture_storage_2d<rgba32float, write>;
#ifdef FURTHER
@group(0) @binding(8) var before: texture_2d<f32>;
@group(0) @binding(9) var<storage, read> tiles: array<u32>;
#endif

#ifdef SAMPLES
const SAMPLES: u32 = #{SAMPLES}u;
#else
const SAMPLES: u32 = 1u;
#endif

// GGX α up to which directions of the lobe are sampled too.
const GLOSSY: f32 = 0.25;
const MOST: f32 = 1e15;

// The specular lobe without its Fresnel term, times n·l [1/sr], and the density with which its directions are sampled.
struct Lobe {
    value: f32,
    density: f32,
}

fn lobe(surface: Surface, to_eye: vec3f, direction: vec3f, alpha: f32) -> Lobe {
    let half_sum = to_eye + direction;
    let length_squared = dot(half_sum, half_sum);
    // Where the two are opposite, as a bent normal may show a surface from behind, no normal lies between them.
    if length_squared < 1e-12 {
        return Lobe(0.0, 0.0);
    }
    let h = half_sum * inverseSqrt(length_squared);
    let n_dot_l = dot(surface.normal, direction);
    let n_dot_v = max(dot(surface.normal, to_eye), 1e-4);
    let value = distribution_ggx(surface.normal, h, alpha) * visibility_smith(n_dot_l, n_dot_v, alpha) * n_dot_l;
    return Lobe(value, visible_normal_density(surface.normal, h, n_dot_v, alpha));
}

fn power(irradiance: vec3f) -> f32 {
    return irradiance.r + irradiance.g + irradiance.b;
}

// What a light brings without shadows, diffuse and specular.
struct Unshadowed {
    diffuse: f32,
    specular: f32,
}

// What a pixel sees of the light.
struct Receiver {
    surface: Surface,
    to_eye: vec3f,
    alpha: f32,
    is_glossy: bool,       // directions of its lobe are sampled too
    is_shiny: bool,        // it reflects specular light
    unit: f32,             // powers cancel out of the ratio: in units of the light's own, sums stay in range
}

fn receiver(pixel: vec2u, z: f32) -> Receiver {
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    let to_eye = normalize(toward_eye(view, position));
    let alpha = max(surface.roughness * surface.roughness, 1e-3);
    let is_shiny = any(surface.normal_reflectance > vec3f(0.0)) || surface.grazing_reflectance > 0.0;
    let is_glossy = is_shiny && alpha <= GLOSSY && dot(surface.normal, to_eye) > 0.0;
    return Receiver(surface, to_eye, alpha, is_glossy, is_shiny, 1.0 / max(power(light.intensity), 1e-30));
}

fn from_light(r: Receiver, incidence: Incidence) -> Unshadowed {
    let e = power(incidence.irradiance) * r.unit;
    let diffuse = min(e * dot(r.surface.normal, incidence.to_light), MOST);
    if !r.is_shiny {
        return Unshadowed(diffuse, 0.0);
    }
    let of_lobe = lobe(r.surface, r.to_eye, incidence.to_light, r.alpha);
    let specular = e * of_lobe.value / (1.0 + select(0.0, of_lobe.density, r.is_glossy) * incidence.solid_angle);
    return Unshadowed(diffuse, min(specular, MOST));
}

// What comes from one point of the light, with and without what lies between.
fn one_point(r: Receiver, incidence: Incidence, is_of_lobe: bool) -> vec4f {
    if dot(r.surface.normal, incidence.to_light) <= 0.0 || power(incidence.irradiance) <= 0.0 {
        return vec4f(0.0);
    }
    let whole = from_light(r, incidence);
    // Of light that glass colours, the mean.
    let lit = dot(vec3f(1.0 / 3.0), arriving(view, shadows.root, r.surface.position, r.surface.normal, incidence));
    let diffuse = select(whole.diffuse, 0.0, is_of_lobe);
    return vec4f(lit * diffuse, diffuse, lit * whole.specular, whole.specular);
}

// One point of the light, and where the surface is glossy one direction of its lobe.
fn sample_once(r: Receiver, number: u32) -> vec4f {
    var random = Sampler(shadows.seed, number, 0u);
    let position = r.surface.position;
    var sums = one_point(r, sample_incidence(light, position, next_pair(&random)), false);
    if r.is_glossy {
        let n = visible_ggx_normal(r.surface.normal, r.to_eye, r.alpha, next_pair(&random));
        sums += one_point(r, meet_light(light, position, reflect(-r.to_eye, n)), true);
    }
    return sums;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= shadows.size) {
        return;
    }
    let pixel = shadows.origin + thread.xy;
    let z = textureLoad(depth, pixel, 0);
    var sums = vec4f(0.0);
    if z > 0.0 {
#ifdef FURTHER
        sums = textureLoad(before, pixel, 0);
        if tiles[tile_of(pixel, view.size)] != MIXED {
            // They count as much as those of the pixels around the tile.
            sums *= f32(SAMPLES);
        } else {
            let r = receiver(pixel, z);
            for (var i = 1u; i < SAMPLES; i++) {
                sums += sample_once(r, number_of(pixel) * SAMPLES + i);
            }
        }
#else
        sums = sample_once(receiver(pixel, z), number_of(pixel) * SAMPLES);
#endif
    }
    textureStore(arrived, pixel, sums);
}
