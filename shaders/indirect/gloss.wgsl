// Gloss: what GGX lobes reflect of the swept light, and the diffuse reflection without what they took. Irradiance about
// the lobe's direction over π stands for the radiance in the lobe: right for even light, too blurred for smooth surfaces.
// What a sky's image adds to that is made before (`sky/sky_light.wgsl`).

#import lightwell::environment::{lobe_reflectance, lobe_direction}
#import lightwell::gbuffer::{decode_surface, world_position}
#import lightwell::sweep_lookup::irradiance_around
#import lightwell::view::{View, toward_eye}
#import lightwell::volume::Volume

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(3) var<uniform> swept: Volume;
@group(0) @binding(4) var base_color: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var object: texture_2d<u32>;
@group(0) @binding(7) var depth: texture_depth_2d;
@group(0) @binding(8) var diffuse: texture_2d<f32>;
@group(0) @binding(10) var sky: texture_2d<f32>;
@group(0) @binding(9) var indirect: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let pixel = thread.xy;
    if any(pixel >= view.size) {
        return;
    }
    var radiance = textureLoad(diffuse, pixel, 0).rgb;
    let z = textureLoad(depth, pixel, 0);
    if z > 0.0 {
        let point = world_position(pixel, view.size, z, view.world_from_clip);
        let s = decode_surface(
            textureLoad(base_color, pixel, 0), textureLoad(normal, pixel, 0), textureLoad(object, pixel, 0).xy, z, point,
        );
        if any(s.normal_reflectance > vec3f(0.0)) || s.grazing_reflectance > 0.0 {
            let to_eye = normalize(toward_eye(view, point));
            let n_dot_v = max(dot(s.normal, to_eye), 1e-4);
            let share = lobe_reflectance(s.normal_reflectance, s.grazing_reflectance, s.roughness, n_dot_v);
            let around = irradiance_around(swept, point, s.normal, lobe_direction(s.normal, to_eye, s.roughness), to_eye);
            let kept = 1.0 - max(share.r, max(share.g, share.b));
            let image = textureLoad(sky, min(pixel, textureDimensions(sky) - 1u), 0).rgb;
            let in_lobe = max(around * 0.318309886 + image, vec3f(0.0));
            radiance = min(kept * radiance + share * in_lobe, vec3f(1e32));
        }
    }
    textureStore(indirect, pixel, vec4f(radiance, 1.0));
}
