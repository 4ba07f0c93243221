//! `bench --window`: windows as their users see them. Each scene plays in a window of its own, which measures itself (`play
//! --measure`), and `window.md` tells the figures.

use super::report::markdown::{self, table};
use super::{fixture, machine, results};
use crate::cli::BenchArgs;
use anyhow::{Context, Result, bail};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::window::has_display;
use lightwell_runtime::window_figures::{RESTED, WindowFigures};
use results::Header;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Size of the windows, if not said [pixels].
const SIZE: [u32; 2] = [1280, 800];
/// Scenes, if none are named.
const SCENES: [&str; 2] = ["cornell", "courtyard"];

#[derive(Debug, Deserialize, Serialize)]
struct Results {
    header: Header,
    windows: Vec<Window>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Window {
    scene: String,
    figures: WindowFigures,
}

/// Measures a window for each scene; gives the report's path.
///
/// # Errors
/// If there is no display, a window ends with an error, or a file cannot be written.
pub(super) fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    if !has_display() {
        bail!("--window opens windows, and there is no display: try it under `xvfb-run -s '-screen 0 1280x800x24'`");
    }
    let size = args.size.unwrap_or(SIZE);
    let gpu = fixture::open_gpu(common)?;
    let header = machine::header(&gpu, format!("Windows of {} pixels", markdown::size(size)))?;
    // The windows have the device for themselves.
    drop(gpu);
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot make {}", args.output.display()))?;
    let mut scenes = args.scenes.clone();
    if scenes.is_empty() {
        scenes = SCENES.map(str::to_owned).to_vec();
    }
    let bar = progress::bar(scenes.len() as u64, "bench --window");
    let mut results = Results { header, windows: Vec::new() };
    for scene in scenes {
        bar.set_message(scene.clone());
        let figures = measured(&scene, size, common, &args.output).with_context(|| format!("scene `{scene}`"))?;
        results.windows.push(Window { scene, figures });
        bar.inc(1);
    }
    bar.finish_and_clear();
    let json = serde_json::to_string_pretty(&results)?;
    results::write_whole(&args.output.join("window.json"), json.as_bytes())?;
    let report = args.output.join("window.md");
    results::write_whole(&report, text(&results).as_bytes())?;
    Ok(report)
}

/// Figures of a window that another process of this program opens.
fn measured(scene: &str, [width, height]: [u32; 2], common: &Common, folder: &Path) -> Result<WindowFigures> {
    let file = folder.join("window.part");
    let program = std::env::current_exe().context("cannot find this program")?;
    let mut command = Command::new(program);
    command.args(["play", scene, "--size", &format!("{width}x{height}"), "--measure"]).arg(&file);
    for (name, value) in [
        ("--models", common.models.as_deref().map(Path::as_os_str)),
        ("--adapter", common.adapter.as_deref().map(AsRef::as_ref)),
    ] {
        value.into_iter().for_each(|value| {
            command.arg(name).arg(value);
        });
    }
    let status = command.status().context("cannot start a window")?;
    if !status.success() {
        bail!("the window ended with {status}");
    }
    let figures = WindowFigures::read(&file).context("the window was closed before all was measured")?;
    std::fs::remove_file(&file)?;
    Ok(figures)
}

fn text(results: &Results) -> String {
    let mut text = format!("# Windows\n\n{}", results.header.in_words());
    let [first, some, many] = RESTED;
    let _ = writeln!(
        text,
        "Each scene plays in a window of its own. *First picture*, of direct light, and *with indirect light*: since the program \
         was started. *Pictures a second* while the scene plays, and the size of the picture then, which the frame budget chose. \
         *Answer*: from a turn of the camera to the picture that shows it, median and worst of eight, while the scene plays and \
         while a view that rests is refined. *At rest*: from a pause to a picture of full size that is the mean of {first}, \
         {some} and {many} frames. Times in seconds.\n"
    );
    let head = [
        "scene",
        "view",
        "first picture",
        "with indirect light",
        "pictures a second",
        "drawn at",
        "answer",
        "answer at rest",
        "at rest",
    ];
    text + &table(&head, &results.windows.iter().map(row).collect::<Vec<_>>())
}

fn row(Window { scene, figures }: &Window) -> Vec<String> {
    let seconds = |value: f64| format!("{value:.2}");
    vec![
        scene.clone(),
        markdown::size(figures.view),
        seconds(figures.first_picture),
        seconds(figures.first_indirect),
        format!("{:.1}", figures.rate()),
        markdown::size(figures.played_size),
        median_and_worst(&figures.answers),
        median_and_worst(&figures.answers_at_rest),
        figures.rested.iter().copied().map(seconds).collect::<Vec<_>>().join(", "),
    ]
}

fn median_and_worst(times: &[f64]) -> String {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    match (sorted.get(sorted.len() / 2), sorted.last()) {
        (Some(median), Some(worst)) => format!("{median:.2}, {worst:.2}"),
        _ => markdown::NONE.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_row_tells_medians_and_rates() {
        let figures = WindowFigures {
            first_picture: 1.234,
            frames: vec![0.1; 20],
            answers: vec![0.3, 0.1, 0.2],
            rested: vec![0.5, 2.0, 8.0],
            view: [800, 600],
            played_size: [400, 300],
            ..WindowFigures::default()
        };
        let row = row(&Window { scene: "a".into(), figures });
        let expected =
            ["a", "800x600", "1.23", "0.00", "10.0", "400x300", "0.20, 0.30", markdown::NONE, "0.50, 2.00, 8.00"];
        assert_eq!(row.iter().map(|cell| cell.replace('×', "x")).collect::<Vec<_>>(), expected);
    }
}
