#define_import_path lightwell::vpl

// Virtual point lights: surfaces that shine as they reflect, and light from far away.
//   MATTE   the scene has no glossy surface

#import lightwell::brdf::{eval_brdf_cosine, distribution_ggx, fresnel_schlick, visibility_smith}
#import lightwell::gbuffer::{Surface, decode_normal_reflectance, decode_octahedral}

const DISTANT: u32 = 1u;
const INVERSE_PI: f32 = 0.31830988618379;
// Nothing brighter is added, so that sums over all lights stay finite.
const MAX_RADIANCE: f32 = 1e26;

struct VirtualLight {
    place: vec3f,          // [m]; DISTANT: unit direction towards it
    kind: u32,
    normal: vec3f,
    nearest: f32,          // d_min [m]
    intensity: vec3f,      // along the normal [W/sr]; DISTANT: irradiance across it [W/m²]
    offset: f32,           // how far a ray ends before the surface [m]
    flux: vec3f,           // that arrives, of glossy surfaces [W]
    gloss: u32,            // roughness and F90; 0: a diffuse surface
    incident: u32,         // octahedral direction that the flux comes from
    specular: u32,         // √F0
    next: f32,             // d_min of the lights at the next hits of the same source [m]; 0: there are none
    padding: u32,
}

struct Connection {
    radiance: vec3f,       // what the receiver reflects to the eye if nothing is between [W/(m² sr)]
    to_light: vec3f,       // unit
    end: vec3f,            // where a shadow ray ends [m]
    distant: bool,
}

// Intensity towards a receiver [W/sr]: a diffuse surface shines by the cosine, a glossy one by its whole reflection of the
// flux that arrives. `spread` is half the angle that the light's patch is seen under, squared.
fn emission(light: VirtualLight, to_receiver: vec3f, cosine: f32, spread: f32) -> vec3f {
    let diffuse = light.intensity * cosine;
#ifndef MATTE
    if light.gloss == 0u {
        return diffuse;
    }
    let incident = decode_octahedral(unpack2x16snorm(light.incident));
    let half_sum = incident + to_receiver;
    let length_squared = dot(half_sum, half_sum);
    if length_squared < 1e-12 {
        return diffuse;
    }
    let h = half_sum * inverseSqrt(length_squared);
    let gloss = unpack2x16unorm(light.gloss);
    let alpha = min(1.0, sqrt(max(gloss.x * gloss.x * gloss.x * gloss.x, 1e-6) + spread));
    let f = fresnel_schlick(decode_normal_reflectance(vec2u(0u, light.specular)), gloss.y, dot(incident, h));
    let n_dot_i = max(dot(light.normal, incident), 1e-4);
    let lobe = distribution_ggx(light.normal, h, alpha) * visibility_smith(cosine, n_dot_i, alpha) * cosine;
    return diffuse * (1.0 - max(f.r, max(f.g, f.b))) + light.flux * f * lobe;
#else
    return diffuse;
#endif
}

// f·I·cosθ·cosθ_i / max(d², d_min²), where I·cosθ_i is the intensity towards the receiver (Keller 1997).
fn connect(light: VirtualLight, surface: Surface, to_eye: vec3f) -> Connection {
    var c: Connection;
    c.distant = light.kind == DISTANT;
    let offset = light.place - surface.position;
    let distance_squared = max(dot(offset, offset), 1e-36);
    c.to_light = select(offset * inverseSqrt(distance_squared), light.place, c.distant);
    c.end = light.place + light.normal * light.offset;
    let emitted = max(0.0, -dot(light.normal, c.to_light));
    let received = dot(surface.normal, c.to_light);
    if received <= 0.0 || (emitted <= 0.0 && !c.distant) {
        return c;
    }
    let nearest = light.nearest * light.nearest;
    // In two steps, so that the square of a tiny distance cannot vanish.
    let bounded = max(distance_squared, nearest);
    // A light stands for a patch as wide as d_min: narrower lobes are widened, or they would show as spots (as Karis 2013,
    // "Real shading in Unreal Engine 4", does it for lights with an extent). By a sixth of the patch's width: by the half
    // of it a floor that mirrors the sun would lose a further twentieth of its light, which the wide lobes send
    // into the floor.
    let spread = select(0.03125 * nearest / bounded, 0.0, c.distant);
    var arriving = light.intensity;
    if !c.distant {
        arriving = emission(light, -c.to_light, emitted, spread) / bounded;
    }
    let alpha = max(surface.roughness * surface.roughness, 1e-3);
    let widened = min(1.0, sqrt(alpha * alpha + spread));
    let response = eval_brdf_cosine(
        surface.normal, to_eye, c.to_light, surface.albedo, surface.normal_reflectance, surface.grazing_reflectance, widened,
    );
    c.radiance = min(response * arriving, vec3f(MAX_RADIANCE));
    return c;
}

// The report's: (ρ/π)·L·max(n·l, 0), where L holds the weight over N already.
fn connect_as_published(light: VirtualLight, surface: Surface) -> Connection {
    var c: Connection;
    let offset = light.place - surface.position;
    c.to_light = offset * inverseSqrt(max(dot(offset, offset), 1e-36));
    c.end = light.place + light.normal * light.offset;
    c.radiance = min(surface.albedo * INVERSE_PI * light.intensity * max(0.0, dot(surface.normal, c.to_light)), vec3f(MAX_RADIANCE));
    return c;
}

// Where a shadow ray starts: off the surface by more than what the point may be off it.
fn shadow_origin(surface: Surface, position_error: f32) -> vec3f {
    return surface.position + surface.normal * (4.0 * position_error);
}
