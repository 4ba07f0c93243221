//! Skies as glossy surfaces reflect them, and their irradiance as a few numbers.

use super::SkyMap;
use super::parallel;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Roughnesses for which reflections are kept: 0, 0.2, … 1.
pub const REFLECTION_LEVELS: u32 = 6;

/// Width and height of the sharpest level at most, and at least \[texels\].
const LARGEST: [u32; 2] = [512, 256];
const SMALLEST: [u32; 2] = [256, 128];
/// Directions that a texel's lobe is sampled in.
const SAMPLES: u32 = 48;

/// A sky as a surface of one roughness reflects it, on the grid of [`SkyMap`].
#[derive(Clone, Debug)]
pub struct SkyReflection {
    /// Width \[texels\].
    pub width: u32,
    /// Height \[texels\].
    pub height: u32,
    /// Mean radiance over the lobe around each direction [W/(m² sr)], row by row from the zenith down.
    pub texels: Vec<Vec3>,
}

impl SkyMap {
    /// What a GGX lobe of each roughness k/5 sees of the sky around its direction, seen from that direction (Karis 2013,
    /// "Real shading in Unreal Engine 4"). Each level has half the texels
    /// of the one before along an edge.
    pub fn reflections(&self) -> Vec<SkyReflection> {
        let mut chain = vec![self.plain()];
        while let Some(last) = chain.last().filter(|last| last.height > 4) {
            let next = last.halved();
            chain.push(next);
        }
        let [width, height] = self.reflection_size();
        (0..REFLECTION_LEVELS)
            .map(|level| {
                let (width, height) = ((width >> level).max(1), (height >> level).max(1));
                let roughness = level as f32 / (REFLECTION_LEVELS - 1) as f32;
                let rows: Vec<u32> = (0..height).collect();
                let row = |row: &u32| -> Vec<Vec3> {
                    let at =
                        |column| direction([(column as f32 + 0.5) / width as f32, (*row as f32 + 0.5) / height as f32]);
                    (0..width).map(|column| reflected(&chain, at(column), roughness, height)).collect()
                };
                SkyReflection { width, height, texels: parallel::map(&rows, row).concat() }
            })
            .collect()
    }

    /// Width and height of the first of them \[texels\].
    pub fn reflection_size(&self) -> [u32; 2] {
        let width = if self.width == 1 { 1 } else { self.width.clamp(SMALLEST[0], LARGEST[0]) };
        [width, self.height.clamp(SMALLEST[1], LARGEST[1])]
    }

    /// Coefficients c of the irradiance of open surfaces, E(n) = Σ c_i·Y_i(n) with the nine real spherical harmonics of
    /// bands 0 to 2: c = A_l·L_lm (Ramamoorthi and Hanrahan 2001) [W/m²].
    pub fn irradiance_harmonics(&self) -> [Vec3; 9] {
        *self.harmonics.get_or_init(|| self.found_harmonics())
    }

    fn found_harmonics(&self) -> [Vec3; 9] {
        let mut sums = [glam::DVec3::ZERO; 9];
        for (d, radiance, angle) in self.patches() {
            for (sum, y) in sums.iter_mut().zip(harmonics(d)) {
                *sum += (radiance * (y * angle)).as_dvec3();
            }
        }
        let band = |i: usize| {
            if i == 0 {
                PI
            } else if i < 4 {
                TAU / 3.0
            } else {
                PI / 4.0
            }
        };
        std::array::from_fn(|i| sums[i].as_vec3() * band(i))
    }

    /// Radiance on the map, interpolated; `u` and `v` run from 0 to 1.
    fn radiance(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let column = |i: f32| (i as i64).rem_euclid(i64::from(self.width)) as usize;
        let row = |i: f32| (i.max(0.0) as usize).min(self.height as usize - 1);
        let at = |i: f32, j: f32| self.texels[row(j) * self.width as usize + column(i)];
        let across = |j: f32| at(left, j).lerp(at(left + 1.0, j), x - left);
        across(top).lerp(across(top + 1.0), y - top)
    }
}

/// Direction at a place on a map that is not turned.
fn direction([u, v]: [f32; 2]) -> Vec3 {
    let (azimuth, polar) = (TAU * (u - 0.5), PI * v);
    Vec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
}

/// Place of a direction on a map that is not turned.
fn place(d: Vec3) -> [f32; 2] {
    [(0.5 + d.x.atan2(-d.z) / TAU).rem_euclid(1.0), d.y.clamp(-1.0, 1.0).acos() / PI]
}

/// Mean over a GGX lobe that is looked into along its axis: half vectors by D·cosθ, weights by the cosine. Each sample
/// reads the map at the size of its part of the lobe (Křivánek and Colbert 2008, "Real-time shading with filtered
/// importance sampling"); `rows` are those of the target, finer than which nothing is read.
fn reflected(chain: &[SkyMap], axis: Vec3, roughness: f32, rows: u32) -> Vec3 {
    // Texels of a level are π/h wide.
    let level_of = |width: f32| (width * chain[0].height as f32 / PI).log2().max(0.0);
    let finest = level_of(PI / rows as f32);
    let read = |d: Vec3, level: f32| {
        let level = level.min((chain.len() - 1) as f32);
        let (low, at) = (level.floor() as usize, place(d));
        chain[low].radiance(at).lerp(chain[(low + 1).min(chain.len() - 1)].radiance(at), level.fract())
    };
    if roughness <= 0.0 {
        return read(axis, finest);
    }
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    let a2 = roughness.powi(4);
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for i in 0..SAMPLES {
        let u = [(i as f32 + 0.5) / SAMPLES as f32, (i.reverse_bits() as f32) * 2.0_f32.powi(-32)];
        // Walter et al. 2007, eqs. 35 and 36.
        let cosine = ((1.0 - u[0]) / (1.0 + (a2 - 1.0) * u[0])).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let half = axis * cosine + (tangent * (TAU * u[1]).cos() + bitangent * (TAU * u[1]).sin()) * sine;
        let light = 2.0 * cosine * half - axis;
        let weight = light.dot(axis);
        if weight <= 0.0 {
            continue;
        }
        let k = 1.0 + cosine * cosine * (a2 - 1.0);
        // D·cosθ/(4·cosθ): the density of the reflected direction.
        let density = a2 / (PI * k * k) / 4.0;
        let width = (1.0 / (SAMPLES as f32 * density)).sqrt();
        sum += weight * read(light, level_of(width).max(finest));
        weights += weight;
    }
    sum / weights.max(1e-6)
}

/// Real spherical harmonics of bands 0 to 2 (Sloan 2008), as `sh_basis_nine` of `lib/sh.wgsl`.
fn harmonics(d: Vec3) -> [f32; 9] {
    let Vec3 { x, y, z } = d;
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_sky_is_the_same_in_all_mirrors() {
        for level in SkyMap::gradient(Vec3::ONE, Vec3::ONE, Vec3::ONE).reflections() {
            assert!(level.texels.iter().all(|texel| (*texel - 1.0).abs().max_element() < 1e-4), "{}", level.height);
        }
    }

    #[test]
    fn rougher_surfaces_blur_and_keep_the_mean() {
        let sky = SkyMap::gradient(Vec3::new(2.0, 1.0, 0.0), Vec3::ONE, Vec3::ZERO);
        let levels = sky.reflections();
        let last = &levels[levels.len() - 1].texels;
        assert!((levels[0].texels[0] - Vec3::new(2.0, 1.0, 0.0)).abs().max_element() < 0.1, "{}", levels[0].texels[0]);
        assert!(last[0].x < 1.9 && last[0].x > 1.2 && last[last.len() - 1].x > 0.05, "{last:?}");
        for level in &levels {
            let weighted = |(i, texel): (usize, &Vec3)| {
                let polar = PI * (i as f32 + 0.5) / level.height as f32;
                *texel * polar.sin() * PI / level.height as f32 / 2.0
            };
            let mean: Vec3 = level.texels.iter().enumerate().map(weighted).sum();
            assert!((mean - sky.mean()).abs().max_element() < 0.06, "{mean}, {}", sky.mean());
        }
    }

    #[test]
    fn nine_numbers_give_the_irradiance() {
        let sky = SkyMap::gradient(Vec3::new(0.2, 0.5, 1.0), Vec3::new(1.0, 0.6, 0.3), Vec3::splat(0.1));
        let c = sky.irradiance_harmonics();
        for n in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, -0.6, 0.8)] {
            let found: Vec3 = c.iter().zip(harmonics(n)).map(|(c, y)| *c * y).sum();
            let expected = sky.irradiance(n);
            assert!(
                (found - expected).abs().max_element() < 0.05 * expected.max_element().max(1.0),
                "{n}: {found}, {expected}"
            );
        }
    }
}
