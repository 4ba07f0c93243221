//! Sub-pixel shifts of averaged frames.

/// Shift of frame `index` of an average of `count`, in pixels, each in −½..½: the Hammersley set, whose mean is the
/// pixel's centre for powers of two, so that the average is not shifted. A single frame is not shifted.
pub fn shift(index: u32, count: u32) -> [f32; 2] {
    let count = f64::from(count.max(1));
    let x = (f64::from(index) + 0.5) / count;
    // The radical inverse in base 2 lies at the lower ends of its cells.
    let y = f64::from(index.reverse_bits()) / 2f64.powi(32) + 0.5 / count;
    [x - 0.5, y - 0.5].map(|v| v as f32)
}

/// Shifts of pair `index` of an average whose length is not known ahead, in pixels, each in −½..½: one for each of two
/// halves. The second is the first mirrored at the pixel's centre, so that the mean of any number of pairs is the centre.
///
/// The first ones are the R2 sequence, which fills a square evenly at every length (M. Roberts, "The Unreasonable
/// Effectiveness of Quasirandom Sequences", 2018). No two shifts are equal, which matters since random numbers follow
/// from the shift.
pub fn pair(index: u32) -> [[f32; 2]; 2] {
    /// Powers of the inverse of the plastic number, the root of x³ = x + 1.
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    /// With this start the sum of the shifts of a half stays within 1.3 pixels for the first 256.
    const START: [f64; 2] = [0.8, 0.175];
    let number = f64::from(index) + 1.0;
    let first = [0, 1].map(|axis| ((START[axis] + number * STEP[axis]).fract() - 0.5) as f32);
    [first, first.map(|v| -v)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_any_number_are_centred_and_fill_the_pixel() {
        let (mut both, mut first) = ([0.0f64; 2], [0.0f64; 2]);
        let mut cells = [0u32; 16];
        let mut seen = std::collections::BTreeSet::new();
        for index in 0..256 {
            let halves = pair(index);
            for [x, y] in halves {
                assert!((-0.5..=0.5).contains(&x) && (-0.5..=0.5).contains(&y), "{x} {y}");
                assert!(seen.insert([x, y].map(f32::to_bits)), "{x} {y} comes twice");
                cells[((x + 0.5) * 4.0).min(3.0) as usize + 4 * ((y + 0.5) * 4.0).min(3.0) as usize] += 1;
            }
            for axis in 0..2 {
                both[axis] += f64::from(halves[0][axis]) + f64::from(halves[1][axis]);
                first[axis] += f64::from(halves[0][axis]);
                assert_eq!(both[axis], 0.0, "after {} pairs", index + 1);
                assert!(first[axis].abs() < 1.3, "after {} images of a half: {first:?}", index + 1);
            }
        }
        assert!(cells.iter().all(|&count| count.abs_diff(32) <= 4), "{cells:?}");
    }

    #[test]
    fn a_single_frame_is_not_shifted() {
        assert_eq!(shift(0, 1), [0.0; 2]);
    }

    #[test]
    fn shifts_fill_the_pixel_evenly() {
        for count in [4u32, 16, 64, 100, 256] {
            let mut sum = [0.0f64; 2];
            let mut quarters = [0u32; 4];
            for [x, y] in (0..count).map(|i| shift(i, count)) {
                assert!((-0.5..=0.5).contains(&x) && (-0.5..=0.5).contains(&y), "{x} {y}");
                sum = [sum[0] + f64::from(x), sum[1] + f64::from(y)];
                quarters[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] += 1;
            }
            let bound = if count.is_power_of_two() { 1e-6 } else { 0.01 };
            assert!(sum.iter().all(|s| (s / f64::from(count)).abs() < bound), "{count}: {sum:?}");
            assert!(quarters.iter().all(|&q| q.abs_diff(count / 4) <= count / 32), "{count}: {quarters:?}");
        }
    }
}
