// What the media in each slice of each column scatter towards the eye, over their density: Σ τᵢ·ρᵢ·(Σ pᵢ·E + light of further
// bounces)/Σ τᵢ, with the optical depths τ of the media there, their albedos ρ and phase functions p, and the irradiance E from
// each light, past shadows and through the media. Light of further bounces is that of the volumes, of which the first
// harmonics count: J − 3g/(4π)·F·ω of its mean radiance J and its net flux F (Pharr, Jakob and Humphreys 2023, section 11.4).
//   LIT       light straight from the lights
//   SWEPT     light of further bounces
//   SHADOWED  the light casts shadows
//   MORE      other light is there already

#import lightwell::haze::{Haze, SLICES, haze_index, sight_through, slice_distance}
#ifdef LIT
#import lightwell::haze_lamps::{POINTS, arriving_between, lamp_count, lamps}
#import lightwell::lights::{Light, is_distant}
#import lightwell::media::{equiangular, equiangular_distance}
#endif
#import lightwell::gbuffer::world_position
#import lightwell::media::{MEDIA, Span, depth_of, media, phase, span_in, span_of_all}
#ifdef SWEPT
#import lightwell::sweep_lookup::fluence_at
#import lightwell::volume::Volume
#endif
#import lightwell::sampling::TAU
#import lightwell::view::View

@group(0) @binding(41) var<uniform> view: View;
@group(0) @binding(39) var<uniform> haze: Haze;
@group(0) @binding(44) var depth: texture_depth_2d;
// [W/(m² sr)]
@group(0) @binding(42) var<storage, read_write> scattered: array<vec4f>;
#ifdef SWEPT
@group(0) @binding(43) var<uniform> swept: Volume;
#endif

const MAX_RADIANCE: f32 = 1e30;

struct Slice {
    origin: vec3f,         // of the line of sight
    direction: vec3f,
    at: f32,               // distance of the point where light is looked up [m]
    middle: f32,
    half_length: f32,
    low: f32,              // between which distances light may be looked up [m]
    high: f32,
    width: f32,            // half of it, across the line of sight [m]
    depth: f32,            // optical depth of all media
    quantile: f32,         // share of what it scatters that lies before the points where light is looked up
}

// Four columns beside each other look light up at four depths, whose mean `integrate.wgsl` takes.
fn quantile_of(column: vec2u) -> f32 {
    let step = (column.x & 1u) * 2u + ((column.x + column.y) & 1u);
    return fract(0.625 + haze.depth_shift + 0.25 * f32(step));
}

// Optical depth of a medium. It is computed where it is needed: most scenes have one or two.
fn depth_of_medium(slice: Slice, index: u32) -> f32 {
    let begin = slice.middle - slice.half_length;
    let end = slice.middle + slice.half_length;
    let whole = span_in(media[index], slice.origin, slice.direction, end);
    return depth_of(media[index], slice.origin, slice.direction, Span(max(whole.begin, begin), whole.end));
}

fn slice_at(column: vec2u, index: u32) -> Slice {
    let at = (vec2f(column) + 0.5 + haze.shift) * haze.tile;
    let sight = sight_through(view, at);
    let begin = slice_distance(haze, f32(index));
    let end = slice_distance(haze, f32(index + 1u));
    var slice: Slice;
    slice.origin = sight.origin;
    slice.direction = sight.direction;
    slice.middle = 0.5 * (begin + end);
    slice.half_length = 0.5 * (end - begin);
    for (var i = 0u; i < MEDIA; i++) {
        slice.depth += depth_of_medium(slice, i);
    }
    // Half of what is scattered in an even slice is so before that point.
    slice.quantile = quantile_of(column);
    let u = slice.quantile;
    let within = select(-log(1.0 - u * (1.0 - exp(-min(slice.depth, 80.0)))) / max(slice.depth, 1e-30), u, slice.depth < 1e-2);
    // Within a medium, and before the surface that is seen there: what lies behind may be another room.
    let pixel = vec2u(clamp(at, vec2f(0.0), vec2f(view.size) - 1.0));
    let z = textureLoad(depth, pixel, 0);
    let seen = distance(sight.origin, world_position(pixel, view.size, max(z, 1e-30), view.world_from_clip));
    let whole = span_of_all(sight.origin, sight.direction, end);
    let low = max(begin, whole.begin);
    let high = max(select(min(end, whole.end), min(min(end, whole.end), seen), z > 0.0 && seen > low), low);
    slice.at = low + clamp(within, 0.0, 1.0) * (high - low);
    slice.low = low;
    slice.high = high;
    let beside = sight_through(view, at + vec2f(haze.tile, 0.0));
    let point = sight.origin + sight.direction * slice.at;
    slice.width = 0.5 * distance(point, beside.origin + beside.direction * slice.at);
    return slice;
}

// Albedo times phase function for light from one direction, in the mean over the media.
fn response(slice: Slice, to_light: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < MEDIA; i++) {
        sum += depth_of_medium(slice, i) * media[i].albedo * phase(media[i].anisotropy, dot(to_light, slice.direction));
    }
    return sum / max(slice.depth, 1e-30);
}

#ifdef LIT
// Where in a slice a light is looked up: where half of its 1/r² lies before and half behind (equiangular sampling), since beams
// are narrow near their light; of lights far off, where the medium's light is.
struct Lookup {
    distance: f32,         // along the line of sight [m]
    share: f32,            // mean of 1/r² in the slice over that there
}

fn lookup_of(slice: Slice, light: Light) -> Lookup {
    let begin = slice.low;
    let end = max(slice.high, begin + 1e-3 * slice.half_length);
    var e = equiangular(slice.origin, slice.direction, Span(begin, end), light.position);
    let across = e.across;
    // A light is no nearer to a column than half of its width.
    e.across = max(across, slice.width);
    e.low = atan((begin - e.foot) / e.across);
    e.high = atan((end - e.foot) / e.across);
    let at = clamp(equiangular_distance(e, slice.quantile), begin, end);
    let squared = across * across + (at - e.foot) * (at - e.foot);
    let mean = (e.high - e.low) / max((end - begin) * e.across, 1e-30);
    // Of a light that is far off for the length of the slice the difference of the angles is nothing but rounding.
    let is_seen_through = slice.depth < 2.0;
    let is_near = is_seen_through && !is_distant(light) && max(end - begin, slice.width) > 0.1 * sqrt(squared);
    return Lookup(select(slice.at, at, is_near), select(1.0, mean * squared, is_near));
}

fn from_lights(slice: Slice, thread: u32) -> vec3f {
    var sum = vec3f(0.0);
    // Also where there is no medium: a branch around it all makes Mesa's software driver (22.3) crash.
    for (var i = 0u; i < lamp_count(thread); i++) {
        let at = lookup_of(slice, lamps[i]);
        let step = (slice.high - slice.low) / f32(POINTS);
        let first = slice.origin + slice.direction * (slice.low + slice.quantile * step);
        let light = arriving_between(i, slice.origin + slice.direction * at.distance, first, slice.direction * step);
        sum += response(slice, light.to_light) * light.irradiance * at.share;
    }
    return min(sum, vec3f(MAX_RADIANCE));
}
#endif

#ifdef SWEPT
fn from_further_bounces(slice: Slice) -> vec3f {
    let around = fluence_at(swept, slice.origin + slice.direction * slice.at);
    let d = slice.direction;
    let along = around.flux[0] * d.x + around.flux[1] * d.y + around.flux[2] * d.z;
    var sum = vec3f(0.0);
    for (var i = 0u; i < MEDIA; i++) {
        let g = media[i].anisotropy;
        // Light travels against the line of sight.
        let radiance = max(around.mean - along * (3.0 * g / (2.0 * TAU)), vec3f(0.0));
        sum += depth_of_medium(slice, i) * media[i].albedo * radiance;
    }
    return min(sum / max(slice.depth, 1e-30), vec3f(MAX_RADIANCE));
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    let columns = haze.columns.x * haze.columns.y;
    if index >= columns * SLICES {
        return;
    }
    let number = index / SLICES;
    let column = vec2u(number % haze.columns.x, number / haze.columns.x);
    let to = haze_index(haze, column, index % SLICES);
    let slice = slice_at(column, index % SLICES);
    var light = vec3f(0.0);
#ifdef LIT
    light += from_lights(slice, index);
#endif
#ifdef SWEPT
    light += from_further_bounces(slice);
#endif
#ifdef MORE
    light += scattered[to].rgb;
#endif
    scattered[to] = vec4f(light, slice.depth);
}
