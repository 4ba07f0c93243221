//! The same paths on the host, one ray at a time: what the device's tracer is checked against, path by path, and what
//! its speed is held against. Purely diffuse surfaces without textures.

use super::TraceSettings;
use crate::bvh::Ray;
use crate::scene::{LightShape, Scene, SceneLight, SceneView};
use crate::scene::{RayKind, SceneBvh, SceneHit, vertex_indices, world_normal};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// The random numbers of `lib/sampling.wgsl`.
struct Sampler {
    seed: u32,
    index: u32,
    dimension: u32,
}

fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn hash_pair(a: u32, b: u32) -> u32 {
    hash(a ^ hash(b))
}

fn scramble_reversed(value: u32, seed: u32) -> u32 {
    let mut x = value.wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6_u32] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

fn reversed_sobol_second(index: u32) -> u32 {
    let steps = [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555_u32)];
    steps.into_iter().fold(index ^ (index >> 16), |x, (shift, mask)| x ^ (x >> shift & mask))
}

impl Sampler {
    fn next_pair(&mut self) -> Vec2 {
        let seed = hash_pair(self.seed, self.dimension);
        self.dimension += 1;
        let index = scramble_reversed(self.index.reverse_bits(), seed);
        let x = scramble_reversed(index, hash(seed ^ 0x9e37_79b9));
        let y = scramble_reversed(reversed_sobol_second(index), hash(seed ^ 0x85eb_ca6b));
        let unit = |bits: u32| (bits >> 8) as f32 * 2.0_f32.powi(-24);
        Vec2::new(unit(x), unit(y))
    }
}

/// Traces paths through a scene on the host.
pub(super) struct HostTracer<'a> {
    scene: &'a Scene,
    bvh: &'a SceneBvh,
    view: &'a SceneView,
    settings: TraceSettings,
    half_height: f32,
}

/// Light of a path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathLight {
    pub(super) direct: Vec3,
    pub(super) indirect: Vec3,
}

struct Vertex {
    position: Vec3,
    geometric_normal: Vec3,
    normal: Vec3,
    albedo: Vec3,
    error: f32,
}

impl<'a> HostTracer<'a> {
    pub(super) fn new(scene: &'a Scene, bvh: &'a SceneBvh, view: &'a SceneView, settings: TraceSettings) -> Self {
        Self { scene, bvh, view, settings, half_height: view.camera.half_height() }
    }

    /// Whether this tracer knows all materials and lights of the scene.
    pub(super) fn knows(scene: &Scene) -> bool {
        !scene.lights.iter().any(|light| light.shape.is_area())
            && scene.primitives.iter().all(|primitive| {
                let m = &primitive.material;
                let textured =
                    m.base_color_texture.is_some() || m.normal_texture.is_some() || m.emissive_texture.is_some();
                !textured
                    && primitive.mesh.extras.is_none()
                    && m.specular == 0.0
                    && m.metallic == 0.0
                    && m.emissive == Vec3::ZERO
            })
    }

    /// Follows the path of one sample of a pixel.
    pub(super) fn path(&self, pixel: [u32; 2], sample: u32) -> PathLight {
        let [width, height] = self.view.size;
        let seed = hash_pair(pixel[1] * width + pixel[0], hash_pair(self.settings.seed, sample & 1));
        let mut random = Sampler { seed, index: sample >> 1, dimension: 0 };
        let size = Vec2::new(width as f32, height as f32);
        let place = Vec2::new(pixel[0] as f32, pixel[1] as f32) - Vec2::from(self.view.jitter) + random.next_pair();
        let at = place / size * 2.0 - 1.0;
        let axes = self.view.camera.world_from_view.matrix3;
        let right = Vec3::from(axes.x_axis) * (self.half_height * size.x / size.y);
        let up = Vec3::from(axes.y_axis) * self.half_height;
        let (across, camera) = (at.x * right - at.y * up, &self.view.camera);
        let (eye, direction) = match camera.is_orthographic() {
            true => (self.view.eye() + across, camera.forward()),
            false => (self.view.eye(), across + camera.forward()),
        };
        let (eye, direction) = match camera.lens_radius().zip(camera.lens.depth_of_field) {
            Some((radius, lens)) => {
                let random = random.next_pair();
                let on_lens = Vec2::from_angle(TAU * random.y) * radius * random.x.sqrt();
                let offset = on_lens.x * Vec3::from(axes.x_axis) + on_lens.y * Vec3::from(axes.y_axis);
                (eye + offset, direction - offset / lens.focus)
            }
            None => (eye, direction),
        };
        let ray = Ray::new(eye + direction * camera.near, direction);
        self.follow(ray, camera.far_plane().map_or(3e38, |far| far - camera.near), &mut random)
    }

    fn follow(&self, mut ray: Ray, mut reach: f32, random: &mut Sampler) -> PathLight {
        let mut light = PathLight::default();
        let mut throughput = Vec3::ONE;
        let mut vertices = 0;
        loop {
            let kind = if vertices == 0 { RayKind::Camera } else { RayKind::Light };
            let hit = self.bvh.closest_hit(&ray, reach, kind);
            let layer = |first: bool, light: &'_ mut PathLight, value: Vec3| {
                *(if first { &mut light.direct } else { &mut light.indirect }) += value;
            };
            let Some(hit) = hit else {
                layer(vertices == 0, &mut light, throughput * self.scene.sky);
                return light;
            };
            vertices += 1;
            let Some(vertex) = self.vertex(&hit, &ray) else { return light };
            layer(vertices == 1, &mut light, throughput * self.light_at(&vertex, vertices == 1, random));
            if vertices > self.settings.bounces.unwrap_or(u32::MAX).min(1024) {
                return light;
            }
            let choice = random.next_pair();
            let direction = cosine_direction(vertex.normal, random.next_pair());
            let cosine = vertex.normal.dot(direction);
            if !(cosine > 0.0) || vertex.geometric_normal.dot(direction) <= 0.0 || vertex.albedo == Vec3::ZERO {
                return light;
            }
            throughput *= vertex.albedo;
            ray = Ray::new(leave(&vertex, direction), direction);
            reach = 3e38;
            if vertices > 3 {
                let chance = throughput.max_element().clamp(0.05, 0.98);
                throughput /= chance;
                if choice.y >= chance {
                    return light;
                }
            }
        }
    }

    /// None at the back of a single-sided surface.
    fn vertex(&self, hit: &SceneHit, ray: &Ray) -> Option<Vertex> {
        let triangle = &self.bvh.triangles[hit.triangle as usize];
        let primitive = &self.scene.primitives[triangle.primitive as usize];
        let [u, v] = hit.barycentric;
        let [a, b, c] = triangle.corners;
        let w = 1.0 - u - v;
        let position = w * a + u * b + v * c;
        let outward = triangle.area_normal().normalize_or_zero();
        let back = outward.dot(ray.direction) > 0.0;
        if back && !primitive.material.double_sided {
            return None;
        }
        let turn = if back { -1.0 } else { 1.0 };
        let normals = vertex_indices(primitive, triangle.triangle)
            .map(|vertex| world_normal(&primitive.world_from_object, primitive.mesh.vertices[vertex].normal.into()));
        let normal = turn * (w * normals[0] + u * normals[1] + v * normals[2]).normalize_or_zero();
        let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
        Some(Vertex {
            position,
            geometric_normal: turn * outward,
            normal: if normal == Vec3::ZERO { turn * outward } else { normal },
            albedo: primitive.material.base_color.truncate(),
            error: largest * 2.0_f32.powi(-20),
        })
    }

    /// Radiance that the vertex reflects of one light, chosen in proportion to what each would bring unhindered.
    fn light_at(&self, vertex: &Vertex, first: bool, random: &mut Sampler) -> Vec3 {
        let lights = &self.scene.lights;
        let mut pick = if lights.len() > 1 { random.next_pair().x } else { 0.0 };
        let mut total = 0.0;
        let mut chosen: Option<(&SceneLight, Vec3, f32)> = None;
        for light in lights.iter().filter(|light| first || light.indirect) {
            let (to_light, irradiance) = incidence(light, vertex.position);
            let cosine = vertex.normal.dot(to_light);
            if cosine <= 0.0 || vertex.geometric_normal.dot(to_light) <= 0.0 {
                continue;
            }
            let reflected = vertex.albedo * (cosine / PI) * irradiance;
            let weight = reflected.element_sum();
            if !(weight > 0.0) {
                continue;
            }
            total += weight;
            let chance = weight / total;
            if pick < chance {
                pick /= chance;
                chosen = Some((light, reflected, weight));
            } else {
                pick = (pick - chance) / (1.0 - chance);
            }
        }
        let Some((light, reflected, weight)) = chosen else { return Vec3::ZERO };
        if light.casts_shadow {
            let (to_light, _) = incidence(light, vertex.position);
            let origin = leave(vertex, to_light);
            let (ray, reach) = match light.shape {
                LightShape::Directional => (Ray::new(origin, to_light), 3e38),
                _ => (Ray::new(origin, light.position - origin), 1.0),
            };
            if self.bvh.is_blocked(&ray, reach) {
                return Vec3::ZERO;
            }
        }
        reflected * (total / weight)
    }
}

fn leave(vertex: &Vertex, direction: Vec3) -> Vec3 {
    let side = if direction.dot(vertex.geometric_normal) >= 0.0 { 1.0 } else { -1.0 };
    vertex.position + vertex.geometric_normal * (side * 4.0 * vertex.error)
}

/// Unit vector to the light, and irradiance on a plane perpendicular to it [W/m²]: `light_incidence` of
/// `lib/lights.wgsl`.
fn incidence(light: &SceneLight, position: Vec3) -> (Vec3, Vec3) {
    if light.shape == LightShape::Directional {
        return (-light.direction, light.intensity);
    }
    let offset = light.position - position;
    let distance = offset.length().max(1e-18);
    let to_light = offset / distance;
    let cone = match light.shape {
        LightShape::Spot { inner, outer } => {
            let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-6);
            ((light.direction.dot(-to_light) - outer.cos()) * scale).clamp(0.0, 1.0).powi(2)
        }
        _ => 1.0,
    };
    let window = light.range.map_or(1.0, |range| (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0));
    (to_light, light.intensity * (cone * window) / (distance * distance))
}

fn cosine_direction(n: Vec3, random: Vec2) -> Vec3 {
    let (radius, angle) = (random.x.sqrt(), TAU * random.y);
    let local = Vec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - random.x).max(0.0).sqrt());
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    let frame =
        Mat3::from_cols(Vec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), Vec3::new(b, s + n.y * n.y * a, -n.y), n);
    (frame * local).normalize()
}
