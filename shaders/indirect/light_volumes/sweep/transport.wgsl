// One slice of the sweep: light of all directions whose dominant axis is AXIS goes on by one slice of cells, upwind to
// downwind, and is added to the irradiance of the cells that it leaves (discrete ordinates with upwind interpolation).
//
// For direction d, s_u = |d_u|/|d_AXIS| and s_v likewise, p the slice before, u_m and v_m the upwind neighbours:
//   arriving = (1−s_u)(1−s_v)·L[u,v] + s_u(1−s_v)·τ_u·L[u_m,v] + (1−s_u)s_v·τ_v·L[u,v_m] + s_u s_v·τ_uv·L[u_m,v_m]
//   L_in  = τ_AXIS·arriving
//   L_out = (1−α)·L_in + F·max(0, n·d)/(π h² |d_AXIS|),  α = min(1, √(dᵀTd·tr T)/|d_AXIS|)
// τ is 1 − a of the face that is crossed if its normal faces the light, else 1; τ_uv is that of the more open way around
// the corner: light along a slanting wall passes the steps that cells make of it.
//
// Cascades are nested: what leaves the cells of the coarser one that lie around the finer one, its shell, enters the
// finer one. NO_OUTER: no coarser cascade lies around this one. NO_INNER: no finer one lies in it. HALF: light on its way
// is kept in half precision; all that is summed up stays in single.

#import lightwell::volume::{Volume, cell_index}

struct Slice {
    inner_low: vec3i,      // first cell of this cascade that the next finer one covers
    forward: i32,          // slices gone from the lower border; negative: this sense rests
    inner_size: vec3i,     // how many of its cells that one covers
    backward: i32,         // slices gone from the upper border
    quarter: u32,          // directions of one quadrant: a group has four quadrants
    before: u32,           // where in `fronts` the slice before is
    after: u32,            // and this one
    brightest: f32,        // radiance of the brightest direction beyond the border [W/(m² sr)]
}

struct Ordinate {
    direction: vec3f,      // unit
    weight: f32,           // [sr]
    border: vec3f,         // radiance that enters from outside of the coarsest cascade [W/(m² sr)]
    padding: f32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> slice: Slice;
// By axis, sense, quadrant.
@group(0) @binding(2) var<storage, read> ordinates: array<Ordinate>;
@group(0) @binding(3) var<storage, read> opacity: array<vec4f>;
@group(0) @binding(4) var<storage, read> emission: array<vec4f>;
// L_out of the slice before and of this one [W/(m² sr)]: sense, direction, v, u; nothing in the fourth place.
@group(0) @binding(5) var<storage, read_write> fronts: array<Stored>;
// Irradiance [W/m²] by cell, normal and channel: for +x −x +y −y +z −z, and for the normals of the surfaces that look
// their light up in the cell, by nearest axis. For its own normal a surface gets the exact cosine integral over all
// directions. Spherical harmonics of order 3 would give it 9 % of the light that only grazes it and 6 % of what comes
// from behind, its own included, which can be ten times all that it receives.
@group(0) @binding(7) var<storage, read_write> axes: array<f32>;
@group(0) @binding(8) var<storage, read_write> facing: array<f32>;
// L_out of the shells for the directions of this axis [W/(m² sr)]: sense, direction, place in the shell.
#ifndef NO_OUTER
@group(0) @binding(9) var<storage, read> outer_shell: array<Stored>;
#endif
#ifndef NO_INNER
@group(0) @binding(10) var<storage, read_write> inner_shell: array<Stored>;
#endif

#ifdef HALF
// A half has eleven bits from 2⁻¹⁴ up to 2¹⁶, and fewer below. The exposure, a power of two, lays the brightest source of
// any cell between 2⁵ and 2⁶: a thousand of them in a row do not reach the end, and the eleven bits last down to the
// millionth part of one. What is brighter still is held there.
alias Stored = vec2u;

var<private> exposure: f32 = 1.0;        // of this cascade; the other two are one by the exposure
var<private> unexposed: f32 = 1.0;
var<private> outer_unexposed: f32 = 1.0; // of the next coarser cascade

// Exponent bits of the exposure for a peak in [2ᵉ⁻¹²⁷, 2ᵉ⁻¹²⁶) are those of 2¹³²⁻ᵉ.
fn exposure_bits(peak: f32) -> u32 {
    return clamp(259u - ((bitcast<u32>(peak) >> 23u) & 255u), 6u, 248u);
}

fn power_of_two(bits: u32) -> f32 {
    return bitcast<f32>(bits << 23u);
}

// Behind the emission of all cells stand the brightest source of this cascade and the coarser ones, and of those alone.
fn expose() {
    let peaks = emission[6u * volume.cells.x * volume.cells.y * volume.cells.z].xy + slice.brightest;
    let bits = exposure_bits(peaks.x);
    exposure = power_of_two(bits);
    unexposed = power_of_two(254u - bits);
    outer_unexposed = power_of_two(254u - exposure_bits(peaks.y));
}

fn to_stored(light: vec3f) -> Stored {
    let exposed = min(light * exposure, vec3f(65504.0));
    return vec2u(pack2x16float(exposed.xy), pack2x16float(vec2f(exposed.z, 0.0)));
}

fn from_stored(stored: Stored) -> vec3f {
    return vec3f(unpack2x16float(stored.x), unpack2x16float(stored.y).x) * unexposed;
}

fn from_outer(stored: Stored) -> vec3f {
    return vec3f(unpack2x16float(stored.x), unpack2x16float(stored.y).x) * outer_unexposed;
}
#else
alias Stored = vec4f;

fn expose() {
}

fn to_stored(light: vec3f) -> Stored {
    return vec4f(light, 0.0);
}

fn from_stored(stored: Stored) -> vec3f {
    return stored.rgb;
}

fn from_outer(stored: Stored) -> vec3f {
    return stored.rgb;
}
#endif

#ifdef AXIS
const A: u32 = #{AXIS}u;
#else
const A: u32 = 0u;
#endif
const U: u32 = (A + 1u) % 3u;
const V: u32 = (A + 2u) % 3u;

fn place_of(along: i32, u: i32, v: i32) -> vec3i {
    var cell: vec3i;
    cell[A] = along;
    cell[U] = u;
    cell[V] = v;
    return cell;
}

fn cell_of(along: i32, u: i32, v: i32) -> vec3u {
    return vec3u(place_of(along, u, v));
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
    let n = vec3u(slice.inner_size);
    let g = cell - slice.inner_low + 1;
    let last = slice.inner_size + 1;
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

// Sources of a cell, by the axis that the normals lie nearest to: F/h² and whether it leaves in all directions alike;
// the mean normal.
struct Source {
    flux: mat3x4f,
    normal: mat3x3f,
    is_lit: bool,
}

fn source_of(cell: vec3u) -> Source {
    let first = 6u * cell_index(volume, cell);
    let flux = mat3x4f(emission[first], emission[first + 2u], emission[first + 4u]);
    let normal = mat3x3f(emission[first + 1u].xyz, emission[first + 3u].xyz, emission[first + 5u].xyz);
    let any_flux = flux[0].rgb + flux[1].rgb + flux[2].rgb;
    return Source(flux, normal, any_flux.r + any_flux.g + any_flux.b > 0.0);
}

// Radiance that a cell's own sources add to what leaves it.
fn emitted(source: Source, d: vec3f) -> vec3f {
    let cosine = max(vec3f(0.0), d * source.normal) * 0.318309886;
    let isotropic = vec3f(source.flux[0].a, source.flux[1].a, source.flux[2].a);
    let lobe = select(cosine, vec3f(0.0795774715), isotropic > vec3f(0.5)) / abs(d[A]);
    return source.flux[0].rgb * lobe.x + source.flux[1].rgb * lobe.y + source.flux[2].rgb * lobe.z;
}

// The part of it that surfaces along the way send out, which what arrives from the side does not hold yet.
fn beside(source: Source, d: vec3f) -> vec3f {
    let ahead = max(vec3f(0.0), d[A] * vec3f(source.normal[0][A], source.normal[1][A], source.normal[2][A]));
    let cosine = max(vec3f(0.0), max(vec3f(0.0), d * source.normal) - ahead) * 0.318309886;
    let isotropic = vec3f(source.flux[0].a, source.flux[1].a, source.flux[2].a);
    let lobe = select(cosine, vec3f(0.0397887358), isotropic > vec3f(0.5)) / abs(d[A]);
    return source.flux[0].rgb * lobe.x + source.flux[1].rgb * lobe.y + source.flux[2].rgb * lobe.z;
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

@compute @workgroup_size(8, 8, 1)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let size = vec3i(volume.cells);
    let u = i32(thread.x);
    let v = i32(thread.y);
    let is_backward = thread.z == 1u;
    let step = select(slice.forward, slice.backward, is_backward);
    if u >= size[U] || v >= size[V] || step < 0 || step > size[A] {
        return;
    }
    expose();
    let here = select(step, size[A] - 1 - step, is_backward);
    let past = select(step - 1, size[A] - step, is_backward);
    let has_here = step < size[A];
    let has_past = step > 0;
    let side = select(0u, 1u, is_backward);
    let sense = thread.z;
    let count = 4u * slice.quarter;
    let group = (2u * A + sense) * count;
    let stride = u32(size[U] * size[V]);
    let front = sense * count * stride;
    let at = u32(v * size[U] + u);

    var tensor = vec4f(0.0);
    var mixed = vec2f(0.0);
    var own: Source;
    var ahead = vec4f(0.0);
    if has_here {
        let cell = cell_of(here, u, v);
        let first = 11u * cell_index(volume, cell);
        tensor = opacity[first];
        mixed = opacity[first + 1u].xy;
        own = source_of(cell);
    }
    if is_backward {
        if has_past { ahead = face(cell_of(past, u, v), A, 1u); }
    } else if has_here {
        ahead = face(cell_of(here, u, v), A, 0u);
    }
    var gone: Source;
    var normals = mat3x3f();
    if has_past {
        let cell = cell_of(past, u, v);
        gone = source_of(cell);
        let first = 11u * cell_index(volume, cell) + 8u;
        normals = mat3x3f(opacity[first].xyz, opacity[first + 1u].xyz, opacity[first + 2u].xyz);
    }
    let trace = tensor.x + tensor.y + tensor.z;

    var px = vec3f(0.0); var mx = vec3f(0.0);
    var py = vec3f(0.0); var my = vec3f(0.0);
    var pz = vec3f(0.0); var mz = vec3f(0.0);
    var facing_x = vec3f(0.0);
    var facing_y = vec3f(0.0);
    var facing_z = vec3f(0.0);

    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let side_u = quadrant & 1u;
        let side_v = quadrant >> 1u;
        let um = select(u - 1, u + 1, side_u == 1u);
        let vm = select(v - 1, v + 1, side_v == 1u);
        let has_um = um >= 0 && um < size[U];
        let has_vm = vm >= 0 && vm < size[V];
        // Faces of the slice before that light of this quadrant crosses on its way to this column.
        var face_u = vec4f(0.0);
        var face_v = vec4f(0.0);
        var face_u_at_vm = vec4f(0.0);
        var face_v_at_um = vec4f(0.0);
        if has_past {
            let face_of_u = select(u, u + 1, side_u == 1u);
            let face_of_v = select(v, v + 1, side_v == 1u);
            face_u = face(cell_of(past, face_of_u, v), U, side_u);
            face_v = face(cell_of(past, u, face_of_v), V, side_v);
            if has_vm { face_u_at_vm = face(cell_of(past, face_of_u, vm), U, side_u); }
            if has_um { face_v_at_um = face(cell_of(past, um, face_of_v), V, side_v); }
        }
        for (var i = quadrant * slice.quarter; i < (quadrant + 1u) * slice.quarter; i++) {
            let ordinate = ordinates[group + i];
            let d = ordinate.direction;
            let inverse = 1.0 / abs(d[A]);
            let s = vec2f(abs(d[U]), abs(d[V])) * inverse;
            let straight = (1.0 - s.x) * (1.0 - s.y);
            let direction = sense * count + i;
            let base = slice.before + front + i * stride;
            let own_column = light_before(direction, base, past, u, v, ordinate.border);
            let left = s.x * (1.0 - s.y) * light_before(direction, base, past, um, v, ordinate.border);
            let low = (1.0 - s.x) * s.y * light_before(direction, base, past, u, vm, ordinate.border);
            let corner = s.x * s.y * light_before(direction, base, past, um, vm, ordinate.border);
            let tau_u = open(face_u, d);
            let tau_v = open(face_v, d);
            let tau_uv = max(open(face_u_at_vm, d) * tau_v, open(face_v_at_um, d) * tau_u);
            let arriving = straight * own_column + tau_u * left + tau_v * low + tau_uv * corner;
            if has_past {
                // What reaches the downwind face of the cell before, less what the cell itself sends out, and before
                // the seal: the irradiance of a surface that closes that face.
                var w = ordinate.weight * arriving;
                if gone.is_lit {
                    w += ordinate.weight * beside(gone, d);
                }
                px += max(0.0, -d.x) * w; mx += max(0.0, d.x) * w;
                py += max(0.0, -d.y) * w; my += max(0.0, d.y) * w;
                pz += max(0.0, -d.z) * w; mz += max(0.0, d.z) * w;
                let turned = max(vec3f(0.0), -(d * normals));
                facing_x += turned.x * w;
                facing_y += turned.y * w;
                facing_z += turned.z * w;
            }
            if has_here {
                let squared = dot(tensor.xyz, d * d) + 2.0 * dot(vec3f(tensor.w, mixed), d * d.yzx);
                let alpha = min(1.0, sqrt(max(0.0, squared * trace)) * inverse);
                let entering = open(ahead, d) * arriving;
                var leaving = (1.0 - alpha) * entering;
                if own.is_lit {
                    leaving += emitted(own, d);
                }
                fronts[slice.after + front + i * stride + at] = to_stored(leaving);
#ifndef NO_INNER
                into_shell(direction, place_of(here, u, v), d, leaving);
#endif
            }
        }
    }
    if has_past {
        let cell = cell_index(volume, cell_of(past, u, v));
        let first = 18u * cell;
        add_axis(first, px);
        add_axis(first + 3u, mx);
        add_axis(first + 6u, py);
        add_axis(first + 9u, my);
        add_axis(first + 12u, pz);
        add_axis(first + 15u, mz);
        add_facing(9u * cell, facing_x);
        add_facing(9u * cell + 3u, facing_y);
        add_facing(9u * cell + 6u, facing_z);
    }
}
