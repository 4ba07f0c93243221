//! Cost over the number of something, and pairs.

use super::markdown::{mib, ms, table, times, whole};
use crate::bench::growth::{Growth, GrowthPoint, Pair};
use crate::bench::plot::{self, Curve};
use crate::bench::results::{Results, Spread};
use anyhow::Result;
use std::path::Path;

/// Times below this are mostly what every frame costs [ms]; how they grow says nothing.
const LEAST: f64 = 2.0;

fn file(curve: &Growth) -> String {
    format!("plots/growth_{}_{}.png", curve.axis, curve.series)
}

fn title(curve: &Growth) -> String {
    format!("{}, {}", curve.axis, curve.series)
}

fn measured(curve: &Growth) -> impl Iterator<Item = &GrowthPoint> {
    curve.points.iter().filter(|point| point.refused.is_none())
}

/// Draws the curves.
///
/// # Errors
/// If a file cannot be written.
pub fn draw(folder: &Path, results: &Results) -> Result<()> {
    for curve in &results.growth {
        let points = |value: fn(&GrowthPoint) -> f64| measured(curve).map(|p| (p.count as f64, value(p))).collect();
        let curves = [
            Curve { label: "everything computed, from start to end [ms]", points: points(|p| p.frame.median) },
            Curve { label: "one object moved [ms]", points: points(|p| p.moved.median) },
            Curve { label: "nothing changed [ms]", points: points(|p| p.still.median) },
        ];
        plot::sweep(&folder.join(file(curve)), &title(curve), &curves, &curve.axis)?;
    }
    Ok(())
}

/// How fast a value grows between two points: its power of the number.
fn exponent(a: &GrowthPoint, b: &GrowthPoint, value: fn(&GrowthPoint) -> f64) -> f64 {
    (value(b) / value(a)).ln() / (b.count as f64 / a.count as f64).ln()
}

/// The steepest growth of a frame's time between neighbours, where it counts.
fn steepest(curve: &Growth) -> Option<(f64, u64)> {
    let points: Vec<&GrowthPoint> = measured(curve).collect();
    let counts = |pair: &&[&GrowthPoint]| pair[1].frame.median > LEAST;
    let steps = points.windows(2).filter(counts);
    steps.map(|pair| (exponent(pair[0], pair[1], |p| p.frame.median), pair[1].count)).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Memory for one more, from the two largest points [bytes].
fn per_item(curve: &Growth, value: fn(&GrowthPoint) -> Option<u64>) -> Option<f64> {
    let points: Vec<&GrowthPoint> = measured(curve).collect();
    let [.., a, b] = points[..] else { return None };
    Some((value(b)? as f64 - value(a)? as f64) / (b.count - a.count) as f64)
}

fn bytes(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| if value < 10.0 { format!("{value:.1}") } else { format!("{value:.0}") })
}

fn reading(curve: &Growth) -> String {
    let growth = steepest(curve).map_or("too fast to tell how it grows".to_owned(), |(power, count)| {
        format!("at its steepest, below {}, a frame's time grows with the power {power:.2} of the number", whole(count))
    });
    let targets = bytes(per_item(curve, |point| Some(point.target_bytes)));
    let process = bytes(per_item(curve, |point| point.process_bytes));
    format!(
        "{growth}; one more takes {targets} bytes of the frame's targets and buffers, and {process} of the process."
    )
}

fn rows(curve: &Growth) -> Vec<Vec<String>> {
    let row = |point: &GrowthPoint| {
        let times = [&point.frame, &point.device, &point.record, &point.moved, &point.still].map(|t| ms(t.median));
        let process = point.process_bytes.map_or("-".to_owned(), mib);
        let first = [whole(point.count), ms(point.load_ms)];
        let last = [whole(point.draws), whole(point.triangles), mib(point.target_bytes), process];
        first.into_iter().chain(times).chain(last).collect()
    };
    measured(curve).map(row).collect()
}

fn refusals(curve: &Growth) -> String {
    let line =
        |point: &GrowthPoint| Some(format!("\n{} {}: {}\n", whole(point.count), curve.axis, point.refused.as_ref()?));
    curve.points.iter().filter_map(line).collect()
}

/// The curves in numbers and as plots.
pub fn section(results: &Results) -> Option<String> {
    let head = [
        "number",
        "load [ms]",
        "frame [ms]",
        "device [ms]",
        "record [ms]",
        "one moved [ms]",
        "still [ms]",
        "draws",
        "triangles",
        "targets [MiB]",
        "process [MiB]",
    ];
    let mut text = String::from(
        "## Growth\n\nScenes made for it: a floor and a wall under a sun in a space of 20 m, at 256×256 pixels; one bounce \
         of indirect light. A frame in which everything is computed, one before which one object was moved, and one in \
         which nothing has changed. The process takes up what smaller scenes have left before it grows: its least figures \
         say nothing.\n",
    );
    for curve in &results.growth {
        text += &format!("\n### {}\n\n{}\n", title(curve), table(&head, &rows(curve)));
        text += &format!("{}\n{}\n![{}]({})\n", reading(curve), refusals(curve), title(curve), file(curve));
    }
    (!results.growth.is_empty()).then_some(text)
}

/// Pairs of scenes whose ratio is bounded.
pub fn pairs(results: &Results) -> Option<String> {
    let row = |pair: &Pair| {
        let ratio =
            |[a, b]: &[Spread; 2]| format!("{} / {} = {}", ms(a.median), ms(b.median), times(a.median / b.median));
        vec![
            format!("{}, against {}", pair.of[0], pair.of[1]),
            ratio(&pair.frame),
            ratio(&pair.device),
            ratio(&pair.record),
            format!("{} / {}", whole(pair.draws[0]), whole(pair.draws[1])),
            times(pair.bound),
        ]
    };
    let rows: Vec<Vec<String>> = results.pairs.iter().map(row).collect();
    let head = ["pair", "frame [ms]", "device [ms]", "record [ms]", "draws", "bound"];
    let text = || {
        format!(
            "## Pairs\n\nDirect light with everything computed, the two scenes in turns, medians at 512×288 pixels.\n\n{}",
            table(&head, &rows)
        )
    };
    (!rows.is_empty()).then(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn point(count: u64, time: f64, bytes: u64) -> GrowthPoint {
        let frame = Spread { median: time, min: time, max: time };
        GrowthPoint { count, frame, target_bytes: bytes, ..GrowthPoint::default() }
    }

    #[test]
    fn growth_is_told_by_its_power_where_it_counts() {
        let refused = GrowthPoint { count: 1000, refused: Some("too many".into()), ..GrowthPoint::default() };
        // Quadratic below what counts, then linear, then constant.
        let points = vec![
            point(1, 0.01, 0),
            point(10, 1.0, 0),
            point(20, 4.0, 0),
            point(40, 8.0, 64),
            point(80, 8.0, 704),
            refused,
        ];
        let curve = Growth { axis: "lights".into(), series: "direct".into(), points };
        let (power, count) = steepest(&curve).unwrap();
        assert!((power - 2.0).abs() < 1e-9 && count == 20, "{power} {count}");
        assert_eq!(per_item(&curve, |point| Some(point.target_bytes)), Some(16.0));
        assert!(refusals(&curve).contains("1,000 lights: too many"));
        let results = Results { growth: vec![curve], ..Results::default() };
        let text = section(&results).unwrap();
        assert!(text.contains("the power 2.00") && text.contains("16 bytes") && text.contains("| 80 |"), "{text}");
    }
}
