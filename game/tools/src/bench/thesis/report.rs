//! The report: each table of the thesis with our figures beside the printed ones.

use super::super::report::markdown::{NONE, error, ms, signed, size, table, whole};
use super::published::{MACHINES, SCENES, STAGES, Scene};
use super::{Results, SceneResults, Times};

/// The whole report as Markdown.
pub(super) fn of(results: &Results) -> String {
    let mut text = format!(
        "# The thesis, side by side\n\nTables and figures of Petr Šefčík's thesis (2016) with ours beside them. Ours: {}",
        results.header.in_words()
    );
    text += "Scenes are in the settings that the thesis evaluated (`--set preset=thesis`): one bounce, b = k = 1, no light of \
             the sky; formulas are the corrected ones where nothing else is said. A scene whose model is missing is replaced \
             by its stand-in.\n\n";
    text += &counts(results);
    for (index, number) in ["7.3", "7.4"].into_iter().enumerate() {
        text += &times(results, index, number);
    }
    text += &errors(results);
    text += &pictures(results);
    text
}

/// The results with what the thesis prints of them.
fn pairs(results: &Results) -> impl Iterator<Item = (&'static Scene, &SceneResults)> {
    SCENES.iter().filter_map(|paper| Some((paper, results.scenes.iter().find(|ours| ours.name == paper.name)?)))
}

fn counts(results: &Results) -> String {
    let mut rows = Vec::new();
    for (paper, ours) in pairs(results) {
        let row = |who: String, values: [u64; 4], merges: String| {
            let mut cells = vec![who];
            cells.extend(values.map(whole));
            cells.push(merges);
            cells
        };
        let printed = [paper.triangles, paper.rsm_triangles, paper.injections, paper.cell_steps];
        rows.push(row(format!("{}, thesis", paper.name), printed, NONE.to_owned()));
        let found = [ours.triangles, ours.rsm_triangles, ours.injections, ours.cell_steps];
        rows.push(row(format!("`{}`", ours.scene), found, whole(ours.merges)));
    }
    let head = ["scene", "triangles", "triangles of all RSMs", "injections", "cells × steps", "merges"];
    format!(
        "## Table 7.1: counts\n\n{}\nThe thesis prints 32786 and 7167 where 2 · 128² and 8 · 8 · 7 · 16 are meant. Our \
         triangles differ where a model is another edition of it, where its parts are ours, and by the objects that move. \
         RSMs leave out faces and objects that a light does not see. Injections of the camera are those of its samples.\n\n",
        table(&head, &rows)
    )
}

fn times(results: &Results, index: usize, number: &str) -> String {
    let mut rows = Vec::new();
    let mut measured = None;
    for (paper, ours) in pairs(results) {
        for (machine, times) in MACHINES.iter().zip(&paper.times) {
            let (stages, total) = &times[index];
            let mut cells = vec![format!("{}, {machine}", paper.name)];
            cells.extend(stages.iter().map(|stage| stage.map_or(NONE.to_owned(), |ms| format!("{ms:.2}"))));
            cells.push(format!("{total:.2}"));
            rows.push(cells);
        }
        if let Some(times) = ours.times.get(index) {
            measured = Some(times);
            let cell = |stage: &str| times.stages.get(stage).map_or(NONE.to_owned(), |&value| ms(value));
            let mut cells = vec![format!("`{}`", ours.scene)];
            cells.extend(STAGES.iter().chain(&["TOTAL"]).map(|stage| cell(stage)));
            rows.push(cells);
        }
    }
    let caption = |times: &Times| format!("{}, medians of {} frames", size(times.size), times.frames);
    let caption = measured.map_or("not measured".to_owned(), caption);
    let head = ["scene [ms]", "IGB", "GRSM", "IL", "IB", "PRP", "REL", "TOTAL"];
    format!(
        "## Table {number}: times ({caption})\n\n{}\nIGB: camera samples (downsampled where formulas are printed) into the \
         geometry volume; GRSM: reflective shadow maps; IL: light injection; IB: injection of blockers that lights see; PRP: \
         merging and propagation; REL: relighting, with gradient damping and the gloss march where the scene has them; TOTAL: \
         the sum.\n\n",
        table(&head, &rows)
    )
}

fn errors(results: &Results) -> String {
    let mut rows = Vec::new();
    for (_, ours) in pairs(results) {
        for row in &ours.errors {
            let what = format!("`{}`, {}", ours.scene, row.what);
            rows.push(vec![what, error(row.nrmse), signed(row.bias), error(row.noise)]);
        }
    }
    format!(
        "## Errors\n\nIndirect light against the path tracer, which ends paths at the second scattering (section 7.4), without \
         the sky. Noise is the reference's own, and is not part of the error.\n\n{}\n",
        table(&["settings", "nrmse", "bias", "noise"], &rows)
    )
}

fn pictures(results: &Results) -> String {
    let mut text =
        "## Figures\n\nMethod, reference and difference for each scene (7.2 to 7.7), gradient damping off and on \
                    (7.8), propagation steps (7.9) and grids (7.10).\n\n"
            .to_owned();
    for (paper, ours) in pairs(results) {
        for (number, files) in &ours.pictures {
            for file in files {
                text += &format!("![Figure {number}, {}]({file})\n\n", paper.name);
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::ErrorRow;
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn our_figures_stand_beside_the_printed_ones() {
        let stages = BTreeMap::from([("GRSM".to_owned(), 1.5), ("TOTAL".to_owned(), 2.25)]);
        let errors = vec![ErrorRow { what: "as evaluated".into(), nrmse: 1.25, bias: -0.5, noise: 0.01 }];
        let scene = SceneResults {
            name: "Cornell".into(),
            scene: "cornell".into(),
            injections: 32_768,
            cell_steps: 7_168,
            times: vec![Times { size: [512; 2], frames: 30, stages }],
            errors,
            pictures: BTreeMap::from([("7.2".to_owned(), vec!["pictures/figure_7.2.png".to_owned()])]),
            ..Default::default()
        };
        let text = of(&Results { scenes: vec![scene], ..Default::default() });
        for line in [
            "| Cornell, thesis | 84 | 84 | 32,786 | 7,167 | – |",
            "| `cornell` | 0 | 0 | 32,768 | 7,168 | 0 |",
            "| Cornell, GTX 980 | – | 0.01 | 0.19 | 0.10 | 0.36 | 0.03 | 0.71 |",
            "| Cornell, 930M | – | 0.04 | 0.43 | 0.30 | 0.37 | 0.18 | 1.32 |",
            "| `cornell` | – | 1.50 | – | – | – | – | 2.25 |",
            "| `cornell`, as evaluated | 1.250 | -0.500 | 0.010 |",
            "![Figure 7.2, Cornell](pictures/figure_7.2.png)",
            "## Table 7.4: times (not measured)",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
    }
}
