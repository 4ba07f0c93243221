//! What a GGX lobe reflects of light that is even over it, as `lib/environment.wgsl` has it.

use glam::Vec3;

/// Coefficients of rⁱ·xʲ in the reflectance of a lobe with F = 1, for roughness r and cosine x: rows i, columns j.
const WHOLE: [[f32; 5]; 5] = [
    [1.0041, -0.0914, 1.1917, -2.3978, 1.2475],
    [-0.4462, -0.9961, 3.586, -1.5073, 0.0],
    [1.7534, -2.5879, -0.3015, 0.0, 0.0],
    [-2.2465, 1.1552, 0.0, 0.0, 0.0],
    [0.9313, 0.0, 0.0, 0.0, 0.0],
];
/// Coefficients of (1−x)²ⁱ·(1−r)ʲ, i from 1 and j from 0, in the part of it that goes with F90.
const GRAZING: [[f32; 3]; 3] = [[0.0354, 0.0282, -0.2741], [-0.1957, 1.1669, 0.3073], [0.2521, -1.7743, 1.5272]];

/// Share of even light that the lobe reflects, ∫ F·D·V·cosθ, by F0, F90, roughness and the cosine of the view: F0·A + F90·B
/// (the split sum of Karis 2013), with least-squares fits of A + B and B. They are within 0.07 everywhere and 0.015 in the
/// mean; the common fit of Karis 2014 is off by up to 0.46 for rough surfaces.
pub(in crate::render) fn lobe_reflectance(
    normal_reflectance: Vec3,
    grazing_reflectance: f32,
    roughness: f32,
    cosine: f32,
) -> Vec3 {
    let (r, x) = (roughness.clamp(0.0, 1.0), cosine.clamp(0.0, 1.0));
    let polynomial = |c: &[f32], at: f32| c.iter().rev().fold(0.0, |sum, c| sum * at + c);
    let whole = polynomial(&WHOLE.map(|row| polynomial(&row, x)), r);
    let square = (1.0 - x) * (1.0 - x);
    let grazing = square * polynomial(&GRAZING.map(|row| polynomial(&row, 1.0 - r)), square) + 0.0043 - 0.0056 * r;
    let grazing = grazing.clamp(0.0, 1.0);
    (normal_reflectance * (whole - grazing) + grazing_reflectance * grazing).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both parts, by importance sampling of half vectors (Karis 2013): G·(v·h)/((n·h)(n·v)) with F's two halves.
    fn integrated(roughness: f32, n_dot_v: f32) -> [f32; 2] {
        const COUNT: u32 = 4096;
        let a2 = roughness.powi(4);
        let view = Vec3::new((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
        let mut sums = [0.0; 2];
        for i in 0..COUNT {
            let u = [(i as f32 + 0.5) / COUNT as f32, i.reverse_bits() as f32 * 2.0_f32.powi(-32)];
            let cosine = ((1.0 - u[0]) / (1.0 + (a2 - 1.0) * u[0])).sqrt();
            let (sin, cos) = (std::f32::consts::TAU * u[1]).sin_cos();
            let half = Vec3::new(cos, sin, 0.0) * (1.0 - cosine * cosine).max(0.0).sqrt() + Vec3::Z * cosine;
            let v_dot_h = view.dot(half);
            let n_dot_l = 2.0 * v_dot_h * cosine - n_dot_v;
            if v_dot_h <= 0.0 || n_dot_l <= 0.0 {
                continue;
            }
            let smith = |a: f32, b: f32| a * (b * b * (1.0 - a2) + a2).sqrt();
            let visibility = 0.5 / (smith(n_dot_l, n_dot_v) + smith(n_dot_v, n_dot_l));
            let value = 4.0 * visibility * n_dot_l * v_dot_h / cosine / COUNT as f32;
            let fresnel = (1.0 - v_dot_h).powi(5);
            sums[0] += (1.0 - fresnel) * value;
            sums[1] += fresnel * value;
        }
        sums
    }

    #[test]
    fn fits_the_integral() {
        let (mut largest, mut mean) = (0.0_f32, 0.0);
        for (r, x) in (1..=10).flat_map(|r| (1..=10).map(move |x| (r as f32 / 10.0, x as f32 / 10.0))) {
            let [a, b] = integrated(r, x);
            for (normal, grazing) in [(1.0, 1.0), (0.04, 1.0), (0.6, 1.0), (1.0, 0.0)] {
                let found = lobe_reflectance(Vec3::splat(normal), grazing, r, x).x;
                let error = (found - (normal * a + grazing * b)).abs();
                largest = largest.max(error);
                mean += error / 400.0;
            }
        }
        assert!(largest < 0.07 && mean < 0.015, "largest {largest}, mean {mean}");
    }
}
