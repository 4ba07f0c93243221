// Virtual lights straight from texels of a reflective shadow map: one bounce, further ones are ignored.

#import lightwell::gbuffer::{decode_albedo, decode_normal}
#import lightwell::lights::Light
#import lightwell::rsm::{RsmLayer, texel_position, texel_received}
#import lightwell::sampling::{hash_pair, unit_float}
#import lightwell::vpl::{VirtualLight, INVERSE_PI}

struct Place {
    first: u32,            // light of this layer
    count: u32,            // lights of this layer
    seed: u32,
    random: u32,           // 1: independent numbers
    near_bound: f32,       // d_min in distances between neighbours
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(0) @binding(0) var<uniform> place: Place;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> rsm: RsmLayer;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var normal: texture_2d_array<u32>;
@group(0) @binding(5) var depth: texture_depth_2d_array;
@group(0) @binding(6) var<storage, read_write> virtual_lights: array<VirtualLight>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.y * groups.x * 64u + thread.x;
    if index >= place.count {
        return;
    }
    var u: vec2f;
    if place.random != 0u {
        let bits = hash_pair(place.seed, index);
        u = vec2f(unit_float(bits), unit_float(hash_pair(bits, 1u)));
    } else {
        // Hammersley's set, shifted (Cranley and Patterson 1976) and its digits flipped.
        let shift = unit_float(place.seed);
        u = vec2f(fract((f32(index) + 0.5) / f32(place.count) + shift), unit_float(reverseBits(index) ^ hash_pair(place.seed, 1u)));
    }
    let texel = min(vec2u(u * f32(rsm.size)), vec2u(rsm.size - 1u));
    var made: VirtualLight;
    let z = textureLoad(depth, texel, rsm.layer, 0);
    if z > 0.0 {
        let n = decode_normal(textureLoad(normal, texel, rsm.layer, 0));
        let position = texel_position(rsm, texel, z, n);
        let received = texel_received(rsm, light, texel, position);
        let albedo = decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
        // A texel stands for all that were not chosen.
        let share = f32(rsm.size) * f32(rsm.size) / f32(place.count);
        let area = received.area * share / max(dot(n, received.to_light), 1e-3);
        let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
        made = VirtualLight(
            position, 0u, n, place.near_bound * sqrt(area), albedo * received.flux * (share * INVERSE_PI), largest * 0x1p-12f,
            vec3f(0.0), 0u, 0u, 0u, 0.0, 0u,
        );
    }
    virtual_lights[place.first + index] = made;
}
