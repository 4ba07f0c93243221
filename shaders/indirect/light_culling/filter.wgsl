// Cross bilateral filter over the interleaved pixels, along one axis at a time, and the reflected radiance from what
// it leaves. The weights over distance are a tent whose half width is the radius: where nothing is in the way and the
// radius is a multiple of the interleaving, all subsets count alike, and no pattern is left. What is filtered is
// irradiance, so that textures stay sharp.

#import lightwell::bilateral::likeness
#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::slc::Culling

@group(0) @binding(1) var<uniform> culling: Culling;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(5) var diffuse: texture_2d<f32>;
@group(0) @binding(6) var specular: texture_2d<f32>;
@group(0) @binding(7) var diffuse_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var specular_out: texture_storage_2d<rgba32float, write>;
// As they left the shading, for the counts.
@group(0) @binding(9) var tested: texture_2d<f32>;
@group(0) @binding(10) var accepted: texture_2d<f32>;
@group(0) @binding(11) var indirect: texture_storage_2d<rgba32float, write>;

const SHOW_LIGHT: u32 = 0u;
const SHOW_CANDIDATES: u32 = 1u;
// Lights a pixel at the end of the scale of colours.
const FULL_SCALE: f32 = 512.0;

struct Filtered {
    diffuse: vec3f,
    specular: vec3f,
}

fn filtered(pixel: vec2u, z: f32, along: vec2i) -> Filtered {
    let position = world_position(pixel, culling.view.size, z, culling.view.world_from_clip);
    let n = decode_normal(textureLoad(normal, pixel, 0));
    var sum = Filtered(textureLoad(diffuse, pixel, 0).rgb, textureLoad(specular, pixel, 0).rgb);
    var weights = 1.0;
    let radius = i32(culling.filter_radius);
    for (var d = 1 - radius; d < radius; d++) {
        let at = vec2i(pixel) + d * along;
        if d == 0 || any(at < vec2i(0)) || any(at >= vec2i(culling.view.size)) {
            continue;
        }
        let other = vec2u(at);
        let other_z = textureLoad(depth, other, 0);
        if other_z <= 0.0 {
            continue;
        }
        let other_position = world_position(other, culling.view.size, other_z, culling.view.world_from_clip);
        let other_n = decode_normal(textureLoad(normal, other, 0));
        let weight = (1.0 - f32(abs(d)) / f32(radius)) * likeness(position, n, other_position, other_n);
        sum.diffuse += weight * textureLoad(diffuse, other, 0).rgb;
        sum.specular += weight * textureLoad(specular, other, 0).rgb;
        weights += weight;
    }
    return Filtered(sum.diffuse / weights, sum.specular / weights);
}

@compute @workgroup_size(8, 8)
fn horizontal(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= culling.view.size) {
        return;
    }
    let z = textureLoad(depth, thread.xy, 0);
    var result = Filtered(vec3f(0.0), vec3f(0.0));
    if z > 0.0 {
        result = filtered(thread.xy, z, vec2i(1, 0));
    }
    textureStore(diffuse_out, thread.xy, vec4f(result.diffuse, 0.0));
    textureStore(specular_out, thread.xy, vec4f(result.specular, 0.0));
}

// Black, blue, green, red over the scale.
fn heat(count: f32) -> vec3f {
    let t = saturate(count / FULL_SCALE) * 3.0;
    return saturate(vec3f(t - 2.0, 1.0 - abs(t - 2.0), 1.0 - abs(t - 1.0)));
}

@compute @workgroup_size(8, 8)
fn vertical(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= culling.view.size) {
        return;
    }
    let z = textureLoad(depth, pixel, 0);
    var radiance = vec3f(0.0);
    if z > 0.0 && culling.show == SHOW_LIGHT {
        let light = filtered(pixel, z, vec2i(0, 1));
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        radiance = min(albedo * light.diffuse * 0.318309886 + light.specular, vec3f(1e32));
    } else if z > 0.0 {
        let candidates = textureLoad(tested, pixel, 0).a;
        let wanted = textureLoad(accepted, pixel, 0).a;
        radiance = heat(select(candidates - wanted, candidates, culling.show == SHOW_CANDIDATES));
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
