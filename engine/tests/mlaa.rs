//! Morphological anti-aliasing: slanted edges come closer to the truth, and nothing else changes.

#![allow(clippy::unwrap_used)]

mod support;

use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, read_texture};
use lightwell::measure::srgb_decode;
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use support::{Stage, gpu};

const EDGE: u32 = 96;

/// The display image, decoded to linear light.
fn display(gpu: &Gpu, stage: &Stage, mlaa: bool) -> (Vec<u8>, Vec<f32>) {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::None, mlaa, ..Default::default() };
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
