//! `lightwell bench --rooms N`: errors over random rooms, a yardstick that no method can be tuned to.
//!
//! ```text
//! room (building, furniture, clutter, surfaces, lights, viewpoint) ─ scene_text ─ a scene file
//!                                                              └─ fixture ─ measure ─ rooms.json ─ rooms.md, worst/
//! ```
//! A room is a function of seed and number alone, the same on every machine. Sizes go from 1 to 30 m, walls from 1 to
//! 30 cm; there are up to four rooms side by side, with doors and windows, closed or open, with pillars, stairs, shelves,
//! curved and thin things, one to three lights, panels that glow and the sky. One of four is cluttered: piles of hundreds
//! of things, full shelves, slats and bars before windows, boards close before walls. A third stands along the axes, a third is
//! turned about the vertical, a third about two axes, lights and camera with all else.
//!
//! Each room is measured with each method against the path tracer. Its reference takes samples until its noise is a
//! quarter of the least error that is taken with it, or to the limit of `--reference-spp`, which the report then says.
//! Every finished room is written at once: the same command continues where an interrupted one stopped, and with a greater
//! number of rooms it adds the further ones.

mod building;
mod clutter;
mod distribution;
mod edges;
mod figures;
mod furniture;
mod lights;
mod measure;
mod methods;
mod pieces;
mod random;
mod report;
mod room;
mod scene_text;
mod solid;
mod surfaces;
mod viewpoint;
mod wall;

#[cfg(test)]
mod tests;

pub(super) use edges::near_edges;

use super::fixture::{self, Fixture};
use super::picture;
use super::results::write_whole;
use super::{machine, report::markdown};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use figures::{Figures, Store};
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::say;
use measure::{Course, Measured};
use methods::Judged;
use room::Room;
use std::path::{Path, PathBuf};

/// Image size, if not said [pixels].
const SIZE: [u32; 2] = [128; 2];
/// Most samples a pixel of a reference, if not said.
const MOST_SAMPLES: u32 = 4096;
/// Worst rooms of each method that are kept with their images.
const WORST: usize = 10;

/// File name of a room.
fn scene_file(index: u64) -> String {
    format!("room_{index:04}.scene.ron")
}

/// The scene of one of the worst rooms, relative to the folder of the results.
fn worst_scene(index: u64) -> String {
    format!("worst/{}", scene_file(index))
}

/// The image of one of the worst rooms, relative to the folder of the results.
fn worst_picture(index: u64, method: &str) -> String {
    format!("worst/{}.png", picture::file_name(&format!("room_{index:04}_{method}")))
}

/// Measures the rooms that are missing, and writes `rooms.json`, `rooms.md`, all rooms as scenes and images of the worst;
/// gives the report's path, or with `--list` that of the scenes.
///
/// # Errors
/// If a room cannot be loaded or drawn, or a file not be written.
pub fn run(args: &BenchArgs, rooms: u64, common: &Common) -> Result<PathBuf> {
    let folder = &args.output;
    if args.list {
        for index in 0..rooms {
            let room = Room::draw(args.seed, index);
            write_scene(folder, &room, args.seed)?;
            say!("room {index}: {}", room.facts.description);
        }
        return Ok(folder.join("rooms"));
    }
    let (judged, variants) = methods::of(args)?;
    let course = Course { size: args.size.unwrap_or(SIZE), most_samples: args.reference_spp.unwrap_or(MOST_SAMPLES) };
    let gpu = fixture::open_gpu(common)?;
    let settings = format!(
        "Seed {}, images of {} pixels, references of {} samples a pixel at most",
        args.seed,
        markdown::size(course.size),
        course.most_samples
    );
    let header = machine::header(&gpu, settings)?;
    let mut store = Store::open(folder, header, judged.iter().map(Judged::figures).collect(), args.fresh)?;
    let bar = progress::bar(rooms, "rooms");
    for index in 0..rooms {
        if !store.has(index) {
            let room = Room::draw(args.seed, index);
            bar.set_message(format!("room {index}"));
            let measured = one(&room, args, (&judged, &variants), &course, &gpu, common);
            let measured = measured.with_context(|| format!("room {index} of seed {}", args.seed))?;
            bar.suspend(|| say!("{}", in_a_line(&measured)));
            store.add(measured.figures.clone());
            // Before the figures: a room that they hold is not drawn again.
            keep_worst(folder, &store.figures, &judged, &measured, &room.scene_text(args.seed))?;
            store.save()?;
            write_whole(&folder.join("rooms.md"), report::text(&store.figures).as_bytes())?;
        }
        bar.set_position(index + 1);
    }
    bar.finish_and_clear();
    let path = folder.join("rooms.md");
    write_whole(&path, report::text(&store.figures).as_bytes())?;
    Ok(path)
}

/// Writes a room as a scene file, and gives its path.
fn write_scene(folder: &Path, room: &Room, seed: u64) -> Result<PathBuf> {
    let scenes = folder.join("rooms");
    std::fs::create_dir_all(&scenes).with_context(|| format!("cannot make the folder {}", scenes.display()))?;
    let path = scenes.join(scene_file(room.facts.index));
    write_whole(&path, room.scene_text(seed).as_bytes())?;
    Ok(path)
}

fn one(
    room: &Room,
    args: &BenchArgs,
    (judged, variants): (&[Judged], &[super::variant::Variant]),
    course: &Course,
    gpu: &std::sync::Arc<lightwell::gpu::Gpu>,
    common: &Common,
) -> Result<Measured> {
    let scene = write_scene(&args.output, room, args.seed)?;
    let mut fixture = Fixture::open(gpu.clone(), &scene.to_string_lossy(), None, common)?;
    fixture.add(variants)?;
    fixture.set_seconds(0.0);
    measure::measure(&mut fixture, judged, course, &room.facts)
}

fn in_a_line(measured: &Measured) -> String {
    let figures = &measured.figures;
    let errors: Vec<String> = figures
        .errors
        .iter()
        .map(|error| {
            let (nrmse, bias) = (markdown::error(error.indirect.nrmse), markdown::signed(error.indirect.bias));
            format!("{} {nrmse} ({bias})", error.method)
        })
        .collect();
    let reference = &figures.reference;
    let limit = if reference.limited { ", the limit" } else { "" };
    format!(
        "room {}: {}\n  nrmse (bias) of indirect light: {}; {} samples{limit}, noise {}; {:.0} s",
        figures.facts.index,
        figures.facts.description,
        errors.join(", "),
        reference.samples,
        markdown::percent(reference.noise),
        figures.seconds
    )
}

/// Writes scene and images of a room that is among the worst, and removes those of rooms that are no more.
fn keep_worst(folder: &Path, figures: &Figures, judged: &[Judged], measured: &Measured, scene: &str) -> Result<()> {
    let own = measured.figures.facts.index;
    let mut kept = Vec::new();
    for (method, judged) in judged.iter().enumerate() {
        for room in figures.worst(method, WORST) {
            let index = room.facts.index;
            let (scene_path, picture_path) = (worst_scene(index), worst_picture(index, &judged.name));
            if index == own {
                let error = &room.errors[method].indirect;
                let title = format!("room {index}, indirect light: {}", judged.name);
                let caption = format!("nrmse {:.3}, bias {:+.3}", error.nrmse, error.bias);
                let (image, reference) = (&measured.images[method], &measured.reference);
                picture::three(&folder.join(&picture_path), image, reference, &title, &caption)?;
                write_whole(&folder.join(&scene_path), scene.as_bytes())?;
            }
            kept.extend([scene_path, picture_path]);
        }
    }
    let Ok(files) = std::fs::read_dir(folder.join("worst")) else { return Ok(()) };
    for file in files.flatten() {
        let name = format!("worst/{}", file.file_name().to_string_lossy());
        if name.starts_with("worst/room_") && !kept.contains(&name) {
            std::fs::remove_file(file.path()).with_context(|| format!("cannot remove {}", file.path().display()))?;
        }
    }
    Ok(())
}
