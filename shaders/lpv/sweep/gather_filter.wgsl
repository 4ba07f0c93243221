// Cross bilateral filter over what was gathered, along one axis at a time, and the reflected radiance from what it
// leaves. Diffuse light is filtered as if all surfaces were white, so that textures stay sharp, and the specular light of
// smooth surfaces less far, since it is an image.
//
// Irradiance changes over a distance d by about d/R of itself, with the harmonic mean R of the distances of all that a
// point sees (Ward, Rubinstein and Clear 1988): weights fall off with d/R, so that corners and contact shadows stay sharp
// and open walls are smooth.

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
// Alpha: closeness of what the rays met, 1/distance in the mean [1/m].
@group(0) @binding(5) var diffuse: texture_2d<f32>;
@group(0) @binding(6) var specular: texture_2d<f32>;
@group(0) @binding(7) var diffuse_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var specular_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(11) var indirect: texture_storage_2d<rgba32float, write>;

#ifdef RADIUS
const RADIUS: i32 = #{RADIUS};
#else
const RADIUS: i32 = 1;
#endif

// d/R at which a neighbour's weight has fallen to 1/e; but within LEAST pixels all count, or corners would be noise.
const TOLERANCE: f32 = 0.2;
const LEAST: f32 = 2.0;

struct Filtered {
    diffuse: vec3f,
    specular: vec3f,
}

// Mean closeness 1/R of what the pixels around see [1/m]: that of few rays is noise.
fn mean_closeness(pixel: vec2u) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 25; i++) {
        let at = clamp(vec2i(pixel) + 2 * vec2i(i % 5 - 2, i / 5 - 2), vec2i(0), vec2i(view.size) - 1);
        if textureLoad(depth, at, 0) > 0.0 {
            sum += textureLoad(diffuse, at, 0).a;
            count += 1.0;
        }
    }
    return sum / max(count, 1.0);
}

fn filtered(pixel: vec2u, z: f32, along: vec2i, closeness: f32) -> Filtered {
    let position = world_position(pixel, view.size, z, view.world_from_clip);
    let texel = textureLoad(normal, pixel, 0);
    let n = decode_normal(texel);
    let roughness = f32(texel.z) / 65535.0;
    // Of the specular lobe: about its width over that of the diffuse one.
    let lobe = max(1.0, saturate(2.0 * roughness * roughness) * f32(RADIUS));
    var sum = Filtered(textureLoad(diffuse, pixel, 0).rgb, textureLoad(specular, pixel, 0).rgb);
    var weights = vec2f(1.0);
    for (var d = 1 - RADIUS; d < RADIUS; d++) {
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
        let off = (other_position - position) * (closeness / TOLERANCE);
        let near = exp(-min(dot(off, off), f32(d * d) / (LEAST * LEAST)));
        let weight = near * saturate(1.0 - f32(abs(d)) / vec2f(f32(RADIUS), lobe)) * like;
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
    var closeness = 0.0;
    if z > 0.0 {
        closeness = mean_closeness(thread.xy);
        result = filtered(thread.xy, z, vec2i(1, 0), closeness);
    }
    textureStore(diffuse_out, thread.xy, vec4f(result.diffuse, closeness));
    textureStore(specular_out, thread.xy, vec4f(result.specular, 0.0));
}

@compute @workgroup_size(8, 8)
fn vertical(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var radiance = vec3f(0.0);
    if z > 0.0 {
        let light = filtered(thread.xy, z, vec2i(0, 1), textureLoad(diffuse, thread.xy, 0).a);
        let albedo = decode_albedo(textureLoad(base_color, thread.xy, 0));
        radiance = min(albedo * light.diffuse + light.specular, vec3f(1e32));
    }
    textureStore(indirect, thread.xy, vec4f(radiance, 1.0));
}
