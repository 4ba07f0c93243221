//! The smaller parts of the report.

use super::facts;
use super::markdown::{error, list, percent, table, times, whole};
use crate::bench::results::{Mode, Results};
use crate::bench::stage::STAGES;
use std::collections::BTreeSet;

/// Title, machine and notes.
pub fn head(results: &Results) -> Option<String> {
    let header = &results.header;
    let commit = header.commit.as_ref().map_or(String::new(), |commit| format!(", commit {commit}"));
    let mut text = format!(
        "# Time against error\n\n{}, {} ({}, {}); {}. Lightwell {}{commit}; {}.\n\nSettings: {}.\n",
        header.adapter,
        header.driver,
        header.backend,
        header.device_type,
        header.system,
        header.version,
        header.date,
        header.settings,
    );
    if !header.command.is_empty() {
        text += &format!("\n```sh\n{}\n```\n", header.command);
    }
    if header.commit.as_ref().is_some_and(|commit| commit.ends_with("-dirty")) {
        text += "\n**The source tree had changes that no commit holds: nobody can measure this again.**\n";
    }
    if header.device_type == "Cpu" {
        text += "\nThis adapter draws in software on the processor: compare times with each other, not with those of a \
                 graphics card.\n";
    }
    if !results.notes.is_empty() {
        text += "\n";
        results.notes.iter().for_each(|note| text += &format!("- {note}\n"));
    }
    Some(text)
}

/// Paths a second.
pub fn throughput(results: &Results) -> Option<String> {
    let row = |t: &crate::bench::results::ThroughputFigures| {
        let rate = |rate: f64| format!("{:.3}", rate * 1e-6);
        let cells = [t.scene.clone(), whole(t.paths), rate(t.device), rate(t.host)];
        [&cells[..], &[t.threads.to_string(), times(t.device / t.host)]].concat()
    };
    let rows: Vec<Vec<String>> = results.throughput.iter().map(row).collect();
    let head = ["scene", "paths", "device [M/s]", "host [M/s]", "threads of the host", "device over host"];
    (!rows.is_empty()).then(|| {
        format!(
            "## Path tracer\n\nThe same paths on the device and by a scalar tracer on the host over the same \
             hierarchies.\n\n{}",
            table(&head, &rows)
        )
    })
}

/// Method, reference and difference of every variant that is drawn, and of the best path tracing.
pub fn pictures(results: &Results) -> Option<String> {
    let mut text = String::from("## Pictures\n\nMethod, reference, difference (thesis figures 7.2 to 7.7).\n\n");
    let mut any = false;
    for scene in &results.scenes {
        let bounces = facts::bounces(results);
        let errors = || results.errors.iter().filter(|e| e.scene == scene.name && e.bounces == bounces);
        let Some(first) = errors().map(|error| error.time).reduce(f64::min) else { continue };
        let traced = |name: &str| results.variants.iter().any(|variant| variant.name == name && variant.traced);
        let swept = |name: &str| results.variants.iter().any(|variant| variant.name == name && variant.sweep.is_some());
        let shown = errors().filter(|error| error.time == first && !swept(&error.variant));
        for error in shown.filter(|error| !traced(&error.variant)) {
            for picture in error.pictures.iter().filter(|picture| picture.ends_with(".png")) {
                text += &format!("![{}, {}]({picture})\n\n", error.scene, error.variant);
                any = true;
            }
        }
    }
    any.then_some(text)
}

/// How it was measured, and what the short names mean.
pub fn method(results: &Results) -> Option<String> {
    let used: BTreeSet<&String> = results.timings.iter().flat_map(|timing| timing.stages.keys()).collect();
    let stages: Vec<String> = STAGES
        .iter()
        .filter(|stage| used.contains(&stage.name.to_owned()))
        .map(|stage| format!("{} {}", stage.name, stage.what))
        .collect();
    let animated = results.timings.iter().any(|timing| timing.mode == Mode::Animated);
    let noise = results.errors.iter().map(|e| e.indirect.noise).fold(0.0, f64::max);
    let mut text = String::from("## How it was measured\n\n");
    text += "- Variants of a scene take turns frame by frame, each round beginning with another one, with worlds and \
             caches of their own. Times are medians over frames; the clock of the scene runs.\n";
    text += "- *Everything computed*: no result of an earlier frame is used.";
    text += if animated { " *Animated*: only what the motion of the scene changes is computed anew.\n" } else { "\n" };
    text += "- Times of frames, drawn and traced, are those of one clock on the wall from start to end, without reading the \
             image back. Times of passes, and their sum (*device*), are the device's own timestamps. Path tracing waits for \
             each of its pieces.\n";
    text += "- nrmse, bias, p95: on unexposed linear RGB over all pixels, without gain fitting. nrmse is unbiased by \
             the noise of the reference (two independent halves).";
    text += &format!(" Noise of the references of indirect light: at most {}.", percent(noise));
    text += " Path tracing is measured with another seed than the reference.\n";
    text += "- *indirect* is the image minus its direct light alone; the reference has all bounces unless it is said \
             otherwise.\n";
    if !stages.is_empty() {
        text += &format!("- Stages: {}.\n", list(&stages));
    }
    let unknown: BTreeSet<&String> = results.timings.iter().flat_map(|timing| &timing.unknown_passes).collect();
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.into_iter().map(|name| format!("`{name}`")).collect();
        text += &format!("- Passes that no stage is known for: {}.\n", list(&names));
    }
    let worst = results.errors.iter().map(|e| e.direct.nrmse).fold(0.0, f64::max);
    text += &format!("- Largest error of direct light of all variants: {}.\n", error(worst));
    Some(text)
}
