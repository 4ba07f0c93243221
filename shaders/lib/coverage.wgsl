#define_import_path lightwell::coverage

// Coverage of faces by surfaces, in three times the fineness of the cells, see `indirect/light_volumes/sweep/coverage.wgsl`, and ways past them. A cell is what light does
// at its centre; the part of a room that a surface faces may have no centre of a cell within reach, as where two walls
// meet at a sharp angle, and the next centre may lie behind one of them.
//
// Lengths are in cells, and those named `part` in thirds of them.

#import lightwell::sweep::{BEFORE, nearest_axis}
#import lightwell::volume::{Volume, cell_index}

// Parts of a cell along an axis. An odd number: so the middle column of parts holds the line through the cells' centres.
const PARTS: u32 = 3u;

// Six words a cell, by axis, and by whether light along +axis or −axis is stopped; a bit for the lower face of each part.
#ifdef FORWARD
@group(3) @binding(4) var<storage, read> coverage: array<u32>;
#else
@group(0) @binding(14) var<storage, read> coverage: array<u32>;
#endif

fn wall_word(volume: Volume, part: vec3u, axis: u32, side: u32) -> u32 {
    return 6u * cell_index(volume, part / PARTS) + 2u * axis + side;
}

fn wall_bit(part: vec3u) -> u32 {
    let within = part % PARTS;
    return 1u << ((within.z * PARTS + within.y) * PARTS + within.x);
}

// Whether the lower face of a part is closed from either side.
fn is_walled(volume: Volume, part: vec3u, axis: u32) -> bool {
    let first = wall_word(volume, part, axis, 0u);
    return ((coverage[first] | coverage[first + 1u]) & wall_bit(part)) != 0u;
}

// Whether walls close the lower face of a cell: they cross the line between its centre and that of the cell before it.
fn is_face_walled(volume: Volume, cell: vec3u, axis: u32, side: u32) -> bool {
    var part = PARTS * cell + PARTS / 2u;
    var met = 0u;
    for (var i = 0u; i < PARTS && part[axis] < PARTS * volume.cells[axis]; i++) {
        met |= coverage[wall_word(volume, part, axis, side)] & wall_bit(part);
        part[axis] -= 1u;
    }
    return met != 0u;
}

// The part just before a surface: the first along its normal whose centre lies before it.
fn part_before(x: vec3f, n: vec3f) -> vec3i {
    let at = f32(PARTS) * (x + BEFORE * n);
    let axis = nearest_axis(n);
    var part = floor(at);
    for (var i = 0u; i < 2u; i++) {
        if dot(n, part + 0.5 - at) < 0.0 {
            part[axis] += sign(n[axis]);
        }
    }
    return vec3i(part);
}

// Whether steps along one axis from part to part meet no wall.
fn is_way_free(volume: Volume, start: vec3i, axis: u32, count: i32) -> bool {
    var part = start;
    for (var i = 0; i < abs(count); i++) {
        var face = part;
        if count > 0 {
            face[axis] += 1;
            part[axis] += 1;
        } else {
            part[axis] -= 1;
        }
        if any(face < vec3i(0)) || any(face >= vec3i(PARTS * volume.cells)) {
            continue;
        }
        if is_walled(volume, vec3u(face), axis) {
            return false;
        }
    }
    return true;
}

// Whether the centre of a cell is reached from a part before a surface with normal n: first along the axes that lead away
// from the surface, then along the others, so that the surface itself is never in the way.
fn is_reached(volume: Volume, start: vec3i, n: vec3f, cell: vec3f) -> bool {
    let goal = vec3i(cell) * i32(PARTS) + i32(PARTS) / 2;
    let count = goal - start;
    let away = n * vec3f(count);
    var order = vec3u(0u, 1u, 2u);
    if away[order.x] < away[order.y] { order = order.yxz; }
    if away[order.y] < away[order.z] { order = order.xzy; }
    if away[order.x] < away[order.y] { order = order.yxz; }
    var part = start;
    for (var i = 0u; i < 3u; i++) {
        let axis = order[i];
        if !is_way_free(volume, part, axis, count[axis]) {
            return false;
        }
        part[axis] = goal[axis];
    }
    return true;
}

// Which of the eight cells around a point half a cell before a surface are before it and are reached, a bit each.
fn reached_around(volume: Volume, x: vec3f, n: vec3f) -> u32 {
    let start = part_before(x, n);
    let low = floor(x + 0.5 * n - 0.5);
    var reached = 0u;
    for (var i = 0u; i < 8u; i++) {
        let cell = low + vec3f(f32(i & 1u), f32((i >> 1u) & 1u), f32(i >> 2u));
        if dot(n, cell + 0.5 - x) > 0.0 && is_reached(volume, start, n, cell) {
            reached |= 1u << i;
        }
    }
    return reached;
}

// The cell that light of a surface would leave from if no other were near: the first whose centre lies before the surface.
// Behind a thin wall is another room: there that is made sure of.
fn source_cell(x: vec3f, n: vec3f, is_thin: bool) -> vec3f {
    let before = x + BEFORE * n;
    if !is_thin {
        return floor(before + 0.5 * n);
    }
    let axis = nearest_axis(n);
    var cell = floor(before);
    for (var i = 0u; i < 2u; i++) {
        if dot(n, cell + 0.5 - before) < 0.0 {
            cell[axis] += sign(n[axis]);
        }
    }
    return cell;
}

// A cell that stands for a part of surface, if any is reached.
struct Linked {
    cell: vec3f,
    is_any: bool,
}

// The cell that light of a surface leaves from: the one that is wanted, or the nearest that is reached to the place half a
// cell before the surface.
fn linked_cell(volume: Volume, x: vec3f, n: vec3f, wanted: vec3f) -> Linked {
    let start = part_before(x, n);
    if is_reached(volume, start, n, wanted) {
        return Linked(wanted, true);
    }
    let around = floor(x + BEFORE * n);
    var nearest = Linked(wanted, false);
    var least = 1e9;
    for (var i = 0u; i < 27u; i++) {
        let cell = around + vec3f(f32(i % 3u), f32(i / 3u % 3u), f32(i / 9u)) - 1.0;
        let way = cell + 0.5 - x;
        let off = way - 0.5 * n;
        let distance = dot(off, off);
        if dot(n, way) > 0.0 && distance < least && is_reached(volume, start, n, cell) {
            nearest = Linked(cell, true);
            least = distance;
        }
    }
    return nearest;
}
