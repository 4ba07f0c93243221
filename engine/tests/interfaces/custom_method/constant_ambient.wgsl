// Constant ambient light: radiance ρ/π·E from every surface.

#import lightwell::gbuffer::decode_albedo

struct Ambient {
    irradiance: vec3f,     // E [W/m²]
}

@group(0) @binding(0) var<uniform> ambient: Ambient;
@group(0) @binding(1) var base_color: texture_2d<u32>;
@group(0) @binding(2) var depth: texture_depth_2d;
@group(0) @binding(3) var indirect: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(indirect)) {
        return;
    }
    var light = vec3f(0.0);
    if textureLoad(depth, thread.xy, 0) > 0.0 {
        light = decode_albedo(textureLoad(base_color, thread.xy, 0)) / 3.14159265 * ambient.irradiance;
    }
    textureStore(indirect, thread.xy, vec4f(light, 1.0));
}
