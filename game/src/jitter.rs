//! Sub-pixel shifts of averaged frames.

/// Shift of frame `index` of an average, in pixels, each in −½..½: the R2 sequence (Roberts 2018), additive
/// recurrences of the inverse powers of the plastic number. Frame 0 is not shifted.
pub fn shift(index: u32) -> [f32; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| ((0.5 + f64::from(index) * step).fract() - 0.5) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_fill_the_pixel_evenly() {
        assert_eq!(shift(0), [0.0; 2]);
        for count in [16u32, 64, 256] {
            let mut sum = [0.0f64; 2];
            let mut quarters = [0u32; 4];
            for i in 0..count {
                let [x, y] = shift(i);
                assert!((-0.5..=0.5).contains(&x) && (-0.5..=0.5).contains(&y), "{x} {y}");
                sum = [sum[0] + f64::from(x), sum[1] + f64::from(y)];
                quarters[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] += 1;
            }
            assert!(sum.iter().all(|s| (s / f64::from(count)).abs() < 0.5 / f64::from(count).sqrt()), "{sum:?}");
            assert!(quarters.iter().all(|&q| q.abs_diff(count / 4) <= count / 16 + 1), "{quarters:?}");
        }
    }
}
