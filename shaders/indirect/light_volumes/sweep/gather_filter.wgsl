// Cross bilateral filter over what was gathered, along one axis at a time, and the reflected radiance from what it
// leaves. Diffuse light is filtered as if all surfaces were white, so that textures stay sharp, and the specular light of
// smooth surfaces less far, since it is an image.
//
// Irradiance changes over a distance d by about d/R of itself, with the harmonic mean R of the distances of all that a
// point sees (Ward, Rubinstein and Clear 1988), and mostly towards the side where the near surfaces are (Ward and Heckbert
// 1992, "Irradiance gradients"): weights fall off quickly with d/R to that side and slowly along, so that corners and
// contact shadows stay sharp without noise in them, and open walls are smooth. That takes all that a point sees for equally
// bright. Beside something that glows light changes over its distance instead, and what is filtered across its bright rim
// is wrong by the rim's brightness: there the mean of 1/t over the light bounds the filter as well.
//   UNLIT     nothing glows
//   TINTED    specular light is told over the tint of the lobe: what layers take from it changes from pixel to pixel

#import lightwell::bilateral::likeness
#import lightwell::color::luminance
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::interleave::{Interleave, pixel_of}
#import lightwell::inverse_distance::{NO_DIFFUSE, decode_inverse_distance, encode_inverse_distance, has_diffuse}
#ifndef UNLIT
#import lightwell::inverse_distance::decode_emitted
#endif
#ifdef TINTED
#import lightwell::layers::tint_seen
#import lightwell::view::toward_eye
#endif
#import lightwell::sampling::basis
#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> reach: Reach;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
// Alpha of both: how near and to which side is what the rays met, see lib/inverse_distance.wgsl.
@group(0) @binding(5) var diffuse: texture_2d<f32>;
@group(0) @binding(6) var specular: texture_2d<f32>;
@group(0) @binding(7) var diffuse_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var specular_out: texture_storage_2d<rgba32float, write>;
#ifdef TINTED
@group(0) @binding(12) var object: texture_2d<u32>;
#endif
@group(0) @binding(11) var indirect: texture_storage_2d<rgba32float, write>;

struct Reach {
    radius: f32,           // distance at which weights are zero [texels]
    weight: f32,           // how much the frame counts among others
    stray: f32,            // how many times as bright as all that is next to it light may be
    @align(16) interleave: Interleave,
}

// d/R at which a neighbour's weight has fallen to 1/e, towards near surfaces and along them; but within LEAST pixels all
// count, or corners would be noise.
const TOLERANCE: f32 = 0.15;
const TOLERANCE_ALONG: f32 = 0.8;
const LEAST: f32 = 2.0;
// The same over the distance of light from what glows, without a least.
const TOLERANCE_EMITTED: f32 = 0.3;

// `stray` of frames in which nothing is cut off.
const ANY: f32 = 1e6;

struct Filtered {
    diffuse: vec3f,
    specular: vec3f,
}

fn pixel_at(texel: vec2i) -> vec2u {
    return pixel_of(reach.interleave, vec2u(texel), view.size);
}

// How near and to which side is what the pixels around see: that of few rays is noise. See lib/inverse_distance.wgsl.
fn mean_nearness(texel: vec2u) -> vec3f {
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var i = 0; i < 25; i++) {
        let around = vec2i(texel) + 2 * vec2i(i % 5 - 2, i / 5 - 2);
        let at = clamp(around, vec2i(0), vec2i(reach.interleave.texels) - 1);
        let code = vec2f(textureLoad(diffuse, at, 0).a, textureLoad(specular, at, 0).a);
        if textureLoad(depth, pixel_at(at), 0) > 0.0 && has_diffuse(code) {
            sum += decode_inverse_distance(code);
            count += 1.0;
        }
    }
    return sum / max(count, 1.0);
}

#ifndef UNLIT
// How near what glows is, over all light that the filter can reach from a texel along the axis: what is bright counts, so
// that nothing bright is filtered into its surroundings.
fn emitted_along(center: vec2u, along: vec2i) -> f32 {
    var mean = 0.0;
    var light = 1e-30;
    let last = i32(ceil(reach.radius)) - 1;
    for (var d = -last; d <= last; d++) {
        let at = vec2i(center) + d * along;
        if any(at < vec2i(0)) || any(at >= vec2i(reach.interleave.texels)) {
            continue;
        }
        let found = textureLoad(diffuse, at, 0);
        let weight = luminance(found.rgb) * (1.0 - f32(abs(d)) / reach.radius);
        let near = decode_emitted(vec2f(found.a, textureLoad(specular, at, 0).a));
        // A running mean: the sum of weighted values could leave the range of floats.
        light += weight;
        mean += (near - mean) * (weight / light);
    }
    return mean;
}
#endif

fn filtered(center: vec2u, z: f32, along: vec2i, inverse_distance: vec3f) -> Filtered {
    let pixel = pixel_at(vec2i(center));
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let texel = textureLoad(normal, pixel, 0);
    let n = decode_normal(texel);
    let toward_near = (basis(n) * vec3f(inverse_distance.xy, 0.0)) / TOLERANCE;
    let roughness = f32(texel.z) / 65535.0;
    // Of the specular lobe: about its width over that of the diffuse one.
    let lobe = max(1.0, saturate(2.0 * roughness * roughness) * reach.radius);
    var sum = Filtered(textureLoad(diffuse, center, 0).rgb, textureLoad(specular, center, 0).rgb);
    let pixels = f32(reach.interleave.stride) / LEAST;
    let least = pixels * pixels;
    var weights = vec2f(1.0);
#ifndef UNLIT
    let emitted = emitted_along(center, along) / TOLERANCE_EMITTED;
#endif
    let last = i32(ceil(reach.radius)) - 1;
    for (var d = -last; d <= last; d++) {
        let at = vec2i(center) + d * along;
        if d == 0 || any(at < vec2i(0)) || any(at >= vec2i(reach.interleave.texels)) {
            continue;
        }
        let other = pixel_at(at);
        let other_z = textureLoad(depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let other_position = world_position(other, view.size, other_z, view.world_from_clip);
        let like = likeness(position, n, other_position, decode_normal(textureLoad(normal, other, 0)));
        let off = other_position - position;
        let across = dot(off, toward_near);
        let any_way = length(off) * (inverse_distance.z / TOLERANCE_ALONG);
        var spread = min(across * across + any_way * any_way, f32(d * d) * least);
#ifndef UNLIT
        spread += dot(off, off) * emitted * emitted;
#endif
        let near = exp(-spread);
        let weight = near * saturate(1.0 - f32(abs(d)) / vec2f(reach.radius, lobe)) * like;
        let found_diffuse = textureLoad(diffuse, at, 0);
        let found_specular = textureLoad(specular, at, 0);
        if has_diffuse(vec2f(found_diffuse.a, found_specular.a)) {
            sum.diffuse += weight.x * found_diffuse.rgb;
            sum.specular += weight.y * found_specular.rgb;
            weights += weight;
        }
    }
    return Filtered(sum.diffuse / weights.x, sum.specular / weights.y);
}

fn has_diffuse_at(texel: vec2u) -> bool {
    return has_diffuse(vec2f(textureLoad(diffuse, texel, 0).a, textureLoad(specular, texel, 0).a));
}

// How near what glows is to a texel alone.
fn emitted_at_texel(texel: vec2u) -> f32 {
#ifdef UNLIT
    return 0.0;
#else
    return decode_emitted(vec2f(textureLoad(diffuse, texel, 0).a, textureLoad(specular, texel, 0).a));
#endif
}

fn store_filtered(texel: vec2u, light: Filtered, inverse_distance: vec3f) {
    let known = encode_inverse_distance(inverse_distance, emitted_at_texel(texel));
    let code = select(NO_DIFFUSE, known, has_diffuse_at(texel));
    textureStore(diffuse_out, texel, vec4f(light.diffuse, code.x));
    textureStore(specular_out, texel, vec4f(light.specular, code.y));
}

@compute @workgroup_size(8, 8)
fn horizontal(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= reach.interleave.texels) {
        return;
    }
    let z = textureLoad(depth, pixel_at(vec2i(texel)), 0);
    var result = Filtered(vec3f(0.0), vec3f(0.0));
    var inverse_distance = vec3f(0.0);
    if z > 0.0 {
        inverse_distance = mean_nearness(texel);
        result = filtered(texel, z, vec2i(1, 0), inverse_distance);
    }
    store_filtered(texel, result, inverse_distance);
}

fn filtered_vertically(texel: vec2u, z: f32) -> Filtered {
    let code = vec2f(textureLoad(diffuse, texel, 0).a, textureLoad(specular, texel, 0).a);
    return filtered(texel, z, vec2i(0, 1), decode_inverse_distance(code));
}

// Luminance of the brightest light next to a texel: of diffuse and of specular light.
fn brightest_beside(texel: vec2u) -> vec2f {
    var brightest = vec2f(0.0);
    for (var i = 0; i < 9; i++) {
        let at = clamp(vec2i(texel) + vec2i(i % 3 - 1, i / 3 - 1), vec2i(0), vec2i(reach.interleave.texels) - 1);
        let light = vec2f(luminance(textureLoad(diffuse, at, 0).rgb), luminance(textureLoad(specular, at, 0).rgb));
        brightest = select(max(brightest, light), brightest, i == 4);
    }
    return brightest;
}

fn limited(light: vec3f, limit: f32) -> vec3f {
    let found = luminance(light);
    return select(light, light * (limit / max(found, 1e-37)), found > limit);
}

// The light of the gathered pixels, for `gather_upsample` and `gather_shift`. Of the few rays of a frame a single one may meet
// something small and bright: no light is `stray` times as bright as all that is next to it.
@compute @workgroup_size(8, 8)
fn vertical_apart(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= reach.interleave.texels) {
        return;
    }
    let z = textureLoad(depth, pixel_at(vec2i(texel)), 0);
    var result = Filtered(vec3f(0.0), vec3f(0.0));
    if z > 0.0 {
        let light = filtered_vertically(texel, z);
        // Where anything goes, what stands alone before the sky keeps its light too.
        let limit = select(reach.stray * brightest_beside(texel), vec2f(3e38), reach.stray >= ANY);
        result = Filtered(limited(light.diffuse, limit.x), limited(light.specular, limit.y));
    }
    store_filtered(texel, result, vec3f(0.0));
}

@compute @workgroup_size(8, 8)
fn vertical(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var radiance = vec3f(0.0);
    if z > 0.0 && has_diffuse_at(thread.xy) {
        let light = filtered_vertically(thread.xy, z);
        let albedo = decode_albedo(textureLoad(base_color, thread.xy, 0));
        var specular_light = light.specular;
#ifdef TINTED
        let position = world_position(thread.xy, view.size, z, view.world_from_clip);
        specular_light *= tint_seen(textureLoad(normal, thread.xy, 0), textureLoad(object, thread.xy, 0), toward_eye(view, position));
#endif
        radiance = min(albedo * light.diffuse + specular_light, vec3f(1e32));
    }
    textureStore(indirect, thread.xy, vec4f(radiance, reach.weight));
}
