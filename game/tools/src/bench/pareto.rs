//! Which methods no other one beats in both time and error, and what path tracing would need for the same error.

/// Indices of the points (time, error) that no other point beats: none is faster with at most the error, or better in
/// at most the time. In order of time.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    order
}

/// Time at which a curve of points (time, error) reaches an error: a line between the points in the logarithms of
/// both. Beyond the last point noise falls with the square root of the time. The flag says that the time lies beyond
/// what was measured.
pub fn time_for_error(curve: &[(f64, f64)], error: f64) -> Option<(f64, bool)> {
    let mut curve: Vec<(f64, f64)> = curve.iter().copied().filter(|&(t, e)| t > 0.0 && e > 0.0).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (&first, &last) = (curve.first()?, curve.last()?);
    if !(error > 0.0 && error.is_finite()) {
        return None;
    }
    if error >= first.1 {
        return Some((first.0 * (first.1 / error).powi(2), error > first.1));
    }
    for pair in curve.windows(2) {
        let ((t0, e0), (t1, e1)) = (pair[0], pair[1]);
        if e0 >= error && error >= e1 && e0 > e1 {
            let share = (e0 / error).ln() / (e0 / e1).ln();
            return Some((t0 * (t1 / t0).powf(share), false));
        }
    }
    Some((last.0 * (last.1 / error).powi(2), true))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(4.0, 0.1), (1.0, 0.9), (2.0, 0.95), (2.0, 0.5), (8.0, 0.1), (16.0, 0.05), (1.0, f64::INFINITY)];
        assert_eq!(front(&points), [1, 3, 0, 5]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn times_between_and_beyond_the_points() {
        // Error falls with the root of the time, as noise does.
        let curve = [(1.0, 0.8), (4.0, 0.4), (16.0, 0.2)];
        for (error, time, beyond) in
            [(0.4, 4.0, false), (0.2 * 2f64.sqrt(), 8.0, false), (0.1, 64.0, true), (1.6, 0.25, true)]
        {
            let (found, outside) = time_for_error(&curve, error).unwrap();
            assert!((found - time).abs() < 1e-9 && outside == beyond, "{error}: {found}");
        }
        assert_eq!(time_for_error(&[], 0.1), None);
        assert_eq!(time_for_error(&curve, 0.0), None);
    }
}
