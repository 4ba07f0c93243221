//! Direct light through the whole pipeline against the formulas that it stands for.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Vec3, Vec3Swizzles};
use lightwell::assets::{Material, Shape};
use lightwell::graph::PassState;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};
use std::f32::consts::PI;

const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);

/// A floor of 20 m edge at y = 0, seen from above.
fn floor() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 3.0, 2.0), Vec3::ZERO, 64);
    stage.add(Shape::Plane { size: [20.0, 20.0], subdivisions: [1, 1] }, ALBEDO, Affine3A::IDENTITY);
    stage
}

/// What rasterizers may move a visible point by, in x and in y \[pixels\]: half a step of the grid of 1/256 that they put
/// corners on, for each of the triangle's corners and for the point itself.
const GRID: f32 = 1.0 / 128.0;

/// Largest relative deviation from `expected(point on the floor)`, over pixels that see the floor: from what is expected
/// anywhere within the rasterizer's grid.
fn worst_deviation(stage: &Stage, expected: impl Fn(Vec3) -> Vec3) -> f32 {
    let image = stage.render(&gpu(), GiMethod::NONE, Layer::Direct);
    let eye = stage.view.eye();
    let on_floor = |ray: Vec3| eye - ray * (eye.y / ray.y);
    let mut worst = 0.0_f32;
    for y in 0..image.height {
        for x in 0..image.width {
            let ray = stage.ray(x, y);
            if ray.y > -0.05 {
                continue;
            }
            if on_floor(ray).abs().max_element() > 9.9 {
                continue;
            }
            let moved = [[0.0, 0.0], [-GRID, 0.0], [GRID, 0.0], [0.0, -GRID], [0.0, GRID]];
            let center = [x, y].map(|place| place as f32 + 0.5);
            let wanted = moved.map(|by| expected(on_floor(stage.ray_at(center[0] + by[0], center[1] + by[1]))));
            let (low, high) = (wanted.into_iter().reduce(Vec3::min), wanted.into_iter().reduce(Vec3::max));
            let got = rgb(&image, x, y);
            let nearest = got.clamp(low.expect("five"), high.expect("five"));
            worst = worst.max((got - nearest).abs().max_element() / wanted[0].max_element().max(1e-6));
        }
    }
    worst
}

#[test]
fn a_point_light_falls_off_by_cosine_and_square_of_distance() {
    let mut stage = floor();
    let (position, intensity) = (Vec3::new(0.5, 1.5, -0.3), Vec3::new(10.0, 20.0, 30.0));
    stage.light(LightShape::Point, intensity, position, Vec3::NEG_Y);
    let worst = worst_deviation(&stage, |point| {
        let offset = position - point;
        ALBEDO / PI * intensity * (offset.y / offset.length()) / offset.length_squared()
    });
    assert!(worst < 1e-3, "relative deviation {worst}");
}

#[test]
fn a_directional_light_is_the_same_everywhere() {
    let mut stage = floor();
    let direction = Vec3::new(0.4, -1.0, 0.3).normalize();
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, direction);
    let worst = worst_deviation(&stage, |_| ALBEDO / PI * 3.0 * -direction.y);
    assert!(worst < 1e-3, "relative deviation {worst}");
}

#[test]
fn a_spot_light_is_full_inside_and_zero_outside_its_cone() {
    let mut stage = floor();
    let (position, inner, outer) = (Vec3::new(0.0, 2.0, 0.0), 20.0_f32.to_radians(), 35.0_f32.to_radians());
    stage.light(LightShape::Spot { inner, outer }, Vec3::splat(8.0), position, Vec3::NEG_Y);
    let worst = worst_deviation(&stage, |point| {
        let offset = position - point;
        let cosine = offset.y / offset.length();
        let t = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        ALBEDO / PI * (8.0 * t * t * cosine / offset.length_squared())
    });
    assert!(worst < 1e-3, "relative deviation {worst}");
}

#[test]
fn a_range_ends_the_light() {
    let mut stage = floor();
    let position = Vec3::new(0.0, 1.0, 0.0);
    stage.light(LightShape::Point, Vec3::ONE, position, Vec3::NEG_Y).range = Some(2.0);
    let worst = worst_deviation(&stage, |point| {
        let offset = position - point;
        let d = offset.length();
        let window = (1.0 - (d / 2.0).powi(4)).clamp(0.0, 1.0);
        ALBEDO / PI * (window * offset.y / d / (d * d))
    });
    assert!(worst < 1e-3, "relative deviation {worst}");
}

#[test]
fn what_stands_before_the_light_casts_its_shadow_for_every_kind_of_light() {
    for shape in [LightShape::Point, LightShape::Directional, LightShape::Spot { inner: 1.0, outer: 1.2 }] {
        let mut stage = floor();
        let over = Affine3A::from_translation(Vec3::new(0.0, 1.0, 0.0));
        stage.add(Shape::Box { size: [1.0, 0.1, 1.0] }, ALBEDO, over);
        stage.light(shape, Vec3::splat(5.0), Vec3::new(0.0, 4.0, 0.0), Vec3::NEG_Y);
        // From below the box, so that the shadow is in view.
        stage.view.camera.world_from_view = Affine3A::from_rotation_x(-0.25) * Affine3A::IDENTITY;
        stage.view.camera.world_from_view.translation = Vec3::new(0.0, 0.8, 2.5).into();
        let image = stage.render(&gpu(), GiMethod::NONE, Layer::Direct);
        let eye = stage.view.eye();
        let (mut dark, mut lit) = (0, 0);
        for y in 0..image.height {
            for x in 0..image.width {
                let ray = stage.ray(x, y);
                let point = eye - ray * (eye.y / ray.y);
                if ray.y > -0.02 || point.abs().max_element() > 3.0 {
                    continue;
                }
                let radius = point.x.abs().max(point.z.abs());
                if radius < 0.45 {
                    assert_eq!(rgb(&image, x, y), Vec3::ZERO, "{shape:?}: light in the shadow at {point}");
                    dark += 1;
                } else if radius > 0.75 {
                    assert!(rgb(&image, x, y).min_element() > 0.0, "{shape:?}: shadow in the light at {point}");
                    lit += 1;
                }
            }
        }
        assert!(dark > 20 && lit > 100, "{shape:?}: {dark} dark and {lit} lit pixels");
    }
}

/// Pixels of the floor that are lit where a plate 1 m above it hides the light, or dark where it does not; beside the
/// plate's border, where rounding may decide, nothing is counted.
fn wrong_in_shadow(gi: GiMethod) -> usize {
    let mut stage = floor();
    let plate = Shape::Plane { size: [1.0, 1.0], subdivisions: [1, 1] };
    let mut material = Material::diffuse("plate", ALBEDO);
    material.double_sided = true;
    stage.add_material(plate, material, Affine3A::from_translation(Vec3::Y));
    let light = Vec3::new(0.3, 2.5, -0.2);
    stage.light(LightShape::Point, Vec3::splat(10.0), light, Vec3::NEG_Y).shadow_size = 32;
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Clpv::default() });
    let image = stage.render(&gpu(), gi, Layer::Direct);
    let eye = stage.view.eye();
    // Where a line from a point of the floor meets the plate's height, over half the plate's edge.
    let on_plate = |floor: Vec3, end: Vec3| (floor + (end - floor) / end.y).xz().abs().max_element() / 0.5;
    let mut wrong = 0;
    for y in 0..image.height {
        for x in 0..image.width {
            let ray = stage.ray(x, y);
            if ray.y > -0.05 {
                continue;
            }
            let point = eye - ray * (eye.y / ray.y);
            let (shadow, view) = (on_plate(point, light), on_plate(point, eye));
            if view > 1.01 && (shadow - 1.0).abs() > 2e-3 && point.xz().abs().max_element() < 9.9 {
                wrong += usize::from((rgb(&image, x, y) == Vec3::ZERO) != (shadow < 1.0));
            }
        }
    }
    wrong
}

/// A map of 32 texels a face cannot tell where the shadow ends; a ray can, and is cast whatever the method is.
#[test]
fn borders_of_shadows_are_exact_where_maps_are_coarse() {
    let wrong = [GiMethod::NONE, GiMethod::CLPV].map(wrong_in_shadow);
    assert_eq!(wrong, [0, 0], "wrong pixels without indirect light and with it");
}

#[test]
fn scaling_a_light_by_a_power_of_two_scales_the_image_exactly() {
    let mut stage = floor();
    stage.light(LightShape::Point, Vec3::new(0.3, 0.7, 1.1), Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_Y);
    let gpu = gpu();
    let once = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    for power in [-20, 20] {
        let factor = 2.0_f32.powi(power);
        stage.scene.lights[0].intensity = Vec3::new(0.3, 0.7, 1.1) * factor;
        stage.scene.lights[0].revision += 1;
        let scaled = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
        for (a, b) in once.rgba.iter().zip(&scaled.rgba) {
            for channel in 0..3 {
                assert_eq!(a[channel] * factor, b[channel]);
            }
        }
    }
}

#[test]
fn no_light_is_exactly_black_and_lights_add_up() {
    let gpu = gpu();
    let mut stage = floor();
    let dark = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    assert!(dark.rgba.iter().all(|p| p[..3] == [0.0; 3]));
    stage.light(LightShape::Point, Vec3::X, Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_Y);
    let first = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    stage.light(LightShape::Directional, Vec3::Y, Vec3::ZERO, Vec3::NEG_Y);
    let both = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    stage.scene.lights.remove(0);
    let second = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    for ((a, b), sum) in first.rgba.iter().zip(&second.rgba).zip(&both.rgba) {
        for channel in 0..3 {
            let expected = a[channel] + b[channel];
            assert!((sum[channel] - expected).abs() <= 1e-4 * expected.abs());
        }
    }
}

#[test]
fn a_light_of_any_strength_and_place_gives_finite_images() {
    let gpu = gpu();
    for intensity in [0.0, 1e-30, 1e30, f32::MAX] {
        for position in [Vec3::ZERO, Vec3::new(0.0, 1e-20, 0.0), Vec3::splat(1e6)] {
            let mut stage = floor();
            stage.light(LightShape::Point, Vec3::splat(intensity), position, Vec3::NEG_Y);
            stage.render(&gpu, GiMethod::NONE, Layer::Total);
        }
    }
}

#[test]
fn a_glossy_surface_reflects_the_light_towards_its_mirror_image() {
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 2.0), Vec3::ZERO, 65);
    let material = Material { roughness: 0.2, ..Material::new("varnish") };
    stage.add_material(Shape::Plane { size: [20.0, 20.0], subdivisions: [1, 1] }, material, Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(4.0), Vec3::new(0.0, 2.0, -2.0), Vec3::NEG_Y);
    let image = stage.render(&gpu(), GiMethod::NONE, Layer::Direct);
    let brightest =
        (0..65 * 65).max_by(|&a, &b| rgb(&image, a % 65, a / 65).x.total_cmp(&rgb(&image, b % 65, b / 65).x));
    let (x, y) = brightest.map(|i| (i % 65, i / 65)).expect("pixels");
    assert!(x.abs_diff(32) <= 1 && y.abs_diff(32) <= 2, "the highlight is at {x}, {y}");
}

#[test]
fn a_still_frame_is_kept_and_a_moved_light_pays_for_itself_alone() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu);
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let mut stage = floor();
    stage.light(LightShape::Point, Vec3::X, Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_Y);
    stage.light(LightShape::Directional, Vec3::Y, Vec3::ZERO, Vec3::NEG_Y);
    let (first, _) = stage.render_with(&gpu, &mut renderer, &settings);
    let (second, report) = stage.render_with(&gpu, &mut renderer, &settings);
    assert_eq!(first, second);
    assert_eq!(report.ran_count(), 0, "{report}");
    let moved = &mut stage.scene.lights[0];
    moved.position.x += 0.5;
    moved.revision += 1;
    let name = moved.pass_name();
    let (cached, report) = stage.render_with(&gpu, &mut renderer, &settings);
    let ran: Vec<&str> = report.passes.iter().filter(|p| p.state == PassState::Ran).map(|p| p.name.as_str()).collect();
    assert!(ran.contains(&format!("shadow {name}").as_str()), "{ran:?}");
    assert!(!ran.contains(&"gbuffer"), "{ran:?}");
    assert_eq!(ran.iter().filter(|name| name.starts_with("shadow")).count(), 1, "{ran:?}");
    let fresh = stage.render(&gpu, GiMethod::NONE, Layer::Total);
    assert_eq!(cached, fresh, "reuse changed a bit");
}

/// No shadow map tells of its change.
#[test]
fn a_light_without_shadows_that_changes_is_computed_anew() {
    let gpu = gpu();
    let mut stage = floor();
    stage.light(LightShape::Point, Vec3::splat(10.0), Vec3::new(0.5, 1.5, -0.3), Vec3::NEG_Y).casts_shadow = false;
    let mut renderer = Renderer::new(&gpu);
    let settings = RenderSettings { only: Layer::Direct, ..RenderSettings::default() };
    stage.render_with(&gpu, &mut renderer, &settings);
    stage.scene.lights[0].intensity *= 2.0;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    let (found, _) = stage.render_with(&gpu, &mut renderer, &settings);
    assert_eq!(found, stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).0);
}

#[test]
fn lights_without_shadows_share_a_pass_and_give_the_same_light() {
    let gpu = gpu();
    let mut stage = floor();
    stage.add(Shape::Sphere { radius: 0.5, segments: 32, rings: 16 }, ALBEDO, Affine3A::from_translation(Vec3::Y));
    for i in 0..150 {
        let place = Vec3::new(0.07 * i as f32 - 5.0, 0.3 + 0.01 * (i % 7) as f32, (i % 13) as f32 * 0.5 - 3.0);
        let shape = if i % 3 == 0 { LightShape::Spot { inner: 0.3, outer: 0.9 } } else { LightShape::Point };
        let light = stage.light(shape, Vec3::new(0.1, 0.2, 0.3), place, Vec3::NEG_Y);
        (light.casts_shadow, light.range) = (false, (i % 5 != 0).then_some(0.8));
    }
    stage.light(LightShape::Directional, Vec3::ONE, Vec3::ZERO, Vec3::new(0.3, -1.0, 0.2).normalize()).casts_shadow =
        true;
    let settings = |each_light_alone| RenderSettings {
        gi: GiMethod::NONE,
        only: Layer::Direct,
        each_light_alone,
        ..RenderSettings::default()
    };
    let (tiled, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings(false));
    let (alone, each) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings(true));
    for (a, b) in tiled.rgba.iter().zip(&alone.rgba) {
        for channel in 0..3 {
            assert!((a[channel] - b[channel]).abs() <= 1e-5 * b[channel].max(1e-3), "{a:?} for {b:?}");
        }
    }
    let passes = |report: &lightwell::graph::FrameReport| {
        report.passes.iter().filter(|p| p.name.starts_with("direct") && p.state == PassState::Ran).count()
    };
    assert!(passes(&report) < 5 && passes(&each) > 100, "{report}");
    assert!(report.ran("direct, lights without shadows"), "{report}");
    // A lamp that moves pays for the one pass, and again it is the same light.
    stage.scene.lights[7].position.y += 0.1;
    stage.scene.lights[7].revision += 1;
    let mut renderer = Renderer::new(&gpu);
    let (first, _) = stage.render_with(&gpu, &mut renderer, &settings(false));
    let (again, report) = stage.render_with(&gpu, &mut renderer, &settings(false));
    assert_eq!(first, again);
    assert!(!report.ran("direct, lights without shadows"), "{report}");
}
