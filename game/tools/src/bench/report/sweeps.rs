//! Sweeps of one setting, as in the thesis's figures 7.9 and 7.10.

use super::facts::{self, Fact};
use super::markdown::{error, ms, signed, table};
use crate::bench::picture::{self, file_name};
use crate::bench::plot::{self, Curve};
use crate::bench::results::Results;
use anyhow::Result;
use lightwell::measure::read_image;
use std::path::Path;

/// The swept setting in words, and the label of its axis.
const AXES: [(&str, &str, &str); 2] = [
    ("steps", "propagation steps, fixed grid", "propagation steps"),
    ("grid", "cells of the grid, fixed steps", "cells along the longest axis"),
];

fn file(scene: &str, axis: &str, kind: &str) -> String {
    format!("plots/{}_sweep_{axis}{kind}.png", file_name(scene))
}

/// The points of a sweep, in the order of the setting.
fn points<'a>(results: &'a Results, scene: &str, axis: &str) -> Vec<(f64, Fact<'a>)> {
    let value = |fact: &Fact| fact.variant.sweep.as_ref().filter(|sweep| sweep.axis == axis).map(|sweep| sweep.value);
    let facts = facts::of(results, scene, true);
    let mut points: Vec<(f64, Fact)> = facts.into_iter().filter_map(|fact| Some((value(&fact)?, fact))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Draws the curves and the rows of images.
///
/// # Errors
/// If a file cannot be read or written.
pub fn draw(folder: &Path, results: &Results) -> Result<()> {
    for scene in &results.scenes {
        for (axis, title, x) in AXES {
            let points = points(results, &scene.name, axis);
            if points.is_empty() {
                continue;
            }
            let curve = |value: fn(&Fact) -> f64| points.iter().map(|(x, fact)| (*x, value(fact))).collect();
            let curves = [
                Curve { label: "nrmse of indirect light", points: curve(|fact| fact.indirect.nrmse) },
                Curve { label: "time of a frame [ms]", points: curve(|fact| fact.time()) },
            ];
            let path = folder.join(file(&scene.name, axis, ""));
            plot::sweep(&path, &format!("{}: {title}", scene.name), &curves, x)?;
            row(folder, results, &scene.name, axis, &points)?;
        }
    }
    Ok(())
}

/// The indirect light of all points side by side, the reference at the end.
fn row(folder: &Path, results: &Results, scene: &str, axis: &str, points: &[(f64, Fact)]) -> Result<()> {
    let image_of = |variant: &str, which: &str| {
        let error = results.errors.iter().find(|error| error.scene == scene && error.variant == variant)?;
        error.pictures.iter().find(|file| file.ends_with(which)).map(|file| folder.join(file))
    };
    let mut images = Vec::new();
    for (_, fact) in points {
        let Some(path) = image_of(&fact.variant.name, "_image.exr").filter(|path| path.is_file()) else { continue };
        images.push((read_image(&path)?, fact.variant.name.clone()));
    }
    let reference = points.iter().find_map(|(_, fact)| image_of(&fact.variant.name, "_reference.exr"));
    let Some(reference) = reference.filter(|path| path.is_file()) else { return Ok(()) };
    let reference = read_image(&reference)?;
    let exposure = picture::exposure(&reference);
    images.push((reference, "reference".to_owned()));
    let title = format!("{scene}: indirect light");
    picture::row(&folder.join(file(scene, axis, "_row")), &title, &images, exposure)
}

/// The sweeps in the report.
pub fn section(results: &Results) -> Option<String> {
    let mut text = String::from("## Sweeps (thesis figures 7.9 and 7.10)\n");
    let mut any = false;
    for scene in &results.scenes {
        for (axis, title, x) in AXES {
            let points = points(results, &scene.name, axis);
            let row = |(_, fact): &(f64, Fact)| {
                vec![
                    fact.variant.name.clone(),
                    ms(fact.time()),
                    error(fact.indirect.nrmse),
                    signed(fact.indirect.bias),
                    error(fact.total.nrmse),
                ]
            };
            let rows: Vec<Vec<String>> = points.iter().map(row).collect();
            if rows.is_empty() {
                continue;
            }
            any = true;
            let table = table(&[x, "time [ms]", "indirect nrmse", "bias", "total nrmse"], &rows);
            let (plot, row) = (file(&scene.name, axis, ""), file(&scene.name, axis, "_row"));
            text += &format!("\n### {}: {title}\n\n{table}\n![{title}]({plot})\n\n![images]({row})\n", scene.name);
        }
    }
    any.then_some(text)
}
