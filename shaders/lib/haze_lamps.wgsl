#define_import_path lightwell::haze_lamps

// Light that reaches a point of a medium straight from lights: past what casts shadows, by the shadow map of the direct pass, and
// through the media. One light that casts shadows at a time, or all that cast none.
//   SHADOWED  it is one that does

#import lightwell::lights::{Light, light_incidence}
#import lightwell::media::{FARTHEST, transmittance}
#ifdef SHADOWED
#import lightwell::shadow_lookup::{Shadow, shadow_coordinate, shadow_receiver}
#endif

@group(0) @binding(13) var<storage, read> lamps: array<Light>;
#ifdef SHADOWED
@group(0) @binding(14) var<uniform> shadow: Shadow;
@group(0) @binding(15) var shadow_map: texture_depth_2d_array;
@group(0) @binding(16) var shadow_sampler: sampler_comparison;
#endif

struct Arriving {
    to_light: vec3f,       // unit
    distance: f32,         // [m]; 0: the light comes from far
    irradiance: vec3f,     // on a plane across the light [W/m²]
}

// All of them. Where a loop hangs on a uniform alone, Mesa's software driver (22.3) makes the shader anew in every frame, and
// keeps all: `thread` is any number that differs between threads.
fn lamp_count(thread: u32) -> u32 {
    return min(arrayLength(&lamps), 0xfffffffu + thread);
}

// Points of a part of a line of sight whose shadow is looked up: borders of shafts cross it at any place.
const POINTS: u32 = 4u;

// The same where the point stands for a part of a line of sight, whose points are `step` apart, the first one at `first`.
fn arriving_between(index: u32, position: vec3f, first: vec3f, step: vec3f) -> Arriving {
    let incidence = light_incidence(lamps[index], position);
    var found = Arriving(incidence.to_light, incidence.distance, vec3f(0.0));
    if all(incidence.irradiance <= vec3f(0.0)) {
        return found;
    }
    var lit = 1.0;
#ifdef SHADOWED
    lit = 0.0;
    for (var k = 0u; k < POINTS; k++) {
        let receiver = shadow_receiver(shadow.view, first + f32(k) * step, incidence.to_light, incidence.to_light);
        let at = shadow_coordinate(shadow.view, shadow.faces[receiver.face].clip_from_world, receiver);
        if at.inside {
            lit += textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv, at.face, at.depth) / f32(POINTS);
        } else {
            lit += 1.0 / f32(POINTS);
        }
    }
#endif
    if lit > 0.0 {
        let distance = select(incidence.distance, FARTHEST, incidence.distance == 0.0);
        found.irradiance = incidence.irradiance * (lit * transmittance(position, incidence.to_light, distance));
    }
    return found;
}

fn arriving(index: u32, position: vec3f) -> Arriving {
    let incidence = light_incidence(lamps[index], position);
    var found = Arriving(incidence.to_light, incidence.distance, vec3f(0.0));
    if all(incidence.irradiance <= vec3f(0.0)) {
        return found;
    }
    var lit = 1.0;
#ifdef SHADOWED
    let receiver = shadow_receiver(shadow.view, position, incidence.to_light, incidence.to_light);
    let at = shadow_coordinate(shadow.view, shadow.faces[receiver.face].clip_from_world, receiver);
    if at.inside {
        lit = textureSampleCompareLevel(shadow_map, shadow_sampler, at.uv, at.face, at.depth);
    }
#endif
    if lit > 0.0 {
        let distance = select(incidence.distance, FARTHEST, incidence.distance == 0.0);
        found.irradiance = incidence.irradiance * (lit * transmittance(position, incidence.to_light, distance));
    }
    return found;
}
