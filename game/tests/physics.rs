//! The example with rapier: a stone is thrown at a tower. `--features physics-example`

#![allow(clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../examples/physics.rs"]
mod physics;

use lightwell_game::prelude::*;

fn place(game: &Game, name: &str) -> Vec3 {
    game.world.ecs.get::<Transform>(game.world.find(name).unwrap()).unwrap().translation
}

#[test]
fn the_tower_falls_and_nothing_falls_through_the_ground() {
    let after = |steps: u64| physics::app().simulate(&InputScript { steps, ..Default::default() }).unwrap();
    let soon = after(10);
    let top = Vec3::new(0.0, 2.75, 0.62);
    // Bricks settle by the little that was left between them.
    assert!(place(&soon, "Stone").x > -6.0 && place(&soon, "Brick 18").distance(top) < 0.2);
    let late = after(240);
    let bricks: Vec<Vec3> = (1..=18).map(|number| place(&late, &format!("Brick {number}"))).collect();
    assert!(bricks.iter().all(|brick| brick.is_finite() && brick.y > 0.1), "{bricks:?}");
    assert!(place(&late, "Brick 18").distance(top) > 0.5, "hit: {bricks:?}");
    assert_eq!(place(&late, "Ground"), Vec3::new(0.0, -0.5, 0.0));
    assert_eq!(place(&late, "Stone"), place(&after(240), "Stone"), "the same game again");
}

#[test]
fn what_is_despawned_leaves_the_physics() {
    let mut game = physics::app().start().unwrap();
    for name in ["Brick 1", "Brick 2", "Brick 3"] {
        let brick = game.world.find(name).unwrap();
        game.world.ecs.despawn(brick);
    }
    for _ in 0..40 {
        game.step(&[]).unwrap();
    }
    assert!(place(&game, "Brick 4").y < 0.5, "what stood on them falls: {}", place(&game, "Brick 4"));
}
