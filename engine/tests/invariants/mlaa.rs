//! Morphological anti-aliasing: slanted edges come closer to the truth, and nothing else changes.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, read_texture};
use lightwell::measure::srgb_decode;
use lightwell::render::{GiMethod, MlaaEdges, RenderSettings, Renderer};
use std::sync::Arc;

const EDGE: u32 = 96;

/// The display image, decoded to linear light.
fn display(gpu: &Gpu, stage: &Stage, mlaa: bool) -> (Vec<u8>, Vec<f32>) {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::NONE, mlaa, ..Default::default() };
    stage.render_with(gpu, &mut renderer, &settings);
    let bytes = read_texture(gpu, renderer.display().unwrap(), 0, 0).unwrap();
    let light = bytes.iter().map(|&byte| srgb_decode(f32::from(byte) / 255.0)).collect();
    (bytes, light)
}

/// A bright square that is turned in the view, before black.
fn slanted(degrees: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 1.0), Vec3::ZERO, EDGE);
    let material = Material { emissive: Vec3::new(0.6, 0.5, 0.4), ..Material::diffuse("lamp", Vec3::ZERO) };
    let turn = Affine3A::from_quat(Quat::from_rotation_z(degrees.to_radians()));
    stage.add_material(Shape::Box { size: [1.0, 1.0, 0.1] }, material, turn);
    stage
}

fn error(image: &[f32], truth: &[f32]) -> f64 {
    let sum: f64 = image.iter().zip(truth).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / image.len() as f64).sqrt()
}

#[test]
fn slanted_edges_come_closer_to_the_truth() {
    let gpu = gpu();
    for degrees in [7.0, 20.0, 33.0] {
        let mut stage = slanted(degrees);
        let (plain_bytes, plain) = display(&gpu, &stage, false);
        let (smooth_bytes, smooth) = display(&gpu, &stage, true);
        let mut truth = vec![0.0; plain.len()];
        for i in 0..64 {
            stage.view.jitter = [(i % 8) as f32 / 8.0 - 0.4375, (i / 8) as f32 / 8.0 - 0.4375];
            for (sum, value) in truth.iter_mut().zip(display(&gpu, &stage, false).1) {
                *sum += value / 64.0;
            }
        }
        let (before, after) = (error(&plain, &truth), error(&smooth, &truth));
        println!("{degrees} degrees: {before:.4} before, {after:.4} after");
        assert!(after < 0.6 * before, "{degrees} degrees: {before} before, {after} after");
        // Pixels whose neighbours all look like them keep their bits.
        let at = |x: u32, y: u32| &plain_bytes[4 * (x + y * EDGE) as usize..][..4];
        let mut flat = 0;
        for (x, y) in (1..EDGE - 1).flat_map(|y| (1..EDGE - 1).map(move |x| (x, y))) {
            let same = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].iter().all(|&(i, j)| at(i, j) == at(x, y));
            if same {
                flat += 1;
                assert_eq!(&smooth_bytes[4 * (x + y * EDGE) as usize..][..4], at(x, y), "pixel {x}, {y}");
            }
        }
        assert!(flat > 4000, "{flat} flat pixels");
    }
}

#[test]
fn straight_edges_keep_their_bits() {
    let gpu = gpu();
    let stage = slanted(0.0);
    assert!(display(&gpu, &stage, false).0 == display(&gpu, &stage, true).0, "a pixel has changed");
}

/// Two boxes of different colour, in front of a camera that is rolled: see `matrix`.
fn pair(degrees: f32, places: [Affine3A; 2]) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 1.0), Vec3::ZERO, EDGE);
    let roll = Affine3A::from_quat(Quat::from_rotation_z(degrees.to_radians()));
    for (place, color) in places.into_iter().zip([Vec3::new(0.6, 0.5, 0.4), Vec3::new(0.05, 0.1, 0.3)]) {
        let material = Material { emissive: color, ..Material::diffuse("lamp", Vec3::ZERO) };
        stage.add_material(Shape::Box { size: [8.0, 8.0, 0.1] }, material, roll * place);
    }
    stage
}

/// Depth finds outlines, normals find corners, and only colours find a seam within a plane.
#[test]
fn each_mode_finds_its_own_edges() {
    let gpu = gpu();
    let shifted = |x: f32, z: f32| Affine3A::from_translation(Vec3::new(x, 0.0, z));
    let turned = |degrees: f32| Affine3A::from_quat(Quat::from_rotation_y(degrees.to_radians()));
    let cases = [
        ("outline", [shifted(4.0, 0.0), shifted(0.0, -0.5)], [true, true, false]),
        ("corner", [turned(-40.0), turned(40.0)], [true, false, true]),
        ("seam", [shifted(4.0, 0.0), shifted(-4.0, 0.0)], [true, false, false]),
    ];
    for (name, places, expected) in cases {
        let stage = pair(20.0, places);
        let plain = display(&gpu, &stage, false).0;
        for (by, expected) in [MlaaEdges::Color, MlaaEdges::Depth, MlaaEdges::Normal].into_iter().zip(expected) {
            let changed = changed(&gpu, &stage, by, &plain);
            println!("{name} by {by:?}: {changed} pixels");
            // The edge crosses some hundred pixels.
            assert_eq!(changed > 50, expected, "{name} by {by:?}: {changed} pixels");
            assert!(expected || changed == 0, "{name} by {by:?}: {changed} pixels");
        }
    }
    // What stands before something of nearly its colour has an outline too.
    let mut stage = pair(20.0, [shifted(4.0, 0.0), shifted(0.0, -0.5)]);
    let material = |value| Arc::new(Material { emissive: Vec3::splat(value), ..Material::diffuse("lamp", Vec3::ZERO) });
    (stage.scene.primitives[0].material, stage.scene.primitives[1].material) = (material(0.3), material(0.33));
    let plain = display(&gpu, &stage, false).0;
    assert_eq!(changed(&gpu, &stage, MlaaEdges::Color, &plain), 0);
    assert!(changed(&gpu, &stage, MlaaEdges::Depth, &plain) > 50);
}

/// Pixels that smoothing changes.
fn changed(gpu: &Gpu, stage: &Stage, by: MlaaEdges, plain: &[u8]) -> usize {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::NONE, mlaa: true, mlaa_edges: by, ..Default::default() };
    stage.render_with(gpu, &mut renderer, &settings);
    let smooth = read_texture(gpu, renderer.display().unwrap(), 0, 0).unwrap();
    smooth.chunks(4).zip(plain.chunks(4)).filter(|(a, b)| a != b).count()
}
