// Hemisphere light: radiance ρ/π·E(n) from every surface, with E between that of the ground and that of the sky.

#import lightwell::gbuffer::{decode_albedo, decode_normal}

@group(0) @binding(0) var<uniform> irradiance: array<vec3f, 2>; // from the sky and from the ground [W/m²]
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var indirect: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(indirect)) {
        return;
    }
    var light = vec3f(0.0);
    if textureLoad(depth, thread.xy, 0) > 0.0 {
        let up = decode_normal(textureLoad(normal, thread.xy, 0)).y;
        let received = mix(irradiance[1], irradiance[0], 0.5 + 0.5 * up);
        light = decode_albedo(textureLoad(base_color, thread.xy, 0)) / 3.14159265 * received;
    }
    textureStore(indirect, thread.xy, vec4f(light, 1.0));
}
