// Walls between the parts of cells: a cell has 3³, and which of their faces a surface closes is found by drawing the scene
// along each axis with a pixel for each column of parts. A pixel is covered where a surface crosses the line through the
// centres of its column, so that surfaces without gaps close a set of faces without gaps: the rasterizer draws no pixel
// along an edge that two triangles share twice, and leaves none out.

#import lightwell::mesh::{Vertex, Instance, world_from_object_point}
#import lightwell::sweep::BEFORE
#import lightwell::coverage::{PARTS, wall_bit, wall_word}
#import lightwell::volume::Volume

@group(0) @binding(0) var<uniform> view: Volume;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
// See `lib/coverage.wgsl`.
@group(1) @binding(0) var<storage, read_write> closed: array<atomic<u32>>;

#ifdef AXIS
const A: u32 = #{AXIS}u;
#else
const A: u32 = 0u;
#endif
const U: u32 = (A + 1u) % 3u;
const V: u32 = (A + 2u) % 3u;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) along: f32,
}

// Looks along −axis, so that what faces the viewer faces along the axis.
@vertex
fn vertex(in: Vertex, @builtin(instance_index) index: u32) -> Varying {
    let point = world_from_object_point(instances[index], in.position);
    let p = (point - view.origin) / view.cell;
    let size = vec3f(view.cells);
    var out: Varying;
    out.clip = vec4f(2.0 * p[U] / size[U] - 1.0, 2.0 * p[V] / size[V] - 1.0, (p[A] + 1.0) / (size[A] + 2.0), 1.0);
    out.along = p[A];
    return out;
}

fn close(in: Varying, faces_up: bool, side: u32) {
    let size = vec3i(PARTS * view.cells);
    var part: vec3i;
    part[A] = i32(round(f32(PARTS) * (in.along + select(-BEFORE, BEFORE, faces_up))));
    part[U] = i32(in.clip.x);
    // Rows of pixels count downwards.
    part[V] = size[V] - 1 - i32(in.clip.y);
    if all(part >= vec3i(0)) && all(part < size) {
        atomicOr(&closed[wall_word(view, vec3u(part), A, side)], wall_bit(vec3u(part)));
    }
}

@fragment
fn one_sided(in: Varying, @builtin(front_facing) front: bool) {
    close(in, front, select(0u, 1u, front));
}

@fragment
fn double_sided(in: Varying, @builtin(front_facing) front: bool) {
    close(in, front, 0u);
    close(in, front, 1u);
}
