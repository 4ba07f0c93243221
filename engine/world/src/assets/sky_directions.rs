//! The choice of directions of a sky by their light (importance sampling).

use super::SkyMap;
use glam::Vec3;

/// Chooses directions of a sky by the flux of its texels.
#[doc(hidden)]
pub struct SkyDirections<'a> {
    map: &'a SkyMap,
    /// Flux of the rows up to each.
    rows: Vec<f64>,
    /// Weights of a row's texels up to each, row by row.
    columns: Vec<f64>,
}

/// Light from one direction of a sky.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct SkySample {
    /// Where it comes from, as a unit vector.
    #[doc(hidden)]
    pub direction: Vec3,
    /// Radiance over the density of the direction \[W/m²\]: its mean over all samples is ∫ L dω.
    #[doc(hidden)]
    pub irradiance: Vec3,
}

impl<'a> SkyDirections<'a> {
    /// For a map that is not black; none for others.
    #[doc(hidden)]
    pub fn new(map: &'a SkyMap) -> Option<Self> {
        let width = map.width as usize;
        let (mut rows, mut columns, mut all) = (Vec::new(), Vec::with_capacity(map.texels.len()), 0.0);
        for (row, texels) in (0..map.height).zip(map.texels.chunks_exact(width)) {
            let mut sum = 0.0;
            columns.extend(texels.iter().map(|texel| {
                sum += f64::from(texel.element_sum());
                sum
            }));
            all += sum * f64::from(map.solid_angle(row));
            rows.push(all);
        }
        (all > 0.0 && all.is_finite()).then_some(Self { map, rows, columns })
    }

    /// ∫ L dω, the mean of the channels \[W/m²\].
    #[doc(hidden)]
    pub fn flux(&self) -> f64 {
        self.rows.last().copied().unwrap_or(0.0) / 3.0
    }

    /// The direction that belongs to a point of the unit square: neighbouring points give neighbouring directions.
    #[doc(hidden)]
    pub fn sample(&self, u: glam::Vec2) -> SkySample {
        let (row, down) = choose(&self.rows, u.x.into());
        let width = self.map.width as usize;
        let (column, across) = choose(&self.columns[row * width..(row + 1) * width], u.y.into());
        let edge = |row: usize| (std::f64::consts::PI * row as f64 / f64::from(self.map.height)).cos();
        let y = edge(row) + (edge(row + 1) - edge(row)) * down;
        let turn = std::f64::consts::TAU * ((column as f64 + across) / width as f64 - 0.5) - f64::from(self.map.turn);
        let horizontal = (1.0 - y * y).max(0.0).sqrt();
        let direction = glam::DVec3::new(horizontal * turn.sin(), y, -horizontal * turn.cos()).as_vec3().normalize();
        // Texels are chosen by the sum of their channels: radiance over density is their colour times the whole flux.
        let radiance = self.map.texels[row * width + column];
        SkySample { direction, irradiance: radiance * (3.0 * self.flux() / f64::from(radiance.element_sum())) as f32 }
    }
}

/// The entry among running sums that a share of the whole falls into, and how far into it.
fn choose(sums: &[f64], share: f64) -> (usize, f64) {
    let whole = sums.last().copied().unwrap_or(0.0);
    let wanted = share * whole;
    // The last entry with a share of its own, should rounding lead beyond it.
    let last = sums.partition_point(|sum| *sum < whole);
    let index = sums.partition_point(|sum| *sum <= wanted).min(last);
    let before = if index > 0 { sums[index - 1] } else { 0.0 };
    (index, ((wanted - before) / (sums[index] - before)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn chosen_directions_add_up_to_the_irradiance() {
        let mut map = SkyMap::new([16, 8], vec![Vec3::new(0.1, 0.2, 0.3); 128], 0.7);
        map.texels[37] = Vec3::new(40.0, 20.0, 10.0);
        map.texels[80..96].fill(Vec3::ZERO);
        let directions = &SkyDirections::new(&map).unwrap();
        let edge = 256;
        let samples = || {
            let at = move |i: u32| glam::Vec2::new((i % edge) as f32 + 0.5, (i / edge) as f32 + 0.5) / edge as f32;
            (0..edge * edge).map(move |i| directions.sample(at(i)))
        };
        let share = 1.0 / (edge * edge) as f32;
        for normal in [Vec3::Y, Vec3::NEG_Y, map.direction(5, 2), Vec3::new(0.6, 0.0, -0.8)] {
            let sum: Vec3 = samples().map(|s| s.irradiance * (s.direction.dot(normal).max(0.0) * share)).sum();
            let expected = map.irradiance(normal);
            assert!((sum / expected - 1.0).abs().max_element() < 0.03, "{normal}: {sum}, expected {expected}");
        }
        let whole: Vec3 = samples().map(|s| s.irradiance * share).sum();
        assert!((whole / (4.0 * PI * map.mean()) - 1.0).abs().max_element() < 1e-3, "{whole}");
        assert!((directions.flux() as f32 / (4.0 * PI * map.mean().element_sum() / 3.0) - 1.0).abs() < 1e-5);
        assert!(SkyDirections::new(&SkyMap::gradient(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO)).is_none());
    }
}
