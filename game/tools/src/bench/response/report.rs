//! `response.md`.

use super::AFTER;
use super::figures::{CaseFigures, Results};
use crate::bench::report::markdown::{NONE, error, table};
use std::fmt::Write as _;

/// The report.
pub fn text(results: &Results) -> String {
    let frames = AFTER.map(|frame| frame.to_string()).join(", ");
    let mut text = format!("# Response to change\n\n{}", results.header.in_words());
    let _ = writeln!(
        text,
        "Windows whose frames are averaged, in rooms made for it, against what single images of the last state converge to, \
         with the same pixel grid. Frame 1 is the first in the last state. *Within 5 %*: the frame from which on means of 13×13 \
         pixels differ by no more (root mean square, of the mean of the converged picture); *error*: that difference after \
         {frames} frames. *Left*: the part of the change of indirect light that is left. *p95*: 95th percentile of the distance \
         of pixels from the converged picture, at the exposure of the brighter of the pictures before and after; *where it \
         changed*: of the pixels that the change changed by more than 2 of 255. *At rest*: p95 of a window that saw no change, \
         after {} frames: noise. All in 255ths. Split RC: what Split Radiance Cascades calls the case.\n",
        AFTER[AFTER.len() - 1]
    );
    let head = ["case", "Split RC", "within 5 %", "error", "left", "p95", "p99", "p95 where it changed", "at rest"];
    text += &table(&head, &results.cases.iter().map(row).collect::<Vec<_>>());
    if let Some(same) = &results.same_view {
        let [window, single] =
            [same.window, same.single].map(|[most, all]| format!("{most:.1} (p95), {all:.1} at most"));
        let _ = writeln!(
            text,
            "\n**The same view twice** (\"same pose twice\"). A window that looked elsewhere in between differs by {window} of \
             255; single images by {single}."
        );
    }
    if let Some(sealed) = &results.sealed {
        let [window, single] = [sealed.window, sealed.single]
            .map(|[shown, radiance]| format!("{shown:.0} of 255 (radiance {radiance:.1e})"));
        let _ = writeln!(
            text,
            "\n**A closed box in the sun** (\"sealed box\"). The brightest value while the camera flies through it: {window} in a \
             window, {single} in single images."
        );
    }
    if !results.cases.is_empty() {
        text += "\nPictures: the last frame before, frames after, and the converged picture.\n\n";
    }
    for case in &results.cases {
        let _ = writeln!(text, "- [{}]({})", case.name, case.picture);
    }
    text
}

fn row(case: &CaseFigures) -> Vec<String> {
    let list = |values: &[f64], digits: usize| match values {
        [] => NONE.to_owned(),
        _ => values.iter().map(|value| format!("{value:.digits$}")).collect::<Vec<_>>().join(", "),
    };
    vec![
        case.name.clone(),
        case.rival.clone().unwrap_or_else(|| NONE.to_owned()),
        case.within.map_or_else(|| format!("not in {}", case.frames), |frame| frame.to_string()),
        case.errors.iter().map(|value| error(*value)).collect::<Vec<_>>().join(", "),
        list(&case.left, 2),
        list(&case.residue, 1),
        list(&case.nearly_all, 1),
        list(&case.where_changed, 1),
        format!("{:.1}", case.rested),
    ]
}
