//! Load → save → load is the identity; saves are atomic and keep what they replace.

use super::*;
use crate::files::ron::document::Document;
use crate::files::save::scene::scene_text;
use crate::files::save::text::to_text;
use crate::world::animation::{Interpolation, KeyValue, Target, Track, Wrap};
use crate::world::{
    Animation, Bloom, Bounces, Camera, CellSize, Clpv, ClpvPlacement, Delta, DepthOfField, Exposure, Fog, FogShape,
    GatherRays, Lens, Light, LightBounds, LightChances, LightCulling, LightKind, LightLobes, LightVisibility,
    Particles, Precision, Projection, Quality, SceneSettings, StochasticLightCulling, ToneMap, Transform, Transport,
};
use glam::{Quat, Vec3};
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;

const SCENE: &str = r#"// A scene.
/* Second line. */

Scene(
    gi: None,
    settings: (sky: (0.1, 0.2, 0.3), duration: 4),
    materials: { "red": (color: (1, 0, 0), specular: 0), "unused": () },
    entities: [
        // An inner comment.
        (name: "Ball", transform: (rotation: (10, 20, 30), scale: 2), mesh: Sphere(radius: 0.5), material: "red",
            children: [(name: "Box", mesh: Box(size: (1, 2, 3)), material: (color: (0, 1, 0)), casts_shadow: false)]),
        (name: "Eye", transform: (translation: (0, 1, 4), look_at: (0, 0, 0)), camera: (fov: 45)),
        (name: "Sun", light: (kind: Directional, intensity: 3)),
    ],
)
"#;

#[test]
fn a_save_keeps_a_backup() {
    let folder = Folder::new(&[("a.scene.ron", SCENE)]);
    let mut world = folder.load("a.scene.ron").unwrap();
    let ball = at(&world, "Ball").unwrap();
    world.ecs.despawn(ball);
    save_scene(&world, &folder.path("a.scene.ron")).unwrap();
    assert_ne!(folder.read("a.scene.ron"), SCENE);
    assert_eq!(folder.read("a.scene.ron.bak"), SCENE);
    let names: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().flatten().map(|e| e.file_name()).collect();
    assert_eq!(names.len(), 2, "no temporary file is left: {names:?}");
}

#[test]
fn a_new_text_says_what_is_not_the_default() {
    let (_, file) = Document::parse::<SceneFile>(Path::new("a.scene.ron"), SCENE.to_owned()).unwrap();
    let text = to_text(&file, None).unwrap();
    for kept in [
        "rotation: (10.0, 20.0, 30.0)",
        "scale: 2.0",
        "look_at: (0.0, 0.0, 0.0)",
        "\"unused\": ()",
        "gi: None",
        "material: \"red\"",
    ] {
        assert!(text.contains(kept), "{kept} in\n{text}");
    }
    assert!(!text.contains("rsm_size"), "defaults are left out:\n{text}");
}

#[test]
fn a_moved_entity_is_saved_where_it_stands() {
    let folder = Folder::new(&[("a.scene.ron", SCENE)]);
    let mut world = folder.load("a.scene.ron").unwrap();
    let ball = at(&world, "Ball").unwrap();
    let place = Transform {
        translation: Vec3::new(0.1, 1.0 / 3.0, -7.0),
        rotation: Quat::from_rotation_x(0.3),
        scale: Vec3::new(1.0, -1.0, 0.0),
    };
    world.ecs.entity_mut(ball).insert(place);
    save_scene(&world, &folder.path("b.scene.ron")).unwrap();
    let again = folder.load("b.scene.ron").unwrap();
    assert_eq!(*again.ecs.get::<Transform>(at(&again, "Ball").unwrap()).unwrap(), place);
}

#[test]
fn the_rest_pose_is_saved_not_the_animated_one() {
    let path = shipped("scenes/cornell.scene.ron");
    let mut world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
    let before = scene_text(&world, &path).unwrap();
    let block = at(&world, "Tall block").unwrap();
    let rest = *world.ecs.get::<Transform>(block).unwrap();
    world.set_tick(37);
    world.update();
    assert_ne!(*world.ecs.get::<Transform>(block).unwrap(), rest, "it moves");
    assert_eq!(scene_text(&world, &path).unwrap(), before);
}

#[test]
fn the_cornell_box_is_84_triangles_in_a_closed_loop() {
    let path = shipped("scenes/cornell.scene.ron");
    let mut world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
    let renderers = world
        .ecs
        .query::<&crate::world::MeshRenderer>()
        .iter(&world.ecs)
        .map(|r| r.mesh.triangle_count())
        .sum::<usize>();
    assert_eq!(renderers, 84);
    let light = at(&world, "Swing/Spot light").unwrap();
    let mut place_at = |tick: u64| {
        world.set_tick(tick);
        world.update();
        world.ecs.get::<crate::world::GlobalTransform>(light).unwrap().0
    };
    let (start, end) = (place_at(0), place_at(180));
    assert_eq!(start, end);
    assert!(place_at(45).translation.x > 0.3 && place_at(135).translation.x < -0.3);
}

#[test]
fn a_failed_write_leaves_the_file() {
    let folder = Folder::new(&[("a.scene.ron", SCENE)]);
    let world = folder.load("a.scene.ron").unwrap();
    let error = save_scene(&world, &folder.path("nowhere/a.scene.ron")).unwrap_err();
    assert!(matches!(error.kind, FileErrorKind::Io), "{error}");
    assert_eq!(folder.read("a.scene.ron"), SCENE);
}

/// Scenes that need no models of others.
pub(super) const SHIPPED: [&str; 18] = [
    "bleeding_gloss",
    "cathedral",
    "cornell",
    "courtyard",
    "embers",
    "gallery",
    "glasshouse",
    "glossy_ring",
    "lens",
    "meeting_room",
    "night_court",
    "plaza",
    "prefabs",
    "smoke",
    "glassware",
    "showroom",
    "studio",
    "vpl_report",
];

/// Where all entities with a component are.
fn places<T: bevy_ecs::prelude::Component>(world: &mut GameWorld) -> Vec<[u32; 12]> {
    use crate::world::GlobalTransform;
    let mut query = world.ecs.query_filtered::<&GlobalTransform, bevy_ecs::prelude::With<T>>();
    query.iter(&world.ecs).map(|place| place.0.to_cols_array().map(f32::to_bits)).collect()
}

/// Camera, lights and objects of each shipped scene move, and come back to where they were: it loops.
#[test]
fn everything_moves_in_shipped_scenes() {
    use crate::world::{Light, MeshRenderer, SceneSettings};
    // These show one thing: how prefabs are written, reflections on a ring, and particles, which are no lights.
    for name in SHIPPED.into_iter().filter(|name| !["prefabs", "glossy_ring", "embers"].contains(name)) {
        let path = shipped(&format!("scenes/{name}.scene.ron"));
        let mut world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
        let settings = world.ecs.resource::<SceneSettings>();
        let duration = f64::from(settings.duration.unwrap_or_else(|| panic!("{name} has no end")));
        let all =
            |world: &mut GameWorld| [places::<Camera>(world), places::<Light>(world), places::<MeshRenderer>(world)];
        let start = all(&mut world);
        world.set_seconds(duration / 7.0);
        world.update();
        for ((before, after), what) in start.iter().zip(all(&mut world)).zip(["camera", "light", "object"]) {
            assert!(*before != after, "no {what} of `{name}` moves");
        }
    }
}

#[test]
fn shipped_scenes_survive_a_round_trip() {
    for name in SHIPPED {
        let path = shipped(&format!("scenes/{name}.scene.ron"));
        let load = |p: &Path| {
            load_scene(p, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
        };
        let world = load(&path);
        let text = scene_text(&world, &path).unwrap();
        let (_, before) = Document::read::<SceneFile>(&path).unwrap();
        let (_, after) = Document::parse::<SceneFile>(&path, text.clone()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(before, after, "{text}");
    }
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![-100.0f32..100.0, (-20i32..20).prop_map(|i| i as f32), Just(1e-6), Just(1.0 / 3.0)]
}

fn vector() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from)
}

fn transform() -> impl Strategy<Value = TransformFile> {
    let rotation = prop_oneof![
        vector().prop_map(Rotation::Euler),
        [0.1f32..1.0, -1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(|q| Rotation::Quaternion(Quat::from_array(q))),
    ];
    let scale = prop_oneof![number().prop_map(Scale::Uniform), vector().prop_map(Scale::Axes)];
    (vector(), of(rotation), of(scale), any::<bool>()).prop_map(|(translation, rotation, scale, look)| TransformFile {
        translation,
        rotation: rotation.filter(|_| !look),
        look_at: look.then_some(translation + Vec3::new(1.0, 2.0, -3.0)),
        scale,
    })
}

fn light() -> impl Strategy<Value = Light> {
    let kind = prop_oneof![
        Just(LightKind::Directional),
        Just(LightKind::Point),
        (0.0f32..40.0, 41.0f32..90.0).prop_map(|(inner, outer)| LightKind::Spot { inner, outer }),
        (0.01f32..90.0).prop_map(|angle| LightKind::Sun { angle }),
        (0.001f32..10.0).prop_map(|radius| LightKind::Sphere { radius }),
        (0.001f32..10.0).prop_map(|radius| LightKind::Disc { radius }),
        (0.001f32..10.0, 0.001f32..10.0).prop_map(|(width, height)| LightKind::Rectangle { width, height }),
        (0.001f32..10.0, 0.001f32..10.0).prop_map(|(length, radius)| LightKind::Tube { length, radius }),
    ];
    (kind, 0.0f32..1e4, of(0.1f32..50.0), any::<bool>(), 16u32..4096).prop_map(
        |(kind, intensity, range, casts_shadow, shadow_size)| Light {
            kind,
            intensity,
            range,
            casts_shadow,
            shadow_size,
            ..Default::default()
        },
    )
}

fn clpv() -> impl Strategy<Value = Clpv> {
    let placement =
        prop_oneof![Just(ClpvPlacement::Fixed), (0.0f32..1.0).prop_map(|ahead| ClpvPlacement::Camera { ahead })];
    let size = prop_oneof![Just(CellSize::Auto), (0.01f32..10.0).prop_map(CellSize::Meters)];
    let transport = prop_oneof![Just(Transport::Sweep), Just(Transport::Diffusion)];
    let bounces = prop_oneof![Just(Bounces::Converged), (1u32..=32).prop_map(Bounces::Count)];
    let quality = prop_oneof![Just(Quality::Low), Just(Quality::Medium), Just(Quality::High), Just(Quality::Ultra)];
    let rays = prop_oneof![
        Just(GatherRays::Auto),
        (0u32..=16).prop_map(GatherRays::Count),
        (1u32..=16).prop_map(GatherRays::Paths)
    ];
    let precision = prop_oneof![Just(Precision::Single), Just(Precision::Half)];
    let points = prop_oneof![Just(GatherRays::Auto), (0u32..=16).prop_map(GatherRays::Count)];
    let method = (transport, bounces, quality, rays, points, precision);
    (method, placement, 1u32..=4, [1u32..=128, 1u32..=128, 1u32..=128], size, 0u32..=1024).prop_map(
        |(
            (transport, bounces, quality, gather_rays, gather_points, precision),
            placement,
            cascades,
            cells,
            cell_size,
            steps,
        )| Clpv {
            transport,
            bounces,
            quality,
            gather_rays,
            gather_points,
            mirror_rays: gather_points,
            precision,
            placement,
            cascades,
            cells,
            cell_size,
            steps,
            ..Default::default()
        },
    )
}

fn slc() -> impl Strategy<Value = StochasticLightCulling> {
    let delta = prop_oneof![(1e-6f32..1.0).prop_map(Delta::Relative), (1e-6f32..1.0).prop_map(Delta::Absolute)];
    let bounds =
        prop_oneof![Just(LightBounds::Ellipsoid), Just(LightBounds::CentredSphere), Just(LightBounds::EnclosingSphere)];
    let culling = prop_oneof![
        Just(LightCulling::Tiled),
        Just(LightCulling::Clustered),
        Just(LightCulling::Splatting),
        Just(LightCulling::None)
    ];
    let lobes = prop_oneof![Just(LightLobes::Both), Just(LightLobes::Diffuse), Just(LightLobes::Specular)];
    let chances = prop_oneof![Just(LightChances::Even), Just(LightChances::Independent)];
    let visibility = prop_oneof![Just(LightVisibility::None), Just(LightVisibility::ShadowRays)];
    let ways = (bounds, culling, lobes, chances);
    (delta, ways, visibility, 8u32..=4096, 0u32..5, 0u32..=64).prop_map(
        |(delta, (bounds, culling, lobes, chances), visibility, rsm_size, power, filter_radius)| {
            StochasticLightCulling {
                delta,
                bounds,
                culling,
                lobes,
                chances,
                visibility,
                rsm_size,
                interleave: 1 << power,
                filter_radius,
                ..Default::default()
            }
        },
    )
}

fn fog() -> impl Strategy<Value = Fog> {
    let edge = || 0.001f32..1e3;
    let shape = prop_oneof![
        Just(FogShape::Everywhere),
        [edge(), edge(), edge()].prop_map(|size| FogShape::Box { size: size.into() }),
        edge().prop_map(|radius| FogShape::Sphere { radius }),
    ];
    (shape, 0.0f32..1e3, [0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0], -0.9f32..0.9, 0.0f32..10.0).prop_map(
        |(shape, extinction, albedo, anisotropy, falloff)| Fog {
            shape,
            extinction,
            albedo: albedo.into(),
            anisotropy,
            falloff,
        },
    )
}

fn particles() -> impl Strategy<Value = Particles> {
    let color = || [0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0].prop_map(Vec3::from);
    let motion = ([-9.0f32..9.0, -9.0f32..9.0, -9.0f32..9.0], 0.0f32..180.0, 0.0f32..1.0);
    (0.0f32..1e3, 0.01f32..10.0, motion, (0.0f32..1.0, 0.0f32..1.0), (color(), color()), 0.0f32..1e6, any::<u32>())
        .prop_map(|(rate, life, (velocity, spread, speed_variation), radii, colors, radiance, seed)| Particles {
            rate,
            life,
            velocity: velocity.into(),
            spread,
            speed_variation,
            radius: radii.0,
            end_radius: radii.1,
            color: colors.0,
            end_color: colors.1,
            radiance,
            seed,
            ..Default::default()
        })
}

fn animation() -> impl Strategy<Value = Animation> {
    let axis = vector().prop_filter("an axis has a direction", |a| a.length() > 0.1);
    let spin = (axis, -90.0f64..90.0).prop_map(|(axis, speed)| Track::Spin { axis, degrees_per_second: speed.round() });
    let keys = vec(vector(), 1..5).prop_map(|values| Track::Keys {
        node: String::new(),
        target: Target::Translation,
        keys: values.into_iter().enumerate().map(|(i, v)| (0.3 + i as f64, KeyValue::Vector(v))).collect(),
        interpolation: Interpolation::Cubic,
        wrap: Wrap::PingPong,
    });
    (vec(prop_oneof![spin, keys], 0..3), number()).prop_map(|(tracks, offset)| Animation {
        tracks,
        offset: offset.into(),
        ..Default::default()
    })
}

fn material() -> impl Strategy<Value = MaterialRef> {
    let volume = ([0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0], 1e-3f32..1e3)
        .prop_map(|(color, distance)| AttenuationFile { color: color.into(), distance });
    let glass = (0.0f32..1.0, 1.0f32..10.0, of(volume), 0.0f32..100.0);
    let coat = (0.0f32..1.0, 0.0f32..1.0).prop_map(|(factor, roughness)| ClearcoatFile { factor, roughness });
    let sheen = ([0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0], 0.0f32..1.0)
        .prop_map(|(color, roughness)| SheenFile { color: color.into(), roughness });
    let anisotropy =
        (0.0f32..1.0, -360.0f32..360.0).prop_map(|(strength, rotation)| AnisotropyFile { strength, rotation });
    let film = (0.0f32..1.0, 1.0f32..10.0, 0.0f32..1e5).prop_map(|(factor, ior, thickness)| IridescenceFile {
        factor,
        ior,
        thickness,
    });
    let layers = (of(coat), of(sheen), of(anisotropy), of(film));
    let inline = ([0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0], 0.0f32..1.0, any::<bool>(), glass, layers).prop_map(
        |(color, roughness, double_sided, glass, (clearcoat, sheen, anisotropy, iridescence))| {
            let (transmission, ior, volume, dispersion) = glass;
            MaterialRef::Inline(Box::new(MaterialFile {
                color: color.into(),
                roughness,
                double_sided,
                transmission,
                ior,
                volume,
                dispersion,
                clearcoat,
                sheen,
                anisotropy,
                iridescence,
                ..Default::default()
            }))
        },
    );
    prop_oneof![Just(MaterialRef::Named("a \"b\" \\ ü".into())), inline]
}

fn lens() -> impl Strategy<Value = Lens> {
    let photographic = (0.5f32..64.0, 1e-4f32..10.0, 25.0f32..1e5)
        .prop_map(|(f_number, shutter, iso)| Exposure::Photographic { f_number, shutter, iso });
    let exposure = prop_oneof![Just(Exposure::Scene), Just(Exposure::Automatic), photographic];
    let tone_map = proptest::sample::select(ToneMap::ALL.to_vec());
    let bloom = (0.0f32..1.0, 0.01f32..1.0).prop_map(|(scatter, radius)| Bloom { scatter, radius });
    let focus = (0.1f32..1e3, 0.5f32..64.0, 4.0f32..100.0);
    let depth_of_field =
        focus.prop_map(|(focus, f_number, sensor_height)| DepthOfField { focus, f_number, sensor_height });
    let film = (0.0f32..0.99, 0.0f32..1.0, 0.0f32..0.5);
    (exposure, tone_map, of(depth_of_field), of(bloom), film).prop_map(
        |(exposure, tone_map, depth_of_field, bloom, (vignette, sharpening, grain))| Lens {
            exposure,
            tone_map,
            depth_of_field,
            bloom,
            grading: None,
            vignette,
            sharpening,
            grain,
        },
    )
}

pub(super) fn entity() -> impl Strategy<Value = EntityFile> {
    let mesh = [0.01f32..10.0, 0.01f32..10.0, 0.01f32..10.0].prop_map(|size| Shape::Box { size });
    let camera = (1.0f32..179.0, of(0.01f32..100.0), 0.001f32..1.0, of(2.0f32..1e3), any::<bool>(), lens()).prop_map(
        |(fov, height, near, far, primary, lens)| {
            let projection = height.map_or(Projection::Perspective, |height| Projection::Orthographic { height });
            Camera { projection, fov, near, far, primary, lens }
        },
    );
    let leaf = (
        "[^/]{1,12}",
        of(transform()),
        of((mesh, of(material()), of(any::<bool>()))),
        of(light()),
        of(camera),
        (of(clpv()), of(slc()), of(fog()), of(particles())),
        of(animation()),
    );
    let leaf = leaf.prop_filter("a name is not blank", |l| !l.0.trim().is_empty()).prop_map(
        |(name, transform, surface, light, camera, (clpv, slc, fog, particles), animation)| {
            let (mesh, material, casts_shadow) = surface.map_or((None, None, None), |(m, r, c)| (Some(m), r, c));
            EntityFile {
                name,
                transform,
                mesh,
                material,
                casts_shadow,
                light,
                camera,
                clpv,
                slc,
                fog,
                particles,
                animation,
                ..Default::default()
            }
        },
    );
    leaf.prop_recursive(4, 24, 4, |inner| {
        (inner.clone(), vec(inner, 0..4)).prop_map(|(mut parent, children)| {
            parent.children = unique(children);
            parent
        })
    })
}

pub(super) fn unique(mut entities: Vec<EntityFile>) -> Vec<EntityFile> {
    let mut names = std::collections::HashSet::new();
    entities.retain(|e| names.insert(e.name.clone()));
    entities
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn generated_scenes_survive_a_round_trip(entities in vec(entity(), 0..5), exposure in number(), sky in 0.0f32..10.0) {
        let file = SceneFile {
            description: "line\nbreak \"quoted\" // no comment".into(),
            settings: SceneSettings { exposure, sky: Vec3::splat(sky), ..Default::default() },
            materials: [("a \"b\" \\ ü".to_owned(), MaterialFile { metallic: 1.0, ..Default::default() })].into(),
            entities: unique(entities),
            ..Default::default()
        };
        let text = to_text(&file, None).unwrap();
        let path = Path::new("x.scene.ron");
        let (_, parsed) = Document::parse::<SceneFile>(path, text.clone()).unwrap_or_else(|e| panic!("{e}\n{text}"));
        prop_assert_eq!(&parsed, &file, "{}", text);
        let folder = Folder::new(&[("x.scene.ron", &text)]);
        let world = folder.load("x.scene.ron").unwrap_or_else(|e| panic!("{e}"));
        let saved = scene_text(&world, path).unwrap();
        prop_assert_eq!(saved, text);
    }
}
