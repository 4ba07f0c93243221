// Light that surfels see at the ends of their links, straight from the lights: the first bounce, by shadow rays from where the
// links end. Points of a patch differ in this light, which has borders, and not in that of further bounces.
//   RAYS     links of a surfel
//   LIGHTS   so many lights, all of which each link looks at: one that is bright but out of sight takes no samples from the
//            others. Without it there are more, and each link chooses one by what it would bring
//   HAZE     media scatter the lights' light on the way

#ifdef HAZE
#import lightwell::haze_along::haze_along
#endif
#import lightwell::next_event::{BLUR, LightRange, LightSample, NO_RAY, blurred, bounded, sample_light}
#import lightwell::radiosity::{ENDS, LinkEnd, link_end_of, link_end_weight, link_ray}
#import lightwell::ray_scene::NONE
#import lightwell::ray_surfaces::surface_at
#import lightwell::rays::{Ray, SHADOW}
#import lightwell::walk::{left_by_glass, passed, trace}
#import lightwell::sampling::{Sampler, next_pair}

struct FirstBounce {
    root: u32,             // of the hierarchy
    light_count: u32,
    seed: u32,
    first: u32,            // surfel of this dispatch
    parts: u32,            // every so manieth surfel has its turn
}

@group(0) @binding(0) var<uniform> first_bounce: FirstBounce;
@group(0) @binding(1) var<storage, read> surfel_links: array<vec2u>;
// Irradiance [W/m²].
@group(0) @binding(2) var<storage, read_write> reflected_light: array<vec4f>;

#ifdef LIGHTS
const LIGHTS: u32 = #{LIGHTS}u;
#endif

const PI: f32 = 3.14159265358979;

// Light of a light, unless something is in its way.
fn arriving(sample: LightSample) -> vec3f {
    let hit = trace(first_bounce.root, sample.ray, sample.reach, SHADOW);
    if hit.triangle != NONE {
        return vec3f(0.0);
    }
    return bounded(sample.light * passed(sample.ray, hit));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = first_bounce.first + (thread.x + thread.y * groups.x * 64u) * first_bounce.parts;
    if index >= arrayLength(&reflected_light) {
        return;
    }
    // All of them. Where a loop hangs on a uniform alone, Mesa's software driver (22.3) makes the shader anew in every frame,
    // and keeps all.
    let light_count = min(first_bounce.light_count, 0xfffffffu + index);
    var light = vec3f(0.0);
    for (var i = 0u; i < ENDS; i++) {
        let at = link_end_of(index, i);
        let end = LinkEnd(surfel_links[at], surfel_links[at + 1u], surfel_links[at + 2u]);
        if end.seen.x == NONE {
            continue;
        }
        let ray = link_ray(end);
        let surface = blurred(surface_at(ray.hit, ray.direction), BLUR);
        var random = Sampler(first_bounce.seed, index * ENDS + i, 0u);
        let weight = link_end_weight(end);
        var passing = weight * left_by_glass(first_bounce.root, Ray(ray.start, ray.direction), ray.hit.t);
#ifdef HAZE
        let between = haze_along(ray.start, ray.direction, ray.hit.t, next_pair(&random).x);
        light += weight * bounded(between.added);
        passing *= between.passing;
#endif
#ifdef LIGHTS
        var of_all = vec3f(0.0);
        for (var k = 0u; k < LIGHTS; k++) {
            var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
            on_light = next_pair(&random);
#endif
            of_all += arriving(sample_light(surface, -ray.direction, NO_RAY, LightRange(k, k + 1u), false, 0.0, on_light));
        }
        light += passing * of_all;
#else
        let pick = next_pair(&random).x;
        var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
        on_light = next_pair(&random);
#endif
        light += passing * arriving(sample_light(surface, -ray.direction, NO_RAY, LightRange(0u, light_count), false, pick, on_light));
#endif
    }
    reflected_light[index] = vec4f(light * (PI / f32(ENDS)), 0.0);
}
