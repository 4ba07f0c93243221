// Temporal anti-aliasing: each pixel takes what was remembered where its point was in the frame before, with a little of this
// frame, whose pixel grid is shifted (Karis 2014, "High-quality temporal supersampling"). While anything moves, what is
// remembered is clipped to the range of what is seen around the pixel: its mean and deviation (Salvi 2016, "An excursion in
// temporal supersampling"). What rests is the plain mean of its frames.
//
// What moves is averaged as it is seen, compressed by x/(1 + luminance): the edge of what is bright is smooth then with few
// frames. What rests is averaged as light.
//   MOVED    there are objects that are elsewhere than in the frame before

#import lightwell::color::luminance
#import lightwell::gbuffer::{decode_radiance, encode_radiance, world_position}
#ifdef MOVED
#import lightwell::motion::place_before
#endif
#import lightwell::view::View

struct Smooth {
    view: View,
    // Clip from world space without the shift, now and in the frame before.
    unshifted: mat4x4f,
    unshifted_before: mat4x4f,
    most: f32,             // frames before that count at most
    exposure: f32,         // factor of the display
    is_known: u32,         // the frame before is there
    is_still: u32,         // the camera is where it was
    is_bounded: u32,       // something may have changed
}

@group(0) @binding(0) var<uniform> smooth_edges: Smooth;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var object: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
// Radiance with shared exponent [W/(m² sr)], and the bits of the number of frames in it.
@group(0) @binding(4) var color_before: texture_2d<u32>;
@group(0) @binding(5) var color_now: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(6) var smoothed: texture_storage_2d<rgba32float, write>;

// How far from the mean of what is around it a remembered colour may be [standard deviations].
const REACH: f32 = 1.0;

struct Past {
    color: vec3f,          // compressed, unless all rests
    frames: f32,
}

// To 0..1 and back; what is out of range for a display stays a little below 1.
fn compressed(radiance: vec3f) -> vec3f {
    let exposed = min(radiance * smooth_edges.exposure, vec3f(1e6));
    return select(radiance, exposed / (1.0 + luminance(exposed)), smooth_edges.is_bounded != 0u);
}

fn expanded(color: vec3f) -> vec3f {
    let room = max(1.0 - luminance(color), 1e-7);
    return select(color, color / (room * smooth_edges.exposure), smooth_edges.is_bounded != 0u);
}

fn color_at(pixel: vec2i) -> vec3f {
    let at = clamp(pixel, vec2i(0), vec2i(smooth_edges.view.size) - 1);
    return compressed(textureLoad(radiance, at, 0).rgb);
}

fn remembered(pixel: vec2i) -> Past {
    let texel = textureLoad(color_before, clamp(pixel, vec2i(0), vec2i(smooth_edges.view.size) - 1), 0);
    return Past(compressed(decode_radiance(texel.xy)), bitcast<f32>(texel.z));
}

// The nearest of the pixels around: edges move with what is in front.
fn nearest(pixel: vec2i) -> vec2i {
    var best = pixel;
    var best_z = textureLoad(depth, pixel, 0);
    for (var i = 0; i < 9; i++) {
        let at = clamp(pixel + vec2i(i % 3 - 1, i / 3 - 1), vec2i(0), vec2i(smooth_edges.view.size) - 1);
        let z = textureLoad(depth, at, 0);
        if z > best_z {
            best_z = z;
            best = at;
        }
    }
    return best;
}

// Where a pixel was in the frame before, less where it is [pixels].
fn motion(pixel: vec2i) -> vec2f {
    let size = vec2f(smooth_edges.view.size);
    let z = textureLoad(depth, pixel, 0);
    let uv = (vec2f(pixel) + 0.5) / size;
    // In homogeneous coordinates, since the sky is infinitely far.
    var now = smooth_edges.view.world_from_clip * vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, z, 1.0);
    var before = now;
#ifdef MOVED
    if z > 0.0 {
        let place = place_before(textureLoad(object, pixel, 0).x, now.xyz / now.w, vec3f(0.0, 1.0, 0.0));
        before = select(now, vec4f(place.position, 1.0), place.is_moved);
    }
#endif
    let here = smooth_edges.unshifted * now;
    let there = smooth_edges.unshifted_before * before;
    if here.w <= 0.0 || there.w <= 0.0 {
        return size;
    }
    return (there.xy / there.w - here.xy / here.w) * vec2f(0.5, -0.5) * size;
}

// Weights of four pixels in a row for a point between the middle two: Catmull and Rom's spline, which keeps edges sharp.
fn spline(t: f32) -> vec4f {
    let u = t * t;
    let v = u * t;
    return vec4f(-0.5 * v + u - 0.5 * t, 1.5 * v - 2.5 * u + 1.0, -1.5 * v + 2.0 * u + 0.5 * t, 0.5 * v - 0.5 * u);
}

fn resampled(at: vec2f) -> Past {
    let low = floor(at);
    let x = spline(at.x - low.x);
    let y = spline(at.y - low.y);
    var sum = vec3f(0.0);
    var frames = 1e9;
    for (var j = 0; j < 4; j++) {
        for (var i = 0; i < 4; i++) {
            let found = remembered(vec2i(low) + vec2i(i - 1, j - 1));
            sum += x[i] * y[j] * found.color;
            let is_near = (i == 1 || i == 2) && (j == 1 || j == 2);
            frames = select(frames, min(frames, found.frames), is_near);
        }
    }
    return Past(max(sum, vec3f(0.0)), frames);
}

fn history(pixel: vec2i) -> Past {
    let way = motion(nearest(pixel));
    if smooth_edges.is_still != 0u && all(abs(way) < vec2f(1e-3)) {
        return remembered(pixel);
    }
    let at = vec2f(pixel) + way;
    if any(at < vec2f(-0.5)) || any(at > vec2f(smooth_edges.view.size) - 0.5) {
        return Past(vec3f(0.0), 0.0);
    }
    return resampled(at);
}

// A remembered colour in the range of what is seen around a pixel now.
fn bounded(color: vec3f, pixel: vec2i) -> vec3f {
    var sum = vec3f(0.0);
    var squares = vec3f(0.0);
    for (var i = 0; i < 9; i++) {
        let c = color_at(pixel + vec2i(i % 3 - 1, i / 3 - 1));
        sum += c;
        squares += c * c;
    }
    let mean = sum / 9.0;
    let deviation = REACH * sqrt(max(squares / 9.0 - mean * mean, vec3f(0.0))) + 1e-4;
    // Towards the mean, as far as the box reaches.
    let off = color - mean;
    let over = abs(off) / deviation;
    return mean + off / max(1.0, max(over.x, max(over.y, over.z)));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= smooth_edges.view.size) {
        return;
    }
    let pixel = vec2i(thread.xy);
    let color = color_at(pixel);
    var past = Past(vec3f(0.0), 0.0);
    if smooth_edges.is_known != 0u {
        past = history(pixel);
    }
    if smooth_edges.is_bounded != 0u {
        past.color = bounded(past.color, pixel);
    }
    let frames = min(past.frames, smooth_edges.most);
    let light = expanded(mix(past.color, color, 1.0 / (frames + 1.0)));
    textureStore(color_now, pixel, vec4u(encode_radiance(light), bitcast<u32>(frames + 1.0), 0u));
    textureStore(smoothed, pixel, vec4f(light, 1.0));
}
