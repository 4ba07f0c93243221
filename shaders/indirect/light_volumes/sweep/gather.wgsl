// Final gather (Reichert 1992; Jensen 1996, section 4): light that reaches a visible surface along rays, of which each
// brings what the surface that it meets emits and reflects. That is the light straight from the lights, by a shadow ray,
// and the light of its patch: errors of that are averaged over all that a pixel sees, and what is smaller than a patch
// casts its own light and shadow. Emissive surfaces and the sky are sampled from the pixel as well, see
// lib/next_event.wgsl, and so is what lights reach, see lib/rsm_samples.wgsl.
//   RAYS      rays of a pixel
//   POINTS    points of lit surfaces that a pixel samples beside them, each the better of several
//   ONE_BOUNCE  patches have no light
//   MIRRORS   what smooth surfaces mirror is left to another pass, see lib/visible_surface.wgsl
//   HAZE      media take and scatter light on the way of rays
//   PATHS     rays go on as paths (Kajiya 1986), each with so many rays more at most, and nothing ends in patches
//   UNLIT, DIFFUSE, EVEN_SKY and others: what the scene does not have, see lib/ray_scene.wgsl

#import lightwell::gbuffer::{decode_albedo, decode_surface, world_position}
#ifdef POINTS
#import lightwell::rsm_samples::{FromPoint, POINT_TEXELS, decode_point, light_from_point, is_drawn, point_density}
#endif
#ifdef LAYERED
#import lightwell::layers::tint_of_lobe
#endif
#import lightwell::next_event::{BLUR, EMITTER_CANDIDATES, LightRange, LightSample, NO_RAY, blurred, bounded, emission_weight, even_reflectance, no_light, sample_light, specular_share}
#ifndef UNLIT
#import lightwell::color::luminance
#import lightwell::next_event::resample_emitter
#endif
#ifndef EVEN_SKY
#import lightwell::next_event::{sample_sky_light, sky_weight}
#import lightwell::sky::sky_radiance
#endif
#ifdef HAZE
#import lightwell::haze_along::haze_along
#import lightwell::media::FARTHEST
#endif
#import lightwell::interleave::{Interleave, pixel_of}
#import lightwell::inverse_distance::{NO_DIFFUSE, encode_inverse_distance, nearness_around}
#ifndef ONE_BOUNCE
#import lightwell::patches::{NO_PATCH, patch_at}
#import lightwell::ray_scene::primitive_of
#endif
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface, surface_at}
#import lightwell::rays::{Hit, Ray, LIGHT, SHADOW}
#import lightwell::walk::{Frame, Walk, begin_walk, go_on, is_over, left_by_glass, load_frame, passed, trace, trace_in}
#import lightwell::sampling::{INVERSE_PI, Sampler, hash_pair, is_chosen, next_pair}
#import lightwell::visible_surface::{VisibleSurface, by_lobe, number_of, ray_from, seen_surface}
#import lightwell::view::View

// One block of uniforms: where there are several and a branch hangs on one of them alone, Mesa's software driver (22.3)
// makes the shader anew in every frame, and keeps all.
struct Gather {
    view: View,
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    root: u32,             // of the hierarchy
    light_count: u32,
    emitter_count: u32,
    seed: u32,
    first: u32,            // row of this dispatch [texels], or of the pixels that are left out
    nearest: f32,          // distance below which the light of patches is not known [m]
    points_low: vec3f,     // box that the RSM samples lie in [m]
    point_count: u32,
    points_high: vec3f,
    @align(16) interleave: Interleave,
}

@group(0) @binding(0) var<uniform> gather: Gather;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
// What a white diffuse surface would reflect, and what the specular lobe does [W/(m² sr)].
@group(0) @binding(8) var diffuse: texture_storage_2d<rgba32float, write>;
@group(0) @binding(9) var specular: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var sky: texture_2d<f32>;
#ifndef ONE_BOUNCE
// Irradiance of patches [W/m²].
@group(0) @binding(11) var<storage, read> patch_light: array<vec4f>;
#else
const NO_PATCH: u32 = 0xfffffu;
#endif
#ifdef POINTS
// See lib/rsm_samples.wgsl.
@group(0) @binding(13) var<storage, read> rsm_samples: array<vec4u>;
#endif

// See lib/strays.wgsl.
@group(0) @binding(14) var<storage, read> stray_pixels: array<u32>;
@group(0) @binding(15) var<storage, read> stray_counts: array<u32>;
// Reflected radiance [W/(m² sr)].
@group(0) @binding(16) var indirect: texture_storage_2d<rgba32float, write>;

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

#ifdef POINTS
const POINTS: u32 = #{POINTS}u;
// Points of which one is chosen by what it would bring if nothing were in its way (Talbot, Cline and Egbert 2005).
const CANDIDATES: u32 = 4u;
#endif

// Rays more that follow one another where surfaces are near or glossy.
#ifdef PATHS
const MOST_NEAR: u32 = #{PATHS}u;
#else
const MOST_NEAR: u32 = 2u;
#endif
// Rays that always go on; later ones by Russian roulette.
const SAFE_BOUNCES: u32 = 3u;
// Share of the specular lobe in what a surface reflects from which on light in other directions than its own says little.
const GLOSSY: f32 = 0.5;

// Where a ray begins.
struct Vertex {
    start: VisibleSurface,
    throughput: vec3f,     // what the visible surface reflects of the light that this one does
    seen_along: vec3f,     // direction in which the visible surface sees this one; zero: it is the visible one
    depth: u32,            // rays between the two
}

struct Sums {
    diffuse: vec3f,
    specular: vec3f,
    toward: vec3f,         // what the rays met: direction/distance [1/m]
    inverse_distance: f32,         // the same: 1/distance [1/m]
#ifndef UNLIT
    emitted: f32,          // luminance of diffuse light from emissive surfaces, over their distances
#endif
}

// A ray from a vertex.
struct GatherRay {
    ray: Ray,
    density: f32,          // [1/sr]
    throughput: vec3f,     // what the visible surface reflects over the light that arrives, over the density
    seen_along: vec3f,
}

// Light of a light at the end of a ray, whose shadow ray waits for the next ray to be traced.
struct Waiting {
    sample: LightSample,
    seen_along: vec3f,
}

fn seen_at(pixel: vec2u, z: f32) -> Vertex {
    let position = world_position(pixel, gather.view.size, z, gather.view.world_from_clip);
    let drawn = decode_surface(
        textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
    );
    return Vertex(seen_surface(gather.view, drawn), vec3f(1.0), vec3f(0.0), 0u);
}

fn add(sums: ptr<function, Sums>, seen: Vertex, direction: vec3f, light: vec3f) {
    let brought = by_lobe(seen.start, direction, light);
    (*sums).diffuse += brought.diffuse;
    (*sums).specular += brought.specular;
}

#ifndef UNLIT
// Notes how far the light from an emissive surface has come. What is nearer than a tenth of a micrometre counts as so far
// off: light of any brightness over it then stays in the range of floats.
fn add_emitted(sums: ptr<function, Sums>, seen: Vertex, direction: vec3f, light: vec3f, distance: f32) {
    (*sums).emitted += luminance(by_lobe(seen.start, direction, light).diffuse) / max(distance, 1e-7);
}
#endif

// The direction in which the visible surface sees light that arrives at a vertex.
fn seen_along(vertex: Vertex, direction: vec3f) -> vec3f {
    return select(vertex.seen_along, direction, vertex.depth == 0u);
}

fn add_unless_blocked(sums: ptr<function, Sums>, seen: Vertex, vertex: Vertex, sample: LightSample) -> bool {
    let hit = trace(gather.root, sample.ray, sample.reach, SHADOW);
    if sample.reach <= 0.0 || hit.triangle != NONE {
        return false;
    }
    let light = vertex.throughput * bounded(sample.light * passed(sample.ray, hit));
    add(sums, seen, seen_along(vertex, normalize(sample.ray.direction)), light);
    return true;
}

// Emissive surfaces and the sky, sampled from a vertex.
fn add_sampled(sums: ptr<function, Sums>, seen: Vertex, vertex: Vertex, random: ptr<function, Sampler>) {
#ifndef UNLIT
    let emitter = next_pair(random);
    let place = next_pair(random);
    let sample = resample_emitter(
        vertex.start.surface, vertex.start.to_eye, vertex.start.to_specular, gather.emitter_count, emitter, place,
    );
    if add_unless_blocked(sums, seen, vertex, sample) && vertex.depth == 0u {
        let distance = length(sample.ray.direction);
        add_emitted(sums, seen, sample.ray.direction / distance, bounded(sample.light), distance);
    }
#endif
#ifndef EVEN_SKY
    let texel = next_pair(random);
    let within = next_pair(random);
    add_unless_blocked(
        sums, seen, vertex,
        sample_sky_light(
            sky, gather.sky_turn, vertex.start.surface, vertex.start.to_eye, vertex.start.to_specular, texel, within,
        ),
    );
#endif
}

#ifdef POINTS
fn load_point(choice: f32) -> vec3u {
    let first = POINT_TEXELS * min(u32(choice * f32(gather.point_count)), gather.point_count - 1u);
    return vec3u(first, first + 1u, first + 2u);
}

// Points of lit surfaces, sampled from the visible one.
fn add_rsm_samples(sums: ptr<function, Sums>, seen: Vertex, first: u32) {
    var random = Sampler(hash_pair(gather.seed, 0x2545f491u), 0u, 0u);
    for (var i = 0u; i < POINTS; i++) {
        random.index = first * POINTS + i;
        random.dimension = 0u;
        var chosen: FromPoint;
        var chosen_weight = 0.0;
        var total = 0.0;
        var pick = next_pair(&random).x;
        for (var k = 0u; k < CANDIDATES; k++) {
            let at = load_point(next_pair(&random).x);
            let point = decode_point(rsm_samples[at.x], rsm_samples[at.y], rsm_samples[at.z]);
            let candidate = light_from_point(seen.start, point, f32(RAYS), f32(POINTS * CANDIDATES));
            let weight = candidate.light.r + candidate.light.g + candidate.light.b;
            if weight > 0.0 {
                total += weight;
                if is_chosen(&pick, weight / total) {
                    chosen = candidate;
                    chosen_weight = weight;
                }
            }
        }
        if chosen_weight > 0.0 {
            let hit = trace(gather.root, chosen.ray, 0.9999, SHADOW);
            if hit.triangle == NONE {
                // The sums are those of all rays.
                let scale = f32(RAYS) * total / chosen_weight;
                add(sums, seen, chosen.direction, bounded(chosen.light * (scale * passed(chosen.ray, hit))));
            }
        }
    }
}
#endif

// Weight of a light's light on what a ray of the visible surface has met, against `add_rsm_samples`.
fn lamp_weight(sample: LightSample, surface: Surface, ray: GatherRay, hit: Hit, depth: u32) -> f32 {
#ifdef POINTS
    let share = bitcast<f32>(rsm_samples[2].y);
    let is_within = all(surface.position >= gather.points_low) && all(surface.position <= gather.points_high);
    if depth > 0u || !is_drawn(share) || sample.reach <= 0.0 || !is_within {
        return 1.0;
    }
    let direction = ray.ray.direction;
    let of_points = point_density(
        sample.irradiance, normalize(sample.ray.direction), surface.geometric_normal, share, direction, hit.t,
    );
    let of_rays = f32(RAYS) * ray.density;
    return of_rays / (of_rays + f32(POINTS * CANDIDATES) * of_points);
#else
    return 1.0;
#endif
}

// The next ray; without throughput it need not be traced.
fn next_ray(vertex: Vertex, random: ptr<function, Sampler>) -> GatherRay {
    let next = ray_from(vertex.start, random);
    let along = seen_along(vertex, next.ray.direction);
    return GatherRay(next.ray, next.density, vertex.throughput * next.throughput, along);
}

fn sky_light(ray: GatherRay) -> vec3f {
#ifdef EVEN_SKY
    return gather.sky;
#else
    let d = ray.ray.direction;
    return sky_radiance(sky, d, gather.sky_turn) * sky_weight(sky, gather.sky_turn, d, ray.density);
#endif
}

// The patch of what was met.
fn patch_of(hit: Hit, surface: Surface) -> u32 {
#ifdef ONE_BOUNCE
    return NO_PATCH;
#else
    return patch_at(primitive_of(hit.triangle), surface.position, surface.geometric_normal);
#endif
}

// Light of its patch that a surface reflects to where a ray in a direction came from. Glossy surfaces reflect as if light
// were even around them.
fn patch_radiance(surface: Surface, found: u32, direction: vec3f) -> vec3f {
#ifdef ONE_BOUNCE
    return vec3f(0.0);
#else
    if found == NO_PATCH {
        return vec3f(0.0);
    }
    return even_reflectance(surface, -direction) * patch_light[found].rgb * INVERSE_PI;
#endif
}

#ifdef PATHS
// Russian roulette, as the path tracer has it: a path that ends goes on from the visible surface, with the next ray.
fn survive(vertex: ptr<function, Vertex>, random: ptr<function, Sampler>) {
    if (*vertex).depth < SAFE_BOUNCES {
        return;
    }
    let t = (*vertex).throughput;
    let chance = clamp(max(t.r, max(t.g, t.b)), 0.05, 0.98);
    (*vertex).throughput /= chance;
    (*vertex).depth = select(0u, (*vertex).depth, next_pair(random).y < chance);
}
#endif

// Adds what a ray has found, but for the light from a light. The light of patches is not known where surfaces are nearer to
// each other than those are large, and what metals reflect depends on its direction: from what is met there `vertex` goes
// on with a ray more (Jensen 1996, section 4).
fn arrive(
    sums: ptr<function, Sums>, seen: Vertex, vertex: ptr<function, Vertex>, sent: GatherRay, hit: Hit,
    random: ptr<function, Sampler>,
) -> Waiting {
    let depth = (*vertex).depth;
    (*vertex).depth = 0u;
    var ray = sent;
    let direction = ray.ray.direction;
#ifdef HAZE
    let reach = select(hit.t, FARTHEST, hit.triangle == NONE);
    let between = haze_along(ray.ray.origin, direction, reach, next_pair(random).x);
    add(sums, seen, ray.seen_along, ray.throughput * bounded(between.added));
    ray.throughput *= between.passing;
#endif
    if hit.triangle == NONE {
        add(sums, seen, ray.seen_along, ray.throughput * sky_light(ray));
        return Waiting(no_light(), ray.seen_along);
    }
    if depth == 0u {
        let near = 1.0 / max(hit.t, 1e-20);
        (*sums).toward += direction * near;
        (*sums).inverse_distance += near;
    }
#ifdef PATHS
    let surface = surface_at(hit, direction);
#else
    let surface = blurred(surface_at(hit, direction), BLUR);
#endif
    if !surface.visible {
        return Waiting(no_light(), ray.seen_along);
    }
    var light = surface.emissive * emission_weight(surface, hit, direction, ray.density, f32(EMITTER_CANDIDATES));
#ifndef UNLIT
    if depth == 0u {
        add_emitted(sums, seen, direction, ray.throughput * bounded(light), hit.t);
    }
#endif
    let to_specular = specular_share(surface, -direction);
    let found = patch_of(hit, surface);
    if (hit.t < gather.nearest || to_specular > GLOSSY || found == NO_PATCH) && gather.nearest > 0.0 && depth < MOST_NEAR {
        *vertex = Vertex(VisibleSurface(surface, -direction, to_specular, false), ray.throughput, ray.seen_along, depth + 1u);
#ifdef PATHS
        survive(vertex, random);
#endif
    } else {
        light += patch_radiance(surface, found, direction);
    }
    var pick = 0.0;
    if gather.light_count > 1u {
        pick = next_pair(random).x;
    }
    var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
    on_light = next_pair(random);
#endif
    var sample = sample_light(surface, -direction, NO_RAY, LightRange(0u, gather.light_count), false, pick, on_light);
    sample.light = ray.throughput * bounded(sample.light) * lamp_weight(sample, surface, ray, hit, depth);
    light = ray.throughput * bounded(light);
    if sample.reach <= 0.0 {
        light += sample.light;
    }
    add(sums, seen, ray.seen_along, light);
    return Waiting(sample, ray.seen_along);
}

// Whether the light that waited arrives, and what the next ray meets.
struct Met {
    is_lit: bool,
    left: vec3f,           // what glass leaves of that light
    hit: Hit,
}

#ifdef CLASSES
// One ray after the other: each has loops of its own for what is opaque and what is not.
fn trace_both(frame: Frame, waiting: LightSample, next: Ray, reach: f32) -> Met {
    var is_lit = false;
    var left = vec3f(1.0);
    var hit: Hit;
    for (var turn = select(1u, 0u, waiting.reach > 0.0); turn < 2u; turn++) {
        let is_shadow = turn == 0u;
        var ray = next;
        if is_shadow {
            ray = waiting.ray;
        }
        hit = trace_in(frame, ray, select(reach, waiting.reach, is_shadow), select(LIGHT, SHADOW, is_shadow));
        if is_shadow {
            is_lit = hit.triangle == NONE;
            left = passed(ray, hit);
        }
    }
    return Met(is_lit, left, hit);
}
#else
// One ray follows the other in the same loop: adapters that run lanes in lockstep let no lane wait between the two for the
// others.
fn trace_both(frame: Frame, waiting: LightSample, next: Ray, reach: f32) -> Met {
    var is_lit = false;
    var left = vec3f(1.0);
    var walk = begin_walk(frame, next, reach, LIGHT);
    if waiting.reach > 0.0 {
        walk = begin_walk(frame, waiting.ray, waiting.reach, SHADOW);
    }
    while !is_over(walk) {
        go_on(&walk);
        if walk.kind == SHADOW && is_over(walk) {
            is_lit = walk.hit.triangle == NONE;
            left = passed(walk.ray, walk.hit);
            walk = begin_walk(frame, next, reach, LIGHT);
        }
    }
    return Met(is_lit, left, walk.hit);
}
#endif

fn gathered(pixel: vec2u, seen: Vertex) -> Sums {
    let frame = load_frame(gather.root);
    var sums: Sums;
    var waiting = Waiting(no_light(), vec3f(0.0));
    var vertex = seen;
    let first = number_of(pixel) * RAYS;
    var begun = 0u;
    var random = Sampler(gather.seed, first, 0u);
#ifdef POINTS
    add_rsm_samples(&sums, seen, number_of(pixel));
#endif
    // A turn more than there are rays: in the last one only the last shadow ray is left.
    for (var turn = 0u; turn <= RAYS * (1u + MOST_NEAR); turn++) {
        if vertex.depth == 0u {
            vertex = seen;
            random = Sampler(gather.seed, first + begun, 0u);
            begun++;
        }
        var ray = GatherRay(Ray(seen.start.surface.position, seen.start.surface.normal), 0.0, vec3f(0.0), vec3f(0.0));
        if begun <= RAYS {
            ray = next_ray(vertex, &random);
            add_sampled(&sums, seen, vertex, &random);
        }
        let reach = select(0.0, 3e38, any(ray.throughput > vec3f(0.0)));
        let met = trace_both(frame, waiting.sample, ray.ray, reach);
        if met.is_lit {
            add(&sums, seen, waiting.seen_along, waiting.sample.light * met.left);
        }
        if begun > RAYS {
            break;
        }
        waiting.sample.reach = 0.0;
        vertex.depth = select(0u, vertex.depth, reach > 0.0);
        if reach > 0.0 {
            ray.throughput *= left_by_glass(gather.root, ray.ray, met.hit.t);
            waiting = arrive(&sums, seen, &vertex, ray, met.hit, &random);
        }
    }
    let share = 1.0 / f32(RAYS);
    sums.diffuse *= share;
    sums.specular *= share;
    sums.toward *= share;
    sums.inverse_distance *= share;
#ifndef UNLIT
    sums.emitted *= share;
#endif
    return sums;
}

// Mean of 1/distance over the light, of which only that from emissive surfaces counts [1/m].
fn emitted_nearness(sums: Sums) -> f32 {
#ifdef UNLIT
    return 0.0;
#else
    return sums.emitted / max(luminance(sums.diffuse), 1e-30);
#endif
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let texel = vec2u(thread.x, thread.y + gather.first);
    if any(texel >= gather.interleave.texels) {
        return;
    }
    let pixel = pixel_of(gather.interleave, texel, gather.view.size);
    let z = textureLoad(depth, pixel, 0);
    var sums: Sums;
    var inverse_distance = select(vec2f(0.0), NO_DIFFUSE, z > 0.0);
    let seen = seen_at(pixel, max(z, 1e-30));
    if z > 0.0 && any(seen.start.surface.albedo > vec3f(0.0)) {
        sums = gathered(pixel, seen);
        let met = nearness_around(sums.toward, sums.inverse_distance, seen.start.surface.normal);
        inverse_distance = encode_inverse_distance(met, emitted_nearness(sums));
    }
#ifdef LAYERED
    // As the filter asks for it.
    let drawn = seen.start.surface;
    sums.specular /=
        tint_of_lobe(drawn.normal_reflectance, drawn.grazing_reflectance, dot(drawn.normal, seen.start.to_eye));
#endif
    textureStore(diffuse, texel, vec4f(sums.diffuse, inverse_distance.x));
    textureStore(specular, texel, vec4f(sums.specular, inverse_distance.y));
}

// Pixels that no gathered one has light for: what their own rays find is what they reflect.
@compute @workgroup_size(64)
fn strays(@builtin(global_invocation_id) thread: vec3u) {
    let index = gather.first + thread.x;
    if index >= stray_counts[0] {
        return;
    }
    let pixel = vec2u(stray_pixels[index] & 0xffffu, stray_pixels[index] >> 16u);
    let seen = seen_at(pixel, max(textureLoad(depth, pixel, 0), 1e-30));
    var radiance = vec3f(0.0);
    if any(seen.start.surface.albedo > vec3f(0.0)) {
        let sums = gathered(pixel, seen);
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        radiance = min(albedo * sums.diffuse + sums.specular, vec3f(1e32));
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
