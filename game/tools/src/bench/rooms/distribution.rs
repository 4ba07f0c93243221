//! Distributions of errors over rooms.

/// Shares of rooms that the report gives: median, 75th, 90th and 95th percentile, worst.
pub const SHARES: [f64; 5] = [0.5, 0.75, 0.9, 0.95, 1.0];

/// The percentiles of some values by nearest rank: the least value that so large a share of all does not exceed. NaN for
/// no values; infinite values come last.
pub fn percentiles<const N: usize>(values: &[f64], shares: [f64; N]) -> [f64; N] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    shares.map(|share| {
        // A hair less, for shares that are no binary fractions: 0.9 of 10 is the ninth.
        let rank = (share * sorted.len() as f64 - 1e-9).ceil().max(1.0) as usize;
        sorted.get(rank - 1).copied().unwrap_or(f64::NAN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_by_nearest_rank() {
        let ten: Vec<f64> = (1..=10).rev().map(f64::from).collect();
        assert_eq!(percentiles(&ten, SHARES), [5.0, 8.0, 9.0, 10.0, 10.0]);
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentiles(&hundred, SHARES), [50.0, 75.0, 90.0, 95.0, 100.0]);
        assert_eq!(percentiles(&[3.0], SHARES), [3.0; 5]);
        assert_eq!(percentiles(&[f64::INFINITY, 1.0, 2.0], [0.5, 1.0]), [2.0, f64::INFINITY]);
        assert!(percentiles(&[], [0.5])[0].is_nan());
    }
}
