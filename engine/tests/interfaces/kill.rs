//! A save is all or nothing: whenever the program is killed, a whole scene is left.

#![allow(clippy::unwrap_used)]

use lightwell::assets::AssetLibrary;
use lightwell::files::{LoadOptions, load_scene, save_scene};
use lightwell::world::{GameWorld, Name};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Tells the process that saves which file.
const FILE: &str = "LIGHTWELL_TEST_SAVES";

fn world(path: &Path) -> GameWorld {
    load_scene(path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The process that is killed: saves one of two scenes after the other until then.
#[test]
fn saves_for_ever() {
    let Some(path) = std::env::var_os(FILE).map(PathBuf::from) else { return };
    let mut world = world(&path);
    let first = world.roots()[0];
    for round in 0_u64.. {
        world.ecs.entity_mut(first).insert(Name(if round % 2 == 0 { "Even" } else { "Odd" }.into()));
        save_scene(&world, &path).unwrap();
        if round == 3 {
            std::fs::write(path.with_extension("begun"), "").unwrap();
        }
    }
}

#[test]
fn a_kill_in_the_middle_of_a_save_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scene.ron");
    let entities: String = (0..400).map(|i| format!("(name: \"Box {i}\", mesh: Box()),\n")).collect();
    for trial in 0_u64..12 {
        std::fs::write(&path, format!("Scene(entities: [(name: \"Odd\", mesh: Box()), {entities}])")).unwrap();
        let begun = path.with_extension("begun");
        let _ = std::fs::remove_file(&begun);
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "kill::saves_for_ever"])
            .env(FILE, &path)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while !begun.exists() {
            assert!(start.elapsed() < Duration::from_secs(60), "the other process saves nothing");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(1700 * trial + 311));
        child.kill().unwrap();
        child.wait().unwrap();
        for file in [path.clone(), path.with_extension("ron.bak")] {
            let world = world(&file);
            let roots = world.roots();
            assert_eq!(roots.len(), 401, "{}", file.display());
            let name = world.name(roots[0]);
            assert!(name == "Even" || name == "Odd", "{name}");
        }
    }
    // What the dead left half-written goes with the next save.
    let left = || {
        let files = std::fs::read_dir(folder.path()).unwrap().flatten();
        files.filter(|file| file.path().extension().is_some_and(|ending| ending == "tmp")).count()
    };
    println!("half-written files left by the last kill: {}", left());
    save_scene(&world(&path), &path).unwrap();
    assert_eq!(left(), if cfg!(target_os = "linux") { 0 } else { left() });
}
