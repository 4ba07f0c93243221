//! Masked surfaces: holes where alpha is below the cutoff, for the eye and for light.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{AlphaMode, AssetId, Material, Sampling, Shape, Texture};
use lightwell::gpu::Gpu;
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::LightShape;
use std::sync::Arc;

/// A square 1 m above the ground, half of which has an alpha of 128 of 255.
fn masked(stage: &mut Stage, cutoff: f32, emissive: Vec3) {
    let texture = Texture {
        id: AssetId::fresh(),
        name: "halves".into(),
        width: 2,
        height: 1,
        rgba: vec![255, 255, 255, 255, 255, 255, 255, 128],
        srgb: true,
        sampling: Sampling { nearest: true, ..Sampling::default() },
    };
    let material = Material {
        alpha_mode: AlphaMode::Mask(cutoff),
        base_color_texture: Some(Arc::new(texture)),
        emissive,
        double_sided: true,
        ..Material::diffuse("masked", Vec3::ZERO)
    };
    let shape = Shape::Plane { size: [4.0; 2], subdivisions: [1; 2] };
    stage.add_material(shape, material, Affine3A::from_translation(Vec3::Y));
}

/// Part of the pixels that are bright.
fn bright(gpu: &Gpu, stage: &Stage, layer: Layer) -> f32 {
    let image = stage.render(gpu, GiMethod::NONE, layer);
    let count = image.rgba.iter().filter(|pixel| pixel[0] > 0.02).count();
    count as f32 / image.rgba.len() as f32
}

const CUTOFFS: [(f32, f32); 4] = [(0.3, 1.0), (0.5, 1.0), (0.51, 0.5), (1.1, 0.0)];

#[test]
fn alpha_below_the_cutoff_is_not_drawn() {
    let gpu = gpu();
    for (cutoff, drawn) in CUTOFFS {
        let mut stage = Stage::new(Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO, 32);
        masked(&mut stage, cutoff, Vec3::ONE);
        let found = bright(&gpu, &stage, Layer::Total);
        assert!((found - drawn).abs() < 0.05, "cutoff {cutoff}: {found} of the image");
    }
}

#[test]
fn light_comes_through_the_holes() {
    let gpu = gpu();
    for (cutoff, drawn) in CUTOFFS {
        // The eye is below the masked square, the lamp above it.
        let mut stage = Stage::new(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 32);
        masked(&mut stage, cutoff, Vec3::ZERO);
        stage.add(Shape::Plane { size: [8.0; 2], subdivisions: [1; 2] }, Vec3::splat(0.5), Affine3A::IDENTITY);
        stage.light(LightShape::Point, Vec3::splat(50.0), Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y);
        let lit = bright(&gpu, &stage, Layer::Direct);
        assert!((lit - (1.0 - drawn)).abs() < 0.08, "cutoff {cutoff}: {lit} of the floor is lit");
    }
}
