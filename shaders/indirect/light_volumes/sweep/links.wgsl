// Which cells each surfel takes its light from, and which one it sends it to: those that no wall stands before.

#import lightwell::sweep::{Surfel, BEFORE, encode_link, nearest_axis, thickness_for}
#import lightwell::coverage::{linked_cell, reached_around, source_cell}
#import lightwell::volume::Volume

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
// See `encode_link`.
@group(0) @binding(2) var<storage, read_write> links: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    let n = surfel.normal;
    let x = (surfel.position - volume.origin) / volume.cell;
    let thickness = thickness_for(surfel, volume.cell);
    if thickness < 0.0 || any(x < vec3f(-1.0)) || any(x > vec3f(volume.cells) + 1.0) {
        links[index] = 0u;
        return;
    }
    let linked = linked_cell(volume, x, n, source_cell(x, n, thickness < volume.cell));
    links[index] = encode_link(reached_around(volume, x, n), linked.cell - floor(x + BEFORE * n), linked.is_any);
}
