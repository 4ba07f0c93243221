#define_import_path lightwell::sweep_lookup

// Irradiance at a point from a swept volume. FORWARD: the bindings of a raster pass, whose first groups are taken.

#import lightwell::sweep::nearest_axis
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
        if all(cell >= vec3f(0.0)) && all(cell < vec3f(volume.cells)) {
            let side = select(0u, 1u, from_above);
            open[axis] = 1.0 - opacity[11u * cell_index(volume, vec3u(cell)) + 2u + 2u * axis + side].w;
        }
    }
    return open;
}

// Irradiance where solids smaller than a cell fill the cells before a surface, so that no light is known there: that of
// the next cell further out that is clear of them. Capitals and feet of columns were black in places otherwise.
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

// Trilinear half a cell before the surface, over the cells whose centre lies before it: light in a cell is known where
// it leaves the cell, so that its mean place is the surface.
fn irradiance(volume: Volume, point: vec3f, n: vec3f) -> vec3f {
    return irradiance_around(volume, point, n, n);
}

// Irradiance before a surface with normal n, for another direction d.
fn irradiance_around(volume: Volume, point: vec3f, n: vec3f, d: vec3f) -> vec3f {
    let x = (point - volume.origin) / volume.cell;
    let at = x + 0.5 * n - 0.5;
    let low = floor(at);
    let t = at - low;
    let base = floor(x + 0.5 * n);
    let open = passages(volume, base, low);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let upper = vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
        let cell = select(low, low + 1.0, upper);
        let w = select(1.0 - t, t, upper);
        let weight = w.x * w.y * w.z;
        let is_inside = all(cell >= vec3f(0.0)) && all(cell < vec3f(volume.cells));
        if is_inside && weight > 0.0 && dot(n, cell + 0.5 - x) > 0.0 {
            let index = cell_index(volume, vec3u(cell));
            let passed = select(open, vec3f(1.0), cell == base);
            let clear = weight * clearance(index) * passed.x * passed.y * passed.z;
            if clear > 0.0 {
                sum += clear * of_cell(index, d);
                weights += clear;
            }
        }
    }
    if weights < 1e-3 {
        return beyond(volume, base, n, d);
    }
    return sum / weights;
}
