// Path tracing (Kajiya 1986): the reference that every other method is measured against.
//
// A vertex of a path gathers light in two ways: next-event estimation towards the lights and towards the emissive
// triangles, and by the ray that goes on, which may itself meet an emissive surface or the sky. What both ways can
// find is weighted by the balance heuristic (Veach and Guibas 1995). Materials and lights are those of the raster
// passes. What a scene does not have is left out of the shader (see lib/rays.wgsl): UNLIT, no surface emits light;
// DIFFUSE, all surfaces are purely so; EVEN_SKY, the sky is alike in all directions;
// ORTHOGRAPHIC, the lines of sight are parallel. Direct light is what comes straight from the lights to the surface that the camera sees, with that
// surface's own emission; all else is indirect, and `bounces` counts the rays that go on.

#import lightwell::brdf::{eval_brdf_cosine, fresnel_schlick, distribution_ggx}
#import lightwell::lights::{Incidence, light_incidence}
#import lightwell::rays::{Ray, Hit, Surface, CAMERA, LIGHT, SHADOW, NONE, DOUBLE_SIDED, Frame, Walk, load_frame, begin_walk, is_over, go_on, trace, surface_at, leave_surface, load_triangle, emitted_at, coverage, materials, emitters, load_light}
#import lightwell::sky::{sky_radiance, sky_density, sample_sky}
#import lightwell::sampling::{Sampler, INVERSE_PI, hash_pair, next_pair, cosine_direction, visible_ggx_normal}

struct Trace {
    eye: vec3f,
    near: f32,             // [m]
    right: vec3f,          // half the image plane at distance 1
    far: f32,              // [m]
    up: vec3f,
    bounces: u32,          // most rays that go on; all: unlimited
    forward: vec3f,        // unit
    seed: u32,
    sky: vec3f,            // radiance [W/(m² sr)]
    root: u32,
    size: vec2u,           // [pixels]
    jitter: vec2f,         // shift of the pixel grid [pixels]
    first_row: u32,        // of this dispatch
    first_sample: u32,
    samples: u32,          // of this dispatch
    light_count: u32,
    emitter_count: u32,
    sky_turn: f32,         // of the sky's map [rad]
}

@group(0) @binding(0) var<uniform> params: Trace;
// Sums of each pixel: direct and indirect light of the even samples, then of the odd ones.
@group(0) @binding(1) var<storage, read_write> sums: array<vec4f>;
@group(0) @binding(2) var sky: texture_2d<f32>;

// Nothing brighter is counted, so that no sum over samples leaves the range of floats.
const MAX_RADIANCE: f32 = 1e30;
// Rays that go on in "unlimited" paths: the chance to get here is below 1e-9, see `survives`.
const MAX_BOUNCES: u32 = 1024u;
// Rays that always go on; later ones by Russian roulette.
const SAFE_BOUNCES: u32 = 3u;

struct Path {
    ray: Ray,
    near: f32,
    reach: f32,
    throughput: vec3f,
    density: f32,          // of the direction that was sampled last [1/sr]
    vertices: u32,         // surfaces met so far
    direct: vec3f,
    indirect: vec3f,
    shadow: Shadow,
}

// Light on its way to a vertex, until it is known whether anything is in the way: its ray is traced together with the
// ray that goes on.
struct Shadow {
    ray: Ray,
    reach: f32,            // 0: there is none
    light: vec3f,          // that the path brings to the eye if nothing is in the way
    is_direct: bool,
}

fn bounded(value: vec3f) -> vec3f {
    return clamp(value, vec3f(0.0), vec3f(MAX_RADIANCE));
}

fn add(path: ptr<function, Path>, radiance: vec3f, is_direct: bool) {
    let value = bounded((*path).throughput * bounded(radiance));
    if is_direct {
        (*path).direct += value;
    } else {
        (*path).indirect += value;
    }
}

// Starts anew, but for what the last path has still to bring.
fn start_path(path: ptr<function, Path>, pixel: vec2u, random: ptr<function, Sampler>) {
    let at = (vec2f(pixel) - params.jitter + next_pair(random)) / vec2f(params.size) * 2.0 - 1.0;
#ifdef ORTHOGRAPHIC
    let eye = params.eye + at.x * params.right - at.y * params.up;
    (*path).ray = Ray(eye + params.forward * params.near, params.forward);
#else
    let direction = params.forward + at.x * params.right - at.y * params.up;
    // Not of unit length: the near and far planes lie at fixed distances along the axis.
    (*path).ray = Ray(params.eye + direction * params.near, direction);
#endif
    (*path).reach = params.far - params.near;
    (*path).throughput = vec3f(1.0);
    (*path).density = 0.0;
    (*path).vertices = 0u;
}

// ---- Reflection ----

// Chance to sample the specular lobe.
fn specular_share(surface: Surface, to_eye: vec3f) -> f32 {
#ifdef DIFFUSE
    return 0.0;
#else
    let n_dot_v = dot(surface.normal, to_eye);
    if n_dot_v <= 0.0 {
        return 0.0;
    }
    let f = fresnel_schlick(surface.normal_reflectance, surface.grazing_reflectance, n_dot_v);
    let specular = max(f.r, max(f.g, f.b));
    let diffuse = max(surface.albedo.r, max(surface.albedo.g, surface.albedo.b)) * (1.0 - specular);
    if specular <= 0.0 {
        return 0.0;
    }
    return select(clamp(specular / (specular + diffuse), 0.1, 0.9), 1.0, diffuse <= 0.0);
#endif
}

// Density with which `sample_direction` gives a direction [1/sr].
fn direction_density(surface: Surface, to_eye: vec3f, direction: vec3f, share: f32) -> f32 {
    let diffuse = max(0.0, dot(surface.normal, direction)) * INVERSE_PI;
#ifdef DIFFUSE
    return diffuse;
#else
    if share <= 0.0 {
        return diffuse;
    }
    // Density of visible normals over 4·v·h: G₁(v)·D/(4·n·v) (Heitz 2018, eq. 17).
    let h = normalize(to_eye + direction);
    let n_dot_v = dot(surface.normal, to_eye);
    let a2 = surface.alpha * surface.alpha;
    let d = distribution_ggx(surface.normal, h, surface.alpha);
    let specular = d / (2.0 * (n_dot_v + sqrt(a2 + (1.0 - a2) * n_dot_v * n_dot_v)));
    return mix(diffuse, specular, share);
#endif
}

fn sample_direction(surface: Surface, to_eye: vec3f, share: f32, choice: f32, random: vec2f) -> vec3f {
#ifndef DIFFUSE
    if choice < share {
        let h = visible_ggx_normal(surface.normal, to_eye, surface.alpha, random);
        return reflect(-to_eye, h);
    }
#endif
    return cosine_direction(surface.normal, random);
}

fn reflected(surface: Surface, to_eye: vec3f, direction: vec3f) -> vec3f {
    // What shines through from below the surface itself is none of its light.
    if dot(surface.geometric_normal, direction) <= 0.0 {
        return vec3f(0.0);
    }
#ifdef DIFFUSE
    return surface.albedo * (max(0.0, dot(surface.normal, direction)) * INVERSE_PI);
#else
    return eval_brdf_cosine(
        surface.normal, to_eye, direction, surface.albedo, surface.normal_reflectance, surface.grazing_reflectance, surface.alpha,
    );
#endif
}

// ---- Next-event estimation ----

// One light, chosen in proportion to what each would bring if nothing were in its way (weighted reservoir,
// Chao 1982): a single light is sampled without noise.
fn add_light(path: ptr<function, Path>, surface: Surface, to_eye: vec3f, random: ptr<function, Sampler>) {
    let is_direct = (*path).vertices == 1u;
    var total = 0.0;
    var chosen: Incidence;
    var chosen_weight = 0.0;
    var chosen_light = vec3f(0.0);
    var casts_shadow = false;
    var pick = 0.0;
    if params.light_count > 1u {
        pick = next_pair(random).x;
    }
    for (var i = 0u; i < params.light_count; i++) {
        let candidate = load_light(i);
        if !is_direct && candidate.indirect == 0u {
            continue;
        }
        let incidence = light_incidence(candidate.light, surface.position);
        if all(incidence.irradiance <= vec3f(0.0)) {
            continue;
        }
        let light = bounded(reflected(surface, to_eye, incidence.to_light) * incidence.irradiance);
        let weight = light.r + light.g + light.b;
        if weight <= 0.0 {
            continue;
        }
        total += weight;
        // The random number is used up and stretched again at each choice.
        let chance = weight / total;
        if pick < chance {
            pick /= chance;
            chosen = incidence;
            casts_shadow = candidate.casts_shadow != 0u;
            chosen_weight = weight;
            chosen_light = light;
        } else {
            pick = (pick - chance) / (1.0 - chance);
        }
    }
    if chosen_weight <= 0.0 {
        return;
    }
    let light = chosen_light * (total / chosen_weight);
    if !casts_shadow {
        add(path, light, is_direct);
        return;
    }
    let origin = leave_surface(surface, chosen.to_light);
    // To the light itself, whose distance is not that of the moved origin; directional light comes from far.
    let is_far = chosen.distance == 0.0;
    let offset = surface.position + chosen.to_light * chosen.distance - origin;
    let ray = Ray(origin, select(offset, chosen.to_light, is_far));
    (*path).shadow = Shadow(ray, select(1.0, 3e38, is_far), bounded((*path).throughput * bounded(light)), is_direct);
}

#ifndef UNLIT
fn choose_emitter(random: f32) -> u32 {
    var low = 0u;
    var high = params.emitter_count - 1u;
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

fn add_emitter(path: ptr<function, Path>, surface: Surface, to_eye: vec3f, share: f32, random: ptr<function, Sampler>) {
    let choice = next_pair(random);
    let on_triangle = next_pair(random);
    let emitter = emitters[choose_emitter(choice.x)];
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
        return;
    }
    let direction = offset * inverseSqrt(distance_squared);
    let response = reflected(surface, to_eye, direction);
    let outward = cross(b - a, c - a);
    let facing = -dot(outward, direction) / length(outward);
    let both_sides = (triangle.flags & DOUBLE_SIDED) != 0u;
    let cosine = select(facing, abs(facing), both_sides);
    if cosine <= 0.0 || all(response <= vec3f(0.0)) {
        return;
    }
    // Solid angle of the triangle's area as seen from here.
    let density = emitter.density * distance_squared / cosine;
    let origin = leave_surface(surface, direction);
    if trace(params.root, Ray(origin, place_on - origin), 0.9999, SHADOW).triangle != NONE {
        return;
    }
    let weight = density / (density + direction_density(surface, to_eye, direction, share));
    let emitted = emitted_at(emitter.triangle, triangle.material, barycentric)
        * coverage(emitter.triangle, triangle.material, barycentric);
    add(path, response * emitted * (weight / density), false);
}

#endif

// Emission of a surface that a path met, weighted against `add_emitter` of the vertex before.
fn add_emission(path: ptr<function, Path>, surface: Surface, hit: Hit) {
    if all(surface.emissive <= vec3f(0.0)) {
        return;
    }
    if (*path).vertices == 1u {
        add(path, surface.emissive, true);
        return;
    }
    var weight = 1.0;
#ifndef UNLIT
    if surface.emitter != NONE {
        let per_area = emitters[surface.emitter].density;
        // The ray's direction is of unit length here.
        let density = per_area * hit.t * hit.t / max(1e-20, abs(dot(surface.geometric_normal, (*path).ray.direction)));
        weight = (*path).density / ((*path).density + density);
    }
#endif
    add(path, surface.emissive * weight, false);
}

// ---- The sky ----

// What a path finds that leaves the scene, weighted against `choose_sky` of the vertex before.
fn add_sky(path: ptr<function, Path>) {
    let is_direct = (*path).vertices == 0u;
#ifdef EVEN_SKY
    add(path, params.sky, is_direct);
#else
    let d = normalize((*path).ray.direction);
    var weight = 1.0;
    if !is_direct {
        weight = (*path).density / ((*path).density + sky_density(sky, d, params.sky_turn));
    }
    add(path, sky_radiance(sky, d, params.sky_turn) * weight, is_direct);
#endif
}

#ifndef EVEN_SKY
// Next-event estimation towards a direction that is chosen by the flux of the sky's texels.
fn choose_sky(path: ptr<function, Path>, surface: Surface, to_eye: vec3f, share: f32, random: ptr<function, Sampler>) {
    let choice = next_pair(random);
    let chosen = sample_sky(sky, params.sky_turn, choice, next_pair(random));
    let response = reflected(surface, to_eye, chosen.direction);
    if !(chosen.density > 0.0) || all(response <= vec3f(0.0)) {
        return;
    }
    let ray = Ray(leave_surface(surface, chosen.direction), chosen.direction);
    if trace(params.root, ray, 3e38, SHADOW).triangle != NONE {
        return;
    }
    let weight = chosen.density / (chosen.density + direction_density(surface, to_eye, chosen.direction, share));
    let radiance = sky_radiance(sky, chosen.direction, params.sky_turn);
    add(path, response * radiance * (weight / chosen.density), false);
}
#endif

// ---- The path ----

// Russian roulette (Arvo and Kirk 1990): the throughput of what goes on is divided by the chance to go on.
fn survives(path: ptr<function, Path>, random: f32) -> bool {
    if (*path).vertices <= SAFE_BOUNCES {
        return true;
    }
    let t = (*path).throughput;
    let chance = clamp(max(t.r, max(t.g, t.b)), 0.05, 0.98);
    (*path).throughput /= chance;
    return random < chance;
}

// The ray to the light, or the one that goes on.
fn walk_of(frame: Frame, path: Path, in_shadow: bool) -> Walk {
    if in_shadow {
        return begin_walk(frame, path.shadow.ray, path.shadow.reach, SHADOW);
    }
    return begin_walk(frame, path.ray, path.reach, select(LIGHT, CAMERA, path.vertices == 0u));
}

// Traces the path's rays and adds the light that waited for it. One ray follows the other in the same loop: adapters
// that run lanes in lockstep let no lane wait between the two for the others.
fn advance(frame: Frame, path: ptr<function, Path>) -> Hit {
    var walk = walk_of(frame, *path, (*path).shadow.reach > 0.0);
    while !is_over(walk) {
        go_on(&walk);
        if walk.kind == SHADOW && is_over(walk) {
            if walk.hit.triangle == NONE && (*path).shadow.is_direct {
                (*path).direct += (*path).shadow.light;
            }
            if walk.hit.triangle == NONE && !(*path).shadow.is_direct {
                (*path).indirect += (*path).shadow.light;
            }
            walk = walk_of(frame, *path, false);
        }
    }
    (*path).shadow.reach = 0.0;
    return walk.hit;
}

// Goes on from the surface that the path has met; false where it ends.
fn extend(path: ptr<function, Path>, hit: Hit, random: ptr<function, Sampler>) -> bool {
    if hit.triangle == NONE {
        add_sky(path);
        return false;
    }
    (*path).vertices += 1u;
    let surface = surface_at(hit, (*path).ray.direction);
    if !surface.visible {
        return false;
    }
    add_emission(path, surface, hit);
    let to_eye = -normalize((*path).ray.direction);
    add_light(path, surface, to_eye, random);
    let bounces = (*path).vertices - 1u;
    if bounces >= min(params.bounces, MAX_BOUNCES) {
        return false;
    }
    let share = specular_share(surface, to_eye);
#ifndef UNLIT
    add_emitter(path, surface, to_eye, share, random);
#endif
#ifndef EVEN_SKY
    choose_sky(path, surface, to_eye, share, random);
#endif
    let choice = next_pair(random);
    let direction = sample_direction(surface, to_eye, share, choice.x, next_pair(random));
    let density = direction_density(surface, to_eye, direction, share);
    let response = reflected(surface, to_eye, direction);
    if !(density > 0.0) || all(response <= vec3f(0.0)) {
        return false;
    }
    (*path).throughput *= response / density;
    (*path).density = density;
    (*path).ray = Ray(leave_surface(surface, direction), direction);
    (*path).reach = 3e38;
    return survives(path, choice.y);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2u(thread.x, thread.y + params.first_row);
    if any(pixel >= params.size) || params.samples == 0u {
        return;
    }
    let index = pixel.y * params.size.x + pixel.x;
    // Every sample is added to what was there before, one by one: in whatever pieces, the sums get the same bits.
    var sum: array<vec3f, 4>;
    for (var i = 0u; i < 4u; i++) {
        sum[i] = sums[4u * index + i].rgb;
    }
    let end = params.first_sample + params.samples;
    var sample = params.first_sample;
    var random: Sampler;
    var path: Path;
    var alive = false;
    let frame = load_frame(params.root);
    // A thread whose path has ended starts the next one at once, so that its neighbours do not wait for it.
    loop {
        let is_new = !alive;
        if is_new {
            random = Sampler(hash_pair(index, hash_pair(params.seed, sample & 1u)), sample >> 1u, 0u);
            start_path(&path, pixel, &random);
            // After the last one only what is left of it is traced.
            path.reach = select(0.0, path.reach, sample < end);
        }
        let hit = advance(frame, &path);
        if is_new {
            // Of the sample before, which is of the other half.
            let odd = (sample & 1u) == 0u;
            sum[0] += select(path.direct, vec3f(0.0), odd);
            sum[1] += select(path.indirect, vec3f(0.0), odd);
            sum[2] += select(vec3f(0.0), path.direct, odd);
            sum[3] += select(vec3f(0.0), path.indirect, odd);
            path.direct = vec3f(0.0);
            path.indirect = vec3f(0.0);
            if sample == end {
                break;
            }
            sample += 1u;
        }
        alive = extend(&path, hit, &random);
    }
    for (var i = 0u; i < 4u; i++) {
        sums[4u * index + i] = vec4f(sum[i], 0.0);
    }
}
