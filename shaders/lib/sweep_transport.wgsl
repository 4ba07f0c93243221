#define_import_path lightwell::sweep_transport

// What the two passes of the sweep share: directions, sources of a cell, and radiance in flight as it is stored.
//   HAZE  media in the cells absorb light, and scatter that of the lamps
//   HALF  radiance in flight is stored in half precision; sums stay in single

struct Ordinate {
    direction: vec3f,      // unit
    weight: f32,           // [sr]
    border: vec3f,         // radiance that enters from outside of the coarsest cascade [W/(m² sr)]
    padding: f32,
}

#ifdef HALF
// A half has eleven bits from 2⁻¹⁴ up to 2¹⁶, and fewer below. The exposure, a power of two, lays the brightest source of
// any cell between 2⁵ and 2⁶: a thousand of them in a row do not reach the end, and the eleven bits last down to the
// millionth part of one. What is brighter still is held there.
var<private> exposure: f32 = 1.0;        // of this cascade; the other two are one by the exposure
var<private> unexposed: f32 = 1.0;
var<private> outer_unexposed: f32 = 1.0; // of the next coarser cascade

// Exponent bits of the exposure for a peak in [2ᵉ⁻¹²⁷, 2ᵉ⁻¹²⁶) are those of 2¹³²⁻ᵉ.
fn exposure_bits(peak: f32) -> u32 {
    return clamp(259u - ((bitcast<u32>(peak) >> 23u) & 255u), 6u, 248u);
}

fn power_of_two(bits: u32) -> f32 {
    return bitcast<f32>(bits << 23u);
}

// Behind the emission of all cells stand the brightest source of this cascade and the coarser ones, and of those alone.
fn expose(peaks: vec2f) {
    let bits = exposure_bits(peaks.x);
    exposure = power_of_two(bits);
    unexposed = power_of_two(254u - bits);
    outer_unexposed = power_of_two(254u - exposure_bits(peaks.y));
}

fn to_stored(light: vec3f) -> vec2u {
    let exposed = min(light * exposure, vec3f(65504.0));
    return vec2u(pack2x16float(exposed.xy), pack2x16float(vec2f(exposed.z, 0.0)));
}

fn from_stored(stored: vec2u) -> vec3f {
    return vec3f(unpack2x16float(stored.x), unpack2x16float(stored.y).x) * unexposed;
}

fn from_outer(stored: vec2u) -> vec3f {
    return vec3f(unpack2x16float(stored.x), unpack2x16float(stored.y).x) * outer_unexposed;
}
#else
fn expose(peaks: vec2f) {
}

fn to_stored(light: vec3f) -> vec4f {
    return vec4f(light, 0.0);
}

fn from_stored(stored: vec4f) -> vec3f {
    return stored.rgb;
}

fn from_outer(stored: vec4f) -> vec3f {
    return stored.rgb;
}
#endif

// A component, by its number.
fn along(v: vec3f, axis: u32) -> f32 {
    return select(select(v.z, v.y, axis == 1u), v.x, axis == 0u);
}

// Sources of a cell, by the axis that the normals lie nearest to: F/h² and whether it leaves in all directions alike (below 0);
// the mean normal.
struct Source {
    flux: mat3x4f,
    normal: mat3x3f,
    is_lit: bool,
#ifdef HAZE
    absorbed: vec3f,       // optical depth of what media absorb, over the edge of a cell
    scattered: vec3f,      // F/h² of what they scatter straight from the lights, to all sides [W/m²]
#endif
}

// From the six vectors of a cell's emission.
fn source_from(a: vec4f, a_normal: vec4f, b: vec4f, b_normal: vec4f, c: vec4f, c_normal: vec4f) -> Source {
    var any_flux = a.rgb + b.rgb + c.rgb;
    let normals = mat3x3f(a_normal.xyz, b_normal.xyz, c_normal.xyz);
#ifdef HAZE
    let scattered = max(vec3f(a.a, b.a, c.a), vec3f(0.0));
    any_flux += scattered;
    let is_lit = any_flux.r + any_flux.g + any_flux.b > 0.0;
    return Source(mat3x4f(a, b, c), normals, is_lit, vec3f(a_normal.w, b_normal.w, c_normal.w), scattered);
#else
    let is_lit = any_flux.r + any_flux.g + any_flux.b > 0.0;
    return Source(mat3x4f(a, b, c), normals, is_lit);
#endif
}

// Radiance that a cell's own sources add to what leaves it, where `forward` is the direction's part along its axis.
fn emitted(source: Source, d: vec3f, forward: f32) -> vec3f {
    let cosine = max(vec3f(0.0), d * source.normal) * 0.318309886;
    let isotropic = vec3f(source.flux[0].a, source.flux[1].a, source.flux[2].a);
    let lobe = select(cosine, vec3f(0.0795774715), isotropic < vec3f(0.0)) / abs(forward);
    var light = source.flux[0].rgb * lobe.x + source.flux[1].rgb * lobe.y + source.flux[2].rgb * lobe.z;
#ifdef HAZE
    light += source.scattered * (0.0795774715 / abs(forward));
#endif
    return light;
}

// The part of it that surfaces along the way send out, which what arrives from the side does not hold yet.
fn beside(source: Source, d: vec3f, axis: u32) -> vec3f {
    let forward = along(d, axis);
    let normals = vec3f(along(source.normal[0], axis), along(source.normal[1], axis), along(source.normal[2], axis));
    let ahead = max(vec3f(0.0), forward * normals);
    let cosine = max(vec3f(0.0), max(vec3f(0.0), d * source.normal) - ahead) * 0.318309886;
    let isotropic = vec3f(source.flux[0].a, source.flux[1].a, source.flux[2].a);
    let lobe = select(cosine, vec3f(0.0397887358), isotropic < vec3f(0.0)) / abs(forward);
    var light = source.flux[0].rgb * lobe.x + source.flux[1].rgb * lobe.y + source.flux[2].rgb * lobe.z;
#ifdef HAZE
    light += source.scattered * (0.0397887358 / abs(forward));
#endif
    return light;
}
