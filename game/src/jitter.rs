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

#[cfg(test)]
mod tests {
    use super::*;

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
