#define_import_path lightwell::direct

// What a visible surface sends to the eye of the light that arrives from one direction.

#import lightwell::brdf::eval_brdf_cosine
#ifdef STRETCHED
#import lightwell::brdf::fresnel_schlick
#import lightwell::layers::stretched_lobe
#endif
#import lightwell::gbuffer::Surface
#import lightwell::lights::Incidence
#ifdef MEDIA
#import lightwell::media::{FARTHEST, transmittance}
#endif

// Whether any of it reaches the front of the surface.
fn is_lit(surface: Surface, incidence: Incidence) -> bool {
    return any(incidence.irradiance > vec3f(0.0)) && dot(surface.normal, incidence.to_light) > 0.0;
}

// Radiance [W/(m² sr)] without regard to shadows. The way to the eye need not be of unit length.
fn reflected_light(surface: Surface, to_eye: vec3f, incidence: Incidence) -> vec3f {
    let alpha = max(surface.roughness * surface.roughness, 1e-3);
#ifdef STRETCHED
    if surface.alpha_along > 0.0 {
        return stretched_light(surface, normalize(to_eye), incidence, alpha);
    }
#endif
    let response = eval_brdf_cosine(
        surface.normal, normalize(to_eye), incidence.to_light, surface.albedo, surface.normal_reflectance, surface.grazing_reflectance, alpha,
    );
    return response * incidence.irradiance;
}

#ifdef STRETCHED
// By a stretched lobe alone, of whose α the geometry buffer has the one along and the geometric mean of both.
fn stretched_light(surface: Surface, to_eye: vec3f, incidence: Incidence, mean: f32) -> vec3f {
    let l = incidence.to_light;
    let h = normalize(to_eye + l);
    let alphas = vec2f(surface.alpha_along, mean * mean / surface.alpha_along);
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, dot(to_eye, h));
    return f * (stretched_lobe(surface.normal, surface.along, to_eye, l, h, alphas) * max(dot(surface.normal, l), 0.0))
        * incidence.irradiance;
}
#endif

// What is left of light on its way through media to a point.
fn through_media(incidence: Incidence, position: vec3f) -> Incidence {
    var left = incidence;
#ifdef MEDIA
    let distance = select(incidence.distance, FARTHEST, incidence.distance == 0.0);
    left.irradiance *= transmittance(position, incidence.to_light, distance);
#endif
    return left;
}
