//! Tests of random rooms: without a device that all load, and with one that small runs work.

#![allow(clippy::unwrap_used)]

use super::figures::Figures;
use super::room::{Orientation, Room};
use crate::bench::run;
use crate::cli::{BenchArgs, BenchLine};
use clap::Parser;
use lightwell::assets::AssetLibrary;
use lightwell::files::{LoadOptions, load_scene};
use lightwell::world::{Camera, Clpv, Light};
use lightwell_runtime::cli::Common;
use std::collections::BTreeSet;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

fn args(folder: &Path, more: &[&str]) -> BenchArgs {
    let line = ["bench", "-o", folder.to_str().unwrap()];
    BenchLine::try_parse_from(line.iter().chain(more)).unwrap().args
}

fn figures(folder: &Path) -> Figures {
    serde_json::from_str(&std::fs::read_to_string(folder.join("rooms.json")).unwrap()).unwrap()
}

#[test]
fn rooms_are_the_same_on_every_machine() {
    let texts = |seed| (0..20).map(|index| Room::draw(seed, index).scene_text(seed)).collect::<String>();
    assert_eq!(texts(1), texts(1));
    assert_ne!(texts(1), texts(2));
    // A change of how rooms are made changes this value: figures of other rooms are not comparable.
    assert_eq!(format!("{:016x}", xxh3_64(texts(1).as_bytes())), "096bf01a5fffb2c4");
}

#[test]
fn rooms_load_without_errors() {
    let dir = tempfile::tempdir().unwrap();
    let mut library = AssetLibrary::new();
    for index in 0..60 {
        let path = dir.path().join(format!("{index}.scene.ron"));
        let text = Room::draw(1, index).scene_text(1);
        std::fs::write(&path, &text).unwrap();
        let mut world = match load_scene(&path, &mut library, &LoadOptions::default()) {
            Ok(world) => world,
            Err(error) => panic!("room {index}: {error}\n{text}"),
        };
        let lights = world.ecs.query::<&Light>().iter(&world.ecs).count();
        assert!((1..=4).contains(&lights), "room {index}: {lights} lights");
        let volumes: Vec<&Clpv> = world.ecs.query::<&Clpv>().iter(&world.ecs).collect();
        assert_eq!(volumes, [&Clpv::default()], "room {index}");
        assert_eq!(world.ecs.query::<&Camera>().iter(&world.ecs).count(), 1, "room {index}");
    }
}

#[test]
fn rooms_are_of_all_kinds() {
    let rooms: Vec<Room> = (0..120).map(|index| Room::draw(1, index)).collect();
    let kinds: BTreeSet<(Orientation, String)> =
        rooms.iter().map(|room| (room.facts.orientation, room.facts.openness.clone())).collect();
    assert_eq!(kinds.len(), 12, "{kinds:?}");
    let longest = |room: &Room| room.facts.size.into_iter().fold(0.0, f64::max);
    assert!(rooms.iter().any(|room| longest(room) < 1.6) && rooms.iter().any(|room| longest(room) > 18.0));
    let cluttered: Vec<&Room> = rooms.iter().filter(|room| room.facts.cluttered).collect();
    assert_eq!(cluttered.len(), 30);
    assert!(cluttered.iter().all(|room| room.facts.solids > 60));
    for room in &rooms {
        assert!((0.5..=30.0).contains(&longest(room)), "{}", room.facts.description);
        let sees = &room.viewpoint;
        let clear = room.items.iter().map(|item| item.distance(sees.from)).fold(f64::INFINITY, f64::min);
        assert!(clear > sees.near, "{}: something is {clear} m from the camera", room.facts.description);
        let inside = room.lighting.lights.iter().any(|light| light.kind != super::lights::Kind::Sun);
        assert!(inside || room.facts.openness != "closed", "{}: dark", room.facts.description);
        for light in room.lighting.lights.iter().filter(|light| light.kind != super::lights::Kind::Sun) {
            assert!(room.items.iter().all(|item| item.distance(light.from) > 0.0), "{}", room.facts.description);
        }
    }
}

#[test]
fn a_tiny_run_from_end_to_end_and_taken_up_again() {
    let dir = tempfile::tempdir().unwrap();
    let base = ["--seed", "5", "--size", "32x32", "--aa", "2", "--reference-spp", "64"];
    let run_rooms = |rooms: &str| {
        let more: Vec<&str> = ["--rooms", rooms].into_iter().chain(base).collect();
        let report = run(&args(dir.path(), &more), &Common::default()).unwrap();
        (figures(dir.path()), std::fs::read_to_string(report).unwrap())
    };
    let (first, _) = run_rooms("1");
    let (both, report) = run_rooms("2");
    assert_eq!(both.rooms[0], first.rooms[0], "what is there is not measured again");
    assert_eq!(
        both.methods.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
        ["single image", "2 images", "volumes alone"]
    );
    for room in &both.rooms {
        assert!(room.reference.indirect > 0.0 && room.reference.noise.is_finite(), "{room:?}");
        assert!((-0.3..1.0).contains(&room.reference.further_bounces), "{room:?}");
        for error in &room.errors {
            for layer in [&error.indirect, &error.total] {
                assert!(layer.nrmse.is_finite() && layer.bias.is_finite(), "{error:?}");
            }
        }
    }
    for word in ["By orientation", "By openness", "By rooms", "The worst rooms", "Near edges", "volumes alone"] {
        assert!(report.contains(word), "no `{word}` in\n{report}");
    }
    for file in ["worst/room_0001.scene.ron", "worst/room_0001_single_image.png", "rooms/room_0000.scene.ron"] {
        assert!(dir.path().join(file).is_file(), "{file}");
    }
    // Other settings are not mixed with those.
    let other = args(dir.path(), &["--rooms", "2", "--seed", "6", "--size", "32x32", "--aa", "2"]);
    let message = format!("{:#}", run(&other, &Common::default()).unwrap_err());
    assert!(message.contains("--fresh"), "{message}");
}

/// What the default settings hold in whatever room, loosely: see `rooms.md` of a long run for how well they do.
#[test]
fn the_default_settings_stay_near_the_reference() {
    let dir = tempfile::tempdir().unwrap();
    let settings = ["--method", "gather high", "--size", "48x48", "--aa", "4", "--reference-spp", "256"];
    let more: Vec<&str> = ["--rooms", "4", "--seed", "1"].into_iter().chain(settings).collect();
    run(&args(dir.path(), &more), &Common::default()).unwrap();
    let rooms = figures(dir.path()).rooms;
    let mut errors: Vec<f64> = rooms.iter().map(|room| room.errors[0].indirect.nrmse).collect();
    errors.sort_by(f64::total_cmp);
    // The second of four by size; halos around small panels that glow may make one room worse by far.
    assert!(errors[1] < 0.35 && errors[3] < 3.0, "{errors:?}");
    for room in &rooms {
        let bias = room.errors[0].indirect.bias;
        assert!(bias.abs() < 0.2, "{}: bias {bias}", room.facts.description);
    }
}
