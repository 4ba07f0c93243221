//! Each formula of the report "Virtual Point Lights" (E. Franchi and L. Ferrante) against numbers worked out by hand.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::vpl::virtual_lights;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{
    Accumulation, InstantRadiosity, ParticleBounce, ParticleCasts, ParticleSequence, ShadowLookup, VirtualShading,
    VirtualVisibility,
};
use std::f32::consts::PI;

/// As the preset `report` of the shipped scenes has it, with so many particles.
fn report(particles: u32) -> InstantRadiosity {
    InstantRadiosity {
        particles,
        sequence: ParticleSequence::Random,
        casts: ParticleCasts::BruteForce,
        bounce: ParticleBounce::Mirror,
        shading: VirtualShading::AsPublished,
        visibility: VirtualVisibility::None,
        accumulation: Accumulation::ByTheLetter,
        shadow_lookup: ShadowLookup::AsPublished,
        shadow_bias: 0.02,
        shadow_slope_bias: 0.1,
        shadow_samples: 1,
        ..Default::default()
    }
}

fn draw(gpu: &Gpu, stage: &mut Stage, settings: InstantRadiosity, only: Layer) -> (ImageF32, Renderer, u64) {
    stage.scene.vpl = Some(settings);
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::VPL, only, display: false, ..Default::default() };
    let (image, report) = stage.render_with(gpu, &mut renderer, &settings);
    (image, renderer, report.total().draws)
}

fn plane(edge: f32) -> Shape {
    Shape::Plane { size: [edge; 2], subdivisions: [1; 2] }
}

/// Half the edge of the room around the origin.
const HALF: f32 = 1.5;
const LAMP: Vec3 = Vec3::new(-0.5, 0.8, 0.3);
const LIGHT: Vec3 = Vec3::new(3.0, 2.0, 1.0);
const EYE: Vec3 = Vec3::new(0.0, 0.2, 1.3);

/// A closed room with nothing but a lamp.
fn room(albedo: f32, edge: u32) -> Stage {
    let mut stage = Stage::new(EYE, Vec3::new(0.1, -0.1, 0.0), edge);
    stage.add_room(Vec3::splat(-HALF), Vec3::splat(2.0 * HALF), Vec3::splat(albedo));
    stage.light(LightShape::Point, LIGHT, LAMP, Vec3::Y);
    stage
}

/// Where a ray from the eye meets the room, and the normal there.
fn wall(ray: Vec3) -> (Vec3, Vec3) {
    let distance = |axis: usize| (HALF * ray[axis].signum() - EYE[axis]) / ray[axis];
    let axis = (0..3).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).expect("three axes");
    let mut normal = Vec3::ZERO;
    normal[axis] = -ray[axis].signum();
    (EYE + distance(axis) * ray, normal)
}

/// "Rendering the Point Light with Shadows": 1/N · ρ/π · (1 − s) · L · max(n·l, 0), whatever the distance.
#[test]
fn the_main_light_by_the_report() {
    let gpu = gpu();
    for particles in [1, 8] {
        let mut stage = room(0.5, 16);
        let image = draw(&gpu, &mut stage, report(particles), Layer::Direct).0;
        for (x, y) in [(1, 1), (8, 8), (3, 12), (14, 9), (8, 14), (8, 1)] {
            let (at, normal) = wall(stage.ray(x, y));
            let cosine = normal.dot((LAMP - at).normalize());
            let expected = LIGHT * (0.5 / PI * cosine / particles as f32);
            let found = rgb(&image, x, y);
            assert!((found - expected).abs().max_element() < 0.01 * expected.x, "N = {particles}: {found} {expected}");
        }
    }
}

/// "Our Version of Keller's Instant Radiosity": the light of a particle loses ρ/π a bounce; a virtual light of the j-th
/// hit is multiplied by N/⌊ρʲ⁻¹N⌋, and all are weighted by 1/N. A pixel is Σ ρ/π · Lᵢ · max(n·lᵢ, 0).
#[test]
fn virtual_lights_by_the_report() {
    let gpu = gpu();
    for accumulation in [Accumulation::ByTheLetter, Accumulation::Batched] {
        let mut stage = room(0.5, 16);
        let (image, renderer, _) =
            draw(&gpu, &mut stage, InstantRadiosity { accumulation, ..report(12) }, Layer::Indirect);
        let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
        let counts = [12.0, 6.0, 3.0, 1.0];
        // The lights lie by the number of the hit.
        let hits = (1..=4).flat_map(|hit| particles.paths.iter().filter_map(move |path| Some((hit, *path.get(hit)?))));
        let expected: Vec<(Vec3, Vec3)> =
            hits.map(|(hit, at)| (at, LIGHT * (0.5 / PI).powi(hit as i32) / counts[hit - 1])).collect();
        assert_eq!((expected.len(), particles.lights.len()), (22, 22));
        for (light, (at, intensity)) in particles.lights.iter().zip(&expected) {
            assert!((Vec3::from(light.place) - *at).length() < 1e-4, "{light:?} at {at}");
            assert!((Vec3::from(light.intensity) - *intensity).length() < 1e-4 * intensity.length(), "{light:?}");
        }
        for (x, y) in [(1, 1), (8, 8), (3, 12), (14, 9), (8, 14), (8, 1)] {
            let (at, normal) = wall(stage.ray(x, y));
            let lit =
                |(place, light): &(Vec3, Vec3)| *light * (normal.dot((*place - at).normalize()).max(0.0) * 0.5 / PI);
            let (sum, found) = (expected.iter().map(lit).sum::<Vec3>(), rgb(&image, x, y));
            assert!((found - sum).abs().max_element() < 0.01 * sum.x, "pixel {x}, {y}: {found}, expected {sum}");
        }
    }
}

/// The weights 1/N: the main light is divided by N, and the virtual lights of the j-th hits are together L(ρ/π)ʲ whatever N.
#[test]
fn all_is_weighted_by_the_number_of_particles() {
    let gpu = gpu();
    let mut stage = room(0.5, 8);
    let mut main = Vec::new();
    for particles in [10, 40] {
        let image = draw(&gpu, &mut stage, report(particles), Layer::Direct).0;
        main.push(rgb(&image, 4, 4).x * particles as f32);
        let renderer = draw(&gpu, &mut stage, report(particles), Layer::Indirect).1;
        let found = virtual_lights(renderer.methods()).expect("they were asked for").particles();
        let sum: Vec3 = found.lights.iter().map(|light| Vec3::from(light.intensity)).sum();
        let hits = found.paths.iter().map(Vec::len).max().expect("paths") as i32 - 1;
        let expected: f32 = (1..=hits).map(|hit| LIGHT.x * (0.5 / PI).powi(hit)).sum();
        assert!((sum.x - expected).abs() < 1e-4 * expected, "N = {particles}: {sum}, expected {expected}");
    }
    assert!((main[0] - main[1]).abs() < 1e-3 * main[0], "N times the main light: {main:?}");
}

/// "The reflection of the direction of the previous ray cast, over the object's normal."
#[test]
fn particles_bounce_as_from_a_mirror() {
    let gpu = gpu();
    let mut stage = room(0.7, 8);
    let mut share = |bounce| {
        let renderer = draw(&gpu, &mut stage, InstantRadiosity { bounce, ..report(64) }, Layer::Indirect).1;
        let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
        let turns = particles.paths.iter().flat_map(|path| path.windows(3));
        let mirrored = turns.clone().filter(|ends| {
            let [before, after] = [ends[1] - ends[0], ends[2] - ends[1]].map(Vec3::normalize);
            let axis = (0..3).max_by(|&a, &b| ends[1][a].abs().total_cmp(&ends[1][b].abs())).expect("three axes");
            let mut expected = before;
            expected[axis] = -before[axis];
            (after - expected).length() < 1e-3
        });
        let all = turns.clone().count();
        assert!(all >= 64, "{all} turns");
        mirrored.count() as f32 / all as f32
    };
    assert_eq!(share(ParticleBounce::Mirror), 1.0);
    assert!(share(ParticleBounce::Diffuse) < 0.05, "bounces at random are no reflections");
}

/// Directions are "a point on the unit sphere, using a uniform distribution": half of any coordinate lies within ±½.
#[test]
fn particles_start_to_all_sides_alike() {
    let gpu = gpu();
    let mut stage = room(0.5, 8);
    let renderer = draw(&gpu, &mut stage, report(1024), Layer::Indirect).1;
    let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
    let directions: Vec<Vec3> = particles.paths.iter().map(|path| (path[1] - path[0]).normalize()).collect();
    for axis in 0..3 {
        let within = directions.iter().filter(|direction| direction[axis].abs() < 0.5).count();
        // Four standard deviations of 1,024 throws of a coin.
        assert!((512 - 64..=512 + 64).contains(&within), "axis {axis}: {within} of 1024");
    }
    // Independent numbers: the mean is off by about 1/√N, where even ones leave a tenth of that.
    let mean = directions.iter().sum::<Vec3>() / 1024.0;
    assert!((0.004..0.1).contains(&mean.length()), "{mean}");
}

/// A floor below a blocker halfway to a lamp two metres above: the map holds ‖l‖/2 everywhere.
fn below_a_blocker(edge: u32) -> Stage {
    let mut stage = Stage::new(Vec3::new(3.2, 0.8, 0.0), Vec3::ZERO, edge);
    stage.add(plane(12.0), Vec3::splat(0.5), Affine3A::IDENTITY);
    stage.add(plane(6.0), Vec3::splat(0.5), Affine3A::from_translation(Vec3::Y));
    stage.light(LightShape::Point, Vec3::ONE, 2.0 * Vec3::Y, Vec3::Y);
    stage
}

/// Distance from the middle of the floor, and whether light arrives, of pixels that see it.
fn lit(gpu: &Gpu, stage: &mut Stage, settings: InstantRadiosity) -> Vec<(f32, bool)> {
    let image = draw(gpu, stage, settings, Layer::Direct).0;
    let [width, height] = stage.view.size;
    let eye = Vec3::from(stage.view.camera.world_from_view.translation);
    let mut found = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let ray = stage.ray(x, y);
        let at = eye - ray * (eye.y / ray.y);
        if ray.y < 0.0 && at.length() < 3.0 {
            found.push((at.length(), rgb(&image, x, y).x > 0.0));
        }
    }
    assert!(found.len() > 300, "{} pixels", found.len());
    found
}

/// bias = b_s + b_dmax · (1 − n·l), compared as ‖l‖ − bias > d. Here d = ‖l‖/2 and n·l = 2/‖l‖, so that light comes
/// through the blocker where b_s + b_dmax·(1 − 2/‖l‖) > ‖l‖/2, that is, beyond the lesser root of
/// ‖l‖² − 2(b_s + b_dmax)·‖l‖ + 4·b_dmax.
#[test]
fn static_and_dynamic_bias_add_up() {
    let gpu = gpu();
    let mut stage = below_a_blocker(48);
    for (shadow_bias, shadow_slope_bias) in [(0.0, 5.0), (0.3, 5.0), (0.0, 3.0), (0.95, 0.0), (1.2, 0.0)] {
        let (sum, product) = (shadow_bias + shadow_slope_bias, 4.0 * shadow_slope_bias);
        let discriminant: f32 = sum * sum - product;
        let [from, to] = if shadow_slope_bias == 0.0 {
            // A static bias alone brings light where it is longer than ‖l‖/2: near the middle, if anywhere.
            [0.0, 2.0 * shadow_bias]
        } else if discriminant > 0.0 {
            [sum - discriminant.sqrt(), sum + discriminant.sqrt()]
        } else {
            [f32::INFINITY; 2]
        };
        let settings = InstantRadiosity { shadow_bias, shadow_slope_bias, ..report(1) };
        let (mut checked, mut mistakes) = (0, Vec::new());
        for (r, is_lit) in lit(&gpu, &mut stage, settings) {
            let l = (4.0 + r * r).sqrt();
            // Nearer to a border than a texel and a pixel reach.
            if (l - from).abs() < 0.05 || (l - to).abs() < 0.05 {
                continue;
            }
            checked += 1;
            if is_lit != (from < l && l < to) {
                mistakes.push((r, is_lit));
            }
        }
        assert!(
            checked > 200 && mistakes.is_empty(),
            "b_s {shadow_bias}, b_dmax {shadow_slope_bias}: {} of {checked} pixels differ, {:?}",
            mistakes.len(),
            mistakes.first()
        );
    }
}

/// S lookups along −l + off·oᵢ, and s their share in shadow. Below the edge of a blocker under the lamp the share falls
/// linearly from 1 to 0 over −off..off, since the offsets are even in [−1, 1]. The bias must make up for how much nearer
/// to the light a floor is that far aside, or it shadows itself.
#[test]
fn percentage_closer_filtering_is_a_share_of_lookups() {
    const OFF: f32 = 0.3;
    const SAMPLES: u32 = 16;
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.9, 0.0), Vec3::ZERO, 64);
    stage.add(plane(12.0), Vec3::splat(0.5), Affine3A::IDENTITY);
    stage.add(plane(4.0), Vec3::splat(0.5), Affine3A::from_translation(Vec3::new(-2.0, 1.0, 0.0)));
    stage.light(LightShape::Point, Vec3::ONE, 2.0 * Vec3::Y, Vec3::Y).shadow_size = 1024;
    let settings = InstantRadiosity { shadow_samples: SAMPLES, shadow_offset: OFF, shadow_bias: 0.4, ..report(1) };
    let image = draw(&gpu, &mut stage, settings, Layer::Direct).0;
    let mut penumbra = 0;
    for column in 0..64 {
        let x = |y: u32| {
            let ray = stage.ray(column, y);
            Vec3::new(ray.x, 0.0, ray.z) * (-0.9 / ray.y)
        };
        let share = |y: u32| {
            let at = x(y);
            let full = 0.5 / PI * 2.0 / (4.0 + at.length_squared()).sqrt();
            1.0 - rgb(&image, column, y).x / full
        };
        let shares: Vec<f32> = (0..64).map(share).collect();
        for share in &shares {
            let lookups = share * SAMPLES as f32;
            assert!((lookups - lookups.round()).abs() < 0.1, "{share} is no share of {SAMPLES} lookups");
        }
        let at = x(32).x;
        let expected = ((OFF - at) / (2.0 * OFF)).clamp(0.0, 1.0);
        penumbra += u32::from((0.1..0.9).contains(&expected));
        // 1,024 lookups a column: four standard deviations are 0.063.
        let found = shares.iter().sum::<f32>() / 64.0;
        let most = if (0.03..0.97).contains(&expected) { 0.063 } else { 0.03 };
        assert!((found - expected).abs() < most, "at {at}: {found}, expected {expected}");
    }
    assert!(penumbra > 10, "{penumbra} columns lie in the penumbra");
}

#[test]
fn a_single_lookup_has_no_offset() {
    let gpu = gpu();
    let mut stage = below_a_blocker(24);
    let mut of = |shadow_offset| {
        let settings = InstantRadiosity { shadow_offset, shadow_bias: 1.2, shadow_slope_bias: 0.0, ..report(1) };
        draw(&gpu, &mut stage, settings, Layer::Direct).0.rgba
    };
    assert!(of(0.0) == of(0.5));
}

/// "Asymptotic Time Complexity for the Rendering": 6·B draws for the cube map, B for the main light, M·B for the virtual
/// lights. Boxes around camera and lamp lie in the frusta of both, so that nothing is left out.
#[test]
fn a_frame_takes_seven_and_m_times_b_draws() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.1, 0.0, 0.2), Vec3::ZERO, 16);
    const OBJECTS: u64 = 3;
    for index in 0..OBJECTS {
        let mut material = Material::diffuse("shell", Vec3::splat(0.5));
        material.double_sided = true;
        let turned = Affine3A::from_quat(Quat::from_rotation_y(0.1 * index as f32));
        stage.add_material(Shape::Box { size: [2.0 + index as f32; 3] }, material, turned);
    }
    stage.light(LightShape::Point, Vec3::ONE, Vec3::new(0.1, 0.2, 0.0), Vec3::Y);
    for (particles, lights) in [(1, 1), (4, 7), (10, 18)] {
        let letter = draw(&gpu, &mut stage, report(particles), Layer::Total).2;
        assert_eq!(letter, (7 + lights) * OBJECTS, "N = {particles}, M = {lights}");
        // All lights in one pass take no draw at all: M/m is 0 in the report's (7 + M/m)·B.
        let batched = InstantRadiosity { accumulation: Accumulation::Batched, ..report(particles) };
        assert_eq!(draw(&gpu, &mut stage, batched, Layer::Total).2, 7 * OBJECTS, "N = {particles}");
    }
}

/// max(n·l, 0) is the surface's alone: a virtual light on a table lights the floor below it, which it does not face.
#[test]
fn virtual_lights_shine_to_both_sides() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 8);
    stage.add(plane(6.0), Vec3::splat(0.5), Affine3A::IDENTITY);
    stage.add(plane(1.0), Vec3::splat(0.5), Affine3A::from_translation(Vec3::Y));
    let shape = LightShape::Spot { inner: 0.1, outer: 0.15 };
    stage.light(shape, Vec3::ONE, 2.0 * Vec3::Y, Vec3::NEG_Y);
    let image = draw(&gpu, &mut stage, report(4), Layer::Indirect).0;
    let (found, full) = (rgb(&image, 4, 4).x, (0.5 / PI).powi(2));
    assert!((0.9 * full..1.01 * full).contains(&found), "{found} of {full}");
}
