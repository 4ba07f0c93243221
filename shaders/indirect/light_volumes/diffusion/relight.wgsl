// Relight: indirect irradiance of every visible surface from the volumes, E = k·Σ A_l·Y_lm(−n)·Î_lm, and the
// radiance ρ·E/π that a diffuse surface makes of it.

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::relight::propagated_irradiance
#import lightwell::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(2) var base_color: texture_2d<u32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(9) var indirect: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    var radiance = vec3f(0.0);
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        let albedo = decode_albedo(textureLoad(base_color, pixel, 0));
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let n = decode_normal(textureLoad(normal, pixel, 0));
        radiance = min(albedo * propagated_irradiance(point, n) / 3.14159265, vec3f(1e32));
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
