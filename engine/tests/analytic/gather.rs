//! The final gather of the sweep transport: against formulas and the path tracer, and what it does not need.

mod points;

use crate::support::{Stage, error, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{AlphaMode, Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::{Counts, FrameReport, PassState};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, CellSize, Clpv, GatherRays, Quality};
use std::f32::consts::PI;

fn settings(bounces: Bounces) -> Clpv {
    Clpv { bounces, quality: Quality::Low, gather_rays: GatherRays::Count(8), ..Default::default() }
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|p| p[0]).sum::<f32>() / image.rgba.len() as f32
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::CLPV, Layer::Indirect)
}

/// Mean of 16 images, each with rays of its own, over the area of the pixels as the path tracer has it.
fn averaged(gpu: &Gpu, mut stage: Stage) -> ImageF32 {
    let count = 16;
    let mut image = |index: u8| {
        stage.view.jitter = [index % 4, index / 4].map(|place| (f32::from(place) + 0.5) / 4.0 - 0.5);
        indirect(gpu, &stage)
    };
    let mut sum = image(0);
    for index in 1..count {
        let next = image(index);
        sum.rgba.iter_mut().zip(&next.rgba).for_each(|(a, b)| (0..3).for_each(|c| a[c] += b[c]));
    }
    sum.rgba.iter_mut().for_each(|pixel| pixel.iter_mut().for_each(|value| *value /= f32::from(count)));
    sum
}

/// A lamp in a closed room of 4 m with a box in it.
fn room(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 64);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    let small = Shape::Box { size: [0.5, 0.9, 0.5] };
    stage.add(small, Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(-0.9, -1.5, -0.8)));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn traced(gpu: &Gpu, stage: &Stage, bounces: u32) -> Image {
    traced_with(gpu, stage, bounces, 256)
}

fn traced_with(gpu: &Gpu, stage: &Stage, bounces: u32, samples: u32) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: Some(bounces), seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("a scene that can be traced");
    tracer.advance(gpu, samples).expect("a device");
    let estimate = tracer.estimate(gpu).expect("an image");
    let [even, odd] = &estimate.indirect;
    let mut image = even.clone();
    for (pixel, other) in image.pixels_mut().iter_mut().zip(odd.pixels()) {
        (0..3).for_each(|channel| pixel[channel] = 0.5 * (pixel[channel] + other[channel]));
    }
    image
}

fn ran(report: &FrameReport) -> Vec<&str> {
    report.passes.iter().filter(|pass| pass.state == PassState::Ran).map(|pass| pass.name.as_str()).collect()
}

/// A sphere of albedo ½ around a light of intensity π: the first bounce brings ¼ of the radiance, see the path tracer's
/// test.
#[test]
fn furnace_inside_a_sphere() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.3), Vec3::ZERO, 32);
    let mut material = Material::diffuse("inside", Vec3::splat(0.5));
    material.double_sided = true;
    let sphere = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
    stage.add_material(sphere, material, Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(PI), Vec3::ZERO, Vec3::Y);
    stage.clpv(Vec3::ZERO, settings(Bounces::Count(1)));
    let found = mean(&indirect(&gpu, &stage));
    assert!((found / 0.25 - 1.0).abs() < 5e-3, "{found}");
}

/// A white convex body under an open sky of radiance 1 looks as bright as the sky.
#[test]
fn furnace_under_the_sky() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 2.5), Vec3::ZERO, 33);
    stage.add(Shape::Sphere { radius: 1.0, segments: 128, rings: 64 }, Vec3::ONE, Affine3A::IDENTITY);
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::ZERO, settings(Bounces::Count(1)));
    let image = indirect(&gpu, &stage);
    let found = crate::support::rgb(&image, 16, 16);
    assert!((found - Vec3::ONE).abs().max_element() < 0.01, "{found}");
}

/// Things that are smaller than a cell, near the camera.
fn cluttered(settings: Clpv) -> Stage {
    let mut stage = room(settings);
    for index in 0..25_u8 {
        let at = Vec3::new(-1.2 + 0.3 * f32::from(index % 5), -1.9, -1.2 + 0.3 * f32::from(index / 5));
        stage.add(Shape::Box { size: [0.12, 0.2, 0.12] }, Vec3::splat(0.8), Affine3A::from_translation(at));
    }
    let eye = Stage::new(Vec3::new(0.4, -0.9, 0.5), Vec3::new(-0.7, -1.9, -0.7), 64);
    stage.view = eye.view;
    stage
}

#[test]
fn one_bounce_is_that_of_the_path_tracer_and_nearer_than_the_volumes() {
    let gpu = gpu();
    // Where nothing is smaller than a cell the volumes are good, and the filter's blur counts.
    for (scene, most) in [(room as fn(Clpv) -> Stage, 1.5), (cluttered, 0.6)] {
        let stage = scene(Clpv { gather_filter: 4, ..settings(Bounces::Count(1)) });
        let expected = traced(&gpu, &stage, 1);
        let (nrmse, bias) = error(&averaged(&gpu, stage), &expected);
        let looked_up = scene(Clpv { gather_rays: GatherRays::Count(0), ..settings(Bounces::Count(1)) });
        let (volumes, _) = error(&averaged(&gpu, looked_up), &expected);
        assert!(bias.abs() < 0.01, "bias {bias}");
        assert!(nrmse < most * volumes, "gathered {nrmse}, looked up {volumes}");
    }
}

#[test]
fn two_bounces_are_those_of_the_path_tracer() {
    let gpu = gpu();
    let stage = room(settings(Bounces::Count(2)));
    let (nrmse, bias) = error(&indirect(&gpu, &stage), &traced(&gpu, &stage, 2));
    assert!(nrmse < 0.08 && bias.abs() < 0.02, "nrmse {nrmse}, bias {bias}");
}

/// White cubes in the sun, a cell high and a cell apart.
fn cubes(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 2.2, 2.4), Vec3::new(0.0, 0.2, 0.0), 64);
    stage.add(Shape::Box { size: [4.0, 0.2, 4.0] }, Vec3::splat(0.8), Affine3A::from_translation(Vec3::NEG_Y * 0.1));
    for index in 0..16_u8 {
        let at = Vec3::new(-1.2 + 0.8 * f32::from(index % 4), 0.2, -1.2 + 0.8 * f32::from(index / 4));
        stage.add(Shape::Box { size: [0.4; 3] }, Vec3::splat(0.8), Affine3A::from_translation(at));
    }
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::new(-0.6, -1.0, 0.2).normalize());
    stage.clpv(Vec3::new(0.0, 0.8, 0.0), Clpv { cells: [12, 6, 12], cell_size: CellSize::Meters(0.4), ..settings });
    stage
}

/// Between the cubes the volumes know little light: rays go on from there.
#[test]
fn all_bounces_are_right_where_surfaces_are_nearer_than_cells() {
    let gpu = gpu();
    let stage = || cubes(Clpv { gather_filter: 0, ..settings(Bounces::Converged) });
    let (nrmse, bias) = error(&averaged(&gpu, stage()), &traced(&gpu, &stage(), 16));
    // Looked up where the first rays end it would be −.22.
    assert!(nrmse < 0.5 && bias.abs() < 0.09, "nrmse {nrmse}, bias {bias}");
}

/// A rough metal floor and a glossy box reflect what the rays find.
#[test]
fn glossy_surfaces_reflect_as_in_the_path_tracer() {
    let gpu = gpu();
    let mut stage = room(settings(Bounces::Count(1)));
    let metal =
        Material { metallic: 1.0, roughness: 0.4, specular: 1.0, ..Material::diffuse("metal", Vec3::splat(0.8)) };
    let floor = Affine3A::from_translation(Vec3::new(0.0, -1.95, 0.0));
    stage.add_material(Shape::Box { size: [3.9, 0.1, 3.9] }, metal, floor);
    let expected = traced(&gpu, &stage, 1);
    let (nrmse, bias) = error(&indirect(&gpu, &stage), &expected);
    assert!(nrmse < 0.15 && bias.abs() < 0.03, "nrmse {nrmse}, bias {bias}");
}

#[test]
fn what_is_gathered_needs_no_sweep_and_one_bounce_no_patches() {
    let gpu = gpu();
    for bounces in 1..=3 {
        let stage = room(settings(Bounces::Count(bounces)));
        let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
        let sweeps = ran(&report).iter().filter(|name| name.starts_with("sweep, cascade")).count();
        assert!(report.ran("gather") && !report.ran("relight") && !report.ran("gloss"), "{report}");
        assert_eq!((sweeps, report.ran("radiosity")), (0, bounces > 1), "{report}");
    }
    let (_, report) = room(Clpv { gather_rays: GatherRays::Count(0), ..settings(Bounces::Count(1)) }).render_with(
        &gpu,
        &mut Renderer::new(&gpu),
        &RenderSettings::default(),
    );
    assert!(!report.ran("gather") && report.ran("relight"), "{report}");
}

#[test]
fn nothing_is_gathered_twice_and_reuse_changes_no_bit() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(settings(Bounces::Count(2)));
    let draw = |renderer: &mut Renderer, stage: &Stage| stage.render_with(&gpu, renderer, &RenderSettings::default());
    let (first, _) = draw(&mut renderer, &stage);
    let (again, report) = draw(&mut renderer, &stage);
    assert_eq!(report.ran_count(), 0, "{report}");
    assert_eq!(first, again);
    stage.view.camera.world_from_view.translation.x -= 0.2;
    let (moved, report) = draw(&mut renderer, &stage);
    assert!(report.ran("gather"), "{report}");
    assert!(!ran(&report).iter().any(|name| name.starts_with("sweep") || name.starts_with("rsm")), "{report}");
    assert_eq!(moved, stage.render(&gpu, GiMethod::CLPV, Layer::Total));
    stage.scene.lights[0].intensity *= 0.5;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    let (dimmed, report) = draw(&mut renderer, &stage);
    assert!(report.ran("gather"), "{report}");
    assert_eq!(dimmed, stage.render(&gpu, GiMethod::CLPV, Layer::Total));
}

/// Rays and cells follow from the quality.
#[test]
fn the_quality_chooses_rays_and_volumes() {
    let gpu = gpu();
    let counts = |quality, gather_rays| {
        let stage = room(Clpv { quality, gather_rays, ..Clpv::default() });
        let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
        let sum = |name: &str, of: fn(&Counts) -> u64| {
            report.passes.iter().filter(|pass| pass.name.starts_with(name)).map(|pass| of(&pass.counts)).sum::<u64>()
        };
        (sum("gather", |counts| counts.paths), sum("sweep", |counts| counts.cells))
    };
    let pixels = 64 * 64;
    let (rays, cells) = counts(Quality::Low, GatherRays::Auto);
    assert!(rays == 0 && cells > 0);
    // Nothing reads the volumes where rays gather.
    assert_eq!(counts(Quality::Medium, GatherRays::Auto), (4 * pixels, 0));
    assert_eq!(counts(Quality::Low, GatherRays::Count(2)), (2 * pixels, 0));
    assert!(counts(Quality::Medium, GatherRays::Count(0)).1 > cells);
    assert_eq!(counts(Quality::High, GatherRays::Auto).0, 8 * pixels);
}

#[test]
fn light_scales_exactly_and_none_is_none() {
    let gpu = gpu();
    let mut stage = room(settings(Bounces::Converged));
    let one = indirect(&gpu, &stage);
    stage.scene.lights[0].intensity *= 2.0;
    let two = indirect(&gpu, &stage);
    for (a, b) in one.rgba.iter().zip(&two.rgba) {
        assert_eq!(a.map(|value| 2.0 * value)[..3], b[..3]);
    }
    stage.scene.lights[0].intensity = Vec3::ZERO;
    assert!(indirect(&gpu, &stage).rgba.iter().all(|pixel| pixel[..3] == [0.0; 3]));
}

/// What was drawn before leaves no trace: a hierarchy that followed what moved has other leaves than a new one.
#[test]
fn a_frame_depends_on_its_scene_alone() {
    let gpu = gpu();
    let mut stage = room(settings(Bounces::Count(2)));
    let at = |x: f32, y: f32, z: f32| Affine3A::from_translation(Vec3::new(x, y, z));
    let mut glass = Material::diffuse("glass", Vec3::new(0.9, 0.2, 0.2));
    (glass.alpha_mode, glass.base_color.w) = (AlphaMode::Blend, 0.5);
    stage.add_material(Shape::Box { size: [1.0, 1.0, 0.02] }, glass, at(0.2, -0.6, -0.9));
    for index in 0..5_u8 {
        let glow = Material { emissive: Vec3::new(2.0, 3.0, 1.0), ..Material::diffuse("glow", Vec3::ZERO) };
        let size = [0.1 + 0.1 * f32::from(index), 0.1, 0.1];
        stage.add_material(Shape::Box { size }, glow, at(-1.5 + 0.6 * f32::from(index), -1.8, 0.4));
    }
    let draw = |renderer: &mut Renderer, stage: &Stage| stage.render_with(&gpu, renderer, &RenderSettings::default()).0;
    let mut renderer = Renderer::new(&gpu);
    draw(&mut renderer, &stage);
    let moving = stage.scene.primitives.last_mut().expect("a box");
    moving.world_from_object = at(-1.6, 1.6, -1.5);
    moving.bounds = moving.mesh.bounds.transformed(&moving.world_from_object);
    moving.geometry_revision += 1;
    stage.scene.revisions.geometry += 1;
    let followed = draw(&mut renderer, &stage);
    assert_eq!(followed, draw(&mut Renderer::new(&gpu), &stage));
}

#[test]
fn shifted_images_have_rays_of_their_own() {
    let gpu = gpu();
    let stage = room(Clpv { gather_rays: GatherRays::Count(1), gather_filter: 0, ..settings(Bounces::Count(1)) });
    let expected = traced(&gpu, &stage, 1);
    let one = error(&indirect(&gpu, &stage), &expected).0;
    // Noise falls with the root of the number of rays, or faster.
    let sixteen = error(&averaged(&gpu, stage), &expected).0;
    assert!(sixteen < 0.4 * one, "noise of one image {one}, of sixteen {sixteen}");
}

#[test]
fn a_scene_too_large_for_rays_is_looked_up_and_says_so() {
    let mut gpu = gpu();
    let stage = room(settings(Bounces::Count(1)));
    let looked_up = room(Clpv { gather_rays: GatherRays::Count(0), ..settings(Bounces::Count(1)) });
    let expected = indirect(&gpu, &looked_up);
    // Less than one material takes.
    gpu.limits.max_storage_buffer_binding_size = 64;
    let mut renderer = Renderer::new(&gpu);
    let settings = RenderSettings { only: Layer::Indirect, ..RenderSettings::default() };
    let (found, report) = stage.render_with(&gpu, &mut renderer, &settings);
    let pass = report.pass("gather").expect("a line in the report");
    assert!(pass.state != PassState::Ran && pass.why.contains("MiB"), "{report}");
    assert_eq!(found, expected);
}

/// The more images are averaged, the less each of them is filtered.
#[test]
fn the_filter_is_narrower_where_many_images_are_averaged() {
    let gpu = gpu();
    let image = |gather_filter, images| {
        let stage = room(Clpv { gather_filter, ..settings(Bounces::Count(1)) });
        let settings = RenderSettings { only: Layer::Indirect, images, ..RenderSettings::default() };
        stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).0
    };
    assert_eq!(image(8, 8), image(4, 1));
    assert_eq!(image(8, 1000), image(0, 1));
    assert_ne!(image(8, 1), image(8, 8));
}

/// A bright panel three centimetres before a wall: the light of its rim changes over that distance, which few rays tell.
fn panel(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.3, 0.1, 1.2), Vec3::new(0.0, 0.0, -2.0), 96);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    let glow = Material { emissive: Vec3::splat(20.0), ..Material::diffuse("glow", Vec3::splat(0.5)) };
    stage.add_material(
        Shape::Box { size: [0.8, 0.5, 0.04] },
        glow,
        Affine3A::from_translation(Vec3::new(0.0, 0.0, -1.95)),
    );
    stage.clpv(Vec3::ZERO, settings);
    stage
}

/// Across the rim of something that glows the filter would spread light by many times what is there.
#[test]
fn the_filter_keeps_the_bright_rim_beside_what_glows() {
    let gpu = gpu();
    let with = |gather_filter, rays| {
        panel(Clpv { gather_filter, gather_rays: GatherRays::Count(rays), ..settings(Bounces::Count(1)) })
    };
    let best = averaged(&gpu, with(0, 16));
    let expected = Image::from_rgba(best.width, best.height, &best.rgba).expect("an image");
    // The same pixel grids, so that edges are alike.
    let [(noise, _), (nrmse, bias)] = [0, 8].map(|filter| error(&averaged(&gpu, with(filter, 2)), &expected));
    assert!(nrmse < noise && bias.abs() < 0.03, "filtered {nrmse}, as gathered {noise}, bias {bias}");
}

/// Above a metal floor a wall's rays end nearer than a patch is large, and go on from there as the metal reflects.
#[test]
fn walls_are_lit_by_the_metal_that_they_stand_on() {
    let gpu = gpu();
    let metal =
        Material { metallic: 1.0, roughness: 0.5, specular: 1.0, ..Material::diffuse("metal", Vec3::splat(0.9)) };
    let mut stage = room(Clpv { gather_filter: 2, ..settings(Bounces::Converged) });
    let floor = Affine3A::from_translation(Vec3::new(0.0, -1.95, 0.0));
    stage.add_material(Shape::Box { size: [3.98, 0.1, 3.98] }, metal, floor);
    stage.view = Stage::new(Vec3::new(0.6, -1.6, -1.3), Vec3::new(0.6, -1.75, -2.0), 48).view;
    let expected = traced_with(&gpu, &stage, 64, 1024);
    let (nrmse, bias) = error(&averaged(&gpu, stage), &expected);
    assert!(nrmse < 0.06 && bias.abs() < 0.01, "nrmse {nrmse}, bias {bias}");
}

/// Rays that go on as paths need nothing that is kept at surfaces, and bring all bounces.
#[test]
fn paths_have_the_mean_of_the_path_tracer_and_no_patches() {
    let gpu = gpu();
    let paths = |bounces| Clpv { gather_rays: GatherRays::Paths(8), ..settings(bounces) };
    for (bounces, limit) in [(Bounces::Converged, 64), (Bounces::Count(3), 3), (Bounces::Count(1), 1)] {
        let stage = room(paths(bounces));
        let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
        assert!(report.ran("gather") && !report.ran("radiosity") && !report.ran("surfel links"), "{report}");
        let expected = traced(&gpu, &stage, limit);
        let (nrmse, bias) = error(&averaged(&gpu, stage), &expected);
        assert!(nrmse < 0.06 && bias.abs() < 0.005, "{bounces:?}: nrmse {nrmse}, bias {bias}");
    }
}
