// How much of a light with a surface arrives at each pixel, by shadow rays to points of it: sums of what the points would bring
// and of what they do bring, for diffuse and for specular reflection. `direct/area.wgsl` filters their ratio.
//
// Where surfaces are glossy, rays along the specular lobe that meet the light count as well, by the balance heuristic (Veach
// and Guibas 1995): few points of a light lie in a narrow lobe.
//   SAMPLES  points of the light, and directions of a glossy surface's lobe, a pixel

#import lightwell::area_lights::{meet_light, sample_incidence}
#import lightwell::brdf::{distribution_ggx, visibility_smith, visible_normal_density}
#import lightwell::gbuffer::{Surface, decode_surface, world_position}
#import lightwell::lights::{Incidence, Light}
#import lightwell::sampling::{Sampler, next_pair, visible_ggx_normal}
#import lightwell::shadow_rays::is_reached
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

fn from_light(surface: Surface, to_eye: vec3f, incidence: Incidence, alpha: f32, is_glossy: bool, unit: f32) -> Unshadowed {
    let e = power(incidence.irradiance) * unit;
    let of_lobe = lobe(surface, to_eye, incidence.to_light, alpha);
    let specular = e * of_lobe.value / (1.0 + select(0.0, of_lobe.density, is_glossy) * incidence.solid_angle);
    return Unshadowed(
        min(e * dot(surface.normal, incidence.to_light), MOST), min(specular, MOST),
    );
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= shadows.size) {
        return;
    }
    let pixel = shadows.origin + thread.xy;
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        textureStore(arrived, pixel, vec4f(0.0));
        return;
    }
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let surface = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    let to_eye = normalize(toward_eye(view, position));
    let alpha = max(surface.roughness * surface.roughness, 1e-3);
    let is_glossy = alpha <= GLOSSY && dot(surface.normal, to_eye) > 0.0;
    // Powers cancel out of the ratio: in units of the light's own, sums stay in range.
    let unit = 1.0 / max(power(light.intensity), 1e-30);
    var sums = vec4f(0.0);
    let first = number_of(pixel) * SAMPLES;
    for (var i = 0u; i < SAMPLES; i++) {
        var random = Sampler(shadows.seed, first + i, 0u);
        let sample = sample_incidence(light, position, next_pair(&random));
        if dot(surface.normal, sample.to_light) > 0.0 && power(sample.irradiance) > 0.0 {
            let whole = from_light(surface, to_eye, sample, alpha, is_glossy, unit);
            let lit = select(0.0, 1.0, is_reached(view, shadows.root, position, surface.normal, sample));
            sums += vec4f(lit * whole.diffuse, whole.diffuse, lit * whole.specular, whole.specular);
        }
        if is_glossy {
            let direction = reflect(-to_eye, visible_ggx_normal(surface.normal, to_eye, alpha, next_pair(&random)));
            let met = meet_light(light, position, direction);
            if dot(surface.normal, direction) > 0.0 && power(met.irradiance) > 0.0 {
                let whole = from_light(surface, to_eye, met, alpha, true, unit);
                let lit = select(0.0, 1.0, is_reached(view, shadows.root, position, surface.normal, met));
                sums += vec4f(0.0, 0.0, lit * whole.specular, whole.specular);
            }
        }
    }
    textureStore(arrived, pixel, sums);
}
