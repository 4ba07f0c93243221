#define_import_path lightwell::sh

// Real spherical harmonics of order 2 as (Y_00, Y_1−1, Y_10, Y_11), that is (1, y, z, x) times their constants
// (Sloan, "Stupid Spherical Harmonics Tricks", 2008), and their convolution with the clamped cosine:
// A_0 = π, A_1 = 2π/3 (Ramamoorthi and Hanrahan 2001).

const BAND_ZERO: f32 = 0.28209479;      // 1 / (2√π)
const BAND_ONE: f32 = 0.48860251;       // √3 / (2√π)
const COSINE_ZERO: f32 = 3.14159265;    // A_0
const COSINE_ONE: f32 = 2.09439510;     // A_1

// The basis in a unit direction.
fn sh_basis(d: vec3f) -> vec4f {
    return vec4f(BAND_ZERO, BAND_ONE * d.y, BAND_ONE * d.z, BAND_ONE * d.x);
}

// Coefficients of max(0, n·ω): A_l·Y_lm(n).
fn sh_cosine_lobe(n: vec3f) -> vec4f {
    return vec4f(COSINE_ZERO * BAND_ZERO, COSINE_ONE * BAND_ONE * vec3f(n.y, n.z, n.x));
}

// Bands 0 to 2 in a unit direction.
fn sh_basis_nine(d: vec3f) -> array<f32, 9> {
    return array<f32, 9>(
        BAND_ZERO, BAND_ONE * d.y, BAND_ONE * d.z, BAND_ONE * d.x,
        1.0925484 * d.x * d.y, 1.0925484 * d.y * d.z, 0.31539157 * (3.0 * d.z * d.z - 1.0),
        1.0925484 * d.x * d.z, 0.5462742 * (d.x * d.x - d.y * d.y),
    );
}
