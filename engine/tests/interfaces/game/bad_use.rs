//! Bad use: told with what to do, and no panic.

use super::*;

fn fails<M>(system: impl IntoScheduleConfigs<bevy_ecs::system::ScheduleSystem, M>) -> String {
    let folder = Folder::new();
    let mut game = folder.game();
    game.add_systems(FixedUpdate, system);
    let error = message(game.step(&[]));
    assert!(x_of(&game, "A") > 0.0, "the step is done nevertheless");
    error
}

#[test]
fn bad_use_is_told_and_does_not_panic() {
    #[derive(Resource)]
    struct Forgotten;
    #[derive(Message)]
    struct Unheard;
    let missing = fails(|_: Res<Forgotten>| {});
    assert!(missing.contains("Forgotten") && missing.contains(".resource("), "{missing}");
    let unheard = fails(|mut writer: MessageWriter<Unheard>| {
        writer.write(Unheard);
    });
    assert!(unheard.contains("Unheard") && unheard.contains(".message::<"), "{unheard}");
    let unread = fails(|_: MessageReader<Unheard>| {});
    assert!(unread.contains("Unheard") && unread.contains(".message::<"), "{unread}");
    let gone = fails(|runners: Query<Entity, With<Runner>>, mut commands: Commands| {
        for entity in &runners {
            let copy = commands.clone_subtree(entity).id();
            commands.entity(copy).despawn();
            commands.entity(copy).insert(Light::default());
        }
    });
    assert!(gone.contains("the entity is gone"), "{gone}");
    let target = fails(late_insert);
    assert!(
        target.contains("command `insert<Light>` failed") && target.contains("the entity is gone: look it up"),
        "{target}"
    );
    let source = fails(|mut commands: Commands| {
        let entity = commands.spawn_empty().id();
        commands.entity(entity).despawn();
        commands.clone_subtree(entity);
    });
    assert!(source.contains("there is no entity"), "{source}");
    let own = fails(|| -> Result { Err("the bridge is up".into()) });
    assert!(own.contains("the bridge is up"), "{own}");
    let action = fails(|input: Res<Input>| {
        input.pressed("jump");
    });
    assert!(action.contains("no button `jump`") && action.contains(".actions("), "{action}");
    let prefab = fails(|mut commands: Commands| {
        commands.spawn_prefab("bal.prefab.ron", Transform::default());
    });
    assert!(prefab.contains("there is no prefab `bal.prefab.ron`") && prefab.contains("ball.prefab.ron"), "{prefab}");
    let scene = fails(|mut commands: Commands| commands.change_scene("nowhere.scene.ron"));
    assert!(scene.contains("nowhere.scene.ron"), "{scene}");
}

/// The entity is despawned before the command comes to its turn.
fn late_insert(mut commands: Commands) {
    let entity = commands.spawn_empty().id();
    commands.entity(entity).despawn();
    commands.entity(entity).insert(Light::default());
}

#[test]
fn an_observer_that_fails_is_told_with_its_name() {
    #[derive(Event)]
    struct Rang;
    fn answer(_: On<Rang>) -> Result {
        Err("nobody is at home".into())
    }
    let folder = Folder::new();
    let mut game = folder.game();
    game.add_observer(answer);
    game.add_systems(FixedUpdate, |mut commands: Commands| commands.trigger(Rang));
    let error = message(game.step(&[]));
    assert!(error.contains("answer") && error.contains("nobody is at home"), "{error}");
}

#[test]
fn the_same_fault_of_many_entities_is_told_once_and_many_are_cut_short() {
    let same = fails(|| -> Result { Err("again".into()) });
    assert_eq!(same.matches("again").count(), 1);
    let folder = Folder::new();
    let mut game = folder.game();
    game.add_systems(FixedUpdate, |mut commands: Commands| {
        for number in 0..100 {
            commands.queue(move |_: &mut World| -> Result { Err(format!("fault number {number}").into()) });
        }
    });
    let error = message(game.step(&[]));
    assert_eq!(error.matches("fault number").count(), 16, "{error}");
}

#[test]
fn unregistered_components_and_names_given_twice_are_refused() {
    let folder = Folder::new();
    let mut game = Game::new();
    let error = message(game.enter(&folder.path("a.scene.ron")));
    assert!(error.contains("no component `Runner`") && error.contains(".component::<Runner>()"), "{error}");
    #[derive(Resource, SceneData, Clone, Default)]
    struct Score;
    let mut game = folder.game();
    let error = message(game.add_saved_resource(Score));
    assert!(error.contains("two types are named `Score`"), "{error}");
    mod other {
        /// Another type of the same name.
        #[derive(bevy_ecs::prelude::Component, lightwell::files::SceneData, Clone, Default)]
        pub struct Runner;
    }
    let error = message(game.add_component::<other::Runner>());
    assert!(error.contains("two types are named `Runner`") && error.contains("rename one"), "{error}");
    folder.write("near.scene.ron", r#"Scene(entities: [(name: "A", components: {"Runer": (speed: 6)})])"#);
    let error = message(game.enter(&folder.path("near.scene.ron")));
    assert!(error.contains("did you mean `Runner`") && error.contains("near.scene.ron:1:"), "{error}");
    folder.write("twice.scene.ron", r#"Scene(entities: [(name: "A"), (name: "A")])"#);
    let error = message(game.enter(&folder.path("twice.scene.ron")));
    assert!(error.contains("`A`") && error.contains("twice.scene.ron:1:"), "{error}");
}
