//! Pairs of scenes that should cost about the same, drawn alternately.

use super::figures::Pair;
use super::glb;
use super::measure::{Course, Frame, frame, spread};
use crate::bench::results::Store;
use anyhow::{Context, Result};
use glam::Vec3;
use lightwell::render::GiMethod;
use lightwell::world::{Light, LightKind, Transform};
use lightwell_runtime::cli::LookArgs;
use lightwell_runtime::progress::Bar;
use lightwell_runtime::session::Session;

/// Image size [pixels].
const SIZE: [u32; 2] = [512, 288];
/// The same in the short run.
const QUICK_SIZE: [u32; 2] = [64, 36];
/// Lights of the two scenes.
const LAMPS: [u32; 2] = [1_000, 10];
/// Boxes that are drawn as many meshes and as one.
const BOXES: usize = 1_200;

/// Measures the pairs that are missing.
///
/// # Errors
/// If a scene cannot be loaded or drawn.
pub fn measure(course: &Course, store: &mut Store, bar: &Bar) -> Result<()> {
    let known = |store: &Store, name: &str| store.results.pairs.iter().any(|pair| pair.name == name);
    if !known(store, "lamps") {
        bar.set_message("1,000 lamps against 10");
        let pair = Pair {
            name: "lamps".to_owned(),
            of: LAMPS.map(|count| format!("`{}` without its sky, {count} lamps of 2 m reach more", hall(course))),
            bound: 3.0,
            ..in_turns(course, [with_lamps(course, LAMPS[0])?, with_lamps(course, LAMPS[1])?])?
        };
        store.results.pairs.push(pair);
        store.save()?;
    }
    if !known(store, "meshes") {
        bar.set_message("1,200 meshes against one");
        let pair = Pair {
            name: "meshes".to_owned(),
            of: [format!("{BOXES} boxes, a mesh each"), "the same triangles in one mesh".to_owned()],
            bound: 1.2,
            ..in_turns(course, [boxes(course, "many", "Keep")?, boxes(course, "merged", "Merge")?])?
        };
        store.results.pairs.push(pair);
        store.save()?;
    }
    Ok(())
}

fn look() -> LookArgs {
    LookArgs { gi: Some(GiMethod::NONE), ..LookArgs::default() }
}

/// The scene that the lights illuminate.
fn hall(course: &Course) -> &'static str {
    if course.quick { "glasshouse" } else { "courtyard" }
}

/// That scene with so many lights spread through it.
fn with_lamps(course: &Course, count: u32) -> Result<Session> {
    // The sky's light would take most of both frames.
    let look = LookArgs { sets: vec![("scene.sky".to_owned(), "(0, 0, 0)".to_owned())], ..look() };
    let mut session = Session::open(course.gpu.clone(), hall(course), &look, course.common)?;
    let bounds = session.scene().bounds();
    let world = &mut session.parts().world;
    for index in 0..count {
        // Halton's sequence: even over the space, whatever their number.
        let at = Vec3::new(halton(index, 2), 0.5 * halton(index, 3), halton(index, 5));
        let entity = world.spawn(&format!("Lamp {index}"), None);
        let light = Light {
            kind: LightKind::Point,
            intensity: 0.2,
            range: Some(2.0),
            casts_shadow: false,
            indirect: false,
            ..Light::default()
        };
        let translation = bounds.min + at * (bounds.max - bounds.min);
        world.ecs.entity_mut(entity).insert((Transform { translation, ..Transform::default() }, light));
    }
    session.set_ticks(0);
    Ok(session)
}

fn halton(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    index += 1;
    while index > 0 {
        digit /= base as f32;
        value += digit * (index % base) as f32;
        index /= base;
    }
    value
}

/// The boxes under a sun with shadows.
fn boxes(course: &Course, name: &str, parts: &str) -> Result<Session> {
    let write = |file: String, bytes: &[u8]| {
        let path = course.folder.join(file);
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        anyhow::Ok(path)
    };
    write(format!("{name}.glb"), &glb::boxes(BOXES))?;
    write(format!("{name}.import.ron"), format!("(parts: {parts})").as_bytes())?;
    let text = format!(
        "Scene(entities: [\n\
         (name: \"Camera\", transform: (translation: (0, 12, 20), look_at: (0, 0, 0)), camera: (fov: 60)),\n\
         (name: \"Sun\", transform: (rotation: (-55, 30, 0)), light: (kind: Directional, intensity: 4)),\n\
         (name: \"Floor\", mesh: Plane(size: (24, 24))),\n\
         (name: \"Boxes\", model: \"{name}.glb\"),\n])\n"
    );
    let path = write(format!("{name}.scene.ron"), text.as_bytes())?;
    Session::open(course.gpu.clone(), &path.to_string_lossy(), &look(), course.common)
}

fn in_turns(course: &Course, mut sessions: [Session; 2]) -> Result<Pair> {
    let mut frames: [Vec<Frame>; 2] = [Vec::new(), Vec::new()];
    for round in 0..course.frames + 2 {
        for (session, frames) in sessions.iter_mut().zip(&mut frames) {
            let drawn = frame(session, if course.quick { QUICK_SIZE } else { SIZE }, false)?;
            if round >= 2 {
                frames.push(drawn);
            }
        }
    }
    let draws = frames.each_ref().map(|frames| frames.last().map_or(0, |frame| frame.report.total().draws));
    Ok(Pair {
        device: frames.each_ref().map(|frames| spread(frames, Frame::device)),
        frame: frames.each_ref().map(|frames| spread(frames, |frame| frame.wall)),
        record: frames.each_ref().map(|frames| spread(frames, Frame::record)),
        draws,
        ..Pair::default()
    })
}
