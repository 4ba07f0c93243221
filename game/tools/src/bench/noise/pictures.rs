//! Pictures of noise: details, each pixel four wide and high.

use super::measure::Shot;
use super::measures::{difference, local_means};
use crate::bench::error::mean;
use crate::bench::picture::{Canvas, displayed, exposure, file_name, three};
use anyhow::{Context, Result};
use lightwell::measure::Image;
use std::path::Path;

/// Edge of a detail [pixels].
const DETAIL: u32 = 96;
/// Size of a pixel of it.
const FACTOR: u32 = 4;
/// Details in a row.
const COLUMNS: usize = 4;
/// Space between details, and height of a line of text [pixels].
const GAP: u32 = 8;
const LINE: u32 = 24;

/// Writes the pictures of a scene, and gives their files: for the window at rest, as it plays and after each change the place
/// where its last image has the worst blotches away from edges, in all images beside the converged one.
///
/// # Errors
/// If one cannot be written.
pub fn write(folder: &Path, scene: &str, shots: &[Shot], truth: &[Image; 2], near: &[bool]) -> Result<Vec<String>> {
    let truth = mean(truth);
    let mut files = Vec::new();
    let mut judged: Vec<&Shot> = Vec::new();
    for shot in shots.iter().filter(|shot| shot.what.starts_with("window")) {
        match judged.last_mut().filter(|last| last.what == shot.what) {
            Some(last) => *last = shot,
            None => judged.push(shot),
        }
    }
    for shot in judged {
        let base = format!("pictures/{}", file_name(&format!("{scene}_{}", shot.what)));
        let title = format!("{scene}, all light: {}, frame {}", shot.what, shot.frame);
        let whole = format!("{base}_whole.png");
        three(&folder.join(&whole), &shot.image, &truth, &title, &format!("frame {}", shot.frame))?;
        let detail = format!("{base}_x{FACTOR}.png");
        let of_it = |other: &&Shot| other.what == shot.what || !other.what.starts_with("window");
        let shown: Vec<(String, &Image)> =
            shots.iter().filter(of_it).map(|shot| (caption(shot), &shot.image)).collect();
        let corner = worst_place(&shot.image, &truth, near);
        details(&folder.join(&detail), &title, corner, &shown, &truth)?;
        files.extend([whole, detail]);
    }
    Ok(files)
}

fn caption(shot: &Shot) -> String {
    match shot.what.strip_prefix("window") {
        Some(_) => format!("window, frame {}", shot.frame),
        None => shot.what.replace('`', ""),
    }
}

/// Corner of the detail with the greatest squared error of means away from edges.
fn worst_place(image: &Image, truth: &Image, near: &[bool]) -> [u32; 2] {
    let size = image.size();
    let away: Vec<bool> = near.iter().map(|near| !near).collect();
    let coarse = local_means(&difference(image, truth), size, &away);
    let edge = size.map(|edge| edge.min(DETAIL));
    let square = |at: [u32; 2]| -> f64 {
        let rows = at[1]..at[1] + edge[1];
        let pixels = rows.flat_map(|y| (at[0]..at[0] + edge[0]).map(move |x| (y * size[0] + x) as usize));
        pixels.filter(|&pixel| away[pixel]).map(|pixel| coarse[pixel].iter().map(|v| v * v).sum::<f64>()).sum()
    };
    let step = (DETAIL / 4) as usize;
    let places =
        (0..=size[1] - edge[1]).step_by(step).flat_map(|y| (0..=size[0] - edge[0]).step_by(step).map(move |x| [x, y]));
    places.max_by(|&a, &b| square(a).total_cmp(&square(b))).unwrap_or_default()
}

fn details(path: &Path, title: &str, corner: [u32; 2], shown: &[(String, &Image)], truth: &Image) -> Result<()> {
    let exposure = exposure(truth);
    let size = truth.size().map(|edge| edge.min(DETAIL));
    let [width, height] = size.map(|edge| edge * FACTOR);
    let all: Vec<(&str, &Image)> = std::iter::once(("converged", truth))
        .chain(shown.iter().map(|(text, image)| (text.as_str(), *image)))
        .collect();
    let (columns, rows) = (all.len().min(COLUMNS) as u32, all.len().div_ceil(COLUMNS) as u32);
    let mut canvas = Canvas::new([columns * (width + GAP) + GAP, LINE + 2 * GAP + rows * (height + LINE + GAP)]);
    canvas.text([GAP, GAP], title)?;
    for (index, (text, image)) in all.into_iter().enumerate() {
        let (column, row) = ((index % COLUMNS) as u32, (index / COLUMNS) as u32);
        let at = [GAP + column * (width + GAP), GAP + LINE + row * (height + LINE + GAP)];
        canvas.paste(at, size, &displayed(&cut(image, corner, size)?, exposure), FACTOR);
        canvas.text([at[0], at[1] + height + 4], text)?;
    }
    canvas.save(path)
}

fn cut(image: &Image, corner: [u32; 2], size: [u32; 2]) -> Result<Image> {
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
    let pixels = pixels.map(|[x, y]| image.pixel(corner[0] + x, corner[1] + y)).collect();
    Image::from_pixels(size[0], size[1], pixels).context("the detail is incomplete")
}
