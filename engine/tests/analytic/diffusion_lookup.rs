//! How the diffusion's light reaches the visible surfaces: lookups, gradient damping, the march for gloss and the fades of
//! cascades, against host formulas on the coefficients that the device holds.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, UVec3, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_buffer};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv, Formulas, GlossMarch, Transport};
use std::f32::consts::PI;

const EDGE: u32 = 48;
const CELL: f32 = 0.5;
const CELLS: UVec3 = UVec3::new(9, 7, 8);
const CENTER: Vec3 = Vec3::new(0.1, 1.2, -0.2);
const BANDS: [f32; 2] = [0.282_094_8, 0.488_602_5];

/// A floor beside a wall, lit from above.
fn stage(floor: Material, settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.3, 1.8, 1.2), Vec3::new(0.0, 0.0, -0.2), EDGE);
    stage.add_material(Shape::Plane { size: [4.0, 4.0], subdivisions: [1, 1] }, floor, Affine3A::IDENTITY);
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_z(-0.5 * PI), Vec3::new(-1.4, 1.0, 0.0));
    stage.add(Shape::Plane { size: [2.0, 3.0], subdivisions: [1, 1] }, Vec3::new(0.8, 0.3, 0.1), turned);
    stage.light(LightShape::Point, Vec3::new(3.0, 2.0, 1.0), Vec3::new(0.4, 1.6, 0.3), Vec3::NEG_Y);
    stage.clpv(CENTER, settings);
    stage
}

fn settings() -> Clpv {
    Clpv {
        transport: Transport::Diffusion,
        cells: CELLS.to_array(),
        cell_size: CellSize::Meters(CELL),
        steps: 6,
        gain: 0.9,
        ..Default::default()
    }
}

/// The indirect image, and the coefficients of its finest cascade.
fn draw(gpu: &Gpu, stage: &Stage) -> (ImageF32, Vec<[f32; 12]>) {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    let (image, _) = stage.render_with(gpu, &mut renderer, &settings);
    (image, read_buffer(gpu, renderer.buffer("propagate, cascade 0").expect("a volume")).expect("readable"))
}

/// Coefficients at a point, trilinear between the centres of cells.
fn sample(light: &[[f32; 12]], point: Vec3) -> [f32; 12] {
    let origin = CENTER - 0.5 * CELLS.as_vec3() * CELL;
    let at = ((point - origin) / CELL - 0.5).clamp(Vec3::ZERO, (CELLS - 1).as_vec3());
    let (low, t) = (at.floor(), at.fract());
    let mut sum = [0.0; 12];
    for corner in 0..8_u32 {
        let upper = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
        let cell = (low.as_uvec3() + upper).min(CELLS - 1);
        let weight = (0..3).map(|i| if upper[i] == 1 { t[i] } else { 1.0 - t[i] }).product::<f32>();
        let values = light[((cell.z * CELLS.y + cell.y) * CELLS.x + cell.x) as usize];
        (0..12).for_each(|i| sum[i] += weight * values[i]);
    }
    sum
}

/// A cell's light times a vector of coefficients (1, y, z, x), by channel.
fn dot(cell: [f32; 12], with: [f32; 4]) -> Vec3 {
    let channel = |c: usize| (0..4).map(|i| cell[4 * c + i] * with[i]).sum::<f32>().max(0.0);
    Vec3::new(channel(0), channel(1), channel(2))
}

fn lobe(n: Vec3) -> [f32; 4] {
    let one = 2.0 / 3.0 * PI * BANDS[1];
    [PI * BANDS[0], one * n.y, one * n.z, one * n.x]
}

fn basis(d: Vec3) -> [f32; 4] {
    [BANDS[0], BANDS[1] * d.y, BANDS[1] * d.z, BANDS[1] * d.x]
}

/// The largest square of the central differences over one cell along the normal, over that of the coefficients.
fn gradient(light: &[[f32; 12]], at: Vec3, n: Vec3) -> f32 {
    let [ahead, behind, here] = [0.5, -0.5, 0.0].map(|cells| sample(light, at + n * (cells * CELL)));
    let channel = |c: usize| {
        let square = |of: &dyn Fn(usize) -> f32| (4 * c..4 * c + 4).map(|i| of(i).powi(2)).sum::<f32>();
        square(&|i| ahead[i] - behind[i]) / square(&|i| here[i])
    };
    (0..3).map(channel).fold(0.0, f32::max)
}

/// Points of the floor that pixels show, away from its edges and the wall, with the directions that they are seen from.
fn floor_pixels(stage: &Stage) -> Vec<([u32; 2], Vec3, Vec3)> {
    let eye = stage.view.eye();
    let mut pixels = Vec::new();
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        let ray = stage.ray(x, y);
        let point = eye - ray * (eye.y / ray.y);
        if ray.y < -0.1 && point.x.abs() < 1.2 && point.z.abs() < 1.2 {
            pixels.push(([x, y], point, -ray));
        }
    }
    assert!(pixels.len() > 200, "{} pixels", pixels.len());
    pixels
}

fn assert_close(found: Vec3, expected: Vec3, tolerance: f32, what: &str) {
    let difference = (found - expected).abs().max_element();
    assert!(difference <= tolerance * expected.max_element() + 1e-7, "{what}: {found} in place of {expected}");
}

#[test]
fn lookups_damping_and_both_offsets_follow_the_host_formula() {
    let gpu = gpu();
    let albedo = Vec3::new(0.4, 0.6, 0.8);
    for (formulas, offset) in [(Formulas::Corrected, 0.5), (Formulas::Printed, 0.0)] {
        for damping in [0.0, 1.0, 7.0] {
            let clpv = Clpv { gradient_damping: damping, formulas, ..settings() };
            let stage = stage(Material::diffuse("floor", albedo), clpv);
            let (image, light) = draw(&gpu, &stage);
            for ([x, y], point, _) in floor_pixels(&stage) {
                let at = point + Vec3::Y * (offset * CELL);
                let damped = 1.0 + damping * gradient(&light, at, Vec3::Y);
                let expected = albedo * dot(sample(&light, at), lobe(Vec3::NEG_Y)) * (0.9 / PI / damped);
                assert_close(
                    rgb(&image, x, y),
                    expected,
                    2e-3,
                    &format!("{formulas:?}, damping {damping}, pixel {x} {y}"),
                );
            }
        }
    }
}

#[test]
fn damping_darkens_what_leaks_through_a_wall_more_than_what_is_lit() {
    let gpu = gpu();
    // A partition between a lit and a dark half, thinner than a cell.
    let image = |damping: f32| {
        let clpv = Clpv { gradient_damping: damping, occlusion: false, ..settings() };
        let mut stage = Stage::new(Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0), EDGE);
        for sign in [-1.0, 1.0] {
            let turned = Affine3A::from_rotation_translation(
                Quat::from_rotation_z(-sign * 0.5 * PI),
                Vec3::new(0.01 * sign, 1.0, 0.0),
            );
            stage.add(Shape::Plane { size: [3.0, 3.0], subdivisions: [1, 1] }, Vec3::splat(0.7), turned);
        }
        stage.light(LightShape::Spot { inner: 0.6, outer: 0.7 }, Vec3::splat(3.0), Vec3::new(-1.5, 1.0, 0.0), Vec3::X);
        stage.clpv(CENTER, clpv);
        draw(&gpu, &stage).0.rgba.iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    let (open, damped) = (image(0.0), image(4.0));
    assert!(open > 0.0, "nothing leaks");
    assert!(damped < 0.6 * open, "{damped} of {open} leaks");
}

#[test]
fn the_march_weights_its_steps_as_it_says() {
    let gpu = gpu();
    let (roughness, steps) = (0.2, 8);
    let metal = Material { metallic: 1.0, roughness, ..Material::diffuse("floor", Vec3::ONE) };
    for (gloss_march, power) in [(GlossMarch::InverseDistance, 1), (GlossMarch::InverseSquare, 2)] {
        let stage = stage(metal.clone(), Clpv { gloss_march, ..settings() });
        let (image, light) = draw(&gpu, &stage);
        let bounds = CELLS.as_vec3() * (0.5 * CELL);
        for ([x, y], point, to_eye) in floor_pixels(&stage) {
            let mirror = Vec3::new(-to_eye.x, to_eye.y, -to_eye.z);
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for d in 1..=steps {
                let at = point + Vec3::Y * (0.5 * CELL) + mirror * (d as f32 * CELL);
                if (at - CENTER).abs().cmpge(bounds).any() {
                    break;
                }
                let weight = (d as f32).powi(-power);
                sum += weight * dot(sample(&light, at), basis(-mirror));
                weights += weight;
            }
            // A smooth white metal reflects nearly all.
            let reflected = rgb(&image, x, y) / (sum / weights);
            let what = format!("{gloss_march:?}, pixel {x} {y}: {reflected} of the marched light");
            assert!(reflected.min_element() > 0.93 && reflected.max_element() < 1.005, "{what}");
            assert!(reflected.max_element() - reflected.min_element() < 5e-3, "{what}");
        }
    }
}

#[test]
fn rougher_surfaces_march_less_far_and_diffuse_ones_not_at_all() {
    let gpu = gpu();
    let report = |floor: Material| {
        let stage = stage(floor, Clpv { gloss_march: GlossMarch::InverseDistance, ..settings() });
        stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default()).1
    };
    assert!(!report(Material::diffuse("floor", Vec3::ONE)).ran("gloss march"));
    assert!(report(Material { specular: 1.0, ..Material::diffuse("floor", Vec3::ONE) }).ran("gloss march"));
}

#[test]
fn the_coarsest_cascade_fades_into_the_outside_where_that_is_asked_for() {
    let gpu = gpu();
    let image = |outside_fade: f32| {
        let stage = stage(Material::diffuse("floor", Vec3::ONE), Clpv { outside_fade, ..settings() });
        let pixels = floor_pixels(&stage);
        (draw(&gpu, &stage).0, pixels)
    };
    let ((whole, pixels), (faded, _)) = (image(0.0), image(3.0));
    let half = CELLS.as_vec3() * (0.5 * CELL);
    for ([x, y], point, _) in pixels {
        let margin = (half - (point - CENTER).abs()).min_element();
        let share = (margin / (3.0 * CELL)).clamp(0.0, 1.0);
        assert_close(rgb(&faded, x, y), rgb(&whole, x, y) * share, 3e-3, &format!("pixel {x} {y}"));
    }
}

/// Relighting leaves out tiles that show no volume, and says how many. What lies outside of the volume is black, in those
/// tiles and in the others.
#[test]
fn tiles_that_show_no_volume_are_left_out() {
    let gpu = gpu();
    let clpv = Clpv { cells: [3, 3, 3], ..settings() };
    let mut stage = stage(Material::diffuse("floor", Vec3::ONE), clpv.clone());
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    let (eye, center) = (stage.view.eye(), Vec3::new(-0.4, 0.3, -1.2));
    stage.clpv(center, clpv);
    for is_in_view in [true, false] {
        if !is_in_view {
            // It lies behind the camera.
            stage.view = Stage::new(eye, eye + Vec3::new(0.0, 2.0, 1.0), EDGE).view;
        }
        let (image, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
        let left_out = report.pass("relight, tiles").expect("a count").why.clone();
        let count: u64 = left_out.split(' ').next().and_then(|word| word.parse().ok()).expect("a number");
        assert_eq!(report.pass("relight").expect("a pass").counts.texels, 64 * (36 - count), "{left_out}");
        assert_eq!((count == 36, count > 4 && count < 36), (!is_in_view, is_in_view), "{left_out}");
        let mut lit = 0;
        for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
            let ray = stage.ray(x, y);
            let point = eye - ray * (eye.y / ray.y);
            let is_lit = rgb(&image, x, y).max_element() > 0.0;
            let off = (point - center).abs().max_element() / (1.5 * CELL);
            // Not the wall, which hides a part of the floor.
            assert!(!is_lit || off < 1.01 || point.x < -1.3, "pixel {x} {y} at {point}");
            lit += u32::from(is_lit);
        }
        assert_eq!(lit > 50, is_in_view, "{lit} pixels");
    }
}

/// A volume so large that its corners leave the range of floats is relit everywhere.
#[test]
fn volumes_beyond_floats_are_finite() {
    let gpu = gpu();
    for size in [1e30, 3e37, 1e-30] {
        let clpv = Clpv { cell_size: CellSize::Meters(size), ..settings() };
        draw(&gpu, &stage(Material::diffuse("floor", Vec3::ONE), clpv));
    }
}
