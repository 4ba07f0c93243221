// Cross bilateral filter over what was gathered, along one axis at a time, and the reflected radiance from what it
// leaves. Diffuse light is filtered as if all surfaces were white, so that textures stay sharp, and the specular light of
// smooth surfaces less far, since it is an image.
//
// Irradiance changes over a distance d by about d/R of itself, with the harmonic mean R of the distances of all that a
// point sees (Ward, Rubinstein and Clear 1988), and mostly towards the side where the near surfaces are (Ward and Heckbert
// 1992, "Irradiance gradients"): weights fall off quickly with d/R to that side and slowly along, so that corners and
// contact shadows stay sharp without noise in them, and open walls are smooth.

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::nearness::{decode_nearness, encode_nearness}
#import lightwell::sampling::basis
#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> reach: Reach;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
// Alpha of both: how near and to which side is what the rays met, see lib/nearness.wgsl.
@group(0) @binding(5) var diffuse: texture_2d<f32>;
@group(0) @binding(6) var specular: texture_2d<f32>;
@group(0) @binding(7) var diffuse_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var specular_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(11) var indirect: texture_storage_2d<rgba32float, write>;

struct Reach {
    // Pixels, the one in the middle among them.
    radius: i32,
}

// d/R at which a neighbour's weight has fallen to 1/e, towards near surfaces and along them; but within LEAST pixels all
// count, or corners would be noise.
const TOLERANCE: f32 = 0.15;
const TOLERANCE_ALONG: f32 = 0.8;
const LEAST: f32 = 2.0;

struct Filtered {
    diffuse: vec3f,
    specular: vec3f,
}

// How near and to which side is what the pixels around see: that of few rays is noise. See lib/nearness.wgsl.
fn mean_nearness(pixel: vec2u) -> vec3f {
    var sum = vec3f(0.0);
    var count = 0.0;
    for (var i = 0; i < 25; i++) {
        let at = clamp(vec2i(pixel) + 2 * vec2i(i % 5 - 2, i / 5 - 2), vec2i(0), vec2i(view.size) - 1);
        if textureLoad(depth, at, 0) > 0.0 {
            let code = vec2f(textureLoad(diffuse, at, 0).a, textureLoad(specular, at, 0).a);
            sum += decode_nearness(code);
            count += 1.0;
        }
    }
    return sum / max(count, 1.0);
}

fn filtered(pixel: vec2u, z: f32, along: vec2i, nearness: vec3f) -> Filtered {
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let texel = textureLoad(normal, pixel, 0);
    let n = decode_normal(texel);
    let toward_near = (basis(n) * vec3f(nearness.xy, 0.0)) / TOLERANCE;
    let roughness = f32(texel.z) / 65535.0;
    // Of the specular lobe: about its width over that of the diffuse one.
    let lobe = max(1.0, saturate(2.0 * roughness * roughness) * f32(reach.radius));
    var sum = Filtered(textureLoad(diffuse, pixel, 0).rgb, textureLoad(specular, pixel, 0).rgb);
    var weights = vec2f(1.0);
    for (var d = 1 - reach.radius; d < reach.radius; d++) {
        let at = vec2i(pixel) + d * along;
        if d == 0 || any(at < vec2i(0)) || any(at >= vec2i(view.size)) {
            continue;
        }
        let other = vec2u(at);
        let other_z = textureLoad(depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let other_position = world_position(other, view.size, other_z, view.world_from_clip);
        let like = likeness(position, n, other_position, decode_normal(textureLoad(normal, other, 0)));
        let off = other_position - position;
        let across = dot(off, toward_near);
        let any_way = length(off) * (nearness.z / TOLERANCE_ALONG);
        let near = exp(-min(across * across + any_way * any_way, f32(d * d) / (LEAST * LEAST)));
        let weight = near * saturate(1.0 - f32(abs(d)) / vec2f(f32(reach.radius), lobe)) * like;
        sum.diffuse += weight.x * textureLoad(diffuse, other, 0).rgb;
        sum.specular += weight.y * textureLoad(specular, other, 0).rgb;
        weights += weight;
    }
    return Filtered(sum.diffuse / weights.x, sum.specular / weights.y);
}

@compute @workgroup_size(8, 8)
fn horizontal(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var result = Filtered(vec3f(0.0), vec3f(0.0));
    var nearness = vec3f(0.0);
    if z > 0.0 {
        nearness = mean_nearness(thread.xy);
        result = filtered(thread.xy, z, vec2i(1, 0), nearness);
    }
    let code = encode_nearness(nearness);
    textureStore(diffuse_out, thread.xy, vec4f(result.diffuse, code.x));
    textureStore(specular_out, thread.xy, vec4f(result.specular, code.y));
}

@compute @workgroup_size(8, 8)
fn vertical(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var radiance = vec3f(0.0);
    if z > 0.0 {
        let code = vec2f(textureLoad(diffuse, thread.xy, 0).a, textureLoad(specular, thread.xy, 0).a);
        let light = filtered(thread.xy, z, vec2i(0, 1), decode_nearness(code));
        let albedo = decode_albedo(textureLoad(base_color, thread.xy, 0));
        radiance = min(albedo * light.diffuse + light.specular, vec3f(1e32));
    }
    textureStore(indirect, thread.xy, vec4f(radiance, 1.0));
}
