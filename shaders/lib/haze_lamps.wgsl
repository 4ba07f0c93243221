#define_import_path lightwell::haze_lamps

// Light that reaches a point of a medium straight from lights: past what casts shadows, by the shadow map of the direct pass, and
// through the media. One light that casts shadows at a time, or all that cast none.
//   SHADOWED  it is one that does

#import lightwell::lights::{Light, light_incidence}
#import lightwell::media::{FARTHEST, transmittance}
#ifdef SHADOWED
#import lightwell::shadow_lookup::{Shadow, shadow_coordinate}
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

fn arriving(index: u32, position: vec3f) -> Arriving {
    let incidence = light_incidence(lamps[index], position);
    var found = Arriving(incidence.to_light, incidence.distance, vec3f(0.0));
    if all(incidence.irradiance <= vec3f(0.0)) {
        return found;
    }
    var lit = 1.0;
#ifdef SHADOWED
    let at = shadow_coordinate(shadow, position, incidence.to_light, incidence.to_light);
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

// Mean of 1/r² along a part of a line, over that at a point of it (the integral of Kulla and Fajardo 2012, "Importance sampling
// techniques for path tracing in participating media"): near a light it varies much within a part. The light is at a distance
// from the point; the foot of its perpendicular on the line lies as far on as `foot`, from where the middle of the part is
// reached after `middle`. `width` is that across the line, nearer than which a light counts as not.
fn inverse_square_of_part(distance: f32, foot: f32, middle: f32, half_length: f32, width: f32) -> f32 {
    let across = max(sqrt(max(distance * distance - foot * foot, 0.0)), max(width, 1e-12));
    let angle = atan((middle + half_length) / across) - atan((middle - half_length) / across);
    let mean = angle / max(2.0 * half_length * across, 1e-30);
    // The difference of two angles is nothing but rounding where the part is seen from afar.
    return select(mean * distance * distance, 1.0, half_length < 1e-3 * distance);
}
