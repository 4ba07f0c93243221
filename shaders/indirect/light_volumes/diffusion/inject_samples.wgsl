// Light injection by samples: texels of all maps, drawn in proportion to the flux that they reflect (Šefčík 2016, section
// 8.2), each with an equal part of it. Their sum is that of all texels.

#import lightwell::gbuffer::{decode_albedo, decode_normal, world_position}
#import lightwell::rsm::texel_received
#import lightwell::rsm_draw::{base_color, cumulative, depth, draw, draw_texel, light, normal, rsm, weigh_texel}
#import lightwell::sh::sh_cosine_lobe
#import lightwell::volume::{Volume, cell_index, BEHIND}

@group(0) @binding(10) var<uniform> volume: Volume;
@group(0) @binding(11) var<storage, read_write> fixed: array<atomic<i32>>;
@group(0) @binding(12) var<storage, read_write> injected: array<f32>;

const INVERSE_PI: f32 = 0.318309886;

// Power of two that turns weights into fixed point: a lobe's coefficient is at most a third of its flux, and all flux
// together is the total.
fn fixed_scale(total: f32) -> f32 {
    return exp2(29.0 - ceil(log2(max(total, 1e-30))));
}

@compute @workgroup_size(64)
fn inject(@builtin(global_invocation_id) thread: vec3u) {
    let drawn = draw_texel(thread.x);
    if !drawn.is_here {
        return;
    }
    let texel = drawn.texel;
    let albedo = decode_albedo(textureLoad(base_color, texel, rsm.layer, 0));
    let n = decode_normal(textureLoad(normal, texel, rsm.layer, 0));
    let z = textureLoad(depth, texel, rsm.layer, 0);
    let position = world_position(texel, vec2u(rsm.size), z, rsm.world_from_clip);
    let received = texel_received(rsm, light, texel, position);
    // As in inject.wgsl.
    let at = (position - volume.origin) / volume.cell + (0.5 - BEHIND) * n + 0.5 * received.to_light;
    let weight = weigh_texel(texel);
    if !(weight > 0.0) || any(at < vec3f(0.0)) || any(at >= vec3f(volume.cells)) {
        return;
    }
    let share = drawn.total / f32(draw.points) * fixed_scale(drawn.total);
    let flux = draw.scale * received.flux * albedo / weight * share;
    let first = 12u * cell_index(volume, vec3u(at));
    let lobe = sh_cosine_lobe(n) * INVERSE_PI;
    for (var channel = 0u; channel < 3u; channel++) {
        if flux[channel] > 0.0 {
            let amount = vec4i(round(flux[channel] * lobe));
            for (var i = 0u; i < 4u; i++) {
                atomicAdd(&fixed[first + 4u * channel + i], amount[i]);
            }
        }
    }
}

// Adds the fixed-point sums of all samples to the volume, as I/h².
@compute @workgroup_size(64)
fn add_to_volume(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= 12u * volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    let sum = f32(atomicLoad(&fixed[index]));
    injected[index] += sum / fixed_scale(cumulative[draw.strips - 1u]) / draw.scale / volume.cell / volume.cell;
}
