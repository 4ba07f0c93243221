//! Samplers of textures by what they draw: edges of texels, mip levels, borders.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine2, Affine3A, Vec2, Vec3};
use lightwell::assets::{AssetId, Levels, Material, Minification, Sampling, Shape, Texture, Wrap};
use lightwell::gpu::Gpu;
use lightwell::render::{GiMethod, Layer};
use std::sync::Arc;

/// Edge of the images.
const EDGE: u32 = 64;

/// A grey texture of rows of bytes.
fn texture(rows: &[&[u8]], sampling: Sampling) -> Texture {
    Texture {
        id: AssetId::fresh(),
        name: "pattern".into(),
        width: rows[0].len() as u32,
        height: rows.len() as u32,
        rgba: rows.iter().flat_map(|row| row.iter().flat_map(|v| [*v, *v, *v, 255])).collect(),
        srgb: false,
        sampling,
    }
}

/// Rows of brightness of a square that fills the image and shows the texture so many times along each edge.
fn drawn(gpu: &Gpu, texture: Texture, times: f32) -> Vec<Vec<f32>> {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, EDGE);
    let mut material = Material::diffuse("screen", Vec3::ZERO);
    (material.emissive, material.emissive_texture) = (Vec3::ONE, Some(Arc::new(texture)));
    material.uv.emissive.transform = Affine2::from_scale(Vec2::splat(times));
    stage.add_material(Shape::Plane { size: [2.0; 2], subdivisions: [1; 2] }, material, Affine3A::IDENTITY);
    let image = stage.render(gpu, GiMethod::NONE, Layer::Total);
    let edge = EDGE as usize;
    (0..edge).map(|y| (0..edge).map(|x| image.rgba[x + y * edge][0]).collect()).collect()
}

fn mean(rows: &[Vec<f32>]) -> f32 {
    rows.iter().flatten().sum::<f32>() / (EDGE * EDGE) as f32
}

/// Pixels that are neither black nor white.
fn between(rows: &[Vec<f32>]) -> usize {
    rows.iter().flatten().filter(|v| (0.02..0.98).contains(*v)).count()
}

fn small(nearest: bool, levels: Levels) -> Sampling {
    Sampling { minification: Some(Minification { nearest, levels }), ..Sampling::default() }
}

const CHECKER: [&[u8]; 2] = [&[0, 255], &[255, 0]];

#[test]
fn magnified_texels_have_hard_edges_or_soft_ones() {
    let gpu = gpu();
    for (nearest, expected) in [(true, 0..1), (false, 2000..4097)] {
        // The filter for small textures plays no part.
        for minification in [None, Some(Minification { nearest: !nearest, levels: Levels::Full })] {
            let sampling = Sampling { nearest, minification, ..Sampling::default() };
            let count = between(&drawn(&gpu, texture(&CHECKER, sampling), 1.0));
            assert!(expected.contains(&count), "{sampling:?}: {count} pixels are grey");
        }
    }
}

#[test]
fn small_textures_are_read_in_full_or_averaged() {
    let gpu = gpu();
    // 2.7 texels a pixel: within a pixel there are black ones and white ones.
    let times = 2.7 * EDGE as f32 / 2.0;
    let grey = |nearest, levels| between(&drawn(&gpu, texture(&CHECKER, small(nearest, levels)), times));
    let all = (EDGE * EDGE) as usize;
    assert_eq!((grey(true, Levels::Full), grey(false, Levels::Blended)), (0, all));
    assert_eq!(
        (grey(true, Levels::Nearest), grey(false, Levels::Nearest), grey(true, Levels::Blended)),
        (all, all, all)
    );
    // Four texels at a time, of the full size: mostly grey, and of all greys.
    let rows = drawn(&gpu, texture(&CHECKER, small(false, Levels::Full)), times);
    let (low, high) = rows.iter().flatten().fold((1.0_f32, 0.0_f32), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(low < 0.1 && high > 0.9, "{low} to {high}");
}

/// The last column and row of three do not count in the next level, which is black: how much of it is seen tells the
/// level of detail.
#[test]
fn mip_levels_are_taken_by_themselves_or_blended() {
    let gpu = gpu();
    let rows: [&[u8]; 3] = [&[0, 0, 255], &[0, 0, 255], &[255, 255, 255]];
    let full = 5.0 / 9.0;
    // How blended levels go over into each other is left to devices, to some degree.
    for (detail, nearest, blended) in [(0.35_f32, full, 0.25 * full..0.75 * full), (0.7, 0.0, 0.0..0.5 * full)] {
        let times = detail.exp2() * EDGE as f32 / 3.0;
        let found = |levels| mean(&drawn(&gpu, texture(&rows, small(false, levels)), times));
        let (a, b, c) = (found(Levels::Nearest), found(Levels::Blended), found(Levels::Full));
        println!("level {detail}: nearest {a:.3}, blended {b:.3}, none {c:.3}");
        assert!((a - nearest).abs() < 0.03, "level {detail}: {a}, expected {nearest}");
        assert!(blended.contains(&b), "level {detail}: {b}, expected {blended:?}");
        assert!((c - full).abs() < 0.03, "level {detail}: {c}, expected {full}");
    }
}

/// Seen at a slant and small, a white field in a black frame is white at every pixel: none is taken from elsewhere.
#[test]
fn slanted_fields_have_no_specks() {
    let gpu = gpu();
    let frame = |i: usize| !(64..448).contains(&i);
    let rows: Vec<Vec<u8>> =
        (0..512).map(|y| (0..512).map(|x| if frame(x) || frame(y) { 0 } else { 255 }).collect()).collect();
    let rows: Vec<&[u8]> = rows.iter().map(Vec::as_slice).collect();
    for (edge, turn) in [(96, 0.3), (120, 0.5), (160, 0.4), (200, 0.35), (240, 0.6)] {
        let mut stage = Stage::new(Vec3::new(0.0, 1.6, 0.0), Vec3::ZERO, edge);
        let mut material = Material::diffuse("screen", Vec3::ZERO);
        let picture = Arc::new(texture(&rows, Sampling::default()));
        (material.emissive, material.emissive_texture) = (Vec3::ONE, Some(picture));
        let slant = Affine3A::from_rotation_x(turn) * Affine3A::from_rotation_z(0.7 * turn);
        stage.add_material(Shape::Plane { size: [2.0; 2], subdivisions: [1; 2] }, material, slant);
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        let inverse = slant.inverse();
        let mut fields = 0;
        for y in 0..edge {
            for x in 0..edge {
                // Where the ray through the pixel meets the plane, in the plane's own coordinates.
                let (from, ray) = (Vec3::new(0.0, 1.6, 0.0), stage.ray(x, y));
                let (from, ray) = (inverse.transform_point3(from), inverse.transform_vector3(ray));
                let at = from - ray * (from.y / ray.y);
                if at.x.abs().max(at.z.abs()) < 0.6 {
                    fields += 1;
                    let value = image.rgba[(x + y * edge) as usize][0];
                    assert!(value > 0.99, "edge {edge}, turn {turn}, pixel {x}, {y}: {value}");
                }
            }
        }
        assert!(fields > edge * edge / 20, "{fields} pixels show the field");
    }
}

#[test]
fn borders_repeat_mirror_or_go_on_along_each_axis() {
    let gpu = gpu();
    let halves: [&[u8]; 2] = [&[0, 255], &[0, 255]];
    let turned: [&[u8]; 2] = [&[0, 0], &[255, 255]];
    for (wrap, pattern) in [(Wrap::Repeat, "0101"), (Wrap::Mirror, "0110"), (Wrap::Clamp, "0111")] {
        let (other, nearest) = (if wrap == Wrap::Repeat { Wrap::Clamp } else { Wrap::Repeat }, true);
        let along_u = Sampling { wrap_u: wrap, wrap_v: other, nearest, minification: None };
        let along_v = Sampling { wrap_u: other, wrap_v: wrap, nearest, minification: None };
        for picture in [texture(&halves, along_u), texture(&turned, along_v)] {
            let rows = drawn(&gpu, picture, 2.0);
            let steps = |at: &dyn Fn(usize) -> f32| -> String {
                [8, 24, 40, 56].map(|i| if at(i) > 0.5 { '1' } else { '0' }).iter().collect()
            };
            let (across, down) = (steps(&|i| rows[32][i]), steps(&|i| rows[i][32]));
            let is_pattern = |found: &str| found == pattern || found.chars().rev().eq(pattern.chars());
            assert!(is_pattern(&across) || is_pattern(&down), "{wrap:?}: {across} and {down}");
        }
    }
}
