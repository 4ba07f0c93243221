// Light injection: every texel of a reflective shadow map becomes a diffuse source in the cell before its surface.
//
// A texel sends out Φ = ρ·Φ_in with intensity I(ω) = (Φ/π)·max(0, n·ω). Sums are made in fixed point: exact to
// rounding, and the same in whatever order the texels come.

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::lights::Light
#import lightwell::rsm::{RsmLayer, texel_received}
#import lightwell::sh::sh_cosine_lobe
#import lightwell::volume::{Volume, cell_index, BEHIND}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> rsm: RsmLayer;
@group(0) @binding(3) var base_color: texture_2d_array<u32>;
@group(0) @binding(4) var normal: texture_2d_array<u32>;
@group(0) @binding(5) var depth: texture_depth_2d_array;
@group(0) @binding(6) var<storage, read_write> fixed: array<atomic<i32>>;
@group(0) @binding(7) var<storage, read_write> injected: array<f32>;

const INVERSE_PI: f32 = 0.318309886;

@compute @workgroup_size(8, 8)
fn inject(@builtin(global_invocation_id) thread: vec3u) {
    let texel = thread.xy;
    if any(texel >= vec2u(rsm.size)) {
        return;
    }
    let z = textureLoad(depth, texel, rsm.layer, 0);
    if z <= 0.0 {
        return;
    }
    let albedo = decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
    if all(albedo <= vec3f(0.0)) {
        return;
    }
    let n = decode_normal(textureLoad(normal, texel, rsm.layer, 0));
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    let received = texel_received(rsm, light, texel, position);
    // Half a cell off the surface and half a cell towards the light: away from its own blockers.
    let at = (position - volume.origin) / volume.cell + (0.5 - BEHIND) * n + 0.5 * received.to_light;
    if any(at < vec3f(0.0)) || any(at >= vec3f(volume.cells)) {
        return;
    }
    let first = 12u * cell_index(volume, vec3u(at));
    let lobe = sh_cosine_lobe(n) * INVERSE_PI;
    let flux = albedo * received.flux * rsm.scale;
    for (var channel = 0u; channel < 3u; channel++) {
        if flux[channel] > 0.0 {
            let amount = vec4i(round(flux[channel] * lobe));
            for (var i = 0u; i < 4u; i++) {
                atomicAdd(&fixed[first + 4u * channel + i], amount[i]);
            }
        }
    }
}

// Adds the fixed-point sums of one light to the volume, as I/h².
@compute @workgroup_size(64)
fn add_to_volume(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= 12u * volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    let sum = f32(atomicLoad(&fixed[index]));
    // Divided one by one: the product of the factors may leave the range of floats.
    injected[index] += sum / rsm.scale / volume.cell / volume.cell;
}
