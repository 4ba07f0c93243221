// What glass takes of a light on its way to the texels of its reflective shadow map: the surfaces there are darker by so much,
// whoever reads the map. The map itself looks through glass.

#import lightwell::gbuffer::{decode_base_color, decode_normal_reflectance, encode_base_color, encode_object, world_position}
#import lightwell::lights::{Light, light_incidence}
#import lightwell::rays::Ray
#import lightwell::walk::left_by_glass
#import lightwell::rsm::RsmLayer

struct ThroughGlass {
    root: u32,             // of the hierarchy for rays
}

@group(0) @binding(0) var<uniform> through_glass: ThroughGlass;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> rsm: RsmLayer;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var specular: texture_2d_array<u32>;
@group(0) @binding(5) var depth: texture_depth_2d_array;
@group(0) @binding(6) var lit_base_color: texture_storage_2d_array<rgba16uint, write>;
@group(0) @binding(7) var lit_specular: texture_storage_2d_array<r32uint, write>;

fn left(texel: vec2u, z: f32) -> vec3f {
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    let incidence = light_incidence(light, position);
    let is_far = incidence.distance == 0.0;
    return left_by_glass(through_glass.root, Ray(position, incidence.to_light), select(incidence.distance, 3e38, is_far));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= vec2u(rsm.size)) {
        return;
    }
    let z = textureLoad(depth, texel, rsm.layer, 0);
    var base = textureLoad(base_color, texel, rsm.layer, 0);
    var mirrored = textureLoad(specular, texel, rsm.layer, 0).r;
    if z > 0.0 {
        let share = left(texel, z);
        // What nothing stands before keeps its bits.
        if any(share < vec3f(1.0)) {
            base = encode_base_color(decode_base_color(base) * share, f32(base.a) / 65535.0);
            mirrored = encode_object(0u, decode_normal_reflectance(vec2u(0u, mirrored)) * share).y;
        }
    }
    textureStore(lit_base_color, texel, rsm.layer, base);
    textureStore(lit_specular, texel, rsm.layer, vec4u(mirrored, 0u, 0u, 0u));
}
