//! A save changes what was edited and nothing else.

use super::*;
use crate::files::save::rewrite::rewritten;
use crate::files::save::scene::scene_text;
use crate::world::{Fog, FogShape, Light, Transform};
use lightwell_needs::needs;

const SCENE: &str = r#"// A yard.
Scene(
    settings: (sky: (0.1, 0.2, 0.3), duration: 4, exposure: 1), // the default, said anyway
    materials: {
        // Of the ball.
        "red": (color: (1, 0, 0), specular: 0.50),
    },
    entities: [ // all of them
        // Looks at the ball.
        (name: "Eye", transform: (translation: (0, 1, 4), rotation: (0, 10, 0)), camera: (fov: 45)),

        /* Lights. */

        // The key light.
        (
            name: "Sun", // from the south
            transform: (rotation: (-60, 30, 0)),
            // Bright.
            light: (kind: Directional, intensity: 3, range: None, casts_shadow: true),
        ), // the end of it
        (name: "Lamp", light: (kind: Point, intensity: 2e1)),
        (name: "Group", children: [
            // Small.
            (name: "Ball", transform: (scale: 2), mesh: Sphere(radius: 0.5), material: "red"), // round
            (name: "Box", mesh: Box(), material: (color: (0, 1, 0))),
        ]),
    ],
)
// The end.
"#;

/// The text after an edit of the loaded scene.
fn saved(text: &str, edit: impl FnOnce(&mut GameWorld)) -> String {
    let folder = Folder::new(&[("a.scene.ron", text)]);
    let mut world = folder.load("a.scene.ron").unwrap();
    edit(&mut world);
    save_scene(&world, &folder.path("a.scene.ron")).unwrap();
    folder.load("a.scene.ron").unwrap_or_else(|error| panic!("{error}"));
    folder.read("a.scene.ron")
}

/// The text with one piece in another's place, which it holds once.
fn with(text: &str, old: &str, new: &str) -> String {
    assert_eq!(text.matches(old).count(), 1, "{old}");
    text.replace(old, new)
}

fn light<'w>(world: &'w mut GameWorld, path: &str) -> bevy_ecs::prelude::Mut<'w, Light> {
    let entity = at(world, path).unwrap();
    world.ecs.get_mut::<Light>(entity).unwrap()
}

#[test]
fn without_a_change_every_byte_stays() {
    for text in [SCENE.to_owned(), SCENE.replace('\n', "\r\n"), format!("\u{feff}{SCENE}")] {
        assert_eq!(saved(&text, |_| {}), text);
    }
}

#[test]
fn one_field_is_one_value() {
    type Edit = fn(&mut GameWorld);
    let edits: [(Edit, &str, &str); 5] = [
        (|world| light(world, "Sun").intensity = 4.5, "intensity: 3,", "intensity: 4.5,"),
        (|world| light(world, "Sun").intensity = 5.0, "intensity: 3,", "intensity: 5,"),
        (|world| light(world, "Sun").casts_shadow = false, "casts_shadow: true", "casts_shadow: false"),
        (|world| light(world, "Sun").range = Some(7.0), "range: None", "range: 7"),
        (|world| light(world, "Lamp").range = Some(7.0), "intensity: 2e1)", "intensity: 2e1, range: 7)"),
    ];
    for (edit, old, new) in edits {
        for newline in ["\n", "\r\n"] {
            let text = SCENE.replace('\n', newline);
            assert_eq!(saved(&text, edit), with(&text, old, new));
        }
    }
    let moved = saved(SCENE, |world| {
        let eye = at(world, "Eye").unwrap();
        world.ecs.get_mut::<Transform>(eye).unwrap().translation.y = 2.5;
    });
    assert_eq!(moved, with(SCENE, "(0, 1, 4)", "(0, 2.5, 4)"), "angles stay angles");
}

#[test]
fn fog_keeps_what_was_written_of_it() {
    let fog = r#"(name: "Mist", fog: (shape: Sphere(radius: 3.0), extinction: 5e-2 /* thin */)),"#;
    let text =
        SCENE.replace("        // The key light.\n", &format!("        {fog} // at dawn\n        // The key light.\n"));
    let edit = |change: fn(&mut Fog)| {
        saved(&text, move |world| {
            let mist = at(world, "Mist").unwrap();
            change(&mut world.ecs.get_mut::<Fog>(mist).unwrap());
        })
    };
    assert_eq!(edit(|_| {}), text);
    assert_eq!(edit(|fog| fog.extinction = 0.1), with(&text, "5e-2", "0.1"));
    assert_eq!(edit(|fog| fog.shape = FogShape::Sphere { radius: 4.0 }), with(&text, "radius: 3.0", "radius: 4.0"));
    assert_eq!(edit(|fog| fog.anisotropy = 0.5), with(&text, "5e-2 /* thin */", "5e-2, /* thin */ anisotropy: 0.5"));
    let clear = saved(&text, |world| {
        let mist = at(world, "Mist").unwrap();
        world.ecs.entity_mut(mist).remove::<Fog>();
    });
    assert!(clear.contains(r#"(name: "Mist")"#) && clear.contains("// at dawn"), "{clear}");
}

#[test]
fn what_goes_takes_its_comments_and_no_others() {
    let gone = saved(SCENE, |world| {
        let sun = at(world, "Sun").unwrap();
        world.ecs.despawn(sun);
    });
    let start = SCENE.find("        // The key light.").unwrap();
    let end = SCENE.find("        (name: \"Lamp\"").unwrap();
    assert_eq!(gone, [&SCENE[..start], &SCENE[end..]].concat());
    let dark = saved(SCENE, |world| {
        let sun = at(world, "Sun").unwrap();
        world.ecs.entity_mut(sun).remove::<Light>();
    });
    let (start, end) = (SCENE.find("            // Bright.").unwrap(), SCENE.find("        ), // the end").unwrap());
    assert_eq!(dark, [&SCENE[..start], &SCENE[end..]].concat());
}

#[test]
fn what_moves_takes_its_comments_along() {
    let moved = saved(SCENE, |world| {
        let (ball, sun) = (at(world, "Group/Ball").unwrap(), at(world, "Sun").unwrap());
        world.set_parent(ball, Some(sun)).unwrap();
    });
    let ball = "            // Small.\n            (name: \"Ball\", transform: (scale: 2), mesh: Sphere(radius: 0.5), material: \"red\"), // round\n";
    let inner: String = ball.lines().map(|line| format!("    {line}\n")).collect();
    let without = with(SCENE, ball, "");
    let light = "casts_shadow: true),\n";
    assert_eq!(moved, with(&without, light, &format!("{light}            children: [\n{inner}            ],\n")));
}

#[test]
fn what_is_renamed_or_added_stands_in_its_place() {
    let renamed = saved(SCENE, |world| {
        let sun = at(world, "Sun").unwrap();
        world.ecs.entity_mut(sun).insert(Name("Moon".into()));
    });
    assert_eq!(renamed, with(SCENE, "\"Sun\"", "\"Moon\""));
    let added = saved(SCENE, |world| {
        let group = at(world, "Group").unwrap();
        world.spawn("New", Some(group));
    });
    let last = "material: (color: (0, 1, 0))),\n";
    assert_eq!(added, with(SCENE, last, &format!("{last}            (name: \"New\"),\n")));
}

#[test]
fn a_line_that_becomes_too_long_is_broken() {
    let text = SCENE
        .replace("            // Small.\n", "")
        .replace("name: \"Lamp\", ", &format!("name: \"{}\", ", "L".repeat(70)));
    let lamp = "L".repeat(70);
    let long = saved(&text, |world| {
        light(world, &lamp).shadow_size = 77;
        light(world, &lamp).rsm_size = 77;
    });
    assert!(
        long.contains(&format!(
            "        (\n            name: \"{lamp}\",\n            light: (kind: Point, intensity: 2e1, "
        )),
        "{long}"
    );
}

#[test]
fn the_file_as_it_is_now_is_edited() {
    let folder = Folder::new(&[("a.scene.ron", SCENE)]);
    let mut world = folder.load("a.scene.ron").unwrap();
    light(&mut world, "Sun").intensity = 9.0;
    let path = folder.path("a.scene.ron");
    // Another program has changed a comment, and a value that is the editor's now.
    let other = with(&with(SCENE, "// Bright.", "// Very bright."), "fov: 45", "fov: 60");
    folder.write("a.scene.ron", other.as_bytes());
    save_scene(&world, &path).unwrap();
    let expected = with(&with(SCENE, "// Bright.", "// Very bright."), "intensity: 3,", "intensity: 9,");
    assert_eq!(folder.read("a.scene.ron"), expected);
    assert_eq!(folder.read("a.scene.ron.bak"), other);
    // What cannot be read, or is gone, is edited as it was loaded.
    let expected = with(SCENE, "intensity: 3,", "intensity: 9,");
    folder.write("a.scene.ron", b"Scene(entities: [");
    save_scene(&world, &path).unwrap();
    assert_eq!(folder.read("a.scene.ron"), expected);
    std::fs::remove_file(&path).unwrap();
    save_scene(&world, &path).unwrap();
    assert_eq!(folder.read("a.scene.ron"), expected);
    save_scene(&world, &folder.path("b.scene.ron")).unwrap();
    assert_eq!(folder.read("b.scene.ron"), expected, "under another name too");
}

/// Scenes and prefabs in a folder of their own.
fn shipped_copies() -> Folder {
    let folder = Folder::new(&[]);
    for kind in ["scenes", "prefabs"] {
        for file in std::fs::read_dir(shipped(kind)).unwrap().flatten() {
            folder.write(&format!("{kind}/{}", file.file_name().display()), &std::fs::read(file.path()).unwrap());
        }
    }
    folder
}

fn names(folder: &Folder, kind: &str) -> Vec<String> {
    let files = std::fs::read_dir(folder.path(kind)).unwrap().flatten();
    files.map(|file| file.file_name().display().to_string()).filter(|name| name.ends_with(".ron")).collect()
}

/// Lines of one text that are not in the other, and the other way round.
fn difference(before: &str, after: &str) -> (Vec<String>, Vec<String>) {
    let missing =
        |a: &str, b: &str| a.lines().filter(|line| !b.lines().any(|other| other == *line)).map(str::to_owned).collect();
    assert_eq!(before.lines().count(), after.lines().count());
    (missing(before, after), missing(after, before))
}

fn check_scene(folder: &Folder, name: &str, options: &LoadOptions) {
    let path = folder.path(&format!("scenes/{name}"));
    let before = std::fs::read_to_string(&path).unwrap();
    let mut world = load_scene(&path, &mut AssetLibrary::new(), options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene_text(&world, &path).unwrap(), before, "{name}");
    let mut lights = world.ecs.query::<(Entity, &Light, &Source)>();
    let of_file =
        |(entity, _, source): &(Entity, &Light, &Source)| matches!(source.origin, Origin::File).then_some(*entity);
    let found = lights.iter(&world.ecs).find_map(|found| of_file(&found));
    let Some(entity) = found else { return };
    let mut wanted = world.rest_light(entity).unwrap();
    wanted.intensity += 0.125;
    world.set_rest_light(entity, wanted);
    let after = scene_text(&world, &path).unwrap();
    let (gone, came) = difference(&before, &after);
    assert!(gone.len() <= 1 && came.len() == 1, "{name}: {gone:?} {came:?}");
}

#[test]
fn shipped_scenes_keep_their_text() {
    let folder = shipped_copies();
    for name in super::round_trip::SHIPPED {
        check_scene(&folder, &format!("{name}.scene.ron"), &LoadOptions::default());
    }
}

#[needs("LIGHTWELL_MODELS")]
fn shipped_scenes_with_models_keep_their_text() {
    let folder = shipped_copies();
    let options = LoadOptions { models: std::env::var_os("LIGHTWELL_MODELS").map(Into::into), ..Default::default() };
    names(&folder, "scenes").iter().for_each(|name| check_scene(&folder, name, &options));
}

#[test]
fn shipped_prefabs_keep_their_text() {
    let folder = shipped_copies();
    let names = names(&folder, "prefabs");
    assert!(names.len() > 20);
    for name in names {
        let before = folder.read(&format!("prefabs/{name}"));
        let scene = format!("(entities: [(name: \"A\", prefab: \"../prefabs/{name}\")])");
        folder.write("scenes/one.scene.ron", scene.as_bytes());
        let mut world = folder.load("scenes/one.scene.ron").unwrap();
        let (scene, prefab) = (folder.path("scenes/one.scene.ron"), folder.path(&format!("prefabs/{name}")));
        let instance = at(&world, "A").unwrap();
        apply_to_prefab(&world, instance, &scene, &prefab).unwrap();
        assert_eq!(folder.read(&format!("prefabs/{name}")), before, "{name}");
        let part = world.children(instance)[0];
        let mut place = world.rest_transform(part);
        place.translation.x += 0.25;
        world.set_rest_transform(part, place);
        apply_to_prefab(&world, instance, &scene, &prefab).unwrap();
        let after = folder.read(&format!("prefabs/{name}"));
        let kept = before.lines().filter(|line| after.lines().any(|other| other == *line)).count();
        assert!(kept + 1 >= before.lines().count(), "{name}\n{after}");
    }
}

#[test]
fn overrides_that_change_nothing_stay() {
    let lamp = "Prefab(entities: [(name: \"Pole\", mesh: Box(), light: (kind: Point, intensity: 3)), (name: \"Sign\", children: [(name: \"Text\")])])";
    let scene = r#"Scene(
    entities: [
        (name: "Lamp", prefab: "lamp.prefab.ron", overrides: {
            "Sign": (), // nothing yet
            "Pole": (mesh: Box(), light: (kind: Point, intensity: 3), without: [Camera, Vpl]), // as it is
        }),
    ],
)
"#;
    let folder = Folder::new(&[("lamp.prefab.ron", lamp), ("a.scene.ron", scene)]);
    let mut world = folder.load("a.scene.ron").unwrap();
    let path = folder.path("a.scene.ron");
    assert_eq!(scene_text(&world, &path).unwrap(), scene);
    light(&mut world, "Lamp/Pole").intensity = 4.0;
    assert_eq!(scene_text(&world, &path).unwrap(), with(scene, "intensity: 3", "intensity: 4"));
}

#[test]
fn old_names_of_components_stay() {
    let text = "Scene(entities: [(name: \"A\", components: {\"Ghost\": (), \"Unknown\": ( x: 01.50 )})])";
    let path = Path::new("a.scene.ron");
    let (_, file) = Document::parse::<SceneFile>(path, text.into()).unwrap();
    assert_eq!(rewritten(text, path, &file, &ComponentTypes::default()).as_deref(), Some(text));
    let mut moved = file.clone();
    moved.entities[0].visible = Some(false);
    let expected = text.replace("\"A\", ", "\"A\", visible: false, ");
    assert_eq!(rewritten(text, path, &moved, &ComponentTypes::default()), Some(expected));
}

#[test]
fn save_as_rewrites_relative_paths() {
    let scene = r#"Scene( // all
    settings: (environment: Image(file: "sky.hdr")),
    materials: { "m": (color_texture: "images/red.png") },
    entities: [
        (name: "P", prefab: "../prefabs/p.prefab.ron", overrides: { "A": (material: (color_texture: "images/red.png")) }),
        (name: "B", mesh: Box(), material: "m"), // a box
        (name: "M", model: "model.glb"),
    ],
)
"#;
    let folder = Folder::new(&[
        ("scenes/a.scene.ron", scene),
        (
            "prefabs/p.prefab.ron",
            "Prefab(entities: [(name: \"A\", mesh: Box(), material: (color_texture: \"blue.png\"))])",
        ),
        ("scenes/deep/er/x", ""),
    ]);
    for image in ["scenes/images/red.png", "prefabs/blue.png"] {
        std::fs::create_dir_all(folder.path(image).parent().unwrap()).unwrap();
        crate::measure::write_png_rgb8(&folder.path(image), [1, 1], &[255, 0, 0]).unwrap();
    }
    let sky = crate::measure::Image::filled(2, 1, [1.0; 3]);
    crate::measure::write_image(&folder.path("scenes/sky.exr"), &sky).unwrap();
    folder.write("scenes/model.glb", &super::models::plain());
    let scene = scene.replace("sky.hdr", "sky.exr");
    folder.write("scenes/a.scene.ron", scene.as_bytes());
    let mut world = folder.load("scenes/a.scene.ron").unwrap();
    let (from, to) = (folder.path("scenes/a.scene.ron"), folder.path("scenes/deep/er/b.scene.ron"));
    let (library, options) = (AssetLibrary::new(), LoadOptions::default());
    save_scene_as(&mut world, &library, &options, &from, &to).unwrap();
    let up = |name: &str| format!("\"../../{name}\"");
    let mut expected = scene.replace("\"../prefabs", "\"../../../prefabs");
    for name in ["sky.exr", "images/red.png", "model.glb"] {
        expected = expected.replace(&format!("\"{name}\""), &up(name));
    }
    assert_eq!(folder.read("scenes/deep/er/b.scene.ron"), expected);
    let prefab = folder.path("prefabs/new.prefab.ron");
    save_prefab(&world, at(&world, "B").unwrap(), &to, &prefab).unwrap();
    assert!(folder.read("prefabs/new.prefab.ron").contains("\"../scenes/images/red.png\""));
    folder.load("scenes/deep/er/b.scene.ron").unwrap();
    // The world is the new file's from then on.
    assert_eq!(scene_text(&world, &to).unwrap(), expected);
    // Out of the project nothing is found: which, and why.
    let elsewhere = tempfile::tempdir().unwrap();
    let out = elsewhere.path().join("c.scene.ron");
    let error = save_scene_as(&mut world, &library, &options, &to, &out).unwrap_err().to_string();
    assert!(
        error.contains("cannot be saved there") && error.contains("/scenes/sky.exr") && error.contains("--trust"),
        "{error}"
    );
    assert!(!out.exists() && std::fs::read_dir(elsewhere.path()).unwrap().count() == 0);
    assert_eq!(scene_text(&world, &to).unwrap(), expected, "the world is as it was");
}

#[test]
fn files_of_later_versions_are_refused_before_they_are_touched() {
    let later = "Scene(version: 7, entities: [(name: \"A\", hologram: 5)])";
    let folder = Folder::new(&[
        ("a.scene.ron", later),
        ("p.prefab.ron", "Prefab(\n    version: 2, entities: [(name: \"A\")])"),
        ("b.scene.ron", "(entities: [(name: \"P\", prefab: \"p.prefab.ron\")])"),
        ("c.scene.ron", "(version: 1, entities: [(name: \"P\", components: {\"version\": (version: 9)})]) // old"),
    ]);
    let error = folder.load("a.scene.ron").err().unwrap();
    assert_eq!(error.kind, FileErrorKind::NewerVersion, "{error}");
    assert!(error.file.ends_with("a.scene.ron") && error.message.contains("version 7"), "{error}");
    let error = folder.load("b.scene.ron").err().unwrap();
    assert!(error.file.ends_with("p.prefab.ron") && error.place.unwrap().line == 2, "{error}");
    let world = folder.load("c.scene.ron").unwrap();
    assert_eq!(scene_text(&world, &folder.path("c.scene.ron")).unwrap(), folder.read("c.scene.ron"));
    // What became of it since is not overwritten.
    folder.write("c.scene.ron", later.as_bytes());
    let error = save_scene(&world, &folder.path("c.scene.ron")).unwrap_err();
    assert_eq!((error.kind, folder.read("c.scene.ron")), (FileErrorKind::NewerVersion, later.to_owned()));
}
