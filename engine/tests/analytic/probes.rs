//! Indirect light at points that a game asks for, against integrals over the sky.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ProbePoint};
use lightwell::world::{CellSize, Clpv, Quality};
use std::f32::consts::{FRAC_PI_2, PI};

/// Under an even sky of radiance 1 over a black floor an upward surface receives π. The sky is seen down to an angle α
/// below the horizon, past the floor's edge: a surface that faces down receives π·sin²α, and the mean over all normals
/// is ∫L dω/4 = π/2·(1 + sin α).
#[test]
fn under_an_even_sky() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 6.0), Vec3::ZERO, 16);
    stage.add(Shape::Plane { size: [24.0; 2], subdivisions: [1; 2] }, Vec3::ZERO, Affine3A::IDENTITY);
    let (cell_size, cells) = (CellSize::Meters(0.75), [32, 12, 32]);
    stage.clpv(Vec3::new(0.0, 3.0, 0.0), Clpv { quality: Quality::Low, cell_size, cells, ..Clpv::default() });
    stage.scene.sky = Vec3::ONE;
    let mut renderer = Renderer::new(&gpu);
    // A square floor is taken for a disc of the same area.
    let (height, radius) = (1.5_f32, 24.0 / PI.sqrt());
    let sine = height / height.hypot(radius);
    let position = Vec3::new(0.3, height, -0.2);
    let points = [Some(Vec3::Y), Some(Vec3::NEG_Y), None].map(|normal| ProbePoint { position, normal });
    renderer.set_probes(points.to_vec());
    assert_eq!(renderer.probe_light(&gpu).unwrap(), [Vec3::ZERO; 3], "nothing was drawn yet");
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Total, ..RenderSettings::default() };
    renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap();
    let found = renderer.probe_light(&gpu).unwrap();
    // Light that grazes the floor is spread by the grid: some of it comes from below.
    let expected = [PI, PI * sine * sine, FRAC_PI_2 * (1.0 + sine)];
    for ((light, expected), tolerance) in found.iter().zip(expected).zip([0.05, 0.15, 0.1]) {
        assert!((light.x - expected).abs() < tolerance * PI, "{light} instead of {expected}");
        assert!(light.x == light.y && light.y == light.z, "{light}");
    }
    // Without any light the volumes are not even filled: nothing is left from the frame before.
    stage.scene.sky = Vec3::ZERO;
    stage.scene.revisions.settings += 1;
    renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap();
    assert_eq!(renderer.probe_light(&gpu).unwrap(), [Vec3::ZERO; 3]);
}

/// In a closed box of reflectance ρ that is lit by a lamp of flux 4πI all surfaces of area A share what is reflected:
/// the mean of the indirect irradiance is Φ/A·ρ/(1−ρ), and probes all over the box find it.
#[test]
fn in_a_closed_box() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.9, 1.9), Vec3::new(0.0, 1.0, 0.0), 16);
    let (size, albedo, intensity) = (4.0_f32, 0.5_f32, 3.0_f32);
    stage.add_room(Vec3::new(-2.0, 0.0, -2.0), Vec3::splat(size), Vec3::splat(albedo));
    stage.light(LightShape::Point, Vec3::splat(intensity), Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y);
    stage.clpv(Vec3::new(0.0, 2.0, 0.0), Clpv { quality: Quality::Medium, ..Clpv::default() });
    let mut renderer = Renderer::new(&gpu);
    let at = |i: usize| [-1.2, 0.0, 1.2][i % 3];
    let places = (0..27).map(|i| Vec3::new(at(i), 2.0 + at(i / 3), at(i / 9)));
    let probes: Vec<ProbePoint> = places.map(|position| ProbePoint { position, normal: None }).collect();
    renderer.set_probes(probes.clone());
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Total, ..RenderSettings::default() };
    renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap();
    let found = renderer.probe_light(&gpu).unwrap();
    let mean = found.iter().map(|light| light.x).sum::<f32>() / found.len() as f32;
    let expected = 4.0 * PI * intensity / (6.0 * size * size) * albedo / (1.0 - albedo);
    assert!((mean / expected - 1.0).abs() < 0.1, "{mean} instead of {expected}: {found:?}");
}
