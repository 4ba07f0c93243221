// What surfaces may reflect of a bounce: as much as the light lost on them, and no more.
//
// The irradiance at a surfel is interpolated, and surfels that touch or lie within each other each take the light that
// only one of them can have: together they would reflect more than arrived, and each further bounce would grow by it.
// So both are spread over the nodes of a coarse lattice, the flux that the sweep took out of the light (Φ_a) and that
// which the surfels claim (Φ_c = Σ A·E), with trilinear weights b; each surfel then keeps the share
//   Σ_nodes b·min(Φ_a/Φ_c, most)
// of its claim. Spread and interpolated with the same weights, all shares add up to Σ_nodes min(Φ_a, most·Φ_c).

#import lightwell::sweep::{Balance, Surfel, to_fixed, from_fixed, lattice_place, corner, corner_weight, node_index}
#import lightwell::volume::{Volume, cell_index}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> balance: Balance;
@group(0) @binding(2) var<storage, read> surfels: array<Surfel>;
// Irradiance of the surfels in the bounce [W/m²]; at the end, as much of it as they reflect a share of.
@group(0) @binding(3) var<storage, read_write> received: array<vec4f>;
// Φ_c of each node, high and low words.
@group(0) @binding(4) var<storage, read_write> claims: array<atomic<i32>>;
// Irradiance of the bounce by axis, and behind it what each cell took out of the light [W/m²].
@group(0) @binding(5) var<storage, read> axes: array<f32>;
@group(0) @binding(6) var<storage, read_write> shares: array<f32>;

fn add(node: u32, flux: f32) {
    let words = to_fixed(flux);
    atomicAdd(&claims[2u * node], words.x);
    let low = bitcast<u32>(atomicAdd(&claims[2u * node + 1u], words.y));
    // However many summands: where the low word wraps around, the high one takes it up.
    if low + u32(words.y) < low {
        atomicAdd(&claims[2u * node], 65536);
    }
}

@compute @workgroup_size(64)
fn claim(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    let e = received[index].rgb;
    let flux = min((e.r + e.g + e.b) * surfel.area * balance.scale, 3.5e13);
    if !(flux > 0.0) {
        return;
    }
    let place = lattice_place(balance, (surfel.position - volume.origin) / volume.cell);
    for (var i = 0u; i < 8u; i++) {
        let weight = corner_weight(place, i);
        if weight > 0.0 {
            add(node_index(balance, corner(place, i)), weight * flux);
        }
    }
}

var<workgroup> partial: array<f32, 64>;

// A workgroup for each node.
@compute @workgroup_size(64)
fn share(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let node = vec3f(group);
    let last = vec3f(balance.nodes - 1u);
    // Cells whose centres lie within a block of the node; those beyond the outermost nodes count to these.
    let low = vec3u(max(vec3f(0.0), (node - 1.0) * balance.block));
    let high = min(volume.cells, vec3u((node + 1.0) * balance.block) + 1u);
    let size = high - min(low, high);
    let first = 18u * volume.cells.x * volume.cells.y * volume.cells.z;
    var lost = 0.0;
    for (var i = local; i < size.x * size.y * size.z; i += 64u) {
        let cell = low + vec3u(i % size.x, i / size.x % size.y, i / size.x / size.y);
        let at = clamp((vec3f(cell) + 0.5) / balance.block, vec3f(0.0), last);
        let w = max(vec3f(0.0), 1.0 - abs(at - node));
        lost += w.x * w.y * w.z * max(0.0, axes[first + cell_index(volume, cell)]);
    }
    partial[local] = lost;
    workgroupBarrier();
    if local == 0u {
        // In order, so that a frame is the same from run to run.
        var sum = 0.0;
        for (var i = 0u; i < 64u; i++) {
            sum += partial[i];
        }
        let index = node_index(balance, group);
        let claimed = from_fixed(atomicLoad(&claims[2u * index]), atomicLoad(&claims[2u * index + 1u]));
        let flux = sum * volume.cell * volume.cell * balance.scale;
        shares[index] = min(balance.most, flux / max(claimed, 1.0));
    }
}

// Each surfel keeps its share.
@compute @workgroup_size(64)
fn keep(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let place = lattice_place(balance, (surfels[index].position - volume.origin) / volume.cell);
    var sum = 0.0;
    for (var i = 0u; i < 8u; i++) {
        sum += corner_weight(place, i) * shares[node_index(balance, corner(place, i))];
    }
    received[index] = vec4f(received[index].rgb * sum, received[index].a);
}
