// Walls between cells: which faces of the cells a surface closes, found by drawing the scene along each axis with a pixel
// for each column of cells. A pixel is covered where a surface crosses the line through the centres of its column, so that
// surfaces without gaps close a set of faces without gaps: the rasterizer draws no pixel along an edge that two triangles
// share twice, and leaves none out.

#import lightwell::mesh::{Vertex, Instance, world_from_object_point}
#import lightwell::sweep::BEFORE
#import lightwell::volume::{Volume, cell_index}

@group(0) @binding(0) var<uniform> view: Volume;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
// A word for each cell; of its lower face along an axis bit 2·axis is set by surfaces that stop light along +axis, and
// the bit after it by those that stop light along −axis.
@group(1) @binding(0) var<storage, read_write> walls: array<atomic<u32>>;

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

fn close(in: Varying, faces_up: bool, bits: u32) {
    let along = i32(round(in.along + select(-BEFORE, BEFORE, faces_up)));
    let column = vec2u(in.clip.xy);
    if along < 0 || u32(along) >= view.cells[A] || column.x >= view.cells[U] || column.y >= view.cells[V] {
        return;
    }
    var cell: vec3u;
    cell[A] = u32(along);
    cell[U] = column.x;
    // Rows of pixels count downwards.
    cell[V] = view.cells[V] - 1u - column.y;
    atomicOr(&walls[cell_index(view, cell)], bits << (2u * A));
}

@fragment
fn one_sided(in: Varying, @builtin(front_facing) front: bool) {
    close(in, front, select(1u, 2u, front));
}

@fragment
fn double_sided(in: Varying, @builtin(front_facing) front: bool) {
    close(in, front, 3u);
}
