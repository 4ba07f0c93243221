//! Mirror reflections: against formulas and the path tracer, over frames of a moving camera, and what they do not need.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Quat, Vec3, Vec4};
use lightwell::assets::{AssetId, Material, Sampling, Shape, Texture};
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, SceneView};
use lightwell::world::{Bounces, Clpv, GatherRays, Quality};
use std::f32::consts::PI;
use std::sync::Arc;

const EDGE: u32 = 64;

fn metal(reflectance: f32, roughness: f32) -> Material {
    let base_color = Vec3::splat(reflectance).extend(1.0);
    Material { base_color, metallic: 1.0, roughness, ..Material::new("metal") }
}

fn medium() -> Clpv {
    Clpv { quality: Quality::Medium, ..Default::default() }
}

fn plane(size: f32) -> Shape {
    Shape::Plane { size: [size; 2], subdivisions: [1, 1] }
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::CLPV, Layer::Indirect)
}

/// Mean of images with rays of their own, shifted by parts of a pixel.
fn mean_of(gpu: &Gpu, stage: &Stage, shifts: impl ExactSizeIterator<Item = [f32; 2]>) -> ImageF32 {
    let count = shifts.len() as f32;
    let images = shifts.map(|jitter| {
        let mut renderer = Renderer::new(gpu);
        let view = SceneView { jitter, ..stage.view.clone() };
        let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
        renderer.render(gpu, &stage.scene, &view, &settings).expect("a frame");
        read_texture_f32(gpu, renderer.radiance().expect("an image")).expect("readable")
    });
    let sum = images.reduce(|mut sum, next| {
        sum.rgba.iter_mut().zip(&next.rgba).for_each(|(a, b)| (0..3).for_each(|c| a[c] += b[c]));
        sum
    });
    let mut mean = sum.expect("images");
    mean.rgba.iter_mut().for_each(|pixel| pixel.iter_mut().for_each(|value| *value /= count));
    mean
}

/// Mean of 16 images over the area of the pixels, as the path tracer has it.
fn averaged(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    let place = |index: u8| (f32::from(index) + 0.5) / 4.0 - 0.5;
    mean_of(gpu, stage, (0..16_u8).map(|index| [index % 4, index / 4].map(place)))
}

/// Mean of 8 images with rays of their own, all at the centres of the pixels but for a hundredth.
fn averaged_at_centres(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    mean_of(gpu, stage, (0..8_u8).map(|index| [f32::from(index) / 800.0, 0.0]))
}

fn traced(gpu: &Gpu, stage: &Stage, samples: u32) -> Image {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, &TraceSettings { bounces: None, seed: 3 }).expect("a scene");
    tracer.advance(gpu, samples).expect("a device");
    tracer.estimate(gpu).expect("an image").indirect()
}

/// Schlick's reflectance of a metal towards a ray that meets a floor.
fn reflectance(normal: f32, ray: Vec3) -> f32 {
    normal + (1.0 - normal) * (1.0 + ray.y).powi(5)
}

/// Where a ray from the eye meets the ceiling at that height by way of a floor at zero.
fn mirrored_place(stage: &Stage, x: u32, y: u32, height: f32) -> (Vec3, Vec3) {
    let eye = Vec3::from(stage.view.camera.world_from_view.translation);
    let ray = stage.ray(x, y);
    let on_floor = eye + ray * (eye.y / -ray.y);
    let up = Vec3::new(ray.x, -ray.y, ray.z);
    (ray, on_floor + up * (height / up.y))
}

/// A mirror under a sky of radiance ½ with a panel of radiance 3 shows each of them, times its reflectance.
#[test]
fn a_mirror_shows_panel_and_sky_where_they_are() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 1.2), Vec3::new(0.0, 0.0, -0.2), EDGE);
    stage.add_material(plane(20.0), metal(0.8, 0.0), Affine3A::IDENTITY);
    let panel = Material { emissive: Vec3::splat(3.0), double_sided: true, ..Material::diffuse("panel", Vec3::ZERO) };
    stage.add_material(plane(1.0), panel, Affine3A::from_translation(Vec3::new(0.0, 1.5, -1.5)));
    stage.scene.sky = Vec3::splat(0.5);
    stage.clpv(Vec3::ZERO, medium());
    let image = indirect(&gpu, &stage);
    let (mut on_panel, mut on_sky) = (0, 0);
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        if stage.ray(x, y).y > -0.3 {
            continue;
        }
        let (ray, place) = mirrored_place(&stage, x, y, 1.5);
        let off = (place - Vec3::new(0.0, 1.5, -1.5)).abs() - 0.5;
        let outside = off.x.max(off.z);
        let radiance = if outside < 0.0 { 3.0 } else { 0.5 };
        // Not beside the panel's edge, nor where the eye sees it straight.
        if outside.abs() < 0.08 {
            continue;
        }
        let (found, expected) = (rgb(&image, x, y).x, radiance * reflectance(0.8, ray));
        assert!((found / expected - 1.0).abs() < 0.01, "pixel {x}, {y}: {found} where {expected} is right");
        *(if outside < 0.0 { &mut on_panel } else { &mut on_sky }) += 1;
    }
    assert!(on_panel > 30 && on_sky > 500, "{on_panel} pixels of the panel, {on_sky} of the sky");
}

/// What a directional light of irradiance E sends to a ceiling is ρE·cos θ/π in the mirror, times its reflectance.
#[test]
fn what_lights_shine_on_is_seen_in_a_mirror() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, -0.4), 32);
    stage.add_material(plane(2.0), metal(0.9, 0.02), Affine3A::IDENTITY);
    let down = Affine3A::from_rotation_translation(Quat::from_rotation_x(PI), Vec3::new(0.0, 3.0, 0.0));
    stage.add(plane(40.0), Vec3::splat(0.4), down);
    // From below, past the mirror.
    let toward = Vec3::new(2.0, 1.0, 0.0).normalize();
    stage.light(LightShape::Directional, Vec3::splat(5.0), Vec3::ZERO, toward);
    stage.clpv(Vec3::ZERO, Clpv { bounces: Bounces::Count(1), ..medium() });
    let image = indirect(&gpu, &stage);
    for (x, y) in [(8, 20), (16, 20), (24, 24), (16, 28)] {
        let (ray, place) = mirrored_place(&stage, x, y, 3.0);
        // The mirror's own shadow lies to the right.
        let shade = place - toward * (place.y / toward.y);
        assert!(shade.x < -1.0, "the place lies in the shadow of the mirror");
        let expected = 0.4 * 5.0 * toward.y / PI * reflectance(0.9, ray);
        let found = rgb(&image, x, y).x;
        assert!((found / expected - 1.0).abs() < 0.01, "pixel {x}, {y}: {found} where {expected} is right");
    }
}

/// A room below a panel that shines, with mirrors on two walls that face each other, and a smooth ball.
fn hall(clpv: Clpv, roughness: f32) -> Stage {
    let mut stage = flat_hall(clpv, roughness);
    let ball = Shape::Sphere { radius: 0.6, segments: 64, rings: 32 };
    stage.add_material(ball, metal(0.8, roughness), Affine3A::from_translation(Vec3::new(-0.4, -1.4, -0.6)));
    stage
}

/// The same without the ball.
fn flat_hall(clpv: Clpv, roughness: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.9, 0.3, 1.6), Vec3::new(-0.6, -0.5, -0.8), EDGE);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    for side in [-1.0, 1.0] {
        let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::new(-side, 0.0, 0.0));
        stage.add_material(
            plane(2.0),
            metal(0.9, roughness),
            Affine3A::from_rotation_translation(turn, Vec3::new(1.98 * side, 0.0, -0.4)),
        );
    }
    stage.add(
        Shape::Box { size: [0.6, 1.0, 0.6] },
        Vec3::new(0.1, 0.3, 0.8),
        Affine3A::from_translation(Vec3::new(0.9, -1.5, -1.2)),
    );
    // Large and dim, so that edges of its image count for little. Not a point light, whose highlights in mirrors are noise of the path tracer without end.
    let panel = Material { emissive: Vec3::splat(1.0), ..Material::diffuse("panel", Vec3::ZERO) };
    let down = Affine3A::from_rotation_translation(Quat::from_rotation_x(PI), Vec3::new(0.0, 1.95, 0.0));
    stage.add_material(plane(3.6), panel, down);
    stage.clpv(Vec3::ZERO, clpv);
    stage
}

#[test]
fn facing_mirrors_end_in_what_the_path_tracer_finds() {
    let gpu = gpu();
    let off = Clpv { mirror_rays: GatherRays::Count(0), ..medium() };
    for roughness in [0.05, 0.2] {
        let stage = hall(medium(), roughness);
        let truth = traced(&gpu, &stage, 512);
        let (found, bias) = error(&averaged(&gpu, &stage), &truth);
        let (without, _) = error(&averaged(&gpu, &hall(off.clone(), roughness)), &truth);
        println!("roughness {roughness}: error {found}, bias {bias}; {without} without rays of their own");
        assert!(found < 0.12 && bias.abs() < 0.03, "error {found}, bias {bias}");
        assert!(found < without, "error {found} against {without} without rays of their own");
    }
}

/// What a polished white surface reflects diffusely is no part of what it mirrors, and the other way round: in even light both
/// together are as bright as that, less the few per cent that Schlick's term takes from light that arrives at a slant.
#[test]
fn furnace_of_lacquer() {
    let gpu = gpu();
    for roughness in [0.05, 0.2] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 2.5), Vec3::ZERO, 33);
        let lacquer = Material { base_color: Vec4::ONE, roughness, ..Material::new("lacquer") };
        let ball = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
        stage.add_material(ball, Material { metallic: 0.0, ..lacquer }, Affine3A::IDENTITY);
        stage.scene.sky = Vec3::ONE;
        stage.clpv(Vec3::ZERO, medium());
        let image = indirect(&gpu, &stage);
        // The mean, since some of the noise is in few pixels; not of the rim, where the formula of glTF gains light.
        let pixels = (13..20).flat_map(|y| (13..20).map(move |x| (x, y)));
        let found = pixels.map(|(x, y)| rgb(&image, x, y).x).sum::<f32>() / 49.0;
        assert!((0.96..=1.005).contains(&found), "roughness {roughness}: {found}");
    }
}

/// Nothing is added to a furnace: bodies of metal that reflects all light, in even light, are as bright as that, but for what
/// single scattering between facets loses (less than 1 % up to this roughness).
#[test]
fn furnace_of_mirrors() {
    let gpu = gpu();
    for roughness in [0.0, 0.1, 0.25] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 2.5), Vec3::ZERO, 33);
        let ball = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
        stage.add_material(ball, metal(1.0, roughness), Affine3A::IDENTITY);
        stage.scene.sky = Vec3::ONE;
        stage.clpv(Vec3::ZERO, medium());
        let image = indirect(&gpu, &stage);
        for (x, y) in [(16, 16), (14, 18), (18, 13)] {
            let found = rgb(&image, x, y).x;
            assert!((0.98..=1.0005).contains(&found), "roughness {roughness}, pixel {x}, {y}: {found}");
        }
    }
}

/// A white plane beside a polished one under an even sky is as bright as elsewhere: the mirror, which has no diffuse light, is
/// not filtered into it.
#[test]
fn mirrors_do_not_darken_what_lies_beside_them() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 0.01), Vec3::ZERO, EDGE);
    stage.add(plane(4.0), Vec3::splat(0.8), Affine3A::from_translation(Vec3::new(-2.0, 0.0, 0.0)));
    stage.add_material(plane(4.0), metal(0.5, 0.1), Affine3A::from_translation(Vec3::new(2.0, 0.0, 0.0)));
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::ZERO, medium());
    let image = indirect(&gpu, &stage);
    // The image is seen from above, upside down: the white plane is on the right.
    for x in 33..44 {
        let found = rgb(&image, x, 32).x;
        assert!((found / 0.8 - 1.0).abs() < 0.01, "{x}: {found}");
    }
}

/// Black pillars behind the camera, which the mirror before it shows.
fn hall_of_pillars(clpv: Clpv, roughness: f32) -> Stage {
    let mut stage = flat_hall(clpv, roughness);
    for index in 0..6_u8 {
        let at = Vec3::new(1.5, 0.0, -1.6 + 0.6 * f32::from(index));
        stage.add(Shape::Box { size: [0.2, 3.8, 0.25] }, Vec3::splat(0.02), Affine3A::from_translation(at));
    }
    stage.view = Stage::new(Vec3::new(0.9, 0.3, 0.6), Vec3::new(-2.0, 0.1, -0.5), EDGE).view;
    stage
}

/// The last of twelve frames of a window whose camera moves.
fn moved(gpu: &Gpu, mut stage: Stage) -> (ImageF32, Stage) {
    let settings = RenderSettings { only: Layer::Indirect, display: false, average: true, ..Default::default() };
    let mut renderer = Renderer::new(gpu);
    let frames = (0..12).map(|_| {
        stage.view.camera.world_from_view.translation += glam::Vec3A::new(-0.04, 0.01, -0.02);
        stage.render_with(gpu, &mut renderer, &settings).0
    });
    (frames.last().expect("frames"), stage)
}

/// While the camera moves, mirrors show what they face now, far sharper than with the rays of the gather alone, whose history
/// is that of the surface; and rough ones have no more noise.
#[test]
fn a_moving_camera_sees_mirrors_as_they_are() {
    let gpu = gpu();
    for (roughness, most) in [(0.05, 0.75), (0.2, 1.0)] {
        let (found, stage) = moved(&gpu, hall_of_pillars(medium(), roughness));
        let off = Clpv { mirror_rays: GatherRays::Count(0), ..medium() };
        let (without, _) = moved(&gpu, hall_of_pillars(off, roughness));
        // Frames that stand for themselves, with many rays.
        let mut alone = hall_of_pillars(Clpv { quality: Quality::Ultra, ..Default::default() }, roughness);
        alone.view = stage.view;
        let truth = Image::from_rgba(EDGE, EDGE, &averaged_at_centres(&gpu, &alone).rgba).expect("a square image");
        let [(found, bias), (without, _)] = [found, without].map(|image| error(&image, &truth));
        println!("roughness {roughness}: error {found}, bias {bias}; {without} without rays of their own");
        assert!(found < most * without && bias.abs() < 0.04, "error {found}, bias {bias}; {without} without");
    }
}

/// A view that rests comes to a mean in which the noise of the rays is gone.
#[test]
fn mirrors_come_to_rest() {
    let gpu = gpu();
    let settings = RenderSettings { only: Layer::Indirect, display: false, average: true, ..Default::default() };
    let stage = hall(medium(), 0.2);
    let mut renderer = Renderer::new(&gpu);
    let mut drawn = stage.render_with(&gpu, &mut renderer, &settings);
    let first = drawn.0.clone();
    while renderer.is_settling() {
        drawn = stage.render_with(&gpu, &mut renderer, &settings);
    }
    // By itself: against the mean of many frames, which the filter changes as much.
    let many = mean_of(&gpu, &stage, (0..64_u8).map(|index| [f32::from(index) / 6400.0, 0.0]));
    let many = Image::from_rgba(EDGE, EDGE, &many.rgba).expect("a square image");
    let [noisy, calm] = [&first, &drawn.0].map(|image| error(image, &many).0);
    let truth = traced(&gpu, &stage, 1024);
    let [(first, _), (rested, bias)] = [first, drawn.0].map(|image| error(&image, &truth));
    println!("noise {noisy}, at rest {calm}; error {first}, at rest {rested}, bias {bias}");
    assert!(calm < 0.7 * noisy, "noise {noisy}, at rest {calm}");
    assert!(rested < 0.9 * first && bias.abs() < 0.03, "error {first}, at rest {rested}, bias {bias}");
}

#[test]
fn no_pass_runs_where_nothing_mirrors() {
    let gpu = gpu();
    let passes = |stage: &Stage| {
        let settings = RenderSettings { only: Layer::Indirect, display: false, ..Default::default() };
        let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
        ["mirror", "mirror filter"].map(|pass| report.ran(pass))
    };
    assert_eq!(passes(&hall(medium(), 0.2)), [true; 2]);
    assert_eq!(passes(&hall(medium(), 0.4)), [true; 2]);
    assert_eq!(passes(&hall(medium(), 0.5)), [false; 2]);
    assert_eq!(passes(&hall(Clpv { mirror_rays: GatherRays::Count(0), ..medium() }, 0.2)), [false; 2]);
    assert_eq!(passes(&hall(Clpv { quality: Quality::Low, ..Default::default() }, 0.2)), [false; 2]);
}

/// A room with a ball of rough metal, lit by what one small spot of the floor reflects.
fn room_with_a_bright_spot(roughness: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 2.0), Vec3::new(0.0, 0.8, 0.0), EDGE);
    stage.add_room(Vec3::new(-2.5, 0.0, -2.5), Vec3::new(5.0, 3.0, 5.0), Vec3::splat(0.5));
    let ball = Shape::Sphere { radius: 0.8, segments: 64, rings: 32 };
    stage.add_material(ball, metal(0.9, roughness), Affine3A::from_translation(Vec3::new(0.0, 0.9, 0.0)));
    let cone = LightShape::Spot { inner: 0.21, outer: 0.28 };
    stage.light(cone, Vec3::splat(60.0), Vec3::new(-1.6, 2.8, 1.6), Vec3::new(0.0, -1.0, 0.0));
    stage.clpv(Vec3::new(0.0, 1.5, 0.0), medium());
    stage
}

/// Whether a pixel shows nothing but the ball.
fn is_on_ball(stage: &Stage, x: u32, y: u32) -> bool {
    let eye = Vec3::from(stage.view.camera.world_from_view.translation);
    let to_middle = Vec3::new(0.0, 0.9, 0.0) - eye;
    let ray = stage.ray(x, y);
    to_middle.cross(ray).length() < 0.7
}

#[test]
fn rough_metal_shows_a_small_bright_spot_without_salt() {
    let gpu = gpu();
    let stage = room_with_a_bright_spot(0.2);
    let (one, many) = (indirect(&gpu, &stage), averaged_at_centres(&gpu, &stage));
    let on_ball = (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))).filter(|&(x, y)| is_on_ball(&stage, x, y));
    let pairs: Vec<_> = on_ball.map(|(x, y)| (rgb(&one, x, y).x, rgb(&many, x, y).x)).collect();
    let count = pairs.len() as f32;
    let mean = pairs.iter().map(|pair| pair.1).sum::<f32>() / count;
    let bias = pairs.iter().map(|pair| pair.0).sum::<f32>() / count / mean - 1.0;
    let off = (pairs.iter().map(|pair| (pair.0 - pair.1).powi(2)).sum::<f32>() / count).sqrt() / mean;
    println!("bias {bias}, off {off}");
    assert!(bias.abs() < 0.08 && off < 0.45, "bias {bias}, off {off}");
}

/// What a metal of two colours reflects of even light is each of them up to their border: the filter leaves textures alone.
#[test]
fn textures_of_rough_metal_stay_sharp() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.5, 0.0), Vec3::ZERO, EDGE);
    let texture = Texture {
        id: AssetId::fresh(),
        name: "halves".into(),
        width: 2,
        height: 1,
        rgba: vec![255, 255, 255, 255, 60, 60, 60, 255],
        srgb: true,
        sampling: Sampling { nearest: true, ..Sampling::default() },
    };
    let halves = Material { base_color_texture: Some(Arc::new(texture)), ..metal(1.0, 0.4) };
    stage.add_material(plane(4.0), halves, Affine3A::IDENTITY);
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::ZERO, medium());
    let image = indirect(&gpu, &stage);
    let at = |x: u32| rgb(&image, x, EDGE / 2).x;
    let contrast = (at(28) / at(36)).max(at(36) / at(28));
    assert!(contrast > 5.0, "the halves differ by {contrast}");
    for (beside, inside) in [(EDGE / 2 - 1, EDGE / 2 - 8), (EDGE / 2, EDGE / 2 + 8)] {
        let (found, expected) = (at(beside), at(inside));
        assert!((found / expected - 1.0).abs() < 0.05, "pixel {beside}: {found} where {expected} is right");
    }
}
