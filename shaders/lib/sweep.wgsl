#define_import_path lightwell::sweep

// What the passes of the sweep transport share: surfels, sums in fixed point, and irradiance by normal.
//
// Lengths are in cells (h = 1) where nothing else is said.

// A piece of surface with all that light needs to know of it.
struct Surfel {
    position: vec3f,       // [m]
    area: f32,             // [m²]
    normal: vec3f,         // unit
    thickness: f32,        // of the solid behind it [m]; huge: a one-sided sheet; see `thickness_for`
    albedo: vec3f,         // diffuse reflectance ρ
    place: u32,            // index of its transform; INNER; CLOSED
    emissive: vec3f,       // emitted radiance [W/(m² sr)]
    wall: f32,             // cells up to this size are sealed by its object's triangles; 0: by its area alone [m]
}

// The inner side of a closed surface that can be seen from both sides.
const INNER: u32 = 0x80000000u;
// Such a surface is a room where so many cells fit into it, with light on both sides; smaller, it is a solid.
const ROOM: f32 = 2.0;

// Where in `place` the eight bits are that tell how closed the surroundings are; below them is the index.
const CLOSED: u32 = 23u;
const INDEX: u32 = 0x7fffffu;

// Share of the light about a surfel that gets past what stands near it.
fn openness(surfel: Surfel) -> f32 {
    return 1.0 - f32((surfel.place >> CLOSED) & 255u) / 255.0;
}

// Thickness of what is behind a surfel as cells of a size have it [m]; below 0: for them it is not there. Closed surfaces
// that can be seen from both sides hold less the width of what they enclose.
fn thickness_for(surfel: Surfel, cell: f32) -> f32 {
    if surfel.thickness >= 0.0 {
        return surfel.thickness;
    }
    if -surfel.thickness >= ROOM * cell {
        return 0.0;
    }
    return select(-surfel.thickness, -1.0, (surfel.place & INNER) != 0u);
}

// Surfaces are taken this far before where they are when a cell is chosen [cells]: ties break the same way everywhere.
const BEFORE: f32 = 1e-3;

// The cells that a surfel has to do with (`indirect/light_volumes/sweep/links.wgsl`), in one word: of the eight cells around the point half a
// cell before it which are reached, a bit each; then whether there is one to send light to, and its place from the
// surfel's own, from −2 to 2 along each axis.
const LINKED: u32 = 0x100u;

fn encode_link(reached: u32, way: vec3f, is_any: bool) -> u32 {
    if !is_any {
        return reached;
    }
    let place = vec3u(clamp(way, vec3f(-2.0), vec3f(2.0)) + 2.0);
    return reached | LINKED | (place.x << 9u) | (place.y << 12u) | (place.z << 15u);
}

fn link_way(link: u32) -> vec3f {
    return vec3f(vec3u(link >> 9u, link >> 12u, link >> 15u) & vec3u(7u)) - 2.0;
}

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

// Axis of the coordinate system that a normal lies nearest to.
fn nearest_axis(n: vec3f) -> u32 {
    let a = abs(n);
    if a.x >= a.y && a.x >= a.z {
        return 0u;
    }
    return select(2u, 1u, a.y >= a.z);
}
