// Injection of emissive surfaces: each of their samples becomes a diffuse source in the cell before its surface (Šefčík
// 2016, section 8.2). A surfel of radiance L and area A has the intensity I(ω) = L·A·max(0, n·ω).

#import lightwell::sh::sh_cosine_lobe
#import lightwell::sweep::Surfel
#import lightwell::volume::{Volume, cell_index, BEHIND}

struct Emission {
    scale: f32,            // power of two that turns intensity [W/sr] into fixed point
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> emission: Emission;
@group(0) @binding(2) var<storage, read> surfels: array<Surfel>;
@group(0) @binding(6) var<storage, read_write> fixed: array<atomic<i32>>;
@group(0) @binding(7) var<storage, read_write> injected: array<f32>;

@compute @workgroup_size(64)
fn inject(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    let at = (surfel.position - volume.origin) / volume.cell + (0.5 - BEHIND) * surfel.normal;
    if all(surfel.emissive <= vec3f(0.0)) || any(at < vec3f(0.0)) || any(at >= vec3f(volume.cells)) {
        return;
    }
    let first = 12u * cell_index(volume, vec3u(at));
    let lobe = sh_cosine_lobe(surfel.normal);
    let intensity = surfel.emissive * (surfel.area * emission.scale);
    for (var channel = 0u; channel < 3u; channel++) {
        let amount = vec4i(round(intensity[channel] * lobe));
        for (var i = 0u; i < 4u; i++) {
            atomicAdd(&fixed[first + 4u * channel + i], amount[i]);
        }
    }
}

// Adds the fixed-point sums to the volume, as I/h².
@compute @workgroup_size(64)
fn add_to_volume(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= 12u * volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    let sum = f32(atomicLoad(&fixed[index]));
    injected[index] += sum / emission.scale / volume.cell / volume.cell;
}
