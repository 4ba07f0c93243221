//! The files that a game says it loads, which `lightwell pack` packs: all of them, and errors where one is missing.

#![allow(clippy::unwrap_used)]

use lightwell_game::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const CHAIR: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"Chair","mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
    "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
    "textures":[{"source":0}],"images":[{"uri":"wood.png"}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
    "buffers":[{"byteLength":60,"uri":"chair.bin"}]}"#;

const HALL: &str = r#"Scene(
    settings: (environment: Image(file: "../images/sky.hdr")),
    materials: { "floor": (color_texture: "../images/floor.png") },
    entities: [
        (name: "Camera", camera: (lens: (grading: "../looks/warm.cube"))),
        (name: "Floor", mesh: Plane(), material: "floor"),
        (name: "Row", prefab: "../prefabs/row.prefab.ron"),
    ],
)"#;

/// A folder with a game's files.
struct Folder(tempfile::TempDir);

impl Folder {
    /// A game whose scene names something of every kind.
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let points: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect();
        let sky = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec(), vec![128; 32]].concat();
        let table = format!("LUT_3D_SIZE 2\n{}", "0.5 0.5 0.5\n".repeat(8));
        let row = r#"Prefab(entities: [(name: "Chair", prefab: "chair.prefab.ron")])"#;
        let chair = r#"Prefab(entities: [(name: "Model", model: "../models/chair.gltf")])"#;
        for (name, bytes) in [
            ("scenes/hall.scene.ron", HALL.as_bytes()),
            (
                "scenes/cellar.scene.ron",
                br#"Scene(entities: [(name: "Camera", camera: ()), (name: "Box", mesh: Box())])"#,
            ),
            ("scenes/hall.actions.ron", b"Actions(axes: {})"),
            ("scenes/step.wav", b"the sound is not read"),
            ("scenes/unused.wav", b""),
            ("prefabs/row.prefab.ron", row.as_bytes()),
            ("prefabs/chair.prefab.ron", chair.as_bytes()),
            ("models/chair.gltf", CHAIR.as_bytes()),
            ("models/chair.bin", &points),
            ("models/chair.import.ron", b"Import(scale: 0.5)"),
            ("images/sky.hdr", &sky),
            ("looks/warm.cube", table.as_bytes()),
        ] {
            folder.write(name, bytes);
        }
        for name in ["images/floor.png", "models/wood.png"] {
            lightwell::measure::write_png_rgb8(&folder.path(name), [1, 1], &[9, 9, 9]).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn app(&self) -> App {
        App::new(self.path("scenes/hall.scene.ron").to_str().unwrap()).actions("hall.actions.ron")
    }

    /// The names of the files that a game loads in some steps, the first scene first.
    fn loaded(&self, app: App, steps: u64, also: &[&str]) -> Vec<String> {
        let also: Vec<PathBuf> = also.iter().map(|name| self.path(name)).collect();
        let script = InputScript { steps, ..Default::default() };
        let files = app.files(&script, &also).unwrap_or_else(|error| panic!("{error:#}"));
        let root = self.0.path().canonicalize().unwrap();
        files.iter().map(|path| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/")).collect()
    }

    /// What a game says that cannot list its files.
    fn fault(&self, app: App, steps: u64) -> String {
        let result = app.files(&InputScript { steps, ..Default::default() }, &[]);
        format!("{:#}", result.expect_err("a fault"))
    }
}

const ALL: [&str; 12] = [
    "scenes/hall.scene.ron",
    "images/floor.png",
    "images/sky.hdr",
    "looks/warm.cube",
    "models/chair.bin",
    "models/chair.gltf",
    "models/chair.import.ron",
    "models/wood.png",
    "prefabs/chair.prefab.ron",
    "prefabs/row.prefab.ron",
    "scenes/hall.actions.ron",
    "scenes/step.wav",
];

#[test]
fn all_that_a_scene_names_is_found_and_no_more() {
    let folder = Folder::new();
    assert_eq!(folder.loaded(folder.app(), 0, &[]), ALL[..11]);
    // As it is heard, for the scene without a step names no sound.
    let app = folder.app().systems(FixedUpdate, |mut sounds: ResMut<Sounds>| sounds.play("step.wav", 1.0));
    assert_eq!(folder.loaded(app, 1, &[]), ALL);
}

#[test]
fn what_systems_load_is_found_by_playing_or_by_its_name() {
    let folder = Folder::new();
    let cellar = || App::new(folder.path("scenes/cellar.scene.ron").to_str().unwrap());
    assert_eq!(folder.loaded(cellar(), 0, &[]), ["scenes/cellar.scene.ron"]);
    let with_chair: BTreeSet<String> = folder.loaded(cellar(), 0, &["prefabs/row.prefab.ron"]).into_iter().collect();
    let models = ["models/chair.bin", "models/chair.gltf", "models/chair.import.ron", "models/wood.png"];
    assert!(models.iter().all(|name| with_chair.contains(*name)), "{with_chair:?}");
    assert!(with_chair.contains("prefabs/row.prefab.ron") && with_chair.contains("prefabs/chair.prefab.ron"));
    let hall = folder.loaded(cellar(), 0, &["scenes/hall.scene.ron"]);
    assert!(hall[0] == "scenes/cellar.scene.ron" && ALL[..10].iter().all(|name| hall.iter().any(|n| n == name)));
    // A system goes there in the third step.
    let app = cellar().systems(FixedUpdate, |time: Res<Time>, mut commands: Commands| {
        if time.step == 3 {
            commands.change_scene("hall.scene.ron");
        }
    });
    let played = folder.loaded(app, 4, &[]);
    assert!(played[0] == "scenes/cellar.scene.ron" && played.len() == 11, "{played:?}");
}

#[test]
fn a_missing_file_is_named_with_the_file_that_mentions_it() {
    for (gone, words) in [
        ("prefabs/chair.prefab.ron", ["row.prefab.ron:1:", "chair.prefab.ron`"]),
        ("models/chair.gltf", ["chair.prefab.ron:1:", "models/chair.gltf"]),
        ("models/chair.bin", ["chair.prefab.ron:1:", "chair.bin"]),
        ("images/floor.png", ["hall.scene.ron:", "floor.png"]),
        ("images/sky.hdr", ["hall.scene.ron:2:", "sky.hdr"]),
        ("looks/warm.cube", ["hall.scene.ron:5:", "warm.cube"]),
        ("scenes/hall.actions.ron", ["hall.actions.ron", ""]),
        ("scenes/hall.scene.ron", ["hall.scene.ron", ""]),
    ] {
        let folder = Folder::new();
        std::fs::remove_file(folder.path(gone)).unwrap();
        let fault = folder.fault(folder.app(), 0);
        assert!(words.iter().all(|word| fault.contains(word)), "without {gone}: {fault}");
    }
    let folder = Folder::new();
    let app = folder.app().systems(FixedUpdate, |mut sounds: ResMut<Sounds>| sounds.play("stop.wav", 1.0));
    let fault = folder.fault(app, 1);
    assert!(fault.contains("step 1") && fault.contains("`stop.wav`") && fault.contains("hall.scene.ron"), "{fault}");
}

#[test]
fn broken_files_are_told_where() {
    for (name, text) in [
        ("scenes/hall.scene.ron", "Scene(entities: [(nam: 3)])"),
        ("prefabs/row.prefab.ron", "Prefab(entities: ["),
        ("models/chair.gltf", "{}"),
        ("images/floor.png", "not an image"),
        ("scenes/hall.actions.ron", "Actions(axes: 3)"),
    ] {
        let folder = Folder::new();
        folder.write(name, text.as_bytes());
        let fault = folder.fault(folder.app(), 0);
        let file = Path::new(name).file_name().unwrap().to_str().unwrap();
        assert!(fault.contains(file), "{name}: {fault}");
    }
}
