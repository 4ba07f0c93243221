//! Frames that reuse earlier results equal frames drawn from nothing, bit for bit, whatever was edited between them; and
//! every pass that is reused has a key that holds all that it binds.
//!
//! Random edits of a small world are drawn by three renderers: one that keeps what it can, a fresh one for each frame, and
//! one whose keys are audited, which computes everything in every frame. Edits are of objects, textures, poses, lights,
//! fog, particles, the sky, the camera with its lens, the size of the image, all fields of the methods of indirect light,
//! all settings of a frame and debug views. Frames that are averaged depend on those before them: they are compared with
//! those of the audited renderer, which has the same history, up to rounding.
//!
//! Each run has a fresh seed, which it prints. `LIGHTWELL_SEED` sets it and `LIGHTWELL_CASES` the number of cases, case n
//! with the seed plus n: a failure names the seed that repeats its case alone. Without `LIGHTWELL_CASES` the run ends
//! after some time.

mod fields;
mod looks;
mod studio;
mod surfaces;

use crate::support::gpu;
use lightwell::gpu::{Gpu, read_texture, read_texture_f32};
use lightwell::render::Renderer;
use lightwell::scene::SceneView;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestError, TestRunner};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use studio::{Edit, METHODS, Studio, edit};

/// Seeds of cases that have failed once.
const FAILED_ONCE: [u64; 4] = [1015, 1031, 1049, 1181];
/// Cases of a run, and the time after which no further one begins.
const CASES: u64 = 48;
const TIME: Duration = Duration::from_secs(20);
/// A kind of light.
const SPOT: &str = "Spot(inner: 20.0, outer: 50.0)";
/// Time to look for shorter sequences of edits that fail too \[ms\].
const SHRINK_MS: u32 = 20_000;
/// Relative difference of radiance that averaged frames may have. With seed 1181, where light is updated over four
/// frames, 7 of 1,536 values differ in their last bit; the pass that rounds differently is not known.
const ROUNDING: f32 = 2.5e-7;
/// Frames that are drawn of a state where they are averaged.
const AVERAGED: usize = 2;

/// The bits of an image's radiance, and of its display image if there is one.
struct Bits {
    radiance: Vec<u32>,
    display: Vec<u8>,
}

impl Bits {
    /// Whether all values are the same, those of radiance up to `rounding` of each.
    fn is_like(&self, other: &Self, rounding: f32) -> bool {
        let is_near = |(a, b): (&u32, &u32)| {
            let (x, y) = (f32::from_bits(*a), f32::from_bits(*b));
            a == b || (x - y).abs() <= rounding * x.abs()
        };
        let is_as_large = self.radiance.len() == other.radiance.len();
        is_as_large && self.radiance.iter().zip(&other.radiance).all(is_near) && self.display == other.display
    }

    /// How many values of the images differ, and the first of them.
    fn difference(&self, other: &Self) -> String {
        let differing = || self.radiance.iter().zip(&other.radiance).enumerate().filter(|(_, (a, b))| a != b);
        let (radiance, first) = (differing().count(), differing().next());
        let display = self.display.iter().zip(&other.display).filter(|(a, b)| a != b).count();
        let [of_radiance, of_display] = [self.radiance.len(), self.display.len()];
        let first = first.map_or_else(String::new, |(index, (expected, found))| {
            format!(" (the first, {index}: {:e} for {:e})", f32::from_bits(*found), f32::from_bits(*expected))
        });
        format!("{radiance} of {of_radiance} values of radiance{first}, {display} of {of_display} of the display image")
    }
}

/// Draws a frame; its images, or its error.
fn draw(gpu: &Gpu, renderer: &mut Renderer, studio: &Studio, view: &SceneView) -> Result<Bits, String> {
    renderer.render(gpu, &studio.scene, view, &studio.settings).map_err(|error| error.to_string())?;
    let radiance = renderer.radiance().ok_or("no radiance")?;
    let radiance = read_texture_f32(gpu, radiance).map_err(|error| error.to_string())?;
    let radiance = radiance.rgba.iter().flatten().map(|value| value.to_bits()).collect();
    let mut display = Vec::new();
    if studio.settings.display {
        let image = renderer.display().ok_or("no display image")?;
        display = read_texture(gpu, image, 0, 0).map_err(|error| error.to_string())?;
    }
    Ok(Bits { radiance, display })
}

/// Says how two results differ; `None` if they are the same, up to `rounding` of each value of radiance.
fn difference(expected: &Result<Bits, String>, found: &Result<Bits, String>, rounding: f32) -> Option<String> {
    match (expected, found) {
        (Ok(expected), Ok(found)) => (!expected.is_like(found, rounding)).then(|| expected.difference(found)),
        (Err(expected), Err(found)) if expected == found => None,
        (Err(error), Ok(_)) => Some(format!("an error is missing: {error}")),
        (_, Err(error)) => Some(error.clone()),
    }
}

fn check(gpu: &Gpu, frames: &[Vec<Edit>]) -> Result<(), TestCaseError> {
    let mut studio = Studio::new();
    let (mut keeping, mut audited) = (Renderer::new(gpu), Renderer::new(gpu));
    audited.set_audit(true);
    let mut log = String::new();
    for (number, edits) in frames.iter().enumerate() {
        for edit in edits {
            log += &format!("\n  frame {number}: {}", studio.describe(*edit));
            studio.apply(*edit);
        }
        let view = studio.view();
        let is_averaged = studio.settings.average;
        for _ in 0..if is_averaged { AVERAGED } else { 1 } {
            let audit = draw(gpu, &mut audited, &studio, &view);
            let kept = draw(gpu, &mut keeping, &studio, &view);
            let fresh = (!is_averaged).then(|| draw(gpu, &mut Renderer::new(gpu), &studio, &view));
            let expected = fresh.as_ref().unwrap_or(&audit);
            let rounding = if is_averaged { ROUNDING } else { 0.0 };
            let state = format!("frame {number} with {:?}, edits:{log}", studio.settings.gi);
            if let Some(difference) = difference(expected, &kept, rounding) {
                return Err(TestCaseError::fail(format!("a frame that reuses results differs: {difference}; {state}")));
            }
            if let Some(difference) = difference(expected, &audit, rounding) {
                return Err(TestCaseError::fail(format!("an audited frame differs: {difference}; {state}")));
            }
        }
    }
    Ok(())
}

/// Draws the world after each of the edits in turn.
fn check_edits(frames: &[&[Edit]]) {
    if let Err(error) = check(&gpu(), &frames.iter().map(|edits| edits.to_vec()).collect::<Vec<_>>()) {
        panic!("{error}");
    }
}

/// Draws the edits of a seed; the error of the shortest sequence of edits that fails.
fn check_seed(gpu: &Gpu, seed: u64) -> Result<(), String> {
    let config = Config {
        cases: 1,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        max_shrink_time: SHRINK_MS,
        max_shrink_iters: 10_000,
        ..Config::default()
    };
    let frames = prop::collection::vec(prop::collection::vec(edit(), 1..4), 2..7);
    // Consecutive seeds begin with different methods, so that all of them come up.
    let method = (seed % METHODS.len() as u64) as usize;
    let strategy = frames.prop_map(move |mut frames| {
        frames[0].insert(0, Edit::Method(method));
        frames
    });
    let failure = match TestRunner::new(config).run(&strategy, |frames| check(gpu, &frames)) {
        Ok(()) => return Ok(()),
        // The reason has the edits of the shortest sequence already.
        Err(TestError::Fail(reason, _)) => reason,
        Err(TestError::Abort(reason)) => reason,
    };
    Err(format!("LIGHTWELL_SEED={seed} LIGHTWELL_CASES=1: {failure}"))
}

fn from_environment(variable: &str) -> Option<u64> {
    let text = std::env::var(variable).ok()?;
    Some(text.parse().unwrap_or_else(|error| panic!("{variable}={text}: {error}")))
}

#[test]
fn random_edits_leave_nothing_behind() {
    let gpu = gpu();
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    let first = from_environment("LIGHTWELL_SEED").unwrap_or_else(clock);
    let wanted = from_environment("LIGHTWELL_CASES");
    let (start, mut count, mut failures) = (Instant::now(), 0, Vec::new());
    println!("first seed {first}");
    while count < wanted.unwrap_or(CASES) && (wanted.is_some() || start.elapsed() < TIME) {
        if let Err(failure) = check_seed(&gpu, first.wrapping_add(count)) {
            println!("{failure}\n");
            failures.push(failure);
        }
        count += 1;
    }
    println!("{count} cases from seed {first} on in {:.0} s", start.elapsed().as_secs_f64());
    assert!(failures.is_empty(), "{} of {count} cases failed:\n{}", failures.len(), failures.join("\n\n"));
}

#[test]
fn seeds_that_have_failed_once_pass() {
    let gpu = gpu();
    let failures: Vec<String> = FAILED_ONCE.iter().filter_map(|seed| check_seed(&gpu, *seed).err()).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

/// Random numbers of averaged frames choose texels, of a sum that does not depend on them.
#[test]
fn sums_over_maps_are_kept_while_random_numbers_change() {
    use Edit::*;
    check_edits(&[&[Method(1), Look(looks::number("average"))], &[Method(4)], &[Nothing]]);
}

/// Shaders that cast rays are compiled for the kinds of all lights, also where they sample none.
#[test]
fn links_are_found_again_with_shaders_for_other_lights() {
    use Edit::*;
    check_edits(&[&[Method(4)], &[Set(0, "light.kind", "Tube(length: 0.6, radius: 0.05)")], &[Nothing]]);
}

/// The reference beside the image continues over frames.
#[test]
fn the_reference_beside_the_image_is_kept() {
    use Edit::*;
    check_edits(&[&[Method(8), Look(looks::number("beside"))], &[Surface(0, 2)], &[Method(6)]]);
}

#[test]
fn rsm_samples_follow_the_numbers_of_lights() {
    use Edit::*;
    // Both lights shine; the first, which feeds no volumes, goes, and the second takes its number.
    let first =
        [Method(2), Set(0, "light.indirect", "false"), LightComesOrGoes(1), Set(1, "light.kind", SPOT), Shown(1)];
    check_edits(&[&first, &[LightComesOrGoes(0)]]);
}

#[test]
fn shadows_of_lights_from_maps_follow_what_moves_out_of_sight() {
    use Edit::*;
    // A box that neither the spot light nor the camera sees, but shadow rays may meet.
    // Dynamic objects are drawn apart from static ones, whose keys then say nothing of them.
    let (there, back) = ([ThingMoves(1, 4)], [ThingMoves(1, 3)]);
    // Virtual lights of maps, and light culling: each with shadow rays.
    for method in [7, 9] {
        let first = [Method(method), Set(0, "light.kind", SPOT), ThingComesOrGoes(1), ThingMoves(1, 3), Shown(1)];
        check_edits(&[&first, &there, &back, &there, &back, &there]);
    }
}

/// Soft shadows, which rays cast without any map.
#[test]
fn soft_shadows_follow_what_moves_out_of_sight() {
    use Edit::*;
    let (there, back) = ([ThingMoves(1, 4)], [ThingMoves(1, 3)]);
    let ball = "Sphere(radius: 0.2)";
    let first = [Method(0), Set(0, "light.kind", ball), ThingComesOrGoes(1), ThingMoves(1, 3), Shown(2)];
    check_edits(&[&first, &there, &back, &there, &back, &there]);
}

/// Skies that differ by direction, of nearly the same mean, and images of the sky, under each method.
#[test]
fn skies_by_direction_are_followed() {
    use Edit::*;
    for method in 0..METHODS.len() {
        check_edits(&[&[Method(method), Sky(2), Shown(1)], &[Sky(3)], &[Sky(4)], &[Sky(7)], &[Sky(8)]]);
    }
}

/// A sky that lights nothing changes no other pass: composition alone must see it.
#[test]
fn a_sky_that_lights_nothing_is_seen() {
    use Edit::*;
    check_edits(&[
        &[Method(0), Set(0, "scene.sky_light", "false"), Shown(0), Sky(0)],
        &[Sky(1)],
        &[Sky(2)],
        &[Sky(3)],
        &[Sky(1)],
    ]);
}

/// Fog comes, is another one at the same place, moves out of sight and goes, under each method.
#[test]
fn fog_is_followed() {
    use Edit::*;
    for method in 0..METHODS.len() {
        check_edits(&[
            &[Method(method), FogComesOrGoes(0), Fog(0, 3), Shown(0)],
            &[Fog(0, 4)],
            &[FogComesOrGoes(1), Fog(1, 6)],
            &[FogMoves(0, 2)],
            &[FogComesOrGoes(1)],
            &[FogComesOrGoes(0)],
        ]);
    }
}

/// A thing becomes glass, of another colour, moves, turns and becomes stone, under each method.
#[test]
fn glass_is_followed() {
    use Edit::*;
    for method in 0..METHODS.len() {
        check_edits(&[
            &[Method(method), Surface(0, 6), Shown(0)],
            &[Surface(0, 7)],
            &[Surface(1, 5), ThingComesOrGoes(1)],
            &[ThingMoves(0, 2)],
            &[Set(0, "light.color", "(0.2, 0.9, 0.5)")],
            &[Surface(0, 0)],
        ]);
    }
}

#[test]
fn all_virtual_lights_shine_after_those_in_reach_did() {
    use Edit::*;
    check_edits(&[&[Method(6), Camera(2), Shown(1)], &[Set(0, "vpl.view_driven", "false")]]);
}
