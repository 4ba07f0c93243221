//! Skies that differ by direction: drawn, traced and swept, against integrals.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Shape, SkyMap};
use lightwell::gpu::Gpu;
use lightwell::measure::Image;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer};
use lightwell::world::{CellSize, Clpv};
use std::path::Path;
use std::sync::Arc;

fn trace(gpu: &Gpu, stage: &Stage, samples: u32) -> Estimate {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, &TraceSettings { bounces: Some(1), seed: 3 }).unwrap();
    tracer.advance(gpu, samples).unwrap();
    tracer.estimate(gpu).unwrap()
}

fn drawn(gpu: &Gpu, stage: &Stage, layer: Layer) -> Image {
    let image = stage.render(gpu, GiMethod::CLPV, layer);
    Image::from_rgba(image.width, image.height, &image.rgba).unwrap()
}

fn set_sky(stage: &mut Stage, map: SkyMap) {
    stage.scene.sky = map.mean();
    stage.scene.sky_map = Some(Arc::new(map));
    stage.scene.revisions.settings += 1;
}

/// An image of a sky of radiance `all` with one texel of its own.
fn sky_file(path: &Path, size: [u32; 2], all: f32, texel: Option<([u32; 2], f32)>) {
    let value = |x: u32, y: u32| match texel {
        Some((at, value)) if at == [x, y] => value,
        _ => all,
    };
    let pixels = (0..size[0] * size[1]).map(|i| [value(i % size[0], i / size[0]); 3]).collect();
    let image = Image::from_pixels(size[0], size[1], pixels).unwrap();
    lightwell::measure::write_image(path, &image).unwrap();
}

/// A floor that fills the view, seen from above.
fn floor() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 16);
    stage.add(Shape::Plane { size: [8.0; 2], subdivisions: [1; 2] }, Vec3::splat(0.5), Affine3A::IDENTITY);
    stage
}

/// Under an even sky of radiance 1 a white convex object looks exactly as bright as the sky.
#[test]
fn white_furnace_of_an_image() {
    let (gpu, dir) = (gpu(), tempfile::tempdir().unwrap());
    let path = dir.path().join("white.exr");
    sky_file(&path, [32, 16], 1.0, None);
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 16);
    stage.add(Shape::Sphere { radius: 1.0, segments: 48, rings: 24 }, Vec3::ONE, Affine3A::IDENTITY);
    set_sky(&mut stage, SkyMap::load(&path, 1.0, 0.7).unwrap());
    let image = trace(&gpu, &stage, 256).total();
    assert!((image.mean() - 1.0).abs() < 2e-3, "{}", image.mean());
}

/// A texel as bright as the sun lights a floor by L·Ω·cosθ·ρ/π, and few samples find it.
#[test]
fn a_bright_texel_converges() {
    let (gpu, dir) = (gpu(), tempfile::tempdir().unwrap());
    let path = dir.path().join("sun.exr");
    sky_file(&path, [256, 128], 0.0, Some(([70, 30], 1e5)));
    let mut stage = floor();
    let map = SkyMap::load(&path, 1.0, 0.0).unwrap();
    let expected = map.irradiance(Vec3::Y).x * 0.5 / std::f32::consts::PI;
    set_sky(&mut stage, map);
    let estimate = trace(&gpu, &stage, 16);
    let (found, noise) = (estimate.indirect().mean(), estimate.noise(Layer::Indirect).unwrap());
    // Radiance is interpolated between texels, which widens it a little.
    assert!((found / f64::from(expected) - 1.0).abs() < 0.02, "{found}, expected {expected}");
    // By the cosine alone, a sample in some ten thousand would meet the texel: noise of 2,500 %.
    assert!(noise < 0.35, "noise {noise}");
}

/// What is drawn behind the scene is what the path tracer sees there, turned map and all.
#[test]
fn drawn_as_traced() {
    let (gpu, dir) = (gpu(), tempfile::tempdir().unwrap());
    let path = dir.path().join("steps.exr");
    sky_file(&path, [16, 8], 0.25, Some(([9, 3], 2.0)));
    let mut stage = Stage::new(Vec3::new(3.0, 1.0, 2.0), Vec3::new(3.2, 1.1, 1.0), 192);
    set_sky(&mut stage, SkyMap::load(&path, 1.0, 0.2).unwrap());
    let traced = trace(&gpu, &stage, 64).direct();
    let drawn = drawn(&gpu, &stage, Layer::Direct);
    let largest = traced.values().zip(drawn.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(traced.values().fold(0.0, f32::max) > 1.5, "the bright texel is in view");
    // At the peak the mean over a pixel lies below its centre by half the slope over a pixel.
    assert!(largest < 0.04, "differs by {largest}");
}

/// An open floor in the light volumes gets the integral of a sky with a bright side.
#[test]
fn swept_as_integrated() {
    let gpu = gpu();
    let mut stage = floor();
    let cell_size = CellSize::Meters(0.5);
    stage.clpv(Vec3::new(0.0, 2.0, 0.0), Clpv { cells: [24, 12, 24], cell_size, ..Clpv::default() });
    let map = SkyMap::gradient(Vec3::new(0.2, 0.5, 1.0), Vec3::new(1.0, 0.6, 0.3), Vec3::ZERO);
    let expected = map.irradiance(Vec3::Y) * 0.5 / std::f32::consts::PI;
    set_sky(&mut stage, map);
    let image = drawn(&gpu, &stage, Layer::Indirect);
    let pixels = image.pixels();
    let mean: [f64; 3] =
        std::array::from_fn(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / pixels.len() as f64);
    for (found, expected) in mean.into_iter().zip(expected.to_array()) {
        assert!((found / f64::from(expected) - 1.0).abs() < 0.05, "{mean:?}, expected {expected}");
    }
}

/// Under an even sky a mirror of any roughness looks as bright as the sky, times what it reflects of it.
#[test]
fn glossy_surfaces_reflect_an_even_sky() {
    let gpu = gpu();
    for (metallic, roughness) in [(1.0, 0.2), (1.0, 0.7), (0.0, 0.3)] {
        let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 16);
        let color = Vec3::splat(if metallic > 0.0 { 0.8 } else { 0.0 });
        let material = lightwell::assets::Material {
            base_color: color.extend(1.0),
            metallic,
            roughness,
            ..lightwell::assets::Material::new("mirror")
        };
        stage.add_material(Shape::Plane { size: [8.0; 2], subdivisions: [1; 2] }, material, Affine3A::IDENTITY);
        let cell_size = CellSize::Meters(0.5);
        stage.clpv(Vec3::new(0.0, 2.0, 0.0), Clpv { cells: [24, 12, 24], cell_size, ..Clpv::default() });
        stage.scene.sky = Vec3::ONE;
        stage.scene.revisions.settings += 1;
        let middle = |image: &Image| f64::from(image.pixels()[8 + 8 * 16][1]);
        let (found, traced) = (drawn(&gpu, &stage, Layer::Indirect), trace(&gpu, &stage, 256).indirect());
        let (found, traced) = (middle(&found), middle(&traced));
        println!("metallic {metallic}, roughness {roughness}: {found:.3}, traced {traced:.3}");
        assert!(traced > 0.02);
        assert!((found / traced - 1.0).abs() < 0.06 || (found - traced).abs() < 0.01, "{found}, traced {traced}");
    }
}
