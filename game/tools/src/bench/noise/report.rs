//! `noise.md`.

use super::figures::{LayerNoise, Results, Row, SceneFigures};
use super::measures::Noise;
use crate::bench::report::markdown::{NONE, error, percent, signed, table};

/// The report.
pub fn text(results: &Results) -> String {
    let mut text = format!("# Noise\n\n{}", results.header.in_words());
    text += "Every image is compared with what `High` converges to: the mean of many of its images whose pixel grid is not \
             shifted, so that edges of surfaces cancel. Errors are relative to the mean of that image, and its noise, known \
             by two halves, is no part of them. *Edges*: within 4 pixels of a geometric edge. *Grain*: what a mean of 13×13 \
             pixels takes away; *blotches*: such means. *Fireflies*: pixels that are off by more than a quarter of the mean. \
             *Shift*: relative error of the mean against the converged image; *bias*: against the path tracer. FLIP: of all \
             light against the converged image. Indirect light is all light without the mean direct light. Windows are \
             `Medium`, or what the scene asks for, averaged over frames and without smoothed edges; the frame after a change \
             is that in which the scene is first in the state that everything is compared in.\n";
    results.scenes.iter().for_each(|scene| text += &section(scene));
    text
}

fn section(scene: &SceneFigures) -> String {
    let limit =
        if scene.limited { ", the limit, which leaves more noise than a quarter of the least error" } else { "" };
    let mut text = format!(
        "\n## `{}`\n\n{}. {} of the pixels are near edges. Converged image: {} frames{limit}; noise of its indirect light away \
         from edges {}, bias {} (all light {}). {:.0} s.\n\n### Indirect light\n\n",
        scene.name,
        scene.course,
        percent(scene.near_edges),
        scene.frames,
        error(scene.noise),
        signed(scene.bias[0]),
        signed(scene.bias[1]),
        scene.seconds
    );
    text += &layer(&scene.rows, |row| &row.indirect);
    text += "\n### All light\n\n";
    text += &layer(&scene.rows, |row| &row.total);
    text += &jumps(scene);
    if !scene.pictures.is_empty() {
        let links: Vec<String> = scene.pictures.iter().map(|file| format!("[{}]({file})", name_of(file))).collect();
        text += &format!("\nPictures: {}.\n", links.join(", "));
    }
    text
}

fn name_of(file: &str) -> &str {
    file.trim_start_matches("pictures/").trim_end_matches(".png")
}

fn layer(rows: &[Row], of: fn(&Row) -> &LayerNoise) -> String {
    let head = [
        "image",
        "frame",
        "edges: nrmse",
        "grain",
        "blotches",
        "fireflies",
        "elsewhere: nrmse",
        "grain",
        "blotches",
        "fireflies",
        "shift",
        "bias",
        "FLIP",
    ];
    let cells = |row: &Row| {
        let layer = of(row);
        let part = |noise: &Option<Noise>| match noise {
            None => [NONE; 4].map(str::to_owned),
            Some(noise) => {
                let [nrmse, grain, blotches] = [noise.nrmse, noise.grain, noise.blotches].map(fine);
                [nrmse, grain, blotches, share(noise.fireflies)]
            }
        };
        let mut cells = vec![row.what.clone(), row.frame.to_string()];
        cells.extend(part(&layer.edges));
        cells.extend(part(&layer.elsewhere));
        cells.extend([signed(layer.shift), signed(layer.bias), fine(layer.flip)]);
        cells
    };
    table(&head, &rows.iter().map(cells).collect::<Vec<_>>())
}

/// An error with four digits: what is left at rest is small.
fn fine(value: f64) -> String {
    if value.is_finite() && value < 0.1 { format!("{value:.4}") } else { error(value) }
}

fn share(value: f64) -> String {
    format!("{:.3} %", 100.0 * value)
}

fn jumps(scene: &SceneFigures) -> String {
    let mut text =
        "\n### Blocks that jump\n\nBlocks of 8×8 that are flat (deviation below 8 of 255) in two successive frames of \
                    the screen as the scene plays, and whose mean changes.\n\n"
            .to_owned();
    let row = |figures: &super::figures::JumpFigures| {
        let jumps = &figures.jumps;
        vec![
            figures.what.clone(),
            jumps.blocks.to_string(),
            jumps.above_6.to_string(),
            jumps.above_10.to_string(),
            format!("{:.1}", jumps.largest),
        ]
    };
    let rows: Vec<Vec<String>> = scene.jumps.iter().map(row).collect();
    text += &table(&["frames", "blocks compared", "above 6 of 255", "above 10 of 255", "largest [255ths]"], &rows);
    if let Some(flat) = scene.flat {
        text +=
            &format!("\nOne image differs from its average by {flat:.2} of 255 in flat blocks (root mean square).\n");
    }
    text
}
