//! Light propagation volumes: flux, symmetry, scale, and what is kept or skipped.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, read_buffer};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv, Transport};
use std::f32::consts::PI;

const ROOM: Vec3 = Vec3::new(4.0, 4.0, 4.0);

/// A lamp in a closed room of 4 m, in a volume of half-metre cells that reaches one cell beyond the walls.
fn room(albedo: f32, settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 64);
    stage.add_room(-0.5 * ROOM, ROOM, Vec3::splat(albedo));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn half_metre_cells(cells: u32, steps: u32) -> Clpv {
    Clpv {
        transport: Transport::Diffusion,
        cells: [cells; 3],
        cell_size: CellSize::Meters(0.5),
        steps,
        ..Default::default()
    }
}

/// Flux of all cells together [W], one channel: ∫I = √(4π)·I_00, and the volume holds I/h².
fn flux(gpu: &Gpu, renderer: &Renderer, buffer: &str, cell: f32) -> f64 {
    let light: Vec<f32> = read_buffer(gpu, renderer.buffer(buffer).expect("a volume")).expect("readable");
    assert!(light.iter().all(|value| value.is_finite()), "{buffer} holds a number that is not finite");
    let constants: f64 = light.iter().step_by(12).map(|&c| f64::from(c)).sum();
    constants * f64::from(4.0 * PI).sqrt() * f64::from(cell * cell)
}

fn indirect() -> RenderSettings {
    RenderSettings { only: Layer::Indirect, ..Default::default() }
}

#[test]
fn all_that_a_lamp_sends_out_is_injected_times_the_reflectance() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let stage = room(0.5, half_metre_cells(10, 1));
    stage.render_with(&gpu, &mut renderer, &indirect());
    let injected = flux(&gpu, &renderer, "inject, cascade 0", 0.5);
    let expected = f64::from(0.5 * 4.0 * PI * 2.0);
    assert!((injected / expected - 1.0).abs() < 2e-3, "{injected} W of {expected} W");
}

#[test]
fn a_spot_light_injects_what_its_cone_holds() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, half_metre_cells(10, 1));
    stage.scene.lights.clear();
    let outer = 30.0_f32.to_radians();
    let lamp = stage.light(
        LightShape::Spot { inner: outer - 2e-3, outer },
        Vec3::splat(2.0),
        Vec3::new(0.1, 1.0, 0.0),
        Vec3::new(0.1, -1.0, 0.2),
    );
    lamp.rsm_size = 256;
    stage.render_with(&gpu, &mut renderer, &indirect());
    let injected = flux(&gpu, &renderer, "inject, cascade 0", 0.5);
    let expected = f64::from(0.5 * 2.0 * 2.0 * PI * (1.0 - outer.cos()));
    assert!((injected / expected - 1.0).abs() < 1e-2, "{injected} W of {expected} W");
}

#[test]
fn emissive_surfaces_inject_their_flux_and_light_a_room_alone() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, half_metre_cells(10, 8));
    stage.scene.lights.clear();
    let radiance = Vec3::new(2.0, 1.0, 0.5);
    let panel = Material { emissive: radiance, ..Material::diffuse("panel", Vec3::ZERO) };
    let turned = Affine3A::from_rotation_translation(glam::Quat::from_rotation_x(PI), Vec3::new(0.1, 1.4, 0.2));
    stage.add_material(Shape::Plane { size: [0.8, 0.6], subdivisions: [1, 1] }, panel, turned);
    let (image, _) = stage.render_with(&gpu, &mut renderer, &indirect());
    let injected = flux(&gpu, &renderer, "inject, cascade 0", 0.5);
    let expected = f64::from(PI * radiance.x * 0.8 * 0.6);
    assert!((injected / expected - 1.0).abs() < 2e-3, "{injected} W of {expected} W");
    let sum: Vec3 = image.rgba.iter().map(|p| Vec3::new(p[0], p[1], p[2])).sum();
    assert!(sum.x > 0.0 && (sum.y / sum.x - 0.5).abs() < 1e-3, "{sum}");
}

#[test]
fn a_step_keeps_the_flux_but_for_the_thirteen_percent_of_the_clamped_lobe() {
    // One lit patch in the middle of a large volume without blockers: nothing leaves within two steps.
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 3.0, 3.0), Vec3::ZERO, 32);
    stage.add(Shape::Plane { size: [0.4, 0.4], subdivisions: [1, 1] }, Vec3::ONE, Affine3A::IDENTITY);
    stage.light(LightShape::Spot { inner: 0.2, outer: 0.3 }, Vec3::ONE, Vec3::new(0.01, 1.0, 0.02), Vec3::NEG_Y);
    let mut sums = Vec::new();
    for steps in [1, 2] {
        let mut renderer = Renderer::new(&gpu);
        stage.clpv(Vec3::ZERO, Clpv { occlusion: false, ..half_metre_cells(15, steps) });
        stage.render_with(&gpu, &mut renderer, &indirect());
        let injected = flux(&gpu, &renderer, "inject, cascade 0", 0.5);
        assert!(injected > 0.0);
        sums.push(flux(&gpu, &renderer, "propagate, cascade 0", 0.5) / injected);
    }
    // The sum holds the injected light, then one wave a step.
    let (first, second) = (sums[0] - 1.0, (sums[1] - sums[0]) / (sums[0] - 1.0));
    assert!((first - 1.13).abs() < 0.01, "first step: {first} of the injected flux");
    assert!((0.999..1.15).contains(&second), "second step: {second} of the first");
}

#[test]
fn a_thousand_steps_in_a_white_closed_room_stay_bounded() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let stage = room(1.0, half_metre_cells(10, 1000));
    stage.render_with(&gpu, &mut renderer, &indirect());
    let injected = flux(&gpu, &renderer, "inject, cascade 0", 0.5);
    let sum = flux(&gpu, &renderer, "propagate, cascade 0", 0.5);
    assert!(sum > injected && sum < 1.2 * 1000.0 * injected, "{sum} W after 1000 steps from {injected} W");
}

#[test]
fn blockers_stop_light_and_bounces_bring_some_of_it_back() {
    let gpu = gpu();
    let sum = |settings: Clpv| {
        let mut renderer = Renderer::new(&gpu);
        room(0.8, settings).render_with(&gpu, &mut renderer, &indirect());
        flux(&gpu, &renderer, "propagate, cascade 0", 0.5)
    };
    // The volume reaches three cells beyond the walls: what they let through stays in it.
    let base = half_metre_cells(14, 12);
    let open = sum(Clpv { occlusion: false, ..base.clone() });
    let blocked = sum(Clpv { bounce: false, ..base.clone() });
    let bounced = sum(base);
    assert!(blocked < 0.8 * open, "blockers left {blocked} W of {open} W");
    assert!(bounced > 1.2 * blocked, "bounces brought {blocked} W to {bounced} W");
}

#[test]
fn intensity_scales_the_indirect_image_exactly_and_zero_is_zero() {
    let gpu = gpu();
    let mut stage = room(0.5, half_metre_cells(10, 8));
    let once = stage.render(&gpu, GiMethod::CLPV, Layer::Indirect);
    assert!(once.rgba.iter().any(|p| p[0] > 0.0));
    for power in [-20, -3, 1, 20] {
        let factor = 2.0_f32.powi(power);
        stage.scene.lights[0].intensity = Vec3::splat(2.0 * factor);
        let scaled = stage.render(&gpu, GiMethod::CLPV, Layer::Indirect);
        for (a, b) in once.rgba.iter().zip(&scaled.rgba) {
            assert_eq!(a[0] * factor, b[0], "2^{power}");
        }
    }
    stage.scene.lights[0].intensity = Vec3::ZERO;
    let dark = stage.render(&gpu, GiMethod::CLPV, Layer::Indirect);
    assert!(dark.rgba.iter().all(|p| p[..3] == [0.0; 3]));
}

#[test]
fn the_mirrored_scene_gives_the_mirrored_image() {
    let gpu = gpu();
    let image = |mirror: f32| {
        let m = Vec3::new(mirror, 1.0, 1.0);
        let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5) * m, Vec3::new(-1.0, -0.8, -1.2) * m, 64);
        stage.add_room(-0.5 * ROOM, ROOM, Vec3::new(0.2, 0.5, 0.7));
        stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2) * m, Vec3::NEG_Y);
        stage.clpv(Vec3::ZERO, half_metre_cells(10, 8));
        stage.render(&gpu, GiMethod::CLPV, Layer::Indirect)
    };
    let (plain, mirrored) = (image(1.0), image(-1.0));
    let (mut square, mut mean) = (0.0_f64, 0.0_f64);
    for y in 0..64 {
        for x in 0..64 {
            let (a, b) = (crate::support::rgb(&plain, x, y).y, crate::support::rgb(&mirrored, 63 - x, y).y);
            square += f64::from(a - b).powi(2) / 4096.0;
            mean += f64::from(a) / 4096.0;
        }
    }
    let nrmse = square.sqrt() / mean;
    assert!(nrmse < 5e-3, "nrmse {nrmse}");
}

#[test]
fn moving_everything_by_whole_cells_changes_nothing_to_see() {
    let gpu = gpu();
    let image = |shift: Vec3| {
        let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5) + shift, Vec3::new(-1.0, -0.8, -1.2) + shift, 64);
        stage.add_room(-0.5 * ROOM + shift, ROOM, Vec3::splat(0.5));
        stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2) + shift, Vec3::NEG_Y);
        stage.clpv(shift, half_metre_cells(10, 8));
        stage.render(&gpu, GiMethod::CLPV, Layer::Indirect)
    };
    let (here, there) = (image(Vec3::ZERO), image(Vec3::new(2.0, -4.0, 8.0)));
    let mean = here.rgba.iter().map(|p| p[0]).sum::<f32>() / here.rgba.len() as f32;
    let square: f32 = here.rgba.iter().zip(&there.rgba).map(|(a, b)| (a[0] - b[0]).powi(2)).sum();
    let nrmse = (square / here.rgba.len() as f32).sqrt() / mean;
    assert!(nrmse < 5e-3, "nrmse {nrmse}");
}

#[test]
fn the_order_of_lights_in_memory_does_not_matter_for_their_sum() {
    let gpu = gpu();
    let lights = [Vec3::new(0.3, 0.6, -0.2), Vec3::new(-0.9, -0.4, 0.8)];
    let image = |which: &[usize]| {
        let mut stage = room(0.5, half_metre_cells(10, 8));
        stage.scene.lights.clear();
        for &i in which {
            stage.light(LightShape::Point, Vec3::splat(1.0 + 2.0 * i as f32), lights[i], Vec3::NEG_Y);
        }
        stage.render(&gpu, GiMethod::CLPV, Layer::Indirect)
    };
    let (both, swapped) = (image(&[0, 1]), image(&[1, 0]));
    for (a, b) in both.rgba.iter().zip(&swapped.rgba) {
        assert!((a[0] - b[0]).abs() <= 1e-5 * a[0].abs().max(1e-6), "{} and {}", a[0], b[0]);
    }
}

#[test]
fn two_runs_give_the_same_bits_and_so_does_a_run_without_any_reuse() {
    let gpu = gpu();
    let stage = room(0.5, Clpv { cascades: 2, ..half_metre_cells(8, 8) });
    let first = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
    let mut renderer = Renderer::new(&gpu);
    stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    let settings = RenderSettings { no_cache: true, ..Default::default() };
    let (again, _) = stage.render_with(&gpu, &mut renderer, &settings);
    assert_eq!(first, again);
}

#[test]
fn a_still_scene_reuses_all_and_a_moved_camera_only_looks_again() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, half_metre_cells(10, 8));
    let settings = RenderSettings::default();
    let (first, _) = stage.render_with(&gpu, &mut renderer, &settings);
    let (second, report) = stage.render_with(&gpu, &mut renderer, &settings);
    assert_eq!(first, second);
    assert_eq!(report.ran_count(), 0, "{report}");
    stage.view.camera.world_from_view.translation.x -= 0.2;
    let (_, report) = stage.render_with(&gpu, &mut renderer, &settings);
    assert!(report.ran("relight") && report.ran("gbuffer"), "{report}");
    for pass in &report.passes {
        let of_light = ["shadow", "rsm", "inject", "blockers", "propagate"].iter().any(|s| pass.name.starts_with(s));
        assert!(!(of_light && report.ran(&pass.name)), "{} ran for a moved camera", pass.name);
    }
}

#[test]
fn without_volumes_or_lights_that_feed_them_nothing_of_them_runs() {
    let gpu = gpu();
    let mut stage = room(0.5, half_metre_cells(10, 8));
    stage.scene.lights[0].indirect = false;
    let (image, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &indirect());
    assert!(image.rgba.iter().all(|p| p[..3] == [0.0; 3]));
    assert!(!report.passes.iter().any(|p| report.ran(&p.name) && p.name.starts_with("rsm")), "{report}");
    stage.scene.clpv = None;
    stage.scene.lights[0].indirect = true;
    let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
    for pass in report.passes.iter().filter(|pass| report.ran(&pass.name)) {
        let of_volumes = ["rsm", "inject", "blockers", "propagate", "relight"].iter().any(|s| pass.name.starts_with(s));
        assert!(!of_volumes, "{} ran without a Clpv component", pass.name);
    }
}

#[test]
fn a_flickering_lamp_redraws_no_map() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, half_metre_cells(10, 8));
    stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    stage.scene.lights[0].intensity *= 0.7;
    stage.scene.lights[0].revision += 1;
    let (kept, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    for pass in &report.passes {
        let map = ["gbuffer", "shadow", "rsm", "blockers"].iter().any(|s| pass.name.starts_with(s));
        assert!(!(map && report.ran(&pass.name)), "{} ran for a change of intensity", pass.name);
    }
    assert!(report.ran("inject, cascade 0"), "{report}");
    assert_eq!(kept, stage.render(&gpu, GiMethod::CLPV, Layer::Total), "reuse changed a bit");
}
