//! Fits the specular lobe by linearly transformed cosines and writes the table that area lights are shaded by:
//!
//! ```text
//! cargo run --release -p lightwell --example fit_lobes -- engine/src/render/direct/lobes.bin
//! ```
//!
//! Method: Heitz, Dupuy, Hill and Neubelt 2016, "Real-time polygonal-light shading with linearly transformed cosines". The lobe
//! is GGX with height-correlated Smith visibility and without Fresnel term, as in `shaders/lib/brdf.wgsl`. Nodes are even in
//! log₂ α and in the angle to the eye; what stands in the table is written in `shaders/lib/lobes.wgsl`.

use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Nodes of roughness, from α = 2⁻¹⁰ to 1.
const ALPHAS: usize = 41;
/// Nodes of the angle between normal and eye, from 0 to LAST_ANGLE.
const ANGLES: usize = 32;
const LAST_ANGLE: f64 = 0.995 * FRAC_PI_2;
/// Samples along each of two dimensions, for each of the two densities.
const SAMPLES: usize = 24;

/// f·cosθ of the lobe towards an eye in the xz plane, and the density with which `sample` gives the direction.
#[derive(Clone, Copy)]
struct Lobe {
    eye: DVec3,
    alpha: f64,
}

impl Lobe {
    fn distribution(&self, h: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        let d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
        a2 / (PI * d * d)
    }

    fn value(&self, l: DVec3) -> f64 {
        if l.z <= 0.0 {
            return 0.0;
        }
        let a2 = self.alpha * self.alpha;
        let h = (self.eye + l).normalize();
        let (v, l) = (self.eye.z, l.z);
        let smith = 0.5 / (l * (v * v * (1.0 - a2) + a2).sqrt() + v * (l * l * (1.0 - a2) + a2).sqrt());
        self.distribution(h) * smith * l
    }

    /// Density of reflections at visible normals (Heitz 2018, eq. 17).
    fn density(&self, l: DVec3) -> f64 {
        let h = (self.eye + l).normalize();
        let (a2, v) = (self.alpha * self.alpha, self.eye.z);
        self.distribution(h) / (2.0 * (v + (a2 + (1.0 - a2) * v * v).sqrt()))
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let stretched = DVec3::new(self.alpha * self.eye.x, 0.0, self.eye.z).normalize();
        let first = DVec3::Y;
        let second = stretched.cross(first);
        let (radius, angle) = (u.x.sqrt(), TAU * u.y);
        let x = radius * angle.cos();
        let blend = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - blend) * (1.0 - x * x).max(0.0).sqrt() + blend * radius * angle.sin();
        let h = x * first + y * second + (1.0 - x * x - y * y).max(0.0).sqrt() * stretched;
        let h = DVec3::new(self.alpha * h.x, self.alpha * h.y, h.z.max(1e-9)).normalize();
        2.0 * h.dot(self.eye) * h - self.eye
    }

    /// ∫ f·cosθ, and the mean direction in the plane of the eye.
    fn moments(&self) -> (f64, DVec3) {
        let (mut norm, mut mean) = (0.0, DVec3::ZERO);
        for u in grid() {
            let l = self.sample(u);
            let weight = self.value(l) / self.density(l);
            norm += weight;
            mean += weight * l;
        }
        mean.y = 0.0;
        (norm / (SAMPLES * SAMPLES) as f64, mean.normalize())
    }
}

fn grid() -> impl Iterator<Item = DVec2> {
    let at = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
    (0..SAMPLES * SAMPLES).map(move |i| DVec2::new(at(i % SAMPLES), at(i / SAMPLES)))
}

/// A cosine lobe under a matrix.
struct Cosine {
    matrix: DMat3,
    inverse: DMat3,
    determinant: f64,
    norm: f64,
}

impl Cosine {
    /// Parameters: logarithms of the widths in the plane of the eye and across it, and the skew in that plane over its width.
    fn new([in_plane, across, skew]: [f64; 3], frame: DMat3, norm: f64) -> Self {
        let (a, b) = (in_plane.exp(), across.exp());
        let shape = DMat3::from_cols(DVec3::new(a, 0.0, 0.0), DVec3::new(0.0, b, 0.0), DVec3::new(skew * a, 0.0, 1.0));
        let matrix = frame * shape;
        Self { matrix, inverse: matrix.inverse(), determinant: matrix.determinant().abs(), norm }
    }

    fn density(&self, l: DVec3) -> f64 {
        let original = (self.inverse * l).normalize();
        let length = (self.matrix * original).length();
        original.z.max(0.0) / PI * length.powi(3) / self.determinant
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let (radius, angle) = (u.x.sqrt(), TAU * u.y);
        let local = DVec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - u.x).sqrt());
        (self.matrix * local).normalize()
    }
}

/// ∫ |lobe − fit|³, by samples of both.
fn error(lobe: Lobe, fit: &Cosine) -> f64 {
    let at = |l: DVec3| {
        let difference = (lobe.value(l) - fit.norm * fit.density(l)).abs();
        let density = fit.density(l) + if l.z > 0.0 { lobe.density(l) } else { 0.0 };
        difference.powi(3) / density
    };
    grid().map(|u| at(fit.sample(u)) + at(lobe.sample(u))).filter(|e| e.is_finite()).sum()
}

/// Downhill simplex (Nelder and Mead 1965), in as many dimensions as are free.
fn minimized(start: [f64; 3], free: usize, cost: impl Fn([f64; 3]) -> f64) -> [f64; 3] {
    let mut simplex = vec![(cost(start), start)];
    for i in 0..free {
        let mut corner = start;
        corner[i] += 0.1;
        simplex.push((cost(corner), corner));
    }
    for _ in 0..120 {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (best, worst) = (simplex[0].0, simplex[free]);
        if worst.0 - best <= 1e-7 * best.abs() {
            break;
        }
        let mut center = [0.0; 3];
        for (_, corner) in &simplex[..free] {
            (0..3).for_each(|i| center[i] += corner[i] / free as f64);
        }
        let along = |t: f64| std::array::from_fn(|i| center[i] + t * (worst.1[i] - center[i]));
        let tried = |t: f64| (cost(along(t)), along(t));
        let reflected = tried(-1.0);
        let chosen = if reflected.0 < best {
            let expanded = tried(-2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < simplex[free - 1].0 {
            reflected
        } else {
            tried(if reflected.0 < worst.0 { -0.5 } else { 0.5 })
        };
        if chosen.0 < worst.0 {
            simplex[free] = chosen;
        } else {
            let first = simplex[0].1;
            for entry in &mut simplex[1..] {
                let nearer: [f64; 3] = std::array::from_fn(|i| 0.5 * (first[i] + entry.1[i]));
                *entry = (cost(nearer), nearer);
            }
        }
    }
    simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
    simplex[0].1
}

/// The four numbers of a node: the inverse matrix [a 0 b; 0 1 0; c 0 d] with its middle scaled to one, as a, b, c/α, d/α.
fn node(inverse: DMat3, alpha: f64) -> [f32; 4] {
    let m = inverse * (1.0 / inverse.y_axis.y);
    [m.x_axis.x, m.z_axis.x, m.x_axis.z / alpha, m.z_axis.z / alpha].map(|number| number as f32)
}

fn main() -> std::io::Result<()> {
    let Some(path) = std::env::args().nth(1) else {
        return Err(std::io::Error::other("name the file to write"));
    };
    let mut table = vec![[0.0_f32; 4]; ALPHAS * ANGLES];
    let mut at_normal = [0.0, 0.0, 0.0];
    let mut largest = 0.0_f64;
    for i in (0..ALPHAS).rev() {
        let alpha = (-10.0 + 10.0 * i as f64 / (ALPHAS - 1) as f64).exp2();
        let mut parameters = at_normal;
        for k in 0..ANGLES {
            let angle = LAST_ANGLE * k as f64 / (ANGLES - 1) as f64;
            let lobe = Lobe { eye: DVec3::new(angle.sin(), 0.0, angle.cos()), alpha };
            let (norm, mean) = lobe.moments();
            let is_normal = k == 0;
            let z = if is_normal { DVec3::Z } else { mean };
            let frame = DMat3::from_cols(DVec3::new(z.z, 0.0, -z.x), DVec3::Y, z);
            let fit = |p: [f64; 3]| Cosine::new(if is_normal { [p[0], p[0], 0.0] } else { p }, frame, norm);
            parameters = minimized(parameters, if is_normal { 1 } else { 3 }, |p| error(lobe, &fit(p)));
            if is_normal {
                parameters = [parameters[0], parameters[0], 0.0];
                at_normal = parameters;
            }
            let fitted = fit(parameters);
            // Share of the lobe that lies elsewhere: half of ∫ |lobe − fit| over the lobe.
            let apart = grid().map(|u| {
                let l = lobe.sample(u);
                (lobe.value(l) - norm * fitted.density(l)).abs() / lobe.density(l)
            });
            let apart = 0.5 * apart.sum::<f64>() / (SAMPLES * SAMPLES) as f64 / norm;
            largest = largest.max(apart);
            if k % 10 == 0 && i % 8 == 0 {
                println!("alpha {alpha:.5}, {:.0}°: {apart:.3} of the lobe lies elsewhere", angle.to_degrees());
            }
            table[i * ANGLES + k] = node(fitted.inverse, alpha);
        }
    }
    println!("at most {largest:.3} of a lobe lies elsewhere");
    std::fs::write(path, bytemuck::cast_slice(&table))
}
