//! A physical sky follows the light that is the sun, and dims it.

use super::*;

fn evening() -> (Stage, Entity) {
    let mut s = Stage::new();
    let environment = Some(Environment::Physical { haze: 1.0, ground: Vec3::splat(0.3), altitude: 0.0, sun: None });
    s.world.ecs.insert_resource(SceneSettings { environment, ..SceneSettings::default() });
    s.frame();
    let sun = s.world.spawn("sun", None);
    let light = Light { kind: LightKind::Sun { angle: 0.5 }, intensity: 2.0, ..Light::default() };
    s.world.ecs.entity_mut(sun).insert(light);
    (s, sun)
}

fn turn(s: &mut Stage, sun: Entity, elevation: f32, azimuth: f32) {
    let rotation = Quat::from_rotation_y(azimuth.to_radians()) * Quat::from_rotation_x(-elevation.to_radians());
    s.world.ecs.get_mut::<Transform>(sun).unwrap().rotation = rotation;
    s.frame();
}

fn intensity(s: &Stage, name: &str) -> Vec3 {
    s.scene.lights.iter().find(|light| light.name == name).unwrap().intensity
}

#[test]
fn the_sun_is_dimmed_and_the_sky_follows() {
    let (mut s, sun) = evening();
    turn(&mut s, sun, 60.0, 0.0);
    let (noon, day) = (intensity(&s, "sun"), s.scene.sky_map.clone().unwrap());
    assert!(noon.max_element() < 2.0 && noon.min_element() > 1.0, "{noon}");
    assert_eq!(intensity(&s, "lamp"), Vec3::ONE * Light::default().intensity, "the lamp is below the air");
    // The brightest direction high in the sky is around the sun: the horizon is brighter.
    let high = day.width * day.height / 3;
    let brightest = (0..high).max_by(|a, b| day.texels[*a as usize].x.total_cmp(&day.texels[*b as usize].x)).unwrap();
    let toward = day.direction(brightest % day.width, brightest / day.width);
    assert!(toward.dot(s.scene.sun_disc.unwrap().toward) > 0.99, "{toward}");
    turn(&mut s, sun, 60.0, 90.0);
    let turned = s.scene.sky_map.clone().unwrap();
    assert_eq!(day.texels, turned.texels, "turned about the vertical it is the same sky");
    assert!(turned.direction(0, 128).dot(day.direction(0, 128)).abs() < 0.1);
    turn(&mut s, sun, 2.0, 90.0);
    let low = intensity(&s, "sun");
    assert!(low.x > 2.0 * low.z && low.x < noon.x, "{low}");
    assert!(s.scene.sky.element_sum() < 0.3 * day.mean().element_sum());
    turn(&mut s, sun, -5.0, 90.0);
    assert_eq!(intensity(&s, "sun"), Vec3::ZERO);
}

#[test]
fn what_does_not_change_takes_no_revision() {
    let (mut s, sun) = evening();
    turn(&mut s, sun, 30.0, 0.0);
    let (before, map) = (s.frame(), s.scene.sky_map.clone().unwrap());
    assert_eq!(list(s.frame()), list(before));
    s.world.ecs.get_mut::<Transform>(sun).unwrap().translation.x = 5.0;
    let moved = s.frame();
    assert_eq!(moved.settings, before.settings, "a sun that is only moved is the same sun");
    assert!(Arc::ptr_eq(&map, s.scene.sky_map.as_ref().unwrap()));
}

#[test]
fn another_sun_or_none_is_noticed() {
    let (mut s, sun) = evening();
    turn(&mut s, sun, 50.0, 0.0);
    let dimmed = intensity(&s, "sun");
    s.world.ecs.resource_mut::<SceneSettings>().environment =
        Some(Environment::Physical { haze: 1.0, ground: Vec3::splat(0.3), altitude: 0.0, sun: Some("moon".into()) });
    s.frame();
    assert!(s.scene.warnings.iter().any(|warning| warning.contains("`moon`")), "{:?}", s.scene.warnings);
    assert_eq!(intensity(&s, "sun"), Vec3::splat(2.0), "it is no sun any more");
    assert!(s.scene.sky_map.is_none() && s.scene.sun_disc.is_none());
    s.world.ecs.entity_mut(sun).insert(Name("moon".into()));
    s.frame();
    assert!(s.scene.warnings.is_empty() && s.scene.sky_map.is_some());
    assert_eq!(intensity(&s, "moon"), dimmed);
    s.world.ecs.resource_mut::<SceneSettings>().environment = None;
    s.frame();
    assert_eq!(intensity(&s, "moon"), Vec3::splat(2.0));
    assert_eq!((s.scene.sky_map.is_none(), s.scene.sky), (true, Vec3::ZERO));
}

#[test]
fn values_out_of_range_give_a_finite_sky() {
    let (mut s, sun) = evening();
    for value in [f32::NAN, f32::INFINITY, -1.0, 1e30] {
        s.world.ecs.resource_mut::<SceneSettings>().environment =
            Some(Environment::Physical { haze: value, ground: Vec3::splat(value), altitude: value, sun: None });
        turn(&mut s, sun, 20.0, 0.0);
        assert!(s.scene.sky.is_finite() && intensity(&s, "sun").is_finite(), "{value}");
    }
    s.world.ecs.resource_mut::<SceneSettings>().environment =
        Some(Environment::Physical { haze: 1.0, ground: Vec3::ZERO, altitude: 0.0, sun: None });
    for (angle, intensity) in [(1e-30, 1.0), (1e-5, 1e30), (0.5, 1e38), (1e30, 1.0)] {
        let light = Light { kind: LightKind::Sun { angle }, intensity, ..Light::default() };
        s.world.ecs.entity_mut(sun).insert(light);
        s.frame();
        let disc = s.scene.sun_disc.unwrap();
        assert!(disc.radiance.is_finite() && disc.half_angle.cos() < 1.0, "{angle}°, {intensity}: {disc:?}");
        assert!(s.scene.sky.is_finite());
    }
}
