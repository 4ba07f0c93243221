#![allow(clippy::unwrap_used)]
use super::*;
use lightwell::world::{Bounces, FogShape, LightKind, Quality};

fn world() -> GameWorld {
    let mut world = GameWorld::new();
    let kind = LightKind::Spot { inner: 20.0, outer: 30.0 };
    let lamp = world.ecs.spawn((Name("Lamp".into()), Transform::default(), Light { kind, ..Light::default() })).id();
    world.ecs.spawn((Name("Bulb".into()), Transform::default(), Light::default(), ChildOf(lamp)));
    world.ecs.spawn((Name("v1.2".into()), Camera::default(), Clpv::default()));
    world
}

fn light(world: &mut GameWorld, name: &str) -> Light {
    let mut query = world.ecs.query::<(&Name, &Light)>();
    query.iter(&world.ecs).find(|(n, _)| n.0 == name).unwrap().1.clone()
}

#[test]
fn values_are_set_by_path() {
    let mut world = world();
    for (path, value) in [
        ("Lamp.light.intensity", "5"),
        ("Lamp.light.kind.outer", "45"),
        ("Lamp.light.color", "(1, 0.5, 0)"),
        ("Lamp.light.color.2", "0.25"),
        ("Lamp.light.range", "7"),
        ("Lamp/Bulb.light.intensity", "2"),
        ("Lamp.transform.rotation", "(0, 90, 0)"),
        ("clpv.cells", "(8, 8, 7)"),
        ("clpv.cell_size", "Meters(0.5)"),
        ("v1.2.camera.fov", "45"),
        ("scene.sky", "(0, 0, 1)"),
    ] {
        apply(&mut world, path, value).unwrap_or_else(|e| panic!("{path}={value}: {e}"));
    }
    let lamp = light(&mut world, "Lamp");
    assert_eq!((lamp.intensity, lamp.range), (5.0, Some(7.0)));
    assert_eq!(lamp.kind, LightKind::Spot { inner: 20.0, outer: 45.0 });
    assert_eq!(lamp.color, Vec3::new(1.0, 0.5, 0.25));
    assert_eq!(light(&mut world, "Bulb").intensity, 2.0);
    let (transform, clpv) = (world.ecs.query::<(&Name, &Transform)>(), world.ecs.query::<&Clpv>());
    let (mut transform, mut clpv) = (transform, clpv);
    let rotation = transform.iter(&world.ecs).find(|(n, _)| n.0 == "Lamp").unwrap().1.rotation;
    assert!((rotation * -Vec3::Z - -Vec3::X).length() < 1e-6, "{rotation}");
    assert_eq!(clpv.iter(&world.ecs).next().unwrap().cells, [8, 8, 7]);
    assert_eq!(world.ecs.resource::<SceneSettings>().sky, Vec3::Z);
}

#[test]
fn fog_is_set_by_path() {
    let mut world = world();
    let smoke = world.ecs.spawn((Name("Smoke".into()), Fog::default())).id();
    for (path, value) in [
        ("Smoke.fog.extinction", "0.2"),
        ("Smoke.fog.shape", "box(size: (4, 3, 4))"),
        ("Smoke.fog.shape.size.1", "5"),
        ("Smoke.fog.albedo", "(0.9, 0.8, 0.7)"),
        ("Smoke.fog.anisotropy", "0.5"),
    ] {
        apply(&mut world, path, value).unwrap_or_else(|e| panic!("{path}={value}: {e}"));
    }
    let shape = FogShape::Box { size: Vec3::new(4.0, 5.0, 4.0) };
    let albedo = Vec3::new(0.9, 0.8, 0.7);
    let expected = Fog { shape, extinction: 0.2, albedo, anisotropy: 0.5, falloff: 0.0 };
    assert_eq!(world.ecs.get::<Fog>(smoke), Some(&expected));
    for (path, said) in [("Smoke.fog.density", "extinction"), ("Smoke.light.intensity", "it has `fog`")] {
        let error = apply(&mut world, path, "1").unwrap_err().to_string();
        assert!(error.contains(said), "{path}: {error}");
    }
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let mut world = world();
    for (path, value, expected) in [
        ("Lump.light.intensity", "5", "Lamp/Bulb"),
        ("Lamp.camera.fov", "5", "`transform`, `light`"),
        ("Lamp.light.power", "5", "intensity"),
        ("Lamp.light.intensity", "bright", "does not fit"),
        ("Lamp.light.intensity", "5,range:3", "one value"),
        ("clpv.stepps", "5", "steps"),
        ("Lamp.light.kind.outer.x", "5", "has no fields"),
        ("scene.skye", "5", "sky"),
        ("Lamp.light", "5", "COMPONENT.FIELD"),
        ("clpv.quality", "Hihg", "did you mean `High`?"),
    ] {
        let error = apply(&mut world, path, value).unwrap_err().to_string();
        assert!(error.contains(expected), "{path}={value}: {error}");
    }
}

#[test]
fn variants_may_be_written_in_other_letters() {
    let mut world = world();
    apply(&mut world, "clpv.quality", "ultra").unwrap();
    apply(&mut world, "clpv.bounces", "count(2)").unwrap();
    let mut clpv = world.ecs.query::<&Clpv>();
    let found = clpv.iter(&world.ecs).next().unwrap();
    assert_eq!((found.quality, found.bounces), (Quality::Ultra, Bounces::Count(2)));
}

#[test]
fn equal_names_want_a_path() {
    let mut world = world();
    let other = world.ecs.spawn(Name("Other".into())).id();
    world.ecs.spawn((Name("Bulb".into()), Light::default(), ChildOf(other)));
    let error = apply(&mut world, "Bulb.light.intensity", "1").unwrap_err().to_string();
    assert!(error.contains("Lamp/Bulb, Other/Bulb"), "{error}");
}

#[test]
#[allow(clippy::field_reassign_with_default, reason = "it has private fields")]
fn presets_make_all_their_changes() {
    let mut world = world();
    let presets = [
        ("small", vec!["clpv.cells=(8, 8, 7)".to_owned(), " Lamp.light.intensity = 5 ".to_owned()]),
        ("wrong", vec!["clpv.cels=(8, 8, 7)".to_owned()]),
        ("endless", vec!["preset=endless".to_owned()]),
    ];
    let presets = presets.into_iter().map(|(name, changes)| (name.to_owned(), changes)).collect();
    let mut info = SceneInfo::default();
    info.presets = presets;
    world.ecs.insert_resource(info);
    apply(&mut world, "preset", "small").unwrap();
    assert_eq!(light(&mut world, "Lamp").intensity, 5.0);
    assert_eq!(world.ecs.query::<&Clpv>().single(&world.ecs).unwrap().cells, [8, 8, 7]);
    for (name, said) in [("smal", "small"), ("wrong", "cels"), ("endless", "cannot make another")] {
        let error = apply(&mut world, "preset", name).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    world.ecs.insert_resource(SceneInfo::default());
    assert!(apply(&mut world, "preset", "small").unwrap_err().to_string().contains("no presets"));
}

/// A component of a game.
#[derive(Component, lightwell::files::SceneData, Clone, Debug, Default, PartialEq)]
struct Moth {
    /// Speed [m/s].
    speed: f32,
    /// Where it likes to be.
    home: Option<Vec3>,
    /// How it flies.
    way: Way,
}

/// How a moth flies.
#[derive(lightwell::files::SceneData, Clone, Debug, Default, PartialEq)]
enum Way {
    #[default]
    Straight,
    Circling {
        /// Radius [m].
        radius: f32,
    },
}

#[test]
fn components_of_a_game_are_set_too() {
    use lightwell::files::{ComponentType, ComponentTypes};
    let mut world = world();
    let mut types = ComponentTypes::default();
    types.add(ComponentType::of::<Moth>()).unwrap();
    types.register(&mut world.ecs);
    world.ecs.insert_resource(types);
    let lamp = find_entity(&mut world, "Lamp.x").unwrap().0;
    world.ecs.entity_mut(lamp).insert(Moth::default());
    for (path, value) in
        [("Lamp.Moth.speed", "3"), ("Lamp.Moth.home", "(1, 2, 3)"), ("Lamp.Moth.way", "Circling(radius: 1)")]
    {
        apply(&mut world, path, value).unwrap_or_else(|e| panic!("{path}={value}: {e}"));
    }
    apply(&mut world, "Lamp.Moth.way.radius", "2.5").unwrap();
    let expected = Moth { speed: 3.0, home: Some(Vec3::new(1.0, 2.0, 3.0)), way: Way::Circling { radius: 2.5 } };
    assert_eq!(world.ecs.get::<Moth>(lamp), Some(&expected));
    for (path, value, said) in [
        ("Lamp.Moth.sped", "3", "speed, home, way"),
        ("Lamp.Moth.speed", "fast", "does not fit"),
        ("Lamp.Moht.speed", "3", "`light`, `Moth`"),
        ("Lamp/Bulb.Moth.speed", "3", "has no `Moth`"),
    ] {
        let error = apply(&mut world, path, value).unwrap_err().to_string();
        assert!(error.contains(said), "{path}={value}: {error}");
    }
    assert_eq!(world.ecs.get::<Moth>(lamp), Some(&expected), "mistakes change nothing");
}

#[test]
fn particles_are_set_by_path() {
    let mut world = GameWorld::new();
    let fire = world.ecs.spawn((Name("Fire".into()), Particles::default())).id();
    for (path, value) in [
        ("Fire.particles.rate", "300"),
        ("Fire.particles.velocity.1", "4"),
        ("Fire.particles.end_color", "(1, 0, 0)"),
        ("Fire.particles.seed", "7"),
    ] {
        apply(&mut world, path, value).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
    let (velocity, end_color) = (Vec3::new(0.0, 4.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    let expected = Particles { rate: 300.0, velocity, end_color, seed: 7, ..Particles::default() };
    assert_eq!(world.ecs.get::<Particles>(fire), Some(&expected));
    for (path, said) in [("Fire.particles.size", "radius"), ("Fire.light.intensity", "it has `particles`")] {
        let error = apply(&mut world, path, "1").unwrap_err().to_string();
        assert!(error.contains(said), "{path}: {error}");
    }
}
