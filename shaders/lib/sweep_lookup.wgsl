#define_import_path lightwell::sweep_lookup

// Irradiance at a point from a swept volume. FORWARD: the bindings of a raster pass, whose first groups are taken.

#import lightwell::sweep::{BEFORE, LINKED, link_way, nearest_axis}
#import lightwell::volume::{Volume, cell_index}

#ifdef FORWARD
@group(3) @binding(1) var<storage, read> axes: array<f32>;
@group(3) @binding(2) var<storage, read> facing: array<f32>;
@group(3) @binding(3) var<storage, read> opacity: array<vec4f>;
#else
@group(0) @binding(1) var<storage, read> axes: array<f32>;
@group(0) @binding(2) var<storage, read> facing: array<f32>;
@group(0) @binding(12) var<storage, read> opacity: array<vec4f>;
#endif

fn axis_at(cell: u32, node: u32) -> vec3f {
    let first = 18u * cell + 3u * node;
    return vec3f(axes[first], axes[first + 1u], axes[first + 2u]);
}

fn facing_at(cell: u32, axis: u32) -> vec3f {
    let first = 9u * cell + 3u * axis;
    return vec3f(facing[first], facing[first + 1u], facing[first + 2u]);
}

// Irradiance for any normal from those of the axes: by the squares of its components, so that even light stays even,
// plus what makes the first harmonic exact, E(n) − E(−n) = V·n with the vector irradiance V that opposite axes differ
// by.
fn from_axes(cell: u32, n: vec3f) -> vec3f {
    let square = n * n;
    let rest = 0.5 * (abs(n) - square);
    var e = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        let behind = select(0u, 1u, n[i] >= 0.0);
        e += (square[i] + rest[i]) * axis_at(cell, 2u * i + 1u - behind) - rest[i] * axis_at(cell, 2u * i + behind);
    }
    return max(e, vec3f(0.0));
}

// Irradiance of a cell for a normal: what was gathered for the surface there, if it faces the same way.
fn of_cell(cell: u32, n: vec3f) -> vec3f {
    let axis = nearest_axis(n);
    let same = smoothstep(0.9, 0.97, dot(n, opacity[11u * cell + 8u + axis].xyz));
    var e = vec3f(0.0);
    if same > 0.0 {
        e += same * facing_at(cell, axis);
    }
    if same < 1.0 {
        e += (1.0 - same) * from_axes(cell, n);
    }
    return e;
}

// The share of a cell that lies outside of solids: those leave their tensor in the cells just below their surface.
// Without it a corner between a wall and a floor is dark, since half of its cells lie in the floor.
fn clearance(index: u32) -> f32 {
    return saturate(1.0 - opacity[11u * index + 1u].w);
}

// How open the faces are that light crosses from the other cells of an interpolation to the one before the surface.
fn passages(volume: Volume, base: vec3f, low: vec3f) -> vec3f {
    var open = vec3f(1.0);
    for (var axis = 0u; axis < 3u; axis++) {
        var cell = base;
        let from_above = base[axis] == low[axis];
        cell[axis] += select(0.0, 1.0, from_above);
        if inside(volume, cell) {
            let side = select(0u, 1u, from_above);
            open[axis] = 1.0 - opacity[11u * cell_index(volume, vec3u(cell)) + 2u + 2u * axis + side].w;
        }
    }
    return open;
}

// How far the cell before a surface says on which side the others lie. One that a solid fills for the most part is as dark
// as the solid, and its closed faces lead out of it: they part nothing from the surface.
fn trust(volume: Volume, base: vec3f) -> f32 {
    if !inside(volume, base) {
        return 1.0;
    }
    return smoothstep(0.3, 0.7, clearance(cell_index(volume, vec3u(base))));
}

fn inside(volume: Volume, cell: vec3f) -> bool {
    return all(cell >= vec3f(0.0)) && all(cell < vec3f(volume.cells));
}

// Mean irradiance, and the sum of the weights.
struct Gathered {
    sum: vec3f,
    weights: f32,
}

// Cells up to so far before a surface count less [cells], so that light has no step where a slanting surface passes a centre.
const BEFORE_FADE: f32 = 0.125;
// Width over which one cell before a surface takes over from the next [cells].
const TAKE_OVER: f32 = 0.5;

// How open the way is from the cell before a surface to each of the eight that are interpolated. Close to where the next cell
// becomes the one before the surface, that one speaks too, as far as it is open to this one: or light would have a step there.
fn visible_cells(volume: Volume, low: vec3f, before: vec3f) -> array<f32, 8> {
    let shown = saturate((before - low - 1.0) / TAKE_OVER + 0.5);
    let nearest = clamp(floor(before), low, low + 1.0);
    let way = passages(volume, nearest, low);
    var visible = array<f32, 8>();
    for (var k = 0u; k < 8u; k++) {
        let base = corner(low, k);
        let share = select(1.0 - shown, shown, is_upper(k)) * select(way, vec3f(1.0), base == nearest);
        let weight = share.x * share.y * share.z;
        if weight > 0.0 {
            let open = mix(vec3f(1.0), passages(volume, base, low), trust(volume, base));
            for (var i = 0u; i < 8u; i++) {
                let passed = select(vec3f(1.0), open, is_upper(i ^ k));
                visible[i] += weight * passed.x * passed.y * passed.z;
            }
        }
    }
    return visible;
}

// Of the eight cells around a point: on which axes one is the upper.
fn is_upper(i: u32) -> vec3<bool> {
    return vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
}

fn corner(low: vec3f, i: u32) -> vec3f {
    return select(low, low + 1.0, is_upper(i));
}

// Trilinear half a cell before the surface, over the cells whose centre lies before it: light in a cell is known where
// it leaves the cell, so that its mean place is the surface. The wall beside a point may pass through the point's cell
// and close the face behind it, so that the cell belongs to the other side. The way to the eye is free: the cell that
// it leads to is on the right side.
fn interpolated(volume: Volume, x: vec3f, n: vec3f, d: vec3f, to_eye: vec3f) -> Gathered {
    let at = x + 0.5 * n - 0.5;
    let low = floor(at);
    let t = at - low;
    var visible = visible_cells(volume, low, x + 0.5 * n + to_eye);
    var all_cells = Gathered(vec3f(0.0), 0.0);
    for (var i = 0u; i < 8u; i++) {
        let cell = corner(low, i);
        let w = select(1.0 - t, t, is_upper(i));
        let before = saturate(dot(n, cell + 0.5 - x) / BEFORE_FADE);
        let weight = before * w.x * w.y * w.z;
        if inside(volume, cell) && weight > 0.0 {
            let index = cell_index(volume, vec3u(cell));
            let clear = weight * clearance(index) * visible[i];
            if clear > 0.0 {
                all_cells.sum += clear * of_cell(index, d);
                all_cells.weights += clear;
            }
        }
    }
    return all_cells;
}

// The clear cells up to two away towards the eye, by their distance: beyond the surface's other neighbours may be another
// room.
fn nearby(volume: Volume, x: vec3f, n: vec3f, d: vec3f, to_eye: vec3f) -> Gathered {
    let at = x + 0.5 * n - 0.5;
    var all_cells = Gathered(vec3f(0.0), 0.0);
    for (var i = 0u; i < 64u; i++) {
        let cell = floor(at) - 1.0 + vec3f(f32(i & 3u), f32((i >> 2u) & 3u), f32(i >> 4u));
        let w = max(vec3f(0.0), 2.0 - abs(cell - at));
        let way = cell + 0.5 - x;
        if inside(volume, cell) && dot(n, way) > 0.0 && dot(to_eye, way) > 0.0 {
            let index = cell_index(volume, vec3u(cell));
            let clear = w.x * w.y * w.z * clearance(index);
            if clear > 0.0 {
                all_cells.sum += clear * of_cell(index, d);
                all_cells.weights += clear;
            }
        }
    }
    return all_cells;
}

// Cells that together weigh less than this hold too little of the room to speak for it.
const LEAST: f32 = 0.1;

// Irradiance where solids smaller than a cell fill all cells before a surface, so that no light is known there: that of
// the next cell further out that is clear of them.
fn beyond(volume: Volume, base: vec3f, n: vec3f, d: vec3f) -> vec3f {
    let last = vec3f(volume.cells) - 1.0;
    let axis = nearest_axis(n);
    var cell = clamp(base, vec3f(0.0), last);
    for (var i = 0u; i < 2u; i++) {
        cell[axis] = clamp(cell[axis] + sign(n[axis]), 0.0, last[axis]);
        if clearance(cell_index(volume, vec3u(cell))) > 0.1 {
            break;
        }
    }
    return of_cell(cell_index(volume, vec3u(cell)), d);
}

// Irradiance before a surface with normal n at a point [m], for another direction d. `to_eye` is the unit vector to the
// eye that sees it, or zero: surfels may be hidden in another solid. What is seen is never in the dark because the cells
// around it count as solid, as along the edges of a room that the grid cuts in halves: there the clear cells nearby fill
// in.
fn irradiance_around(volume: Volume, point: vec3f, n: vec3f, d: vec3f, to_eye: vec3f) -> vec3f {
    let x = (point - volume.origin) / volume.cell;
    var all_cells = interpolated(volume, x, n, d, to_eye);
    if all_cells.weights < LEAST && any(to_eye != vec3f(0.0)) {
        let more = nearby(volume, x, n, d, to_eye);
        if more.weights > 0.0 {
            let share = LEAST - all_cells.weights;
            all_cells.sum += more.sum * (share / more.weights);
            all_cells.weights = LEAST;
        }
    }
    if all_cells.weights < 1e-3 {
        return beyond(volume, floor(x + 0.5 * n), n, d);
    }
    return all_cells.sum / all_cells.weights;
}

// Irradiance of a surface, see `irradiance_around`.
fn irradiance(volume: Volume, point: vec3f, n: vec3f, to_eye: vec3f) -> vec3f {
    return irradiance_around(volume, point, n, n, to_eye);
}

// Irradiance of a surfel: of the cells before it that it is linked to (`indirect/light_volumes/sweep/links.wgsl`).
fn linked_irradiance(volume: Volume, point: vec3f, n: vec3f, link: u32) -> vec3f {
    let x = (point - volume.origin) / volume.cell;
    let at = x + 0.5 * n - 0.5;
    let low = floor(at);
    let t = at - low;
    var all_cells = Gathered(vec3f(0.0), 0.0);
    for (var i = 0u; i < 8u; i++) {
        let upper = vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
        let cell = select(low, low + 1.0, upper);
        let w = select(1.0 - t, t, upper);
        if ((link >> i) & 1u) != 0u && inside(volume, cell) {
            let index = cell_index(volume, vec3u(cell));
            let clear = w.x * w.y * w.z * clearance(index);
            if clear > 0.0 {
                all_cells.sum += clear * of_cell(index, n);
                all_cells.weights += clear;
            }
        }
    }
    if all_cells.weights >= 1e-3 {
        return all_cells.sum / all_cells.weights;
    }
    // Nothing of the room is known next to it.
    let cell = floor(x + BEFORE * n) + link_way(link);
    if (link & LINKED) == 0u || !inside(volume, cell) {
        return vec3f(0.0);
    }
    return of_cell(cell_index(volume, vec3u(cell)), n);
}

// Light around a point, whatever surfaces there are.
struct Fluence {
    mean: vec3f,           // radiance, the mean over all directions [W/(m² sr)]
    flux: mat3x3f,         // net flux along each axis [W/m²]
}

// Trilinear between the cells whose centres lie around a point [m] and that no wall parts from it. With the irradiance E of the
// six faces of a cell: J = Σ E/(6π), since Σ |ω·n| over the axes is 3/2 in the mean over all directions, and F = E(−n) − E(n).
fn fluence_at(volume: Volume, point: vec3f) -> Fluence {
    let x = clamp((point - volume.origin) / volume.cell, vec3f(0.01), vec3f(volume.cells) - 0.01);
    let low = floor(x - 0.5);
    let t = x - 0.5 - low;
    let base = floor(x);
    let open = passages(volume, base, low);
    var sum = Fluence(vec3f(0.0), mat3x3f(vec3f(0.0), vec3f(0.0), vec3f(0.0)));
    var weights = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let upper = vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
        let cell = select(low, low + 1.0, upper);
        let w = select(1.0 - t, t, upper);
        let passed = select(open, vec3f(1.0), cell == base);
        if !inside(volume, cell) {
            continue;
        }
        let index = cell_index(volume, vec3u(cell));
        // The point's own cell counts in any case.
        let least = select(0.0, 1e-4, all(cell == base));
        let weight = max(w.x * w.y * w.z * passed.x * passed.y * passed.z * clearance(index), least);
        if weight > 0.0 {
            weights += weight;
            for (var axis = 0u; axis < 3u; axis++) {
                let above = axis_at(index, 2u * axis);
                let below = axis_at(index, 2u * axis + 1u);
                sum.mean += weight * (above + below);
                sum.flux[axis] += weight * (below - above);
            }
        }
    }
    let scale = 1.0 / max(weights, 1e-30);
    return Fluence(sum.mean * (scale / 18.849556), sum.flux * scale);
}
