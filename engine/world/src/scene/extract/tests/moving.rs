//! Which objects are static, and which are dynamic.

use super::*;

fn moving(s: &Stage) -> Vec<bool> {
    s.scene.primitives.iter().map(|primitive| primitive.moving).collect()
}

#[test]
fn what_changes_is_moving_from_then_on() {
    let mut s = Stage::new();
    let still = s.world.spawn("still", None);
    s.insert(still, renderer());
    s.frame();
    assert_eq!(moving(&s), [false, false]);
    let before = s.scene.revisions.statics;
    let nudge = |s: &mut Stage| s.world.ecs.get_mut::<Transform>(s.thing).unwrap().translation.x += 0.1;
    nudge(&mut s);
    let begun = s.frame().statics;
    assert!(begun > before && moving(&s) == [true, false]);
    // Further moves change nothing static, nor do lights, nor does rest.
    for step in 0..40 {
        if step < 5 {
            nudge(&mut s);
        }
        s.insert(s.lamp, Light { intensity: step as f32, ..Light::default() });
        assert_eq!((s.frame().statics, moving(&s)), (begun, vec![true, false]));
    }
    // It has rested for long: when another one begins to move, it is called static with what is left.
    s.world.ecs.get_mut::<Transform>(still).unwrap().translation.y = 1.0;
    assert!(s.frame().statics > begun);
    assert_eq!(moving(&s), [false, true]);
}

#[test]
fn what_goes_on_after_a_rest_has_to_rest_twice_as_long() {
    let mut s = Stage::new();
    let nudge = |s: &mut Stage| s.world.ecs.get_mut::<Transform>(s.thing).unwrap().translation.x += 0.1;
    let rest = |s: &mut Stage, frames: u32| {
        nudge(s);
        for _ in 0..frames {
            s.frame();
        }
        // Another object comes: what has rested is called static now.
        let other = s.world.spawn("other", None);
        s.insert(other, renderer());
        s.frame();
        moving(s)[0]
    };
    let found = [31, 31, 61, 61, 121, 61].map(|frames| rest(&mut s, frames));
    assert_eq!(found, [false, true, false, true, false, true]);
}

#[test]
fn what_is_animated_or_hangs_on_it_is_moving_from_the_start() {
    let mut s = Stage::new();
    let group = s.group;
    s.insert(
        group,
        Animation { tracks: vec![Track::Spin { axis: Vec3::Y, degrees_per_second: 10.0 }], ..Animation::default() },
    );
    s.remove::<MeshRenderer>(s.thing);
    s.frame();
    s.insert(s.thing, renderer());
    s.frame();
    assert_eq!(moving(&s), [true]);
    // And stays it, however long the animation rests.
    s.world.ecs.get_mut::<Animation>(group).unwrap().speed = 0.0;
    for _ in 0..100 {
        s.frame();
    }
    let other = s.world.spawn("other", None);
    s.insert(other, renderer());
    s.frame();
    assert_eq!(moving(&s), [true, false]);
}
