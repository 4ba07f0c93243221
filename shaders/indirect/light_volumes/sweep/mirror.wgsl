// Mirror reflections: what surfaces too smooth for the gather's filter reflect by their specular lobes, by rays of their own
// for every pixel. A ray brings what the surface that it meets emits and reflects: light straight from the lights, by a
// shadow ray, and the light of its patch. Where a surface reflects more by its specular lobe than diffusely, as metals do, a
// ray along that lobe goes on (Whitted 1980), up to MOST_MIRRORS times. Other lobes reflect as if light were even around
// them.
//
// Patches are steps of light, which a mirror would show. Each look-up is therefore moved by up to half a patch, at random:
// the mean over look-ups is the light interpolated between patches.
//   RAYS        most rays of a pixel: of what reflects by its specular lobe alone
//   MIRRORS     roughness up to which surfaces mirror [%]
//   ONE_BOUNCE  patches have no light
//   HAZE        media take and scatter light on the way of rays
//   UNLIT, DIFFUSE, EVEN_SKY and others: what the scene does not have, see lib/ray_scene.wgsl

#import lightwell::gbuffer::{Surface as Drawn, decode_surface, world_position}
#ifdef HAZE
#import lightwell::haze_along::haze_along
#endif
#import lightwell::next_event::{LightSample, NO_RAY, blurred, bounded, diffuse_reflectance, even_reflectance, sample_light, sample_one_light, specular_share}
#ifndef EVEN_SKY
#import lightwell::sky::sky_radiance
#endif
#ifndef ONE_BOUNCE
#import lightwell::patches::{NO_PATCH, patch_at}
#import lightwell::ray_scene::primitive_of
#endif
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::{Surface, surface_at}
#import lightwell::rays::{Hit, LIGHT, SHADOW, trace}
#import lightwell::sampling::{INVERSE_PI, Sampler, basis, hash_pair, next_pair}
#import lightwell::visible_surface::{SeenRay, VisibleSurface, mirror_surface, number_of, ray_from}
#import lightwell::view::View

struct Mirror {
    view: View,
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    root: u32,             // of the hierarchy
    light_count: u32,
    seed: u32,
    first_row: u32,        // of this dispatch [pixels]
    patch_size: f32,       // [m]
}

@group(0) @binding(0) var<uniform> mirror: Mirror;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
// Radiance [W/(m² sr)], and how far off is what the first ray met [m]; 0: the pixel mirrors nothing.
@group(0) @binding(8) var mirrored: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var sky: texture_2d<f32>;
#ifndef ONE_BOUNCE
// Irradiance of patches [W/m²].
@group(0) @binding(11) var<storage, read> patch_light: array<vec4f>;
#endif

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

// Mirrors that a ray meets one after the other.
const MOST_MIRRORS: u32 = 4u;
// Share of the specular lobe in what a surface reflects from which on light in other directions than its own says little.
const GLOSSY: f32 = 0.5;
// Lights of which none is left out.
const FEW_LIGHTS: u32 = 4u;
// Look-ups of patches around what a ray has met.
const LOOKUPS: u32 = 2u;
// How many times as wide as the lobe of a mirror, in α, highlights of what it shows are at least. One that another surface
// shows in a rough mirror is blurred twice, and is else found by chance alone; in a smooth mirror it stays as it is.
const WIDER: f32 = 4.0;
// How far off the sky is [m].
const FAR: f32 = 1e6;

struct Reflection {
    radiance: vec3f,       // [W/(m² sr)]
    distance: f32,         // to what the first ray met [m]
}

fn sky_along(direction: vec3f) -> vec3f {
#ifdef EVEN_SKY
    return mirror.sky;
#else
    return sky_radiance(sky, direction, mirror.sky_turn);
#endif
}

#ifndef ONE_BOUNCE
// Irradiance of the patches around what was met [W/m²].
fn patch_irradiance(surface: Surface, hit: Hit, random: ptr<function, Sampler>) -> vec3f {
    let primitive = primitive_of(hit.triangle);
    let across = basis(surface.geometric_normal);
    let first = next_pair(random);
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var i = 0u; i < LOOKUPS; i++) {
        // The two lie opposite to each other: light that changes evenly has no noise.
        let offset = select(first - 0.5, 0.5 - first, i == 1u) * mirror.patch_size;
        let near = surface.position + across[0] * offset.x + across[1] * offset.y;
        let found = patch_at(primitive, near, surface.geometric_normal);
        if found != NO_PATCH {
            sum += patch_light[found].rgb;
            count += 1.0;
        }
    }
    let own = patch_at(primitive, surface.position, surface.geometric_normal);
    if count == 0.0 && own != NO_PATCH {
        return patch_light[own].rgb;
    }
    return sum / max(count, 1.0);
}
#endif

// What a white surface reflects of the light of its patches.
fn patch_radiance(surface: Surface, hit: Hit, random: ptr<function, Sampler>) -> vec3f {
#ifdef ONE_BOUNCE
    return vec3f(0.0);
#else
    return patch_irradiance(surface, hit, random) * INVERSE_PI;
#endif
}

// What a surface reflects of the lights, straight from there: of all if they are few, since the choice of one would be noise,
// or else of one.
fn lit_radiance(surface: Surface, direction: vec3f, random: ptr<function, Sampler>) -> vec3f {
    let are_few = mirror.light_count <= FEW_LIGHTS;
    var pick = 0.0;
    if !are_few {
        pick = next_pair(random).x;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < select(1u, mirror.light_count, are_few); i++) {
        var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
        on_light = next_pair(random);
#endif
        var sample: LightSample;
        if are_few {
            sample = sample_one_light(surface, -direction, i, on_light);
        } else {
            sample = sample_light(surface, -direction, NO_RAY, mirror.light_count, false, pick, on_light);
        }
        if sample.reach <= 0.0 || trace(mirror.root, sample.ray, sample.reach, SHADOW).triangle == NONE {
            sum += bounded(sample.light);
        }
    }
    return sum;
}

fn reflection_along(first: SeenRay, alpha: f32, random: ptr<function, Sampler>) -> Reflection {
    var found = Reflection(vec3f(0.0), FAR);
    var ray = first;
    var blur = alpha;
    for (var depth = 0u; depth <= MOST_MIRRORS; depth++) {
        if !any(ray.throughput > vec3f(0.0)) {
            break;
        }
        let direction = ray.ray.direction;
        let hit = trace(mirror.root, ray.ray, 3e38, LIGHT);
#ifdef HAZE
        let between = haze_along(ray.ray.origin, direction, hit.t, next_pair(random).x);
        found.radiance += bounded(ray.throughput * between.added);
        ray.throughput *= between.passing;
#endif
        if hit.triangle == NONE {
            found.radiance += bounded(ray.throughput * sky_along(direction));
            break;
        }
        found.distance = select(found.distance, clamp(hit.t, 1e-6, FAR), depth == 0u);
        var surface = blurred(surface_at(hit, direction), blur);
        if !surface.visible {
            break;
        }
        var light = bounded(surface.emissive) + lit_radiance(blurred(surface, WIDER * blur), direction, random);
        blur = surface.alpha;
        var next = SeenRay(ray.ray, 0.0, vec3f(0.0));
        if specular_share(surface, -direction) > GLOSSY && depth < MOST_MIRRORS {
            light += diffuse_reflectance(surface) * patch_radiance(surface, hit, random);
            surface.albedo = vec3f(0.0);
            next = ray_from(VisibleSurface(surface, -direction, 1.0, false), random);
        } else {
            light += even_reflectance(surface, -direction) * patch_radiance(surface, hit, random);
        }
        found.radiance += bounded(ray.throughput * light);
        ray = SeenRay(next.ray, next.density, ray.throughput * next.throughput);
    }
    return found;
}

fn share_of_lobe(drawn: Drawn, seen: VisibleSurface) -> f32 {
    var surface = seen.surface;
    surface.albedo = drawn.albedo;
    return specular_share(surface, seen.to_eye);
}

// `share` is that of the specular lobe in what the surface reflects.
fn reflection(pixel: vec2u, seen: VisibleSurface, share: f32) -> Reflection {
    let rays = clamp(u32(round(share * f32(RAYS))), 1u, RAYS);
    var sum = Reflection(vec3f(0.0), 0.0);
    for (var i = 0u; i < rays; i++) {
        var random = Sampler(hash_pair(mirror.seed, 0x68e31da4u), number_of(pixel) * RAYS + i, 0u);
        let found = reflection_along(ray_from(seen, &random), seen.surface.alpha, &random);
        sum.radiance += found.radiance;
        // What is near parts most from what a pixel beside it shows.
        sum.distance += 1.0 / found.distance;
    }
    return Reflection(sum.radiance / f32(rays), f32(rays) / sum.distance);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2u(thread.x, thread.y + mirror.first_row);
    if any(pixel >= mirror.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    var found = Reflection(vec3f(0.0), 0.0);
    if z > 0.0 {
        let position = world_position(pixel, mirror.view.size, z, mirror.view.world_from_clip);
        let drawn = decode_surface(
            textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, position,
        );
        let seen = mirror_surface(mirror.view, drawn);
        if seen.is_mirror {
            found = reflection(pixel, seen, share_of_lobe(drawn, seen));
        }
    }
    textureStore(mirrored, pixel, vec4f(found.radiance, found.distance));
}
