// ξ and the range of every virtual light.

#import lightwell::sampling::{hash, unit_float}
#import lightwell::slc::{VirtualLight, LightRange, Culling, light_range}

@group(0) @binding(0) var<uniform> culling: Culling;
@group(0) @binding(1) var<storage, read> virtual_lights: array<VirtualLight>;
@group(0) @binding(2) var<storage, read> bound: vec4f;
@group(0) @binding(3) var<storage, read_write> ranges: array<LightRange>;

// Neighbouring lights shine alike, so that their numbers are spread evenly: Weyl's sequence with the golden ratio,
// shifted at random for each subset. Every single number is uniform over all seeds.
fn xi_of(index: u32) -> f32 {
    let subset = index / culling.lights;
    let steps = (index % culling.lights) * 2654435769u;
    let bits = steps + hash(subset ^ hash(culling.seed));
    return clamp(unit_float(bits), 0x1p-24f, 1.0 - 0x1p-24f);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index < arrayLength(&virtual_lights) {
        ranges[index] = light_range(virtual_lights[index], bound.x, xi_of(index), culling.bounds);
    }
}
