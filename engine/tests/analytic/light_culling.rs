//! Stochastic light culling: its mean against the sum over all lights, the same bits whatever culls, and what must hold
//! at all scales.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::render::slc::{ACCEPTED, TESTED};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{
    Delta, LightBounds, LightChances, LightCulling, LightLobes, LightVisibility, StochasticLightCulling,
};

const BOUNDS: [LightBounds; 3] = [LightBounds::Ellipsoid, LightBounds::EnclosingSphere, LightBounds::CentredSphere];

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
    for chances in [LightChances::Even, LightChances::Independent] {
        check_mean(chances);
    }
}

fn check_mean(chances: LightChances) {
    let gpu = gpu();
    let all = StochasticLightCulling { culling: LightCulling::None, ..small() };
    let sum = indirect(&gpu, &stage(0.4, 16, 1.0, 5.0, all));
    let seeds = 256_u32;
    let pixels = sum.rgba.len();
    let (mut mean, mut square) = (vec![0.0_f64; pixels], vec![0.0_f64; pixels]);
    for seed in 0..seeds {
        let image = indirect(&gpu, &stage(0.4, 16, 1.0, 5.0, StochasticLightCulling { chances, seed, ..small() }));
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
    println!(
        "{chances:?}: spread {spread:.3} standard errors over {} pixels, bias of the image {bias:.5}",
        deviations.len()
    );
    assert!(deviations.len() > pixels / 2, "hardly any pixel has noise: the test says little");
    assert!(spread < 1.4 && bias.abs() < 0.01, "spread {spread}, bias {bias}");
}

/// One way of finding lights takes the same ones as another: they differ in what they test in vain alone.
#[test]
fn every_way_of_culling_gives_the_same_bits() {
    let gpu = gpu();
    let of = |culling, bounds| {
        let settings = StochasticLightCulling { culling, bounds, rsm_size: 128, interleave: 2, ..small() };
        indirect(&gpu, &stage(0.3, 64, 1.0, 5.0, settings))
    };
    let first = of(LightCulling::Tiled, LightBounds::Ellipsoid);
    assert!(first.rgba.iter().map(|pixel| pixel[0]).sum::<f32>() > 1.0, "there is nothing to compare");
    for culling in [LightCulling::Tiled, LightCulling::Clustered] {
        for bounds in BOUNDS {
            let image = of(culling, bounds);
            assert!(image.rgba == first.rgba, "{culling:?} with {bounds:?} gives another image");
        }
    }
}

#[test]
fn splatting_adds_the_same_lights() {
    let gpu = gpu();
    if !gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
        let settings = StochasticLightCulling { culling: LightCulling::Splatting, ..small() };
        assert!(refused(&gpu, settings).contains("blends 32-bit floats"));
        return;
    }
    // An edge that is no multiple of the interleaving: parts of the atlas then hang over the image.
    let of = |culling, bounds| {
        let stage = stage(0.3, 51, 1.0, 5.0, StochasticLightCulling { culling, bounds, ..small() });
        (indirect(&gpu, &stage), counts(&gpu, &stage))
    };
    for bounds in BOUNDS {
        let [(tiled, wanted), (splatted, found)] =
            [LightCulling::Tiled, LightCulling::Splatting].map(|c| of(c, bounds));
        assert_eq!(wanted[1], found[1], "accepted");
        assert!(found[0] >= found[1] && found[0] < wanted[0], "{bounds:?}: tested {} and {}", found[0], wanted[0]);
        for (a, b) in tiled.rgba.iter().zip(&splatted.rgba) {
            assert!((a[0] - b[0]).abs() <= 1e-4 * a[0].abs() + 1e-6, "{a:?} by tiles, {b:?} by splats");
        }
    }
}

/// What the renderer says of settings that it does not draw.
fn refused(gpu: &Gpu, settings: StochasticLightCulling) -> String {
    let stage = stage(0.3, 2048, 1.0, 5.0, settings);
    let frame = RenderSettings { gi: GiMethod::SLC, ..Default::default() };
    let result = Renderer::new(gpu).render(gpu, &stage.scene, &stage.view, &frame);
    result.expect_err("it cannot be drawn").to_string()
}

/// No other way of culling stands in for one that cannot be had.
#[test]
fn rivals_that_do_not_fit_are_refused_in_words() {
    let gpu = gpu();
    let clustered =
        StochasticLightCulling { culling: LightCulling::Clustered, rsm_size: 1024, interleave: 2, ..small() };
    let text = refused(&gpu, clustered);
    assert!(text.contains("masks") && text.contains("Clustered") && text.contains("MiB"), "{text}");
    let visibility = LightVisibility::ShadowRays;
    let shadowed = StochasticLightCulling { culling: LightCulling::Splatting, visibility, ..small() };
    let text = refused(&gpu, shadowed);
    assert!(text.contains("Splatting") && text.contains("shadow rays"), "{text}");
}

/// A stage all of gold: GGX lobes alone, since the spheres of diffuse ones differ little.
fn golden(roughness: f32, edge: u32, settings: StochasticLightCulling) -> Stage {
    let mut stage = stage(roughness, edge, 1.0, 5.0, settings);
    let gold = stage.scene.primitives.last().expect("the ball").material.clone();
    stage.scene.primitives.iter_mut().for_each(|primitive| primitive.material = gold.clone());
    stage
}

/// Figures 9 and 10 of 2017: the spheroid tests fewer lights in vain than the sphere around it, and that one fewer than
/// the centred sphere; 32 slices of depth test no more than two.
#[test]
fn ellipsoids_test_far_fewer_lights_in_vain_than_spheres() {
    let gpu = gpu();
    // GGX α = roughness² of 0.2, 0.1 and 0.04.
    for roughness in [0.447_f32, 0.316, 0.2] {
        let of = |bounds, culling| {
            let ways = StochasticLightCulling { bounds, culling, delta: Delta::Relative(1e-3), ..small() };
            counts(&gpu, &golden(roughness, 256, StochasticLightCulling { rsm_size: 128, ..ways }))
        };
        let [ellipsoids, enclosing, centred] = BOUNDS.map(|bounds| of(bounds, LightCulling::Tiled));
        let vain = [ellipsoids, enclosing, centred].map(|[tested, accepted]| tested - accepted);
        let fall = 1.0 - vain[0] / vain[2];
        println!("roughness {roughness}: {} wanted, in vain {vain:?}: {fall:.3}", ellipsoids[1]);
        assert!(ellipsoids[1] == enclosing[1] && ellipsoids[1] == centred[1], "the same lights are accepted");
        assert!(fall > 0.87, "roughness {roughness}: in vain {vain:?}");
        assert!(vain[0] < 0.6 * vain[1] && vain[1] < vain[2], "roughness {roughness}: in vain {vain:?}");
        let clustered = of(LightBounds::Ellipsoid, LightCulling::Clustered);
        assert!(clustered[0] <= ellipsoids[0] && clustered[1] == ellipsoids[1], "{clustered:?}, {ellipsoids:?}");
    }
}

/// Diffuse and GGX lobes shine alone, and together as the sum: table 2 and figure 9 count them apart.
#[test]
fn lobes_add_up() {
    let gpu = gpu();
    for culling in [LightCulling::Tiled, LightCulling::None] {
        let of = |lobes| {
            let stage = stage(0.5, 48, 1.0, 5.0, StochasticLightCulling { culling, lobes, ..small() });
            (indirect(&gpu, &stage), counts(&gpu, &stage))
        };
        let [both, diffuse, specular] = [LightLobes::Both, LightLobes::Diffuse, LightLobes::Specular].map(of);
        for (of_both, [a, b]) in both.1.iter().zip([0, 1].map(|i| [diffuse.1[i], specular.1[i]])) {
            assert!(a > 0.0 && b > 0.0 && *of_both == a + b, "{culling:?}: {of_both} lights, {a} and {b}");
        }
        let sums = diffuse.0.rgba.iter().zip(&specular.0.rgba).map(|(a, b)| a[0] + b[0]);
        for (sum, pixel) in sums.zip(&both.0.rgba) {
            assert!((sum - pixel[0]).abs() <= 1e-4 * pixel[0] + 1e-6, "{culling:?}: {sum} and {}", pixel[0]);
        }
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
