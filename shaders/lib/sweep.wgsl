#define_import_path lightwell::sweep

// What the passes of the sweep transport share: surfels, sums in fixed point, and irradiance by normal.
//
// Lengths are in cells (h = 1) where nothing else is said.

// A piece of surface with all that light needs to know of it.
struct Surfel {
    position: vec3f,       // [m]
    area: f32,             // [m²]
    normal: vec3f,         // unit
    thickness: f32,        // of the solid behind it [m]; huge: a one-sided sheet
    albedo: vec3f,         // diffuse reflectance ρ
    place: u32,            // index of its transform
    emissive: vec3f,       // emitted radiance [W/(m² sr)]
    extent: f32,           // second largest edge of its object's box [m]
}

// Surfaces are taken this far before where they are when a cell is chosen [cells]: ties break the same way everywhere.
const BEFORE: f32 = 1e-3;

// A number as the sum of two words, high·2¹⁶ + low with 0 ≤ low < 2¹⁶. Sums of both words are exact and do not depend
// on order; together they span 2⁴⁵, so that a light far weaker than another is not rounded away. Up to 2¹⁶ summands.
fn to_fixed(value: f32) -> vec2i {
    let whole = round(value);
    let high = floor(whole * 0.0000152587890625);
    return vec2i(i32(high), i32(whole - high * 65536.0));
}

fn from_fixed(high: i32, low: i32) -> f32 {
    let unsigned = bitcast<u32>(low);
    return f32(high + i32(unsigned >> 16u)) * 65536.0 + f32(unsigned & 0xffffu);
}

// Irradiance is kept for eighteen normals: the six axes, then (±x±y), (±y±z), (±z±x) over √2, four signs each. For an
// axis-aligned wall that is the exact cosine integral over all directions, where spherical harmonics of order 3 give a
// surface 9 % of the light that only grazes it and 6 % of what comes from behind.
//
// For any other normal: linear between the three corners of the triangle on the octahedron that holds it, plus what
// makes the first harmonic exact, E(n) − E(−n) = V·n with the vector irradiance V, whose components the axes hold.
struct Nodes {
    edge: vec3u,           // three of the twelve diagonals
    edge_weight: vec3f,
    plus: vec3f,           // weights of +x, +y, +z
    minus: vec3f,          // weights of −x, −y, −z
}

fn diagonal(plane: u32, first: f32, second: f32) -> u32 {
    return 4u * plane + select(0u, 1u, first < 0.0) + select(0u, 2u, second < 0.0);
}

const HALF_ROOT: f32 = 0.70710678;

fn nodes_of(n: vec3f) -> Nodes {
    let b = abs(n) / (abs(n.x) + abs(n.y) + abs(n.z));
    // Corner triangles have one barycentric coordinate above ½; the middle one has none.
    let corner = max(vec3f(0.0), 2.0 * b - 1.0);
    var edge_weight = 1.0 - 2.0 * b.zxy;
    if b.x > 0.5 {
        edge_weight = vec3f(2.0 * b.y, 0.0, 2.0 * b.z);
    } else if b.y > 0.5 {
        edge_weight = vec3f(2.0 * b.x, 2.0 * b.z, 0.0);
    } else if b.z > 0.5 {
        edge_weight = vec3f(0.0, 2.0 * b.y, 2.0 * b.x);
    }
    let s = select(vec3f(-1.0), vec3f(1.0), n >= vec3f(0.0));
    var nodes: Nodes;
    nodes.edge = vec3u(diagonal(0u, s.x, s.y), diagonal(1u, s.y, s.z), diagonal(2u, s.z, s.x));
    nodes.edge_weight = edge_weight;
    let mean = s * (corner + HALF_ROOT * (edge_weight.xyz + edge_weight.zxy));
    // ½V·(n − mean): half the difference of opposite axes.
    let rest = 0.5 * (n - mean);
    nodes.plus = select(vec3f(0.0), corner, n >= vec3f(0.0)) + rest;
    nodes.minus = select(corner, vec3f(0.0), n >= vec3f(0.0)) - rest;
    return nodes;
}
