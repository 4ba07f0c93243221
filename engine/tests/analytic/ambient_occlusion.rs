//! Screen-space ambient occlusion of the diffusion's light: its share of an image is that of the same image without it.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::FrameReport;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ViewProjection};
use lightwell::world::{CellSize, Clpv, Transport};
use std::f32::consts::PI;

const EDGE: u32 = 128;
const PASS: &str = "ambient occlusion";
/// Width and height of the wall \[m\], which stands at z = −1 and faces +z.
const WALL: [f32; 2] = [1.6, 0.7];

fn settings(radius: f32) -> Clpv {
    Clpv {
        transport: Transport::Diffusion,
        cells: [12, 8, 12],
        cell_size: CellSize::Meters(0.5),
        // Light everywhere.
        occlusion: false,
        steps: 24,
        ambient_occlusion: radius,
        ..Default::default()
    }
}

fn floor() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.3, 1.3, 1.6), Vec3::new(0.0, 0.3, -1.0), EDGE);
    let plane = Shape::Plane { size: [5.0, 5.0], subdivisions: [1, 1] };
    stage.add(plane, Vec3::splat(0.8), Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(3.0), Vec3::new(0.4, 1.6, 0.3), Vec3::NEG_Y);
    stage.clpv(Vec3::Y, settings(0.0));
    stage
}

fn floor_and_wall() -> Stage {
    let mut stage = floor();
    let at = Vec3::new(0.0, 0.5 * WALL[1], -1.0);
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.5 * PI), at);
    stage.add(Shape::Plane { size: WALL, subdivisions: [1, 1] }, Vec3::splat(0.8), turned);
    stage
}

fn draw(gpu: &Gpu, stage: &mut Stage, radius: f32) -> (ImageF32, FrameReport) {
    stage.clpv(Vec3::Y, settings(radius));
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    stage.render_with(gpu, &mut Renderer::new(gpu), &settings)
}

/// Pixels of the floor at least so far before the wall: its points, and the share of light that is left there.
fn shares(gpu: &Gpu, stage: &mut Stage, radius: f32) -> Vec<(Vec3, f32)> {
    let (whole, _) = draw(gpu, stage, 0.0);
    let (occluded, report) = draw(gpu, stage, radius);
    assert!(report.ran(PASS));
    let mut shares = Vec::new();
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        let (eye, ray) = match stage.view.camera.projection {
            ViewProjection::Orthographic { height } => {
                let at = glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / EDGE as f32 - 0.5;
                let local = Vec3::new(at.x, -at.y, 0.0) * height;
                let place = stage.view.camera.world_from_view;
                (place.transform_point3(local), place.transform_vector3(Vec3::NEG_Z))
            }
            ViewProjection::Perspective { .. } => (stage.view.eye(), stage.ray(x, y)),
        };
        let point = eye - ray * (eye.y / ray.y);
        let full = rgb(&whole, x, y).y;
        if ray.y < -0.05 && point.x.abs() < 2.4 && point.z.abs() < 2.4 && point.z > -0.97 && full > 0.0 {
            shares.push((point, rgb(&occluded, x, y).y / full));
        }
    }
    assert!(shares.len() > 500, "{} pixels", shares.len());
    shares
}

#[test]
fn a_plane_alone_is_open() {
    let gpu = gpu();
    for radius in [0.01, 0.3, 5.0, 1e6] {
        let mut stage = floor();
        let perspective = shares(&gpu, &mut stage, radius);
        stage.view.camera.projection = ViewProjection::Orthographic { height: 3.0 };
        for (point, share) in perspective.into_iter().chain(shares(&gpu, &mut stage, radius)) {
            assert!((share - 1.0).abs() < 1e-4, "radius {radius}, at {point}: {share}");
        }
    }
}

/// The form factor of the wall from a point of the floor, by small squares.
fn wall_from(point: Vec3) -> f32 {
    const STEPS: u32 = 200;
    let [w, h] = WALL.map(|edge| edge / STEPS as f32);
    let mut sum = 0.0;
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i as f32 + 0.5, j as f32 + 0.5))) {
        let offset = Vec3::new(i * w - 0.5 * WALL[0], j * h, -1.0) - point;
        sum += offset.y * -offset.z / offset.length_squared().powi(2) * (w * h);
    }
    sum / PI
}

#[test]
fn a_wall_hides_its_form_factor() {
    let gpu = gpu();
    let mut stage = floor_and_wall();
    // So far that nothing fades which the wall hides.
    let shares = shares(&gpu, &mut stage, 4.0);
    let (mut error, mut hidden, mut count, mut worst) = (0.0, 0.0, 0.0, 0.0_f32);
    for (point, share) in shares.into_iter().filter(|(point, _)| point.z < -0.1 && point.x.abs() < 0.6) {
        let expected = 1.0 - wall_from(point);
        worst = worst.max((share - expected).abs());
        error += share - expected;
        hidden += 1.0 - expected;
        count += 1.0;
    }
    println!("off by {} of {} on average, by {worst} at worst, {count} pixels", error / count, hidden / count);
    assert!((error / hidden).abs() < 0.1 && worst < 0.1, "off by {error} of {hidden}, {worst} at worst");
}

#[test]
fn what_is_beyond_the_radius_hides_nothing() {
    let gpu = gpu();
    let mut stage = floor_and_wall();
    let radius = 0.8;
    let (mut near, mut count) = (0.0, 0.0);
    for (point, share) in shares(&gpu, &mut stage, radius) {
        let distance = point.z + 1.0;
        // The filter reaches two pixels farther.
        if distance > radius + 0.2 {
            assert!((share - 1.0).abs() < 1e-4, "{share} at {point}");
        } else if distance < 0.15 * radius && point.x.abs() < 0.5 {
            near += share;
            count += 1.0;
        }
    }
    println!("{} over {count} pixels", near / count);
    // At the wall's foot nearly half of all light is hidden.
    assert!(count > 10.0 && near / count > 0.5 && near / count < 0.75, "{} over {count} pixels", near / count);
}

#[test]
fn it_is_off_unless_asked_for_and_finite_whatever_is_typed() {
    let gpu = gpu();
    let mut stage = floor_and_wall();
    let (plain, report) = draw(&gpu, &mut stage, 0.0);
    assert!(!report.ran(PASS), "{report}");
    for off in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let (image, report) = draw(&gpu, &mut stage, off);
        assert!(!report.ran(PASS) && image.rgba == plain.rgba, "{off}");
    }
    // The stage asserts that all pixels are finite.
    for radius in [f32::MIN_POSITIVE, 1e-9, 1e9, f32::MAX] {
        let (image, report) = draw(&gpu, &mut stage, radius);
        let [found, whole] = [&image, &plain].map(|image| image.rgba.iter().map(|p| p[1]).sum::<f32>());
        assert!(report.ran(PASS) && found > 0.5 * whole && found <= whole, "{radius}: {found} of {whole}");
    }
}
