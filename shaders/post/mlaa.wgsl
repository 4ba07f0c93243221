// Morphological anti-aliasing (Reshetov 2009, "Morphological antialiasing"). The outline behind a run of edges is a line
// from half a pixel aside at each end that the outline turns at, to the edge itself in the middle of the run. What of a
// pixel lies beyond that line takes the colour of the neighbour across the edge. Areas are computed as in Jimenez et al.
// 2011 ("Practical morphological anti-aliasing"), but in closed form instead of from a texture.
//   BY_DEPTH, BY_NORMAL   what tells edges; neither: the colours

#ifdef BY_NORMAL
#import lightwell::gbuffer::decode_normal
#endif

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var edges_out: texture_storage_2d<r32uint, write>;
@group(0) @binding(2) var edges: texture_2d<u32>;
@group(0) @binding(3) var weights_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var weights: texture_2d<f32>;
@group(0) @binding(5) var display: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(6) var depth: texture_depth_2d;
@group(0) @binding(7) var normal: texture_2d<u32>;

// Least difference of a channel, as displayed, that makes an edge.
const THRESHOLD: f32 = 0.1;
// Least step of the distance, as a part of it, that makes an edge.
const DEPTH_STEP: f32 = 0.01;
// Cosine of the least angle between normals that makes an edge: 20°.
const NORMAL_COSINE: f32 = 0.94;
// How far a run is followed each way [pixels].
const REACH: i32 = 32;

const TOP: u32 = 1u;
const LEFT: u32 = 2u;

#ifdef BY_DEPTH

fn depth_at(at: vec2i) -> f32 {
    return textureLoad(depth, clamp(at, vec2i(0), vec2i(textureDimensions(depth)) - 1), 0);
}

// Reversed depth is linear in the image over a plane, and nearly one over the distance: what two pixels differ by beyond
// the slope of either side, as a part of the nearer, is the step between two surfaces.
fn is_edge(at: vec2i, to: vec2i) -> bool {
    let here = depth_at(at);
    let there = depth_at(at + to);
    let slopes = vec2f(here - depth_at(at - to), depth_at(at + 2 * to) - there);
    let step = abs(there - here - slopes);
    return min(step.x, step.y) > DEPTH_STEP * max(here, there);
}

#else ifdef BY_NORMAL

fn is_edge(at: vec2i, to: vec2i) -> bool {
    let is_there = vec2<bool>(textureLoad(depth, at, 0) > 0.0, textureLoad(depth, at + to, 0) > 0.0);
    if !all(is_there) {
        return any(is_there);
    }
    let cosine = dot(decode_normal(textureLoad(normal, at, 0)), decode_normal(textureLoad(normal, at + to, 0)));
    return cosine < NORMAL_COSINE;
}

#else

fn is_edge(at: vec2i, to: vec2i) -> bool {
    let d = abs(textureLoad(image, at, 0).rgb - textureLoad(image, at + to, 0).rgb);
    return max(d.r, max(d.g, d.b)) >= THRESHOLD;
}

#endif

// Which of a pixel's edges, to the pixel above and to the left, are edges of the image.
@compute @workgroup_size(8, 8)
fn edges_main(@builtin(global_invocation_id) thread: vec3u) {
    let at = vec2i(thread.xy);
    if any(thread.xy >= textureDimensions(edges_out)) {
        return;
    }
    var found = 0u;
    if at.y > 0 && is_edge(at, vec2i(0, -1)) {
        found |= TOP;
    }
    if at.x > 0 && is_edge(at, vec2i(-1, 0)) {
        found |= LEFT;
    }
    textureStore(edges_out, at, vec4u(found, 0u, 0u, 0u));
}

fn has(at: vec2i, edge: u32) -> bool {
    if any(at < vec2i(0)) || any(at >= vec2i(textureDimensions(edges))) {
        return false;
    }
    return (textureLoad(edges, at, 0).r & edge) != 0u;
}

// Whether the outline turns at an edge that leads away from a run. One that goes on for three pixels and more is the side
// of a corner, which stays sharp (Jimenez et al. 2012, "SMAA").
fn turns(at: vec2i, away: vec2i, edge: u32) -> bool {
    return has(at, edge) && !(has(at + away, edge) && has(at + 2 * away, edge));
}

// Height of the outline at an end of a run, towards the pixels before it (above, left): there or behind it turns an edge.
fn height_at_end(before: bool, behind: bool) -> f32 {
    return 0.5 * (select(0.0, 1.0, before) - select(0.0, 1.0, behind));
}

// Area between x0 and x1 below a line that falls from h at 0 to nothing at `length`.
fn area(h: f32, length: f32, x0: f32, x1: f32) -> f32 {
    let a = clamp(x0, 0.0, length);
    let b = clamp(x1, 0.0, length);
    return h * ((b - a) - 0.5 * (b * b - a * a) / length);
}

// Of one edge of a pixel: the part of the pixel before it that takes this pixel's colour, and the part of this pixel that
// takes the other's. `along` is the run's direction, `across` leads to the pixel before.
fn blend_of(at: vec2i, along: vec2i, across: vec2i, edge: u32, turn: u32) -> vec2f {
    var first = 0;
    while first < REACH && has(at - along * (first + 1), edge) {
        first += 1;
    }
    var last = 0;
    while last < REACH && has(at + along * (last + 1), edge) {
        last += 1;
    }
    let start = at - along * first;
    let end = at + along * (last + 1);
    // A run that is longer than the search has no end within reach.
    let low = select(height_at_end(turns(start + across, across, turn), turns(start, -across, turn)), 0.0, first == REACH);
    let high = select(height_at_end(turns(end + across, across, turn), turns(end, -across, turn)), 0.0, last == REACH);
    let length = f32(first + last + 1);
    let x = f32(first);
    let half = 0.5 * length;
    let from_low = area(low, half, x, x + 1.0);
    let from_high = area(high, half, length - x - 1.0, length - x);
    return vec2f(max(from_low, 0.0) + max(from_high, 0.0), max(-from_low, 0.0) + max(-from_high, 0.0));
}

@compute @workgroup_size(8, 8)
fn weights_main(@builtin(global_invocation_id) thread: vec3u) {
    let at = vec2i(thread.xy);
    if any(thread.xy >= textureDimensions(edges)) {
        return;
    }
    var result = vec4f(0.0);
    if has(at, TOP) {
        result = vec4f(blend_of(at, vec2i(1, 0), vec2i(0, -1), TOP, LEFT), result.zw);
    }
    if has(at, LEFT) {
        result = vec4f(result.xy, blend_of(at, vec2i(0, 1), vec2i(-1, 0), LEFT, TOP));
    }
    textureStore(weights_out, at, result);
}

fn weight_at(at: vec2i) -> vec4f {
    if any(at >= vec2i(textureDimensions(weights))) {
        return vec4f(0.0);
    }
    return textureLoad(weights, at, 0);
}

// IEC 61966-2-1.
fn decode_srgb(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn encode_srgb(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn light(at: vec2i) -> vec3f {
    return decode_srgb(textureLoad(image, at, 0).rgb);
}

@compute @workgroup_size(8, 8)
fn blend_main(@builtin(global_invocation_id) thread: vec3u) {
    let at = vec2i(thread.xy);
    if any(thread.xy >= textureDimensions(image)) {
        return;
    }
    let own = weight_at(at);
    let up = own.y;
    let left = own.w;
    let down = weight_at(at + vec2i(0, 1)).x;
    let right = weight_at(at + vec2i(1, 0)).z;
    let sum = up + left + down + right;
    var shown = textureLoad(image, at, 0).rgb;
    if sum > 0.0 {
        var mixed = light(at) * max(0.0, 1.0 - sum);
        if up > 0.0 { mixed += up * light(at - vec2i(0, 1)); }
        if left > 0.0 { mixed += left * light(at - vec2i(1, 0)); }
        if down > 0.0 { mixed += down * light(at + vec2i(0, 1)); }
        if right > 0.0 { mixed += right * light(at + vec2i(1, 0)); }
        shown = encode_srgb(saturate(mixed / max(1.0, sum)));
    }
    textureStore(display, at, vec4f(shown, 1.0));
}
