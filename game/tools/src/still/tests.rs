//! Tests of averages on the device.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::capture::Sampling;
use crate::cli::{Quality, QualityArgs};
use crate::shot::{Images, Shot};
use lightwell::measure::flip_displayed;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::writer::Picture;

const SIZE: [u32; 2] = [64, 48];

/// The Cornell box with all the noise of its rays.
fn noisy() -> Session {
    let sets = vec![("clpv.gather_filter".to_owned(), "1".to_owned())];
    let look = LookArgs { sets, ..LookArgs::default() };
    let mut session = Session::headless("cornell", &look, &Common::default()).unwrap();
    session.set_seconds(0.0);
    session
}

fn goal(quality: Quality) -> Goal {
    // No limit, whatever else the machine does meanwhile: the bytes are those of every run.
    Goal { time_limit: Duration::MAX, ..Goal::new(&QualityArgs::default(), quality) }
}

fn still(session: &mut Session, goal: Goal) -> (Image, Outcome) {
    let settings = session.render_settings(true);
    average(session, SIZE, &settings, goal, &mut |_| ()).unwrap()
}

#[test]
fn better_qualities_are_nearer_to_what_they_converge_to_and_know_how_near() {
    let mut session = noisy();
    // Other shifts and random numbers than those of the averages. Its own noise is a good half of that of the best. A screen
    // clips and curves the noise of each frame, which is less where edges share their light: so they share it here too.
    let settings = session.render_settings(true);
    let sampling = Sampling { images: 512, edges: goal(Quality::Best).edges };
    let converged = capture::take_telling(&mut session, SIZE, sampling, &settings, &mut || ()).unwrap();
    let mut last = f64::INFINITY;
    for quality in [Quality::Fast, Quality::Good, Quality::Best] {
        let goal = Goal { least: 2, ..goal(quality) };
        let (image, outcome) = still(&mut session, goal);
        let error = flip_displayed(&image, &converged).mean();
        eprintln!("{quality:?}: error {error:.4}; {outcome}");
        assert_eq!(outcome.end, End::Bound, "{outcome}");
        assert!(outcome.estimate.mean <= goal.bound && goal.excess(outcome.estimate) <= 1.0, "{outcome}");
        assert!(error < 1.5 * outcome.estimate.mean && error > 0.4 * outcome.estimate.mean, "{error}, {outcome}");
        assert!(error < last, "{quality:?}: {error} after {last}");
        last = error;
    }
}

#[test]
fn the_same_command_gives_the_same_image_and_tells_how_far_it_is() {
    let mut session = noisy();
    let settings = session.render_settings(true);
    let mut steps = Vec::new();
    let (first, outcome) =
        average(&mut session, SIZE, &settings, goal(Quality::Good), &mut |step| steps.push(step)).unwrap();
    assert!(steps.iter().all(|step| step.images <= step.expected), "{steps:?}");
    assert_eq!(steps.len() as u32, outcome.images / 2 - 1, "one for each pair but the last");
    let (second, _) = still(&mut noisy(), goal(Quality::Good));
    assert_eq!(first.first_bit_difference(&second), None);
}

#[test]
fn the_time_limit_ends_an_average() {
    let mut session = noisy();
    let goal = Goal { bound: 0.0, most: 1 << 20, ..goal(Quality::Good) };
    let (_, outcome) = still(&mut session, Goal { time_limit: Duration::from_nanos(1), ..goal });
    assert_eq!((outcome.images, outcome.end), (2, End::Time), "two at least");
    let (_, outcome) = still(&mut session, Goal { time_limit: Duration::from_secs(2), ..goal });
    assert_eq!(outcome.end, End::Time);
    // What one pair takes may vary much on a machine that has other work.
    assert!(outcome.images > 2 && outcome.time < Duration::from_secs(6), "{outcome}");
    let (_, outcome) = still(&mut session, Goal { least: 2, most: 6, ..goal });
    assert_eq!((outcome.images, outcome.end), (6, End::Most));
}

/// `--aa 1` and images of radiance are frames as they are drawn for themselves, whatever was averaged before.
#[test]
fn single_frames_are_as_they_were() {
    let mut session = noisy();
    still(&mut session, Goal { bound: 1.0, least: 2, ..goal(Quality::Fast) });
    let view = |session: &Session| SceneView { camera: session.camera().unwrap(), size: SIZE, jitter: [0.0; 2] };
    let mut plain = noisy();
    let (place, settings) = (view(&plain), plain.display_settings());
    plain.render(&place, &settings).unwrap();
    let (_, bytes) = plain.display_bytes().unwrap();
    let shot = |linear, count| Shot { size: SIZE, images: Images::Count(Sampling::images(count)), linear };
    let (picture, outcome) = shot(false, 1).take(&mut session, &mut |_| ()).unwrap();
    let Picture::Display { rgb, .. } = picture else { panic!("no picture for a screen") };
    assert!(outcome.is_none() && rgb == bytes);
    let settings = plain.render_settings(false);
    for count in [1, 2] {
        let expected = capture::take(&mut plain, SIZE, count, &settings).unwrap();
        let (picture, _) = shot(true, count).take(&mut session, &mut |_| ()).unwrap();
        let Picture::Linear(radiance) = picture else { panic!("no radiance") };
        assert_eq!(radiance.first_bit_difference(&expected), None, "{count}");
    }
}
