// Irradiance of the cells: the sum over all directions of what arrived there, in a fixed order.
//
// What reaches the downwind face of a cell, less what the cell itself sends out, and before the seal, is the irradiance of
// a surface that closes that face. It is summed up for +x −x +y −y +z −z, and for the normals of the surfaces that look
// their light up in the cell, by nearest axis. For its own normal a surface gets the exact cosine integral over all
// directions. Spherical harmonics of order 3 would give it 9 % of the light that only grazes it and 6 % of what comes
// from behind, its own included, which can be ten times all that it receives.

#import lightwell::volume::Volume
#import lightwell::sweep_transport::{Ordinate, Source, source_from, beside, expose, from_stored}

// Light as it is stored.
#ifdef HALF
alias Stored = vec2u;
#else
alias Stored = vec4f;
#endif

struct Part {
    first: u32,            // directions of an axis that are there, counted over both its senses
    end: u32,
    arrivals: u32,         // where theirs begin
    padding: u32,
}

struct Collect {
    parts: array<Part, 3>, // by axis
    quarter: u32,          // directions of one quadrant
    is_first: u32,         // nothing was summed up before
    brightest: f32,        // radiance of the brightest direction beyond the border [W/(m² sr)]
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> collect: Collect;
@group(0) @binding(2) var<storage, read> ordinates: array<Ordinate>;
@group(0) @binding(3) var<storage, read> opacity: array<vec4f>;
@group(0) @binding(4) var<storage, read> emission: array<vec4f>;
// By direction, cell [W/(m² sr)].
@group(0) @binding(5) var<storage, read> arrivals: array<Stored>;
// Irradiance [W/m²] by cell, normal and channel.
@group(0) @binding(6) var<storage, read_write> axes: array<f32>;
@group(0) @binding(7) var<storage, read_write> facing: array<f32>;

struct Sums {
    px: vec3f, mx: vec3f,
    py: vec3f, my: vec3f,
    pz: vec3f, mz: vec3f,
    facing_x: vec3f, facing_y: vec3f, facing_z: vec3f,
}

// What a cell is, for all directions.
struct Cell {
    index: u32,
    cells: u32,            // of the grid
    source: Source,
    normals: mat3x3f,      // of the surfaces that look up their light here
}

// The directions of one sense of an axis that are there.
fn sum_sense(cell: Cell, axis: u32, sense: u32) -> Sums {
    let part = collect.parts[axis];
    let count = 4u * collect.quarter;
    let end = min(part.end, (sense + 1u) * count);
    var sums: Sums;
    for (var direction = max(part.first, sense * count); direction < end; direction++) {
        let ordinate = ordinates[2u * axis * count + direction];
        let d = ordinate.direction;
        let arriving = from_stored(arrivals[part.arrivals + (direction - part.first) * cell.cells + cell.index]);
        var w = ordinate.weight * arriving;
        if cell.source.is_lit {
            w += ordinate.weight * beside(cell.source, d, axis);
        }
        sums.px += max(0.0, -d.x) * w; sums.mx += max(0.0, d.x) * w;
        sums.py += max(0.0, -d.y) * w; sums.my += max(0.0, d.y) * w;
        sums.pz += max(0.0, -d.z) * w; sums.mz += max(0.0, d.z) * w;
        let turned = max(vec3f(0.0), -(d * cell.normals));
        sums.facing_x += turned.x * w;
        sums.facing_y += turned.y * w;
        sums.facing_z += turned.z * w;
    }
    return sums;
}

fn add_axis(first: u32, value: vec3f) {
    axes[first] += value.r;
    axes[first + 1u] += value.g;
    axes[first + 2u] += value.b;
}

fn add_facing(first: u32, value: vec3f) {
    facing[first] += value.r;
    facing[first + 1u] += value.g;
    facing[first + 2u] += value.b;
}

fn add(cell: u32, sums: Sums) {
    add_axis(18u * cell, sums.px);
    add_axis(18u * cell + 3u, sums.mx);
    add_axis(18u * cell + 6u, sums.py);
    add_axis(18u * cell + 9u, sums.my);
    add_axis(18u * cell + 12u, sums.pz);
    add_axis(18u * cell + 15u, sums.mz);
    add_facing(9u * cell, sums.facing_x);
    add_facing(9u * cell + 3u, sums.facing_y);
    add_facing(9u * cell + 6u, sums.facing_z);
}

// Light along an axis and against it: first the sense whose border is nearer, so that a mirrored scene has the same bits.
fn add_both(cell: Cell, axis: u32, slice: u32) {
    if collect.parts[axis].end == collect.parts[axis].first {
        return;
    }
    let first = select(0u, 1u, 2u * slice + 1u > volume.cells[axis]);
    add(cell.index, sum_sense(cell, axis, first));
    add(cell.index, sum_sense(cell, axis, 1u - first));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = thread.x + thread.y * groups.x * 64u;
    let cells = volume.cells.x * volume.cells.y * volume.cells.z;
    if index >= cells {
        return;
    }
    expose(emission[6u * cells].xy + collect.brightest);
    var cell: Cell;
    cell.index = index;
    cell.cells = cells;
    let at = 6u * index;
    cell.source = source_from(
        emission[at], emission[at + 1u], emission[at + 2u], emission[at + 3u], emission[at + 4u], emission[at + 5u]
    );
    let first = 11u * index + 8u;
    cell.normals = mat3x3f(opacity[first].xyz, opacity[first + 1u].xyz, opacity[first + 2u].xyz);
    if collect.is_first == 1u {
        for (var i = 0u; i < 18u; i++) { axes[18u * index + i] = 0.0; }
        for (var i = 0u; i < 9u; i++) { facing[9u * index + i] = 0.0; }
    }
    add_both(cell, 0u, index % volume.cells.x);
    add_both(cell, 1u, (index / volume.cells.x) % volume.cells.y);
    add_both(cell, 2u, index / (volume.cells.x * volume.cells.y));
}
