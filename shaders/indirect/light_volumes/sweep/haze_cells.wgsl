// All light in each cell, as media would scatter it to all sides alike: straight from the lights, and the mean radiance of all
// else, J = Σ E/(6π) over the six faces (see `fluence_at` of lib/sweep_lookup.wgsl).

#import lightwell::volume::Volume

@group(0) @binding(0) var<uniform> volume: Volume;
// See `indirect/light_volumes/sweep/lamp_light.wgsl`.
@group(0) @binding(1) var<storage, read> lamp_light: array<vec4f>;
// Irradiance by cell and axis [W/m²].
@group(0) @binding(2) var<storage, read> axes: array<f32>;
// Two vectors a cell: J [W/(m² sr)]; net flux of all channels together [W/m²].
@group(0) @binding(3) var<storage, read_write> haze_cells: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    var sum = vec3f(0.0);
    var flux = vec3f(lamp_light[3u * index].w, lamp_light[3u * index + 1u].w, lamp_light[3u * index + 2u].w);
    for (var axis = 0u; axis < 3u; axis++) {
        let first = 18u * index + 6u * axis;
        let above = vec3f(axes[first], axes[first + 1u], axes[first + 2u]);
        let below = vec3f(axes[first + 3u], axes[first + 4u], axes[first + 5u]);
        sum += above + below;
        let net = below - above;
        flux[axis] += net.r + net.g + net.b;
    }
    haze_cells[2u * index] = vec4f(lamp_light[3u * index].rgb + sum / 18.849556, 0.0);
    haze_cells[2u * index + 1u] = vec4f(flux, 0.0);
}
