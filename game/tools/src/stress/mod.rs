//! `lightwell stress`: what must hold for every scene, held against a matrix of scales, lights, grids, turns and places.
//!
//! `--full` takes a covering array of all pairs of method, scale, light, turn, place and grid; otherwise one row for each
//! method is drawn.
//!
//! ```text
//! cover (which rows) ─ setup (the room as text) ─ rig (draws it) ─┬─ checks (invariants of a row) ─┬─ table
//!                      degenerate, room ──────────────────────────┘                                └─ scenes of the worst
//! endurance (a long run) ─ aside (each in a process of its own) ─ table
//! ```
//!
//! What the system does to the program is not part of the matrix; each fault has a test of its own:
//!
//! | fault | test |
//! |---|---|
//! | disk full while an image or a scene is saved | `game/program/tests/cli/faults.rs`: `a_full_disk_leaves_the_old_picture_and_says_which_file`, `a_full_disk_leaves_the_old_scene` |
//! | read-only place | `faults.rs`: `where_nothing_may_be_written_a_save_says_so` |
//! | a file vanishes, or is half there, while it is loaded | `faults.rs`: `a_file_that_vanishes_while_it_is_loaded_is_named` |
//! | killed while saving | `engine/tests/interfaces/kill.rs`: `a_kill_in_the_middle_of_a_save_loses_nothing`; of the window `game/program/tests/window.rs`: `a_scene_is_opened_edited_undone_saved_and_survives_a_kill` |
//! | no memory for what is asked for | `faults.rs`: `a_frame_that_finds_no_memory_is_refused_in_words` |
//! | device lost | `faults.rs`: `a_lost_device_is_an_error` |
//! | window of 1 × 1 pixel, off the screen and back | `window.rs`: `a_window_comes_back_from_nothing` |
//! | monitor of another scale | `window.rs`: `a_monitor_of_another_scale_is_followed` |
//! | textures of 16,384 texels | `faults.rs`: `a_texture_of_16384_texels_is_drawn` |
//! | input of any bytes | `tests/fuzz` |

mod aside;
mod checks;
mod cover;
mod degenerate;
mod endurance;
mod invariant;
mod rig;
mod room;
mod setup;
mod table;

use crate::cli::StressArgs;
use anyhow::{Context, Result};
use endurance::Endured;
use invariant::Invariant;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::say;
use rig::Rig;
use setup::{Grid, Lamps, Method, Setup};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;
use table::Table;

/// Lengths of a unit \[m\]. By powers of two nothing is rounded, so that any length of fixed size shows.
const SCALES: [f32; 7] = [1.0, 1.0 / 1024.0, 1.0 / 128.0, 0.1, 10.0, 128.0, 1024.0];
/// Frames of the long run where not all is asked for.
const SHORT: u32 = 40;
/// Factors on all light.
const INTENSITIES: [f32; 5] = [1.0, 1e-6, 1e-3, 1e3, 1e6];
/// Euler angles \[degrees\].
const TILTS: [[f32; 3]; 3] = [[0.0; 3], [0.0, 17.0, 0.0], [30.0, 45.0, 0.0]];
/// Places [units]: the origin, and a thousand and a hundred thousand units away.
const POSITIONS: [[f32; 3]; 3] = [[0.0; 3], [600.0, -64.0, 800.0], [-6e4, 1e3, 8e4]];

/// Runs the suite. The exit code is 1 if a bound is broken.
///
/// # Errors
/// If there is no device, or a file cannot be written.
pub fn run(args: &StressArgs, common: &Common) -> Result<ExitCode> {
    if let Some(scene) = &args.endure {
        return aside::run_here(scene, args, common);
    }
    let start = Instant::now();
    let mut rig = Rig::new(&args.output, common)?;
    let methods: Vec<Method> = Method::ALL.into_iter().filter(|m| args.takes(m.name())).collect();
    let table = fill(&mut rig, &rows(args.full, &methods), &methods)?;
    let summary = format!(
        "{} images of 64x64 pixels in {:.0} s; {} cells of the table beyond their bounds",
        rig.drawn,
        start.elapsed().as_secs_f64(),
        table.broken().count()
    );
    let path = args.output.join("stress.txt");
    let write = |text: &str| std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()));
    // The long runs may take an hour: what was found so far is there if they are interrupted.
    write(&format!("{summary}\n\n{}", table.text()))?;
    table.write_picture(&args.output.join("stress.png"))?;
    let broken = keep_worst(&args.output, &table)?;
    let runs = long_runs(&rig, args, common)?;
    let faults: Vec<String> = runs.iter().flat_map(Endured::faults).collect();
    let text = format!(
        "{summary}; all in {:.0} min\n\n{}\n{}{}",
        start.elapsed().as_secs_f64() / 60.0,
        table.text(),
        endurance::table(&runs),
        faults.join("\n")
    );
    write(&text)?;
    say!("{text}");
    Ok(ExitCode::from(u8::from(broken > 0 || !faults.is_empty())))
}

/// The long runs: of all scenes, or a short one of the first.
fn long_runs(rig: &Rig, args: &StressArgs, common: &Common) -> Result<Vec<Endured>> {
    let scenes = if args.full { &endurance::SCENES[..] } else { &endurance::SCENES[..1] };
    let frames = |share: u32| (if args.full { args.frames } else { SHORT } / share).max(2);
    let runs: Vec<(&str, u32)> = scenes.iter().map(|&(scene, share)| (scene, frames(share))).collect();
    let bar = progress::bar(runs.iter().map(|(_, frames)| u64::from(*frames)).sum(), "long runs");
    let ended = match runs[..] {
        [(scene, frames)] => endurance::endure(rig.gpu(), scene, frames, common, &|| bar.inc(1)).map(|run| vec![run]),
        _ => aside::run_all(&runs, common, &bar),
    };
    bar.finish_and_clear();
    ended
}

/// All rows, or one for each method.
fn rows(full: bool, methods: &[Method]) -> Vec<Setup> {
    let levels = [methods.len(), SCALES.len(), INTENSITIES.len(), TILTS.len(), POSITIONS.len(), Grid::ALL.len()];
    let rows = cover::pairwise(&levels).into_iter().map(|row| Setup {
        method: methods[row[0]],
        scale: SCALES[row[1]],
        intensity: INTENSITIES[row[2]],
        tilt: TILTS[row[3]],
        position: POSITIONS[row[4]],
        grid: Grid::ALL[row[5]],
        quarter_turn: false,
        mirrored: false,
        lamps: Lamps::All,
        reversed: false,
        moved: 0.0,
        seed: 0,
    });
    let rows: Vec<Setup> = rows.collect();
    if full {
        return rows;
    }
    // Far from all that is usual.
    methods.iter().filter_map(|method| rows.iter().rev().find(|row| row.method == *method).cloned()).collect()
}

fn place(row: &Setup) -> String {
    format!(
        "scale {:.0e}, light {:.0e}, turned {:?}, at {:?}, grid {:?}",
        row.scale, row.intensity, row.tilt, row.position, row.grid
    )
}

fn fill(rig: &mut Rig, rows: &[Setup], methods: &[Method]) -> Result<Table> {
    let mut table = Table::default();
    let scenes = degenerate::scenes();
    let bar = progress::bar((rows.len() + methods.len() * (scenes.len() + 2)) as u64, "stress");
    for row in rows {
        let found = checks::check(rig, row).with_context(|| format!("{}: {}", row.method.name(), place(row)))?;
        for (invariant, deviation) in found {
            log::info!("{}, {}: {deviation:.2e} at {}", invariant.name(), row.method.name(), place(row));
            table.enter(invariant, row.method, deviation, &place(row), &row.text());
        }
        bar.inc(1);
    }
    rig.forget();
    for &method in methods {
        let albedos = if method == Method::Direct { &[][..] } else { &[0.5, 0.9][..] };
        for &albedo in albedos {
            let energy = room::energy(rig, method, Grid::Fixed, albedo)?;
            let place = format!("a closed room of albedo {albedo}");
            table.enter(Invariant::Energy, method, energy.excess, &place, "");
            table.enter(Invariant::Deficit, method, energy.deficit, &place, "");
            bar.inc(1);
        }
        for (name, stated, text) in &scenes {
            let outcome = degenerate::attempt(rig, method, text);
            log::info!("{name}, {}: {outcome:?}", method.name());
            let broken = !stated.holds(method, &outcome);
            if broken {
                log::warn!("{name}, {}: {outcome:?}, but stated is {stated:?}", method.name());
            }
            table.enter(
                Invariant::Degenerate,
                method,
                f64::from(u8::from(broken)),
                &format!("{name}: {outcome:?}, and not {stated:?}"),
                text,
            );
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(table)
}

/// Writes the scenes of what is beyond its bound; gives their number.
fn keep_worst(folder: &Path, table: &Table) -> Result<usize> {
    let mut count = 0;
    for (invariant, method, worst) in table.broken() {
        let name = format!("{} {}.scene.ron", invariant.name(), method.name()).replace(' ', "_");
        let path = folder.join(name);
        let text = format!("// {}\n{}", worst.place, worst.scene);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        count += 1;
    }
    Ok(count)
}
