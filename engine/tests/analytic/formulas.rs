//! Terms that passes share with the path tracer, against formulas: comparing both would not find a fault in them.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Vec3, Vec3Swizzles, Vec4};
use lightwell::assets::{Material, Shape, SkyMap};
use lightwell::gpu::ImageF32;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, GatherRays, Quality};
use std::f32::consts::PI;
use std::sync::Arc;

/// glTF 2.0, appendix B, rewritten: reflected over incident radiance times n·l [1/sr].
fn gltf(material: &Material, n: Vec3, to_eye: Vec3, to_light: Vec3) -> Vec3 {
    let base = material.base_color.truncate();
    let h = (to_eye + to_light).normalize();
    let (n_l, n_v, n_h, v_h) = (n.dot(to_light), n.dot(to_eye), n.dot(h), to_eye.dot(h));
    let f0 = Vec3::splat(0.04).lerp(base, material.metallic);
    let f = f0 + (Vec3::ONE - f0) * (1.0 - v_h).powi(5);
    let a2 = material.roughness.powi(4);
    let d = a2 / (PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2));
    let smith = |a: f32, b: f32| a * (b * b * (1.0 - a2) + a2).sqrt();
    let v = 0.5 / (smith(n_l, n_v) + smith(n_v, n_l));
    ((1.0 - f.max_element()) * base * (1.0 - material.metallic) / PI + f * d * v) * n_l
}

#[test]
fn gloss_is_that_of_gltf() {
    for (metallic, roughness) in [(0.0, 0.3), (0.0, 0.8), (0.6, 0.5), (1.0, 0.4)] {
        let base_color = Vec4::new(0.8, 0.5, 0.2, 1.0);
        let material = Material { base_color, metallic, roughness, ..Material::new("gloss") };
        // Low above the floor, where the Fresnel term counts.
        let mut stage = Stage::new(Vec3::new(0.0, 0.5, 2.0), Vec3::new(0.0, 0.0, 0.0), 48);
        let floor = Shape::Plane { size: [20.0; 2], subdivisions: [1; 2] };
        stage.add_material(floor, material.clone(), Affine3A::IDENTITY);
        let (lamp, intensity) = (Vec3::new(0.4, 0.7, -2.0), Vec3::new(4.0, 5.0, 6.0));
        stage.light(LightShape::Point, intensity, lamp, Vec3::NEG_Y);
        let image = stage.render(&gpu(), GiMethod::NONE, Layer::Direct);
        let eye = stage.view.eye();
        let mut count = 0;
        for (x, y) in (0..48 * 48).map(|i| (i % 48, i / 48)) {
            let ray = stage.ray(x, y);
            if ray.y > -0.1 {
                continue;
            }
            let offset = lamp - (eye - ray * (eye.y / ray.y));
            let expected = gltf(&material, Vec3::Y, -ray, offset.normalize()) * intensity / offset.length_squared();
            let found = rgb(&image, x, y);
            // F0 is kept in ten bits, roughness and colours in sixteen.
            let tolerance = 0.01 * expected.max_element();
            let name = format!("metallic {metallic}, roughness {roughness}, pixel {x}, {y}");
            assert!((found - expected).abs().max_element() < tolerance, "{name}: {found}, expected {expected}");
            count += 1;
        }
        assert!(count > 400, "{count} pixels");
    }
}

/// Each face of a point light's map holds what stands before it: boxes in all six directions, each at another place.
#[test]
fn shadows_of_a_point_light_fall_in_all_directions() {
    let gpu = gpu();
    for (number, axis) in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate() {
        // From beside the box, at the wall with its shadow.
        let mut stage = Stage::new(0.9 * axis + 1.6 * axis.zxy(), 2.0 * axis, 32);
        stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::splat(0.7));
        let aside = axis.yzx() * (0.15 * number as f32 - 0.3) + axis.zxy() * (0.3 - 0.1 * number as f32);
        let at = Affine3A::from_translation(axis * 1.2 + aside);
        stage.add(Shape::Box { size: [0.5; 3] }, Vec3::splat(0.5), at);
        let light = stage.light(LightShape::Point, Vec3::splat(3.0), Vec3::ZERO, Vec3::NEG_Y);
        light.shadow_size = 1024;
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
        let mut tracer = PathTracer::new(&gpu);
        tracer.begin(&gpu, &stage.scene, &stage.view, &TraceSettings { bounces: Some(0), seed: 1 }).unwrap();
        tracer.advance(&gpu, 16).unwrap();
        let truth = tracer.estimate(&gpu).unwrap().direct();
        let (nrmse, bias) = error(&image, &truth);
        println!("{axis}: nrmse {nrmse:.4}, bias {bias:+.4}");
        assert!(nrmse < 0.22 && bias.abs() < 0.03, "towards {axis}: nrmse {nrmse}, bias {bias}");
    }
}

/// A mirrored ball is a ball: what faces the light is lit.
#[test]
fn mirrored_objects_keep_their_outside() {
    let gpu = gpu();
    let of = |scale: Vec3| {
        let mut stage = Stage::new(Vec3::new(0.0, 0.5, 2.0), Vec3::ZERO, 48);
        let ball = Shape::Sphere { radius: 0.8, segments: 64, rings: 32 };
        stage.add(ball, Vec3::splat(0.7), Affine3A::from_scale(scale));
        stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::new(-0.6, -1.0, -0.4));
        stage.render(&gpu, GiMethod::NONE, Layer::Direct)
    };
    let plain = of(Vec3::ONE);
    let expected = Image::from_rgba(48, 48, &plain.rgba).unwrap();
    assert!(expected.mean() > 0.02, "it is lit");
    for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::NEG_ONE] {
        let (nrmse, bias) = error(&of(scale), &expected);
        assert!(nrmse < 0.05 && bias.abs() < 0.01, "{scale}: nrmse {nrmse}, bias {bias}");
    }
}

/// The brightest texel of a turned sky is seen where the map says that it lies.
#[test]
fn a_turned_sky_is_seen_where_it_lies() {
    let (gpu, dir) = (gpu(), tempfile::tempdir().unwrap());
    let path = dir.path().join("star.exr");
    for (column, row, turn) in [(5, 6, 0.0), (5, 6, 0.9), (20, 9, -2.0), (30, 4, 2.5)] {
        let value = |i: u32| if (i % 32, i / 32) == (column, row) { [50.0; 3] } else { [0.5; 3] };
        let image = Image::from_pixels(32, 16, (0..512).map(value).collect()).unwrap();
        lightwell::measure::write_image(&path, &image).unwrap();
        let map = SkyMap::load(&path, 1.0, turn).unwrap();
        let mut stage = Stage::new(Vec3::ZERO, map.direction(column, row), 33);
        stage.scene.sky = map.mean();
        stage.scene.sky_map = Some(Arc::new(map));
        for gi in [GiMethod::NONE, GiMethod::REFERENCE] {
            let seen = stage.render(&gpu, gi, Layer::Total);
            let middle = rgb(&seen, 16, 16).x;
            assert!(middle > 40.0, "{column}, {row} turned by {turn} with {gi:?}: {middle}");
        }
    }
}

/// What was behind a thing that goes away takes none of the light that the thing had.
#[test]
fn what_comes_into_view_has_no_light_of_what_hid_it() {
    let gpu = gpu();
    let clpv = Clpv {
        bounces: Bounces::Count(1),
        quality: Quality::Low,
        gather_rays: GatherRays::Count(8),
        gather_filter: 0,
        ..Default::default()
    };
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 1.8), Vec3::new(0.0, -0.2, -2.0), 48);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::splat(0.6));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.0, 1.7, -1.7), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, clpv);
    let place = |at| Affine3A::from_translation(at);
    stage.add(Shape::Box { size: [1.2, 1.2, 0.2] }, Vec3::new(0.1, 0.8, 0.1), place(Vec3::new(0.0, 0.0, 0.4)));
    let settings = |only, average| RenderSettings { only, display: false, average, ..Default::default() };
    let light = settings(Layer::Indirect, true);
    let mut renderer = Renderer::new(&gpu);
    let mut before = stage.render_with(&gpu, &mut renderer, &light).0;
    for _ in 0..30 {
        before = stage.render_with(&gpu, &mut renderer, &light).0;
    }
    let albedo = |stage: &Stage| stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings(Layer::Albedo, false)).0;
    let hidden = albedo(&stage);
    // Behind the camera.
    let thing = stage.scene.primitives.last_mut().unwrap();
    thing.world_from_object = place(Vec3::new(0.0, 0.0, 1.95));
    thing.bounds = thing.mesh.bounds.transformed(&thing.world_from_object);
    thing.geometry_revision += 1;
    stage.scene.revisions.geometry += 1;
    let kept = stage.render_with(&gpu, &mut renderer, &light).0;
    let fresh = stage.render_with(&gpu, &mut Renderer::new(&gpu), &light).0;
    let revealed: Vec<usize> = (0..hidden.rgba.len()).filter(|&i| hidden.rgba[i][1] > 0.7).collect();
    assert!(revealed.len() > 100, "{} pixels", revealed.len());
    let mean = |image: &ImageF32, reflectance: f32| {
        revealed.iter().map(|&i| image.rgba[i][1] / reflectance).sum::<f32>() / revealed.len() as f32
    };
    let (before, kept, fresh) = (mean(&before, 0.8), mean(&kept, 0.6), mean(&fresh, 0.6));
    println!("over reflectance: before {before:.4}, then {kept:.4}, and {fresh:.4} from nothing");
    assert!((before / fresh - 1.0).abs() > 0.15, "the thing had other light");
    assert!((kept - fresh).abs() < 0.3 * (before - fresh).abs(), "light of the thing stays");
}
