//! The thesis's tables 7.1, 7.3 and 7.4 in our figures, errors and memory.

use super::facts::{self, Fact, Light, is_baseline};
use super::markdown::{NONE, error, list, mib, ms, percent, signed, size, table, whole};
use crate::bench::published_figures;
use crate::bench::results::{Mode, Results, Timing};
use crate::bench::stage;
use std::collections::BTreeSet;

/// Scenes and settings: table 7.1.
pub fn scenes(results: &Results) -> Option<String> {
    let row = |scene: &crate::bench::results::SceneFigures| {
        let published = published_figures::of(&scene.name);
        vec![
            named(&scene.name),
            scene.primitives.to_string(),
            whole(scene.triangles as u64),
            published.and_then(|(p, stand_in)| p.triangles.filter(|_| !stand_in)).unwrap_or(NONE).to_owned(),
            scene.lights.clone(),
            scene.volumes.clone(),
            published.map_or(NONE, |(p, _)| p.volumes).to_owned(),
            scene.steps.map_or(NONE.to_owned(), |steps| steps.to_string()),
        ]
    };
    let rows: Vec<Vec<String>> = results.scenes.iter().map(row).collect();
    let head =
        ["scene", "primitives", "triangles", "thesis", "lights", "volumes, finest cell", "thesis", "propagation steps"];
    (!rows.is_empty()).then(|| format!("## Scenes and settings (thesis table 7.1)\n\n{}", table(&head, &rows)))
}

/// A scene's name, with the thesis's scene that it stands in for.
fn named(scene: &str) -> String {
    match published_figures::of(scene) {
        Some((paper, true)) => format!("{scene} (for {})", paper.name),
        _ => scene.to_owned(),
    }
}

/// Errors of all variants.
pub fn errors(results: &Results) -> Option<String> {
    let mut text = String::from("## Errors\n");
    let mut any = false;
    for scene in &results.scenes {
        let mut rows = Vec::new();
        let all = facts::of(results, &scene.name, false);
        for fact in &all {
            let (indirect, total) = (&fact.indirect, &fact.total);
            rows.push(vec![
                fact.variant.name.clone(),
                ms(fact.time()),
                error(indirect.nrmse),
                signed(indirect.bias),
                error(indirect.p95),
                error(indirect.flip),
                error(total.nrmse),
                signed(total.bias),
                error(total.p95),
                error(total.flip),
                error(fact.direct.nrmse),
            ]);
        }
        let Some(first) = all.first() else { continue };
        any = true;
        let head = [
            "variant",
            "time [ms]",
            "indirect nrmse",
            "bias",
            "p95",
            "FLIP",
            "total nrmse",
            "total bias",
            "total p95",
            "total FLIP",
            "direct nrmse",
        ];
        let noise = format!(
            "Noise of the reference: indirect {}, total {}.{}",
            percent(first.indirect.noise),
            percent(first.total.noise),
            too_noisy(&all)
        );
        text += &format!("\n### {}\n\n{}\n{noise}\n", scene.name, table(&head, &rows));
        text += &other_bounces(results, &scene.name);
    }
    any.then_some(text)
}

/// The variants whose error the reference's noise is more than a quarter of.
fn too_noisy(all: &[Fact]) -> String {
    let of = |what: &str, light: Light| {
        let is_noisy = |fact: &&Fact| !fact.variant.traced && fact.of(light).noise > 0.25 * fact.of(light).nrmse;
        let names: Vec<String> = all.iter().filter(is_noisy).map(|fact| format!("`{}`", fact.variant.name)).collect();
        (!names.is_empty()).then(|| format!("{what} of {}", list(&names)))
    };
    let found = [of("indirect light", Light::Indirect), of("all light", Light::Total)];
    let found: Vec<String> = found.into_iter().flatten().collect();
    match found.is_empty() {
        true => String::new(),
        false => format!(" That is more than a quarter of the error of {}.", found.join(", and of ")),
    }
}

/// Errors against references of other numbers of bounces, where there are some.
fn other_bounces(results: &Results, scene: &str) -> String {
    let shown = facts::bounces(results);
    let others = || results.errors.iter().filter(|error| error.scene == scene && error.bounces != shown);
    let kinds: BTreeSet<Option<u32>> = others().map(|error| error.bounces).collect();
    let mut text = String::new();
    for bounces in kinds {
        let mut rows = Vec::new();
        for variant in &results.variants {
            let errors = || others().filter(|e| e.bounces == bounces && e.variant == variant.name);
            if errors().next().is_some() {
                let indirect = facts::mean(errors().map(|error| &error.indirect));
                rows.push(vec![variant.name.clone(), error(indirect.nrmse), signed(indirect.bias)]);
            }
        }
        let what = bounces.map_or("unlimited indirect bounces".to_owned(), |k| format!("{k} indirect bounces"));
        text += &format!("\nAgainst {what}:\n\n{}", table(&["variant", "indirect nrmse", "bias"], &rows));
    }
    text
}

/// Path tracing: what the same error costs by sampling.
pub fn traced(results: &Results) -> Option<String> {
    let mut rows = Vec::new();
    for scene in &results.scenes {
        for fact in facts::of(results, &scene.name, false).iter().filter(|fact| is_baseline(fact)) {
            let stage = |name: &str| fact.timing.stages.get(name).map_or(NONE.to_owned(), |time| ms(time.median));
            rows.push(vec![
                scene.name.clone(),
                fact.variant.name.clone(),
                size(fact.timing.size),
                stage("TRC"),
                stage("BVH"),
                error(fact.indirect.nrmse),
                error(fact.total.nrmse),
            ]);
        }
    }
    let head = ["scene", "variant", "size", "trace [ms]", "hierarchy, host [ms]", "indirect nrmse", "total nrmse"];
    (!rows.is_empty()).then(|| {
        format!("## Path tracing as the baseline\n\n{}\n{}\n", table(&head, &rows), published_figures::INDEPENDENT)
    })
}

/// Times of each stage: table 7.3.
pub fn times(results: &Results) -> Option<String> {
    let drawn = |timing: &&Timing| !results.variants.iter().any(|v| v.name == timing.variant && v.traced);
    let kinds: BTreeSet<(Mode, [u32; 2])> = results.timings.iter().filter(drawn).map(|t| (t.mode, t.size)).collect();
    let mut text = String::from("## Times of each stage [ms] (thesis table 7.3)\n");
    for &(mode, at) in &kinds {
        let timings: Vec<&Timing> =
            results.timings.iter().filter(drawn).filter(|t| (t.mode, t.size) == (mode, at)).collect();
        text += &format!("\n### {} at {}\n\n{}", mode_name(mode), size(at), stage_table(&timings, mode, at));
    }
    text += "\nMedian over the frames of each stage; of the sum also least and greatest. The thesis's times are those of a \
             GeForce GTX 980 at 512×512 for whole frames.\n";
    (!kinds.is_empty()).then_some(text)
}

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Full => "Everything computed",
        Mode::Animated => "Animated, what has not changed is reused",
        Mode::Shifted => "Another image of an average, what the shift of its pixels does not change is reused",
    }
}

fn stage_table(timings: &[&Timing], mode: Mode, at: [u32; 2]) -> String {
    let mut stages: Vec<&str> = timings.iter().flat_map(|t| t.stages.keys().map(String::as_str)).collect();
    stages.sort_by_key(|name| (stage::order(name), *name));
    stages.dedup();
    let published = mode == Mode::Full && at == [512; 2];
    let mut head = vec!["scene, variant"];
    head.extend(&stages);
    head.extend(["all", "least–greatest", "thesis"]);
    let row = |timing: &&Timing| {
        let mut row = vec![format!("{}, {}", timing.scene, timing.variant)];
        row.extend(stages.iter().map(|name| timing.stages.get(*name).map_or(NONE.to_owned(), |time| ms(time.median))));
        row.push(ms(timing.total.median));
        row.push(format!("{}–{}", ms(timing.total.min), ms(timing.total.max)));
        let thesis = published_figures::of(&timing.scene).filter(|_| published && timing.variant == "clpv");
        row.push(thesis.map_or(NONE.to_owned(), |(paper, _)| ms(paper.frame_ms)));
        row
    };
    let rows: Vec<Vec<String>> = timings.iter().map(row).collect();
    table(&head, &rows)
}

/// Counts that do not depend on the machine: table 7.1 and section 7.3.4.
pub fn counts(results: &Results) -> Option<String> {
    let mut rows = Vec::new();
    let mut seen = BTreeSet::new();
    for timing in results.timings.iter().filter(|timing| timing.mode == Mode::Full && !timing.counts.is_empty()) {
        if !seen.insert((&timing.scene, &timing.variant)) {
            continue;
        }
        let sum = |name: &str| timing.counts.values().filter_map(|counts| counts.get(name)).sum::<u64>();
        let of = |stage: &str, name: &str| timing.counts.get(stage).and_then(|counts| counts.get(name)).copied();
        let or_none = |count: Option<u64>| count.map_or(NONE.to_owned(), whole);
        let thesis = published_figures::of(&timing.scene).filter(|_| timing.variant == "clpv").map(|(paper, _)| paper);
        let injections = of("IL", "injections").map(|light| light + of("IB", "injections").unwrap_or(0));
        rows.push(vec![
            format!("{}, {}", timing.scene, timing.variant),
            whole(sum("draws")),
            whole(sum("triangles")),
            whole(sum("dispatches")),
            or_none(injections),
            or_none(thesis.map(|paper| paper.injections)),
            or_none(of("PRP", "cells")),
            or_none(thesis.map(|paper| paper.cell_steps)),
            or_none(timing.merges),
            or_none(thesis.and_then(|paper| paper.merges)),
        ]);
    }
    let head = [
        "scene, variant",
        "draws",
        "triangles",
        "dispatches",
        "injections",
        "thesis",
        "cell-steps",
        "thesis",
        "merges",
        "thesis",
    ];
    (!rows.is_empty()).then(|| {
        format!(
            "## Counts that do not depend on the machine (thesis table 7.1)\n\n{}\nOf the first measured frame, everything \
             computed. Injections: texels of light and of blockers, cascades counted one by one. The thesis prints 32786 \
             and 7167 for Cornell.\n",
            table(&head, &rows)
        )
    })
}

/// Memory.
pub fn memory(results: &Results) -> Option<String> {
    let row = |timing: &Timing| {
        let mode = match timing.mode {
            Mode::Full => "everything",
            Mode::Animated => "animated",
            Mode::Shifted => "averaged",
        };
        vec![
            format!("{}, {}", timing.scene, timing.variant),
            size(timing.size),
            mode.into(),
            mib(timing.allocated_bytes),
        ]
    };
    let drawn = results.timings.iter().filter(|timing| timing.allocated_bytes > 0);
    let rows: Vec<Vec<String>> = drawn.map(row).collect();
    let peak = results.timings.iter().filter_map(|timing| timing.peak_bytes).max();
    let peak = peak.map_or(String::new(), |bytes| {
        format!("\nMost memory of the whole process, with all variants loaded at once: {} MiB.\n", mib(bytes))
    });
    (!rows.is_empty()).then(|| {
        format!(
            "## Memory of a frame's targets\n\n{}{peak}",
            table(&["scene, variant", "size", "computed", "[MiB]"], &rows)
        )
    })
}
