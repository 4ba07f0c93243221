#define GLASS
#define ON_SCREEN
// Glass that the camera sees: what passes it, refracted, and what it reflects, by rays. Rays start at the nearest glass of a pixel;
// what they show is taken from the image of the opaque surfaces, where that shows it too, see lib/seen_along.wgsl. Light that
// the glass itself scatters, and highlights, are drawn by blend.wgsl.
//   RAYS        rays of a pixel at rough glass; clear glass has one that passes and one that it reflects
//   LAYER       the light that is asked for
//   ONE_BOUNCE, HAZE and others: as in lib/seen_along.wgsl

#import lightwell::gbuffer::world_position
#import lightwell::ray_scene::NONE
#ifdef DISPERSION
#import lightwell::ray_surfaces::followed_color
#endif
#import lightwell::ray_surfaces::{Surface, surface_at}
#import lightwell::rays::{Hit, PANE, Ray}
#import lightwell::walk::trace
#import lightwell::refraction::CLEAR
#import lightwell::sampling::{Sampler, hash_pair}
#import lightwell::seen_along::{Around, Branch, around, follow, screen}
#import lightwell::view::{View, toward_eye}
#import lightwell::visible_surface::{SeenRay, number_of}

struct SeenThrough {
    view: View,
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    origin: vec2u,         // first pixel of this dispatch
    size: vec2u,           // [pixels]
    root: u32,             // of the hierarchy
    light_count: u32,
    seed: u32,
    patch_size: f32,       // [m]
}

@group(0) @binding(0) var<uniform> glass: SeenThrough;
// Radiance [W/(m² sr)], and how far from where the camera's rays start the glass is [m]; 0: there is none.
@group(0) @binding(1) var seen_through: texture_storage_2d<rgba32float, write>;
@group(0) @binding(2) var depth: texture_depth_2d;
// That of the nearest glass.
@group(0) @binding(3) var mask: texture_depth_2d;

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

// The depth behind which a pixel's line of sight has no other beginning [of the near plane's].
const FARTHEST_DEPTH: f32 = 1e-4;
// How far behind an opaque surface glass may lie and be seen, as a part of the distance.
const SLACK: f32 = 1e-4;

// The line of sight of a pixel, up to the opaque surface.
struct Sight {
    ray: Ray,
    reach: f32,            // [m]
}

fn sight_of(pixel: vec2u) -> Sight {
    let z = textureLoad(depth, pixel, 0);
    let start = world_position(pixel, glass.view.size, 1.0, glass.view.world_from_clip);
    let end = world_position(pixel, glass.view.size, max(z, FARTHEST_DEPTH), glass.view.world_from_clip);
    let direction = -normalize(toward_eye(glass.view, end));
    let reach = select(3e38, distance(start, end) * (1.0 + SLACK), z > FARTHEST_DEPTH);
    return Sight(Ray(start, direction), reach);
}

#ifdef DISPERSION
// Where the nearest surface parts colours, each goes its own way.
fn radiance_of_colors(surface: Surface, hit: Hit, ray: Ray, number: u32) -> vec3f {
    if surface.dispersion <= 0.0 {
        return radiance_of(surface, hit, ray, number);
    }
    var sum = vec3f(0.0);
    for (var color = 0u; color < 3u; color++) {
        followed_color = f32(color) - 1.0;
        let found = radiance_of(surface, hit, ray, number);
        sum = select(sum, found, vec3u(0u, 1u, 2u) == vec3u(color));
    }
    return sum;
}
#endif

fn radiance_of(surface: Surface, hit: Hit, ray: Ray, number: u32) -> vec3f {
    let rays = select(1u, RAYS, surface.alpha > CLEAR);
    var sum = vec3f(0.0);
    for (var i = 0u; i < rays; i++) {
        var random = Sampler(hash_pair(glass.seed, 0x3c6ef372u), number * RAYS + i, 0u);
        sum += follow(Branch(SeenRay(ray, 0.0, vec3f(1.0)), vec3f(0.0), 0.0, true), hit, &random).radiance;
    }
    return sum / f32(rays);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= glass.size) {
        return;
    }
    let pixel = glass.origin + thread.xy;
    around = Around(glass.sky, glass.sky_turn, glass.root, glass.light_count, glass.patch_size);
    screen = glass.view;
    let sight = sight_of(pixel);
    let z = textureLoad(mask, pixel, 0);
    let is_there = z > 0.0 && z >= textureLoad(depth, pixel, 0) * (1.0 - SLACK);
    let hit = trace(glass.root, sight.ray, select(0.0, sight.reach, is_there), PANE);
    var seen = vec4f(0.0);
    if hit.triangle != NONE {
        let surface = surface_at(hit, sight.ray.direction);
#ifdef DISPERSION
        seen = vec4f(radiance_of_colors(surface, hit, sight.ray, number_of(pixel)), max(hit.t, 1e-6));
#else
        seen = vec4f(radiance_of(surface, hit, sight.ray, number_of(pixel)), max(hit.t, 1e-6));
#endif
    }
    textureStore(seen_through, pixel, seen);
}
