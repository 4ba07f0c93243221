//! `lightwell pack`: games that cargo has built are packed, and run from elsewhere as from the source tree.

#![allow(clippy::unwrap_used)]

use lightwell_runtime::cli::Common;
use lightwell_tests::root;
use lightwell_tools::cli::PackArgs;
use lightwell_tools::pack;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// An example's program. Cargo builds it with the tests, unless a single test was asked for.
fn example(name: &str) -> PathBuf {
    let programs = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("examples");
    let path = programs.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.exists(), "the example `{name}` is not built (cargo build --release --examples)");
    path
}

fn arguments(name: &str, output: &Path) -> PackArgs {
    PackArgs {
        program: Some(example(name)),
        example: Some(name.into()),
        // Its folder is where the paths of examples start.
        manifest_path: Some(root().join("Cargo.toml")),
        output: Some(output.to_owned()),
        ..Default::default()
    }
}

fn pack(args: &PackArgs) -> Result<(), String> {
    pack::run(args, &Common::default()).map_err(|error| format!("{error:#}"))
}

/// All files below a folder, with `/` on every system.
fn files(folder: &Path) -> Vec<String> {
    fn collect(root: &Path, folder: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => collect(root, &path, found),
                false => found.push(path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/")),
            }
        }
    }
    let mut found = Vec::new();
    collect(folder, folder, &mut found);
    found.sort();
    found
}

/// Plays two steps without a window and gives the image.
fn image(program: &Path, folder: &Path, is_alone: bool) -> Vec<u8> {
    let output = TempDir::new().unwrap();
    let mut command = Command::new(program);
    command.args(["--headless", "--steps", "2", "--every", "2", "--size", "96x60", "-o"]).arg(output.path());
    if is_alone {
        command.env_clear().env("HOME", output.path());
    } else {
        command.env_remove("LIGHTWELL_SHADERS");
    }
    let said = command.current_dir(folder).output().unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    std::fs::read(output.path().join("step_0002.png")).unwrap()
}

#[test]
fn a_packed_game_runs_from_an_empty_folder_and_draws_the_same() {
    let folder = TempDir::new().unwrap();
    pack(&arguments("corner", &folder.path().join("packed"))).unwrap();
    let moved = folder.path().join("moved");
    std::fs::rename(folder.path().join("packed"), &moved).unwrap();
    assert_eq!(files(&moved), ["LICENCES.txt", "assets/corner.scene.ron", "corner", "packed.txt"]);
    let (empty, packed) = (TempDir::new().unwrap(), moved.join("corner"));
    let drawn = image(&packed, empty.path(), true);
    assert!(drawn == image(&example("corner"), &root(), false), "the packed game draws another image");
    assert_eq!(files(empty.path()).len(), 0);

    // Files of that name that lie around are not taken for the game's.
    let scenes = empty.path().join("game/examples/scenes");
    std::fs::create_dir_all(&scenes).unwrap();
    std::fs::write(scenes.join("corner.scene.ron"), "Scene()").unwrap();
    assert!(drawn == image(&packed, empty.path(), true), "a scene in the working directory counts");
    // A folder of shaders beside the program does take the place of those within it.
    std::fs::create_dir_all(moved.join("shaders/geometry")).unwrap();
    std::fs::write(moved.join("shaders/geometry/gbuffer.wgsl"), "nonsense").unwrap();
    let words = ["--headless", "--steps", "1", "--every", "1"];
    let said = Command::new(&packed).args(words).current_dir(empty.path()).output().unwrap();
    let errors = String::from_utf8_lossy(&said.stderr);
    assert!(!said.status.success() && errors.contains("gbuffer.wgsl:1:"), "{errors}");
}

#[test]
fn what_a_script_loads_and_what_is_included_is_packed() {
    let folder = TempDir::new().unwrap();
    let sources = root().join("game/examples/lamplight");
    let args = PackArgs {
        script: Some(sources.join("lose.script.ron")),
        include: ["lit.wav", "won.wav", "tile.prefab.ron"].map(|name| sources.join(name)).to_vec(),
        ..arguments("lamplight", &folder.path().join("packed"))
    };
    pack(&args).unwrap();
    let packed = files(&folder.path().join("packed"));
    let assets: Vec<&str> = packed.iter().filter_map(|name| name.strip_prefix("assets/")).collect();
    let all = [
        "game/examples/lamplight/bush.prefab.ron",
        "game/examples/lamplight/court.scene.ron",
        "game/examples/lamplight/cypress.prefab.ron",
        "game/examples/lamplight/firefly.prefab.ron",
        "game/examples/lamplight/lamp.prefab.ron",
        "game/examples/lamplight/lamplight.actions.ron",
        "game/examples/lamplight/lit.wav",
        "game/examples/lamplight/tile.prefab.ron",
        "game/examples/lamplight/won.wav",
        "prefabs/column.prefab.ron",
    ];
    assert_eq!(assets, all);
    let licences = std::fs::read_to_string(folder.path().join("packed/LICENCES.txt")).unwrap();
    for words in ["bevy_ecs 0.20", "lightwell 0.1", "wgpu 30", "Permission is hereby granted", "Apache License"] {
        assert!(licences.contains(words), "no {words}");
    }
    assert!(!licences.contains("proptest") && !licences.contains("clap_derive"), "what is not in the program");
}

#[test]
fn only_a_packed_game_that_nobody_added_to_is_replaced() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("packed");
    let args = arguments("corner", &output);
    let forced = PackArgs { force: true, ..arguments("corner", &output) };
    let refused = |args: &PackArgs, words: &str| {
        let error = pack(args).expect_err(words);
        assert!(error.contains(words), "{error}");
    };
    std::fs::create_dir(&output).unwrap();
    std::fs::write(output.join("letter.txt"), "dear").unwrap();
    refused(&args, "is there already");
    refused(&forced, "is no packed game");
    std::fs::remove_dir_all(&output).unwrap();
    std::fs::write(&output, "a file").unwrap();
    refused(&forced, "is no packed game");
    std::fs::remove_file(&output).unwrap();

    pack(&args).unwrap();
    refused(&args, "is there already");
    std::fs::write(output.join("slot.ron"), "saved").unwrap();
    refused(&forced, "slot.ron was not packed");
    std::fs::remove_file(output.join("slot.ron")).unwrap();
    std::fs::write(output.join("assets/corner.scene.ron"), "changed").unwrap();
    pack(&forced).unwrap();
    assert!(std::fs::read_to_string(output.join("assets/corner.scene.ron")).unwrap().starts_with("Scene("));
    // Nothing is left beside it.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_cannot_be_packed_is_told_before_anything_is_there() {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("packed");
    let refused = |args: PackArgs, words: &[&str]| {
        let error = pack(&args).expect_err(words[0]);
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        assert!(!output.exists());
    };
    let args = || arguments("corner", &output);
    refused(PackArgs { include: vec!["no/such.wav".into()], ..args() }, &["no/such.wav", "there is no such file"]);
    let away = folder.path().join("away.wav");
    std::fs::write(&away, "").unwrap();
    refused(PackArgs { include: vec![away], ..args() }, &["away.wav lies outside of", "move it there", "--trust"]);
    let prefab = root().join("game/examples/lamplight/broken.prefab.ron");
    let broken = folder.path().join("broken.scene.ron");
    std::fs::write(&broken, "Scene(entities: [(name: \"A\", prefab: \"gone.prefab.ron\")])").unwrap();
    refused(PackArgs { include: vec![broken], ..args() }, &["broken.scene.ron:1:", "gone.prefab.ron"]);
    refused(PackArgs { include: vec![prefab], ..args() }, &["there is no such file"]);
    refused(PackArgs { program: Some("no/such".into()), ..args() }, &["there is no no/such"]);
    let lightwell = example("corner").with_file_name("../lightwell");
    if lightwell.exists() {
        refused(PackArgs { program: Some(lightwell), ..args() }, &["does not know --list-files"]);
    }
    refused(PackArgs { example: None, package: Some("nobody".into()), program: None, ..args() }, &["`nobody`"]);
}
