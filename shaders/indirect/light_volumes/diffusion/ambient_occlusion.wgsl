// Screen-space ambient occlusion for the local detail that the volumes lack (Šefčík 2016, section 8.2), by horizons in the
// depth image (Jimenez et al. 2016, "Practical realtime strategies for accurate indirect occlusion", GTAO).
//
// A slice is a plane through the line of sight. In it the horizon is searched on either side, and what lies between the two
// horizons is integrated with the cosine in closed form. A pixel has one slice, and 4×4 pixels have 16. Their sum is divided
// by that of the same slices without any horizon: an open plane has exactly 1.

#import lightwell::gbuffer::{decode_normal, world_position}
#import lightwell::sampling::basis
#import lightwell::view::{View, position_error, toward_eye}

struct Occlusion {
    origin: vec2u,         // of the region [pixels]
    size: vec2u,           // of the region [pixels]
    radius: f32,           // within which surfaces occlude [m]
    padding: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> occlusion: Occlusion;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var noisy: texture_2d<f32>;
@group(0) @binding(5) var integrals: texture_storage_2d<rg32float, write>;
@group(0) @binding(6) var visibility: texture_storage_2d<r32float, write>;

const PI: f32 = 3.14159265;
// Steps on either side, and halvings of the one in which the highest occluder ends.
const STEPS: u32 = 16u;
const HALVINGS: u32 = 3u;
// Part of the radius from which on occluders fade.
const FADE: f32 = 0.4;
// Depth does not tell how thick an occluder is: distances along the line of sight count by so much more for the fade, so that
// what stands before a surface hides less of it than what stands beside it (XeGTAO's compensation of thin occluders).
const THIN: f32 = 0.5;

fn load_depth(pixel: vec2u) -> f32 {
    return textureLoad(depth, pixel, 0);
}

// A plane through the line of sight.
struct Slice {
    step: vec2f,           // one pixel along it on the screen
    pixels: f32,           // that the radius covers
    tangent: vec3f,        // unit, along the slice and the surface
    slope: f32,            // length of the normal's projection into the slice
}

struct Receiver {
    pixel: vec2u,
    point: vec3f,
    n: vec3f,
    sight: vec3f,          // unit, towards the eye
    error: f32,            // of points on the surface [m]
}

// How high a sample stands over the tangent plane, in the slice [rad]. Samples lie at the centres of pixels beside the slice;
// measured from the tangent plane, those on a plane stand at exactly 0 all the same.
fn elevation(receiver: Receiver, slice: Slice, side: f32, offset: vec3f) -> f32 {
    let height = dot(offset, receiver.n) - 2.0 * receiver.error;
    let reach = length(offset) * slice.slope;
    if !(height > 0.0) || !(reach > 0.0) {
        return 0.0;
    }
    let angle = asin(min(height / reach, 1.0));
    let leans_over = dot(offset, slice.tangent) * side < 0.0 && height > 0.5 * reach;
    return select(angle, PI - angle, leans_over);
}

// How high what is seen so many pixels along the slice stands over the tangent plane, as far as it counts [rad].
fn occluder(receiver: Receiver, slice: Slice, side: f32, pixels: f32) -> f32 {
    let at = floor(vec2f(receiver.pixel) + 0.5 + side * pixels * slice.step);
    if any(at < vec2f(0.0)) || any(at >= vec2f(view.size)) {
        return 0.0;
    }
    let z = load_depth(vec2u(at));
    if z <= 0.0 {
        return 0.0;
    }
    let offset = world_position(vec2u(at), view.size, z, view.world_from_clip) - receiver.point;
    let stretched = offset + THIN * dot(offset, receiver.sight) * receiver.sight;
    let kept = saturate((1.0 - length(stretched) / occlusion.radius) / (1.0 - FADE));
    return kept * elevation(receiver, slice, side, offset);
}

// Steps become longer with the distance.
fn step_at(slice: Slice, i: f32) -> f32 {
    let t = i / f32(STEPS);
    return 1.0 + t * t * max(slice.pixels - 1.0, 0.0);
}

// The horizon over the tangent plane on one side of a slice [rad].
fn horizon(receiver: Receiver, slice: Slice, side: f32, start: f32) -> f32 {
    var highest = 0.0;
    var near = 0.0;
    for (var i = 0u; i < STEPS; i++) {
        let at = f32(i) + start;
        let found = occluder(receiver, slice, side, step_at(slice, at));
        near = select(near, at, found > highest);
        highest = max(highest, found);
    }
    if highest <= 0.0 {
        return 0.0;
    }
    var far = near + 1.0;
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = 0.5 * (near + far);
        let found = occluder(receiver, slice, side, step_at(slice, middle));
        near = select(near, middle, found > highest);
        far = select(middle, far, found > highest);
        highest = max(highest, found);
    }
    return highest;
}

// ∫ of the cosine with the normal at `gamma` from the line of sight to the angle h, over both.
fn arc(h: f32, gamma: f32) -> f32 {
    return 0.25 * (cos(gamma) + 2.0 * h * sin(gamma) - cos(2.0 * h - gamma));
}

// Directions and starts of 4×4 pixels, all different (Jimenez et al. 2016).
fn pattern(pixel: vec2u) -> vec2f {
    let p = pixel & vec2u(3u);
    let direction = f32((((p.x + p.y) & 3u) << 2u) + p.x) / 16.0;
    let start = f32((p.y - p.x) & 3u) / 4.0;
    return vec2f(direction, start);
}

// ∫ of the cosine in the pixel's slice, over what nothing nearby hides and over all.
fn integrate(receiver: Receiver) -> vec2f {
    let sight = receiver.sight;
    let frame = basis(sight);
    let noise = pattern(receiver.pixel);
    let angle = noise.x * PI;
    let along = cos(angle) * frame[0] + sin(angle) * frame[1];
    let across = cross(sight, along);
    let projected = receiver.n - dot(receiver.n, across) * across;
    let slope = length(projected);
    // Pixels a metre: the slice's plane is a line on the screen.
    let clip = view.clip_from_world * vec4f(receiver.point, 1.0);
    let moved = view.clip_from_world * vec4f(along, 0.0);
    let speed = (moved.xy - clip.xy / clip.w * moved.w) / clip.w * vec2f(0.5, -0.5) * vec2f(view.size);
    let pace = length(speed);
    if !(slope > 1e-4) || !(pace > 0.0) {
        return vec2f(0.0);
    }
    // No farther than across the image.
    let pixels = min(pace * occlusion.radius, f32(view.size.x + view.size.y));
    let slice = Slice(speed / pace, pixels, normalize(cross(across, projected)), slope);
    let tilt = acos(saturate(dot(projected, sight) / slope));
    let gamma = select(tilt, -tilt, dot(projected, along) < 0.0);
    let ahead = gamma + 0.5 * PI;
    let behind = gamma - 0.5 * PI;
    let open = arc(max(ahead - horizon(receiver, slice, 1.0, noise.y), 0.0), gamma)
        + arc(min(behind + horizon(receiver, slice, -1.0, noise.y), 0.0), gamma);
    return slope * vec2f(open, arc(ahead, gamma) + arc(behind, gamma));
}

fn pixel_of(thread: vec2u) -> vec2u {
    return occlusion.origin + thread;
}

@compute @workgroup_size(8, 8)
fn occlude(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= occlusion.size) {
        return;
    }
    let pixel = pixel_of(thread.xy);
    let z = load_depth(pixel);
    var found = vec2f(0.0);
    if z > 0.0 {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let n = decode_normal(textureLoad(normal, pixel, 0));
        let sight = normalize(toward_eye(view, point));
        found = integrate(Receiver(pixel, point, n, sight, position_error(view, point)));
    }
    textureStore(integrals, pixel, vec4f(found, 0.0, 0.0));
}

// Share of the light that arrives, from the slices of 4×4 pixels as far as they lie near the tangent plane.
@compute @workgroup_size(8, 8)
fn denoise(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= occlusion.size) {
        return;
    }
    let pixel = pixel_of(thread.xy);
    let z = load_depth(pixel);
    var open = 1.0;
    if z > 0.0 {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let n = decode_normal(textureLoad(normal, pixel, 0));
        var sum = vec2f(0.0);
        let low = max(vec2i(pixel) - 1, vec2i(occlusion.origin));
        let high = min(vec2i(pixel) + 2, vec2i(occlusion.origin + occlusion.size) - 1);
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                let at = vec2u(vec2i(x, y));
                sum += nearness(at, pixel, point, n) * textureLoad(noisy, at, 0).rg;
            }
        }
        open = select(1.0, saturate(sum.x / sum.y), sum.y > 0.0);
    }
    textureStore(visibility, pixel, vec4f(open));
}

// 1 on the tangent plane, 0 from an angle of 15° to it on.
fn nearness(at: vec2u, pixel: vec2u, point: vec3f, n: vec3f) -> f32 {
    let z = load_depth(at);
    if all(at == pixel) {
        return 1.0;
    }
    if z <= 0.0 {
        return 0.0;
    }
    let offset = world_position(at, view.size, z, view.world_from_clip) - point;
    let off_plane = max(abs(dot(offset, n)) - 2.0 * position_error(view, point), 0.0);
    return saturate(1.0 - 4.0 * off_plane / max(length(offset), 1e-30));
}
