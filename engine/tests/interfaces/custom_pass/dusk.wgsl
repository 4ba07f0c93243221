// Dusk: below a luminance of 0.05 W/(m² sr) colours fade into blue.

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var dusk: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    if any(thread.xy >= textureDimensions(dusk)) {
        return;
    }
    let light = textureLoad(radiance, thread.xy, 0).rgb;
    let luminance = dot(light, vec3f(0.2126, 0.7152, 0.0722));
    let night = luminance * vec3f(0.6, 0.9, 1.8);
    textureStore(dusk, thread.xy, vec4f(mix(night, light, smoothstep(0.0, 0.05, luminance)), 1.0));
}
