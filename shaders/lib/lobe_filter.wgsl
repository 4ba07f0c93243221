#define_import_path lightwell::lobe_filter

// Filters over what is seen along lobes, in mirrors and through rough glass: pixels share what they found as far as each sees it
// within a part of its own lobe. What is seen at a distance t along the direction of one pixel lies off the direction of another
// by an angle, which counts over the width of the lobe. So flat, curved and grazing surfaces are blurred as their lobes blur them:
// nothing at contacts, along the view where a floor stretches its reflections.

#import lightwell::sampling::TAU

// The lobe of a pixel.
struct Lobe {
    position: vec3f,       // [m]
    direction: vec3f,      // of most of its light, unit
    across: vec3f,         // unit, in the surface and across the plane of incidence
    narrowing: f32,        // width across that plane over that within it
    alpha: f32,            // width of the lobe [rad]
    distance: f32,         // of what is seen along it [m]
}

// Which pixels a filter of the width of the lobe reaches: an ellipse.
struct Footprint {
    long: vec2f,           // half axes [pixels]
    short: vec2f,
}

// Standard deviations that a filter reaches.
const REACHED: f32 = 2.0;
// Turn from one tap to the next [rad]: the golden angle (Vogel 1979).
const GOLDEN: f32 = 2.39996323;

// Lobes narrow across the plane of incidence as half vectors turn reflected directions there by less.
fn across_of(n: vec3f, to_eye: vec3f) -> vec3f {
    let c = cross(n, to_eye);
    let size = length(c);
    return select(vec3f(0.0), c / max(size, 1e-20), size > 1e-3);
}

// Where another pixel sees what it shows, as seen by a lobe: within and across the plane of incidence [widths of the lobe].
fn offset_in(lobe: Lobe, other_position: vec3f, other_direction: vec3f) -> vec2f {
    let toward = other_position + other_direction * lobe.distance - lobe.position;
    let off = toward / max(length(toward), 1e-30) - lobe.direction;
    let sideways = dot(off, lobe.across);
    let within = off - sideways * lobe.across;
    let sign = select(-1.0, 1.0, dot(within, cross(lobe.direction, lobe.across)) >= 0.0);
    return vec2f(sign * length(within), sideways / lobe.narrowing) / lobe.alpha;
}

// From the offsets per pixel to the right and below.
fn footprint_of(right: vec2f, below: vec2f, width: f32, most: f32) -> Footprint {
    let a = dot(right, right);
    let b = dot(right, below);
    let c = dot(below, below);
    let mean = 0.5 * (a + c);
    let spread = sqrt(0.25 * (a - c) * (a - c) + b * b);
    let angle = select(0.0, 0.5 * atan2(2.0 * b, a - c), spread > 1e-12 * mean);
    let steep = vec2f(cos(angle), sin(angle));
    let reach = REACHED * width;
    let short = min(reach * inverseSqrt(max(mean + spread, 1e-12)), most);
    let long = min(reach * inverseSqrt(max(mean - spread, 1e-12)), most);
    return Footprint(long * vec2f(-steep.y, steep.x), short * steep);
}

// How many pixels share a lobe, weighted by how much they do.
fn pixels_in_lobe(right: vec2f, below: vec2f) -> f32 {
    return 2.0 * TAU / max(abs(right.x * below.y - right.y * below.x), 1e-6);
}

fn longest(footprint: Footprint) -> f32 {
    return length(footprint.long);
}

// The pixel of a tap, relative to the one in the middle.
fn tap_at(footprint: Footprint, index: u32, taps: u32, turn: f32) -> vec2i {
    let part = sqrt((f32(index) + 0.5) / f32(taps));
    let angle = turn * TAU + f32(index) * GOLDEN;
    return vec2i(round(part * (cos(angle) * footprint.long + sin(angle) * footprint.short)));
}

fn weight_of(offset: vec2f, width: f32) -> f32 {
    return exp(-0.5 * dot(offset, offset) / (width * width));
}
