#define_import_path lightwell::wide_nodes

// Nodes of eight children with boxes of a byte a coordinate (Ylitie et al. 2017), as rays/wide_tree.rs writes them. Six
// texels a node:
//   origin of its grid, exponents of the grid's units (a byte each, 128 more than they are)
//   first of the children that are nodes; first triangle of those that are leaves; which slots hold nodes; which hold leaves
//   a word of 16 bits for each slot: of a leaf, how far its first triangle is behind that of the node, and their number
//   less one above these 14 bits
//   lower x, y, z and upper x of four children, a byte each
//   the same of the other four
//   upper y and z of the former, and of the latter

#import lightwell::ray_scene::load_node

const TEXELS: u32 = 6u;
const OFFSET_BITS: u32 = 14u;

// Children of a node that a ray meets. Sets are bits in the order of their slots on the way of the ray.
struct Met {
    inner: u32,            // that are nodes
    leaves: u32,
    first_child: u32,
    all_inner: u32,        // slots that hold nodes, met or not, in the order of the slots
    first_triangle: u32,
    words: vec4u,          // of all slots
}

// A set of slots in the order in which a ray of that octant comes by; or the other way around.
fn ordered(slots: u32, octant: u32) -> u32 {
    var turned = slots;
    turned = select(turned, ((turned & 0x55u) << 1u) | ((turned >> 1u) & 0x55u), (octant & 1u) != 0u);
    turned = select(turned, ((turned & 0x33u) << 2u) | ((turned >> 2u) & 0x33u), (octant & 2u) != 0u);
    return select(turned, ((turned & 0x0fu) << 4u) | ((turned >> 4u) & 0x0fu), (octant & 4u) != 0u);
}

fn bytes(word: u32) -> vec4f {
    return vec4f(unpack4xU8(word));
}

// Which of four children a ray meets before t_max, a bit each.
fn met_of_four(low: vec3u, high: vec3u, scale: vec3f, offset: vec3f, t_max: f32) -> u32 {
    let is_turned = scale < vec3f(0.0);
    let near = select(low, high, is_turned);
    let far = select(high, low, is_turned);
    let near_x = bytes(near.x) * scale.x + offset.x;
    let near_y = bytes(near.y) * scale.y + offset.y;
    let near_z = bytes(near.z) * scale.z + offset.z;
    let far_x = bytes(far.x) * scale.x + offset.x;
    let far_y = bytes(far.y) * scale.y + offset.y;
    let far_z = bytes(far.z) * scale.z + offset.z;
    // As whole numbers, and four roundings further: see `meets_box` of lib/walk.wgsl.
    let enter = max(max(near_x, near_y), max(near_z, vec4f(0.0)));
    let leave = min(min(far_x, far_y), min(far_z, vec4f(t_max)));
    let met = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), enter <= leave * 1.0000005);
    return met.x | met.y | met.z | met.w;
}

// The children of a node that a ray from an origin meets before t_max; `inverse` is one over its direction.
fn met_children(node: u32, origin: vec3f, inverse: vec3f, octant: u32, t_max: f32) -> Met {
    let at = TEXELS * node;
    let grid = load_node(at);
    let links = load_node(at + 1u);
    let words = load_node(at + 2u);
    let first = load_node(at + 3u);
    let second = load_node(at + 4u);
    let upper = load_node(at + 5u);
    let exponents = vec3u(grid.w & 0xffu, (grid.w >> 8u) & 0xffu, (grid.w >> 16u) & 0xffu);
    let unit = bitcast<vec3f>((exponents - 1u) << vec3u(23u));
    let scale = unit * inverse;
    let offset = (bitcast<vec3f>(grid.xyz) - origin) * inverse;
    let met = met_of_four(first.xyz, vec3u(first.w, upper.xy), scale, offset, t_max)
        | (met_of_four(second.xyz, vec3u(second.w, upper.zw), scale, offset, t_max) << 4u);
    return Met(ordered(met & links.z, octant), ordered(met & links.w, octant), links.x, links.z, links.y, words);
}

// The word of a slot.
fn word_of(words: vec4u, slot: u32) -> u32 {
    let pair = select(select(words.x, words.y, (slot & 2u) != 0u), select(words.z, words.w, (slot & 2u) != 0u), slot >= 4u);
    return select(pair & 0xffffu, pair >> 16u, (slot & 1u) != 0u);
}

// The node that a slot holds.
fn child_in(slot: u32, first_child: u32, all_inner: u32) -> u32 {
    return first_child + countOneBits(all_inner & ((1u << slot) - 1u));
}
