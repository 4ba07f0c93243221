#define_import_path lightwell::rsm_samples

// Surface points that lights reach, as light sources of the final gather (Keller 1997, with the weights of Veach and
// Guibas 1995). `indirect/light_volumes/sweep/rsm_samples.wgsl` draws them with a density that is proportional to the irradiance, so that a
// small bright patch far away is found by each pixel, where few of its rays would meet it; in corners rays are the better
// way. Either way's light is weighted by the balance heuristic, so that their sum is right and neither has peaks.

#import lightwell::gbuffer::decode_surface
#import lightwell::lights::light_incidence
#ifdef MEDIA
#import lightwell::media::{FARTHEST, transmittance}
#endif
#import lightwell::next_event::{bounded, reflected, direction_density}
#import lightwell::ray_scene::load_light
#import lightwell::ray_surfaces::{Surface, leave_surface}
#import lightwell::rays::Ray
#import lightwell::visible_surface::VisibleSurface

// vec4u a point: position [m] and light; base colour and normal as in the G-buffer; √F0 as in the G-buffer, and one over the
// flux that all maps' texels receive, all channels together [1/W]. All zero: not a point.
const POINT_TEXELS: u32 = 3u;

// Flux below one over this [W] is left to the rays: densities could leave the range of floats.
const MAX_SHARE: f32 = 1e35;

fn is_drawn(share: f32) -> bool {
    return share > 0.0 && share < MAX_SHARE;
}

struct RsmSample {
    surface: Surface,
    light: u32,
    share: f32,            // of a unit of flux in all that the texels receive [1/W]; 0: there is no such point
}

fn decode_point(place: vec4u, colors: vec4u, rest: vec4u) -> RsmSample {
    let low = colors & vec4u(0xffffu);
    let high = colors >> vec4u(16u);
    let position = bitcast<vec3f>(place.xyz);
    let drawn = decode_surface(
        vec4u(low.xy, high.xy), vec4u(low.zw, high.zw), vec2u(0u, rest.x), 1.0, position,
    );
    var surface: Surface;
    surface.position = position;
    surface.normal = drawn.normal;
    surface.geometric_normal = drawn.normal;
    surface.albedo = drawn.albedo;
    surface.normal_reflectance = drawn.normal_reflectance;
    surface.grazing_reflectance = drawn.grazing_reflectance;
    surface.alpha = max(drawn.roughness * drawn.roughness, 1e-3);
    let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
    surface.error = largest * 0x1p-17f;
    return RsmSample(surface, place.w, bitcast<f32>(rest.y));
}

// Density with which points are drawn on a surface, per solid angle as seen from a distance [1/sr]. `irradiance` is that on
// a plane across the light [W/m²], all channels together.
fn point_density(irradiance: f32, to_light: vec3f, n: vec3f, share: f32, direction: vec3f, distance: f32) -> f32 {
    let per_area = irradiance * share * max(0.0, dot(n, to_light));
    // No surface is seen quite from the side.
    return per_area * distance * distance / max(abs(dot(n, direction)), 1e-6);
}

// What a visible surface reflects of the light that a point reflects to it, and the way between the two.
struct FromPoint {
    light: vec3f,          // [W/(m² sr)]
    direction: vec3f,      // unit, to the point
    ray: Ray,              // to the point; its length is the distance
}

// `rays` and `candidates` are the numbers with which both ways sample.
fn light_from_point(seen: VisibleSurface, point: RsmSample, rays: f32, candidates: f32) -> FromPoint {
    let nothing = FromPoint(vec3f(0.0), vec3f(0.0), Ray(vec3f(0.0), vec3f(0.0)));
    let offset = point.surface.position - seen.surface.position;
    let distance = length(offset);
    if !is_drawn(point.share) || !(distance > 0.0) {
        return nothing;
    }
    let direction = offset / distance;
    let response = reflected(seen.surface, seen.to_eye, direction);
    if dot(point.surface.normal, direction) >= 0.0 || all(response <= vec3f(0.0)) {
        return nothing;
    }
    let incidence = light_incidence(load_light(point.light).light, point.surface.position);
    let e = incidence.irradiance;
    var radiance = bounded(reflected(point.surface, -direction, incidence.to_light) * e);
#ifdef MEDIA
    let to_light = select(incidence.distance, FARTHEST, incidence.distance == 0.0);
    radiance *= transmittance(point.surface.position, incidence.to_light, to_light)
        * transmittance(seen.surface.position, direction, distance);
#endif
    let of_points =
        point_density(e.r + e.g + e.b, incidence.to_light, point.surface.normal, point.share, direction, distance);
    let of_rays = direction_density(seen.surface, seen.to_eye, direction, seen.to_specular);
    let both = candidates * of_points + rays * of_rays;
    if !(both > 0.0) {
        return nothing;
    }
    let start = leave_surface(seen.surface, direction);
    let end = leave_surface(point.surface, -direction);
    return FromPoint(bounded(response * radiance / both), direction, Ray(start, end - start));
}
