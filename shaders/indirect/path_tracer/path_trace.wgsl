#define EXACT_FILMS
// Path tracing (Kajiya 1986): the reference that every other method is measured against.
//
// A vertex of a path gathers light in two ways: next-event estimation towards the lights and towards the emissive
// triangles, and by the ray that goes on, which may itself meet an emissive surface or the sky. What both ways can
// find is weighted by the balance heuristic (Veach and Guibas 1995). Materials and lights are those of the raster
// passes. What a scene does not have is left out of the shader (see lib/ray_scene.wgsl): UNLIT, no surface emits light;
// DIFFUSE, all surfaces are purely so; EVEN_SKY, the sky is alike in all directions; (the other way around) AREA_LIGHTS, a
// light has a surface; MEDIA, light passes through media; ORTHOGRAPHIC, the lines of sight are parallel; THIN_LENS, the camera has a plane of focus. Direct light is what comes straight from the lights to
// the surface that the camera sees, with that surface's own emission; all else is indirect, and `bounces` counts the rays
// that go on.

#import lightwell::next_event::{LightRange, LightSample, NO_RAY, alpha_of_choice, bounded, direction_density, emission_weight, reflected, sample_direction, sample_light, specular_share}
#ifdef AREA_LIGHTS
#import lightwell::next_event::radiance_of_lights
#endif
#ifndef UNLIT
#import lightwell::next_event::sample_emitter
#endif
#ifndef EVEN_SKY
#import lightwell::next_event::{sample_sky_light, sky_weight}
#endif
#ifdef MEDIA
#import lightwell::media::{FARTHEST, MEDIA, distance_of_depth, extinction_of_all, media, span_in, span_of_all, transmittance}
#import lightwell::next_event::{Segment, sample_segment, segment}
#import lightwell::ray_surfaces::point_of_medium
#endif
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface, surface_at, leave_surface}
#import lightwell::rays::{Ray, Hit, CAMERA, LIGHT, SHADOW, hit_of}
#import lightwell::walk::{Frame, Walk, load_frame, begin_walk, is_over, go_on, passed, trace, trace_in}
#ifdef GLASS
#import lightwell::glass::{glass_at, pass_share}
#import lightwell::ray_materials::base_color_at
#import lightwell::ray_textures::coordinates
#import lightwell::ray_scene::load_triangle
#import lightwell::rays::SEEN
#import lightwell::walk::left_by_glass
#import lightwell::refraction::{cross_surface, crossing_share, reflecting}
#ifdef DISPERSION
#import lightwell::ray_surfaces::{dispersed, followed_color}
#endif
#endif
#import lightwell::sky::sky_radiance
#import lightwell::sampling::{Sampler, TAU, hash_pair, next_pair}

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
    sun_toward: vec3f,     // unit
    sun_cosine: f32,       // of half its angle; above 1: no disc is seen
    sun_radiance: vec3f,   // [W/(m² sr)]
    size: vec2u,           // [pixels]
    jitter: vec2f,         // shift of the pixel grid [pixels]
    first_row: u32,        // of this dispatch
    first_sample: u32,
    samples: u32,          // of this dispatch
    light_count: u32,
    emitter_count: u32,
    sky_turn: f32,         // of the sky's map [rad]
    lens_radius: f32,      // [m]
    inverse_focus: f32,    // of the distance of the plane of focus along the axis [1/m]
}

@group(0) @binding(0) var<uniform> params: Trace;
// Sums of each pixel: direct and indirect light of the even samples, then of the odd ones.
@group(0) @binding(1) var<storage, read_write> sums: array<vec4f>;
@group(0) @binding(2) var sky: texture_2d<f32>;

// Rays that go on in "unlimited" paths: the chance to get here is below 1e-9, see `survives`.
const MAX_BOUNCES: u32 = 1024u;
// Rays that always go on; later ones by Russian roulette.
const SAFE_BOUNCES: u32 = 3u;

var<private> light_count: u32;
var<private> emitter_count: u32;

struct Path {
    ray: Ray,
    near: f32,
    reach: f32,
    throughput: vec3f,
    density: f32,          // of the direction that was sampled last [1/sr]
    vertices: u32,         // surfaces met so far, but for those of glass that it has crossed
    direct: vec3f,
    indirect: vec3f,
    shadow: Shadow,
#ifdef GLASS
    is_seen: bool,         // what it meets is seen, through glass and in mirrors: glass refracts
    crossings: u32,        // surfaces of glass that it has crossed
    has_crossed: bool,     // the last surface was crossed
    absorption: vec3f,     // of the body in which it is [1/m]
#ifdef DISPERSION
    is_of_one_color: bool, // it was refracted where colours part: only one is followed
#endif
#endif
}

// Light on its way to a vertex, until it is known whether anything is in the way: its ray is traced together with the
// ray that goes on.
struct Shadow {
    ray: Ray,
    reach: f32,            // 0: there is none
    light: vec3f,          // that the path brings to the eye if nothing is in the way
    is_direct: bool,
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
#ifdef THIN_LENS
    // From a point of the lens to that of the plane of focus which the pixel's centre ray meets (Cook, Porter and Carpenter
    // 1984).
    let on_lens = next_pair(random);
    let disc = params.lens_radius * sqrt(on_lens.x) * vec2f(cos(TAU * on_lens.y), sin(TAU * on_lens.y));
    let offset = disc.x * normalize(params.right) + disc.y * normalize(params.up);
    let bent = direction - offset * params.inverse_focus;
    (*path).ray = Ray(params.eye + offset + bent * params.near, bent);
#else
    (*path).ray = Ray(params.eye + direction * params.near, direction);
#endif
#endif
    (*path).reach = params.far - params.near;
    (*path).throughput = vec3f(1.0);
    (*path).density = 0.0;
    (*path).vertices = 0u;
#ifdef GLASS
    (*path).is_seen = true;
    (*path).crossings = 0u;
    (*path).has_crossed = false;
    (*path).absorption = vec3f(0.0);
#ifdef DISPERSION
    (*path).is_of_one_color = false;
    followed_color = 0.0;
#endif
#endif
}

// ---- Next-event estimation ----

fn add_light(path: ptr<function, Path>, surface: Surface, to_eye: vec3f, share: f32, random: ptr<function, Sampler>) {
    let is_direct = (*path).vertices == 1u;
    var pick = 0.0;
    if light_count > 1u {
        pick = next_pair(random).x;
    }
    var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
    on_light = next_pair(random);
#endif
    let sample = sample_light(surface, to_eye, share, LightRange(0u, light_count), is_direct, pick, on_light);
    if sample.reach <= 0.0 {
        add(path, sample.light, is_direct);
        return;
    }
    (*path).shadow = Shadow(sample.ray, sample.reach, bounded((*path).throughput * bounded(sample.light)), is_direct);
}

#ifdef AREA_LIGHTS
// What the ray that goes on finds of lights with a surface, up to where it met the scene.
fn add_met_lights(path: ptr<function, Path>, hit: Hit) {
    // The camera sees no lights.
    if (*path).vertices == 0u {
        return;
    }
#ifdef GLASS
    // Nor are they seen through glass; what rough glass shows of them came from there.
    if (*path).has_crossed {
        return;
    }
#endif
    let is_direct = (*path).vertices == 1u;
    let ray = (*path).ray;
    let distance = select(hit.t, 3e38, hit.triangle == NONE);
    add(path, radiance_of_lights(ray.origin, ray.direction, (*path).density, distance, light_count, is_direct), is_direct);
}
#endif

// What is left of the light of a sample, if nothing is in the way.
fn add_unless_blocked(path: ptr<function, Path>, sample: LightSample) {
    if sample.reach <= 0.0 {
        return;
    }
    let hit = trace(params.root, sample.ray, sample.reach, SHADOW);
    if hit.triangle == NONE {
        add(path, sample.light * passed(sample.ray, hit), false);
    }
}

// Emission of a surface that a path met, weighted against `sample_emitter` at the vertex before.
fn add_emission(path: ptr<function, Path>, surface: Surface, hit: Hit) {
    if all(surface.emissive <= vec3f(0.0)) {
        return;
    }
    if (*path).vertices == 1u {
        add(path, surface.emissive, true);
        return;
    }
    add(path, surface.emissive * emission_weight(surface, hit, (*path).ray.direction, (*path).density, 1.0), false);
}

// ---- The sky ----

// What a path finds that leaves the scene.
fn add_sky(path: ptr<function, Path>) {
    let is_direct = (*path).vertices == 0u;
#ifdef EVEN_SKY
    add(path, params.sky, is_direct);
#else
    let d = normalize((*path).ray.direction);
    let weight = select(sky_weight(sky, params.sky_turn, d, (*path).density), 1.0, is_direct);
    // The sun is a light, whose disc the camera alone sees here.
    let is_sun = is_direct && dot(d, params.sun_toward) >= params.sun_cosine;
    let light = sky_radiance(sky, d, params.sky_turn) * weight + select(vec3f(0.0), params.sun_radiance, is_sun);
    add(path, light, is_direct);
#endif
}

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

#ifdef MEDIA
// Where a ray that goes on is scattered or absorbed.
struct Collision {
    distance: f32,         // [m]
    medium: u32,           // or NONE
}

// The nearest of what the media have on its way: collisions are those of independent particles, whose distances are
// distributed as exp(−optical depth) in each medium.
fn collide(path: Path, hit: Hit, random: ptr<function, Sampler>) -> Collision {
    // Before the first surface the direction is not of unit length.
    let length = length(path.ray.direction);
    let direction = path.ray.direction / length;
    let reach = select(hit.t * length, FARTHEST, hit.triangle == NONE);
    var found = Collision(reach, NONE);
    segment = Segment(path.ray.origin, direction, span_of_all(path.ray.origin, direction, reach), 0.0, 0.0, f32(light_count));
    for (var i = 0u; i < MEDIA; i++) {
        let span = span_in(media[i], path.ray.origin, direction, reach);
        let depth = -log(1.0 - next_pair(random).x);
        let distance = span.begin + distance_of_depth(media[i], path.ray.origin, direction, span, depth);
        if distance < min(span.end, found.distance) {
            found = Collision(distance, i);
        }
    }
    if found.medium != NONE {
        let position = path.ray.origin + direction * found.distance;
        segment.distance = found.distance;
        segment.density = extinction_of_all(position) * transmittance(path.ray.origin, direction, found.distance);
    }
    return found;
}

// What media scatter on the way of the last ray, near one of the lights.
fn add_scattered(path: ptr<function, Path>, random: ptr<function, Sampler>) {
    let pick = next_pair(random);
    var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
    on_light = next_pair(random);
#endif
    if light_count == 0u {
        return;
    }
    let is_direct = (*path).vertices == 0u;
    let index = min(u32(pick.x * f32(light_count)), light_count - 1u);
    let sample = sample_segment(index, is_direct, pick.y, on_light);
    let hit = trace(params.root, sample.ray, sample.reach, SHADOW);
    if hit.triangle == NONE {
        add(path, sample.light * passed(sample.ray, hit), is_direct);
    }
}
#endif

// A ray with its reach and what it is for.
struct Cast {
    ray: Ray,
    reach: f32,
    kind: u32,
}

// The ray to the light, or the one that goes on.
fn cast_of(path: Path, in_shadow: bool) -> Cast {
    if in_shadow {
        return Cast(path.shadow.ray, path.shadow.reach, SHADOW);
    }
#ifdef GLASS
    let is_first = path.vertices == 0u && path.crossings == 0u;
    return Cast(path.ray, path.reach, select(select(LIGHT, SEEN, path.is_seen), CAMERA, is_first));
#else
    return Cast(path.ray, path.reach, select(LIGHT, CAMERA, path.vertices == 0u));
#endif
}

// Adds the light that waited for the ray to it, unless that has met something.
fn add_waiting(path: ptr<function, Path>, ray: Ray, hit: Hit) {
    let light = (*path).shadow.light * passed(ray, hit);
    if hit.triangle == NONE && (*path).shadow.is_direct {
        (*path).direct += light;
    }
    if hit.triangle == NONE && !(*path).shadow.is_direct {
        (*path).indirect += light;
    }
}

#ifdef CLASSES
// Traces the path's rays and adds the light that waited for it. One ray after the other: each has loops of its own for what is
// opaque and what is not.
fn advance(frame: Frame, path: ptr<function, Path>) -> Hit {
    var hit: Hit;
    for (var turn = select(1u, 0u, (*path).shadow.reach > 0.0); turn < 2u; turn++) {
        let sent = cast_of(*path, turn == 0u);
        hit = trace_in(frame, sent.ray, sent.reach, sent.kind);
        if turn == 0u {
            add_waiting(path, sent.ray, hit);
        }
    }
    (*path).shadow.reach = 0.0;
    return hit;
}
#else
fn walk_of(frame: Frame, path: Path, in_shadow: bool) -> Walk {
    let sent = cast_of(path, in_shadow);
    return begin_walk(frame, sent.ray, sent.reach, sent.kind);
}

// Traces the path's rays and adds the light that waited for it. One ray follows the other in the same loop: adapters
// that run lanes in lockstep let no lane wait between the two for the others.
fn advance(frame: Frame, path: ptr<function, Path>) -> Hit {
    var walk = walk_of(frame, *path, (*path).shadow.reach > 0.0);
    while !is_over(walk) {
        go_on(&walk);
        if walk.kind == SHADOW && is_over(walk) {
            add_waiting(path, walk.ray, walk.hit);
            walk = walk_of(frame, *path, false);
        }
    }
    (*path).shadow.reach = 0.0;
    return walk.hit;
}
#endif

#ifdef GLASS
// Most surfaces of glass that a path crosses.
const MOST_CROSSINGS: u32 = 64u;
// GGX α up to which what a surface mirrors is seen in it.
const MIRRORS: f32 = 0.1;

// What the body takes in which a path is, or, where it is not seen, glass on its way.
fn weaken(path: ptr<function, Path>, hit: Hit) {
    if !(*path).is_seen {
        (*path).throughput *= left_by_glass(params.root, (*path).ray, hit.t);
        return;
    }
    let distance = min(hit.t * length((*path).ray.direction), 1e9);
    (*path).throughput *= exp(-(*path).absorption * distance);
}

// Glass that is not seen was met by chance, and reflects.
fn met_by_chance(path: ptr<function, Path>, surface: Surface, hit: Hit) {
    let material = load_triangle(hit.triangle).material;
    let place = coordinates(hit.triangle, hit.barycentric);
    let glass = glass_at(material, place, base_color_at(material, place).rgb);
    let cosine = abs(dot(surface.geometric_normal, normalize((*path).ray.direction)));
    (*path).throughput /= max(1.0 - pass_share(glass, cosine), 1e-6);
}

#ifdef DISPERSION
// Chooses one of the colours where they part first.
fn choose_color(path: ptr<function, Path>, random: f32) {
    let color = min(u32(random * 3.0), 2u);
    (*path).is_of_one_color = true;
    (*path).throughput *= select(vec3f(0.0), vec3f(3.0), vec3u(0u, 1u, 2u) == vec3u(color));
    followed_color = f32(color) - 1.0;
}
#endif

// Goes on beyond a surface of glass; false where nothing passes.
fn cross_glass(path: ptr<function, Path>, met: Surface, to_eye: vec3f, random: ptr<function, Sampler>) -> bool {
    var surface = met;
#ifdef DISPERSION
    if surface.dispersion > 0.0 && !(*path).is_of_one_color {
        choose_color(path, next_pair(random).x);
        surface = dispersed(surface);
    }
#endif
    var crossed = surface;
    crossed.is_crossed = true;
    add_light(path, crossed, to_eye, NO_RAY, random);
    let crossing = cross_surface(surface, to_eye, next_pair(random));
    (*path).throughput *= crossing.weight;
    if !any(crossing.weight > vec3f(0.0)) || (*path).crossings >= MOST_CROSSINGS {
        return false;
    }
    (*path).vertices -= 1u;
    (*path).crossings += 1u;
    (*path).has_crossed = true;
    if surface.is_solid {
        (*path).absorption = select(surface.absorption, vec3f(0.0), surface.is_inside);
    }
    (*path).ray = Ray(leave_surface(surface, crossing.direction), crossing.direction);
    (*path).reach = 3e38;
    // No other way leads to what it meets.
    (*path).density = 1e30;
    return true;
}
#endif

// Goes on from the surface that the path has met; false where it ends.
fn extend(path: ptr<function, Path>, met: Hit, random: ptr<function, Sampler>) -> bool {
    var hit = met;
#ifdef MEDIA
    let collision = collide(*path, met, random);
    add_scattered(path, random);
    if collision.medium != NONE {
        // A number that is none of a triangle's.
        hit = hit_of(collision.distance / length((*path).ray.direction), NONE - 1u, vec2f(0.0));
    }
#endif
#ifdef GLASS
    weaken(path, hit);
#endif
#ifdef AREA_LIGHTS
    add_met_lights(path, hit);
#endif
    if hit.triangle == NONE {
        add_sky(path);
        return false;
    }
    (*path).vertices += 1u;
    var surface: Surface;
#ifdef MEDIA
    if collision.medium != NONE {
        let position = (*path).ray.origin + hit.t * (*path).ray.direction;
        surface = point_of_medium(position, media[collision.medium].albedo, media[collision.medium].anisotropy);
    } else {
        surface = surface_at(hit, (*path).ray.direction);
    }
#else
    surface = surface_at(hit, (*path).ray.direction);
#endif
    if !surface.visible {
        return false;
    }
    add_emission(path, surface, hit);
    let to_eye = -normalize((*path).ray.direction);
#ifdef GLASS
    if any(surface.passing > vec3f(0.0)) {
        if (*path).is_seen {
            let crosses = crossing_share(surface, to_eye);
            if next_pair(random).x < crosses {
                (*path).throughput /= crosses;
                return cross_glass(path, surface, to_eye, random);
            }
            (*path).throughput /= 1.0 - crosses;
            surface = reflecting(surface, to_eye);
        } else {
            met_by_chance(path, surface, hit);
            // Light that it mirrors onto others is spread as light that passes is: no caustics.
            surface.alpha = max(surface.alpha, MIRRORS);
        }
    }
    (*path).has_crossed = false;
#endif
    let bounces = (*path).vertices - 1u;
    let is_last = bounces >= min(params.bounces, MAX_BOUNCES);
    let share = specular_share(surface, to_eye);
    // After the last surface no ray goes on.
    add_light(path, surface, to_eye, select(share, NO_RAY, is_last), random);
    if is_last {
        return false;
    }
#ifndef UNLIT
    let choice_of_emitter = next_pair(random);
    add_unless_blocked(path, sample_emitter(surface, to_eye, share, emitter_count, 1.0, choice_of_emitter.x, next_pair(random)));
#endif
#ifndef EVEN_SKY
    let choice_of_texel = next_pair(random);
    add_unless_blocked(path, sample_sky_light(sky, params.sky_turn, surface, to_eye, share, choice_of_texel, next_pair(random)));
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
#ifdef GLASS
    (*path).is_seen = (*path).is_seen && alpha_of_choice(surface, to_eye, share, choice.x) < MIRRORS;
#endif
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
    // All of them. Where a loop depends on a uniform alone, Mesa's software driver (22.3) recompiles the shader for every
    // dispatch and keeps each.
    light_count = min(params.light_count, 0xfffffffu + index);
    emitter_count = min(params.emitter_count, 0xfffffffu + index);
    var taken = 0u;
    var random: Sampler;
    var path: Path;
    var alive = false;
    let frame = load_frame(params.root);
    // A thread whose path has ended starts the next one at once, so that its neighbours do not wait for it.
    loop {
        let is_new = !alive;
        if is_new {
            let sample = params.first_sample + taken;
            random = Sampler(hash_pair(index, hash_pair(params.seed, sample & 1u)), sample >> 1u, 0u);
            start_path(&path, pixel, &random);
            // After the last one only what is left of it is traced.
            path.reach = select(0.0, path.reach, taken < params.samples);
        }
        let hit = advance(frame, &path);
        if is_new {
            // Of the sample before, which is of the other half.
            let odd = ((params.first_sample + taken) & 1u) == 0u;
            sum[0] += select(path.direct, vec3f(0.0), odd);
            sum[1] += select(path.indirect, vec3f(0.0), odd);
            sum[2] += select(vec3f(0.0), path.direct, odd);
            sum[3] += select(vec3f(0.0), path.indirect, odd);
            path.direct = vec3f(0.0);
            path.indirect = vec3f(0.0);
            if taken == params.samples {
                break;
            }
            taken += 1u;
        }
        alive = extend(&path, hit, &random);
    }
    for (var i = 0u; i < 4u; i++) {
        sums[4u * index + i] = vec4f(sum[i], 0.0);
    }
}
