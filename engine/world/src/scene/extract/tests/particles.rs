//! Particles: one primitive a source, posed by time alone.

use super::*;
use crate::scene::Primitive;

/// A stage with sparks.
fn sparkling() -> (Stage, Entity) {
    let mut s = Stage::new();
    let fire = s.world.spawn("fire", None);
    s.insert(fire, Particles::default());
    s.frame();
    (s, fire)
}

impl Stage {
    fn particles(&self) -> Option<&Primitive> {
        self.scene.primitives.iter().find(|primitive| primitive.is_particles())
    }

    fn at(&mut self, seconds: f64) -> Vec<Vertex> {
        self.world.set_seconds(seconds);
        self.frame();
        self.particles().unwrap().mesh.vertices.clone()
    }
}

#[test]
fn the_same_time_shows_the_same_particles_at_any_frame_rate() {
    let (mut s, fire) = sparkling();
    let then = s.at(1.5);
    for frame in 0..7 {
        assert_ne!(s.at(2.0 + f64::from(frame) / 60.0), then);
    }
    assert_eq!(s.at(1.5), then);
    let (mut other, _) = sparkling();
    for frame in 0..4 {
        other.at(f64::from(frame) / 24.0);
    }
    assert_eq!(other.at(1.5), then);
    s.insert(fire, Particles { seed: 9, ..Particles::default() });
    assert_ne!(s.at(1.5), then);
}

#[test]
fn time_poses_them_and_nothing_else_is_new() {
    let (mut s, _) = sparkling();
    let before = s.scene.revisions;
    let [rest, material] = [s.particles().unwrap().mesh.topology(), s.particles().unwrap().material.id];
    assert!(s.particles().unwrap().moving && s.frame() == before, "a paused scene has nothing new");
    s.at(0.5);
    let now = s.scene.revisions;
    assert!(now.geometry > before.geometry);
    assert_eq!((now.statics, now.materials, now.lights), (before.statics, before.materials, before.lights));
    let primitive = s.particles().unwrap();
    assert_eq!([primitive.mesh.topology(), primitive.material.id], [rest, material]);
}

#[test]
fn they_come_and_go_beside_a_mesh_and_count_for_no_bounds() {
    let (mut s, fire) = sparkling();
    let bounds = s.scene.bounds();
    s.insert(fire, renderer());
    s.frame();
    assert_eq!(s.scene.primitives.len(), 3);
    assert!(s.scene.primitives.is_sorted_by_key(|primitive| primitive.id));
    s.world.ecs.entity_mut(fire).remove::<MeshRenderer>();
    let statics = s.frame().statics;
    assert_eq!(s.scene.bounds(), bounds);
    s.world.ecs.entity_mut(fire).remove::<Particles>();
    assert!(s.frame().statics > statics && s.particles().is_none());
}

#[test]
fn an_entity_takes_its_particles_with_it() {
    let (mut s, fire) = sparkling();
    let before = s.particles().unwrap().clone();
    s.insert(fire, Transform::from_translation(Vec3::new(3.0, 0.0, -2.0)));
    s.frame();
    let after = s.particles().unwrap();
    assert_eq!(after.mesh.vertices, before.mesh.vertices);
    assert_eq!(Vec3::from(after.world_from_object.translation), Vec3::new(3.0, 0.0, -2.0));
    // Turned, they fly elsewhere.
    s.insert(fire, Transform::from_rotation(Quat::from_rotation_x(1.0)));
    s.frame();
    assert_ne!(s.particles().unwrap().mesh.vertices, before.mesh.vertices);
}

#[test]
fn what_is_out_of_range_is_said_and_shown_in_range() {
    let (mut s, fire) = sparkling();
    let wild = Particles { rate: 1e9, life: f32::NAN, radius: -1.0, end_radius: 0.01, ..Particles::default() };
    s.insert(fire, wild);
    s.frame();
    assert!(s.scene.warnings.iter().any(|w| w.contains("`fire`: has particles") && w.contains("65,536")));
    let mesh = s.particles().unwrap().mesh.clone();
    assert!(mesh.bounds.size().is_finite() && mesh.balls.as_ref().unwrap().len() <= Particles::MOST);
    for dark in [
        Particles { radiance: f32::NAN, ..Particles::default() },
        Particles { rate: 0.0, ..Particles::default() },
        Particles { radius: 0.0, end_radius: 0.0, ..Particles::default() },
        Particles { color: Vec3::ZERO, end_color: Vec3::ZERO, ..Particles::default() },
    ] {
        s.insert(fire, dark);
        s.frame();
        assert!(s.particles().is_none(), "{dark:?}");
    }
    s.insert(fire, Particles::default());
    s.insert(fire, Transform::from_translation(Vec3::splat(f32::NAN)));
    s.frame();
    assert!(s.particles().is_none() && s.scene.warnings.iter().any(|w| w.contains("not finite")));
}
