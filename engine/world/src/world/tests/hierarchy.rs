use crate::core::SceneId;
use crate::world::*;
use bevy_ecs::prelude::{ChildOf, Children, Component, DetectChanges, Entity, Query, Ref, ResMut};
use glam::{Quat, Vec3};

fn spawn_at(world: &mut GameWorld, name: &str, parent: Option<Entity>, translation: Vec3) -> Entity {
    let entity = world.spawn(name, parent);
    world.ecs.entity_mut(entity).insert(Transform { translation, ..Transform::default() });
    entity
}

fn place(world: &GameWorld, entity: Entity) -> Vec3 {
    world.ecs.get::<GlobalTransform>(entity).unwrap().0.translation.into()
}

/// a at x = 1, below it b at +10, below that c at +100.
fn chain() -> (GameWorld, [Entity; 3]) {
    let mut world = GameWorld::new();
    let a = spawn_at(&mut world, "a", None, Vec3::X);
    let b = spawn_at(&mut world, "b", Some(a), 10.0 * Vec3::X);
    let c = spawn_at(&mut world, "c", Some(b), 100.0 * Vec3::X);
    world.update();
    (world, [a, b, c])
}

#[test]
fn places_propagate_down_the_hierarchy() {
    let (mut world, [a, b, c]) = chain();
    assert_eq!([a, b, c].map(|e| place(&world, e).x), [1.0, 11.0, 111.0]);
    world.ecs.get_mut::<Transform>(a).unwrap().rotation = Quat::from_rotation_y(std::f32::consts::PI);
    world.ecs.get_mut::<Transform>(b).unwrap().scale = Vec3::splat(2.0);
    world.update();
    assert!(place(&world, b).abs_diff_eq(Vec3::new(-9.0, 0.0, 0.0), 1e-4));
    assert!(place(&world, c).abs_diff_eq(Vec3::new(-209.0, 0.0, 0.0), 1e-4));
}

#[test]
fn only_what_moved_is_written() {
    let (mut world, [a, b, c]) = chain();
    let is_changed = |world: &GameWorld, e: Entity| {
        let changed = world.ecs.entity(e).get_ref::<GlobalTransform>().unwrap();
        changed.last_changed().is_newer_than(world.ecs.last_change_tick(), world.ecs.read_change_tick())
    };
    world.update();
    assert_eq!([a, b, c].map(|e| is_changed(&world, e)), [false; 3]);
    world.ecs.get_mut::<Transform>(b).unwrap().translation.x = 20.0;
    world.update();
    assert_eq!([a, b, c].map(|e| is_changed(&world, e)), [false, true, true]);
    let same = *world.ecs.get::<Transform>(b).unwrap();
    *world.ecs.get_mut::<Transform>(b).unwrap() = same;
    world.update();
    assert_eq!([a, b, c].map(|e| is_changed(&world, e)), [false; 3]);
}

#[test]
fn a_new_parent_and_none_take_effect() {
    let (mut world, [a, b, c]) = chain();
    let other = spawn_at(&mut world, "other", None, 1000.0 * Vec3::X);
    world.set_parent(b, Some(other)).unwrap();
    world.update();
    assert_eq!((place(&world, b).x, place(&world, c).x), (1010.0, 1110.0));
    world.set_parent(b, None).unwrap();
    world.update();
    assert_eq!((place(&world, b).x, place(&world, c).x), (10.0, 110.0));
    // By the ECS alone.
    world.ecs.entity_mut(c).insert(ChildOf(a));
    world.update();
    assert_eq!(place(&world, c).x, 101.0);
    world.ecs.entity_mut(c).remove::<ChildOf>();
    world.update();
    assert_eq!(place(&world, c).x, 100.0);
}

#[test]
fn a_group_without_transform_passes_its_parent_on() {
    let (mut world, [a, b, c]) = chain();
    world.ecs.entity_mut(b).remove::<Transform>();
    world.update();
    assert_eq!(place(&world, c).x, 101.0);
    let group = world.ecs.spawn(ChildOf(a)).id();
    world.ecs.entity_mut(c).insert(ChildOf(group));
    world.ecs.get_mut::<Transform>(a).unwrap().translation.x = 2.0;
    world.update();
    assert_eq!(place(&world, c).x, 102.0);
}

#[test]
fn cycles_are_refused() {
    let (mut world, [a, b, c]) = chain();
    let error = world.set_parent(a, Some(c)).unwrap_err();
    assert_eq!(error, WorldError::Cycle { child: "a".into(), parent: "a/b/c".into() });
    assert!(world.set_parent(a, Some(a)).is_err());
    world.ecs.entity_mut(a).insert(ChildOf(c));
    world.update();
    assert_eq!((world.parent(a), world.parent(b), world.parent(c)), (None, Some(a), Some(b)));
    assert_eq!(place(&world, c).x, 111.0);
}

#[test]
fn look_up_goes_by_paths_of_names() {
    let (mut world, [a, b, c]) = chain();
    assert_eq!((world.find("a/b/c"), world.find("a/c"), world.find("b"), world.find("")), (Some(c), None, None, None));
    assert_eq!((world.path(c).as_str(), world.roots(), world.children(a)), ("a/b/c", vec![a], vec![b]));
    assert_eq!((world.unique_name(Some(a), "b"), world.unique_name(None, "b")), ("b 2".into(), "b".into()));
    // A new parent whose child has the name already.
    let other = world.spawn("b", None);
    world.set_parent(other, Some(a)).unwrap();
    assert_eq!(world.path(other), "a/b 2");
}

#[derive(Component, Clone, Debug, PartialEq)]
struct Own(Vec<u32>);

#[test]
fn a_clone_is_deep_and_has_its_own_names_and_identities() {
    let (mut world, [a, b, c]) = chain();
    world.ecs.entity_mut(c).insert(Own(vec![1, 2]));
    let clone = world.clone_subtree(b).unwrap();
    assert_eq!((world.name(clone), world.parent(clone)), ("b 2", Some(a)));
    let below = world.children(clone);
    let [leaf] = below[..] else { panic!("{below:?}") };
    assert_ne!(leaf, c);
    assert_eq!(world.ecs.get::<Own>(leaf), Some(&Own(vec![1, 2])));
    assert_eq!(world.children(b), [c]);
    let ids = [a, b, c, clone, leaf].map(|e| world.id(e).unwrap());
    assert_eq!(ids, [1, 2, 3, 4, 5].map(SceneId));
    assert_eq!(world.entity(ids[4]), Some(leaf));
    world.ecs.get_mut::<Own>(leaf).unwrap().0.push(3);
    world.ecs.get_mut::<Transform>(clone).unwrap().translation.x = 50.0;
    world.update();
    assert_eq!(world.ecs.get::<Own>(c), Some(&Own(vec![1, 2])));
    assert_eq!((place(&world, leaf).x, place(&world, c).x), (151.0, 111.0));
    let root = world.clone_subtree(a).unwrap();
    assert_eq!((world.name(root), world.children(root).len()), ("a 2", 2));
    world.ecs.despawn(root);
    assert!(matches!(world.clone_subtree(root), Err(WorldError::Missing(_))));
}

#[test]
fn despawn_waits_for_the_end_of_the_frame() {
    let (mut world, [a, b, c]) = chain();
    world.despawn_later(c);
    world.despawn_later(b);
    world.despawn_later(b);
    assert_eq!(world.find("a/b/c"), Some(c));
    world.update();
    assert_eq!((world.find("a/b"), world.find("a")), (None, Some(a)));
    assert!(world.ecs.get_entity(c).is_err());
    // From a system of the game.
    world.add_systems(|names: Query<(Entity, Ref<Name>)>, mut queue: ResMut<DespawnQueue>| {
        names.iter().for_each(|(entity, _)| queue.push(entity));
    });
    world.update();
    assert!(world.roots().is_empty());
}

#[test]
fn identities_are_never_used_twice() {
    let (mut world, [a, _, c]) = chain();
    let id = world.id(c).unwrap();
    assert!(matches!(world.spawn_with_id("x", None, id), Err(WorldError::IdentityTaken { .. })));
    world.ecs.despawn(c);
    assert_eq!(world.entity(id), None);
    let fresh = world.spawn("fresh", Some(a));
    assert_eq!(world.id(fresh), Some(SceneId(4)));
    let again = world.spawn_with_id("c", Some(a), id).unwrap();
    assert_eq!((world.id(again), world.entity(id)), (Some(id), Some(again)));
    world.spawn_with_id("far", None, SceneId(100)).unwrap();
    let next = world.spawn("next", None);
    assert_eq!(world.id(next), Some(SceneId(101)));
    // By the ECS alone: in the next update.
    let bare = world.ecs.spawn(Transform::default()).id();
    assert_eq!(world.id(bare), None);
    world.update();
    assert_eq!(world.id(bare), Some(SceneId(102)));
    assert!(world.ecs.get::<Children>(bare).is_none());
}

#[test]
fn a_rotation_that_is_none_counts_as_identity() {
    let with = |rotation| Transform { rotation, ..Transform::default() }.unit_rotation();
    for q in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0, 1.0]] {
        assert_eq!(with(Quat::from_array(q)), Quat::IDENTITY, "{q:?}");
    }
    for s in [1e-30, 1e30] {
        assert!(
            with(Quat::from_xyzw(0.0, s, 0.0, s)).abs_diff_eq(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2), 1e-6)
        );
    }
}

#[test]
fn orientation_outlives_zero_scale_and_follows_a_mirror() {
    let mut world = GameWorld::new();
    let turn = Quat::from_rotation_y(0.5);
    let parent = world.spawn("parent", None);
    let child = world.spawn("child", Some(parent));
    let forward =
        |world: &GameWorld| -> Vec3 { super::super::forward(world.ecs.get::<Orientation>(child).unwrap()).into() };
    let expected = turn * Vec3::NEG_Z;
    for (outer, own) in
        [(Vec3::ONE, Vec3::ZERO), (Vec3::ONE, -Vec3::ONE), (Vec3::ZERO, Vec3::ONE), (Vec3::ONE, Vec3::ONE)]
    {
        world.ecs.entity_mut(parent).insert(Transform { scale: outer, ..Transform::default() });
        world.ecs.entity_mut(child).insert(Transform { rotation: turn, scale: own, ..Transform::default() });
        world.update();
        assert!(forward(&world).abs_diff_eq(expected, 1e-6), "{outer} {own}: {}", forward(&world));
    }
    world.ecs.entity_mut(parent).insert(Transform { scale: Vec3::new(-1.0, 1.0, 1.0), ..Transform::default() });
    world.update();
    assert!(forward(&world).abs_diff_eq(expected * Vec3::new(-1.0, 1.0, 1.0), 1e-6));
    assert!((world.ecs.get::<Orientation>(child).unwrap().0.determinant() - 1.0).abs() < 1e-6);
}
