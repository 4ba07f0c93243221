#define_import_path lightwell::patches

// Patches of surfels: which one a point of a surface belongs to. See engine/src/scene/surfels/patches.rs.

#import lightwell::sampling::hash

// World to the cells of an object's grid, which turns with it.
struct PatchGrid {
    rows: array<vec4f, 3>,
}

// Places of a hash table with open addressing: tag and patch. A power of two of them.
@group(0) @binding(20) var<storage, read> patch_table: array<vec2u>;
// Index of the object by that of the primitive; all bits set: it has no surfels.
@group(0) @binding(21) var<storage, read> place_of_primitive: array<u32>;
@group(0) @binding(22) var<storage, read> patch_grids: array<PatchGrid>;

const NO_PATCH: u32 = 0xfffffu;
// How far before its surface a point is taken when its cell is chosen [cells].
const PATCH_BEFORE: f32 = 0.25;
// Cells from the origin beyond which all are one.
const PATCH_REACH: f32 = 1e9;
// Most places of the table that are looked at.
const PATCH_PROBES: u32 = 32u;

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

fn patch_in(place: u32, face: u32, cell: vec3u) -> u32 {
    let side = place * 8u + face;
    let start = hash(cell.x ^ hash(cell.y ^ hash(cell.z ^ hash(side))));
    let tag = hash(cell.z ^ hash(cell.x ^ hash(cell.y ^ hash(side ^ 0x9e3779b9u))));
    let mask = arrayLength(&patch_table) - 1u;
    for (var step = 0u; step < PATCH_PROBES; step++) {
        let known = patch_table[(start + step) & mask];
        if known.y == NO_PATCH || known.x == tag {
            return known.y;
        }
    }
    return NO_PATCH;
}

// The patch of a point of a primitive, by its position [m] and the geometric normal on its visible side. Where none faces
// as the point does most, one may face the way that comes next.
fn patch_at(primitive: u32, position: vec3f, normal: vec3f) -> u32 {
    let place = place_of_primitive[primitive];
    if place == 0xffffffffu {
        return NO_PATCH;
    }
    let a = patch_grids[place].rows[0];
    let b = patch_grids[place].rows[1];
    let c = patch_grids[place].rows[2];
    let turned = vec3f(dot(a.xyz, normal), dot(b.xyz, normal), dot(c.xyz, normal));
    let n = turned * inverseSqrt(max(dot(turned, turned), 1e-30));
    let p = vec3f(dot(a.xyz, position) + a.w, dot(b.xyz, position) + b.w, dot(c.xyz, position) + c.w);
    let cell = bitcast<vec3u>(vec3i(clamp(floor(p + PATCH_BEFORE * n), vec3f(-PATCH_REACH), vec3f(PATCH_REACH))));
    var rest = n;
    for (var i = 0u; i < 3u; i++) {
        let face = face_of(rest);
        let found = patch_in(place, face, cell);
        if found != NO_PATCH {
            return found;
        }
        rest[face / 2u] = 0.0;
    }
    return NO_PATCH;
}
