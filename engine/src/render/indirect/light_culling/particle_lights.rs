//! Virtual lights of light-emitting particles: points of their surfaces, chosen in proportion to the flux that they emit.

use crate::gpu::ComputeKey;
use crate::graph::ComputeBuilder;
use crate::scene::{Primitive, Scene};
use bytemuck::{Pod, Zeroable};
use encase::ShaderType;
use glam::Vec3;

/// Lights of a subset.
const LIGHTS: u32 = 64;

/// `ParticleLight` of `indirect/light_culling/particle_lights.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ParticleLight {
    position: [f32; 3],
    /// Of the surface that it stands for \[m²\].
    area: f32,
    normal: [f32; 3],
    /// Part of the surfaces around that it lights \[m²\], for the error bound: flux over area is irradiance there.
    lit: f32,
    /// Φ = π·L·area \[W\].
    flux: [f32; 3],
    padding: u32,
}

/// `Placing` of `indirect/light_culling/particle_lights.wgsl`.
#[derive(ShaderType)]
pub(crate) struct PlacingUniform {
    first: u32,
    lights: u32,
    count: u32,
    subsets: u32,
}

/// Lights of a subset that particles make.
pub(super) fn count(scene: &Scene) -> u32 {
    if sources(scene).next().is_some() { LIGHTS } else { 0 }
}

/// Changes with the particles, and with the box around what they light.
fn key(scene: &Scene) -> Option<(Vec<[u64; 3]>, [u32; 6])> {
    let revisions: Vec<_> = sources(scene).map(|p| [p.id.0, p.geometry_revision, p.material_revision]).collect();
    let bounds = scene.bounds();
    let corners = [bounds.min, bounds.max].map(|corner| corner.to_array());
    (!revisions.is_empty()).then(|| (revisions, std::array::from_fn(|i| corners[i / 3][i % 3].to_bits())))
}

fn sources(scene: &Scene) -> impl Iterator<Item = &Primitive> {
    scene.primitives.iter().filter(|primitive| primitive.is_particles())
}

/// Declares the step that writes the lights behind the others of each subset: `first` is their place in it, of `lights`.
pub(super) fn declare_step<'a>(
    pass: &mut ComputeBuilder<'_, 'a>,
    scene: &'a Scene,
    [first, lights, subsets]: [u32; 3],
) {
    let count = count(scene);
    if count == 0 {
        return;
    }
    let mut step = pass.step_of(ComputeKey::new("indirect/light_culling/particle_lights.wgsl", "main"));
    step.uniform("placing", &PlacingUniform { first, lights, count, subsets });
    step.values_of("particle_lights", &(scene.identity, key(scene)), move || sample(scene, count * subsets));
    step.over_items(count * subsets);
}

/// A triangle that emits light.
struct Emitter {
    corners: [Vec3; 3],
    radiance: Vec3,
    /// Flux up to it and with it.
    until: f64,
}

/// So many lights, evenly distributed over the flux of all particles: the sum of their flux is that of the particles.
fn sample(scene: &Scene, count: u32) -> Vec<ParticleLight> {
    let emitters = emitters(scene);
    let total = emitters.last().map_or(0.0, |last| last.until);
    // Particles light all sides of the scene.
    let size = scene.bounds().size().max(Vec3::ZERO);
    let lit = 2.0 * size.dot(Vec3::new(size.y, size.z, size.x)) / count as f32;
    let light = |index: u32| {
        // The middles of equal parts, and of their triangles another point for each (R₂ sequence: Roberts 2018).
        let at = (f64::from(index) + 0.5) / f64::from(count) * total;
        let chosen = emitters.partition_point(|emitter| emitter.until <= at).min(emitters.len().saturating_sub(1));
        let Some(emitter) = emitters.get(chosen) else { return ParticleLight::zeroed() };
        let [u, v] = [0.754_877_666_2, 0.569_840_290_9].map(|step: f64| (step * f64::from(index)).fract() as f32);
        let root = u.sqrt();
        let [a, b, c] = emitter.corners;
        let brightest = emitter.radiance.max_element();
        // Area over the chance of it.
        let area = (total / f64::from(count) / f64::from(brightest)) as f32;
        ParticleLight {
            position: (a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)).to_array(),
            area,
            normal: (b - a).cross(c - a).normalize_or_zero().to_array(),
            lit: if lit.is_finite() { lit.max(area) } else { area },
            flux: (emitter.radiance * (std::f32::consts::PI * area)).to_array(),
            ..ParticleLight::zeroed()
        }
    };
    (0..count).map(light).collect()
}

fn emitters(scene: &Scene) -> Vec<Emitter> {
    let (mut emitters, mut sum) = (Vec::new(), 0.0);
    for primitive in sources(scene) {
        let (mesh, place) = (&primitive.mesh, &primitive.world_from_object);
        let balls = mesh.balls.as_deref().map_or(&[][..], |balls| balls);
        let triangles = mesh.triangle_count() / balls.len().max(1);
        for (index, corners) in mesh.indices.chunks_exact(3).enumerate() {
            let radiance = Vec3::from(balls[index / triangles].radiance);
            let corner = |i: usize| place.transform_point3(mesh.vertices[corners[i] as usize].position.into());
            let corners = [0, 1, 2].map(corner);
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            let flux = f64::from(area) * f64::from(radiance.max_element());
            if flux > 0.0 && flux.is_finite() {
                sum += flux;
                emitters.push(Emitter { corners, radiance, until: sum });
            }
        }
    }
    emitters
}
