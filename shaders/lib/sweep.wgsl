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

// Axis of the coordinate system that a normal lies nearest to.
fn nearest_axis(n: vec3f) -> u32 {
    let a = abs(n);
    if a.x >= a.y && a.x >= a.z {
        return 0u;
    }
    return select(2u, 1u, a.y >= a.z);
}
