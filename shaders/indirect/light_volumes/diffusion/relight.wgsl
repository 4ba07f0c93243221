// Relight: indirect irradiance of every visible surface from the volumes, E = k·Σ A_l·Y_lm(−n)·Î_lm, and the
// radiance ρ·E/π that a diffuse surface makes of it.
//   AMBIENT_OCCLUSION  nearby surfaces keep a part of it away

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::relight::propagated_irradiance
#import lightwell::view::View

// The pixels in which a volume may be seen.
struct Region {
    origin: vec2u,
    size: vec2u,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(9) var indirect: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var<uniform> region: Region;
#ifdef AMBIENT_OCCLUSION
@group(0) @binding(11) var visibility: texture_2d<f32>;
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= region.size) {
        return;
    }
    let pixel = region.origin + thread.xy;
    var radiance = vec3f(0.0);
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let n = decode_normal(textureLoad(normal, pixel, 0));
        var irradiance = propagated_irradiance(point, n);
#ifdef AMBIENT_OCCLUSION
        irradiance *= textureLoad(visibility, pixel, 0).r;
#endif
        radiance = min(albedo * irradiance / 3.14159265, vec3f(1e32));
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}

// Black: what lies outside of all volumes.
@compute @workgroup_size(8, 8)
fn clear(@builtin(global_invocation_id) thread: vec3u) {
    if all(thread.xy < textureDimensions(indirect)) {
        textureStore(indirect, thread.xy, vec4f(vec3f(0.0), 1.0));
    }
}
