//! Lights, cameras and volumes come out in their ranges, whatever components hold.

use super::*;

#[test]
fn lights_come_out_in_range() {
    let mut s = Stage::new();
    let given = Light { color: Vec3::new(1.0, 0.5, 0.0), intensity: 4.0, range: Some(3.0), ..Light::default() };
    let light = s.light(given.clone());
    assert_eq!((light.intensity, light.range, light.shape), (Vec3::new(4.0, 2.0, 0.0), Some(3.0), LightShape::Point));
    for intensity in [f32::NAN, -1.0, f32::INFINITY] {
        assert_eq!(s.light(Light { intensity, ..given.clone() }).intensity, Vec3::ZERO);
    }
    for color in [Vec3::NAN, Vec3::new(1.0, -1.0, 1.0)] {
        assert_eq!(s.light(Light { color, ..given.clone() }).intensity, Vec3::ZERO);
    }
    for range in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
        assert_eq!(s.light(Light { range: Some(range), ..given.clone() }).range, None);
    }
    let sized = s.light(Light { shadow_size: 0, rsm_size: u32::MAX, ..given.clone() });
    assert_eq!((sized.shadow_size, sized.rsm_size), (1, crate::scene::MAX_RSM_SIZE), "no more than is drawn");
    for (inner, outer) in [(10.0, 20.0), (30.0, 20.0), (-5.0, 0.0), (200.0, 200.0), (0.0, -1.0), (20.0, 20.0)] {
        let spot = s.light(Light { kind: LightKind::Spot { inner, outer }, ..given.clone() });
        let LightShape::Spot { inner: a, outer: b } = spot.shape else { panic!() };
        assert!(
            0.0 <= a && a < b && b <= std::f32::consts::FRAC_PI_2 && b >= 0.0099_f32.to_radians(),
            "{inner} {outer}: {a} {b}"
        );
    }
    let lost = s.light(Light { kind: LightKind::Spot { inner: f32::NAN, outer: 30.0 }, ..given });
    assert_eq!(lost.intensity, Vec3::ZERO);
}

#[test]
fn lights_with_a_surface_have_a_size() {
    let mut s = Stage::new();
    let mut shape = |kind| s.light(Light { kind, ..Light::default() }).shape;
    assert_eq!(shape(LightKind::Sphere { radius: 0.5 }), LightShape::Sphere { radius: 0.5 });
    let half_size = Vec2::new(0.5, 0.25);
    assert_eq!(shape(LightKind::Rectangle { width: 1.0, height: 0.5 }), LightShape::Rectangle { half_size });
    assert_eq!(shape(LightKind::Tube { length: 2.0, radius: 0.1 }), LightShape::Tube { half_length: 1.0, radius: 0.1 });
    assert_eq!(shape(LightKind::Sun { angle: 90.0 }), LightShape::Sun { half_angle: std::f32::consts::FRAC_PI_4 });
    for radius in [0.0, -1.0, f32::NAN] {
        assert_eq!(shape(LightKind::Disc { radius }), LightShape::Disc { radius: 1e-6 }, "{radius}");
    }
    assert_eq!(shape(LightKind::Disc { radius: f32::INFINITY }), LightShape::Disc { radius: 1e6 });
}

#[test]
fn directions_come_from_the_rotation_whatever_the_scale() {
    let mut s = Stage::new();
    let rotation = Quat::from_rotation_x(-1.0);
    for scale in [Vec3::ONE, Vec3::ZERO, -Vec3::ONE, Vec3::new(1.0, 5.0, -0.1)] {
        let place = Transform { rotation, scale, translation: Vec3::Y };
        s.insert(s.lamp, place);
        s.insert(s.eye, place);
        s.frame();
        let light = &s.scene.lights[0];
        assert!(light.direction.abs_diff_eq(rotation * Vec3::NEG_Z, 1e-6), "{scale}: {}", light.direction);
        assert_eq!(light.position, Vec3::Y);
        let view = s.scene.cameras[0].world_from_view;
        assert!((view.matrix3.determinant() - 1.0).abs() < 1e-6);
        assert!(view.transform_vector3(Vec3::NEG_Z).abs_diff_eq(rotation * Vec3::NEG_Z, 1e-6));
    }
}

#[test]
fn cameras_and_volumes_come_out_in_range() {
    let mut s = Stage::new();
    s.insert(s.eye, Camera { fov: f32::NAN, near: 0.0, far: Some(-1.0), primary: true, ..Camera::default() });
    let wild = Clpv {
        cascades: 0,
        cells: [0, 500, 8],
        cell_size: CellSize::Meters(f32::NAN),
        gain: f32::NAN,
        ..Clpv::default()
    };
    s.insert(s.volume, wild);
    s.world.ecs.resource_mut::<SceneSettings>().sky = Vec3::NAN;
    s.frame();
    let camera = &s.scene.cameras[0];
    let projection = ViewProjection::Perspective { vertical_fov: 60_f32.to_radians() };
    assert_eq!((camera.projection, camera.near, camera.far), (projection, 0.05, None));
    let tame = Clpv { cells: [1, 128, 8], ..Clpv::default() };
    assert_eq!(s.scene.clpv.as_ref().unwrap().settings, tame);
    assert_eq!(s.scene.sky, Vec3::ZERO);
    assert_eq!(s.changes(|_| {}), NOTHING);
    let wild =
        Lens { bloom: Some(Bloom { scatter: 2.0, radius: 0.1 }), grain: f32::NAN, vignette: 0.2, ..Lens::default() };
    s.insert(s.eye, Camera { lens: wild, ..Camera::default() });
    s.frame();
    assert_eq!(s.scene.cameras[0].lens, Lens { vignette: 0.2, ..Lens::default() });
    let said = |part: &str| s.scene.warnings.iter().any(|warning| warning.contains(part));
    assert!(said("without `bloom`") && said("without `grain`"), "{:?}", s.scene.warnings);
    for (height, expected) in [(3.0, 3.0), (-3.0, 1.0), (f32::NAN, 1.0)] {
        let projection = Projection::Orthographic { height };
        s.insert(s.eye, Camera { projection, near: 0.0, far: None, ..Camera::default() });
        s.frame();
        let camera = &s.scene.cameras[0];
        assert_eq!(camera.projection, ViewProjection::Orthographic { height: expected });
        assert_eq!((camera.near, camera.far_plane()), (0.0, Some(100.0 * expected)));
    }
}

#[test]
fn the_first_volume_by_identity_wins() {
    let mut s = Stage::new();
    let second = s.world.spawn("second", None);
    assert_eq!(s.changes(|s| s.insert(second, Clpv { steps: 7, ..Clpv::default() })), NOTHING);
    assert_eq!(s.changes(|s| s.world.despawn_later(s.volume)), CLPV);
    assert_eq!(s.scene.clpv.as_ref().unwrap().settings.steps, 7);
}
