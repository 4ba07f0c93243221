//! Skies by direction: radiance on an equirectangular grid, with the tables to choose bright directions by.

use super::sky_image::decode;
use super::{AssetError, AssetId};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::path::Path;
use std::sync::{Mutex, OnceLock};

/// Widest map that is kept \[texels\]: a tenth of the moon's width. Wider images are averaged down.
const MAX_WIDTH: u32 = 2048;
/// Rows of a gradient.
const GRADIENT_ROWS: u32 = 512;
/// Radiance of the sky by direction. Column u goes round the horizon, row v from the zenith to the nadir; the middle
/// of the image lies towards −Z, and what is right of it towards +X.
#[derive(Debug)]
pub struct SkyMap {
    /// Identity for caches: no two maps of a process share it.
    pub id: AssetId,
    /// Width \[texels\].
    pub width: u32,
    /// Height \[texels\].
    pub height: u32,
    /// Radiance [W/(m² sr)], row by row from the zenith down.
    pub texels: Vec<Vec3>,
    /// How far the map is turned about the vertical, counter-clockwise seen from above \[rad\].
    pub turn: f32,
    /// Arguments and results of the calls of [`SkyMap::around`].
    around: Mutex<Vec<(Vec<Vec3>, Vec<Vec3>)>>,
    /// See [`SkyMap::irradiance_harmonics`], once they were asked for.
    pub(super) harmonics: OnceLock<[Vec3; 9]>,
}

impl SkyMap {
    pub(super) fn new([width, height]: [u32; 2], texels: Vec<Vec3>, turn: f32) -> Self {
        Self { id: AssetId::fresh(), width, height, texels, turn, around: Mutex::default(), harmonics: OnceLock::new() }
    }

    /// A sky that changes with height alone: from the horizon up by √sin of the elevation to the zenith, and in the
    /// same way down to the ground. All are radiances [W/(m² sr)].
    pub fn gradient(zenith: Vec3, horizon: Vec3, ground: Vec3) -> Self {
        let row = |row: u32| {
            let sine = (PI * (row as f32 + 0.5) / GRADIENT_ROWS as f32).cos();
            horizon.lerp(if sine >= 0.0 { zenith } else { ground }, sine.abs().sqrt())
        };
        let texels = (0..GRADIENT_ROWS).map(row).collect();
        Self::new([1, GRADIENT_ROWS], texels, 0.0)
    }

    /// Reads an equirectangular Radiance (`.hdr`) or OpenEXR image, linear Rec. 709. `intensity` multiplies its values;
    /// `turn` as in [`SkyMap::turn`].
    ///
    /// # Errors
    /// If the file cannot be read, is no such image, or holds values that are not finite.
    pub fn load(path: &Path, intensity: f32, turn: f32) -> Result<Self, AssetError> {
        let bytes = super::read_file(path, &super::Meter::default())?;
        let (width, height, values) = decode(path, &bytes)?;
        if values.iter().any(|value| !value.is_finite()) {
            let problem = "holds values that are not finite: save it again without NaN and infinity";
            return Err(AssetError::format(path, "sky image", problem));
        }
        let texels = values.as_chunks().0.iter().map(|&rgb| Vec3::from(rgb).max(Vec3::ZERO) * intensity).collect();
        let mut map = Self::new([width, height], texels, turn);
        while map.width > MAX_WIDTH && map.height > 1 {
            map = map.halved();
        }
        Ok(map)
    }

    /// The same sky, so many times as bright and turned otherwise.
    pub fn varied(&self, factor: f32, turn: f32) -> Self {
        self.lit(Vec3::splat(factor), turn)
    }

    /// The same sky, every channel so many times as bright, and turned otherwise.
    pub(crate) fn lit(&self, factor: Vec3, turn: f32) -> Self {
        Self::new([self.width, self.height], self.texels.iter().map(|texel| *texel * factor).collect(), turn)
    }

    /// The same sky, not turned.
    pub(super) fn plain(&self) -> Self {
        Self::new([self.width, self.height], self.texels.clone(), 0.0)
    }

    /// The same sky with half the texels along each edge.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let at = |x: u32, y: u32| self.texels[(y.min(self.height - 1) * self.width + x.min(self.width - 1)) as usize];
        let mean = |i: u32| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        let texels = (0..width * height).map(mean).collect();
        Self::new([width, height], texels, self.turn)
    }

    /// Solid angle of each texel of a row \[sr\].
    pub fn solid_angle(&self, row: u32) -> f32 {
        let edge = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(self.height)).cos();
        (std::f64::consts::TAU / f64::from(self.width) * (edge(row) - edge(row + 1))) as f32
    }

    /// Direction of the middle of a texel.
    pub fn direction(&self, column: u32, row: u32) -> Vec3 {
        self.towards((column as f32 + 0.5) / self.width as f32, row)
    }

    /// Direction at a part of the way round, in the middle of a row.
    fn towards(&self, u: f32, row: u32) -> Vec3 {
        let azimuth = TAU * (u - 0.5) - self.turn;
        let polar = PI * (row as f32 + 0.5) / self.height as f32;
        Vec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
    }

    /// Mean radiance over all directions [W/(m² sr)].
    pub fn mean(&self) -> Vec3 {
        self.patches().map(|(_, radiance, angle)| (radiance * angle).as_dvec3()).sum::<glam::DVec3>().as_vec3()
            / (2.0 * TAU)
    }

    /// Irradiance of an open surface [W/m²]: E(n) = ∫ L(ω)·max(0, n·ω) dω.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        let part = |(d, radiance, angle): (Vec3, Vec3, f32)| (radiance * (angle * d.dot(normal).max(0.0))).as_dvec3();
        self.patches().map(part).sum::<glam::DVec3>().as_vec3()
    }

    /// Direction, radiance and solid angle of patches that make up the sky: its texels, those of narrow maps in
    /// several parts.
    pub(super) fn patches(&self) -> impl Iterator<Item = (Vec3, Vec3, f32)> + '_ {
        let parts = 128u32.div_ceil(self.width);
        (0..self.height).flat_map(move |row| {
            let angle = self.solid_angle(row) / parts as f32;
            (0..self.width * parts).map(move |column| {
                let radiance = self.texels[(row * self.width + column / parts) as usize];
                (self.towards((column as f32 + 0.5) / (self.width * parts) as f32, row), radiance, angle)
            })
        })
    }

    /// Mean radiance around each of some directions: every part of the sky counts for the direction that it lies
    /// nearest to.
    pub fn around(&self, directions: &[Vec3]) -> Vec<Vec3> {
        // A poisoned lock holds a whole answer or an old one, and both are told apart by the question.
        let mut known = self.around.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, answer)) = known.iter().find(|(asked, _)| asked == directions) {
            return answer.clone();
        }
        let answer = self.gathered_around(directions);
        // A few sets of directions are in use at a time.
        known.truncate(3);
        known.insert(0, (directions.to_vec(), answer.clone()));
        answer
    }

    fn gathered_around(&self, directions: &[Vec3]) -> Vec<Vec3> {
        let mut coarse = None;
        while coarse.as_ref().unwrap_or(self).width > 128 {
            coarse = Some(coarse.as_ref().unwrap_or(self).halved());
        }
        let mut sums = vec![(Vec3::ZERO, 0.0); directions.len()];
        for (d, radiance, angle) in coarse.as_ref().unwrap_or(self).patches() {
            let nearest = directions.iter().map(|other| d.dot(*other)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((sum, weight)) = nearest.and_then(|(index, _)| sums.get_mut(index)) {
                *sum += radiance * angle;
                *weight += angle;
            }
        }
        sums.into_iter().map(|(sum, weight)| if weight > 0.0 { sum / weight } else { Vec3::ZERO }).collect()
    }

    /// Mean of each texel's radiance as it is interpolated: by 1, 6, 1 eighths of the texels around, both ways. A bright
    /// texel shines into its neighbours, which must then have a chance too.
    fn weights(&self) -> Vec<f64> {
        let (width, height) = (self.width as usize, self.height as usize);
        let own: Vec<f64> = self.texels.iter().map(|t| f64::from(t.element_sum())).collect();
        let across = |i: usize| {
            let (row, x) = (i - i % width, i % width);
            (own[row + (x + width - 1) % width] + 6.0 * own[i] + own[row + (x + 1) % width]) / 8.0
        };
        let rows: Vec<f64> = (0..own.len()).map(across).collect();
        let down = |i: usize| {
            let (x, y) = (i % width, i / width);
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            (rows[above * width + x] + 6.0 * rows[i] + rows[below * width + x]) / 8.0
        };
        (0..own.len()).map(down).collect()
    }

    /// Rows of texels for the device: radiance, and in alpha the chance that the texel or one before it in its row is
    /// chosen; after each row one more texel, whose alpha is the chance of that row or one above it. Chances go with
    /// the flux of the texels (importance sampling; Pharr, Jakob and Humphreys, section 12.5).
    pub fn table(&self) -> Vec<[f32; 4]> {
        let mut table = Vec::with_capacity(((self.width + 1) * self.height) as usize);
        let weights = self.weights();
        let rows: Vec<f64> = (0..self.height)
            .map(|row| {
                let first = (row * self.width) as usize;
                weights[first..first + self.width as usize].iter().sum::<f64>() * f64::from(self.solid_angle(row))
            })
            .collect();
        let (all, mut above) = (rows.iter().sum::<f64>(), 0.0);
        let share = |part: f64, whole: f64, index: u32, count: u32| match whole > 0.0 {
            // The last is exactly one, so that a choice always ends.
            _ if index + 1 == count => 1.0,
            true => (part / whole) as f32,
            false => (index + 1) as f32 / count as f32,
        };
        for row in 0..self.height {
            let first = (row * self.width) as usize;
            let whole: f64 = weights[first..first + self.width as usize].iter().sum();
            let mut sum = 0.0;
            for column in 0..self.width {
                sum += weights[first + column as usize];
                let radiance = self.texels[first + column as usize];
                table.push(radiance.extend(share(sum, whole, column, self.width)).to_array());
            }
            above += rows[row as usize];
            table.push([0.0, 0.0, 0.0, share(above, all, row, self.height)]);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
        (a - b).abs().max_element() <= tolerance * b.abs().max_element().max(1e-6)
    }

    #[test]
    fn an_even_sky_gives_pi() {
        let even = SkyMap::gradient(Vec3::ONE, Vec3::ONE, Vec3::ONE);
        assert!(near(even.mean(), Vec3::ONE, 1e-5), "{}", even.mean());
        for normal in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(0.6, -0.8, 0.0)] {
            assert!(near(even.irradiance(normal), Vec3::splat(PI), 1e-3), "{}", even.irradiance(normal));
        }
        let directions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        assert!(even.around(&directions).iter().all(|l| near(*l, Vec3::ONE, 1e-4)));
    }

    #[test]
    fn the_ground_lights_what_looks_down() {
        let sky = SkyMap::gradient(Vec3::Z, Vec3::ZERO, Vec3::X);
        // ∫ √cosθ·cosθ dω over the hemisphere: 2π ∫ μ^{3/2} dμ = 4π/5.
        assert!(near(sky.irradiance(Vec3::Y), Vec3::Z * (0.8 * PI), 1e-2), "{}", sky.irradiance(Vec3::Y));
        assert!(near(sky.irradiance(Vec3::NEG_Y), Vec3::X * (0.8 * PI), 1e-2));
    }

    #[test]
    fn images_are_read_and_turned() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sky.exr");
        let mut image = image::Rgb32FImage::new(8, 4);
        image.put_pixel(4, 1, image::Rgb([2.0, 1.0, 0.5]));
        image.save(&path).unwrap();
        let sky = SkyMap::load(&path, 2.0, 0.0).unwrap();
        assert_eq!((sky.width, sky.height), (8, 4));
        let brightest =
            (0..32u32).max_by(|a, b| sky.texels[*a as usize].x.total_cmp(&sky.texels[*b as usize].x)).unwrap();
        assert_eq!(sky.texels[brightest as usize], Vec3::new(4.0, 2.0, 1.0));
        let d = sky.direction(brightest % 8, brightest / 8);
        assert!(d.z < 0.0 && d.x > 0.0 && d.x < 0.5 && d.y > 0.0, "right of the middle: {d}");
        let turned = SkyMap::load(&path, 2.0, PI / 2.0).unwrap();
        let d = turned.direction(brightest % 8, brightest / 8);
        assert!(d.x < 0.0 && d.z < 0.0 && d.z > -0.5, "−Z turned a quarter to the left is −X: {d}");
    }

    #[test]
    fn bad_images_say_what_to_do() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sky.hdr");
        let message = |path: &Path| SkyMap::load(path, 1.0, 0.0).unwrap_err().to_string();
        assert!(message(&path).contains("sky.hdr"));
        std::fs::write(&path, b"no image").unwrap();
        assert!(message(&path).contains("convert it"), "{}", message(&path));
        std::fs::write(&path, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\nxx").unwrap();
        assert!(message(&path).contains("sky.hdr"), "{}", message(&path));
        std::fs::write(&path, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4096 +X 8192\nxx").unwrap();
        assert!(message(&path).contains("more than 53 bytes can hold"), "{}", message(&path));
        let square = dir.path().join("square.exr");
        image::Rgb32FImage::new(4, 4).save(&square).unwrap();
        assert!(message(&square).contains("twice as wide"), "{}", message(&square));
    }

    #[test]
    fn chances_rise_to_one() {
        let mut sky = SkyMap::gradient(Vec3::ONE, Vec3::ZERO, Vec3::ZERO);
        sky.texels[7] = Vec3::splat(1e6);
        let table = sky.table();
        assert_eq!(table.len(), 2 * GRADIENT_ROWS as usize);
        let rows: Vec<f32> = table.iter().skip(1).step_by(2).map(|texel| texel[3]).collect();
        assert!(rows.windows(2).all(|pair| pair[0] <= pair[1]) && rows.last() == Some(&1.0));
        assert!(rows[8] - rows[5] > 0.99, "the bright row and its neighbours are nearly always chosen");
    }
}
