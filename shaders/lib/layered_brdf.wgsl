#define_import_path lightwell::layered_brdf

// What a surface with layers reflects, and directions by its lobes. See lib/layers.wgsl. What a scene has none of is left out:
// COATS, SHEEN, FILMS, ANISOTROPY, see lib/ray_scene.wgsl.
//   EXACT_FILMS   films reflect by the angle at the microfacets, not by that of the view with Schlick's term

#import lightwell::brdf::{PI, distribution_ggx, fresnel_schlick, visibility_smith, visible_normal_density}
#import lightwell::layers::{film_reflectance, sheen_lobe, stretched_density, stretched_lobe}
#import lightwell::ray_surfaces::Surface
#import lightwell::sampling::{visible_ggx_normal, visible_normal_in}

// Of the base, at the microfacets of a half vector.
fn fresnel_of_base(surface: Surface, cosine: f32) -> vec3f {
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, cosine);
#ifdef FILMS
#ifdef EXACT_FILMS
    if surface.film > 0.0 {
        let bare = fresnel_schlick(surface.film_base * surface.film_left, surface.grazing_reflectance, cosine);
        let film = film_reflectance(surface.film_base, surface.film_ior, surface.film_thickness, cosine);
        return mix(bare, film * surface.film_left, surface.film);
    }
#endif
#endif
    return f;
}

// D·V of the base.
fn lobe_of_base(surface: Surface, v: vec3f, l: vec3f, h: vec3f) -> f32 {
#ifdef ANISOTROPY
    if surface.alpha_along > 0.0 {
        return stretched_lobe(surface.normal, surface.along, v, l, h, vec2f(surface.alpha_along, surface.alpha));
    }
#endif
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
#ifdef SHEEN
        if any(surface.sheen > vec3f(0.0)) {
            let n_dot_v = max(dot(surface.normal, v), 1e-4);
            sum += surface.sheen * sheen_lobe(surface.sheen_roughness, dot(surface.normal, h), n_dot_l, n_dot_v);
        }
#endif
        sum *= n_dot_l;
    }
#ifdef COATS
    let coat_dot_l = dot(surface.coat_normal, l);
    if surface.coat > 0.0 && coat_dot_l > 0.0 {
        let coat_dot_v = max(dot(surface.coat_normal, v), 1e-4);
        let lobe = distribution_ggx(surface.coat_normal, h, surface.coat_alpha)
            * visibility_smith(coat_dot_l, coat_dot_v, surface.coat_alpha);
        sum += surface.coat * lobe * coat_dot_l;
    }
#endif
    return sum;
}

// Chance to follow the lobe of the coat where one of the specular lobes is followed.
fn coat_share(surface: Surface, to_eye: vec3f) -> f32 {
#ifdef COATS
    if surface.coat <= 0.0 || dot(surface.coat_normal, to_eye) <= 0.0 {
        return 0.0;
    }
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, dot(surface.normal, to_eye));
    let base = max(f.r, max(f.g, f.b));
    return select(clamp(surface.coat / (surface.coat + base), 0.1, 0.9), 1.0, base <= 0.0);
#else
    return 0.0;
#endif
}

// A direction by one of the specular lobes.
fn sample_layer(surface: Surface, to_eye: vec3f, choice: f32, random: vec2f) -> vec3f {
    let of_coat = choice < coat_share(surface, to_eye);
    let n = select(surface.normal, surface.coat_normal, of_coat);
    let alpha = select(surface.alpha, surface.coat_alpha, of_coat);
#ifdef ANISOTROPY
    if !of_coat && surface.alpha_along > 0.0 {
        let frame = mat3x3f(surface.along, cross(n, surface.along), n);
        return reflect(-to_eye, visible_normal_in(frame, to_eye, vec2f(surface.alpha_along, alpha), random));
    }
#endif
    return reflect(-to_eye, visible_ggx_normal(n, to_eye, alpha, random));
}

// Density with which `sample_layer` gives a direction [1/sr].
fn layered_density(surface: Surface, to_eye: vec3f, direction: vec3f) -> f32 {
    let h = normalize(to_eye + direction);
    var density = visible_normal_density(surface.normal, h, dot(surface.normal, to_eye), surface.alpha);
#ifdef ANISOTROPY
    if surface.alpha_along > 0.0 {
        density = stretched_density(surface.normal, surface.along, to_eye, h, vec2f(surface.alpha_along, surface.alpha));
    }
#endif
#ifdef COATS
    let share = coat_share(surface, to_eye);
    if share > 0.0 {
        let coat = visible_normal_density(surface.coat_normal, h, dot(surface.coat_normal, to_eye), surface.coat_alpha);
        density = mix(density, coat, share);
    }
#endif
    return density;
}
