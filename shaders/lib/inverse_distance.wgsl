#define_import_path lightwell::inverse_distance

// How near the surfaces are that a point sees, and to which side of its normal they lie. With the direction ω and the
// distance t of each hit: the means of 1/t (its inverse is the harmonic mean R), and of ω/t along the two
// tangents of lightwell::sampling::basis [1/m]. And how near the light is that emissive surfaces send there: the mean of
// 1/t over all light, of which only that from emissive surfaces counts. Kept in two floats, for the alpha of two images.

#import lightwell::sampling::basis

// Of each tangent's part of 1/R. Both together with the level below are a whole number that a float holds exactly.
const STEPS: f32 = 1022.0;
const SIDES: f32 = 1023.0 * 1023.0;

// Emitted light over 1/R is kept in levels, half an octave each: 0 is none, 1 is half as near, 15 is 64 times as near.
const LEVELS: f32 = 15.0;
const FIRST_LEVEL: f32 = 3.0;

// The code of a pixel without diffuse light to filter, since all that it reflects is mirrored.
const NO_DIFFUSE: vec2f = vec2f(0.0, -1.0);

fn has_diffuse(code: vec2f) -> bool {
    return code.y >= 0.0;
}

// From the parts along the tangents, 1/R, and the same of emitted light.
fn encode_inverse_distance(inverse_distance: vec3f, emitted: f32) -> vec2f {
    // Where the rays met nothing, a light still has its distance.
    let near = max(inverse_distance.z, emitted * exp2(-0.5 * (LEVELS - FIRST_LEVEL)));
    let side = clamp(inverse_distance.xy / max(near, 1e-30), vec2f(-1.0), vec2f(1.0));
    let code = round((0.5 * side + 0.5) * STEPS);
    let level = clamp(round(2.0 * log2(max(emitted, 1e-30) / max(near, 1e-30)) + FIRST_LEVEL), 0.0, LEVELS);
    return vec2f(near, select(0.0, level * SIDES, emitted > 0.0) + code.x * (STEPS + 1.0) + code.y);
}

fn decode_inverse_distance(code: vec2f) -> vec3f {
    let side = code.y - SIDES * floor(code.y / SIDES);
    let x = floor(side / (STEPS + 1.0));
    let y = side - x * (STEPS + 1.0);
    return vec3f((2.0 * vec2f(x, y) / STEPS - 1.0) * code.x, code.x);
}

fn decode_emitted(code: vec2f) -> f32 {
    let level = floor(code.y / SIDES);
    return select(0.0, code.x * exp2(0.5 * (level - FIRST_LEVEL)), level > 0.0);
}

// From the means of ω/t and 1/t, around a normal.
fn nearness_around(toward: vec3f, all: f32, n: vec3f) -> vec3f {
    return vec3f((toward * basis(n)).xy, all);
}
