#define GLASS
#define ON_SCREEN
// Glass that the camera sees: what passes it, refracted, and what it reflects, by rays. Rays start at the nearest glass of a pixel;
// what they show is taken from the image of the opaque surfaces, where that shows it too, see lib/seen_along.wgsl. Light that
// the glass itself scatters, and highlights, are drawn by blend.wgsl.
//   RAYS        rays of a pixel at rough glass; clear glass has one that passes and one that it reflects
//   LAYER       the light that is asked for
//   ONE_BOUNCE, HAZE and others: as in lib/seen_along.wgsl

#import lightwell::color::luminance
#import lightwell::gbuffer::world_position
#import lightwell::ray_scene::{NONE, primitive_of}
#ifdef DISPERSION
#import lightwell::ray_surfaces::followed_color
#endif
#import lightwell::ray_surfaces::{Surface, surface_at}
#import lightwell::rays::{Hit, PANE, Ray}
#import lightwell::walk::trace
#import lightwell::refraction::CLEAR
#import lightwell::rough_glass::{RoughGlass, encode_rough_glass}
#import lightwell::sampling::{Sampler, hash_pair}
#import lightwell::seen_along::{Around, Branch, FAR, around, follow, light_at_glass, screen, surfaces_met}
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
// What lights make of it, which no filter may blur [W/(m² sr)].
@group(0) @binding(5) var glow_at_glass: texture_storage_2d<rgba32float, write>;
// See lib/rough_glass.wgsl; 0: there is none.
@group(0) @binding(4) var rough_glass: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(2) var depth: texture_depth_2d;
// That of the nearest glass.
@group(0) @binding(3) var mask: texture_depth_2d;

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif

// Surfaces from which on a way through clear glass is one of many that a pixel shows: what is reflected within a body again and again
// changes from point to point. Such a pixel has more rays, and where they differ it is filtered by about a pixel.
const MANY_SURFACES: u32 = 10u;
// How much rays of such a pixel differ, over what they bring in the mean, from which on no image is seen.
const NO_IMAGE: f32 = 0.3;
// Mark of such pixels in the number of their primitive: they share with no others.
const MANIFOLD: u32 = 0x80000000u;
const RAYS_OF_MANY_SURFACES: u32 = max(RAYS / 2u, 1u);
// Width of that filter [pixels].
const PIXELS_OF_MANY_SURFACES: f32 = 1.2;

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

struct InGlass {
    radiance: vec3f,       // [W/(m² sr)]
    glow: vec3f,           // [W/(m² sr)]
    distance: f32,         // from the glass to what is seen [m]
    is_manifold: bool,     // clear as it is, no image is seen
}

fn seen_in(surface: Surface, hit: Hit, ray: Ray, number: u32) -> InGlass {
    var rays = select(1u, RAYS, surface.alpha > CLEAR);
    var sum = InGlass(vec3f(0.0), vec3f(0.0), 0.0, false);
    var squares = 0.0;
    for (var i = 0u; i < rays; i++) {
        var random = Sampler(hash_pair(glass.seed, 0x3c6ef372u), number * RAYS + i, 0u);
        let found = follow(Branch(SeenRay(ray, 0.0, vec3f(1.0)), vec3f(0.0), 0.0, true), hit, &random);
        sum.radiance += found.radiance;
        sum.glow += light_at_glass;
        // What is near parts most from what a pixel beside it shows.
        sum.distance += 1.0 / found.distance;
        let brightness = min(luminance(found.radiance), 1e15);
        squares += brightness * brightness;
        if surface.alpha <= CLEAR && surfaces_met >= MANY_SURFACES {
            rays = RAYS_OF_MANY_SURFACES;
        }
    }
    let share = 1.0 / f32(rays);
    let mean = share * luminance(sum.radiance);
    sum.is_manifold = surface.alpha <= CLEAR && share * squares > (1.0 + NO_IMAGE * NO_IMAGE) * mean * mean;
    return InGlass(share * sum.radiance, share * sum.glow, 1.0 / (share * sum.distance), sum.is_manifold);
}

#ifdef DISPERSION
// Where the nearest surface parts colours, each goes its own way.
fn seen_in_colors(surface: Surface, hit: Hit, ray: Ray, number: u32) -> InGlass {
    if surface.dispersion <= 0.0 {
        return seen_in(surface, hit, ray, number);
    }
    var sum = InGlass(vec3f(0.0), vec3f(0.0), 0.0, false);
    for (var color = 0u; color < 3u; color++) {
        followed_color = f32(color) - 1.0;
        let found = seen_in(surface, hit, ray, number);
        let is_own = vec3u(0u, 1u, 2u) == vec3u(color);
        sum.radiance = select(sum.radiance, found.radiance, is_own);
        sum.glow = select(sum.glow, found.glow, is_own);
        sum.distance = found.distance;
        sum.is_manifold = sum.is_manifold || found.is_manifold;
    }
    return sum;
}
#endif

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
    var rough = vec4u(0u);
    var shone = vec3f(0.0);
    if hit.triangle != NONE {
        let surface = surface_at(hit, sight.ray.direction);
#ifdef DISPERSION
        let found = seen_in_colors(surface, hit, sight.ray, number_of(pixel));
#else
        let found = seen_in(surface, hit, sight.ray, number_of(pixel));
#endif
        seen = vec4f(found.radiance, max(hit.t, 1e-6));
        shone = found.glow;
        if surface.alpha > CLEAR && any(surface.passing > vec3f(0.0)) {
            let known = RoughGlass(surface.normal, surface.alpha, surface.is_solid);
            rough = encode_rough_glass(known, primitive_of(hit.triangle), found.distance);
        } else if found.is_manifold {
            let known = RoughGlass(surface.normal, PIXELS_OF_MANY_SURFACES * glass.view.pixel, false);
            rough = encode_rough_glass(known, MANIFOLD | primitive_of(hit.triangle), FAR);
        }
    }
    textureStore(seen_through, pixel, seen);
    textureStore(glow_at_glass, pixel, vec4f(shone, 0.0));
    textureStore(rough_glass, pixel, rough);
}
