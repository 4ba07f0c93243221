// A filter over what mirrors show, narrower than their specular lobes blur it: the noise of few rays becomes less, and the image
// hardly less sharp. See lib/lobe_filter.wgsl.
//
// Of few rays a single one may meet something small and bright. What a pixel shows above all that is around it is therefore
// parted from the rest, and goes as far as its lobe reaches: no light is lost, and none stays a dot.
//   part    what is above its surroundings, and the rest, both over the tint of the lobe, so that textures stay sharp
//   filter  both of them, each with its own width, once more with other pixels
//   LAST    the sum of both is made
//   STRETCHED  the surfaces are second lobes, whose reflections are told over their tint
//   THROUGH_GLASS  what is seen through rough glass, see transparency/glass.wgsl, in place of mirrors

#import lightwell::color::luminance
#ifdef THROUGH_GLASS
#import lightwell::gbuffer::{decode_normal, world_position}
#import lightwell::rough_glass::{RoughGlass, decode_rough_glass, passing_direction, passing_width}
#else
#import lightwell::environment::lobe_reflectance
#import lightwell::gbuffer::{decode_normal, decode_normal_reflectance, world_position}
#endif
#import lightwell::lobe_filter::{Footprint, Lobe, across_of, footprint_of, longest, offset_in, tap_at, weight_of}
#import lightwell::sampling::{hash, unit_float}
#import lightwell::view::{View, toward_eye}

struct MirrorFilter {
    view: View,
    origin: vec2u,         // first pixel
    size: vec2u,           // [pixels]
    width: f32,            // of the filter over that of the lobe
    stray_width: f32,      // the same for what is above its surroundings
    turn: u32,             // of the pattern of pixels
}

@group(0) @binding(0) var<uniform> mirror_filter: MirrorFilter;
#ifdef THROUGH_GLASS
@group(0) @binding(8) var rough_glass: texture_2d<u32>;
// What lights make of the glass, which is added as it is [W/(m² sr)].
@group(0) @binding(9) var glow_at_glass: texture_2d<f32>;
#else
@group(0) @binding(1) var normal: texture_2d<u32>;
@group(0) @binding(2) var object: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
#endif
// Radiance [W/(m² sr)], and how far off is what is shown [m]; 0: the pixel mirrors nothing. Through glass, how far off that is.
@group(0) @binding(4) var mirrored: texture_2d<f32>;
@group(0) @binding(5) var filtered: texture_storage_2d<rgba32float, write>;
// What is above its surroundings, and how far off is what the pixels around show [m].
@group(0) @binding(6) var strays: texture_2d<f32>;
@group(0) @binding(7) var strays_out: texture_storage_2d<rgba32float, write>;

#ifdef THROUGH_GLASS
const IS_MIRROR: bool = false;
#else
const IS_MIRROR: bool = true;
#endif
const TAPS: u32 = 16u;
// Farthest that the filter reaches [pixels].
const MOST: f32 = 12.0;
// Shortest reach that meets other pixels [pixels].
const LEAST: f32 = 0.75;
// Pixels to each side that make up the surroundings of one.
const AROUND: i32 = 2;
// How many times as bright as its surroundings a pixel may be. They count by the square of the mean root: a few strays among
// them say little.
const STRAY: f32 = 4.0;
// Least tint: black reflects nothing, which needs no tint.
const LEAST_TINT: f32 = 1e-4;

fn is_inside(pixel: vec2i) -> bool {
    let from_first = pixel - vec2i(mirror_filter.origin);
    return all(from_first >= vec2i(0)) && all(from_first < vec2i(mirror_filter.size));
}

// A surface that shows an image.
struct Shown {
    position: vec3f,       // [m]
    normal: vec3f,
    to_eye: vec3f,
    direction: vec3f,      // in which most of its light is seen
    alpha: f32,            // width of its lobe [rad]
}

#ifdef THROUGH_GLASS
// Of what makes one image, 0 where there is none.
fn id_at(pixel: vec2i) -> u32 {
    return textureLoad(rough_glass, pixel, 0).z;
}

fn shown_distance(pixel: vec2i, found: vec4f) -> f32 {
    return bitcast<f32>(textureLoad(rough_glass, pixel, 0).w);
}

fn tint_at(pixel: vec2i) -> vec3f {
    return vec3f(1.0);
}

fn shown_at(pixel: vec2i) -> Shown {
    let size = mirror_filter.view.size;
    let glass = decode_rough_glass(textureLoad(rough_glass, pixel, 0));
    let start = world_position(vec2u(pixel), size, 1.0, mirror_filter.view.world_from_clip);
    let to_eye = normalize(toward_eye(mirror_filter.view, world_position(vec2u(pixel), size, 0.5, mirror_filter.view.world_from_clip)));
    let position = start - to_eye * textureLoad(mirrored, pixel, 0).a;
    return Shown(position, glass.normal, to_eye, passing_direction(glass, to_eye), passing_width(glass));
}
#else
fn id_at(pixel: vec2i) -> u32 {
    return select(0u, textureLoad(object, pixel, 0).x, textureLoad(mirrored, pixel, 0).a > 0.0);
}

fn shown_distance(pixel: vec2i, found: vec4f) -> f32 {
    return found.a;
}

fn shown_at(pixel: vec2i) -> Shown {
    let size = mirror_filter.view.size;
    let position = world_position(vec2u(pixel), size, textureLoad(depth, pixel, 0), mirror_filter.view.world_from_clip);
    let texel = textureLoad(normal, pixel, 0);
    let n = decode_normal(texel);
    let to_eye = normalize(toward_eye(mirror_filter.view, position));
    let roughness = f32(texel.z) / 65535.0;
    return Shown(position, n, to_eye, reflect(-to_eye, n), roughness * roughness);
}

// Share of even light that is reflected.
fn tint_at(pixel: vec2i) -> vec3f {
#ifdef STRETCHED
    return vec3f(1.0);
#else
    let texel = textureLoad(normal, pixel, 0);
    let f = decode_normal_reflectance(textureLoad(object, pixel, 0).xy);
    let shown = shown_at(pixel);
    let roughness = vec2f(texel.zw) / 65535.0;
    return max(lobe_reflectance(f, roughness.y, roughness.x, dot(shown.normal, shown.to_eye)), vec3f(LEAST_TINT));
#endif
}
#endif

fn is_same(pixel: vec2i, id: u32) -> bool {
    return is_inside(pixel) && id_at(pixel) == id;
}

// What the pixels around show.
struct Surroundings {
    brightness: f32,       // luminance
    distance: f32,         // harmonic mean, of the nearest [m]
}

fn surroundings_of(pixel: vec2i, id: u32) -> Surroundings {
    var roots = 0.0;
    var count = 0.0;
    var nearness = 0.0;
    var near_count = 0.0;
    for (var y = -AROUND; y <= AROUND; y++) {
        for (var x = -AROUND; x <= AROUND; x++) {
            let at = pixel + vec2i(x, y);
            if !is_same(at, id) {
                continue;
            }
            let found = textureLoad(mirrored, at, 0);
            let is_beside = max(abs(x), abs(y)) <= 1;
            nearness += select(0.0, 1.0 / max(shown_distance(at, found), 1e-6), is_beside);
            near_count += select(0.0, 1.0, is_beside);
            if x != 0 || y != 0 {
                roots += sqrt(luminance(found.rgb));
                count += 1.0;
            }
        }
    }
    let root = roots / max(count, 1.0);
    // A pixel by itself has nowhere to spread to.
    return Surroundings(select(1e30, root * root, count > 0.0), near_count / max(nearness, 1e-30));
}

@compute @workgroup_size(8, 8)
fn part(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2i(mirror_filter.origin + thread.xy);
    if !is_inside(pixel) {
        return;
    }
    let own = textureLoad(mirrored, pixel, 0);
    var rest = own;
    var stray = vec4f(0.0);
    let id = id_at(pixel);
    if id != 0u {
        let around = surroundings_of(pixel, id);
        let tint = tint_at(pixel);
        let kept = min(1.0, STRAY * around.brightness / max(luminance(own.rgb), 1e-30));
        rest = vec4f(kept * own.rgb / tint, own.a);
        stray = vec4f((1.0 - kept) * own.rgb / tint, around.distance);
    }
    textureStore(filtered, pixel, rest);
    textureStore(strays_out, pixel, stray);
}

fn lobe_of(shown: Shown, distance: f32) -> Lobe {
    let narrowing = clamp(dot(shown.normal, shown.to_eye), 0.1, 1.0);
    let across = across_of(shown.normal, shown.to_eye);
    return Lobe(shown.position, shown.direction, across, narrowing, max(shown.alpha, 1e-4), distance);
}

fn offset_of(lobe: Lobe, pixel: vec2i) -> vec2f {
    let shown = shown_at(pixel);
    return offset_in(lobe, shown.position, shown.direction);
}

// Offset per pixel along an axis, from the pixel beside that is of the same mirror.
fn step_along(lobe: Lobe, pixel: vec2i, axis: vec2i, id: u32) -> vec2f {
    if is_same(pixel + axis, id) {
        return offset_of(lobe, pixel + axis);
    }
    if is_same(pixel - axis, id) {
        return -offset_of(lobe, pixel - axis);
    }
    return vec2f(1e6);
}

// The mean over a footprint: of the rest, or of strays.
fn mean_over(lobe: Lobe, footprint: Footprint, pixel: vec2i, id: u32, width: f32, are_strays: bool) -> vec3f {
    var sum = textureLoad(mirrored, pixel, 0).rgb;
    if are_strays {
        sum = textureLoad(strays, pixel, 0).rgb;
    }
    if longest(footprint) < LEAST {
        return sum;
    }
    let turn = unit_float(hash(u32(pixel.x) ^ hash(u32(pixel.y) ^ hash(mirror_filter.turn))));
    var weights = 1.0;
    for (var i = 0u; i < TAPS; i++) {
        let at = pixel + tap_at(footprint, i, TAPS, turn);
        if all(at == pixel) || !is_same(at, id) {
            continue;
        }
        let weight = weight_of(offset_of(lobe, at), width);
        var found = textureLoad(mirrored, at, 0).rgb;
        if are_strays {
            found = textureLoad(strays, at, 0).rgb;
        }
        sum += weight * found;
        weights += weight;
    }
    return sum / weights;
}

@compute @workgroup_size(8, 8)
fn filter_lobes(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = vec2i(mirror_filter.origin + thread.xy);
    if !is_inside(pixel) {
        return;
    }
    let own = textureLoad(mirrored, pixel, 0);
    var rest = own.rgb;
    var stray = textureLoad(strays, pixel, 0);
    let id = id_at(pixel);
    if id != 0u {
        let lobe = lobe_of(shown_at(pixel), stray.a);
        let right = step_along(lobe, pixel, vec2i(1, 0), id);
        let below = step_along(lobe, pixel, vec2i(0, 1), id);
        let narrow = mirror_filter.width;
        let wide = mirror_filter.stray_width;
        rest = mean_over(lobe, footprint_of(right, below, narrow, MOST), pixel, id, narrow, false);
        stray = vec4f(mean_over(lobe, footprint_of(right, below, wide, MOST), pixel, id, wide, true), stray.a);
#ifdef LAST
        rest = (rest + stray.rgb) * tint_at(pixel);
#endif
    }
#ifdef LAST
#ifdef THROUGH_GLASS
    rest += textureLoad(glow_at_glass, pixel, 0).rgb;
#endif
    textureStore(filtered, pixel, vec4f(rest, select(own.a, stray.a, id != 0u && IS_MIRROR)));
#else
    textureStore(filtered, pixel, vec4f(rest, own.a));
    textureStore(strays_out, pixel, stray);
#endif
}
