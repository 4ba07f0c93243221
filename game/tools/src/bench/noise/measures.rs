//! Measures of noise in an image whose truth is known: error, its fine and its coarse part, fireflies, and blocks of a screen
//! that jump.

use lightwell::measure::{Image, srgb_encode};
use serde::{Deserialize, Serialize};

/// Half the edge of the square of 13×13 that parts grain from blotches [pixels].
const RADIUS: usize = 6;
/// Share of the mean light from which on a pixel that is off by it is a firefly.
const FIREFLY: f64 = 0.25;
/// Edge of the blocks of a screen [pixels].
const BLOCK: usize = 8;
/// Deviation within a block below which it is flat \[255ths\].
const FLAT: f64 = 8.0;
/// Changes of a block's mean that are counted \[255ths\].
pub const JUMPS: [f64; 2] = [6.0, 10.0];

/// Error within a part of an image, relative to the mean of the whole truth, without the truth's own noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Root mean square error.
    pub nrmse: f64,
    /// The same of what a mean of 13×13 takes away.
    pub grain: f64,
    /// The same of means of 13×13.
    pub blotches: f64,
    /// Share of the pixels that are off by more than a quarter of the mean.
    pub fireflies: f64,
}

/// Error of each pixel and channel.
type Errors = Vec<[f64; 3]>;

/// The noise of an image within a part of it, against two independent halves of the truth. None: there is no such part, or the
/// truth is black.
pub fn noise(image: &Image, halves: &[Image; 2], part: &[bool]) -> Option<Noise> {
    let scale = mean_of(halves);
    let count = part.iter().filter(|pixel| **pixel).count();
    if count == 0 || scale <= 0.0 {
        return None;
    }
    let errors = halves.each_ref().map(|half| difference(image, half));
    let coarse = errors.each_ref().map(|errors| local_means(errors, image.size(), part));
    let fine = [0, 1].map(|half| subtract(&errors[half], &coarse[half]));
    let root = |pair: &[Errors; 2]| (product(pair, part) / (3 * count) as f64).max(0.0).sqrt() / scale;
    Some(Noise {
        nrmse: root(&errors),
        grain: root(&fine),
        blotches: root(&coarse),
        fireflies: fireflies(&errors, part, FIREFLY * scale) as f64 / count as f64,
    })
}

/// Root mean square error of an image within a part, and what the noise of the truth's mean makes of it alone, both relative to
/// the mean of the truth.
pub fn error_and_noise(image: &Image, halves: &[Image; 2], part: &[bool]) -> [f64; 2] {
    let (mut square, mut spread, mut count) = (0.0, 0.0, 0.0);
    let pixels = image.pixels().iter().zip(halves[0].pixels()).zip(halves[1].pixels()).zip(part);
    for (((a, r1), r2), _) in pixels.filter(|(_, is_part)| **is_part) {
        for channel in 0..3 {
            let [a, r1, r2] = [a, r1, r2].map(|pixel| f64::from(pixel[channel]));
            square += (a - r1) * (a - r2);
            spread += (r1 - r2) * (r1 - r2);
        }
        count += 3.0;
    }
    let scale = mean_of(halves);
    if count == 0.0 || scale <= 0.0 {
        return [0.0; 2];
    }
    [(square / count).max(0.0).sqrt() / scale, 0.5 * (spread / count).sqrt() / scale]
}

fn mean_of(halves: &[Image; 2]) -> f64 {
    0.5 * (halves[0].mean() + halves[1].mean())
}

/// The difference of two images.
pub fn difference(image: &Image, truth: &Image) -> Vec<[f64; 3]> {
    let pixels = image.pixels().iter().zip(truth.pixels());
    pixels.map(|(a, r)| [0, 1, 2].map(|c| f64::from(a[c]) - f64::from(r[c]))).collect()
}

fn subtract(a: &Errors, b: &Errors) -> Errors {
    a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect()
}

/// Sum of the products of two errors within a part.
fn product([a, b]: &[Errors; 2], part: &[bool]) -> f64 {
    let pixels = a.iter().zip(b).zip(part).filter(|(_, is_part)| **is_part);
    pixels.map(|((a, b), _)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

fn fireflies([a, b]: &[Errors; 2], part: &[bool], bound: f64) -> usize {
    let grey = |error: &[f64; 3]| (error[0] + error[1] + error[2]) / 3.0;
    let pixels = a.iter().zip(b).zip(part).filter(|(_, is_part)| **is_part);
    pixels.filter(|((a, b), _)| (0.5 * (grey(a) + grey(b))).abs() > bound).count()
}

/// For each pixel the mean over the square around it, of those pixels of it that belong to the part.
pub fn local_means(values: &[[f64; 3]], size: [u32; 2], part: &[bool]) -> Vec<[f64; 3]> {
    let [width, height] = size.map(|edge| edge as usize);
    let stride = width + 1;
    // Sums over all pixels above and to the left; the fourth is their number.
    let mut table = vec![[0.0; 4]; stride * (height + 1)];
    for y in 0..height {
        let mut row = [0.0; 4];
        for x in 0..width {
            let index = y * width + x;
            if part[index] {
                let [r, g, b] = values[index];
                row = [row[0] + r, row[1] + g, row[2] + b, row[3] + 1.0];
            }
            let above = table[y * stride + x + 1];
            table[(y + 1) * stride + x + 1] = [0, 1, 2, 3].map(|c| above[c] + row[c]);
        }
    }
    let mean = |index: usize| {
        let (x, y) = (index % width, index / width);
        let [left, top] = [x, y].map(|at| at.saturating_sub(RADIUS));
        let (right, bottom) = ((x + RADIUS + 1).min(width), (y + RADIUS + 1).min(height));
        let at = |x: usize, y: usize| table[y * stride + x];
        let [a, b, c, d] = [at(right, bottom), at(left, bottom), at(right, top), at(left, top)];
        let sum = [0, 1, 2, 3].map(|channel| a[channel] - b[channel] - c[channel] + d[channel]);
        [0, 1, 2].map(|channel| if sum[3] > 0.0 { sum[channel] / sum[3] } else { 0.0 })
    };
    (0..width * height).map(mean).collect()
}

/// What a screen shows, in grey \[255ths\].
#[derive(Clone, Debug)]
pub struct Screen {
    size: [usize; 2],
    grey: Vec<f64>,
}

/// Blocks that are flat in two successive frames, and those whose mean jumps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Jumps {
    /// Blocks that were compared.
    pub blocks: u64,
    /// Those that changed by more than 6 of 255.
    pub above_6: u64,
    /// Those that changed by more than 10 of 255.
    pub above_10: u64,
    /// The largest change \[255ths\].
    pub largest: f64,
}

impl Screen {
    /// Of the light that a screen sends out, linear and 0..1.
    pub fn new(light: &Image) -> Self {
        let encode = |value: f32| 255.0 * f64::from(srgb_encode(value.clamp(0.0, 1.0)));
        let grey = light.pixels().iter().map(|pixel| pixel.map(encode).iter().sum::<f64>() / 3.0).collect();
        Self { size: light.size().map(|edge| edge as usize), grey }
    }

    /// Pixels of each whole block, row by row.
    fn blocks(&self) -> impl Iterator<Item = Vec<usize>> {
        let [width, height] = self.size;
        let columns = width / BLOCK;
        (0..columns * (height / BLOCK)).map(move |block| {
            let corner = (block / columns) * BLOCK * width + (block % columns) * BLOCK;
            (0..BLOCK * BLOCK).map(|pixel| corner + (pixel / BLOCK) * width + pixel % BLOCK).collect()
        })
    }

    fn mean(&self, block: &[usize]) -> f64 {
        block.iter().map(|&pixel| self.grey[pixel]).sum::<f64>() / block.len() as f64
    }

    /// Whether the pixels of a block differ little.
    fn is_flat(&self, block: &[usize]) -> bool {
        let mean = self.mean(block);
        let square: f64 = block.iter().map(|&pixel| (self.grey[pixel] - mean).powi(2)).sum();
        (square / block.len() as f64).sqrt() < FLAT
    }

    /// Root mean square difference from an average in the blocks that are flat in it \[255ths\]. None: there are none.
    pub fn flat_difference(&self, average: &Self) -> Option<f64> {
        let (mut square, mut count) = (0.0, 0);
        for block in average.blocks().filter(|block| average.is_flat(block)) {
            square += block.iter().map(|&pixel| (self.grey[pixel] - average.grey[pixel]).powi(2)).sum::<f64>();
            count += block.len();
        }
        (count > 0).then(|| (square / count as f64).sqrt())
    }
}

impl Jumps {
    /// Compares a frame with the one before it.
    pub fn add(&mut self, before: &Screen, now: &Screen) {
        for block in now.blocks().filter(|block| before.is_flat(block) && now.is_flat(block)) {
            let jump = (now.mean(&block) - before.mean(&block)).abs();
            self.blocks += 1;
            self.above_6 += u64::from(jump > JUMPS[0]);
            self.above_10 += u64::from(jump > JUMPS[1]);
            self.largest = self.largest.max(jump);
        }
    }
}

/// The value that a share of all does not exceed (nearest rank); 0 of none.
pub fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((share * values.len() as f64 - 1e-9).ceil().max(1.0) as usize).min(values.len()) - 1;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use xxhash_rust::xxh3::xxh3_64;

    const SIZE: [u32; 2] = [256, 256];

    fn image(of: impl Fn(u32, u32, u32) -> f32) -> Image {
        let [width, height] = SIZE;
        let pixel = |index: u32| [0, 1, 2].map(|c| of(index % width, index / width, c));
        Image::from_pixels(width, height, (0..width * height).map(pixel).collect()).unwrap()
    }

    /// Numbers of mean 0 and variance 1, even between ±√3.
    fn random(seed: u32, x: u32, y: u32, channel: u32) -> f32 {
        let bits = xxh3_64(&[seed, x, y, channel].map(u32::to_le_bytes).concat()) >> 40;
        3.0_f32.sqrt() * (2.0 * bits as f32 / 2.0_f32.powi(24) - 1.0)
    }

    fn all() -> Vec<bool> {
        vec![true; (SIZE[0] * SIZE[1]) as usize]
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, not {expected}");
    }

    #[test]
    fn white_noise_is_grain_and_what_a_mean_leaves_of_it() {
        let truth = || Image::filled(SIZE[0], SIZE[1], [2.0; 3]);
        let found = noise(&image(|x, y, c| 2.0 + 0.1 * random(1, x, y, c)), &[truth(), truth()], &all()).unwrap();
        near(found.nrmse, 0.05, 0.01);
        near(found.grain, 0.05 * (1.0 - 1.0 / 169.0_f64).sqrt(), 0.01);
        // A little more at the image's edges, where fewer pixels are averaged.
        near(found.blotches, 0.05 / 13.0, 0.12);
    }

    #[test]
    fn noise_in_large_squares_is_blotches() {
        let truth = || Image::filled(SIZE[0], SIZE[1], [1.0; 3]);
        let found = noise(&image(|x, y, c| 1.0 + 0.1 * random(2, x / 64, y / 64, c)), &[truth(), truth()], &all());
        let found = found.unwrap();
        assert!(found.blotches > 0.9 * found.nrmse && found.grain < 0.3 * found.nrmse, "{found:?}");
    }

    #[test]
    fn noise_of_the_truth_is_none_of_the_image() {
        let half = |seed| image(|x, y, c| 1.0 + 0.2 * random(seed, x, y, c));
        let halves = [half(3), half(4)];
        let right = noise(&Image::filled(SIZE[0], SIZE[1], [1.0; 3]), &halves, &all()).unwrap();
        assert!(right.nrmse < 0.02 && right.grain < 0.02 && right.blotches < 0.005, "{right:?}");
        let off = Image::filled(SIZE[0], SIZE[1], [1.3; 3]);
        near(noise(&off, &halves, &all()).unwrap().blotches, 0.3, 0.01);
        let [error, own] = error_and_noise(&off, &halves, &all());
        near(error, 0.3, 0.01);
        near(own, 0.2 / 2.0_f64.sqrt(), 0.01);
    }

    #[test]
    fn parts_are_measured_each_by_itself() {
        let truth = || Image::filled(SIZE[0], SIZE[1], [1.0; 3]);
        let halves = [truth(), truth()];
        // The left half is off by 0.5, the right one is right, up to the very border.
        let half_wrong = image(|x, _, _| if x < 128 { 1.5 } else { 1.0 });
        let left: Vec<bool> = (0..SIZE[0] * SIZE[1]).map(|index| index % SIZE[0] < 128).collect();
        let right: Vec<bool> = left.iter().map(|left| !left).collect();
        let found = noise(&half_wrong, &halves, &left).unwrap();
        near(found.blotches, 0.5, 1e-6);
        assert!(found.grain < 1e-6 && found.fireflies == 1.0, "{found:?}");
        assert_eq!(noise(&half_wrong, &halves, &right), Some(Noise::default()));
        assert_eq!(noise(&half_wrong, &halves, &vec![false; left.len()]), None);
    }

    #[test]
    fn fireflies_are_counted() {
        let truth = || Image::filled(SIZE[0], SIZE[1], [1.0; 3]);
        // One pixel of 256 is far too bright, one too dark, one just within a quarter.
        let spots = image(|x, y, _| match (x * 7 + y * 13) % 256 {
            0 => 9.0,
            1 => 0.7,
            2 => 1.24,
            _ => 1.0,
        });
        let found = noise(&spots, &[truth(), truth()], &all()).unwrap();
        assert_eq!(found.fireflies, 2.0 / 256.0);
    }

    /// Linear light that a screen shows as this grey.
    fn shown(grey: f64) -> f32 {
        lightwell::measure::srgb_decode((grey / 255.0) as f32)
    }

    #[test]
    fn blocks_that_jump_are_counted() {
        let before = Screen::new(&image(|_, _, _| shown(100.0)));
        // One block by 7, one by 12; one that has an edge through it changes too, but is not flat.
        let now = Screen::new(&image(|x, y, _| match (x / 8, y / 8) {
            (3, 4) => shown(107.0),
            (9, 2) => shown(112.0),
            (20, 20) => shown(if x % 8 < 4 { 100.0 } else { 200.0 }),
            _ => shown(100.0),
        }));
        let mut jumps = Jumps::default();
        jumps.add(&before, &now);
        assert_eq!((jumps.blocks, jumps.above_6, jumps.above_10), (32 * 32 - 1, 2, 1));
        near(jumps.largest, 12.0, 1e-3);
        jumps.add(&now, &now);
        assert_eq!((jumps.above_6, jumps.above_10), (2, 1));
    }

    #[test]
    fn flat_parts_differ_by_their_noise() {
        let average = Screen::new(&image(|x, _, _| shown(if x == 100 { 250.0 } else { 100.0 })));
        let first = Screen::new(&image(|x, y, _| {
            let noise = f64::from(random(5, x, y, 0));
            shown(if x == 100 { 50.0 } else { 100.0 + 2.0 * noise })
        }));
        near(first.flat_difference(&average).unwrap(), 2.0, 0.02);
    }

    #[test]
    fn percentiles_by_nearest_rank() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!([0.5, 0.95, 1.0].map(|share| percentile(values.clone(), share)), [50.0, 95.0, 100.0]);
        assert_eq!(percentile(Vec::new(), 0.5), 0.0);
    }
}
