//! The sweep transport: against formulas, and what must hold at all times.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, Quality};

const ROOM: Vec3 = Vec3::new(4.0, 4.0, 4.0);

fn settings(bounces: Bounces) -> Clpv {
    Clpv { bounces, quality: Quality::Low, ..Default::default() }
}

/// A lamp in a closed room of 4 m.
fn room(albedo: f32, settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 64);
    stage.add_room(-0.5 * ROOM, ROOM, Vec3::splat(albedo));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|p| p[0]).sum::<f32>() / image.rgba.len() as f32
}

/// A plane of 2 m that glows at x = 0, on a floor; the floor seen from above.
fn glowing_wall(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.8, 0.8, 0.0), Vec3::new(0.8, 0.0, 0.0), 64);
    let slab = |size: Vec3| Shape::Box { size: size.into() };
    let floor = Affine3A::from_translation(Vec3::new(1.0, -0.1, 0.0));
    stage.add(slab(Vec3::new(2.4, 0.2, 2.0)), Vec3::ONE, floor);
    let mut glow = Material::diffuse("glow", Vec3::ZERO);
    glow.emissive = Vec3::ONE;
    stage.add_material(slab(Vec3::new(0.2, 2.0, 2.0)), glow, Affine3A::from_translation(Vec3::new(-0.1, 1.0, 0.0)));
    stage.clpv(Vec3::ZERO, settings);
    stage
}

/// Irradiance on the floor from a wall of 2 × 2 m at x = 0 with L = 1, by its contour (Lambert; closed form by Baum
/// et al. 1989): E = ½·Σ Θᵢ·(nᵢ·n).
fn wall_irradiance(x: f64) -> f64 {
    let corners = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 2.0, -1.0]];
    let from_point = corners.map(|c: [f64; 3]| glam::DVec3::new(c[0] - x, c[1], c[2]).normalize());
    let edge = |i: usize| {
        let (a, b) = (from_point[i], from_point[(i + 1) % 4]);
        a.dot(b).clamp(-1.0, 1.0).acos() * a.cross(b).normalize_or_zero().y
    };
    (0.5 * (0..4).map(edge).sum::<f64>()).abs()
}

/// Normalised root of the mean square error of the floor's light, and its largest error.
fn error_before_glowing_wall(gpu: &Gpu, settings: Clpv) -> (f64, f64) {
    let stage = glowing_wall(settings);
    let image = stage.render(gpu, GiMethod::CLPV, Layer::Indirect);
    let mut worst = 0.0_f64;
    let (mut square, mut total) = (0.0, 0.0);
    for column in 0..64 {
        // The camera looks down from 0.8 m; its right is +x or −x, whichever: the ray tells.
        let ray = stage.ray(column, 32);
        let point = Vec3::new(0.8, 0.8, 0.0) + ray * (0.8 / -ray.y);
        let expected = wall_irradiance(f64::from(point.x));
        if point.x < 0.06 {
            continue;
        }
        let found = f64::from(rgb(&image, column, 32).x) * std::f64::consts::PI;
        worst = worst.max((found / expected - 1.0).abs());
        square += (found - expected).powi(2);
        total += expected;
    }
    ((square * 64.0).sqrt() / total, worst)
}

#[test]
fn a_glowing_wall_lights_the_floor_as_its_form_factor_says() {
    let settings = Clpv { quality: Quality::High, ..settings(Bounces::Count(1)) };
    let (nrmse, worst) = error_before_glowing_wall(&gpu(), settings);
    assert!(nrmse < 0.07 && worst < 0.15, "nrmse {nrmse}, largest error {worst}");
}

#[test]
fn finer_cascades_before_the_camera_err_less() {
    let gpu = gpu();
    let with = |cascades| error_before_glowing_wall(&gpu, Clpv { cascades, ..settings(Bounces::Count(1)) }).0;
    let errors = [1, 2, 3].map(with);
    assert!(errors[1] < 0.95 * errors[0] && errors[2] < errors[0], "one, two and three cascades: {errors:?}");
}

#[test]
fn finer_cascades_bring_no_energy_and_lose_none() {
    let gpu = gpu();
    for albedo in [0.5, 0.9] {
        let with = |cascades| {
            let settings = Clpv { cascades, ..settings(Bounces::Converged) };
            mean(&room(albedo, settings).render(&gpu, GiMethod::CLPV, Layer::Indirect))
        };
        let [one, two, four] = [1, 2, 4].map(with);
        let near = |a: f32| (a / one - 1.0).abs() < 0.08;
        assert!(near(two) && near(four), "albedo {albedo}: {one}, {two} and {four} with 1, 2 and 4 cascades");
    }
}

#[test]
fn finer_cascades_stand_still_while_the_camera_stays_in_its_cell() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, Clpv { cascades: 2, ..settings(Bounces::Count(2)) });
    stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    // Of two small steps one at most leads into the next cell.
    let small_steps = [0, 1].map(|_| {
        stage.view.camera.world_from_view.translation.x -= 0.004;
        let (_, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
        assert!(report.ran("relight"), "{report}");
        report.passes.iter().filter(|p| p.name.contains("cascade") && report.ran(&p.name)).count()
    });
    assert!(small_steps.contains(&0), "passes that ran again: {small_steps:?}");
    stage.view.camera.world_from_view.translation.x -= 0.9;
    let (moved, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    assert!(report.ran("sweep, cascade 0, bounce 1") && !report.ran("opacity, cascade 1"), "{report}");
    assert_eq!(moved, stage.render(&gpu, GiMethod::CLPV, Layer::Total), "it matters how the camera came here");
}

#[test]
fn closed_shells_let_no_light_in() {
    let gpu = gpu();
    // Cells are of 0.2 m, or less in finer cascades.
    for (thickness, shift) in [(0.01, 0.0), (0.04, 0.07), (0.1, 0.03), (0.2, 0.0), (0.2, 0.11), (0.35, 0.05)] {
        for cascades in [1, 2, 3] {
            let center = Vec3::new(shift, -0.4 * shift, 0.7 * shift);
            let mut stage = Stage::new(center + Vec3::new(0.5, 0.3, 1.1), center + Vec3::new(-0.3, -0.4, -1.0), 32);
            let edge = 3.0 + thickness;
            for axis in 0..3 {
                for side in [-1.5, 1.5] {
                    let (mut at, mut size) = (center, Vec3::splat(edge));
                    at[axis] += side;
                    size[axis] = thickness;
                    stage.add(Shape::Box { size: size.to_array() }, Vec3::splat(0.8), Affine3A::from_translation(at));
                }
            }
            stage.scene.sky = Vec3::ONE;
            stage.clpv(Vec3::ZERO, Clpv { cascades, ..settings(Bounces::Count(1)) });
            let leaked = mean(&stage.render(&gpu, GiMethod::CLPV, Layer::Indirect)) / 0.8;
            assert!(leaked < 1e-3, "walls of {thickness} m, moved {shift} m, {cascades} cascades: {leaked}");
        }
    }
}

#[test]
fn intensity_scales_the_image_exactly_and_zero_is_zero() {
    let gpu = gpu();
    let mut stage = room(0.5, settings(Bounces::Converged));
    let once = stage.render(&gpu, GiMethod::CLPV, Layer::Indirect);
    assert!(once.rgba.iter().all(|p| p[0] > 0.0));
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
fn a_closed_room_fills_with_light_as_the_series_says() {
    // Far from its first bounce light is even: E = Φ·(1 + ρ + ρ² + …)·ρ/S, on the mean over the walls exactly.
    let gpu = gpu();
    let once = mean(&room(0.5, settings(Bounces::Count(1))).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    for albedo in [0.5_f32, 0.8, 1.0] {
        let mut last = 0.0;
        for (count, series) in [(1, 1.0), (2, 1.0 + albedo), (4, 1.0 + albedo + albedo.powi(2) + albedo.powi(3))] {
            let image = room(albedo, settings(Bounces::Count(count))).render(&gpu, GiMethod::CLPV, Layer::Indirect);
            let expected = once * (albedo / 0.5).powi(2) * series;
            let found = mean(&image);
            assert!(found > last, "bounce {count} added nothing");
            assert!((found / expected - 1.0).abs() < 0.12, "albedo {albedo}, {count} bounces: {found} for {expected}");
            last = found;
        }
    }
    let endless = mean(&room(0.8, settings(Bounces::Converged)).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    let many = mean(&room(0.8, settings(Bounces::Count(32))).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    assert!((endless / many - 1.0).abs() < 0.01, "converged {endless}, 32 bounces {many}");
    let white = mean(&room(1.0, settings(Bounces::Count(32))).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    assert!(white <= 32.0 * 1.1 * once * 4.0, "a white room gains: {white}");
}

#[test]
fn surfaces_that_lie_within_each_other_reflect_light_once() {
    // Panels half sunk into the ceiling: their upper faces and what they cover are in the dark, a few centimetres from
    // the light. Each of them has the irradiance of its cell, but the light is lost only once.
    let gpu = gpu();
    let settings = settings(Bounces::Count(8));
    let plain = mean(&room(0.8, settings.clone()).render(&gpu, GiMethod::CLPV, Layer::Indirect));
    let mut stage = room(0.8, settings);
    for x in [-1.0, 1.0] {
        for z in [-1.0, 1.0] {
            let panel = Shape::Box { size: Vec3::new(1.9, 0.06, 1.9).into() };
            stage.add(panel, Vec3::splat(0.8), Affine3A::from_translation(Vec3::new(x, 0.5 * ROOM.y - 0.01, z)));
        }
    }
    let panelled = mean(&stage.render(&gpu, GiMethod::CLPV, Layer::Indirect));
    assert!((panelled / plain - 1.0).abs() < 0.06, "{panelled} with panels, {plain} without");
}

#[test]
fn two_runs_give_the_same_bits_and_so_does_a_run_without_any_reuse() {
    let gpu = gpu();
    let stage = room(0.5, settings(Bounces::Converged));
    let first = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
    let mut renderer = Renderer::new(&gpu);
    stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    let (again, _) = stage.render_with(&gpu, &mut renderer, &RenderSettings { no_cache: true, ..Default::default() });
    assert_eq!(first, again);
}

#[test]
fn a_moved_camera_only_looks_again_and_a_changed_lamp_moves_no_surface() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let mut stage = room(0.5, settings(Bounces::Converged));
    stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    let (_, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    assert_eq!(report.ran_count(), 0, "{report}");
    stage.view.camera.world_from_view.translation.x -= 0.2;
    let (_, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    assert!(report.ran("relight"), "{report}");
    let ran = |report: &lightwell::graph::FrameReport, names: &[&str]| -> Vec<String> {
        let of = |pass: &&lightwell::graph::PassReport| names.iter().any(|name| pass.name.starts_with(name));
        report.passes.iter().filter(of).filter(|p| report.ran(&p.name)).map(|p| p.name.clone()).collect()
    };
    let of_light = ["rsm", "surfels", "opacity", "emit", "sweep", "receive"];
    assert_eq!(ran(&report, &of_light), Vec::<String>::new());
    stage.scene.lights[0].intensity *= 0.7;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    let (kept, report) = stage.render_with(&gpu, &mut renderer, &RenderSettings::default());
    assert_eq!(ran(&report, &["rsm", "surfels", "opacity"]), Vec::<String>::new());
    assert!(report.ran("sweep, cascade 0, bounce 1"), "{report}");
    assert_eq!(kept, stage.render(&gpu, GiMethod::CLPV, Layer::Total), "reuse changed a bit");
}

/// Light of a light on one side of a wall across the volume that is found on the other side, over what is on its own.
fn leak(gpu: &Gpu, thickness: f32, degrees: f32, shift: f32) -> f32 {
    let turn = Affine3A::from_rotation_y(degrees.to_radians());
    let mut both = [0.0; 2];
    for (mean_of, side) in both.iter_mut().zip([1.0, -1.0]) {
        // A floor on each side, seen from above; the wall stands between them.
        let eye = turn.transform_point3(Vec3::new(1.2 * side, 0.9, 0.0));
        let mut stage = Stage::new(eye, eye - Vec3::Y, 32);
        let place = |x: f32| turn * Affine3A::from_translation(Vec3::new(x + shift, 0.0, 0.0));
        let wall = place(0.0) * Affine3A::from_translation(Vec3::new(0.0, 1.0, 0.0));
        stage.add(Shape::Box { size: [thickness, 2.2, 8.0] }, Vec3::splat(0.7), wall);
        for x in [-2.0, 2.0] {
            let floor = place(x) * Affine3A::from_translation(Vec3::new(0.0, -0.2, 0.0));
            stage.add(Shape::Box { size: [4.0, 0.4, 8.0] }, Vec3::splat(0.7), floor);
        }
        let lamp = turn.transform_point3(Vec3::new(1.0 + shift, 0.6, 0.1));
        stage.light(
            LightShape::Spot { inner: 0.5, outer: 0.6 },
            Vec3::splat(2.0),
            lamp,
            turn.transform_vector3(Vec3::new(-1.0, -0.2, 0.0)),
        );
        stage.clpv(Vec3::ZERO, settings(Bounces::Count(1)));
        *mean_of = mean(&stage.render(gpu, GiMethod::CLPV, Layer::Indirect));
    }
    both[1] / both[0]
}

#[test]
fn flat_walls_do_not_leak() {
    let gpu = gpu();
    // Cells are of 0.44 to 0.5 m.
    let mut worst = 0.0_f32;
    for thickness in [0.05, 0.22, 0.45] {
        for degrees in [0.0, 17.0, 30.0, 45.0] {
            for shift in [0.0, 0.13] {
                let leaked = leak(&gpu, thickness, degrees, shift);
                assert!(leaked < 0.018, "wall of {thickness} m at {degrees}°, moved {shift} m: {leaked}");
                worst = worst.max(leaked);
            }
        }
    }
    eprintln!("largest leak {worst}");
}

#[test]
fn the_sum_of_lights_is_the_light_of_their_sum() {
    let gpu = gpu();
    let image = |which: &[usize]| {
        let mut stage = room(0.5, settings(Bounces::Count(3)));
        stage.scene.lights.clear();
        let lights = [(Vec3::new(0.3, 0.6, -0.2), 2.0), (Vec3::new(-0.9, -0.4, 0.8), 2e-6)];
        for &i in which {
            stage.light(LightShape::Point, Vec3::splat(lights[i].1), lights[i].0, Vec3::NEG_Y);
        }
        stage.render(&gpu, GiMethod::CLPV, Layer::Indirect)
    };
    let (both, swapped, first, second) = (image(&[0, 1]), image(&[1, 0]), image(&[0]), image(&[1]));
    assert_eq!(both.rgba, swapped.rgba, "the order of lights matters");
    for ((sum, a), b) in both.rgba.iter().zip(&first.rgba).zip(&second.rgba) {
        assert!((sum[0] - a[0] - b[0]).abs() <= 1e-5 * sum[0], "{} + {} gave {}", a[0], b[0], sum[0]);
    }
}
