#define_import_path lightwell::refraction

// Light that passes a surface of glass which is seen: thin walls, and the surfaces of bodies. See lib/glass.wgsl.

#import lightwell::brdf::{distribution_ggx, fresnel_schlick, visibility_smith}
#import lightwell::ray_surfaces::Surface
#import lightwell::sampling::visible_ggx_normal

// GGX α up to which lights are not seen through glass, as the camera itself sees none. Rougher glass shows their glow.
const CLEAR: f32 = 0.01;

// Where light goes on that has passed, and what is left of it.
struct Crossing {
    direction: vec3f,
    weight: vec3f,         // 0: none passes
}

// Fresnel's term with total reflection: where light leaves a body, Schlick's term is that of the angle outside.
fn fresnel_of(surface: Surface, cosine: f32) -> vec3f {
    var outside = cosine;
    if surface.is_inside {
        let sine_squared = surface.eta * surface.eta * (1.0 - cosine * cosine);
        if sine_squared >= 1.0 {
            return vec3f(1.0);
        }
        outside = sqrt(1.0 - sine_squared);
    }
    return fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, outside);
}

fn largest(value: vec3f) -> f32 {
    return max(value.r, max(value.g, value.b));
}

// Smith's masking of one direction (Walter et al. 2007, eq. 34).
fn masking(cosine: f32, alpha: f32) -> f32 {
    let c = max(cosine, 1e-6);
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * (1.0 - c * c) / (c * c)));
}

// What the surface reflects by its specular lobe alone, and how much of that there is: for the smooth inside of a body the
// term of the mean normal, which may be that of total reflection.
fn reflecting(surface: Surface, to_eye: vec3f) -> Surface {
    var result = surface;
    if surface.is_inside {
        let f = fresnel_of(surface, abs(dot(surface.normal, to_eye)));
        result.normal_reflectance = f;
        result.grazing_reflectance = largest(f);
    }
    return result;
}

// Chance to follow the light that passes rather than what is reflected.
fn crossing_share(surface: Surface, to_eye: vec3f) -> f32 {
    let f = fresnel_of(surface, abs(dot(surface.normal, to_eye)));
    let left = 1.0 - largest(f);
    let passes = largest(surface.passing) * left;
    let stays = largest(f) + largest(surface.albedo) * left;
    if passes <= 0.0 {
        return 0.0;
    }
    return select(clamp(passes / (passes + stays), 0.05, 0.95), 1.0, stays <= 0.0);
}

// A direction beyond the surface at a visible normal of it, and what passes that way over the chance of the direction.
fn cross_surface(surface: Surface, to_eye: vec3f, random: vec2f) -> Crossing {
    let n = surface.normal;
    if dot(n, to_eye) <= 0.0 {
        return Crossing(-to_eye, surface.passing);
    }
    let h = visible_ggx_normal(n, to_eye, surface.alpha, random);
    let cosine = dot(to_eye, h);
    let left = surface.passing * (1.0 - largest(fresnel_of(surface, cosine)));
    if !surface.is_solid {
        let mirrored = reflect(-to_eye, h);
        let up = dot(mirrored, n);
        return Crossing(mirrored - 2.0 * up * n, select(vec3f(0.0), left * masking(up, surface.alpha), up > 0.0));
    }
    let k = 1.0 - surface.eta * surface.eta * (1.0 - cosine * cosine);
    if k <= 0.0 {
        return Crossing(-to_eye, vec3f(0.0));
    }
    let direction = normalize(-surface.eta * to_eye + (surface.eta * cosine - sqrt(k)) * h);
    let down = -dot(direction, n);
    return Crossing(direction, select(vec3f(0.0), left * masking(down, surface.alpha), down > 0.0));
}

// The direction of a reflection at the same visible normal, and what is reflected that way over its chance.
fn mirror_at_surface(surface: Surface, to_eye: vec3f, random: vec2f) -> Crossing {
    let n = surface.normal;
    if dot(n, to_eye) <= 0.0 {
        return Crossing(to_eye, vec3f(0.0));
    }
    let h = visible_ggx_normal(n, to_eye, surface.alpha, random);
    let direction = reflect(-to_eye, h);
    let up = dot(direction, n);
    let f = fresnel_of(surface, dot(to_eye, h));
    return Crossing(direction, select(vec3f(0.0), f * masking(up, surface.alpha), up > 0.0));
}

// Radiance towards the eye over the light that arrives from a direction beyond the surface, times its cosine [1/sr]. Light on
// its way into a body goes on to another surface of it, which counts.
fn transmitted(surface: Surface, to_eye: vec3f, direction: vec3f) -> vec3f {
    let n = surface.normal;
    let down = -dot(direction, n);
    let n_dot_v = dot(n, to_eye);
    if surface.alpha <= CLEAR || down <= 0.0 || n_dot_v <= 0.0 || (surface.is_solid && !surface.is_inside) {
        return vec3f(0.0);
    }
    if !surface.is_solid {
        let mirrored = direction + 2.0 * down * n;
        let h = normalize(to_eye + mirrored);
        let left = surface.passing * (1.0 - largest(fresnel_of(surface, dot(to_eye, h))));
        return left * (distribution_ggx(n, h, surface.alpha) * visibility_smith(down, n_dot_v, surface.alpha) * down);
    }
    // Walter et al. 2007, eq. 16 and 21, for L/n².
    var h = surface.eta * to_eye + direction;
    h *= select(-1.0, 1.0, dot(h, n) >= 0.0) / max(length(h), 1e-20);
    let cosine = dot(to_eye, h);
    let beyond = dot(direction, h);
    if cosine <= 0.0 || beyond >= 0.0 {
        return vec3f(0.0);
    }
    let left = surface.passing * (1.0 - largest(fresnel_of(surface, cosine)));
    let shadowing = masking(n_dot_v, surface.alpha) * masking(down, surface.alpha);
    let spread = surface.eta * cosine + beyond;
    let density = distribution_ggx(n, h, surface.alpha) * cosine * -beyond / (n_dot_v * max(spread * spread, 1e-12));
    return left * (shadowing * density);
}
