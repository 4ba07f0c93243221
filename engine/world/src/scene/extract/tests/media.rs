//! Fog: where it lies, what it comes out as, and what is new after which change.

use super::*;
use crate::scene::{MAX_MEDIA, MediumShape, SceneMedium};
use glam::DVec3;

/// A stage with a fog that has edges.
fn foggy(fog: Fog) -> (Stage, Entity) {
    let mut s = Stage::new();
    let mist = s.world.spawn("mist", None);
    s.insert(mist, fog);
    s.frame();
    (s, mist)
}

fn ball() -> Fog {
    Fog { shape: FogShape::Sphere { radius: 2.0 }, extinction: 0.5, ..Fog::default() }
}

impl Stage {
    fn fog(&mut self, entity: Entity, fog: Fog) -> &SceneMedium {
        self.insert(entity, fog);
        self.frame();
        &self.scene.media[0]
    }

    /// Whether an edit changes the revision of media.
    fn changes_media(&mut self, edit: impl FnOnce(&mut Self)) -> bool {
        let before = self.scene.revisions.media;
        edit(self);
        self.frame().media != before
    }

    fn warns(&self, part: &str) -> bool {
        self.scene.warnings.iter().any(|warning| warning.contains(part))
    }
}

#[test]
fn fog_comes_out_in_range() {
    let (mut s, mist) = foggy(ball());
    assert!(s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    let expected = (0.5, Vec3::splat(0.95), 0.0, 0.0);
    let found = |m: &SceneMedium| (m.extinction, m.albedo, m.anisotropy, m.falloff);
    assert_eq!((found(&s.scene.media[0]), s.scene.media[0].name.as_str()), (expected, "mist"));
    let wild = Fog {
        extinction: 1e9,
        albedo: Vec3::new(-1.0, 2.0, f32::NAN),
        anisotropy: -3.0,
        falloff: f32::INFINITY,
        ..ball()
    };
    assert_eq!(found(s.fog(mist, wild)), (1e6, Vec3::new(0.0, 1.0, 0.0), -0.95, 1e6));
    assert!(s.warns("`mist`: has fog settings out of range"), "{:?}", s.scene.warnings);
    s.fog(mist, ball());
    assert!(s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    for extinction in [0.0, -1.0, f32::NAN] {
        s.insert(mist, Fog { extinction, ..ball() });
        s.frame();
        assert!(s.scene.media.is_empty(), "{extinction}");
        assert_eq!(s.warns("out of range"), extinction != 0.0, "{extinction}");
    }
}

#[test]
fn sizes_come_out_in_range() {
    let (mut s, mist) = foggy(ball());
    let axes = |m: &SceneMedium| {
        let m = m.local_from_world.matrix3;
        Vec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z).recip()
    };
    for (radius, expected) in [(-1.0, 1e-6), (f32::NAN, 1e-6), (1e9, 1e6), (3.0, 3.0)] {
        let found = axes(s.fog(mist, Fog { shape: FogShape::Sphere { radius }, ..ball() }));
        assert!((found / expected).abs_diff_eq(Vec3::ONE, 1e-5), "{radius}: {found}");
        assert_eq!(s.warns("out of range"), radius != 3.0);
    }
    let size = Vec3::new(0.0, 4.0, f32::INFINITY);
    let found = axes(s.fog(mist, Fog { shape: FogShape::Box { size }, ..ball() }));
    assert!((found / Vec3::new(5e-7, 2.0, 5e5)).abs_diff_eq(Vec3::ONE, 1e-5), "{found}");
}

#[test]
fn a_box_is_turned_moved_and_scaled_with_its_entity() {
    let (mut s, mist) = foggy(Fog { shape: FogShape::Box { size: Vec3::new(4.0, 2.0, 6.0) }, ..ball() });
    let rotation = Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.0, 2.0);
    let place = Transform { translation: Vec3::new(1.0, -2.0, 3.0), rotation, scale: Vec3::new(2.0, 0.5, -3.0) };
    s.insert(mist, place);
    s.frame();
    let medium = &s.scene.media[0];
    assert_eq!((medium.shape, medium.base), (MediumShape::Box, place.translation));
    assert!(medium.up.abs_diff_eq(rotation * Vec3::Y, 1e-6), "of length 1 whatever the scale: {}", medium.up);
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let local = Vec3::new(sign(0), sign(1), sign(2));
        let world = place.matrix().transform_point3(local * Vec3::new(2.0, 1.0, 3.0));
        let found = medium.local_from_world.transform_point3(world);
        assert!(found.abs_diff_eq(local, 1e-5), "{local} lies at {found}");
    }
}

#[test]
fn a_ball_becomes_an_ellipsoid_below_what_is_scaled() {
    let (mut s, mist) = foggy(ball());
    s.world.set_parent(mist, Some(s.group)).unwrap();
    let place = Transform { translation: Vec3::Y, scale: Vec3::new(1.0, 3.0, 0.5), ..Transform::default() };
    s.insert(s.group, place);
    s.frame();
    let medium = &s.scene.media[0];
    assert_eq!(medium.shape, MediumShape::Sphere);
    for (edge, local) in [(Vec3::X * 2.0, Vec3::X), (Vec3::Y * 6.0, Vec3::Y), (Vec3::Z, Vec3::Z)] {
        let found = medium.local_from_world.transform_point3(Vec3::Y + edge);
        assert!(found.abs_diff_eq(local, 1e-5), "{found}");
    }
}

#[test]
fn sizes_at_the_ends_of_the_range_fit_any_scale() {
    let (mut s, mist) = foggy(ball());
    for (radius, scale) in [(1e6, 1e12), (1e-6, 1e-12), (1e6, 1e-3), (1e-6, 1e3)] {
        s.insert(mist, Transform::default().with_scale(Vec3::splat(scale)));
        let medium = s.fog(mist, Fog { shape: FogShape::Sphere { radius }, ..ball() });
        let found = medium.local_from_world.transform_point3(Vec3::X * radius * scale);
        assert!(found.abs_diff_eq(Vec3::X, 1e-5), "{radius} {scale}: {found}");
    }
}

#[test]
fn fog_everywhere_has_a_height_and_no_edges() {
    let (mut s, mist) = foggy(Fog { falloff: 0.1, ..Fog::default() });
    for scale in [Vec3::ONE, Vec3::ZERO] {
        s.insert(mist, Transform { translation: Vec3::splat(5.0), scale, ..Transform::default() });
        s.frame();
        let medium = &s.scene.media[0];
        assert_eq!((medium.shape, medium.local_from_world), (MediumShape::Everywhere, glam::Affine3A::IDENTITY));
        assert_eq!((medium.base, medium.up, medium.falloff), (Vec3::splat(5.0), Vec3::Y, 0.1));
    }
    assert!(s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
}

#[test]
fn fog_without_a_volume_or_a_place_is_told_and_left_out() {
    let (mut s, mist) = foggy(ball());
    let wrong = [
        (Transform::default().with_scale(Vec3::ZERO), "scaled to nothing"),
        (Transform::default().with_scale(Vec3::new(1.0, 0.0, 1.0)), "scaled to nothing"),
        (Transform::from_translation(Vec3::NAN), "not finite"),
    ];
    for (place, said) in wrong {
        assert!(s.changes_media(|s| s.insert(mist, place)), "{said}");
        assert!(s.scene.media.is_empty() && s.warns(said), "{said}: {:?}", s.scene.warnings);
        assert!(s.changes_media(|s| s.insert(mist, Transform::default())));
        assert!(s.scene.media.len() == 1 && s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    }
}

#[test]
fn the_revision_of_media_follows_what_changes_them() {
    let (mut s, mist) = foggy(ball());
    let before = list(s.scene.revisions);
    assert!(!s.changes_media(|_| {}));
    // Written, but the same.
    assert!(!s.changes_media(|s| s.insert(mist, (ball(), Transform::default()))));
    assert!(!s.changes_media(|s| s.insert(s.thing, Transform::from_translation(Vec3::X))), "no fog");
    assert!(!s.changes_media(|s| s.insert(mist, Name("steam".into()))));
    assert_eq!(s.scene.media[0].name, "steam");
    assert!(s.changes_media(|s| s.world.ecs.get_mut::<Fog>(mist).unwrap().extinction = 0.25));
    assert!(s.changes_media(|s| s.insert(mist, Transform::from_translation(Vec3::X))));
    assert!(s.changes_media(|s| s.insert(mist, Transform::from_rotation(Quat::from_rotation_x(1.0)))));
    assert!(s.changes_media(|s| s.remove::<Fog>(mist)));
    assert!(s.scene.media.is_empty());
    assert!(s.changes_media(|s| s.insert(mist, ball())));
    assert!(s.changes_media(|s| assert!(s.world.ecs.despawn(mist))));
    assert!(s.scene.media.is_empty());
    let after = list(s.scene.revisions);
    assert_eq!((&before[1..], &after[1..]), (&after[1..], &before[1..]), "fog is no light and no surface");
}

#[test]
fn fog_that_went_while_nothing_was_extracted_is_gone() {
    let (mut s, mist) = foggy(ball());
    s.remove::<Fog>(mist);
    for _ in 0..4 {
        s.world.update();
    }
    s.frame();
    assert!(s.scene.media.is_empty());
}

#[test]
fn the_first_sixteen_by_identity_are_drawn() {
    let (mut s, mist) = foggy(ball());
    let later: Vec<Entity> = (1..=MAX_MEDIA).map(|number| s.world.spawn(&format!("fog {number}"), None)).collect();
    // In any order, and those that hide nothing do not count.
    for (number, entity) in later.iter().enumerate().rev() {
        s.insert(*entity, Fog { extinction: number as f32, ..ball() });
    }
    s.frame();
    let names = |s: &Stage| s.scene.media.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
    assert_eq!((names(&s).len(), names(&s)[1].as_str()), (MAX_MEDIA, "fog 2"));
    assert!(s.scene.media.is_sorted_by_key(|m| m.id) && s.scene.warnings.is_empty(), "{:?}", s.scene.warnings);
    let same = names(&s);
    let last = s.world.spawn("one too many", None);
    assert!(!s.changes_media(|s| s.insert(last, ball())));
    assert_eq!(names(&s), same);
    assert!(s.warns("`one too many`: holds fog that is not drawn: a scene has at most 16"), "{:?}", s.scene.warnings);
    assert!(s.changes_media(|s| s.remove::<Fog>(mist)));
    assert!(names(&s).contains(&"one too many".to_owned()) && s.scene.warnings.is_empty());
}

#[test]
fn fog_stays_where_it_is_when_the_camera_goes_far() {
    let mut s = Stage::new();
    // Nothing but fog, a light and a camera.
    s.remove::<MeshRenderer>(s.thing);
    let mist = s.world.spawn("mist", None);
    let far = Transform::from_xyz(1e6, 0.0, 0.0);
    s.insert(mist, (ball(), far));
    s.frame();
    assert_eq!((s.scene.origin, s.scene.media[0].base), (DVec3::ZERO, Vec3::X * 1e6));
    s.insert(s.eye, far);
    s.frame();
    assert_ne!(s.scene.origin, DVec3::ZERO);
    assert_eq!(s.scene.origin + s.scene.media[0].base.as_dvec3(), DVec3::X * 1e6);
    assert_eq!((s.scene.media.len(), s.scene.lights.len()), (1, 1));
    let center = s.scene.media[0].local_from_world.transform_point3(s.scene.media[0].base);
    assert!(center.abs_diff_eq(Vec3::ZERO, 1e-6), "{center}");
}
