#define_import_path lightwell::inverse_distance

// How near the surfaces are that a point sees, and to which side of its normal they lie. With the direction ω and the
// distance t of what each ray meets: the means of 1/t (its inverse is the harmonic mean R), and of ω/t along the two
// tangents of lightwell::sampling::basis [1/m]. Kept in two floats, for the alpha of two images.

#import lightwell::sampling::basis

// Of each tangent's part of 1/R. Both together are a whole number that a float holds exactly.
const STEPS: f32 = 1022.0;

// From the parts along the tangents, and 1/R.
fn encode_inverse_distance(inverse_distance: vec3f) -> vec2f {
    let side = clamp(inverse_distance.xy / max(inverse_distance.z, 1e-30), vec2f(-1.0), vec2f(1.0));
    let code = round((0.5 * side + 0.5) * STEPS);
    return vec2f(inverse_distance.z, code.x * (STEPS + 1.0) + code.y);
}

fn decode_inverse_distance(code: vec2f) -> vec3f {
    let x = floor(code.y / (STEPS + 1.0));
    let y = code.y - x * (STEPS + 1.0);
    return vec3f((2.0 * vec2f(x, y) / STEPS - 1.0) * code.x, code.x);
}

// From the means of ω/t and 1/t, around a normal.
fn nearness_around(toward: vec3f, all: f32, n: vec3f) -> vec3f {
    return vec3f((toward * basis(n)).xy, all);
}
