//! Frames that reuse earlier results equal frames drawn from nothing, bit for bit, whatever was edited between them; and
//! every pass that is reused has a key that holds all that it binds.
//!
//! Random edits of a small world (things, lights and fog come, go, move and change, the sky, the camera, the size of the
//! image, the method of indirect light and its settings) are drawn by three renderers: one that keeps what it can, a
//! fresh one for each frame, and one whose keys are audited.

mod studio;

use crate::support::gpu;
use lightwell::gpu::{Gpu, read_texture, read_texture_f32};
use lightwell::render::Renderer;
use lightwell::scene::SceneView;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use studio::{Edit, METHODS, Studio, edit};

/// What a renderer makes of a frame: the bits of its two images, or its error.
fn draw(gpu: &Gpu, renderer: &mut Renderer, studio: &Studio, view: &SceneView) -> Result<Vec<u32>, String> {
    renderer.render(gpu, &studio.scene, view, &studio.settings).map_err(|error| error.to_string())?;
    let radiance = renderer.radiance().ok_or("no radiance")?;
    let radiance = read_texture_f32(gpu, radiance).map_err(|error| error.to_string())?;
    let display = renderer.display().ok_or("no display image")?;
    let display = read_texture(gpu, display, 0, 0).map_err(|error| error.to_string())?;
    let radiance = radiance.rgba.iter().flatten().map(|value| value.to_bits());
    Ok(radiance.chain(display.into_iter().map(u32::from)).collect())
}

fn check(gpu: &Gpu, frames: &[Vec<Edit>]) -> Result<(), TestCaseError> {
    let mut studio = Studio::new();
    let (mut keeping, mut audited) = (Renderer::new(gpu), Renderer::new(gpu));
    audited.set_audit(true);
    for (number, edits) in frames.iter().enumerate() {
        edits.iter().for_each(|edit| studio.apply(*edit));
        let view = studio.view();
        let fresh = draw(gpu, &mut Renderer::new(gpu), &studio, &view);
        let kept = draw(gpu, &mut keeping, &studio, &view);
        let state = format!("frame {number} with {:?}", studio.settings.gi);
        prop_assert_eq!(fresh.is_ok(), kept.is_ok(), "{}: {:?}, {:?}", state, fresh.err(), kept.err());
        prop_assert!(fresh == kept, "{}: other bits than from nothing", state);
        let audit = draw(gpu, &mut audited, &studio, &view);
        prop_assert!(audit == fresh, "{}: {:?}", state, audit.err());
    }
    Ok(())
}

/// Draws the world after each of the edits in turn.
fn check_edits(frames: &[&[Edit]]) {
    if let Err(error) = check(&gpu(), &frames.iter().map(|edits| edits.to_vec()).collect::<Vec<_>>()) {
        panic!("{error}");
    }
}

#[test]
fn random_edits_leave_nothing_behind() {
    let gpu = gpu();
    let cases = std::env::var("LIGHTWELL_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(48);
    let seed = std::env::var("LIGHTWELL_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let config = Config { cases, rng_seed: RngSeed::Fixed(seed), failure_persistence: None, ..Config::default() };
    let frames = prop::collection::vec(prop::collection::vec(edit(), 1..4), 2..7);
    // Each sequence begins with a method, so that all of them come up.
    let strategy = (0..METHODS.len(), frames).prop_map(|(method, mut frames)| {
        frames[0].insert(0, Edit::Method(method));
        frames
    });
    if let Err(error) = TestRunner::new(config).run(&strategy, |frames| check(&gpu, &frames)) {
        panic!("{error}");
    }
}

#[test]
fn rsm_samples_follow_the_numbers_of_lights() {
    use Edit::*;
    // Both lights shine; the first, which feeds no volumes, goes, and the second takes its number.
    let first = [Method(2), LightFeedsIndirect(0), LightComesOrGoes(1), LightKind(1, 2), Shown(1)];
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
        let first = [Method(method), LightKind(0, 2), ThingComesOrGoes(1), ThingMoves(1, 3), Shown(1)];
        check_edits(&[&first, &there, &back, &there, &back, &there]);
    }
}

/// The same of soft shadows, which rays cast without any map.
#[test]
fn soft_shadows_follow_what_moves_out_of_sight() {
    use Edit::*;
    let (there, back) = ([ThingMoves(1, 4)], [ThingMoves(1, 3)]);
    let first = [Method(0), LightKind(0, 4), ThingComesOrGoes(1), ThingMoves(1, 3), Shown(2)];
    check_edits(&[&first, &there, &back, &there, &back, &there]);
}

/// Skies that differ by direction, of nearly the same mean, under each method.
#[test]
fn skies_by_direction_are_followed() {
    use Edit::*;
    for method in 0..METHODS.len() {
        check_edits(&[&[Method(method), Sky(2), Shown(1)], &[Sky(3)], &[Sky(4)], &[Sky(2)]]);
    }
}

/// A sky that lights nothing changes no other pass: composition alone must see it.
#[test]
fn a_sky_that_lights_nothing_is_seen() {
    use Edit::*;
    check_edits(&[&[Method(0), Setting(11), Shown(0), Sky(0)], &[Sky(1)], &[Sky(2)], &[Sky(3)], &[Sky(1)]]);
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
            &[LightColor(0)],
            &[Surface(0, 0)],
        ]);
    }
}

#[test]
fn all_virtual_lights_shine_after_those_in_reach_did() {
    use Edit::*;
    check_edits(&[&[Method(6), Camera(2), Shown(1)], &[Setting(0)]]);
}
