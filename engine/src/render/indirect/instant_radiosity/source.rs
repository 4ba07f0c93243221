//! What shoots particles: lights, surfaces that emit, and the sky.

use super::beam::Beam;
use super::random::{Numbers, cone_direction, cosine_direction, frame};
use super::surface;
use super::trace_particles::Origin;
use crate::assets::{SkyDirections, SkySample};
use crate::scene::SceneBvh;
use crate::scene::{LightShape, Scene, SceneLight};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// A particle as it leaves its source.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    /// Flux over density [W]: the mean over all particles is the flux of the source.
    pub(super) flux: Vec3,
    /// Density of the direction [1/sr]; 0 where particles start side by side.
    pub(super) per_solid_angle: f32,
    /// Density of the start point across the direction [1/m²]; 0 where they start at one point.
    pub(super) per_area: f32,
    /// Emission of the start point itself.
    pub(super) glow: Glow,
}

/// Light of a start point itself, for all particles of its source together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Glow {
    /// The direct passes draw it.
    None,
    /// A surface: normal, intensity along it [W/sr], area \[m²\].
    Surface(Vec3, Vec3, f32),
    /// Light from far away that travels along the particle's direction: irradiance across it [W/m²].
    Distant(Vec3),
}

/// A source of particles.
pub(super) enum Source<'a> {
    /// A light of the scene, with its index.
    Light(usize, &'a SceneLight, Beam),
    /// All triangles that emit.
    Emitters(Emitters<'a>),
    /// The sky around a ball that holds the scene.
    Sky { light: SkyLight<'a>, center: Vec3, radius: f32 },
}

/// Radiance of the sky by direction.
pub(super) enum SkyLight<'a> {
    /// The same radiance from everywhere [W/(m² sr)].
    Even(Vec3),
    /// That of a map.
    Map(SkyDirections<'a>),
}

impl<'a> SkyLight<'a> {
    fn new(scene: &'a Scene) -> Option<Self> {
        match &scene.sky_map {
            Some(map) => SkyDirections::new(map).map(Self::Map),
            None => (scene.sky.max_element() > 0.0).then_some(Self::Even(scene.sky)),
        }
    }

    /// ∫ L dω, the mean of the channels \[W/m²\].
    fn flux(&self) -> f64 {
        match self {
            Self::Even(radiance) => f64::from(radiance.element_sum()) / 3.0 * f64::from(4.0 * PI),
            Self::Map(directions) => directions.flux(),
        }
    }

    /// Where light comes from, and its radiance over the density of that direction \[W/m²\].
    fn sample(&self, u: Vec2) -> SkySample {
        match self {
            Self::Even(radiance) => {
                SkySample { direction: -cone_direction(Vec3::Z, -1.0, u), irradiance: *radiance * (4.0 * PI) }
            }
            Self::Map(directions) => directions.sample(u),
        }
    }
}

/// Triangles that emit, each chosen in proportion to the flux that it sends out.
pub(super) struct Emitters<'a> {
    scene: &'a Scene,
    bvh: &'a SceneBvh,
    /// Triangle, and the sum of flux up to it.
    list: Vec<(u32, f64)>,
}

impl<'a> Emitters<'a> {
    fn new(scene: &'a Scene, bvh: &'a SceneBvh) -> Self {
        let mut list = Vec::new();
        let mut sum = 0.0;
        for (triangle, index) in bvh.triangles.iter().zip(0..) {
            let primitive = &scene.primitives[triangle.primitive as usize];
            let radiance = primitive.material.emissive.max_element();
            if !(radiance > 0.0) || !primitive.casts_shadow {
                continue;
            }
            let sides = if primitive.material.double_sided { 2.0 } else { 1.0 };
            let flux = f64::from(triangle.area_normal().length()) * 0.5 * f64::from(radiance) * sides;
            if flux > 0.0 && flux.is_finite() {
                sum += flux;
                list.push((index, sum));
            }
        }
        Self { scene, bvh, list }
    }

    fn total(&self) -> f64 {
        self.list.last().map_or(0.0, |(_, sum)| *sum)
    }

    fn start(&self, numbers: &mut Numbers) -> Option<Start> {
        let choice = numbers.pair();
        let at = f64::from(choice.x) * self.total();
        let index = self.list.partition_point(|(_, sum)| *sum <= at).min(self.list.len() - 1);
        let before = if index > 0 { self.list[index - 1].1 } else { 0.0 };
        let (triangle, until) = self.list[index];
        let SurfaceShare { area, sides } = self.share(triangle);
        // Chance of the triangle over its area and sides.
        let density = ((until - before) / self.total()) as f32 / (area * sides);
        // Uniform over the triangle (Turk 1990).
        let u = numbers.pair();
        let root = u.x.sqrt();
        let barycentric = [root * (1.0 - u.y), root * u.y];
        let point = surface::point(self.scene, self.bvh, triangle, barycentric);
        let emitted = surface::emitted(self.scene, self.bvh, triangle, barycentric);
        let outward = self.bvh.triangles[triangle as usize].area_normal().normalize_or_zero();
        let n = if sides > 1.5 && choice.y < 0.5 { -outward } else { outward };
        let direction = cosine_direction(n, numbers.pair());
        let cosine = n.dot(direction);
        if !(cosine > 0.0) || !density.is_finite() {
            return None;
        }
        Some(Start {
            origin: point.position + n * (4.0 * point.error),
            direction,
            flux: emitted * (PI / density),
            per_solid_angle: cosine / PI,
            per_area: 0.0,
            glow: Glow::Surface(n, emitted / density, 1.0 / density),
        })
    }

    fn share(&self, triangle: u32) -> SurfaceShare {
        let triangle = &self.bvh.triangles[triangle as usize];
        let double_sided = self.scene.primitives[triangle.primitive as usize].material.double_sided;
        SurfaceShare { area: 0.5 * triangle.area_normal().length(), sides: if double_sided { 2.0 } else { 1.0 } }
    }
}

struct SurfaceShare {
    area: f32,
    sides: f32,
}

impl<'a> Source<'a> {
    /// All sources of the scene, and the flux [W] that particles are dealt out by. Only lights that feed indirect
    /// light count.
    pub(super) fn all(scene: &'a Scene, bvh: &'a SceneBvh) -> Vec<(Self, f64)> {
        let bounds = scene.bounds();
        if bounds.is_empty() {
            return Vec::new();
        }
        let mut sources = Vec::new();
        let feeds = |light: &SceneLight| light.indirect && light.intensity.max_element() > 0.0;
        for (index, light) in scene.lights.iter().enumerate().filter(|(_, light)| feeds(light)) {
            let beam = match light.shape {
                LightShape::Directional | LightShape::Sun { .. } => Beam::new(light.direction, &bounds, bvh),
                _ => Beam::default(),
            };
            let extent = match light.shape {
                LightShape::Directional | LightShape::Sun { .. } => beam.area(),
                LightShape::Point | LightShape::Sphere { .. } => 4.0 * PI,
                LightShape::Disc { .. } | LightShape::Rectangle { .. } => PI,
                LightShape::Tube { .. } => PI * PI,
                LightShape::Spot { inner, outer } => 2.0 * PI * (1.0 - 0.5 * (inner.cos() + outer.cos())),
            };
            let flux = f64::from(light.intensity.element_sum()) / 3.0 * f64::from(extent);
            sources.push((Source::Light(index, light, beam), flux));
        }
        let emitters = Emitters::new(scene, bvh);
        if !emitters.list.is_empty() {
            let flux = emitters.total() * f64::from(PI);
            sources.push((Source::Emitters(emitters), flux));
        }
        if let Some(light) = SkyLight::new(scene) {
            let radius = 0.5 * bounds.size().length();
            let flux = light.flux() * f64::from(PI) * f64::from(radius).powi(2);
            sources.push((Source::Sky { light, center: bounds.center(), radius }, flux));
        }
        sources.retain(|(_, flux)| flux.is_finite());
        sources
    }

    /// Whether start points are lights themselves.
    pub(super) fn glows(&self) -> bool {
        !matches!(self, Source::Light(..))
    }

    /// The origin of its virtual lights.
    pub(super) fn origin(&self) -> Origin {
        match self {
            Source::Light(index, ..) => Origin::Light(*index),
            Source::Emitters(_) => Origin::Emitters,
            Source::Sky { .. } => Origin::Sky,
        }
    }

    /// A particle.
    pub(super) fn start(&self, numbers: &mut Numbers) -> Option<Start> {
        match self {
            Source::Light(_, light, beam) => Some(start_of_light(light, beam, numbers)),
            Source::Emitters(emitters) => emitters.start(numbers),
            Source::Sky { light, center, radius } => {
                let SkySample { direction, irradiance } = light.sample(numbers.pair());
                let direction = -direction;
                // A disc across the direction, all alike (Shirley and Chiu would keep more of the stratification).
                let u = numbers.pair();
                let (r, angle) = (radius * u.x.sqrt(), 2.0 * PI * u.y);
                let axes = frame(direction);
                let across = axes.x_axis * (r * angle.cos()) + axes.y_axis * (r * angle.sin());
                let disc = PI * radius * radius;
                Some(Start {
                    origin: *center + across - direction * (1.001 * radius),
                    direction,
                    flux: irradiance * disc,
                    per_solid_angle: 0.0,
                    per_area: 1.0 / disc,
                    glow: Glow::Distant(irradiance),
                })
            }
        }
    }
}

fn start_of_light(light: &SceneLight, beam: &Beam, numbers: &mut Numbers) -> Start {
    let u = numbers.pair();
    let start = |direction: Vec3, flux: Vec3, solid_angle: f32| Start {
        origin: light.position,
        direction,
        flux,
        per_solid_angle: 1.0 / solid_angle,
        per_area: 0.0,
        glow: Glow::None,
    };
    match light.shape {
        LightShape::Point => start(cone_direction(Vec3::Z, -1.0, u), light.intensity * (4.0 * PI), 4.0 * PI),
        LightShape::Spot { inner, outer } => {
            let solid_angle = 2.0 * PI * (1.0 - outer.cos());
            let direction = cone_direction(light.direction, outer.cos(), u);
            // KHR_lights_punctual, "Inner and outer cone angles".
            let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-6);
            let smooth = ((light.direction.dot(direction) - outer.cos()) * scale).clamp(0.0, 1.0).powi(2);
            start(direction, light.intensity * (smooth * solid_angle), solid_angle)
        }
        LightShape::Directional => Start {
            origin: beam.start(u),
            flux: light.intensity * beam.area(),
            per_solid_angle: 0.0,
            per_area: 1.0 / beam.area(),
            ..start(light.direction, Vec3::ZERO, 1.0)
        },
        LightShape::Sun { half_angle } => Start {
            origin: beam.start(u),
            direction: cone_direction(light.direction, half_angle.cos(), numbers.pair()),
            flux: light.intensity * beam.area(),
            per_solid_angle: 0.0,
            per_area: 1.0 / beam.area(),
            ..start(light.direction, Vec3::ZERO, 1.0)
        },
        _ => {
            let (offset, normal, extent) = point_of_surface(light, u);
            let direction = cosine_direction(normal, numbers.pair());
            let flux = light.intensity * extent;
            Start {
                origin: light.position + offset,
                per_solid_angle: normal.dot(direction).max(1e-3) / PI,
                ..start(direction, flux, 1.0)
            }
        }
    }
}

/// A point of a light's surface, from its middle, with its normal, and the light's flux over its intensity \[sr\]. Every
/// point of it sends out the same flux.
fn point_of_surface(light: &SceneLight, u: Vec2) -> (Vec3, Vec3, f32) {
    let across = light.direction.cross(light.axis);
    match light.shape {
        LightShape::Sphere { radius } => {
            let normal = cone_direction(Vec3::Z, -1.0, u);
            (normal * radius, normal, 4.0 * PI)
        }
        LightShape::Disc { radius } => {
            let (r, angle) = (radius * u.x.sqrt(), 2.0 * PI * u.y);
            ((light.axis * angle.cos() + across * angle.sin()) * r, light.direction, PI)
        }
        LightShape::Rectangle { half_size } => {
            let at = (2.0 * u - 1.0) * half_size;
            (light.axis * at.x + across * at.y, light.direction, PI)
        }
        LightShape::Tube { half_length, radius } => {
            let angle = 2.0 * PI * u.y;
            let normal = light.direction * angle.cos() + across * angle.sin();
            (light.axis * ((2.0 * u.x - 1.0) * half_length) + normal * radius, normal, PI * PI)
        }
        // What has no surface.
        _ => (Vec3::ZERO, light.direction, 0.0),
    }
}
