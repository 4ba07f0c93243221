#define_import_path lightwell::slc_shading

// The contribution of a virtual light to a pixel, for all ways of culling: Russian roulette with p(ω, l) against the light's ξ,
// and what is accepted divided by p.
//   UNCULLED  all lights, none by chance
//   RAYS      shadow rays to the lights

#import lightwell::brdf::{distribution_ggx, visibility_smith, fresnel_schlick}
#import lightwell::gbuffer::{Surface, decode_octahedral, decode_surface, world_position}
#import lightwell::slc::{LightRange, Culling, DIFFUSE_LOBE, acceptance, brightest, diffuse_share, grazing_weight}
#import lightwell::slc::{specular_factor, squeezed}
#import lightwell::slc::{LIGHTS_A_ROW, PLACE, SHAPE, COLOR, INCIDENCE, NORMAL_FLUX, GRAZING_FLUX, SPHEROID, AXIS}
#import lightwell::view::{position_error, toward_eye}
#ifdef RAYS
#import lightwell::ray_scene::NONE
#import lightwell::rays::{Ray, SHADOW}
#import lightwell::walk::{passed, trace}
#endif

@group(0) @binding(1) var<uniform> culling: Culling;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var object: texture_2d<u32>;
@group(0) @binding(5) var depth: texture_depth_2d;
@group(0) @binding(6) var light_texels: texture_2d_array<f32>;
@group(0) @binding(7) var<storage, read> ranges: array<LightRange>;
@group(0) @binding(8) var<storage, read> bound: vec4f;

struct Pixel {
    surface: Surface,
    to_eye: vec3f,
    n_dot_v: f32,
    alpha: f32,
    is_glossy: bool,       // reflects more than diffusely
    origin: vec3f,         // where rays start [m]
    delta: f32,
    diffuse: vec3f,
    tested: f32,
    specular: vec3f,
    accepted: f32,
}

// Nothing brighter is added, so that sums stay finite.
const MAX_RADIANCE: f32 = 1e28;
// How far rounding may have moved a virtual light, over its coordinates.
const POSITION_ERROR: f32 = 2e-5;

#ifdef RAYS
// What arrives of light from there: all, nothing, or what glass leaves.
fn arriving(pixel: Pixel, position: vec3f, normal: vec3f) -> vec3f {
    let c = abs(position);
    let end = position + normal * (POSITION_ERROR * max(c.x, max(c.y, c.z)));
    let ray = Ray(pixel.origin, end - pixel.origin);
    let hit = trace(culling.root, ray, 1.0, SHADOW);
    return select(vec3f(0.0), passed(ray, hit), hit.triangle == NONE);
}
#endif

// What the surface reflects of irradiance `e` on a plane perpendicular to the light.
fn add(pixel: ptr<function, Pixel>, e: vec3f, to_light: vec3f, cosine: f32) {
    let surface = (*pixel).surface;
    let half_sum = to_light + (*pixel).to_eye;
    let length_squared = dot(half_sum, half_sum);
    if !(*pixel).is_glossy || length_squared < 1e-12 {
        (*pixel).diffuse += e * cosine;
        return;
    }
    let h = half_sum * inverseSqrt(length_squared);
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, dot((*pixel).to_eye, h));
    (*pixel).diffuse += e * (cosine * (1.0 - brightest(f)));
    let d = distribution_ggx(surface.normal, h, (*pixel).alpha);
    let v = visibility_smith(cosine, (*pixel).n_dot_v, (*pixel).alpha);
    (*pixel).specular += min(e * f * (d * v * cosine), vec3f(MAX_RADIANCE));
}

fn light_texel(index: u32, layer: u32) -> vec4f {
    return textureLoad(light_texels, vec2u(index % LIGHTS_A_ROW, index / LIGHTS_A_ROW), layer, 0);
}

// Whether the light may be accepted, with as little as possible: most of a tile's lights end here. The diffuse lobe
// is I = color·(1 − max F)·cosθ, accepted if p = I/(δ·l²) > ξ, which is (1 − max F)·cosθ·reach² > l². The specular one
// is tested by its range.
fn may_accept(pixel: Pixel, index: u32, lobe: u32) -> bool {
    if lobe == DIFFUSE_LOBE {
        let place = light_texel(index, PLACE);
        let shape = light_texel(index, SHAPE);
        let offset = pixel.surface.position - place.xyz;
        let distance_squared = dot(offset, offset);
        let emitted = dot(shape.xyz, offset) * inverseSqrt(max(distance_squared, 1e-36));
        return emitted * shape.w > distance_squared + abs(place.w);
    }
    let spheroid = light_texel(index, SPHEROID);
    let axis = light_texel(index, AXIS);
    let from_center = squeezed(pixel.surface.position - spheroid.xyz, axis.xyz, axis.w);
    return dot(from_center, from_center) <= spheroid.w * spheroid.w;
}

// Tests a light and adds it if it is accepted.
fn take_light(pixel: ptr<function, Pixel>, index: u32, lobe: u32) {
    let place = light_texel(index, PLACE);
    let shape = light_texel(index, SHAPE);
    let incidence = light_texel(index, INCIDENCE);
    let offset = place.xyz - (*pixel).surface.position;
    let distance_squared = dot(offset, offset);
    let to_light = offset * inverseSqrt(max(distance_squared, 1e-36));
    let emitted = -dot(shape.xyz, to_light);
    if !(emitted > 0.0) {
        return;
    }
    let softened = distance_squared + abs(place.w);
    let incident = decode_octahedral(incidence.xy);
    let weight = grazing_weight(incident, -to_light);
    var e: vec3f;
    var is_accepted: bool;
    if lobe == DIFFUSE_LOBE {
        let color = light_texel(index, COLOR);
        let factor = emitted * select(1.0, diffuse_share(color.w, incidence.z, weight), place.w < 0.0);
#ifdef UNCULLED
        is_accepted = factor * shape.w > 0.0;
        e = color.xyz * (factor / softened);
#else
        is_accepted = factor * shape.w > softened;
        // Divided by p = min(I/(δ·l²), 1).
        e = color.xyz * max(factor / softened, (*pixel).delta / brightest(color.xyz));
#endif
    } else {
        let from_normal = light_texel(index, NORMAL_FLUX);
        let flux = mix(from_normal.xyz, light_texel(index, GRAZING_FLUX).xyz, weight);
        let intensity = flux * specular_factor(shape.xyz, incident, incidence.w, -to_light, emitted);
#ifdef UNCULLED
        is_accepted = any(intensity > vec3f(0.0));
        e = intensity / softened;
#else
        let p = acceptance(intensity, (*pixel).delta, softened);
        is_accepted = p > from_normal.w;
        e = intensity / softened / p;
#endif
    }
    if !is_accepted {
        return;
    }
    (*pixel).accepted += 1.0;
    let cosine = dot((*pixel).surface.normal, to_light);
    if cosine <= 0.0 {
        return;
    }
#ifdef RAYS
    e *= arriving(*pixel, place.xyz, shape.xyz);
    if all(e <= vec3f(0.0)) {
        return;
    }
#endif
    add(pixel, min(e, vec3f(MAX_RADIANCE)), to_light, cosine);
}

fn load_pixel(at: vec2u, z: f32) -> Pixel {
    var pixel: Pixel;
    let position = world_position(at, culling.view.size, z, culling.view.world_from_clip);
    pixel.surface = decode_surface(
        textureLoad(base_color, at, 0), textureLoad(normal, at, 0), textureLoad(object, at, 0).xy, z, position,
    );
    pixel.to_eye = normalize(toward_eye(culling.view, position));
    pixel.n_dot_v = max(dot(pixel.surface.normal, pixel.to_eye), 1e-4);
    pixel.alpha = max(pixel.surface.roughness * pixel.surface.roughness, 1e-3);
    pixel.is_glossy = pixel.surface.grazing_reflectance > 0.0 || any(pixel.surface.normal_reflectance > vec3f(0.0));
    pixel.delta = bound.x;
    pixel.origin = position + pixel.surface.normal * (4.0 * position_error(culling.view, position));
    return pixel;
}
