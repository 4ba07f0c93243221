#define_import_path lightwell::sampling

// Random numbers and directions for path tracing.

const TAU: f32 = 6.28318530717959;
const INVERSE_PI: f32 = 0.31830988618379;

// One path's numbers: a scrambled Sobol' sequence over the samples of a pixel, a fresh pair of dimensions a call.
struct Sampler {
    seed: u32,             // of the pixel and the half
    index: u32,            // of the sample in its half
    dimension: u32,        // pairs used so far
}

// O'Neill's PCG output function, as a hash (Jarzynski and Olano 2020).
fn hash(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn hash_pair(a: u32, b: u32) -> u32 {
    return hash(a ^ hash(b));
}

// Owen scrambling of a number whose bits are in reverse order (Laine and Karras 2011, with the constants of Burley
// 2020).
fn scramble_reversed(value: u32, seed: u32) -> u32 {
    var x = value + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return reverseBits(x);
}

// Second dimension of the Sobol' (0, 2)-sequence, its bits in reverse order. The direction numbers are the rows of
// Pascal's triangle mod 2: with the index's bits as a polynomial b(z) over GF(2), this is b(1 + z), found by halves,
// since (1 + z)^n = 1 + z^n for n a power of two.
fn reversed_sobol_second(index: u32) -> u32 {
    var x = index ^ (index >> 16u);
    x ^= (x >> 8u) & 0x00ff00ffu;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 2u) & 0x33333333u;
    x ^= (x >> 1u) & 0x55555555u;
    return x;
}

fn unit_float(bits: u32) -> f32 {
    return f32(i32(bits >> 8u)) * 0x1p-24f;
}

// Two numbers in [0, 1), stratified together over the samples; different pairs are shuffled against each other
// (Burley 2020, "Practical hash-based Owen scrambling").
fn next_pair(state: ptr<function, Sampler>) -> vec2f {
    let seed = hash_pair((*state).seed, (*state).dimension);
    (*state).dimension += 1u;
    let index = scramble_reversed(reverseBits((*state).index), seed);
    // The first dimension of the sequence is the index in reverse.
    let x = scramble_reversed(index, hash(seed ^ 0x9e3779b9u));
    let y = scramble_reversed(reversed_sobol_second(index), hash(seed ^ 0x85ebca6bu));
    return vec2f(unit_float(x), unit_float(y));
}

// Two unit vectors perpendicular to a third (Duff et al. 2017).
fn basis(n: vec3f) -> mat3x3f {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat3x3f(vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3f(b, s + n.y * n.y * a, -n.y), n);
}

// Direction with density cosθ/π around n (Malley's method).
fn cosine_direction(n: vec3f, random: vec2f) -> vec3f {
    let radius = sqrt(random.x);
    let angle = TAU * random.y;
    let local = vec3f(radius * cos(angle), radius * sin(angle), sqrt(max(0.0, 1.0 - random.x)));
    return normalize(basis(n) * local);
}

// Whether a candidate with that chance takes the place of the one chosen before it (weighted reservoir: Chao 1982). The
// random number is used up and stretched again, for the candidates that follow.
fn is_chosen(pick: ptr<function, f32>, chance: f32) -> bool {
    let is_taken = *pick < chance;
    *pick = select((*pick - chance) / (1.0 - chance), *pick / chance, is_taken);
    return is_taken;
}

// Microfacet normal with the density of those that v sees (Heitz 2018, "Sampling the GGX distribution of visible
// normals"); v unit, in the hemisphere of n.
fn visible_ggx_normal(n: vec3f, v: vec3f, alpha: f32, random: vec2f) -> vec3f {
    return visible_normal_in(basis(n), v, vec2f(alpha), random);
}

// The same with other α along the first than along the second axis of a frame, whose third is the normal.
fn visible_normal_in(frame: mat3x3f, v: vec3f, alphas: vec2f, random: vec2f) -> vec3f {
    let local = v * frame;
    let stretched = normalize(vec3f(alphas * local.xy, local.z));
    let length_squared = dot(stretched.xy, stretched.xy);
    let first = select(
        vec3f(1.0, 0.0, 0.0), vec3f(-stretched.y, stretched.x, 0.0) * inverseSqrt(max(length_squared, 1e-30)), length_squared > 1e-12,
    );
    let second = cross(stretched, first);
    let radius = sqrt(random.x);
    let angle = TAU * random.y;
    let x = radius * cos(angle);
    let blend = 0.5 * (1.0 + stretched.z);
    let y = mix(sqrt(max(0.0, 1.0 - x * x)), radius * sin(angle), blend);
    let h = x * first + y * second + sqrt(max(0.0, 1.0 - x * x - y * y)) * stretched;
    return normalize(frame * vec3f(alphas * h.xy, max(1e-7, h.z)));
}
