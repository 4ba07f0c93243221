#define_import_path lightwell::motion

// Where the points of surfaces were in the frame before. See engine/src/render/motion.rs.

// An object that moved.
struct Moved {
    rows: array<vec4f, 3>, // world of the frame before from that of this one
    id: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

// By their identity.
@group(0) @binding(24) var<storage, read> moved: array<Moved>;

struct Place {
    position: vec3f,       // world [m]
    normal: vec3f,         // unit
    is_moved: bool,
}

// Where a point of an object was, and how it was turned.
fn place_before(id: u32, position: vec3f, normal: vec3f) -> Place {
    var low = 0u;
    var high = arrayLength(&moved);
    while low < high {
        let middle = (low + high) / 2u;
        if moved[middle].id < id {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low == arrayLength(&moved) || moved[low].id != id {
        return Place(position, normal, false);
    }
    let a = moved[low].rows[0];
    let b = moved[low].rows[1];
    let c = moved[low].rows[2];
    let p = vec4f(position, 1.0);
    // By the cofactor matrix, for objects that change their size too.
    let ab = cross(a.xyz, b.xyz);
    let bc = cross(b.xyz, c.xyz);
    let n = vec3f(dot(bc, normal), dot(cross(c.xyz, a.xyz), normal), dot(ab, normal));
    let size = max(abs(n.x), max(abs(n.y), abs(n.z)));
    return Place(vec3f(dot(a, p), dot(b, p), dot(c, p)), normalize(n / max(size, 1e-30)), true);
}
