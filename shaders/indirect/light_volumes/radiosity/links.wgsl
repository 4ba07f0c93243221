// What surfels see: from each a few rays go out, distributed as the cosine, and each is kept as a link to the patch that it
// meets. So the irradiance of a surfel is the mean over its links of what their patches send back (Monte Carlo form factors:
// Malley 1988; Cohen and Wallace 1993, section 4.4.3), whatever light there is, and the links are as good for the next frame
// as long as nothing moves. The weights of a surfel's links sum up to no more than one: no bounce can gain light.
//
// What rays and shadow rays find of emissive surfaces and the sky depends on no light either, and is summed up at once.
//   RAYS      rays of a surfel
//   AT_ONCE   those of a dispatch
//   UNLIT, DIFFUSE, EVEN_SKY and others: what the scene does not have, see lib/ray_scene.wgsl

#import lightwell::next_event::{EMITTER_CANDIDATES, LightSample, bounded, direction_density, emission_weight, even_reflectance}
#ifndef UNLIT
#import lightwell::next_event::resample_emitter
#endif
#ifndef EVEN_SKY
#import lightwell::next_event::{sample_sky_light, sky_weight}
#import lightwell::sky::sky_radiance
#endif
#ifdef MEDIA
#import lightwell::media::{FARTHEST, share_not_absorbed}
#endif
#import lightwell::patches::patch_at
#import lightwell::radiosity::{RAYS, Link, encode_link, link_start, no_link}
#import lightwell::ray_scene::{NONE, primitive_of}
#import lightwell::ray_surfaces::{Surface, leave_surface, surface_at}
#import lightwell::rays::{Hit, Ray, LIGHT, SHADOW}
#import lightwell::walk::{left_by_glass, passed, trace}
#import lightwell::sampling::{Sampler, cosine_direction, next_pair}
#import lightwell::sweep::Surfel

struct Links {
    sky: vec3f,            // radiance [W/(m² sr)]
    sky_turn: f32,         // of the sky's map [rad]
    root: u32,             // of the hierarchy
    emitter_count: u32,
    seed: u32,
    first: u32,            // surfel of this dispatch
    first_ray: u32,        // of each surfel
    before: f32,           // where links start before their surfel [m]
    far: f32,              // distance beyond which what is met is not of the surfel's own surroundings [m]
    parts: u32,            // every so manieth surfel has its turn
}

@group(0) @binding(0) var<uniform> links: Links;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
// See `lib/radiosity.wgsl`: those of a surfel follow each other.
@group(0) @binding(2) var<storage, read_write> surfel_links: array<Link>;
// Irradiance from emissive surfaces and the sky [W/m²], and the share of rays that go far: by all rays of each surfel, and after
// all surfels by those of each dispatch, PARTS a surfel.
@group(0) @binding(3) var<storage, read_write> shone_on: array<vec4f>;
@group(0) @binding(4) var sky: texture_2d<f32>;

#ifdef AT_ONCE
const AT_ONCE: u32 = #{AT_ONCE}u;
#else
const AT_ONCE: u32 = 1u;
#endif
const PARTS: u32 = RAYS / AT_ONCE;

const PI: f32 = 3.14159265358979;

// A white surface, which reflects irradiance/π.
fn white_surface(surfel: Surfel) -> Surface {
    var surface: Surface;
    surface.position = link_start(surfel, links.before);
    surface.normal = surfel.normal;
    surface.geometric_normal = surfel.normal;
    surface.albedo = vec3f(1.0);
    surface.alpha = 1.0;
    // Transforms round more often than a point of a triangle is.
    let p = abs(surfel.position);
    surface.error = max(p.x, max(p.y, p.z)) * 0x1p-19f;
    return surface;
}

fn unless_blocked(sample: LightSample) -> vec3f {
    let hit = trace(links.root, sample.ray, sample.reach, SHADOW);
    if sample.reach > 0.0 && hit.triangle == NONE {
        return bounded(sample.light * passed(sample.ray, hit));
    }
    return vec3f(0.0);
}

// Emissive surfaces and the sky, sampled from the surfel.
fn sampled_light(surface: Surface, random: ptr<function, Sampler>) -> vec3f {
    var light = vec3f(0.0);
#ifndef UNLIT
    let emitter = next_pair(random);
    let place = next_pair(random);
    light += unless_blocked(resample_emitter(surface, surface.normal, 0.0, links.emitter_count, emitter, place));
#endif
#ifndef EVEN_SKY
    let texel = next_pair(random);
    let within = next_pair(random);
    light += unless_blocked(sample_sky_light(sky, links.sky_turn, surface, surface.normal, 0.0, texel, within));
#endif
    return light;
}

fn sky_light(direction: vec3f, density: f32) -> vec3f {
#ifdef EVEN_SKY
    return links.sky;
#else
    return sky_radiance(sky, direction, links.sky_turn) * sky_weight(sky, links.sky_turn, direction, density);
#endif
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = links.first + (thread.x + thread.y * groups.x * 64u) * links.parts;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surface = white_surface(surfels[index]);
    var light = vec3f(0.0);
    var far = 0u;
    for (var i = links.first_ray; i < links.first_ray + AT_ONCE; i++) {
        var random = Sampler(links.seed, index * RAYS + i, 0u);
        let direction = cosine_direction(surface.normal, next_pair(&random));
        light += sampled_light(surface, &random);
        let density = direction_density(surface, surface.normal, direction, 0.0);
        let ray = Ray(leave_surface(surface, direction), direction);
        let hit = trace(links.root, ray, select(0.0, 3e38, density > 0.0), LIGHT);
        far += select(0u, 1u, hit.t > links.far);
        var passing = left_by_glass(links.root, ray, hit.t);
#ifdef MEDIA
        passing *= share_not_absorbed(surface.position, direction, select(hit.t, FARTHEST, hit.triangle == NONE));
#endif
        var link = no_link();
        if density > 0.0 {
            if hit.triangle == NONE {
                light += passing * bounded(sky_light(direction, density));
            } else {
                let met = surface_at(hit, direction);
                if met.visible {
                    light += passing * bounded(met.emissive * emission_weight(met, hit, direction, density, f32(EMITTER_CANDIDATES)));
                    let seen = patch_at(primitive_of(hit.triangle), met.position, met.geometric_normal);
                    link = encode_link(seen, passing * even_reflectance(met, -direction), hit);
                }
            }
        }
        surfel_links[index * RAYS + i] = link;
    }
    let parts = arrayLength(&surfels) + index * PARTS;
    shone_on[parts + links.first_ray / AT_ONCE] = vec4f(light * (PI / f32(RAYS)), f32(far) / f32(RAYS));
    var all = vec4f(0.0);
    for (var part = 0u; part < PARTS; part++) {
        all += shone_on[parts + part];
    }
    shone_on[index] = all;
}
