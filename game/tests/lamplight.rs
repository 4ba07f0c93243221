//! The example game, played by scripts that win and lose it, with and without images.

#![allow(clippy::unwrap_used)]

#[path = "../examples/lamplight/game.rs"]
mod game;

use game::{Ball, Lamp, Phase, Run};
use lightwell_game::prelude::*;
use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/lamplight").join(name)
}

/// The way around the court, as a player would roll it: lamp by lamp, then to the gate.
const WAY: [(f32, f32); 12] = [
    (-5.9, 1.4),
    (-5.2, 0.0),
    (-6.3, -2.0),
    (-5.0, -3.5),
    (-2.0, -4.0),
    (0.4, -3.5),
    (3.2, -4.3),
    (5.4, -4.3),
    (5.5, -3.0),
    (5.8, -0.5),
    (5.5, 1.6),
    (6.6, 5.2),
];

/// Rolls the ball from place to place with the keys alone; gives what was pressed.
fn record_by_hand() -> InputScript {
    let mut game = game::app().start().unwrap();
    let (mut script, mut held, mut next) = (InputScript::default(), Vec::<Key>::new(), 0);
    for step in 1..60 * 60 {
        let ball = game.world.find("Ball").unwrap();
        let place = game.world.ecs.get::<Transform>(ball).unwrap().translation;
        let velocity = game.world.ecs.get::<Ball>(ball).unwrap().velocity;
        let phase = game.world.ecs.resource::<Run>().phase;
        let (x, z) = WAY[next];
        let away = Vec3::new(x - place.x, 0.0, z - place.z);
        next = if away.length() < 0.45 { (next + 1).min(WAY.len() - 1) } else { next };
        // Slows down in time: towards where it will be in a third of a second.
        let aim = away - velocity * 0.35;
        let wanted: Vec<Key> = match phase {
            Phase::Menu if step == 30 => vec![Key::Enter],
            Phase::Playing => {
                let axis =
                    |at: f32, low, high| if at.abs() < 0.15 { None } else { Some(if at < 0.0 { low } else { high }) };
                axis(aim.x, Key::A, Key::D).into_iter().chain(axis(aim.z, Key::W, Key::S)).collect()
            }
            _ => Vec::new(),
        };
        let up = held.iter().filter(|key| !wanted.contains(key)).map(|key| InputEvent::Release(Button::Key(*key)));
        let down = wanted.iter().filter(|key| !held.contains(key)).map(|key| InputEvent::Press(Button::Key(*key)));
        let events: Vec<InputEvent> = up.chain(down).collect();
        held = wanted;
        game.step(&events).unwrap();
        script.record(&events);
        if phase == Phase::Won {
            break;
        }
    }
    script
}

/// The script that wins; with `LIGHTWELL_BLESS=1` recorded anew, after a change of the court.
fn winning() -> InputScript {
    let path = file("win.script.ron");
    if std::env::var_os("LIGHTWELL_BLESS").is_some() {
        record_by_hand().write(&path).unwrap();
    }
    InputScript::read(&path).unwrap()
}

#[test]
fn the_winning_script_wins() {
    let game = game::app().simulate(&winning()).unwrap();
    let run = game.world.ecs.resource::<Run>();
    assert_eq!((run.phase, run.lamps), (Phase::Won, [5, 5]), "{run:?}");
    assert!(run.score >= 5 * 50 + 20 && run.glow > 0.0, "{run:?}");
}

#[test]
fn the_losing_script_loses_its_glow() {
    let game = game::app().simulate(&InputScript::read(&file("lose.script.ron")).unwrap()).unwrap();
    let run = game.world.ecs.resource::<Run>();
    assert!(run.phase == Phase::Lost && run.glow <= 0.0 && run.lamps == [0, 5], "{run:?}");
}

#[test]
fn who_falls_into_the_well_has_lost_and_rolls_again() {
    let text = "Script(steps: 200, events: [
        (1, Press(Key(Enter))), (2, Release(Key(Enter))),
        (2, Move(LeftX, 0.0)), (190, Press(Pad(South))), (191, Release(Pad(South))),
    ])";
    let script = InputScript::parse(&file("well.script.ron"), text).unwrap();
    // Before it begins to roll the ball is put over the well.
    let into_the_well = |time: Res<Time>, mut ball: Single<&mut Transform, With<Ball>>| {
        if time.step == 3 {
            ball.translation = Vec3::new(0.0, 0.5, 0.0);
        }
    };
    let play =
        |steps| game::app().systems(FixedUpdate, into_the_well).simulate(&InputScript { steps, ..script.clone() });
    // The ball fell 2 m within a second.
    let mut short = script.clone();
    short.events.retain(|(step, _)| *step <= 100);
    let lost = game::app().systems(FixedUpdate, into_the_well).simulate(&InputScript { steps: 100, ..short }).unwrap();
    assert_eq!(lost.world.ecs.resource::<Run>().phase, Phase::Lost);
    let again = play(200).unwrap();
    let run = again.world.ecs.resource::<Run>();
    assert!(run.phase == Phase::Playing && run.time < 0.5 && run.glow > 0.95, "{run:?}");
    let ball = again.world.find("Ball").unwrap();
    assert!(again.world.ecs.get::<Transform>(ball).unwrap().translation.x < -4.0, "back at the start");
}

#[test]
fn a_saved_game_goes_on_with_its_lamps() {
    let folder = tempfile::tempdir().unwrap();
    let slot = folder.path().join("slot.save.ron");
    let script = winning();
    let mut short = script.clone();
    short.steps = script.steps / 2;
    short.events.retain(|(step, _)| *step <= short.steps);
    let mut first = game::app().simulate(&short).unwrap();
    first.save(&slot).unwrap();
    let lit = first.world.ecs.resource::<Run>().clone();
    assert!(lit.lamps[0] >= 1 && lit.lamps[0] < 5, "{lit:?}");
    let mut second = game::app().start().unwrap();
    second.load(&slot).unwrap();
    assert_eq!(second.world.ecs.resource::<Run>(), &lit);
    let mut lamps = second.world.ecs.query::<&Lamp>();
    assert_eq!(lamps.iter(&second.world.ecs).filter(|lamp| lamp.on).count() as u32, lit.lamps[0]);
    for step in short.steps + 1..=script.steps {
        second.step(&script.at(step)).unwrap();
    }
    // Keys that were held at the moment of saving are not: whoever loads presses them anew.
    assert!(second.world.ecs.resource::<Run>().lamps[0] >= lit.lamps[0]);
}

/// With images, the light that walls throw back counts: the ball ends with more glow than without.
#[test]
fn with_pictures_the_light_of_the_walls_counts() {
    let script = winning();
    let dark = game::app().simulate(&script).unwrap();
    let pictures = Pictures { size: [96, 60], every: 60, folder: None };
    let outcome = game::app().headless(&script, &pictures).unwrap();
    let [dark, lit] = [&dark, &outcome.game].map(|game| game.world.ecs.resource::<Run>().clone());
    assert_eq!(lit.phase, Phase::Won, "{lit:?}");
    assert!(lit.glow > dark.glow + 0.02, "{lit:?} {dark:?}");
    let ball = outcome.game.world.find("Ball").unwrap();
    let probe = outcome.game.world.ecs.get::<LightProbe>(ball).unwrap();
    assert!(probe.indirect.min_element() > 0.0, "{probe:?}");
    let ([width, height], bytes) = outcome.picture.unwrap();
    assert_eq!((width * height * 3) as usize, bytes.len());
    let mean = bytes.iter().map(|b| f64::from(*b)).sum::<f64>() / bytes.len() as f64;
    assert!(mean > 12.0, "the court is lit: {mean}");
}
