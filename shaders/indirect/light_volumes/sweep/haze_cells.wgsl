// All light in each cell, as media would scatter it to all sides alike: straight from the lights, and the mean radiance of all
// else, J = Σ E/(6π) over the six faces (see `fluence_at` of lib/sweep_lookup.wgsl).

#import lightwell::volume::Volume

@group(0) @binding(0) var<uniform> volume: Volume;
// See `indirect/light_volumes/sweep/lamp_light.wgsl`.
@group(0) @binding(1) var<storage, read> lamp_light: array<vec4f>;
// Irradiance by cell and axis [W/m²].
@group(0) @binding(2) var<storage, read> axes: array<f32>;
// [W/(m² sr)]
@group(0) @binding(3) var<storage, read_write> haze_cells: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < 6u; i++) {
        let first = 18u * index + 3u * i;
        sum += vec3f(axes[first], axes[first + 1u], axes[first + 2u]);
    }
    haze_cells[index] = vec4f(lamp_light[3u * index].rgb + sum / 18.849556, 0.0);
}
