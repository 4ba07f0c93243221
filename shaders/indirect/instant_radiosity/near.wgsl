// The light that the bound on virtual lights leaves out (bias compensation: Kollig and Keller 2004, "Illumination in the
// presence of weak singularities"). Within d_min the sum has 1/d_min² in place of 1/d². The rest is light of surfaces that
// are so near, and a short ray finds them: of what a surface at distance t sends the share
//   1 − min(1/t², 1/d_min²)·t² = max(0, 1 − t²/d_min²)
// is missing, with the d_min of the virtual lights that would stand for it there: light of a light for those of its first
// hits, and light of a virtual light, of which one is chosen, for those of the next hits.
//   RAYS        rays of a pixel
//   RADIUS      of the filter [pixels]
//   MATTE       as in lib/vpl.wgsl; others as in lib/ray_scene.wgsl

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{Surface as Drawn, decode_albedo, decode_normal, decode_surface, world_position}
#import lightwell::lights::Incidence
#import lightwell::next_event::{LightSample, bounded, incidence_of, no_light, reflected, toward_light}
#import lightwell::ray_scene::{NONE, load_light}
#import lightwell::ray_surfaces::{Surface, leave_surface, surface_at}
#import lightwell::rays::{Ray, LIGHT, SHADOW}
#import lightwell::walk::{left_by_glass, passed, trace}
#import lightwell::sampling::{Sampler, is_chosen, next_pair}
#import lightwell::visible_surface::{VisibleSurface, by_lobe, number_of, ray_from, seen_surface}
#import lightwell::view::View
#import lightwell::vpl::{VirtualLight, connect}

// One block of uniforms: where there are several and a branch hangs on one of them alone, Mesa's software driver (22.3)
// makes the shader anew in every frame, and keeps all.
struct Near {
    view: View,
    root: u32,             // of the hierarchy
    light_count: u32,
    virtual_count: u32,    // virtual lights; 0: none is followed by another hit
    seed: u32,
    reach: f32,            // the largest d_min [m]
    glow: f32,             // d_min of virtual lights on emissive surfaces [m]
    first_row: u32,        // of this dispatch
}

@group(0) @binding(0) var<uniform> near: Near;
// d_min of the first hits of each light [m].
@group(0) @binding(1) var<storage, read> nearest: array<f32>;
@group(0) @binding(2) var<storage, read> virtual_lights: array<VirtualLight>;
@group(0) @binding(3) var base_color: texture_2d<u32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var object: texture_2d<u32>;
@group(0) @binding(6) var depth: texture_depth_2d;
// Diffuse light as of a white surface, and closeness of what the rays met [1/m]; light of the specular lobe.
@group(0) @binding(7) var diffuse_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var specular_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(9) var diffuse: texture_2d<f32>;
@group(0) @binding(10) var specular: texture_2d<f32>;
// The contribution of the virtual lights, and that with the near light.
@group(0) @binding(11) var summed: texture_2d<f32>;
@group(0) @binding(12) var indirect: texture_storage_2d<rgba32float, write>;

#ifdef RAYS
const RAYS: u32 = #{RAYS}u;
#else
const RAYS: u32 = 1u;
#endif
#ifdef RADIUS
const RADIUS: i32 = #{RADIUS};
#else
const RADIUS: i32 = 1;
#endif

// Virtual lights that one is chosen from (resampling: Talbot, Cline and Egbert 2005).
const CANDIDATES: u32 = 4u;
// The bound on the light of virtual lights at what a ray met, over theirs. Rays meet other places from pixel to pixel, and
// the filter takes their mean: no spot stays, and less light is lost.
const SHARPER: f32 = 0.5;
// Distance over that of what is near at which a neighbour's weight has fallen to 1/e, as in indirect/light_volumes/sweep/gather_filter.wgsl;
// but within LEAST pixels all count, or corners would be noise.
const TOLERANCE: f32 = 0.2;
const LEAST: f32 = 2.0;

// Share of the light from a surface at a distance that a bound leaves out.
fn left_out(distance: f32, bound: f32) -> f32 {
    if bound <= 0.0 {
        return 0.0;
    }
    let q = distance / bound;
    return max(0.0, 1.0 - q * q);
}

fn brightness(light: vec3f) -> f32 {
    return light.r + light.g + light.b;
}

// What a surface reflects of one light, chosen in proportion to what each would contribute (weighted reservoir, Chao 1982).
fn of_lamp(surface: Surface, to_eye: vec3f, distance: f32, random: f32, on_light: vec2f) -> LightSample {
    var total = 0.0;
    var chosen: Incidence;
    var chosen_light = vec3f(0.0);
    var casts_shadow = false;
    var pick = random;
    for (var i = 0u; i < near.light_count; i++) {
        let candidate = load_light(i);
        let share = left_out(distance, nearest[i]);
        if candidate.indirect == 0u || share <= 0.0 {
            continue;
        }
        let incidence = incidence_of(candidate.light, surface.position, on_light);
        let light = share * bounded(reflected(surface, to_eye, incidence.to_light) * incidence.irradiance);
        let weight = brightness(light);
        if weight <= 0.0 {
            continue;
        }
        total += weight;
        if is_chosen(&pick, weight / total) {
            chosen = incidence;
            chosen_light = light;
            casts_shadow = candidate.casts_shadow != 0u;
        }
    }
    if total <= 0.0 {
        return no_light();
    }
    return toward_light(surface, chosen, chosen_light * (total / brightness(chosen_light)), casts_shadow);
}

// What a surface reflects of the virtual lights, by one of them.
fn of_virtual_light(surface: Surface, to_eye: vec3f, distance: f32, random: ptr<function, Sampler>) -> LightSample {
    let drawn = Drawn(
        surface.position, surface.normal, surface.albedo, surface.normal_reflectance, surface.grazing_reflectance,
        sqrt(surface.alpha), true,
    );
    var total = 0.0;
    var chosen = no_light();
    for (var i = 0u; i < CANDIDATES; i++) {
        let u = next_pair(random);
        var light = virtual_lights[min(u32(u.x * f32(near.virtual_count)), near.virtual_count - 1u)];
        light.nearest *= SHARPER;
        let share = left_out(distance, light.next);
        let c = connect(light, drawn, to_eye);
        let value = share * c.radiance;
        let weight = brightness(value);
        if weight <= 0.0 {
            continue;
        }
        total += weight;
        if u.y < weight / total {
            let origin = leave_surface(surface, c.to_light);
            let ray = Ray(origin, select(c.end - origin, c.to_light, c.distant));
            chosen = LightSample(value / weight, ray, select(1.0, 3e38, c.distant), 0.0);
        }
    }
    chosen.light *= total * f32(near.virtual_count) / f32(CANDIDATES);
    return chosen;
}

fn unblocked(sample: LightSample) -> vec3f {
    let hit = trace(near.root, sample.ray, sample.reach, SHADOW);
    if hit.triangle != NONE {
        return vec3f(0.0);
    }
    return bounded(sample.light * passed(sample.ray, hit));
}

// Light that a surface sends back along a ray which met it, as far as it is left out.
fn sent(surface: Surface, direction: vec3f, distance: f32, random: ptr<function, Sampler>) -> vec3f {
    var light = surface.emissive * left_out(distance, near.glow);
    let pick = next_pair(random).x;
    var on_light = vec2f(0.0);
#ifdef AREA_LIGHTS
    on_light = next_pair(random);
#endif
    light += unblocked(of_lamp(surface, -direction, distance, pick, on_light));
    if near.virtual_count > 0u {
        light += unblocked(of_virtual_light(surface, -direction, distance, random));
    }
    return light;
}

struct Sums {
    diffuse: vec3f,
    specular: vec3f,
    closeness: f32,
}

fn gathered(pixel: vec2u, seen: VisibleSurface) -> Sums {
    var sums = Sums(vec3f(0.0), vec3f(0.0), 0.0);
    for (var i = 0u; i < RAYS; i++) {
        var random = Sampler(near.seed, number_of(pixel) * RAYS + i, 0u);
        let ray = ray_from(seen, &random);
        if all(ray.throughput <= vec3f(0.0)) {
            continue;
        }
        let hit = trace(near.root, ray.ray, near.reach, LIGHT);
        sums.closeness += 1.0 / max(hit.t, 1e-30);
        if hit.triangle == NONE {
            continue;
        }
        let surface = surface_at(hit, ray.ray.direction);
        if surface.visible {
            let left = left_by_glass(near.root, ray.ray, hit.t);
            let light = left * ray.throughput * bounded(sent(surface, ray.ray.direction, hit.t, &random));
            let brought = by_lobe(seen, ray.ray.direction, light);
            sums.diffuse += brought.diffuse;
            sums.specular += brought.specular;
        }
    }
    return Sums(sums.diffuse / f32(RAYS), sums.specular / f32(RAYS), sums.closeness / f32(RAYS));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2u(thread.x, thread.y + near.first_row);
    if any(pixel >= near.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    var sums = Sums(vec3f(0.0), vec3f(0.0), 0.0);
    if z > 0.0 {
        let drawn = decode_surface(
            textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z,
            world_position(pixel, near.view.size, z, near.view.world_from_clip),
        );
        sums = gathered(pixel, seen_surface(near.view, drawn));
    }
    textureStore(diffuse_out, pixel, vec4f(sums.diffuse, sums.closeness));
    textureStore(specular_out, pixel, vec4f(sums.specular, 0.0));
}

// ---- Filter ----

struct Filtered {
    diffuse: vec4f,
    specular: vec3f,
}

fn filtered(pixel: vec2u, z: f32, along: vec2i) -> Filtered {
    let position = world_position(pixel, near.view.size, z, near.view.world_from_clip);
    let texel = textureLoad(normal, pixel, 0);
    let n = decode_normal(texel);
    let roughness = f32(texel.z) / 65535.0;
    let own = textureLoad(diffuse, pixel, 0);
    // Of the specular lobe: about its width over that of the diffuse one.
    let lobe = max(1.0, saturate(2.0 * roughness * roughness) * f32(RADIUS));
    var sum = Filtered(own, textureLoad(specular, pixel, 0).rgb);
    var weights = vec2f(1.0);
    for (var d = 1 - RADIUS; d < RADIUS; d++) {
        let at = vec2i(pixel) + d * along;
        if d == 0 || any(at < vec2i(0)) || any(at >= vec2i(near.view.size)) {
            continue;
        }
        let other = vec2u(at);
        let other_z = textureLoad(depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let other_position = world_position(other, near.view.size, other_z, near.view.world_from_clip);
        let like = likeness(position, n, other_position, decode_normal(textureLoad(normal, other, 0)));
        let off = (other_position - position) * (own.a / TOLERANCE);
        let close = exp(-min(dot(off, off), f32(d * d) / (LEAST * LEAST)));
        let weight = close * saturate(1.0 - f32(abs(d)) / vec2f(f32(RADIUS), lobe)) * like;
        sum.diffuse += weight.x * textureLoad(diffuse, other, 0);
        sum.specular += weight.y * textureLoad(specular, other, 0).rgb;
        weights += weight;
    }
    return Filtered(sum.diffuse / weights.x, sum.specular / weights.y);
}

@compute @workgroup_size(8, 8)
fn horizontal(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= near.view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var result = Filtered(vec4f(0.0), vec3f(0.0));
    if z > 0.0 {
        result = filtered(thread.xy, z, vec2i(1, 0));
    }
    textureStore(diffuse_out, thread.xy, result.diffuse);
    textureStore(specular_out, thread.xy, vec4f(result.specular, 0.0));
}

@compute @workgroup_size(8, 8)
fn vertical(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= near.view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var radiance = textureLoad(summed, thread.xy, 0).rgb;
    if z > 0.0 {
        let light = filtered(thread.xy, z, vec2i(0, 1));
        let albedo = decode_albedo(textureLoad(base_color, thread.xy, 0));
        radiance = min(radiance + albedo * light.diffuse.rgb + light.specular, vec3f(1e32));
    }
    textureStore(indirect, thread.xy, vec4f(radiance, 1.0));
}
