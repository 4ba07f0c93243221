//! Light of the sky under methods that bring none of their own, and the sky's image in glossy surfaces.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape, SkyMap};
use lightwell::gpu::Gpu;
use lightwell::measure::{Image, compare};
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::world::{
    Clpv, InstantRadiosity, LightVisibility, Quality, StochasticLightCulling, Transport, VirtualPlacement,
};
use std::sync::Arc;

const NAMES: [&str; 3] = ["none", "diffusion", "light culling without rays"];

/// The stage under each method that has no light of the sky.
fn each_method(stage: &mut Stage, mut test: impl FnMut(&str, &Stage, GiMethod)) {
    stage.scene.sky_light = true;
    for name in NAMES {
        stage.scene.clpv = None;
        let gi = match name {
            "none" => GiMethod::NONE,
            "diffusion" => {
                stage.clpv(Vec3::ZERO, Clpv { transport: Transport::Diffusion, ..Clpv::default() });
                GiMethod::CLPV
            }
            _ => GiMethod::SLC,
        };
        test(name, stage, gi);
    }
}

fn set_sky(stage: &mut Stage, map: SkyMap) {
    stage.scene.sky = map.mean();
    stage.scene.sky_map = Some(Arc::new(map));
    stage.scene.revisions.settings += 1;
}

fn floor(albedo: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 16);
    stage.add(Shape::Plane { size: [8.0; 2], subdivisions: [1; 2] }, Vec3::splat(albedo), Affine3A::IDENTITY);
    stage
}

fn drawn(gpu: &Gpu, stage: &Stage, gi: GiMethod, layer: Layer) -> Image {
    let image = stage.render(gpu, gi, layer);
    Image::from_rgba(image.width, image.height, &image.rgba).unwrap()
}

/// A white floor under an even sky is as bright as the sky, whatever the method.
#[test]
fn white_floor_under_an_even_sky() {
    let gpu = gpu();
    let mut stage = floor(1.0);
    stage.scene.sky = Vec3::ONE;
    each_method(&mut stage, |name, stage, gi| {
        let mean = drawn(&gpu, stage, gi, Layer::Indirect).mean();
        println!("{name}: {mean:.4}");
        assert!((mean - 1.0).abs() < 0.02, "{name}: {mean}");
        let direct = drawn(&gpu, stage, gi, Layer::Direct).mean();
        assert_eq!(direct, 0.0, "{name}: the sky's light is no direct light");
    });
    stage.scene.sky_light = false;
    assert_eq!(drawn(&gpu, &stage, GiMethod::NONE, Layer::Total).mean(), 0.0, "switched off");
}

/// An open floor gets the integral of a sky with a bright side.
#[test]
fn as_integrated() {
    let gpu = gpu();
    let mut stage = floor(0.5);
    let map = SkyMap::gradient(Vec3::new(0.2, 0.5, 1.0), Vec3::new(1.0, 0.6, 0.3), Vec3::ZERO);
    let expected = map.irradiance(Vec3::Y) * 0.5 / std::f32::consts::PI;
    set_sky(&mut stage, map);
    each_method(&mut stage, |name, stage, gi| {
        let image = drawn(&gpu, stage, gi, Layer::Indirect);
        for c in 0..3 {
            let mean = image.pixels().iter().map(|p| p[c]).sum::<f32>() / image.pixels().len() as f32;
            assert!((mean / expected[c] - 1.0).abs() < 0.06, "{name}: {mean}, expected {expected}");
        }
    });
}

/// Methods with light of the sky of their own take it by direction, and not its mean.
#[test]
fn as_integrated_by_methods_that_shoot_or_cast_into_the_sky() {
    let gpu = gpu();
    let mut stage = floor(0.5);
    stage.scene.sky_light = true;
    let gradient = SkyMap::gradient(Vec3::new(0.2, 0.5, 1.0), Vec3::new(1.0, 0.6, 0.3), Vec3::ZERO);
    for (map, what) in [(gradient, "gradient"), (halves(), "image")] {
        let expected = map.irradiance(Vec3::Y) * 0.5 / std::f32::consts::PI;
        let of_mean = map.mean() * 0.5;
        assert!((of_mean / expected - 1.0).abs().max_element() > 0.12, "{what}: the mean would do");
        set_sky(&mut stage, map);
        let particles = InstantRadiosity { particles: 512, ..InstantRadiosity::default() };
        let of_maps = InstantRadiosity { placement: VirtualPlacement::Rsm, ..InstantRadiosity::default() };
        for (gi, vpl) in [(GiMethod::VPL, particles.clone()), (GiMethod::VPL, of_maps), (GiMethod::SLC, particles)] {
            let name = format!("{gi:?}, {:?}, {what}", vpl.placement);
            stage.scene.vpl = Some(vpl);
            let visibility = LightVisibility::ShadowRays;
            stage.scene.slc = Some(StochasticLightCulling { visibility, ..StochasticLightCulling::default() });
            let image = drawn(&gpu, &stage, gi, Layer::Indirect);
            for c in 0..3 {
                let mean = image.pixels().iter().map(|p| p[c]).sum::<f32>() / image.pixels().len() as f32;
                println!("{name}: {:.3} of what is expected", mean / expected[c]);
                assert!((mean / expected[c] - 1.0).abs() < 0.06, "{name}: {mean}, expected {expected}");
            }
        }
    }
}

/// A sky that turns keeps its mean, bit for bit, and all that it lights is redrawn.
#[test]
fn turned_skies_are_drawn_anew() {
    let gpu = gpu();
    let mut stage = floor(0.5);
    let wall = Affine3A::from_translation(Vec3::new(0.0, 0.3, -0.6));
    stage.add(Shape::Box { size: [2.0, 0.6, 0.2] }, Vec3::splat(0.5), wall);
    stage.scene.sky_light = true;
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Low, ..Clpv::default() });
    stage.scene.vpl = Some(InstantRadiosity { particles: 64, ..InstantRadiosity::default() });
    let visibility = LightVisibility::ShadowRays;
    stage.scene.slc = Some(StochasticLightCulling { visibility, ..StochasticLightCulling::default() });
    for gi in [GiMethod::NONE, GiMethod::CLPV, GiMethod::VPL, GiMethod::SLC] {
        let mut kept = Renderer::new(&gpu);
        let settings = RenderSettings { gi, only: Layer::Indirect, ..Default::default() };
        set_sky(&mut stage, halves());
        let (first, mean) = (stage.render_with(&gpu, &mut kept, &settings).0, stage.scene.sky);
        let turned = halves().varied(1.0, 2.0);
        assert_eq!(turned.mean(), mean);
        set_sky(&mut stage, turned);
        let second = stage.render_with(&gpu, &mut kept, &settings).0;
        let fresh = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).0;
        assert!(second.rgba == fresh.rgba, "{gi:?}: other than from nothing");
        assert!(second.rgba != first.rgba, "{gi:?}: the turn does not show");
    }
}

/// No sky is seen in a closed room, and its light does not get in.
#[test]
fn closed_rooms_stay_dark() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.2, 0.9), Vec3::new(0.0, 0.0, -1.0), 32);
    for axis in 0..3 {
        for side in [-1.1, 1.1] {
            let (mut at, mut size) = (Vec3::ZERO, Vec3::splat(2.4));
            (at[axis], size[axis]) = (side, 0.2);
            stage.add(Shape::Box { size: size.to_array() }, Vec3::splat(0.8), Affine3A::from_translation(at));
        }
    }
    stage.scene.sky = Vec3::ONE;
    each_method(&mut stage, |name, stage, gi| {
        let mean = drawn(&gpu, stage, gi, Layer::Indirect).mean();
        assert!(mean < 0.01, "{name}: {mean}");
    });
}

/// Methods with a sky of their own do not get it twice.
#[test]
fn counted_once() {
    let gpu = gpu();
    let mut stage = floor(1.0);
    stage.scene.sky = Vec3::ONE;
    stage.scene.sky_light = true;
    stage.clpv(Vec3::ZERO, Clpv::default());
    stage.scene.slc =
        Some(StochasticLightCulling { visibility: LightVisibility::ShadowRays, ..StochasticLightCulling::default() });
    for gi in [GiMethod::CLPV, GiMethod::VPL, GiMethod::SLC] {
        let mut renderer = Renderer::new(&gpu);
        let settings = RenderSettings { gi, only: Layer::Indirect, ..Default::default() };
        let (image, report) = stage.render_with(&gpu, &mut renderer, &settings);
        let mean = Image::from_rgba(image.width, image.height, &image.rgba).unwrap().mean();
        assert!((mean - 1.0).abs() < 0.05, "{gi:?}: {mean}");
        assert!(!report.passes.iter().any(|pass| pass.name.ends_with(", sky")), "{report}");
    }
}

/// A sky of two halves and a bright band, each easy to tell in a mirror.
fn halves() -> SkyMap {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("halves.exr");
    let pixel = |i: u32| match (i % 64, i / 64) {
        (_, 10..=13) => [3.0, 2.5, 2.0],
        (0..=31, _) => [0.9, 0.2, 0.1],
        _ => [0.1, 0.3, 0.8],
    };
    let image = Image::from_pixels(64, 32, (0..64 * 32).map(pixel).collect()).unwrap();
    lightwell::measure::write_image(&path, &image).unwrap();
    SkyMap::load(&path, 1.0, 0.4).unwrap()
}

/// The pixels that show what lies within a distance of the origin, without those at the outline.
fn within(image: &Image, stage: &Stage, distance: f32) -> Image {
    let [width, height] = stage.view.size;
    let eye = stage.view.eye();
    let keep = |(i, pixel): (usize, &[f32; 3])| {
        let ray = stage.ray(i as u32 % width, i as u32 / width);
        if eye.cross(ray).length() < distance { *pixel } else { [0.0; 3] }
    };
    Image::from_pixels(width, height, image.pixels().iter().enumerate().map(keep).collect()).unwrap()
}

/// Metals of several roughnesses show the image of the sky that the path tracer shows in them.
#[test]
fn metals_show_the_sky() {
    let gpu = gpu();
    for (roughness, most) in [(0.05, 0.12), (0.3, 0.2), (0.7, 0.12)] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.3, 1.4), Vec3::ZERO, 48);
        let material =
            Material { base_color: glam::Vec4::splat(0.9), metallic: 1.0, roughness, ..Material::new("metal") };
        let sphere = Shape::Sphere { radius: 1.0, segments: 64, rings: 32 };
        stage.add_material(sphere, material, Affine3A::IDENTITY);
        set_sky(&mut stage, halves());
        let mut tracer = PathTracer::new(&gpu);
        tracer.begin(&gpu, &stage.scene, &stage.view, &TraceSettings { bounces: Some(1), seed: 3 }).unwrap();
        tracer.advance(&gpu, 96).unwrap();
        let view = Stage::new(stage.view.eye(), Vec3::ZERO, 48);
        let truth = within(&tracer.estimate(&gpu).unwrap().indirect(), &view, 0.9);
        let check = |name: &str, image: &Image| {
            let found = compare(&within(image, &view, 0.9), &truth).unwrap();
            println!("roughness {roughness}, {name}: nrmse {:.3}, bias {:+.3}", found.nrmse, found.bias);
            assert!(found.nrmse < most && found.bias.abs() < 0.03, "roughness {roughness}, {name}: {found:?}");
        };
        each_method(&mut stage, |name, stage, gi| check(name, &drawn(&gpu, stage, gi, Layer::Indirect)));
        stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Low, ..Clpv::default() });
        check("sweep", &drawn(&gpu, &stage, GiMethod::CLPV, Layer::Indirect));
    }
}

#[test]
fn what_metals_show_of_the_sky_is_made_once_and_only_where_it_is_read() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.3, 1.4), Vec3::ZERO, 16);
    let material = Material { metallic: 1.0, roughness: 0.3, ..Material::new("metal") };
    stage.add_material(Shape::Sphere { radius: 1.0, segments: 16, rings: 8 }, material, Affine3A::IDENTITY);
    set_sky(&mut stage, halves());
    stage.scene.sky_light = true;
    let passes = ["sky levels", "sky reflection"];
    let draw = |stage: &Stage, renderer: &mut Renderer, gi| {
        let settings = RenderSettings { gi, only: Layer::Indirect, ..Default::default() };
        let report = stage.render_with(&gpu, renderer, &settings).1;
        passes.map(|pass| report.ran(pass))
    };
    let mut renderer = Renderer::new(&gpu);
    assert_eq!(draw(&stage, &mut renderer, GiMethod::NONE), [true, true]);
    stage.view.camera.world_from_view.translation.x += 0.01;
    assert_eq!(draw(&stage, &mut renderer, GiMethod::NONE), [false, true]);
    set_sky(&mut stage, halves());
    assert_eq!(draw(&stage, &mut renderer, GiMethod::NONE), [true, true]);
    // Rays see the sky itself.
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Clpv::default() });
    assert_eq!(draw(&stage, &mut Renderer::new(&gpu), GiMethod::CLPV), [false, false]);
}
