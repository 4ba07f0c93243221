#define_import_path lightwell::layered_brdf

// What a surface with layers reflects, and directions by its lobes. See lib/layers.wgsl.

#import lightwell::brdf::{PI, distribution_ggx, fresnel_schlick, visibility_smith, visible_normal_density}
#import lightwell::layers::{film_reflectance, sheen_lobe, stretched_density, stretched_lobe}
#import lightwell::ray_surfaces::Surface
#import lightwell::sampling::{visible_ggx_normal, visible_normal_in}

// Of the base, at the microfacets of a half vector.
fn fresnel_of_base(surface: Surface, cosine: f32) -> vec3f {
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, cosine);
    if surface.film <= 0.0 {
        return f;
    }
    let bare = fresnel_schlick(surface.film_base * surface.film_left, surface.grazing_reflectance, cosine);
    let film = film_reflectance(surface.film_base, surface.film_ior, surface.film_thickness, cosine);
    return mix(bare, film * surface.film_left, surface.film);
}

// D·V of the base.
fn lobe_of_base(surface: Surface, v: vec3f, l: vec3f, h: vec3f) -> f32 {
    if surface.alpha_along > 0.0 {
        return stretched_lobe(surface.normal, surface.along, v, l, h, vec2f(surface.alpha_along, surface.alpha));
    }
    let n_dot_v = max(dot(surface.normal, v), 1e-4);
    return distribution_ggx(surface.normal, h, surface.alpha)
        * visibility_smith(dot(surface.normal, l), n_dot_v, surface.alpha);
}

// Reflected over incident radiance times n·l [1/sr], as `eval_brdf_cosine` of lib/brdf.wgsl.
fn layered_brdf_cosine(surface: Surface, v: vec3f, l: vec3f) -> vec3f {
    let half_sum = v + l;
    let length_squared = dot(half_sum, half_sum);
    if length_squared < 1e-12 {
        return surface.albedo * (max(dot(surface.normal, l), 0.0) / PI);
    }
    let h = half_sum * inverseSqrt(length_squared);
    var sum = vec3f(0.0);
    let n_dot_l = dot(surface.normal, l);
    if n_dot_l > 0.0 {
        let f = fresnel_of_base(surface, dot(v, h));
        sum = (1.0 - max(f.r, max(f.g, f.b))) * surface.albedo / PI + f * lobe_of_base(surface, v, l, h);
        if any(surface.sheen > vec3f(0.0)) {
            let n_dot_v = max(dot(surface.normal, v), 1e-4);
            sum += surface.sheen * sheen_lobe(surface.sheen_roughness, dot(surface.normal, h), n_dot_l, n_dot_v);
        }
        sum *= n_dot_l;
    }
    let coat_dot_l = dot(surface.coat_normal, l);
    if surface.coat > 0.0 && coat_dot_l > 0.0 {
        let coat_dot_v = max(dot(surface.coat_normal, v), 1e-4);
        let lobe = distribution_ggx(surface.coat_normal, h, surface.coat_alpha)
            * visibility_smith(coat_dot_l, coat_dot_v, surface.coat_alpha);
        sum += surface.coat * lobe * coat_dot_l;
    }
    return sum;
}

// Chance to follow the lobe of the coat where one of the specular lobes is followed.
fn coat_share(surface: Surface, to_eye: vec3f) -> f32 {
    if surface.coat <= 0.0 || dot(surface.coat_normal, to_eye) <= 0.0 {
        return 0.0;
    }
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, dot(surface.normal, to_eye));
    let base = max(f.r, max(f.g, f.b));
    return select(clamp(surface.coat / (surface.coat + base), 0.1, 0.9), 1.0, base <= 0.0);
}

// A direction by one of the specular lobes.
fn sample_layer(surface: Surface, to_eye: vec3f, choice: f32, random: vec2f) -> vec3f {
    var h: vec3f;
    if choice < coat_share(surface, to_eye) {
        h = visible_ggx_normal(surface.coat_normal, to_eye, surface.coat_alpha, random);
    } else if surface.alpha_along > 0.0 {
        let frame = mat3x3f(surface.along, cross(surface.normal, surface.along), surface.normal);
        h = visible_normal_in(frame, to_eye, vec2f(surface.alpha_along, surface.alpha), random);
    } else {
        h = visible_ggx_normal(surface.normal, to_eye, surface.alpha, random);
    }
    return reflect(-to_eye, h);
}

// Density with which `sample_layer` gives a direction [1/sr].
fn layered_density(surface: Surface, to_eye: vec3f, direction: vec3f) -> f32 {
    let h = normalize(to_eye + direction);
    var base = 0.0;
    if surface.alpha_along > 0.0 {
        base = stretched_density(surface.normal, surface.along, to_eye, h, vec2f(surface.alpha_along, surface.alpha));
    } else {
        base = visible_normal_density(surface.normal, h, dot(surface.normal, to_eye), surface.alpha);
    }
    let share = coat_share(surface, to_eye);
    if share <= 0.0 {
        return base;
    }
    let coat = visible_normal_density(surface.coat_normal, h, dot(surface.coat_normal, to_eye), surface.coat_alpha);
    return mix(base, coat, share);
}
