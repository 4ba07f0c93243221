// What surfels see: from each a few rays go out, distributed as the cosine, and each is kept as a link to the patch that it
// meets. So the irradiance of a surfel is the mean over its links of what their patches send back (Monte Carlo form factors:
// Malley 1988; Cohen and Wallace 1993, section 4.4.3), whatever light there is, and the links are as good for the next frame
// as long as nothing moves. The weights of a surfel's links sum up to no more than one: no bounce can gain light.
//
// The light of a patch is a mean over its surfels. What lies near sees less of the others than they do, and has less light than
// they have: in a crevice both sides are dark. So where a link meets something near it goes on from there, in another direction,
// until it has come far (as the final gather does: Christensen 1999, "Faster photon map global illumination"). What of the
// surfaces on its way counts for the lights' light is one of them, each with the same chance.
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
#import lightwell::patches::{NO_PATCH, patch_at}
#import lightwell::radiosity::{ENDS, LinkEnd, LinkRay, MOST_MET, RAYS, encode_link, encode_link_end, link_end_of, links_of, no_link}
#import lightwell::radiosity::no_link_end
#import lightwell::ray_scene::{NONE, primitive_of}
#import lightwell::ray_surfaces::{Surface, leave_surface, surface_at}
#import lightwell::rays::{Hit, Ray, LIGHT, SHADOW, no_hit}
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
    far: f32,              // distance beyond which what is met is not of the surfel's own surroundings [m]
    parts: u32,            // every so manieth surfel has its turn
    near: f32,             // distance up to which links go on from what they meet [m]; 0: none does
}

@group(0) @binding(0) var<uniform> links: Links;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
// And their ends, see `lib/radiosity.wgsl`.
@group(0) @binding(2) var<storage, read_write> surfel_links: array<vec2u>;
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
fn white_surface(position: vec3f, normal: vec3f, error: f32) -> Surface {
    var surface: Surface;
    surface.position = position;
    surface.normal = normal;
    surface.geometric_normal = normal;
    surface.albedo = vec3f(1.0);
    surface.alpha = 1.0;
    surface.error = error;
    return surface;
}

fn surface_of(surfel: Surfel) -> Surface {
    // Transforms round more often than a point of a triangle is.
    let p = abs(surfel.position);
    return white_surface(surfel.position, surfel.normal, max(p.x, max(p.y, p.z)) * 0x1p-19f);
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

// What a link finds.
struct Found {
    light: vec3f,          // of emissive surfaces and the sky, over π [W/m²]
    link: vec2u,
    end: LinkEnd,
    is_far: bool,
}

fn follow(surfel: Surface, random: ptr<function, Sampler>) -> Found {
    var found = Found(vec3f(0.0), no_link(), no_link_end(), false);
    var surface = surfel;
    // What arrives of light that comes along the ray.
    var passing = vec3f(1.0);
    // Of so many ends, each as likely as the others, one is kept.
    var ends = 0u;
    var kept = LinkRay(vec3f(0.0), vec3f(0.0), no_hit(0.0));
    var kept_passing = vec3f(0.0);
    for (var met = 1u; met <= MOST_MET; met++) {
        let direction = cosine_direction(surface.normal, next_pair(random));
        found.light += passing * sampled_light(surface, random);
        let density = direction_density(surface, surface.normal, direction, 0.0);
        let ray = Ray(leave_surface(surface, direction), direction);
        let hit = trace(links.root, ray, select(0.0, 3e38, density > 0.0), LIGHT);
        let before = passing;
        passing *= left_by_glass(links.root, ray, hit.t);
#ifdef MEDIA
        passing *= share_not_absorbed(surface.position, direction, select(hit.t, FARTHEST, hit.triangle == NONE));
#endif
        if density <= 0.0 {
            break;
        }
        if hit.triangle == NONE {
            found.is_far |= met == 1u;
            found.light += passing * bounded(sky_light(direction, density));
            break;
        }
        let end = surface_at(hit, direction);
        if !end.visible {
            break;
        }
        found.is_far |= met == 1u && hit.t > links.far;
        found.light += passing * bounded(end.emissive * emission_weight(end, hit, direction, density, f32(EMITTER_CANDIDATES)));
        ends++;
        if ends == 1u || next_pair(random).x * f32(ends) < 1.0 {
            kept = LinkRay(surface.position, direction, hit);
            kept_passing = before;
        }
        passing *= even_reflectance(end, -direction);
        let patch_there = patch_at(primitive_of(hit.triangle), end.position, end.geometric_normal);
        if (hit.t > links.near && patch_there != NO_PATCH) || links.near == 0.0 || met == MOST_MET {
            found.link = encode_link(patch_there, passing);
            break;
        }
        surface = white_surface(end.position, end.geometric_normal, end.error);
    }
    if ends > 0u {
        found.end = encode_link_end(kept, f32(ends) * kept_passing);
    }
    return found;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = links.first + (thread.x + thread.y * groups.x * 64u) * links.parts;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surface = surface_of(surfels[index]);
    var light = vec3f(0.0);
    var far = 0u;
    for (var i = links.first_ray; i < links.first_ray + AT_ONCE; i++) {
        var random = Sampler(links.seed, index * RAYS + i, 0u);
        let found = follow(surface, &random);
        light += found.light;
        far += select(0u, 1u, found.is_far);
        surfel_links[links_of(index) + i] = found.link;
        if i < ENDS {
            let at = link_end_of(index, i);
            surfel_links[at] = found.end.seen;
            surfel_links[at + 1u] = found.end.ray;
            surfel_links[at + 2u] = found.end.weight;
        }
    }
    let parts = arrayLength(&surfels) + index * PARTS;
    shone_on[parts + links.first_ray / AT_ONCE] = vec4f(light * (PI / f32(RAYS)), f32(far) / f32(RAYS));
    var all = vec4f(0.0);
    for (var part = 0u; part < PARTS; part++) {
        all += shone_on[parts + part];
    }
    shone_on[index] = all;
}
