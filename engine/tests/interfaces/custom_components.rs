//! Components of a game in scene and prefab files: read, saved, edited, and refused with a place.

#![allow(clippy::unwrap_used)]

use bevy_ecs::prelude::*;
use lightwell::assets::AssetLibrary;
use lightwell::files::{
    ComponentType, ComponentTypes, CustomValue, EditContext, FileErrorKind, LoadOptions, SceneData, TypeNote,
    describe_entity, edit_entity, load_scene, save_scene,
};
use lightwell::world::GameWorld;
use std::path::{Path, PathBuf};

/// How a guard moves.
#[derive(SceneData, Clone, Debug, Default, PartialEq)]
enum Gait {
    /// Not at all.
    #[default]
    Still,
    /// Up and down.
    Walk {
        /// Speed [m/s], 0 to 5.
        speed: f32,
    },
    /// After somebody.
    Chase(String),
}

/// Looks for thieves.
#[derive(Component, SceneData, Clone, Debug, PartialEq)]
struct Guard {
    /// Angle of its view [degrees].
    view: f32,
    /// What it does.
    gait: Gait,
    /// Places that it visits.
    posts: Vec<glam::Vec3>,
}

impl Default for Guard {
    fn default() -> Self {
        Self { view: 60.0, gait: Gait::Still, posts: Vec::new() }
    }
}

/// Can be taken.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Loot;

/// Weight [kg].
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Weight(f32);

fn options() -> LoadOptions {
    let mut types = ComponentTypes::default();
    types.is_complete = true;
    types.add(ComponentType::of::<Guard>()).unwrap();
    types.add(ComponentType::of::<Loot>()).unwrap();
    types.add(ComponentType::of::<Weight>()).unwrap();
    LoadOptions { types, ..Default::default() }
}

struct Files(tempfile::TempDir);

impl Files {
    fn new(scene: &str) -> (Self, PathBuf) {
        let files = Self(tempfile::tempdir().unwrap());
        let path = files.write("a.scene.ron", scene);
        (files, path)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn load(path: &Path, options: &LoadOptions) -> Result<GameWorld, lightwell::files::FileError> {
    load_scene(path, &mut AssetLibrary::new(), options)
}

const SCENE: &str = r#"Scene(entities: [
    (name: "Bob", components: {
        "Guard": (gait: Walk(speed: 1.5), posts: [(1, 0, 0), (0, 0, 2)]),
        "Weight": 80,
        "Loot": (),
    }),
    (name: "Al", components: {"Guard": (view: 90, gait: Chase("Bob"))}),
])"#;

#[test]
fn what_a_scene_says_is_in_the_world_and_comes_back() {
    let (_files, path) = Files::new(SCENE);
    let options = options();
    let world = load(&path, &options).unwrap();
    let bob = world.find("Bob").unwrap();
    let guard = world.ecs.get::<Guard>(bob).unwrap();
    assert_eq!((guard.view, &guard.gait, guard.posts.len()), (60.0, &Gait::Walk { speed: 1.5 }, 2));
    assert_eq!(world.ecs.get::<Weight>(bob), Some(&Weight(80.0)));
    assert!(world.ecs.get::<Loot>(bob).is_some());
    save_scene(&world, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("60"), "what is the default is not written:\n{text}");
    let again = load(&path, &options).unwrap();
    for name in ["Bob", "Al"] {
        let [a, b] = [&world, &again].map(|w| w.ecs.get::<Guard>(w.find(name).unwrap()).unwrap());
        assert_eq!(a, b);
    }
    save_scene(&again, &path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text, "load and save is the identity");
}

#[test]
fn values_that_changed_are_saved() {
    let (_files, path) = Files::new(SCENE);
    let options = options();
    let mut world = load(&path, &options).unwrap();
    let al = world.find("Al").unwrap();
    world.ecs.get_mut::<Guard>(al).unwrap().view = 12.5;
    world.ecs.entity_mut(al).insert(Loot);
    let bob = world.find("Bob").unwrap();
    world.ecs.entity_mut(bob).remove::<Weight>();
    save_scene(&world, &path).unwrap();
    let again = load(&path, &options).unwrap();
    let (al, bob) = (again.find("Al").unwrap(), again.find("Bob").unwrap());
    assert_eq!(again.ecs.get::<Guard>(al).unwrap().view, 12.5);
    assert!(again.ecs.get::<Loot>(al).is_some() && again.ecs.get::<Weight>(bob).is_none());
}

#[test]
fn instances_override_components_and_keep_the_rest() {
    let (files, path) = Files::new(
        r#"Scene(entities: [
            (name: "Post", prefab: "post.prefab.ron", overrides: {
                "Man": (components: {"Guard": (view: 10)}, without: [Own("Loot")]),
            }),
            (name: "Other", prefab: "post.prefab.ron"),
        ])"#,
    );
    let prefab = r#"Prefab(entities: [(name: "Man", components: {"Guard": (view:  45.0), "Loot": (), "Weight": 7})])"#;
    files.write("post.prefab.ron", prefab);
    let options = options();
    let mut world = load(&path, &options).unwrap();
    let man = world.find("Post/Man").unwrap();
    assert_eq!(world.ecs.get::<Guard>(man).unwrap().view, 10.0);
    assert!(world.ecs.get::<Loot>(man).is_none() && world.ecs.get::<Weight>(man).is_some());
    let other = world.find("Other/Man").unwrap();
    world.ecs.get_mut::<Weight>(other).unwrap().0 = 9.0;
    save_scene(&world, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("Guard").count(), 1, "only what differs from the prefab is written:\n{text}");
    let again = load(&path, &options).unwrap();
    assert_eq!(again.ecs.get::<Weight>(again.find("Other/Man").unwrap()), Some(&Weight(9.0)));
    assert!(again.ecs.get::<Loot>(again.find("Post/Man").unwrap()).is_none());
}

#[test]
fn mistakes_are_named_with_their_place() {
    let (files, _) = Files::new(SCENE);
    let cases = [
        (
            r#""Gaurd": ()"#,
            FileErrorKind::UnknownName,
            ["no component `Gaurd`", "did you mean `Guard`?", ".component::<Gaurd>()"],
        ),
        (
            r#""Guard": (veiw: 3)"#,
            FileErrorKind::UnknownField,
            ["unknown field `veiw`", "did you mean `view`?", "2:42"],
        ),
        (r#""Guard": (gait: Wlak)"#, FileErrorKind::UnknownVariant, ["unknown variant `Wlak`", "`Walk`", "2:48"]),
        (r#""Guard": (view: "far")"#, FileErrorKind::WrongType, ["number", "a.scene.ron:2", "view"]),
    ];
    for (text, kind, parts) in cases {
        let path =
            files.write("a.scene.ron", &format!("Scene(entities: [\n    (name: \"Bob\", components: {{{text}}}),\n])"));
        let error = load(&path, &options()).err().unwrap();
        let shown = error.to_string();
        assert_eq!(error.kind, kind, "{shown}");
        parts.iter().for_each(|part| assert!(shown.contains(part), "no {part} in:\n{shown}"));
    }
}

#[test]
fn a_program_that_does_not_know_the_game_keeps_its_components() {
    let (_files, path) = Files::new(SCENE);
    let stranger = load(&path, &LoadOptions::default()).unwrap();
    save_scene(&stranger, &path).unwrap();
    let world = load(&path, &options()).unwrap();
    assert_eq!(world.ecs.get::<Weight>(world.find("Bob").unwrap()), Some(&Weight(80.0)));
    assert_eq!(world.ecs.get::<Guard>(world.find("Al").unwrap()).unwrap().gait, Gait::Chase("Bob".into()));
}

#[test]
fn an_edit_changes_adds_and_removes_them() {
    let (_files, path) = Files::new(SCENE);
    let options = options();
    let mut library = AssetLibrary::new();
    let mut world = load_scene(&path, &mut library, &options).unwrap();
    let bob = world.find("Bob").unwrap();
    let before = describe_entity(&world, bob, &path).unwrap();
    let mut now = before.clone();
    now.components.insert("Weight".into(), CustomValue::new(" 5 "));
    now.components.remove("Loot");
    let mut context = EditContext { library: &mut library, options: &options, path: &path };
    edit_entity(&mut world, &mut context, bob, &now).unwrap();
    assert_eq!(world.ecs.get::<Weight>(bob), Some(&Weight(5.0)));
    assert!(world.ecs.get::<Loot>(bob).is_none() && world.ecs.get::<Guard>(bob).is_some());
    let mut wrong = now.clone();
    wrong.components.insert("Weight".into(), CustomValue::new("\"heavy\""));
    let mut context = EditContext { library: &mut library, options: &options, path: &path };
    assert!(edit_entity(&mut world, &mut context, bob, &wrong).is_err());
    assert_eq!(world.ecs.get::<Weight>(bob), Some(&Weight(5.0)), "nothing changes then");
}

#[test]
fn comments_tell_of_nested_types_too() {
    let notes = ComponentType::of::<Guard>().notes;
    let help = |key: &str| notes.iter().find(|note| note.key == key).map(|note: &TypeNote| note.help);
    assert_eq!(help("Guard"), Some("Looks for thieves."));
    assert_eq!(help("Guard.view"), Some("Angle of its view [degrees]."));
    assert_eq!(help("Gait.Walk"), Some("Up and down."));
    assert_eq!(help("Gait.Walk.speed"), Some("Speed [m/s], 0 to 5."));
}

#[test]
fn two_types_of_one_name_are_refused() {
    mod other {
        use bevy_ecs::prelude::Component;
        use lightwell::files::SceneData;
        /// Another one.
        #[derive(Component, SceneData, Clone, Default)]
        pub struct Loot;
    }
    let mut types = ComponentTypes::default();
    types.add(ComponentType::of::<Loot>()).unwrap();
    types.add(ComponentType::of::<Loot>()).unwrap();
    let error = types.add(ComponentType::of::<other::Loot>()).unwrap_err().to_string();
    assert!(error.contains("two types are named `Loot`") && error.contains("other::Loot"), "{error}");
}
