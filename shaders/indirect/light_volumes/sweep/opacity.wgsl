// What stops light in a cell: the opacity tensor of thick solids, and the seal, by which surfaces close the faces of the
// cells that they pass. A wall closes a face whole or not at all (`indirect/light_volumes/sweep/coverage.wgsl`), so that closed surfaces leave
// no gap; surfels tell which way it faces. What is smaller than a cell, or has holes, closes faces by its area.

#import lightwell::sweep::{Surfel, BEFORE, nearest_axis, thickness_for}
#import lightwell::coverage::is_face_walled
#import lightwell::volume::{Volume, cell_index}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<storage, read> surfels: array<Surfel>;
// 44 a cell: Txx Tyy Tzz Txy Tyz Tzx, area of thin surfaces, area of thick ones just above the centre; then N and a of
// the lower faces along x, y, z, for light along +i (surfaces with n_i < 0) and along −i; then Σ A·n of the surfaces that
// look their light up here, for each axis that a normal may lie nearest to; nothing.
@group(0) @binding(2) var<storage, read_write> sums: array<atomic<i32>>;
// The same as numbers, eleven vectors a cell; N and n normalised, a at most 1.
@group(0) @binding(3) var<storage, read_write> opacity: array<vec4f>;

// A cell's areas sum to far less than 2⁷ faces.
const AREA_SCALE: f32 = 16777216.0;

fn add(index: u32, value: f32) {
    atomicAdd(&sums[index], i32(round(value * AREA_SCALE)));
}

fn inside(cell: vec3f) -> bool {
    return all(cell >= vec3f(0.0)) && all(cell < vec3f(volume.cells));
}

// T += A·n nᵀ, ¾ of a cell below the surface.
fn add_tensor(p: vec3f, n: vec3f, area: f32) {
    let cell = floor(p - 0.75 * n);
    if !inside(cell) {
        return;
    }
    let first = 44u * cell_index(volume, vec3u(cell));
    let square = area * n * n;
    let mixed = area * n * n.yzx;
    for (var i = 0u; i < 3u; i++) {
        add(first + i, square[i]);
        add(first + 3u + i, mixed[i]);
    }
}

// Slides the surfel's plane to the centre line of the column that it lies in, and gives its normal to the face next to
// it there; what is no wall closes that face by its area.
fn seal(q: vec3f, n: vec3f, area: f32, is_wall: bool, i: u32) {
    let j = (i + 1u) % 3u;
    let k = (i + 2u) % 3u;
    if abs(n[i]) < 1e-3 {
        return;
    }
    let across = vec2f(q[j] - floor(q[j]) - 0.5, q[k] - floor(q[k]) - 0.5);
    let slide = dot(vec2f(n[j], n[k]), across) / n[i];
    var cell = floor(q);
    cell[i] = round(q[i] + clamp(slide, -4.0, 4.0));
    if !inside(cell) {
        return;
    }
    let side = select(1u, 0u, n[i] < 0.0);
    let first = 44u * cell_index(volume, vec3u(cell)) + 8u + 4u * (2u * i + side);
    let weight = area * abs(n[i]);
    add(first, weight * n.x);
    add(first + 1u, weight * n.y);
    add(first + 2u, weight * n.z);
    if !is_wall {
        add(first + 3u, weight);
    }
}

// Tells the cells before a surface, which its irradiance is interpolated from, which way it faces.
fn add_facing(p: vec3f, n: vec3f, area: f32) {
    let low = floor(p + 0.5 * n - 0.5);
    for (var i = 0u; i < 8u; i++) {
        let cell = low + vec3f(f32(i & 1u), f32((i >> 1u) & 1u), f32(i >> 2u));
        if inside(cell) && dot(n, cell + 0.5 - p) > 0.0 {
            let first = 44u * cell_index(volume, vec3u(cell)) + 32u + 3u * nearest_axis(n);
            add(first, area * n.x);
            add(first + 1u, area * n.y);
            add(first + 2u, area * n.z);
        }
    }
}

@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= arrayLength(&surfels) {
        return;
    }
    let surfel = surfels[index];
    let n = surfel.normal;
    let p = (surfel.position - volume.origin) / volume.cell;
    let area = min(surfel.area / volume.cell / volume.cell, 4.0);
    let thickness = thickness_for(surfel, volume.cell) / volume.cell;
    if !(area > 0.0) || thickness < 0.0 || any(p < vec3f(-8.0)) || any(p > vec3f(volume.cells) + 8.0) {
        return;
    }
    let before = p + BEFORE * n;
    add_facing(p, n, area);
    if thickness >= 1.0 {
        add_tensor(before, n, area);
        // The cell whose centre lies just below the surface.
        let below = floor(before - 0.5 * n);
        if inside(below) {
            add(44u * cell_index(volume, vec3u(below)) + 7u, area);
        }
    } else if inside(floor(before)) {
        add(44u * cell_index(volume, vec3u(before)) + 6u, area);
    }
    let is_wall = surfel.wall >= volume.cell;
    for (var axis = 0u; axis < 3u; axis++) {
        seal(before, n, area, is_wall, axis);
    }
}

fn face_sums(index: u32, axis: u32, side: u32) -> vec4f {
    let first = 44u * index + 4u * (2u + 2u * axis + side);
    let v = vec4f(
        f32(atomicLoad(&sums[first])), f32(atomicLoad(&sums[first + 1u])),
        f32(atomicLoad(&sums[first + 2u])), f32(atomicLoad(&sums[first + 3u])),
    ) / AREA_SCALE;
    return vec4f(v.xyz / max(length(v.xyz), 1e-12), min(v.w, 1.0));
}

// What surfels tell of a face, or the axis where a wall's surfels miss it.
fn facing(n: vec3f, axis: u32, side: u32) -> vec3f {
    var out = n;
    if all(n == vec3f(0.0)) {
        out[axis] = select(-1.0, 1.0, side == 1u);
    }
    return out;
}

// N and a of a face for light along +axis (side 0) or −axis. Walls close it whole, and where they have but one side their
// backs close it too: nothing is seen through them.
fn closed_face(cell: vec3u, index: u32, axis: u32, side: u32) -> vec4f {
    let here = face_sums(index, axis, side);
    if is_face_walled(volume, cell, axis, side) {
        return vec4f(facing(here.xyz, axis, side), 1.0);
    }
    if is_face_walled(volume, cell, axis, 1u - side) {
        return vec4f(-facing(face_sums(index, axis, 1u - side).xyz, axis, 1u - side), 1.0);
    }
    return here;
}

@compute @workgroup_size(64)
fn finish(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    if index >= volume.cells.x * volume.cells.y * volume.cells.z {
        return;
    }
    let cell = vec3u(index % volume.cells.x, index / volume.cells.x % volume.cells.y, index / volume.cells.x / volume.cells.y);
    for (var i = 0u; i < 2u; i++) {
        let first = 44u * index + 4u * i;
        opacity[11u * index + i] = vec4f(
            f32(atomicLoad(&sums[first])), f32(atomicLoad(&sums[first + 1u])),
            f32(atomicLoad(&sums[first + 2u])), f32(atomicLoad(&sums[first + 3u])),
        ) / AREA_SCALE;
    }
    for (var i = 0u; i < 6u; i++) {
        opacity[11u * index + 2u + i] = closed_face(cell, index, i / 2u, i % 2u);
    }
    for (var axis = 0u; axis < 3u; axis++) {
        let first = 44u * index + 32u + 3u * axis;
        let sum = vec3f(vec3i(atomicLoad(&sums[first]), atomicLoad(&sums[first + 1u]), atomicLoad(&sums[first + 2u])));
        opacity[11u * index + 8u + axis] = vec4f(sum / max(length(sum), 1e-12), 0.0);
    }
}
