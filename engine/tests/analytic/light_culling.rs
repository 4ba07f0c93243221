//! Stochastic light culling: its mean against the sum over all lights, the same bits whatever culls, and what must hold
//! at all scales.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::render::slc::{ACCEPTED, TESTED};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Delta, LightBounds, LightCulling, LightVisibility, StochasticLightCulling};

/// A gold sphere of a roughness and a lamp in a room.
fn stage(roughness: f32, edge: u32, scale: f32, intensity: f32, settings: StochasticLightCulling) -> Stage {
    let at = |v: [f32; 3]| Vec3::from(v) * scale;
    let mut stage = Stage::new(at([1.4, 0.9, 1.5]), at([-1.0, -1.3, -1.2]), edge);
    stage.view.camera.near *= scale;
    stage.add_room(at([-2.0; 3]), at([4.0; 3]), Vec3::new(0.7, 0.5, 0.4));
    let mut gold = Material::diffuse("gold", Vec3::new(1.0, 0.77, 0.34));
    (gold.metallic, gold.roughness, gold.specular) = (1.0, roughness, 1.0);
    let ball = Shape::Sphere { radius: 0.7 * scale, segments: 48, rings: 24 };
    stage.add_material(ball, gold, Affine3A::from_translation(at([-0.4, -1.2, -0.3])));
    stage.light(LightShape::Point, Vec3::splat(intensity), at([0.6, 0.8, 0.2]), Vec3::NEG_Y);
    stage.scene.slc = Some(settings);
    stage
}

/// Few enough to be shaded all.
fn small() -> StochasticLightCulling {
    StochasticLightCulling {
        rsm_size: 64,
        interleave: 2,
        filter_radius: 0,
        delta: Delta::Relative(3e-3),
        ..Default::default()
    }
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::SLC, Layer::Indirect)
}

/// Lights tested and accepted, of all pixels.
fn counts(gpu: &Gpu, stage: &Stage) -> [f64; 2] {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::SLC, only: Layer::Indirect, ..Default::default() };
    let (_, report) = stage.render_with(gpu, &mut renderer, &settings);
    let passes = report.passes.iter().filter(|pass| ["slc cull", "slc shade"].contains(&pass.name.as_str()));
    println!("cull and shade {:.0} ms", passes.filter_map(|pass| pass.gpu_ms).sum::<f64>());
    [TESTED, ACCEPTED].map(|name| {
        let image = read_texture_f32(gpu, renderer.target(name).expect("a target")).expect("readable");
        image.rgba.iter().map(|pixel| f64::from(pixel[3])).sum()
    })
}

#[test]
fn the_mean_over_many_xi_is_the_sum_over_all_lights() {
    let gpu = gpu();
    let all = StochasticLightCulling { culling: LightCulling::None, ..small() };
    let sum = indirect(&gpu, &stage(0.4, 16, 1.0, 5.0, all));
    let seeds = 256_u32;
    let pixels = sum.rgba.len();
    let (mut mean, mut square) = (vec![0.0_f64; pixels], vec![0.0_f64; pixels]);
    for seed in 0..seeds {
        let image = indirect(&gpu, &stage(0.4, 16, 1.0, 5.0, StochasticLightCulling { seed, ..small() }));
        for (i, pixel) in image.rgba.iter().enumerate() {
            mean[i] += f64::from(pixel[0]) / f64::from(seeds);
            square[i] += f64::from(pixel[0]).powi(2) / f64::from(seeds);
        }
    }
    // Deviations in units of the standard error: their squares have mean 1 if there is noise and nothing else.
    let mut deviations = Vec::new();
    for (i, pixel) in sum.rgba.iter().enumerate() {
        let error = ((square[i] - mean[i].powi(2)).max(0.0) / f64::from(seeds)).sqrt();
        if error > 1e-6 * mean[i] {
            deviations.push((mean[i] - f64::from(pixel[0])) / error);
        }
    }
    let spread = (deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64).sqrt();
    let total: f64 = sum.rgba.iter().map(|pixel| f64::from(pixel[0])).sum();
    let bias = mean.iter().sum::<f64>() / total - 1.0;
    println!("spread {spread:.3} standard errors over {} pixels, bias of the image {bias:.5}", deviations.len());
    assert!(deviations.len() > pixels / 2, "hardly any pixel has noise: the test says little");
    assert!(spread < 1.4 && bias.abs() < 0.01, "spread {spread}, bias {bias}");
}

#[test]
fn bounds_of_either_kind_give_the_same_bits() {
    let gpu = gpu();
    let of = |bounds| {
        let settings = StochasticLightCulling { bounds, rsm_size: 128, interleave: 2, ..small() };
        indirect(&gpu, &stage(0.3, 64, 1.0, 5.0, settings))
    };
    assert!(of(LightBounds::Ellipsoid).rgba == of(LightBounds::CentredSphere).rgba, "spheres give another image");
}

#[test]
fn ellipsoids_test_far_fewer_lights_in_vain_than_centred_spheres() {
    let gpu = gpu();
    // GGX α = roughness² of 0.2, 0.1 and 0.04.
    for (roughness, least) in [(0.447_f32, 0.85), (0.316, 0.85), (0.2, 0.85)] {
        let of = |bounds| {
            let settings = StochasticLightCulling {
                bounds,
                rsm_size: 128,
                interleave: 2,
                delta: Delta::Relative(1e-3),
                ..small()
            };
            let mut stage = stage(roughness, 256, 1.0, 5.0, settings);
            // GGX lobes alone: the spheres of diffuse ones differ little.
            let gold = stage.scene.primitives.last().expect("the ball").material.clone();
            stage.scene.primitives.iter_mut().for_each(|primitive| primitive.material = gold.clone());
            counts(&gpu, &stage)
        };
        let [[ellipsoids, wanted], [spheres, same]] = [of(LightBounds::Ellipsoid), of(LightBounds::CentredSphere)];
        let fall = 1.0 - (ellipsoids - wanted) / (spheres - same);
        println!(
            "roughness {roughness}: {wanted} wanted, in vain {} and {}: {fall:.3}",
            ellipsoids - wanted,
            spheres - same
        );
        assert_eq!(wanted, same);
        assert!(fall > least, "roughness {roughness}: in vain {} of {}", ellipsoids - wanted, spheres - same);
    }
}

#[test]
fn all_scales_and_intensities_give_the_same_image() {
    let gpu = gpu();
    for roughness in [0.0, 0.1, 0.6] {
        let settings = || StochasticLightCulling { visibility: LightVisibility::ShadowRays, ..small() };
        let base = indirect(&gpu, &stage(roughness, 32, 1.0, 1.0, settings()));
        let sum = |image: &ImageF32| image.rgba.iter().map(|p| f64::from(p[0]) + f64::from(p[1])).sum::<f64>();
        let total = sum(&base);
        assert!(total > 0.0);
        for (scale, intensity) in [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e3, 1e-6), (1e-3, 1e6)] {
            let image = indirect(&gpu, &stage(roughness, 32, scale, intensity, settings()));
            let expected = total * f64::from(intensity) / f64::from(scale).powi(2);
            let ratio = sum(&image) / expected;
            assert!((ratio - 1.0).abs() < 1e-2, "roughness {roughness}, scale {scale}, intensity {intensity}: {ratio}");
        }
        // A power of two changes the exponent and no bit besides.
        let twice = indirect(&gpu, &stage(roughness, 32, 1.0, 2.0, settings()));
        assert!(twice.rgba.iter().zip(&base.rgba).all(|(a, b)| a[0] == 2.0 * b[0] && a[1] == 2.0 * b[1]));
    }
}

#[test]
fn a_wall_in_the_way_stops_light_only_with_shadow_rays() {
    let gpu = gpu();
    let of = |visibility| {
        let mut stage = stage(1.0, 32, 1.0, 5.0, StochasticLightCulling { visibility, ..small() });
        // Between the lamp and what the camera sees: all light there would have to pass through it.
        let wall = Shape::Box { size: [0.2, 3.99, 3.99] };
        stage.add(wall, Vec3::splat(0.5), Affine3A::IDENTITY);
        stage.scene.lights[0].position = Vec3::new(-1.0, 1.0, 0.0);
        stage.view.camera.world_from_view.translation.x = 1.9;
        let view = &mut stage.view.camera.world_from_view;
        *view = Affine3A::from_translation(Vec3::new(1.0, 0.0, 1.5));
        let image = indirect(&gpu, &stage);
        image.rgba.iter().map(|p| f64::from(p[0])).sum::<f64>()
    };
    let [through, stopped] = [of(LightVisibility::None), of(LightVisibility::ShadowRays)];
    assert!(through > 1.0, "the room behind the wall gets {through}");
    assert!(stopped < 1e-3 * through, "{stopped} of {through} passes the wall");
}

/// On an open floor E = π·L, and ρ·L is reflected; a box over it takes what it covers.
#[test]
fn the_sky_lights_what_sees_it() {
    let gpu = gpu();
    let of = |covered: bool, visibility| {
        let mut stage = Stage::new(Vec3::new(0.0, 0.8, 0.4), Vec3::new(0.0, -1.0, -0.2), 16);
        stage.add(Shape::Plane { size: [9.0, 9.0], subdivisions: [1, 1] }, Vec3::splat(0.5), Affine3A::IDENTITY);
        if covered {
            let lid = Affine3A::from_translation(Vec3::new(0.0, 1.2, 0.0));
            stage.add(Shape::Box { size: [60.0, 0.2, 60.0] }, Vec3::ZERO, lid);
        }
        stage.scene.sky = Vec3::new(1.0, 2.0, 0.5);
        stage.scene.slc = Some(StochasticLightCulling { visibility, interleave: 4, filter_radius: 4, ..small() });
        let image = indirect(&gpu, &stage);
        Vec3::from([0, 1, 2].map(|c| image.rgba.iter().map(|p| p[c]).sum::<f32>() / image.rgba.len() as f32))
    };
    let open = of(false, LightVisibility::ShadowRays);
    assert!((open - Vec3::new(0.5, 1.0, 0.25)).abs().max_element() < 5e-3, "{open}");
    let covered = of(true, LightVisibility::ShadowRays);
    assert!(covered.max_element() < 0.01, "{covered}");
    assert_eq!(of(false, LightVisibility::None), Vec3::ZERO);
}

#[test]
fn no_light_is_exactly_none_and_too_many_are_an_error() {
    let mut gpu = gpu();
    // Cards may bind more.
    gpu.limits.max_storage_buffer_binding_size = 128 << 20;
    let dark = indirect(&gpu, &stage(0.3, 16, 1.0, 0.0, small()));
    assert!(dark.rgba.iter().all(|pixel| pixel[..3] == [0.0; 3]));
    let settings = StochasticLightCulling { rsm_size: 4096, ..small() };
    let many = stage(0.3, 16, 1.0, 1.0, settings);
    let mut renderer = Renderer::new(&gpu);
    let frame = RenderSettings { gi: GiMethod::SLC, ..Default::default() };
    let error = renderer.render(&gpu, &many.scene, &many.view, &frame).expect_err("16 million lights do not fit");
    let text = error.to_string();
    assert!(text.contains("virtual lights take") && text.contains("rsm_size"), "{text}");
}
