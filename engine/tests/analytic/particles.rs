//! Light-emitting particles: how bright they are, and what they light in every method, against formulas and lights.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{Extractor, LightShape, Scene, SceneView};
use lightwell::world::{
    Camera, Clpv, GameWorld, GatherRays, InstantRadiosity, Light, MeshRenderer, Particles, Transform, Transport,
};
use std::f32::consts::PI;
use std::sync::Arc;

/// Changes a stage.
type Change<'a> = &'a dyn Fn(&mut Stage);

const FLOOR: f32 = 0.5;
const HEIGHT: f32 = 1.2;

/// Particles that hover around a place, up to 0.2 m to each side.
fn cloud() -> Particles {
    Particles {
        rate: 1000.0,
        life: 1.0,
        source: Vec3::splat(0.4),
        velocity: Vec3::ZERO,
        gravity: Vec3::ZERO,
        radius: 1e-3,
        end_radius: 1e-3,
        color: Vec3::ONE,
        end_color: Vec3::ONE,
        radiance: 1000.0,
        ..Particles::default()
    }
}

/// Radiant intensity of all of them together, if none hides another \[W/sr\].
fn intensity(particles: &Particles) -> f32 {
    particles.count() as f32 * particles.radiance * PI * particles.radius * particles.radius
}

/// Adds particles to a stage as they are at a time \[s\].
fn add(stage: &mut Stage, particles: Particles, at: Vec3, seconds: f64) {
    let mut world = GameWorld::new();
    let entity = world.spawn("particles", None);
    world.ecs.entity_mut(entity).insert((particles, Transform::from_translation(at)));
    world.set_seconds(seconds);
    world.update();
    let mut scene = Scene::default();
    Extractor::new().extract(&mut world, &mut scene);
    assert_eq!(scene.primitives.len(), 1);
    stage.scene.primitives.append(&mut scene.primitives);
    stage.scene.revisions.geometry += 1;
    stage.scene.revisions.materials += 1;
}

/// A floor below particles that are out of view, and a black ceiling.
fn floor() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.7, 1.0), Vec3::new(0.0, 0.0, 0.3), 32);
    let plane = Shape::Plane { size: [8.0, 8.0], subdivisions: [1, 1] };
    stage.add(plane.clone(), Vec3::splat(FLOOR), Affine3A::IDENTITY);
    let turn = Quat::from_rotation_x(PI);
    stage.add(plane, Vec3::ZERO, Affine3A::from_rotation_translation(turn, Vec3::Y * 2.4));
    stage
}

/// Mean radiance of the floor below a point light of an intensity, and nothing around it.
fn expected(stage: &Stage, intensity: f32) -> f32 {
    let [width, height] = stage.view.size;
    let eye = stage.view.eye();
    let light = Vec3::Y * HEIGHT;
    let at = |x: u32, y: u32| {
        let ray = stage.ray(x, y);
        let point = eye + ray * (-eye.y / ray.y);
        let to_light = light - point;
        let irradiance = intensity * to_light.normalize().y / to_light.length_squared();
        if ray.y < 0.0 && point.abs().max_element() < 4.0 { FLOOR * irradiance / PI } else { 0.0 }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| at(x, y))).sum::<f32>() / (width * height) as f32
}

fn trace(gpu: &Gpu, stage: &Stage, samples: u32) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: None, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}")).total()
}

fn mean_traced(image: &Image) -> f32 {
    image.pixels().iter().map(|pixel| pixel[0]).sum::<f32>() / image.pixels().len() as f32
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|pixel| pixel[0]).sum::<f32>() / image.rgba.len() as f32
}

/// Particles light a floor as one light with the sum of their intensities does: πr²L each, in the path tracer and in every
/// method.
#[test]
fn many_particles_light_a_floor_as_one_light() {
    let gpu = gpu();
    let particles = cloud();
    let of = |change: &dyn Fn(&mut Stage)| {
        let mut stage = floor();
        add(&mut stage, particles, Vec3::Y * HEIGHT, 3.0);
        change(&mut stage);
        stage
    };
    let stage = of(&|_| {});
    let wanted = expected(&stage, intensity(&particles));
    let traced = mean_traced(&trace(&gpu, &stage, 256));
    // A hundredth of the light is hidden by other particles, and the cloud is no point.
    assert!((traced / wanted - 1.0).abs() < 0.03, "{traced} traced, {wanted} expected");
    let gather = |stage: &mut Stage| stage.clpv(Vec3::Y, Clpv::default());
    let volumes =
        |stage: &mut Stage| stage.clpv(Vec3::Y, Clpv { gather_rays: GatherRays::Count(0), ..Clpv::default() });
    let virtual_lights = |stage: &mut Stage| stage.scene.vpl = Some(InstantRadiosity::default());
    let methods: [(&str, GiMethod, Change, f32); 4] = [
        ("gather", GiMethod::CLPV, &gather, 0.04),
        ("volumes", GiMethod::CLPV, &volumes, 0.2),
        ("virtual lights", GiMethod::VPL, &virtual_lights, 0.06),
        ("light culling", GiMethod::SLC, &|_| {}, 0.06),
    ];
    for (name, gi, change, bound) in methods {
        let found = mean(&of(change).render(&gpu, gi, Layer::Indirect));
        println!("{name}: {found}, {wanted} expected");
        assert!((found / wanted - 1.0).abs() < bound, "{name}: {found}, {wanted} expected");
    }
    // The diffusion loses and spreads light, but is not dark.
    let diffusion = Clpv { transport: Transport::Diffusion, ..Clpv::default() };
    let found =
        mean(&of(&|stage| stage.clpv(Vec3::Y, diffusion.clone())).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    assert!(found > 0.1 * wanted && found < 4.0 * wanted, "{found} diffused, {wanted} expected");
}

/// A closed room is as bright with particles as with a light of their power in their middle, all bounces included.
#[test]
fn a_room_is_as_bright_as_under_a_sphere_light() {
    let gpu = gpu();
    let room = || {
        let mut stage = Stage::new(Vec3::new(0.0, -0.9, -0.4), Vec3::new(0.0, -0.9, -2.0), 32);
        stage.add_room(Vec3::splat(-1.5), Vec3::splat(3.0), Vec3::splat(0.6));
        stage
    };
    let particles = cloud();
    let mut with_particles = room();
    add(&mut with_particles, particles, Vec3::Y * 0.5, 1.0);
    let mut with_light = room();
    let light = Vec3::splat(intensity(&particles));
    with_light.light(LightShape::Sphere { radius: 0.2 }, light, Vec3::Y * 0.5, Vec3::NEG_Y);
    let wanted = mean_traced(&trace(&gpu, &with_light, 256));
    let traced = mean_traced(&trace(&gpu, &with_particles, 256));
    with_particles.clpv(Vec3::ZERO, Clpv::default());
    let drawn = mean(&with_particles.render(&gpu, GiMethod::CLPV, Layer::Total));
    println!("{wanted} under the light, {traced} traced, {drawn} drawn");
    assert!((traced / wanted - 1.0).abs() < 0.04, "{traced} traced, {wanted} under the light");
    assert!((drawn / wanted - 1.0).abs() < 0.06, "{drawn} drawn, {wanted} under the light");
}

/// One particle before black, and the light of its disc: the sum over pixels of radiance times solid angle.
#[test]
fn a_disc_is_as_bright_as_its_sphere_however_small() {
    let gpu = gpu();
    for (radius, bound) in [(2e-4_f32, 0.05), (4e-3, 0.05), (0.02, 0.03), (0.2, 0.03)] {
        let particles = Particles { rate: 1.0, source: Vec3::ZERO, radius, end_radius: radius, ..cloud() };
        let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 64);
        add(&mut stage, particles, Vec3::new(0.13, 0.071, -2.0), 0.5);
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        let solid_angle = |x: u32, y: u32| {
            let cosine = stage.ray(x, y).dot(Vec3::NEG_Z);
            (2.0 / 64.0_f32).powi(2) * cosine.powi(3)
        };
        let flux: f32 = (0..64)
            .flat_map(|y| (0..64).map(move |x| (x, y)))
            .map(|(x, y)| rgb(&image, x, y).x * solid_angle(x, y))
            .sum();
        let distance = Vec3::new(0.13, 0.071, -2.0).length();
        let wanted = intensity(&particles) / distance / distance;
        assert!((flux / wanted - 1.0).abs() < bound, "radius {radius}: {flux}, {wanted} expected");
        assert!(stage.render(&gpu, GiMethod::NONE, Layer::Indirect).rgba.iter().all(|pixel| pixel[0] == 0.0));
    }
}

/// A wall through the middle of a particle hides half of it, and one before it all.
#[test]
fn surfaces_hide_particles_softly() {
    let gpu = gpu();
    let sum = |wall: f32| {
        let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 64);
        let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        let plane = Shape::Plane { size: [9.0, 9.0], subdivisions: [1, 1] };
        stage.add(plane, Vec3::ZERO, Affine3A::from_rotation_translation(turn, Vec3::NEG_Z * wall));
        let particles = Particles { rate: 1.0, source: Vec3::ZERO, radius: 0.1, end_radius: 0.1, ..cloud() };
        add(&mut stage, particles, Vec3::NEG_Z * 2.0, 0.5);
        mean(&stage.render(&gpu, GiMethod::NONE, Layer::Total))
    };
    let whole = sum(3.0);
    assert!((sum(2.0) / whole - 0.5).abs() < 0.02, "{} of {whole}", sum(2.0));
    assert_eq!(sum(1.0), 0.0);
}

/// Scenes without particles have no pass for them.
#[test]
fn no_particles_no_pass() {
    let gpu = gpu();
    let mut stage = floor();
    stage.clpv(Vec3::Y, Clpv::default());
    let names = |stage: &Stage| {
        let mut renderer = Renderer::new(&gpu);
        renderer.set_audit(true);
        let settings = RenderSettings { gi: GiMethod::CLPV, ..RenderSettings::default() };
        let (_, report) = stage.render_with(&gpu, &mut renderer, &settings);
        report.passes.iter().map(|pass| pass.name.clone()).collect::<Vec<_>>()
    };
    assert!(names(&stage).iter().all(|name| name != "particle discs"));
    add(&mut stage, cloud(), Vec3::Y * HEIGHT, 0.0);
    assert!(names(&stage).iter().any(|name| name == "particle discs"));
}

/// Time moves particles alone: what cameras and lights see of surfaces stays as it is.
#[test]
fn time_draws_no_surface_again() {
    let gpu = gpu();
    let mut world = GameWorld::new();
    let mut add = |name: &str, at: Vec3, component: &mut dyn FnMut(&mut bevy_ecs::world::EntityWorldMut)| {
        let entity = world.spawn(name, None);
        let mut entity = world.ecs.entity_mut(entity);
        entity.insert(Transform::from_translation(at));
        component(&mut entity);
    };
    let mesh = Arc::new(Shape::Plane { size: [4.0, 4.0], subdivisions: [1, 1] }.mesh().expect("a valid shape"));
    let material = Arc::new(Material::diffuse("floor", Vec3::splat(0.5)));
    let floor = MeshRenderer { mesh, material, casts_shadow: true, visible: true };
    add("floor", Vec3::NEG_Y, &mut |entity| {
        entity.insert(floor.clone());
    });
    add("lamp", Vec3::Y, &mut |entity| {
        entity.insert(Light { indirect: false, ..Light::default() });
    });
    add("eye", Vec3::Z * 2.0, &mut |entity| {
        entity.insert(Camera::default());
    });
    add("fire", Vec3::ZERO, &mut |entity| {
        entity.insert(Particles::default());
    });
    let (mut extractor, mut scene, mut renderer) = (Extractor::new(), Scene::default(), Renderer::new(&gpu));
    let mut ran = |seconds: f64| {
        world.set_seconds(seconds);
        world.update();
        extractor.extract(&mut world, &mut scene);
        let view = SceneView { camera: scene.cameras[0].clone(), size: [16, 16], jitter: [0.0; 2] };
        let settings = RenderSettings { gi: GiMethod::NONE, ..RenderSettings::default() };
        let report = renderer.render(&gpu, &scene, &view, &settings).unwrap_or_else(|error| panic!("{error}"));
        let of = |name: &str| report.passes.iter().any(|pass| pass.name.starts_with(name) && report.ran(&pass.name));
        ["gbuffer", "shadow", "particle discs"].map(of)
    };
    assert_eq!(ran(0.0), [true, true, true]);
    assert_eq!(ran(0.1), [false, false, true]);
    assert_eq!(ran(0.1), [false, false, false]);
}
