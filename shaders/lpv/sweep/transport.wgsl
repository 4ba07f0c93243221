// One slice of the sweep: light of all directions whose dominant axis is AXIS goes on by one slice of cells, upwind to
// downwind, and is added to the irradiance of the cells that it leaves (discrete ordinates with upwind interpolation).
//
// For direction d, s_u = |d_u|/|d_AXIS| and s_v likewise, p the slice before, u_m and v_m the upwind neighbours:
//   arriving = (1−s_u)(1−s_v)·L[u,v] + s_u(1−s_v)·τ_u·L[u_m,v] + (1−s_u)s_v·τ_v·L[u,v_m] + s_u s_v·τ_uv·L[u_m,v_m]
//   L_in  = τ_AXIS·arriving
//   L_out = (1−α)·L_in + F·max(0, n·d)/(π h² |d_AXIS|),  α = min(1, √(dᵀTd·tr T)/|d_AXIS|)
// τ is 1 − a of the face that is crossed if its normal faces the light, else 1; τ_uv is the mean of both ways around
// the corner.

#import lightwell::volume::{Volume, cell_index}

struct Slice {
    forward: i32,          // slices gone from the lower border; negative: this sense rests
    backward: i32,         // and from the upper border
    quarter: u32,          // directions of one quadrant: a group has four quadrants
    padding: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> slice: Slice;
// Unit direction and weight [sr]; by axis, sense, quadrant.
@group(0) @binding(2) var<storage, read> directions: array<vec4f>;
@group(0) @binding(3) var<storage, read> opacity: array<vec4f>;
@group(0) @binding(4) var<storage, read> emission: array<vec4f>;
// L_out of the slice before and of this one [W/(m² sr)]: sense, direction, v, u.
// and, in the fourth place, the flux that the cell took out of the light, without regard to colour [W/m²].
@group(0) @binding(5) var<storage, read> before: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> after: array<vec4f>;
// Irradiance [W/m²] by cell, normal and channel: for +x −x +y −y +z −z, and for the normals of the surfaces that look
// their light up in the cell, by nearest axis. For its own normal a surface gets the exact cosine integral over all
// directions. Spherical harmonics of order 3 would give it 9 % of the light that only grazes it and 6 % of what comes
// from behind, its own included, which can be ten times all that it receives. Behind the irradiance of all cells `axes`
// holds what each took out of the light [W/m²].
@group(0) @binding(7) var<storage, read_write> axes: array<f32>;
@group(0) @binding(8) var<storage, read_write> facing: array<f32>;
// Radiance that enters from outside along each direction [W/(m² sr)].
@group(0) @binding(9) var<storage, read> border: array<vec4f>;

#ifdef AXIS
const A: u32 = #{AXIS}u;
#else
const A: u32 = 0u;
#endif
const U: u32 = (A + 1u) % 3u;
const V: u32 = (A + 2u) % 3u;

fn cell_of(along: i32, u: i32, v: i32) -> vec3u {
    var cell: vec3u;
    cell[A] = u32(along);
    cell[U] = u32(u);
    cell[V] = u32(v);
    return cell;
}

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
    let here = select(step, size[A] - 1 - step, is_backward);
    let past = select(step - 1, size[A] - step, is_backward);
    let has_here = step < size[A];
    let has_past = step > 0;
    let side = select(0u, 1u, is_backward);
    let sense = thread.z;
    let count = 4u * slice.quarter;
    let group = (2u * A + sense) * count;
    let stride = u32(size[U] * size[V]);
    let size_product = volume.cells.x * volume.cells.y * volume.cells.z;
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
    var lost = 0.0;

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
            let direction = directions[group + i];
            let d = direction.xyz;
            let inverse = 1.0 / abs(d[A]);
            let s = vec2f(abs(d[U]), abs(d[V])) * inverse;
            let straight = (1.0 - s.x) * (1.0 - s.y);
            let base = front + i * stride;
            let outside = border[group + i].rgb;
            var arriving = outside;
            var sent = outside;
            if has_past {
                var left = outside;
                var low = outside;
                var corner = outside;
                if has_um { left = before[base + u32(v * size[U] + um)].rgb; }
                if has_vm { low = before[base + u32(vm * size[U] + u)].rgb; }
                if has_um && has_vm { corner = before[base + u32(vm * size[U] + um)].rgb; }
                let tau_u = open(face_u, d);
                let tau_v = open(face_v, d);
                let tau_uv = 0.5 * (open(face_u_at_vm, d) * tau_v + open(face_v_at_um, d) * tau_u);
                let own_column = before[base + at];
                lost += own_column.a;
                left *= s.x * (1.0 - s.y);
                low *= (1.0 - s.x) * s.y;
                corner *= s.x * s.y;
                sent = straight * own_column.rgb + left + low + corner;
                arriving = straight * own_column.rgb + tau_u * left + tau_v * low + tau_uv * corner;
                // What reaches the downwind face of the cell before, less what the cell itself sends out, and before
                // the seal: the irradiance of a surface that closes that face.
                var w = direction.w * arriving;
                if gone.is_lit {
                    w += direction.w * beside(gone, d);
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
                let taken = sent - leaving;
                if own.is_lit {
                    leaving += emitted(own, d);
                }
                after[base + at] = vec4f(leaving, direction.w * abs(d[A]) * (taken.r + taken.g + taken.b));
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
        axes[18u * size_product + cell] += lost;
        add_facing(9u * cell, facing_x);
        add_facing(9u * cell + 3u, facing_y);
        add_facing(9u * cell + 6u, facing_z);
    }
}
