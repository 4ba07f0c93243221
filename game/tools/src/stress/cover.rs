//! Covering arrays: few rows in which every pair of levels of two factors occurs.

use std::collections::BTreeSet;

/// Rows of levels, one of each factor, such that every pair of levels of any two factors stands in one of them. Greedy,
/// a row at a time (Cohen, Dalal, Fredman and Patton 1997): a pair that is still missing is taken, and each other
/// factor gets the level that adds most pairs. The same rows every time.
pub fn pairwise(levels: &[usize]) -> Vec<Vec<usize>> {
    let mut missing = BTreeSet::new();
    for (first, &a) in levels.iter().enumerate() {
        for (second, &b) in levels.iter().enumerate().skip(first + 1) {
            missing.extend((0..a).flat_map(|i| (0..b).map(move |j| ((first, i), (second, j)))));
        }
    }
    let mut rows = Vec::new();
    while let Some(&pair) = missing.first() {
        let mut row = vec![None; levels.len()];
        (row[pair.0.0], row[pair.1.0]) = (Some(pair.0.1), Some(pair.1.1));
        for factor in 0..levels.len() {
            if row[factor].is_none() {
                row[factor] = (0..levels[factor])
                    // The first of the best; the start moves on from row to row, so that ties are spread.
                    .map(|level| (level + rows.len()) % levels[factor])
                    .rev()
                    .max_by_key(|&level| pairs_of(&row, (factor, level)).filter(|p| missing.contains(p)).count());
            }
        }
        let row: Vec<usize> = row.into_iter().map(Option::unwrap_or_default).collect();
        for first in 0..row.len() {
            for second in first + 1..row.len() {
                missing.remove(&((first, row[first]), (second, row[second])));
            }
        }
        rows.push(row);
    }
    rows
}

type Choice = (usize, usize);

/// The pairs that a choice makes with those that are made.
fn pairs_of(row: &[Option<usize>], choice: Choice) -> impl Iterator<Item = (Choice, Choice)> {
    row.iter().enumerate().filter_map(move |(factor, level)| {
        let other = (factor, (*level)?);
        Some(if factor < choice.0 { (other, choice) } else { (choice, other) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_pair_occurs_and_the_rows_are_few() {
        for levels in [vec![6, 7, 5, 3, 3, 3], vec![2, 2], vec![4, 1, 3]] {
            let rows = pairwise(&levels);
            for (f, &a) in levels.iter().enumerate() {
                for (g, &b) in levels.iter().enumerate().skip(f + 1) {
                    let found: HashSet<_> = rows.iter().map(|row| (row[f], row[g])).collect();
                    assert_eq!(found.len(), a * b, "{levels:?}: {f} and {g}");
                }
            }
            let mut sorted = levels.clone();
            sorted.sort_unstable_by(|a, b| b.cmp(a));
            let least = sorted[0] * sorted[1];
            assert!(rows.len() <= least + least / 2, "{} rows, no fewer than {least}", rows.len());
        }
    }
}
