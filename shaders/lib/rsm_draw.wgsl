#define_import_path lightwell::rsm_draw

// Texels of reflective shadow maps, drawn in proportion to the flux that they receive.
//   REFLECTED  to the flux that they reflect diffusely
//
// Texels are weighed in strips of a row, whose running sum over all maps is searched for each sample. `weigh` and `sum_up` of
// indirect/light_volumes/sweep/rsm_samples.wgsl make that sum.

#import lightwell::gbuffer::{decode_albedo, world_position}
#import lightwell::lights::Light
#import lightwell::rsm::{RsmLayer, texel_received}
#import lightwell::sampling::{hash_pair, unit_float}

struct Draw {
    low: vec3f,            // texels beyond this box have no weight [m]
    first_strip: u32,      // of the map
    high: vec3f,
    strips: u32,           // of all maps
    points: u32,
    seed: u32,
    scale: f32,            // a power of two by which flux is weighed [1/W]: all of it is below 2³⁸
    light: u32,            // the map's light among the scene's
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> rsm: RsmLayer;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var normal: texture_2d_array<u32>;
@group(0) @binding(5) var specular: texture_2d_array<u32>;
@group(0) @binding(6) var depth: texture_depth_2d_array;
// Weight of each strip: its flux, all channels together, times the scale.
@group(0) @binding(7) var<storage, read_write> weights: array<f32>;
// Of each strip and all before it.
@group(0) @binding(8) var<storage, read_write> cumulative: array<f32>;

const STRIP: u32 = 32u;    // texels

// Halvings that find one among all strips that maps of any size can have.
const HALVINGS: u32 = 24u;

fn strips_a_row() -> u32 {
    return (rsm.size + STRIP - 1u) / STRIP;
}

// Zero where nothing is, or what is there is black: the back of a surface with one side.
fn weigh_texel(texel: vec2u) -> f32 {
    let z = textureLoad(depth, texel, rsm.layer, 0);
    let base = textureLoad(base_color, texel, rsm.layer, 0).rgb;
    let mirrored = textureLoad(specular, texel, rsm.layer, 0).r;
    if z <= 0.0 || (all(base == vec3u(0u)) && mirrored == 0u) {
        return 0.0;
    }
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    if any(position < draw.low) || any(position > draw.high) {
        return 0.0;
    }
    var flux = draw.scale * texel_received(rsm, light, texel, position).flux;
#ifdef REFLECTED
    flux *= decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
#endif
    return flux.r + flux.g + flux.b;
}

// Without a branch: some drivers make a shader with branches on uniforms alone anew whenever those change.
fn before(strip: u32) -> f32 {
    return select(cumulative[max(strip, 1u) - 1u], 0.0, strip == 0u);
}

// First strip from `first` on, of so many, whose running sum is above the value.
fn find_strip(first: u32, count: u32, value: f32) -> u32 {
    var low = first;
    var high = first + count - 1u;
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = (low + high) / 2u;
        let is_above = cumulative[middle] > value;
        high = select(high, middle, is_above);
        low = select(min(middle + 1u, high), low, is_above);
    }
    return low;
}

// The texel of a strip at which the running sum passes the value; by rounding, the last one with any weight.
fn find_texel(strip: u32, value: f32) -> vec2u {
    let a_row = strips_a_row();
    let row = strip / a_row;
    let first = STRIP * (strip % a_row);
    let end = min(first + STRIP, rsm.size);
    var found = first;
    var running = 0.0;
    for (var x = first; x < end && running <= value; x++) {
        let w = weigh_texel(vec2u(x, row));
        found = select(found, x, w > 0.0);
        running += w;
    }
    return vec2u(found, row);
}

struct DrawnTexel {
    texel: vec2u,
    total: f32,            // weight of all texels of all maps
    is_here: bool,         // false: it lies in another map
}

// Each sample has one of as many equal parts of the sum (systematic sampling).
fn draw_texel(sample: u32) -> DrawnTexel {
    let total = cumulative[draw.strips - 1u];
    let strips = strips_a_row() * rsm.size;
    if sample >= draw.points || !(total > 0.0) {
        return DrawnTexel(vec2u(0u), total, false);
    }
    let within = unit_float(hash_pair(draw.seed, sample));
    let value = (f32(sample) + within) / f32(draw.points) * total;
    if value < before(draw.first_strip) || value >= cumulative[draw.first_strip + strips - 1u] {
        return DrawnTexel(vec2u(0u), total, false);
    }
    let strip = find_strip(draw.first_strip, strips, value);
    return DrawnTexel(find_texel(strip - draw.first_strip, value - before(strip)), total, true);
}
