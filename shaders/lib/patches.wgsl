#define_import_path lightwell::patches

// Patches of surfels: which one a point of a surface belongs to. See engine/world/src/scene/surfels/patches.rs.

#import lightwell::sampling::hash

// World to the cells of an object's grid, which turns with it, and where its cells are looked for in the table: first place,
// number of places, a power of two, and the first node.
struct PatchGrid {
    rows: array<vec4f, 3>,
    first: u32,
    places: u32,
    nodes: u32,
    pad_a: u32,
}

// A cell of an object's grid: what answers for each of the six ways that a surface may face, which is a patch, NO_PATCH, or
// PATCH_NODE and the index of a node. Or a node: a plane in the grid, as bits of floats, and what answers before and behind it.
struct PatchCell {
    patches: array<u32, 6>,
    tag: u32,
    is_used: u32,
}

// Places of a hash table with open addressing, then nodes, then places of another table for objects that bend. Index of the
// object by that of the primitive; all bits set: it has no surfels. FORWARD: in a raster pass, whose first groups are taken.
#ifdef FORWARD
@group(3) @binding(30) var<storage, read> patch_table: array<PatchCell>;
@group(3) @binding(31) var<storage, read> place_of_primitive: array<u32>;
@group(3) @binding(32) var<storage, read> patch_grids: array<PatchGrid>;
#else
@group(0) @binding(20) var<storage, read> patch_table: array<PatchCell>;
@group(0) @binding(21) var<storage, read> place_of_primitive: array<u32>;
@group(0) @binding(22) var<storage, read> patch_grids: array<PatchGrid>;
#endif

const NO_PATCH: u32 = 0xfffffu;
// How far before its surface a point is taken when its cell is chosen [cells].
const PATCH_BEFORE: f32 = 0.25;
// Cells from the origin beyond which all are one.
const PATCH_REACH: f32 = 1e9;
// Most places of the table that are looked at.
const PATCH_PROBES: u32 = 32u;
const PATCH_NODE: u32 = 0x80000000u;
// Most nodes between a cell and a patch.
const PATCH_DEPTH: u32 = 8u;

// Which of the six ways a normal faces: +x, −x, +y, −y, +z, −z.
fn face_of(n: vec3f) -> u32 {
    let size = abs(n);
    var axis = 2u;
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
    } else if size.y >= size.z {
        axis = 1u;
    }
    return 2u * axis + select(0u, 1u, n[axis] < 0.0);
}

// The patch that answers at a point of the grid, after all planes that part its cell.
fn side_of(answer: u32, p: vec3f, first_node: u32) -> u32 {
    var found = answer;
    for (var depth = 0u; depth < PATCH_DEPTH; depth++) {
        if (found & PATCH_NODE) == 0u {
            break;
        }
        let node = first_node + (found & ~PATCH_NODE);
        let plane = bitcast<vec4f>(vec4u(
            patch_table[node].patches[0], patch_table[node].patches[1], patch_table[node].patches[2], patch_table[node].patches[3],
        ));
        found = patch_table[node].patches[select(5u, 4u, dot(plane, vec4f(p, 1.0)) >= 0.0)];
    }
    return found;
}

// The patch of a point of a primitive, by its position [m] and the geometric normal on its visible side.
fn patch_at(primitive: u32, position: vec3f, normal: vec3f) -> u32 {
    let place = place_of_primitive[primitive];
    if place == 0xffffffffu {
        return NO_PATCH;
    }
    return patch_of_object(place, position, normal);
}

// The same by the index of the object.
fn patch_of_object(place: u32, position: vec3f, normal: vec3f) -> u32 {
    let a = patch_grids[place].rows[0];
    let b = patch_grids[place].rows[1];
    let c = patch_grids[place].rows[2];
    let turned = vec3f(dot(a.xyz, normal), dot(b.xyz, normal), dot(c.xyz, normal));
    let n = turned * inverseSqrt(max(dot(turned, turned), 1e-30));
    let p = vec3f(dot(a.xyz, position) + a.w, dot(b.xyz, position) + b.w, dot(c.xyz, position) + c.w);
    let cell = bitcast<vec3u>(vec3i(clamp(floor(p + PATCH_BEFORE * n), vec3f(-PATCH_REACH), vec3f(PATCH_REACH))));
    let start = hash(cell.x ^ hash(cell.y ^ hash(cell.z ^ hash(place))));
    let tag = hash(cell.z ^ hash(cell.x ^ hash(cell.y ^ hash(place ^ 0x9e3779b9u))));
    let first = patch_grids[place].first;
    let mask = patch_grids[place].places - 1u;
    for (var step = 0u; step < PATCH_PROBES; step++) {
        let at = first + ((start + step) & mask);
        if patch_table[at].tag == tag {
            return side_of(patch_table[at].patches[face_of(n)], p, patch_grids[place].nodes);
        }
        if patch_table[at].is_used == 0u {
            break;
        }
    }
    return NO_PATCH;
}
