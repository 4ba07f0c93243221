//! Tracks of keys for fields by path, in files: read, played, saved, reloaded, and refused with a place.

use super::*;
use crate::files::save::scene::scene_text;
use crate::files::{
    ComponentType, ComponentTypes, EditContext, LoadOptions, SceneData, describe_scene, edit_scene, follow_scene,
    read_scene,
};
use crate::world::{Clpv, Environment, Fog, FogShape, Light, Particles, SceneSettings};
use bevy_ecs::prelude::Component;
use glam::Vec3;

/// Rings.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Bell {
    /// Loudness, 0 to 1.
    loudness: f32,
    /// Whether it is muffled.
    muffled: bool,
}

const SCENE: &str = r#"Scene(
    settings: (sky: (0.5, 0.5, 0.5), exposure: 1, environment: Gradient(zenith: (1, 1, 1), horizon: (0, 0, 0))),
    entities: [
        (name: "Volume", clpv: (gain: 0.5), components: {"Bell": (loudness: 0.125)}, animation: (tracks: [
            Keys(target: Field("scene.exposure"), keys: [(0, -2), (2, 2)]),
            Keys(target: Field("scene.environment.zenith"), keys: [(0, (0, 0, 0)), (2, (2, 4, 6))]),
            Keys(target: Field("clpv.gain"), keys: [(0, 0), (2, 1)]),
            Keys(target: Field("Bell.loudness"), keys: [(0, 0), (2, 1)]),
            Keys(target: Field("Bell.muffled"), keys: [(0, false), (1, true), (2, false)]),
            Keys(node: "Lamp", target: Field("light.casts_shadow"), keys: [(0, true), (1, false), (2, true)]),
        ]), children: [(name: "Lamp", light: (kind: Point, intensity: 3))]),
    ],
)"#;

fn options() -> LoadOptions {
    let mut types = ComponentTypes::default();
    types.is_complete = true;
    types.add(ComponentType::of::<Bell>()).unwrap();
    LoadOptions { types, ..Default::default() }
}

fn load(folder: &Folder) -> Result<GameWorld, FileError> {
    load_scene(&folder.path("s.scene.ron"), &mut AssetLibrary::new(), &options())
}

fn gain(world: &GameWorld) -> f32 {
    world.ecs.get::<Clpv>(at(world, "Volume").unwrap()).unwrap().gain
}

fn go(world: &mut GameWorld, seconds: f64) {
    world.set_seconds(seconds);
    world.update();
}

#[test]
fn settings_volumes_lights_and_components_of_a_game_are_keyed() {
    let folder = Folder::new(&[("s.scene.ron", SCENE)]);
    let mut world = load(&folder).unwrap();
    let unplayed = scene_text(&world, &folder.path("s.scene.ron")).unwrap();
    go(&mut world, 1.5);
    let settings = world.ecs.resource::<SceneSettings>().clone();
    let environment =
        Environment::Gradient { zenith: Vec3::new(1.5, 3.0, 4.5), horizon: Vec3::ZERO, ground: Vec3::ZERO };
    assert_eq!((settings.exposure, settings.environment, gain(&world)), (1.0, Some(environment), 0.75));
    let volume = at(&world, "Volume").unwrap();
    assert_eq!(world.ecs.get::<Bell>(volume), Some(&Bell { loudness: 0.75, muffled: true }));
    assert!(!world.ecs.get::<Light>(at(&world, "Volume/Lamp").unwrap()).unwrap().casts_shadow);
    // Nothing of that is saved.
    let played = scene_text(&world, &folder.path("s.scene.ron")).unwrap();
    assert_eq!(played, unplayed);
    assert!(
        played.contains("exposure: 1") && played.contains("loudness: 0.125") && played.contains("gain: 0.5"),
        "{played}"
    );
    assert!(played.contains("(1, true)") || played.contains("(1.0, true)"), "switches stay switches: {played}");
    // What was saved plays the same.
    folder.write("s.scene.ron", played.as_bytes());
    let mut again = load(&folder).unwrap();
    go(&mut again, 1.5);
    assert_eq!(
        (gain(&again), again.ecs.resource::<SceneSettings>()),
        (gain(&world), world.ecs.resource::<SceneSettings>())
    );
}

#[test]
fn fog_is_keyed_and_saved_at_rest() {
    let track = |target: &str, keys: &str| format!("Keys(target: Field(\"fog.{target}\"), keys: [{keys}])");
    let tracks = [
        track("extinction", "(0, 0), (2, 1)"),
        track("albedo", "(0, (0, 0, 0)), (2, (1, 0.5, 0))"),
        track("shape.size", "(0, (2, 2, 2)), (2, (4, 2, 2))"),
    ];
    let fog = "fog: (shape: Box(size: (1, 2, 3)), extinction: 0.25)";
    let scene = format!(r#"(entities: [(name: "Smoke", {fog}, animation: (tracks: [{}]))])"#, tracks.join(", "));
    let folder = Folder::new(&[("s.scene.ron", &scene)]);
    let mut world = load(&folder).unwrap();
    go(&mut world, 1.0);
    let smoke = at(&world, "Smoke").unwrap();
    let shape = FogShape::Box { size: Vec3::new(3.0, 2.0, 2.0) };
    let expected = Fog { shape, extinction: 0.5, albedo: Vec3::new(0.5, 0.25, 0.0), ..Fog::default() };
    assert_eq!(world.ecs.get::<Fog>(smoke), Some(&expected));
    let saved = scene_text(&world, &folder.path("s.scene.ron")).unwrap();
    assert!(saved.contains("extinction: 0.25") && saved.contains("size: (1"), "{saved}");
    for (right, wrong, said) in [
        ("fog.extinction", "fog.extinctoin", "did you mean `extinction`?"),
        ("(2, 1)])", "(2, -1)])", "`fog.extinction` cannot be -1"),
        ("(2, (4, 2, 2))", "(2, (4, 0, 2))", "`fog.shape.size` cannot be (4.0,0.0,2.0)"),
    ] {
        folder.write("s.scene.ron", scene.replacen(right, wrong, 1).as_bytes());
        let error = load(&folder).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(said), "{wrong}: {error}");
    }
}

#[test]
fn a_file_that_changes_while_it_plays_is_followed() {
    let folder = Folder::new(&[("s.scene.ron", SCENE)]);
    let (path, options) = (folder.path("s.scene.ron"), options());
    let mut world = load(&folder).unwrap();
    go(&mut world, 0.5);
    let before = read_scene(&path, &options).unwrap();
    // The value that is shown now, a key, and an own value that is keyed.
    let changed = SCENE.replace("gain: 0.5", "gain: 0.25").replace(
        "(2, 1)]),\n            Keys(target: Field(\"Bell.lo",
        "(2, 3)]),\n            Keys(target: Field(\"Bell.lo",
    );
    let changed = changed.replace("exposure: 1", "exposure: 5");
    folder.write("s.scene.ron", changed.as_bytes());
    let now = read_scene(&path, &options).unwrap();
    let mut library = AssetLibrary::new();
    let mut context = EditContext { library: &mut library, options: &options, path: &path };
    follow_scene(&mut world, &mut context, &before, &now).unwrap();
    world.update();
    assert_eq!((gain(&world), world.ecs.resource::<SceneSettings>().exposure), (0.75, -1.0));
    assert_eq!(world.rest_settings().exposure, 5.0);
    let rest: Clpv = world.rest_component(at(&world, "Volume").unwrap(), "clpv").unwrap();
    assert_eq!(rest.gain, 0.25);
    // An edit of another setting leaves the keyed ones what they are.
    let mut scene = describe_scene(&world);
    assert_eq!(scene.settings.exposure, 5.0);
    scene.settings.move_speed = 9.0;
    edit_scene(&mut world, &mut context, &scene).unwrap();
    world.update();
    assert_eq!((world.ecs.resource::<SceneSettings>().exposure, world.rest_settings().exposure), (-1.0, 5.0));
    assert_eq!(world.rest_settings().move_speed, 9.0);
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_what_there_is() {
    let wrong = |target: &str, keys: &str, words: &[&str]| {
        let scene = SCENE.replace(
            r#"Keys(target: Field("scene.exposure"), keys: [(0, -2), (2, 2)])"#,
            &format!("Keys(target: Field(\"scene.move_speed\"), keys: [(0, 1)]), Keys({target}, keys: [{keys}])"),
        );
        let folder = Folder::new(&[("s.scene.ron", &scene)]);
        let message = load(&folder).err().map(|error| error.to_string()).unwrap_or_default();
        let all = ["s.scene.ron:5:", "track 1"].iter().chain(words);
        all.for_each(|word| assert!(message.contains(word), "{target} {keys}, {word}: {message}"));
    };
    let field = |path: &str| format!("target: Field(\"{path}\")");
    wrong(&field("clpv.gian"), "(0, 1)", &["`clpv` of `Volume` has no field `gian`", "did you mean `gain`?"]);
    wrong(&field("clpv.colour"), "(0, 1)", &["known here: `transport`, `bounces`"]);
    wrong(&field("clvp.gain"), "(0, 1)", &["`Volume` has no `clvp`", "did you mean `clpv`?"]);
    wrong(&field("light.indirect"), "(0, true)", &["`Volume` has no `light`", "`Bell`", "`scene`"]);
    wrong(&field("light.intensity"), "(0, 1)", &["`Volume` has no `light`"]);
    wrong(&field("casts_shadow"), "(0, true)", &["`Volume` has no `casts_shadow`"]);
    wrong(&field("transform.place"), "(0, 1)", &["no field `place`", "`translation`"]);
    wrong(&field("transform"), "(0, 1)", &["name one of its fields"]);
    wrong(&field("scene.skye"), "(0, 1)", &["`scene` of `scene` has no field `skye`", "did you mean `sky`?"]);
    wrong(&field("scene.sky"), "(0, 1)", &["key 0: `scene.sky` wants (x, y, z)", "(0.5,0.5,0.5) without the track"]);
    wrong(&field("scene.sky"), "(0, (1, 1, 1)), (1, (1, -1, 1))", &["key 1: `scene.sky` cannot be (1.0,-1.0,1.0)"]);
    wrong(&field("scene.exposure"), "(0, (1, 1, 1))", &["wants one number"]);
    wrong(&field("scene.duration"), "(0, 1)", &["cannot be keyed", "another speed"]);
    wrong(&field("scene.environment"), "(0, 1)", &["wants nothing as a whole"]);
    wrong(&field("clpv.quality"), "(0, 1)", &["wants no keys, for it is `High`"]);
    wrong(&field("clpv.steps"), "(0, 1), (1, 5000)", &["key 1: `clpv.steps` cannot be 5000", "`steps` is 5000"]);
    wrong(&field("Bell.loudness"), "(0, (1, 2))", &["`Bell.loudness` wants one number"]);
    wrong(&field("Bell.loudness.x"), "(0, 1)", &["`Bell.loudness` has no fields, so no `x`"]);
    wrong(&field("light.color.x"), "(0, 1)", &["a part of `light.color`", "Field(\"light.color\")"]);
    wrong(&field("clpv. gain"), "(0, 1)", &["no path of a field"]);
    wrong(&field("clpv.gain"), "(0, 1), (1, true)", &["values of one kind"]);
    wrong(
        &format!("node: \"Lamp\", {}", field("scene.sky")),
        "(0, (1, 1, 1))",
        &["belongs to the scene", "leave `node` out"],
    );
    wrong(
        &format!("node: \"Lamp\", {}", field("light.rsm_sice")),
        "(0, 64)",
        &["`light` of `Lamp`", "did you mean `rsm_size`?"],
    );
    wrong(&format!("node: \"Lamp\", {}", field("light.rsm_size")), "(0, 2)", &["cannot be 2", "`rsm_size` is 2"]);
}

#[test]
fn particles_are_keyed_and_saved_at_rest() {
    let track = |target: &str, keys: &str| format!("Keys(target: Field(\"particles.{target}\"), keys: [{keys}])");
    let tracks = [
        track("radiance", "(0, 0), (2, 100)"),
        track("velocity", "(0, (0, 0, 0)), (2, (0, 4, 0))"),
        track("rate", "(0, 10), (2, 30)"),
    ];
    let fire = "particles: (rate: 40, radiance: 7)";
    let scene = format!(r#"(entities: [(name: "Fire", {fire}, animation: (tracks: [{}]))])"#, tracks.join(", "));
    let folder = Folder::new(&[("s.scene.ron", &scene)]);
    let mut world = load(&folder).unwrap();
    go(&mut world, 1.0);
    let velocity = Vec3::new(0.0, 2.0, 0.0);
    let expected = Particles { rate: 20.0, radiance: 50.0, velocity, ..Particles::default() };
    assert_eq!(world.ecs.get::<Particles>(at(&world, "Fire").unwrap()), Some(&expected));
    let saved = scene_text(&world, &folder.path("s.scene.ron")).unwrap();
    assert!(saved.contains("rate: 40") && saved.contains("radiance: 7"), "{saved}");
    for (right, wrong, said) in [
        ("particles.radiance", "particles.radience", "did you mean `radiance`?"),
        ("(2, 30)])", "(2, 1e9)])", "`particles.rate` cannot be 1000000000"),
        ("(0, 10), (2, 30)])", "(0, 10), (2, 1e6)])", "a second that live for 2 s each are 2000000 particles at once"),
    ] {
        folder.write("s.scene.ron", scene.replacen(right, wrong, 1).as_bytes());
        let error = load(&folder).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(said), "{wrong}: {error}");
    }
}
