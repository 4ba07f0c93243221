// The sweep: light of all directions whose dominant axis is AXIS goes through a grid, slice by slice, upwind to downwind
// (discrete ordinates with upwind interpolation). A workgroup has a few directions of one quadrant and marches through
// all slices by itself; what arrives at each cell is kept for indirect/light_volumes/sweep/collect.wgsl.
//
// For direction d, s_u = |d_u|/|d_AXIS| and s_v likewise, p the slice before, u_m and v_m the upwind neighbours:
//   arriving = (1−s_u)(1−s_v)·L[u,v] + s_u(1−s_v)·τ_u·L[u_m,v] + (1−s_u)s_v·τ_v·L[u,v_m] + s_u s_v·τ_uv·L[u_m,v_m]
//   L_in  = τ_AXIS·arriving
//   L_out = (1−α)·L_in + F·max(0, n·d)/(π h² |d_AXIS|),  α = min(1, √(dᵀTd·tr T)/|d_AXIS|)
// τ is 1 − a of the face that is crossed if its normal faces the light, else 1; τ_uv is that of the more open way around
// the corner: light along a slanting wall passes the steps that cells make of it.
//
// Cascades are nested: what leaves the cells of the coarser one that lie around the finer one, its shell, enters the
// finer one.
// Where media absorb light (HAZE), L_in is less by exp(−σₐ·h/|d_AXIS|), and what they scatter straight from the lights is a source.
//   NO_OUTER  no coarser cascade lies around this one
//   NO_INNER  no finer one lies in it

#import lightwell::volume::{Volume, cell_index}
#import lightwell::sweep_transport::{Ordinate, Source, source_from, emitted, expose, to_stored, from_stored, from_outer}

// Light as it is stored.
#ifdef HALF
alias Stored = vec2u;
#else
alias Stored = vec4f;
#endif

struct March {
    inner_low: vec3i,      // first cell of this cascade that the next finer one covers
    quarter: u32,          // directions of one quadrant: two senses have four quadrants each
    inner_size: vec3i,     // how many of its cells that one covers
    chunk: u32,            // directions of a workgroup
    first: u32,            // the first workgroup of this dispatch, among those of the axis
    arrivals: u32,         // where in `arrivals` those of this dispatch begin
    turn: u32,             // half of the fronts' length
    brightest: f32,        // radiance of the brightest direction beyond the border [W/(m² sr)]
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> march: March;
// By axis, sense, quadrant.
@group(0) @binding(2) var<storage, read> ordinates: array<Ordinate>;
@group(0) @binding(3) var<storage, read> opacity: array<vec4f>;
@group(0) @binding(4) var<storage, read> emission: array<vec4f>;
// L_out of the slice before and of this one [W/(m² sr)], alternately: workgroup, direction, v, u.
@group(0) @binding(5) var<storage, read_write> fronts: array<Stored>;
// What arrives at the downwind face of each cell [W/(m² sr)]: workgroup, direction, cell.
@group(0) @binding(6) var<storage, read_write> arrivals: array<Stored>;
// L_out of the shells for the directions of this axis [W/(m² sr)]: sense, direction, place in the shell.
#ifndef NO_OUTER
@group(0) @binding(7) var<storage, read> outer_shell: array<Stored>;
#endif
#ifndef NO_INNER
@group(0) @binding(8) var<storage, read_write> inner_shell: array<Stored>;
#endif

const THREADS: u32 = 256u;

#ifdef AXIS
const A: u32 = #{AXIS}u;
#else
const A: u32 = 0u;
#endif
const U: u32 = (A + 1u) % 3u;
const V: u32 = (A + 2u) % 3u;

fn place_of(slice: i32, u: i32, v: i32) -> vec3i {
    var cell: vec3i;
    cell[A] = slice;
    cell[U] = u;
    cell[V] = v;
    return cell;
}

fn cell_of(slice: i32, u: i32, v: i32) -> vec3u {
    return vec3u(place_of(slice, u, v));
}

// Cells of the shell around a box of n cells: the faces of a box of n + 2.
fn shell_size(n: vec3u) -> u32 {
    let m = n + 2u;
    return 2u * (m.y * m.z + m.z * m.x + m.x * m.y);
}

// The place in the shell of a cell g of that larger box.
fn shell_place(g: vec3u, n: vec3u) -> u32 {
    let m = n + 2u;
    let faces = vec3u(m.y * m.z, m.z * m.x, m.x * m.y);
    if g.x == 0u || g.x == n.x + 1u {
        return select(faces.x, 0u, g.x == 0u) + g.z * m.y + g.y;
    }
    if g.y == 0u || g.y == n.y + 1u {
        return 2u * faces.x + select(faces.y, 0u, g.y == 0u) + g.x * m.z + g.z;
    }
    return 2u * (faces.x + faces.y) + select(faces.z, 0u, g.z == 0u) + g.y * m.x + g.x;
}

// L_out of a column of the slice before: `direction` counts both senses of the axis, `first` is where its front begins.
fn light_before(direction: u32, first: u32, past: i32, u: i32, v: i32, border: vec3f) -> vec3f {
    let size = vec3i(volume.cells);
    let cell = place_of(past, u, v);
    if all(cell >= vec3i(0)) && all(cell < size) {
        return from_stored(fronts[first + u32(v * size[U] + u)]);
    }
#ifdef NO_OUTER
    return border;
#else
    // Two cells for one of the coarser cascade.
    let n = volume.cells / 2u;
    return from_outer(outer_shell[direction * shell_size(n) + shell_place(vec3u((cell + 2) / 2), n)]);
#endif
}

#ifndef NO_INNER
// 1 before an opening, 0 before a wall that closes a face.
fn no_wall(f: vec4f, d: vec3f) -> f32 {
    return smoothstep(0.0, 0.3, open(f, d));
}

// What leaves a cell of the shell for the finer cascade. Its upper borders have no faces of their own; and a wall along
// a border may close the faces beyond it here, and those before it there: so it counts as far as one cell inside.
fn into_shell(direction: u32, cell: vec3i, d: vec3f, leaving: vec3f) {
    let n = vec3u(march.inner_size);
    let g = cell - march.inner_low + 1;
    let last = march.inner_size + 1;
    if any(g < vec3i(0)) || any(g > last) || (all(g > vec3i(0)) && all(g < last)) {
        return;
    }
    var light = leaving;
    for (var axis = 0u; axis < 3u; axis++) {
        var onward = cell;
        if g[axis] == 0 && d[axis] > 0.0 {
            onward[axis] += 1;
            light *= no_wall(face(vec3u(onward), axis, 0u), d);
            onward[axis] += 1;
            light *= no_wall(face(vec3u(onward), axis, 0u), d);
        }
        if g[axis] == last[axis] && d[axis] < 0.0 {
            light *= open(face(vec3u(onward), axis, 1u), d);
            onward[axis] -= 1;
            light *= no_wall(face(vec3u(onward), axis, 1u), d);
        }
    }
    inner_shell[direction * shell_size(n) + shell_place(vec3u(g), n)] = to_stored(light);
}
#endif

// The lower face of a cell along an axis, for light along +axis (side 0) or −axis (side 1).
fn face(cell: vec3u, axis: u32, side: u32) -> vec4f {
    if any(cell >= volume.cells) {
        return vec4f(0.0);
    }
    return opacity[11u * cell_index(volume, cell) + 2u + 2u * axis + side];
}

fn open(f: vec4f, d: vec3f) -> f32 {
    return select(1.0, 1.0 - f.w, dot(f.xyz, d) < 0.0);
}

fn source_of(cell: vec3u) -> Source {
    let at = 6u * cell_index(volume, cell);
    return source_from(
        emission[at], emission[at + 1u], emission[at + 2u], emission[at + 3u], emission[at + 4u], emission[at + 5u]
    );
}

// Which directions a workgroup has.
struct Chunk {
    sense: u32,            // 0 along the axis, 1 against it
    side_u: u32,           // 1 against u
    side_v: u32,
    first: u32,            // direction, counted over both senses of the axis
    count: u32,
    group: u32,            // number of the workgroup in its dispatch
}

fn chunk_of(group: u32) -> Chunk {
    let a_quadrant = (march.quarter + march.chunk - 1u) / march.chunk;
    let number = march.first + group;
    let quadrant = number / a_quadrant;
    let begin = (number % a_quadrant) * march.chunk;
    let count = min(march.chunk, march.quarter - begin);
    return Chunk(quadrant >> 2u, quadrant & 1u, (quadrant >> 1u) & 1u, quadrant * march.quarter + begin, count, group);
}

// Opacity of the faces of the slice before that light of a quadrant crosses on its way to a column, and of the face that
// it crosses into this slice.
struct Faces {
    u: vec4f,
    v: vec4f,
    u_at_vm: vec4f,
    v_at_um: vec4f,
    ahead: vec4f,
}

fn faces_before(chunk: Chunk, past: i32, u: i32, v: i32, um: i32, vm: i32) -> Faces {
    let size = vec3i(volume.cells);
    let face_of_u = u + i32(chunk.side_u);
    let face_of_v = v + i32(chunk.side_v);
    var faces: Faces;
    faces.u = face(cell_of(past, face_of_u, v), U, chunk.side_u);
    faces.v = face(cell_of(past, u, face_of_v), V, chunk.side_v);
    if vm >= 0 && vm < size[V] {
        faces.u_at_vm = face(cell_of(past, face_of_u, vm), U, chunk.side_u);
    }
    if um >= 0 && um < size[U] {
        faces.v_at_um = face(cell_of(past, um, face_of_v), V, chunk.side_v);
    }
    return faces;
}

// One column advances by one slice. `before` and `after` are where the fronts of the workgroup begin.
fn advance(chunk: Chunk, step: i32, u: i32, v: i32, before: u32, after: u32) {
    let size = vec3i(volume.cells);
    let is_backward = chunk.sense == 1u;
    let here = select(step, size[A] - 1 - step, is_backward);
    let past = select(step - 1, size[A] - step, is_backward);
    let has_here = step < size[A];
    let has_past = step > 0;
    let um = select(u - 1, u + 1, chunk.side_u == 1u);
    let vm = select(v - 1, v + 1, chunk.side_v == 1u);
    let stride = u32(size[U] * size[V]);
    let cells = volume.cells.x * volume.cells.y * volume.cells.z;

    var tensor = vec4f(0.0);
    var mixed = vec2f(0.0);
    var own: Source;
    var faces: Faces;
    if has_past {
        faces = faces_before(chunk, past, u, v, um, vm);
    }
    if has_here {
        let cell = cell_of(here, u, v);
        let first = 11u * cell_index(volume, cell);
        tensor = opacity[first];
        mixed = opacity[first + 1u].xy;
        own = source_of(cell);
    }
    if is_backward {
        if has_past { faces.ahead = face(cell_of(past, u, v), A, 1u); }
    } else if has_here {
        faces.ahead = face(cell_of(here, u, v), A, 0u);
    }
    let trace = tensor.x + tensor.y + tensor.z;

    for (var i = 0u; i < chunk.count; i++) {
        let direction = chunk.first + i;
        let ordinate = ordinates[8u * A * march.quarter + direction];
        let d = ordinate.direction;
        let inverse = 1.0 / abs(d[A]);
        let s = vec2f(abs(d[U]), abs(d[V])) * inverse;
        let straight = (1.0 - s.x) * (1.0 - s.y);
        let base = before + i * stride;
        let own_column = light_before(direction, base, past, u, v, ordinate.border);
        let left = s.x * (1.0 - s.y) * light_before(direction, base, past, um, v, ordinate.border);
        let low = (1.0 - s.x) * s.y * light_before(direction, base, past, u, vm, ordinate.border);
        let corner = s.x * s.y * light_before(direction, base, past, um, vm, ordinate.border);
        let tau_u = open(faces.u, d);
        let tau_v = open(faces.v, d);
        let tau_uv = max(open(faces.u_at_vm, d) * tau_v, open(faces.v_at_um, d) * tau_u);
        let arriving = straight * own_column + tau_u * left + tau_v * low + tau_uv * corner;
        if has_past {
            let first = march.arrivals + (chunk.group * march.chunk + i) * cells;
            arrivals[first + cell_index(volume, cell_of(past, u, v))] = to_stored(arriving);
        }
        if has_here {
            let squared = dot(tensor.xyz, d * d) + 2.0 * dot(vec3f(tensor.w, mixed), d * d.yzx);
            let alpha = min(1.0, sqrt(max(0.0, squared * trace)) * inverse);
            let entering = open(faces.ahead, d) * arriving;
            var leaving = (1.0 - alpha) * entering;
#ifdef HAZE
            leaving *= exp(-own.absorbed * inverse);
#endif
            if own.is_lit {
                leaving += emitted(own, d, d[A]);
            }
            fronts[after + i * stride + u32(v * size[U] + u)] = to_stored(leaving);
#ifndef NO_INNER
            into_shell(direction, place_of(here, u, v), d, leaving);
#endif
        }
    }
}

@compute @workgroup_size(THREADS)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    expose(emission[6u * volume.cells.x * volume.cells.y * volume.cells.z].xy + march.brightest);
    let chunk = chunk_of(group.x);
    let columns = volume.cells[U] * volume.cells[V];
    let fronts_of_group = chunk.group * march.chunk * columns;
    for (var step = 0u; step <= volume.cells[A]; step++) {
        let turn = step & 1u;
        let before = turn * march.turn + fronts_of_group;
        let after = (1u - turn) * march.turn + fronts_of_group;
        for (var at = thread; at < columns; at += THREADS) {
            advance(chunk, i32(step), i32(at % volume.cells[U]), i32(at / volume.cells[U]), before, after);
        }
        storageBarrier();
    }
}
