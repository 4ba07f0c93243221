#define_import_path lightwell::next_event

// A vertex of a path: directions by the surface's reflection, and next-event estimation towards lights, emissive triangles
// and the sky. What both ways can find is weighted by the balance heuristic (Veach and Guibas 1995). What a scene does not
// have is left out: see lib/ray_scene.wgsl; UNLIT, no surface emits light; DIFFUSE, all surfaces are purely so; EVEN_SKY, the
// sky is alike in all directions; (the other way around) AREA_LIGHTS, a light has a surface; MEDIA, light passes through media,
// which weaken it on its way to where it is sampled, and whose points are vertices too.
//   NOT_ABSORBED  of light from emissive surfaces and the sky only that is lost which media absorb, not what they scatter

#import lightwell::brdf::{eval_brdf_cosine, fresnel_schlick, visible_normal_density}
#ifndef DIFFUSE
#import lightwell::environment::lobe_reflectance
#endif
#ifdef AREA_LIGHTS
#import lightwell::area_lights::{is_area, sample_incidence, meet_light}
#endif
#import lightwell::lights::{Incidence, Light, is_distant, light_incidence}
#ifdef LAYERED
#import lightwell::layered_brdf::{coat_share, layered_brdf_cosine, layered_density, sample_layer}
#import lightwell::ray_materials::emission_below_coat
#endif
#ifdef MEDIA
#import lightwell::media::{FARTHEST, Span, equiangular, equiangular_density, equiangular_distance, extinction_of_all, phase, scattered_direction, scattering_at, share_not_absorbed, transmittance}
#endif
#import lightwell::ray_materials::{coverage, emitted_at}
#import lightwell::ray_scene::{NONE, DOUBLE_SIDED, load_triangle, emitters, load_light}
#import lightwell::ray_surfaces::{Surface, leave_surface}
#ifdef MEDIA
#import lightwell::ray_surfaces::point_of_medium
#endif
#import lightwell::rays::{Ray, Hit}
#ifdef GLASS
#import lightwell::refraction::transmitted
#endif
#import lightwell::sampling::{INVERSE_PI, cosine_direction, is_chosen, visible_ggx_normal}
#import lightwell::sky::{sky_radiance, sky_density, sample_sky}

// Nothing brighter is counted, so that no sum over samples leaves the range of floats.
const MAX_RADIANCE: f32 = 1e30;

// Places on emissive surfaces of which `resample_emitter` takes one.
const EMITTER_CANDIDATES: u32 = 4u;

fn bounded(value: vec3f) -> vec3f {
    return clamp(value, vec3f(0.0), vec3f(MAX_RADIANCE));
}

// ---- Reflection ----

// Least GGX α of what is seen by a diffuse reflection.
const BLUR: f32 = 0.1;

// A surface whose specular lobe is no narrower than `least`, a GGX α. A light that a smooth surface mirrors to a diffuse one
// is a caustic there: rays hardly ever find it, and show it as a bright spot where they do. A wider lobe brings the same
// energy, to where it falls in the mean (path space regularization: Kaplanyan and Dachsbacher 2013).
fn blurred(surface: Surface, least: f32) -> Surface {
    var result = surface;
    result.alpha = max(surface.alpha, least);
#ifdef LAYERED
    result.coat_alpha = max(surface.coat_alpha, least);
    result.alpha_along = select(0.0, max(surface.alpha_along, least), surface.alpha_along > 0.0);
#endif
    return result;
}

// What a surface reflects by its specular lobes alone.
fn specular_of(surface: Surface) -> Surface {
    var result = surface;
    result.albedo = vec3f(0.0);
#ifdef LAYERED
    result.sheen = vec3f(0.0);
    result.sheen_albedo = vec3f(0.0);
#endif
    return result;
}

// Chance to sample the specular lobe.
fn specular_share(surface: Surface, to_eye: vec3f) -> f32 {
#ifdef MEDIA
    if surface.is_medium {
        return 0.0;
    }
#endif
#ifdef DIFFUSE
    return 0.0;
#else
    let n_dot_v = dot(surface.normal, to_eye);
    if n_dot_v <= 0.0 {
        return 0.0;
    }
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, n_dot_v);
    var specular = max(f.r, max(f.g, f.b));
    var diffuse = max(surface.albedo.r, max(surface.albedo.g, surface.albedo.b)) * (1.0 - specular);
#ifdef LAYERED
    specular += surface.coat;
    diffuse += max(surface.sheen_albedo.r, max(surface.sheen_albedo.g, surface.sheen_albedo.b));
#endif
    if specular <= 0.0 {
        return 0.0;
    }
    return select(clamp(specular / (specular + diffuse), 0.1, 0.9), 1.0, diffuse <= 0.0);
#endif
}

// Density with which `sample_direction` gives a direction [1/sr].
fn direction_density(surface: Surface, to_eye: vec3f, direction: vec3f, share: f32) -> f32 {
#ifdef MEDIA
    if surface.is_medium {
        return phase(surface.anisotropy, -dot(to_eye, direction));
    }
#endif
    let diffuse = max(0.0, dot(surface.normal, direction)) * INVERSE_PI;
#ifdef DIFFUSE
    return diffuse;
#else
    if share <= 0.0 {
        return diffuse;
    }
#ifdef LAYERED
    let specular = layered_density(surface, to_eye, direction);
#else
    let h = normalize(to_eye + direction);
    let specular = visible_normal_density(surface.normal, h, dot(surface.normal, to_eye), surface.alpha);
#endif
    return mix(diffuse, specular, share);
#endif
}

fn sample_direction(surface: Surface, to_eye: vec3f, share: f32, choice: f32, random: vec2f) -> vec3f {
#ifdef MEDIA
    if surface.is_medium {
        return scattered_direction(surface.anisotropy, -to_eye, random);
    }
#endif
#ifndef DIFFUSE
    if choice < share {
#ifdef LAYERED
        return sample_layer(surface, to_eye, choice / share, random);
#else
        let h = visible_ggx_normal(surface.normal, to_eye, surface.alpha, random);
        return reflect(-to_eye, h);
#endif
    }
#endif
    return cosine_direction(surface.normal, random);
}

// Reflected over incident radiance times n·l [1/sr].
fn reflected(surface: Surface, to_eye: vec3f, direction: vec3f) -> vec3f {
#ifdef MEDIA
    if surface.is_medium {
        return surface.albedo * phase(surface.anisotropy, -dot(to_eye, direction));
    }
#endif
    // What shines through from below the surface itself is none of its light.
    if dot(surface.geometric_normal, direction) <= 0.0 {
        return vec3f(0.0);
    }
#ifdef DIFFUSE
    return surface.albedo * (max(0.0, dot(surface.normal, direction)) * INVERSE_PI);
#else
#ifdef LAYERED
    return layered_brdf_cosine(surface, to_eye, direction);
#else
    return eval_brdf_cosine(
        surface.normal, to_eye, direction, surface.albedo, surface.normal_reflectance, surface.grazing_reflectance, surface.alpha,
    );
#endif
#endif
}

// GGX α of the lobe that `sample_direction` follows with these numbers; 1 for the diffuse ones.
fn alpha_of_choice(surface: Surface, to_eye: vec3f, share: f32, choice: f32) -> f32 {
    if choice >= share {
        return 1.0;
    }
#ifdef LAYERED
    return select(surface.alpha, surface.coat_alpha, choice < share * coat_share(surface, to_eye));
#else
    return surface.alpha;
#endif
}

// What counts of the light from lights: that which the surface reflects, or, where it is crossed, what passes it.
fn lit(surface: Surface, to_eye: vec3f, direction: vec3f) -> vec3f {
#ifdef GLASS
    if surface.is_crossed {
        return transmitted(surface, to_eye, direction);
    }
#endif
    return reflected(surface, to_eye, direction);
}

// Share of even light from all around that a surface reflects diffusely: its albedo, less what the specular lobe takes of it
// (Schlick's (1 − v·h)⁵ is 0.004 in the mean over diffuse directions).
fn diffuse_reflectance(surface: Surface) -> vec3f {
#ifdef DIFFUSE
    return surface.albedo;
#else
    let f = mix(surface.normal_reflectance, vec3f(surface.grazing_reflectance), 0.004);
    let base = surface.albedo * (1.0 - max(f.r, max(f.g, f.b)));
#ifdef LAYERED
    return base + surface.sheen_albedo;
#else
    return base;
#endif
#endif
}

// The same of all that it reflects towards a unit direction, by its specular lobe too.
fn even_reflectance(surface: Surface, to_eye: vec3f) -> vec3f {
    let diffuse = diffuse_reflectance(surface);
#ifdef DIFFUSE
    return diffuse;
#else
    let specular = lobe_reflectance(
        surface.normal_reflectance, surface.grazing_reflectance, sqrt(surface.alpha), dot(surface.normal, to_eye),
    );
#ifdef LAYERED
    return diffuse + specular + surface.coat;
#else
    return diffuse + specular;
#endif
#endif
}

// ---- Light that is sampled ----

// What a surface reflects towards the eye if the ray meets nothing up to its reach.
struct LightSample {
    light: vec3f,          // over the chance of the choice [W/(m² sr)]
    ray: Ray,
    reach: f32,            // 0: no ray is needed
    irradiance: f32,       // of a light at a point, on a plane across its light, all channels together [W/m²]
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0), Ray(vec3f(0.0), vec3f(0.0)), 0.0, 0.0);
}

// `share` of `sample_light` where no ray goes on that could meet the light.
const NO_RAY: f32 = -1.0;

#ifdef MEDIA
// Share of light from an emissive surface or the sky that media let pass to a point.
fn passing(position: vec3f, direction: vec3f, distance: f32) -> vec3f {
#ifdef NOT_ABSORBED
    return share_not_absorbed(position, direction, distance);
#else
    return vec3f(transmittance(position, direction, distance));
#endif
}
#endif

// Light from a point of a light, which two random numbers choose if it has a surface.
fn incidence_of(light: Light, position: vec3f, on_light: vec2f) -> Incidence {
#ifdef AREA_LIGHTS
    return sample_incidence(light, position, on_light);
#else
    return light_incidence(light, position);
#endif
}

// Weight of a sampled point of a light against the ray that goes on, by the specular lobe with a chance of `share`, and may
// meet it too.
fn light_weight(surface: Surface, to_eye: vec3f, share: f32, incidence: Incidence) -> f32 {
#ifdef AREA_LIGHTS
    if share >= 0.0 && incidence.solid_angle > 0.0 {
        return 1.0 / (1.0 + incidence.solid_angle * direction_density(surface, to_eye, incidence.to_light, share));
    }
#endif
    return 1.0;
}

#ifdef MEDIA
// The part of a ray on which a path is scattered, for the lights that a point on it sees. Without density there is none: a point
// of a medium then counts for all light.
struct Segment {
    origin: vec3f,
    direction: vec3f,      // unit
    span: Span,
    distance: f32,         // of the point where the path was scattered [m]
    density: f32,          // of that distance [1/m]
    lights: f32,           // of which one is chosen for `sample_segment`
}

var<private> segment: Segment;

// Weight of the light that a point where a path is scattered has of a light, against `sample_segment` (balance heuristic).
fn weight_of_collision(surface: Surface, light: Light) -> f32 {
    if !surface.is_medium || segment.density <= 0.0 || is_distant(light) {
        return 1.0;
    }
    let e = equiangular(segment.origin, segment.direction, segment.span, light.position);
    return segment.density / (segment.density + equiangular_density(e, segment.distance) / segment.lights);
}

// Light of one light that media scatter on the way of a ray to its beginning, at a point near that light: where the path itself
// is scattered, a light is hardly ever near.
fn sample_segment(index: u32, is_direct: bool, random: f32, on_light: vec2f) -> LightSample {
    let candidate = load_light(index);
    if is_distant(candidate.light) || (!is_direct && candidate.indirect == 0u) || segment.span.end <= segment.span.begin {
        return no_light();
    }
    let e = equiangular(segment.origin, segment.direction, segment.span, candidate.light.position);
    let distance = clamp(equiangular_distance(e, random), segment.span.begin, segment.span.end);
    let position = segment.origin + segment.direction * distance;
    let incidence = incidence_of(candidate.light, position, on_light);
    let scattering = scattering_at(position, dot(incidence.to_light, segment.direction));
    if all(incidence.irradiance <= vec3f(0.0)) || all(scattering <= vec3f(0.0)) {
        return no_light();
    }
    let passing = transmittance(segment.origin, segment.direction, distance);
    let of_collisions = extinction_of_all(position) * passing;
    let density = equiangular_density(e, distance) / segment.lights + of_collisions;
    let light = bounded(scattering * incidence.irradiance * (passing / density));
    return toward_light(point_of_medium(position, vec3f(0.0), 0.0), incidence, light, candidate.casts_shadow != 0u);
}
#endif

// Lights with the numbers from `begin` on, without `end`.
struct LightRange {
    begin: u32,
    end: u32,
}

// One light of a range, chosen in proportion to what each would bring if nothing were in its way (weighted reservoir,
// Chao 1982): a single light is sampled without noise. Lights that feed no indirect light are left out unless the light
// is direct.
fn sample_light(
    surface: Surface, to_eye: vec3f, share: f32, range: LightRange, is_direct: bool, random: f32, on_light: vec2f,
) -> LightSample {
    var total = 0.0;
    var chosen: Incidence;
    var chosen_weight = 0.0;
    var chosen_light = vec3f(0.0);
    var casts_shadow = false;
    var pick = random;
    for (var i = range.begin; i < range.end; i++) {
        let candidate = load_light(i);
        if !is_direct && candidate.indirect == 0u {
            continue;
        }
        let incidence = incidence_of(candidate.light, surface.position, on_light);
        if all(incidence.irradiance <= vec3f(0.0)) {
            continue;
        }
        var light = bounded(lit(surface, to_eye, incidence.to_light) * incidence.irradiance);
#ifdef MEDIA
        light *= weight_of_collision(surface, candidate.light);
#endif
        let weight = light.r + light.g + light.b;
        if weight <= 0.0 {
            continue;
        }
        total += weight;
        if is_chosen(&pick, weight / total) {
            chosen = incidence;
            casts_shadow = candidate.casts_shadow != 0u;
            chosen_weight = weight;
            chosen_light = light;
        }
    }
    if chosen_weight <= 0.0 {
        return no_light();
    }
    let found = light_weight(surface, to_eye, share, chosen);
    return toward_light(surface, chosen, chosen_light * (found * total / chosen_weight), casts_shadow);
}

#ifdef AREA_LIGHTS
// Radiance that a ray in a unit direction, sampled with that density, finds on the surfaces of lights, up to where it meets the
// scene, over what `sample_light` finds of them. With L/(p + 1/ω) written as E·p/(1 + ω·p): no light is divided by its size.
fn radiance_of_lights(origin: vec3f, direction: vec3f, density: f32, hit_distance: f32, count: u32, is_direct: bool) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < count; i++) {
        let candidate = load_light(i);
        if !is_area(candidate.light) || (!is_direct && candidate.indirect == 0u) {
            continue;
        }
        let incidence = meet_light(candidate.light, origin, direction);
        // As for its samples, nothing stands before a light that casts no shadow; the sun lies behind all.
        let distance = select(incidence.distance, 1e38, incidence.distance == 0.0);
        if all(incidence.irradiance <= vec3f(0.0)) || (candidate.casts_shadow != 0u && 0.9999 * distance > hit_distance) {
            continue;
        }
        sum += bounded(incidence.irradiance * (density / (1.0 + incidence.solid_angle * density)));
    }
    return bounded(sum);
}
#endif

// What a surface reflects of a light if nothing is between them.
fn toward_light(surface: Surface, incidence: Incidence, unweakened: vec3f, casts_shadow: bool) -> LightSample {
    var reflected_light = unweakened;
#ifdef MEDIA
    let distance = select(incidence.distance, FARTHEST, incidence.distance == 0.0);
    reflected_light *= transmittance(surface.position, incidence.to_light, distance);
#endif
    // Points that a light with a surface reaches are not drawn from its reflective shadow map, which sees from one point.
    let e = select(incidence.irradiance, vec3f(0.0), incidence.solid_angle > 0.0);
    let irradiance = e.r + e.g + e.b;
    if !casts_shadow {
        return LightSample(reflected_light, Ray(vec3f(0.0), vec3f(0.0)), 0.0, irradiance);
    }
    let origin = leave_surface(surface, incidence.to_light);
    // To the light itself, whose distance is not that of the moved origin; directional light comes from far.
    let is_far = incidence.distance == 0.0;
    let offset = surface.position + incidence.to_light * incidence.distance - origin;
    let ray = Ray(origin, select(offset, incidence.to_light, is_far));
    // The surface of a light may lie on one of the scene.
    let reach = select(1.0, 0.9999, incidence.solid_angle > 0.0);
    return LightSample(reflected_light, ray, select(reach, 3e38, is_far), irradiance);
}

#ifndef UNLIT
fn choose_emitter(count: u32, random: f32) -> u32 {
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if emitters[middle].cumulative > random {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

// A place on an emissive triangle, chosen by flux, as one of `candidates`, weighted against `sample_direction`.
fn sample_emitter(
    surface: Surface, to_eye: vec3f, share: f32, count: u32, candidates: f32, choice: f32, on_triangle: vec2f,
) -> LightSample {
    let emitter = emitters[choose_emitter(count, choice)];
    let triangle = load_triangle(emitter.triangle);
    // Uniform over the triangle (Turk 1990).
    let root = sqrt(on_triangle.x);
    let barycentric = vec2f(root * (1.0 - on_triangle.y), root * on_triangle.y);
    let a = triangle.corner_a;
    let b = triangle.corner_b;
    let c = triangle.corner_c;
    let place_on = a + barycentric.x * (b - a) + barycentric.y * (c - a);
    let offset = place_on - surface.position;
    let distance_squared = dot(offset, offset);
    if distance_squared <= 0.0 {
        return no_light();
    }
    let direction = offset * inverseSqrt(distance_squared);
    let response = reflected(surface, to_eye, direction);
    let outward = cross(b - a, c - a);
    let facing = -dot(outward, direction) / length(outward);
    let both_sides = (triangle.flags & DOUBLE_SIDED) != 0u;
    let cosine = select(facing, abs(facing), both_sides);
    if cosine <= 0.0 || all(response <= vec3f(0.0)) {
        return no_light();
    }
    // Solid angle of the triangle's area as seen from here.
    let density = candidates * (emitter.density * distance_squared / cosine);
    let weight = density / (density + direction_density(surface, to_eye, direction, share));
    var emitted = emitted_at(emitter.triangle, triangle.material, barycentric)
        * coverage(emitter.triangle, triangle.material, barycentric);
#ifdef LAYERED
    emitted *= emission_below_coat(emitter.triangle, triangle.material, barycentric, cosine);
#endif
    let origin = leave_surface(surface, direction);
    var light = response * emitted * (weight / density);
#ifdef MEDIA
    light *= passing(surface.position, direction, sqrt(distance_squared));
#endif
    return LightSample(light, Ray(origin, place_on - origin), 0.9999, 0.0);
}

// Of several places the one that brings most if nothing is in its way is the likeliest to be chosen (resampling: Talbot,
// Cline and Egbert 2005): beside something that glows most places on it are too far off or turned away. The first pair
// chooses emitters and among the places, the second places on them: each candidate's is shifted by a step of the R2
// sequence (Roberts 2018), so that they lie apart.
fn resample_emitter(
    surface: Surface, to_eye: vec3f, share: f32, count: u32, choice: vec2f, on_triangle: vec2f,
) -> LightSample {
    var chosen = no_light();
    var chosen_weight = 0.0;
    var total = 0.0;
    var pick = choice.y;
    for (var i = 0u; i < EMITTER_CANDIDATES; i++) {
        let step = f32(i);
        let emitter = fract(choice.x + step / f32(EMITTER_CANDIDATES));
        let place = fract(on_triangle + step * vec2f(0.7548776662, 0.5698402909));
        let sample = sample_emitter(surface, to_eye, share, count, f32(EMITTER_CANDIDATES), emitter, place);
        let light = bounded(sample.light);
        let weight = light.r + light.g + light.b;
        if weight <= 0.0 {
            continue;
        }
        total += weight;
        if is_chosen(&pick, weight / total) {
            chosen = sample;
            chosen_weight = weight;
        }
    }
    chosen.light *= total / max(chosen_weight, 1e-37);
    return chosen;
}
#endif

// Weight of the emission of a surface that a ray in a unit direction, sampled with that density, has met, against
// so many candidates of `sample_emitter` where the ray came from.
fn emission_weight(surface: Surface, hit: Hit, direction: vec3f, density: f32, candidates: f32) -> f32 {
#ifndef UNLIT
    if surface.emitter != NONE {
        let per_area = candidates * emitters[surface.emitter].density;
        let of_emitter = per_area * hit.t * hit.t / max(1e-20, abs(dot(surface.geometric_normal, direction)));
        return density / (density + of_emitter);
    }
#endif
    return 1.0;
}

#ifndef EVEN_SKY
// A direction that is chosen by the flux of the sky's texels, weighted against `sample_direction`.
fn sample_sky_light(
    sky: texture_2d<f32>, turn: f32, surface: Surface, to_eye: vec3f, share: f32, choice: vec2f, within: vec2f,
) -> LightSample {
    let chosen = sample_sky(sky, turn, choice, within);
    let response = reflected(surface, to_eye, chosen.direction);
    if !(chosen.density > 0.0) || all(response <= vec3f(0.0)) {
        return no_light();
    }
    let weight = chosen.density / (chosen.density + direction_density(surface, to_eye, chosen.direction, share));
    let radiance = sky_radiance(sky, chosen.direction, turn);
    let ray = Ray(leave_surface(surface, chosen.direction), chosen.direction);
    var light = response * radiance * (weight / chosen.density);
#ifdef MEDIA
    light *= passing(surface.position, chosen.direction, FARTHEST);
#endif
    return LightSample(light, ray, 3e38, 0.0);
}

// Weight of the sky's radiance in a direction that was sampled with that density, against `sample_sky_light`.
fn sky_weight(sky: texture_2d<f32>, turn: f32, direction: vec3f, density: f32) -> f32 {
    return density / (density + sky_density(sky, direction, turn));
}
#endif
