//! No point that accepts a light lies outside of its range: on the host, on the device, and both alike.

use super::lobe::{LightRange, Lobe, VirtualLight, acceptance};
use crate::gpu::{Binding, ComputeKey, Gpu, GpuOptions, default_shader_dir, read_buffer};
use crate::world::LightBounds;
use glam::Vec3;
use proptest::prelude::*;

const DELTA: f32 = 0.001;
/// In the order of their numbers on the device.
const ALL_BOUNDS: [LightBounds; 3] = [LightBounds::Ellipsoid, LightBounds::CentredSphere, LightBounds::EnclosingSphere];

/// A light in a random place and pose, with a point near the border of where it is accepted.
#[derive(Clone, Debug)]
struct Case {
    light: VirtualLight,
    point: Vec3,
    xi: f32,
}

/// Numbers in 0..1 that a case is made of.
type Draws = [f32; 14];

fn direction(u: f32, v: f32) -> Vec3 {
    let z = 2.0 * u - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// α down to 1e-3, incidence down to 1e-5 off grazing, scales 1e-3 to 1e3, fluxes 1e-6 to 1e6.
fn case(d: Draws) -> Case {
    let scale = 10.0_f32.powf(6.0 * d[0] - 3.0);
    let flux = 10.0_f32.powf(12.0 * d[1] - 6.0);
    let normal = direction(d[2], d[3]);
    let tangent = normal.any_orthonormal_vector();
    let cosine = 10.0_f32.powf(-5.0 * d[4]);
    let to_light = (normal * cosine + tangent * (1.0 - cosine * cosine).max(0.0).sqrt()).normalize();
    let alpha = 10.0_f32.powf(-3.0 * d[5]);
    let reflectance = Vec3::new(d[6], 0.5 * d[6], 0.04);
    let light = VirtualLight {
        position: (direction(d[7], d[8]) * scale).into(),
        spread: 0.0,
        to_light: to_light.into(),
        alpha,
        normal: normal.into(),
        grazing_reflectance: 1.0,
        flux: (Vec3::new(1.0, 0.7, 0.2) * flux).into(),
        albedo: [0.8 * (1.0 - d[6]); 3],
        normal_reflectance: reflectance.into(),
        ..Default::default()
    };
    // Around the mirror direction, as near as the lobe is narrow, or anywhere.
    let mirror = 2.0 * normal.dot(to_light) * normal - to_light;
    let width = if d[9] < 0.5 { alpha } else { 1.0 };
    let towards = (mirror + direction(d[10], d[11]) * (2.0 * width * d[9])).normalize();
    let xi = (d[12] * d[12]).clamp(2.0_f32.powi(-24), 1.0 - 2.0_f32.powi(-24));
    let lobe = if d[13] < 0.5 { Lobe::Specular } else { Lobe::Diffuse };
    let border = (light.intensity(lobe, towards).max_element() / DELTA / xi).sqrt();
    let distance = border * (1.0 - 0.2 * d[13].fract().powi(4));
    let point = Vec3::from(light.position) + towards * distance.max(1e-6 * scale);
    Case { light, point, xi }
}

fn lobes() -> [Lobe; 2] {
    [Lobe::Diffuse, Lobe::Specular]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn a_range_holds_every_point_that_accepts_the_light(draws in prop::array::uniform14(0.0_f32..1.0)) {
        let Case { light, point, xi } = case(draws);
        let offset = point - Vec3::from(light.position);
        for lobe in lobes() {
            let p = acceptance(light.intensity(lobe, offset.normalize()), DELTA, offset.length_squared());
            prop_assert!(p.is_finite());
            if p > xi {
                for bounds in ALL_BOUNDS {
                    let range = light.range(DELTA, xi, bounds);
                    prop_assert!(range.holds(lobe, point), "{lobe:?} {bounds:?}: p {p} > xi {xi}; {range:?}");
                }
            }
        }
    }

    #[test]
    fn ranges_are_finite_for_grazing_light_and_tiny_alpha(draws in prop::array::uniform14(0.0_f32..1.0)) {
        let Case { mut light, xi, .. } = case(draws);
        light.alpha = 1e-3;
        for cosine in [0.0, 1e-30, 1e-7, 1.0] {
            let normal = Vec3::from(light.normal);
            light.to_light = (normal * cosine + normal.any_orthonormal_vector()).normalize().into();
            for bounds in ALL_BOUNDS {
                let range = light.range(DELTA, xi, bounds);
                let floats: &[f32] = bytemuck::cast_slice(std::slice::from_ref(&range));
                prop_assert!(floats.iter().all(|value| value.is_finite()), "{range:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    /// Figure 9 of 2017: the rivals hold all that the spheroid holds, and so cannot cull what it keeps.
    #[test]
    fn spheres_hold_every_point_of_the_spheroid(draws in prop::array::uniform14(0.0_f32..1.0)) {
        let Case { light, xi, .. } = case(draws);
        let [spheroid, centred, enclosing] = ALL_BOUNDS.map(|bounds| light.range(DELTA, xi, bounds));
        if spheroid.specular_radius > 0.0 {
            // On its surface.
            let (axis, unit) = (Vec3::from(spheroid.axis), direction(draws[10], draws[11]));
            let stretched = unit + axis * ((1.0 / spheroid.squeeze - 1.0) * axis.dot(unit));
            let center = Vec3::from(spheroid.specular_center);
            // Without the margins, of which the one over the coordinates is not stretched in spheres.
            let r = (spheroid.specular_radius - 1e-6 * center.abs().max_element()) / 1.001;
            let point = center + stretched * r;
            prop_assert!(enclosing.holds(Lobe::Specular, point), "{point} is not in {enclosing:?}");
            prop_assert!(centred.holds(Lobe::Specular, point), "{point} is not in {centred:?}");
        }
    }
}

#[test]
fn the_spheroid_touches_the_lobe_at_normal_incidence() {
    let light = VirtualLight {
        to_light: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, 1.0],
        alpha: 0.2,
        grazing_reflectance: 1.0,
        flux: [1.0; 3],
        normal_reflectance: [1.0; 3],
        ..Default::default()
    };
    // On the axis D = 1/(πα²), G₁ = 1: l = r/α, which is the far end of the spheroid.
    let range = light.range(DELTA, 0.5, LightBounds::Ellipsoid);
    let end = range.specular_center[2] + range.specular_radius / range.squeeze;
    let farthest = (light.intensity(Lobe::Specular, Vec3::Z).max_element() / DELTA / 0.5).sqrt();
    assert!((end / farthest - 1.0).abs() < 5e-3, "{end} {farthest}");
}

fn gpu() -> Gpu {
    let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("shaders") };
    Gpu::headless(&options).expect("a Vulkan driver")
}

/// What the device says of the cases: ranges, and chances with whether the ranges hold the points.
fn probe(gpu: &Gpu, cases: &[Case], bounds: usize) -> (Vec<LightRange>, Vec<[f32; 4]>) {
    let none = wgpu::BufferUsages::empty();
    let points: Vec<[f32; 4]> = cases.iter().map(|case| case.point.extend(case.xi).into()).collect();
    let lights: Vec<VirtualLight> = cases.iter().map(|case| case.light).collect();
    let ranges = gpu.storage("ranges", &vec![LightRange::default(); cases.len()], none);
    let found = gpu.storage("found", &vec![[0.0_f32; 4]; cases.len()], none);
    let inputs = (
        gpu.storage("points", &points, none),
        gpu.storage("lights", &lights, none),
        gpu.storage("choice", &[DELTA, bounds as f32], none),
    );
    let pipeline =
        gpu.pipelines.compute(gpu, &ComputeKey::new("indirect/light_culling/probe.wgsl", "main")).expect("a shader");
    let group = [
        ("points", Binding::Buffer(&inputs.0)),
        ("virtual_lights", Binding::Buffer(&inputs.1)),
        ("choice", Binding::Buffer(&inputs.2)),
        ("ranges", Binding::Buffer(&ranges)),
        ("found", Binding::Buffer(&found)),
    ];
    let group = pipeline.bind(gpu, 0, &group).expect("bindings");
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(pipeline.compute().expect("a compute shader"));
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(cases.len().div_ceil(64) as u32, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    (read_buffer(gpu, &ranges).expect("ranges"), read_buffer(gpu, &found).expect("chances"))
}

#[test]
fn the_device_culls_no_accepted_point_and_agrees_with_the_host() {
    let gpu = gpu();
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u32 << 24) as f32
    };
    let cases: Vec<Case> = (0..100_000).map(|_| case(std::array::from_fn(|_| next()))).collect();
    let mut accepted = 0;
    for (index, bounds) in ALL_BOUNDS.into_iter().enumerate() {
        let (ranges, found) = probe(&gpu, &cases, index);
        for ((case, range), [diffuse, specular, in_diffuse, in_specular]) in cases.iter().zip(&ranges).zip(found) {
            for (p, held) in [(diffuse, in_diffuse), (specular, in_specular)] {
                assert!(p.is_finite() && (p <= case.xi || held > 0.0), "{bounds:?}: p {p}; {case:?} {range:?}");
                accepted += u32::from(p > case.xi);
            }
            let host = case.light.range(DELTA, case.xi, bounds);
            let pairs = [(host.diffuse_radius, range.diffuse_radius), (host.specular_radius, range.specular_radius)];
            for (a, b) in pairs.into_iter().chain([(host.squeeze, range.squeeze)]) {
                assert!((a - b).abs() <= 2e-4 * a.abs(), "{bounds:?}: {host:?} on the host, {range:?} on the device");
            }
            let scale = host.specular_radius.abs() / host.squeeze + Vec3::from(case.light.position).length();
            let apart = Vec3::from(host.specular_center).distance(range.specular_center.into());
            assert!(apart <= 2e-4 * scale, "{bounds:?}: {host:?} on the host, {range:?} on the device");
        }
    }
    assert!(accepted > 100_000, "only {accepted} points accepted their light: the test says little");
}
