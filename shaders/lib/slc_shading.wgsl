#define_import_path lightwell::slc_shading

// What a virtual light brings to a pixel, for all ways of culling: Russian roulette with p(ω, l) against the light's ξ,
// and what is accepted divided by p.
//   UNCULLED  all lights, none by chance
//   RAYS      shadow rays to the lights

#import lightwell::brdf::{distribution_ggx, visibility_smith, fresnel_schlick}
#import lightwell::gbuffer::{Surface, decode_surface, world_position}
#import lightwell::slc::{VirtualLight, LightRange, Culling, lobe_intensity, acceptance, diffuse_share}
#import lightwell::view::View
#ifdef RAYS
#import lightwell::rays::{Ray, SHADOW, NONE, trace}
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> culling: Culling;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var object: texture_2d<u32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var<storage, read> virtual_lights: array<VirtualLight>;
@group(0) @binding(7) var<storage, read> ranges: array<LightRange>;
@group(0) @binding(8) var<storage, read> bound: vec4f;
struct Pixel {
    surface: Surface,
    to_eye: vec3f,
    n_dot_v: f32,
    alpha: f32,
    origin: vec3f,         // where rays start [m]
    delta: f32,
    diffuse: vec3f,
    tested: f32,
    specular: vec3f,
    accepted: f32,
}

// Nothing brighter is added, so that sums stay finite.
const MAX_RADIANCE: f32 = 1e28;
// How far rounding may have moved a point, over its coordinates and its distance from the eye.
const POSITION_ERROR: f32 = 2e-5;

#ifdef RAYS
fn is_visible(pixel: Pixel, light: VirtualLight) -> bool {
    let c = abs(light.position);
    let end = light.position + light.normal * (POSITION_ERROR * max(c.x, max(c.y, c.z)));
    return trace(culling.root, Ray(pixel.origin, end - pixel.origin), 1.0, SHADOW).triangle == NONE;
}
#endif

// What the surface reflects of irradiance `e` on a plane perpendicular to the light.
fn add(pixel: ptr<function, Pixel>, e: vec3f, to_light: vec3f, cosine: f32) {
    let surface = (*pixel).surface;
    let half_sum = to_light + (*pixel).to_eye;
    let length_squared = dot(half_sum, half_sum);
    if length_squared < 1e-12 {
        (*pixel).diffuse += e * cosine;
        return;
    }
    let h = half_sum * inverseSqrt(length_squared);
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, dot((*pixel).to_eye, h));
    (*pixel).diffuse += e * (cosine * diffuse_share(f));
    let d = distribution_ggx(surface.normal, h, (*pixel).alpha);
    let v = visibility_smith(cosine, (*pixel).n_dot_v, (*pixel).alpha);
    (*pixel).specular += min(e * f * (d * v * cosine), vec3f(MAX_RADIANCE));
}

fn test_light(pixel: ptr<function, Pixel>, index: u32, lobe: u32) {
    (*pixel).tested += 1.0;
    let offset = virtual_lights[index].position - (*pixel).surface.position;
    let distance_squared = dot(offset, offset);
    if !(distance_squared > 1e-36) {
        return;
    }
    let to_light = offset * inverseSqrt(distance_squared);
    let softened = distance_squared + virtual_lights[index].spread;
    let intensity = lobe_intensity(virtual_lights[index], lobe, -to_light);
#ifdef UNCULLED
    let p = 1.0;
    let is_accepted = any(intensity > vec3f(0.0));
#else
    let p = acceptance(intensity, (*pixel).delta, softened);
    let is_accepted = p > ranges[index].xi;
#endif
    if !is_accepted {
        return;
    }
    (*pixel).accepted += 1.0;
    let cosine = dot((*pixel).surface.normal, to_light);
    if cosine <= 0.0 {
        return;
    }
#ifdef RAYS
    if !is_visible(*pixel, virtual_lights[index]) {
        return;
    }
#endif
    add(pixel, min(intensity / softened / p, vec3f(MAX_RADIANCE)), to_light, cosine);
}

fn load_pixel(at: vec2u, z: f32) -> Pixel {
    var pixel: Pixel;
    let position = world_position(at, view.size, z, view.world_from_clip);
    pixel.surface = decode_surface(
        textureLoad(base_color, at, 0), textureLoad(normal, at, 0), textureLoad(object, at, 0).xy, z, position,
    );
    pixel.to_eye = normalize(view.eye - position);
    pixel.n_dot_v = max(dot(pixel.surface.normal, pixel.to_eye), 1e-4);
    pixel.alpha = max(pixel.surface.roughness * pixel.surface.roughness, 1e-3);
    pixel.delta = bound.x;
    let c = abs(position);
    let error = POSITION_ERROR * max(max(c.x, max(c.y, c.z)), distance(position, view.eye));
    pixel.origin = position + pixel.surface.normal * error;
    return pixel;
}
