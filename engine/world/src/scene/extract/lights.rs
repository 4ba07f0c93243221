//! Lights, with parameters that the renderer can rely on.

use super::context::{Context, Part, name_or_id};
use super::sky::Air;
use super::sorted::Elements;
use crate::scene::{LightShape, MAX_RSM_SIZE, Scene, SceneLight};
use crate::world::{GlobalTransform, Identity, Light, LightKind, Name, Orientation, forward, right};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::{Vec2, Vec3};

/// Largest edge of a shadow map \[texels\]: the portable limit of a texture.
const MAX_MAP_SIZE: u32 = 8192;

type Row =
    (Entity, &'static Identity, Option<&'static Name>, &'static GlobalTransform, &'static Orientation, &'static Light);
type RowItem<'a> = (Entity, &'a Identity, Option<&'a Name>, &'a GlobalTransform, &'a Orientation, &'a Light);
type IsChanged = Or<(Changed<GlobalTransform>, Changed<Orientation>, Changed<Light>, Changed<Name>, Added<Identity>)>;
type Params = (
    Query<'static, 'static, Row, IsChanged>,
    Query<'static, 'static, Row>,
    Query<'static, 'static, (), (With<Light>, With<GlobalTransform>, With<Orientation>)>,
    RemovedComponents<'static, 'static, Light>,
    RemovedComponents<'static, 'static, GlobalTransform>,
);

/// Extracted lights of the world, with the state that detects changes.
pub(super) struct Lights {
    state: SystemState<Params>,
    elements: Elements<SceneLight>,
    /// Revision of the air that attenuated the lights.
    air: u64,
}

impl Lights {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world), elements: Elements::default(), air: 0 }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context, air: Air) {
        let Ok((changed, all, living, mut no_light, mut no_place)) = self.state.get_mut(world) else { return };
        let elements = &mut self.elements;
        let mut gone: Vec<Entity> = no_light.read().chain(no_place.read()).filter(|e| !living.contains(*e)).collect();
        if context.is_late {
            gone.extend(elements.entities().filter(|e| !living.contains(*e)));
        }
        for entity in gone {
            elements.remove(entity);
            context.log.forget(entity, Part::Light);
        }
        let mut take = |row| elements.update(row, scene, context, air);
        match std::mem::replace(&mut self.air, air.version) == air.version {
            true => changed.iter().for_each(&mut take),
            false => all.iter().for_each(&mut take),
        }
        if elements.apply(&mut scene.lights) {
            scene.revisions.lights = context.revisions.next();
        }
    }
}

impl Elements<SceneLight> {
    /// Updates the scene's light of an entity.
    fn update(
        &mut self,
        (entity, identity, name, place, orientation, light): RowItem,
        scene: &mut Scene,
        context: &mut Context,
        air: Air,
    ) {
        context.log.begin(entity, Part::Light);
        if !place.0.is_finite() {
            context.log.warn(
                entity,
                Part::Light,
                name,
                "is a light that gives none: its place in the world is not finite",
            );
            return self.remove(entity);
        }
        let mut new = SceneLight {
            id: identity.id(),
            name: name_or_id(entity, name),
            position: place.relative_to(scene.origin).translation.into(),
            direction: forward(orientation).into(),
            axis: right(orientation).into(),
            ..sanitized(light, |message| context.log.warn(entity, Part::Light, name, message))
        };
        new.intensity *= air.passes(entity, new.direction);
        match self.get(&mut scene.lights, entity) {
            Some(old) => {
                // A new name is no new light.
                new.revision = old.revision;
                old.name.clone_from(&new.name);
                if *old != new {
                    new.revision = context.revisions.next();
                    scene.revisions.lights = new.revision;
                    *old = new;
                }
            }
            None => {
                new.revision = context.revisions.next();
                self.add(entity, new);
            }
        }
    }
}

/// The light with parameters in range and without a place. Warns of what had to be changed.
fn sanitized(light: &Light, mut warn: impl FnMut(&'static str)) -> SceneLight {
    let product = light.color * light.intensity;
    let is_valid = product.is_finite() && light.intensity >= 0.0 && light.color.cmpge(Vec3::ZERO).all();
    if !is_valid {
        warn("is a light that gives none: its intensity or colour is negative or not finite");
    }
    let mut intensity = if is_valid { product } else { Vec3::ZERO };
    let shape = match light.kind {
        LightKind::Directional => LightShape::Directional,
        LightKind::Point => LightShape::Point,
        LightKind::Spot { inner, outer } if inner.is_finite() && outer.is_finite() => cone(inner, outer, &mut warn),
        LightKind::Spot { .. } => {
            warn("is a light that gives none: an angle of its cone is not finite");
            intensity = Vec3::ZERO;
            cone(0.0, 45.0, &mut warn)
        }
        _ => surface(light.kind, &mut warn),
    };
    let range = light.range.filter(|r| *r != f32::INFINITY);
    let valid_range = range.filter(|r| *r > 0.0);
    if range != valid_range {
        warn("is a light without a range: the one it has is not above zero");
    }
    let shadow_size = light.shadow_size.clamp(1, MAX_MAP_SIZE);
    let rsm_size = light.rsm_size.clamp(1, MAX_RSM_SIZE);
    if shadow_size != light.shadow_size {
        warn("is a light with another map size: the edge of its shadow map is not in 1..=8192 texels");
    }
    if rsm_size != light.rsm_size {
        warn("is a light with another map size: the edge of its RSM is not in 1..=4096 texels");
    }
    SceneLight {
        id: Default::default(),
        name: String::new(),
        shape,
        intensity,
        position: Vec3::ZERO,
        direction: Vec3::NEG_Z,
        axis: Vec3::X,
        range: valid_range,
        casts_shadow: light.casts_shadow,
        indirect: light.indirect,
        shadow_size,
        rsm_size,
        revision: 0,
    }
}

/// A light with a surface. A size that is out of range becomes the nearest one that is in it: what is too small is a point.
fn surface(kind: LightKind, warn: &mut impl FnMut(&'static str)) -> LightShape {
    let mut has_changed = false;
    let mut within = |value: f32, range: std::ops::RangeInclusive<f32>| {
        let (low, high) = range.into_inner();
        // Not a number is none either.
        let new = value.max(low).min(high);
        has_changed |= new != value;
        new
    };
    let mut size = |value: f32| within(value, LightKind::SIZES);
    let shape = match kind {
        LightKind::Sphere { radius } => LightShape::Sphere { radius: size(radius) },
        LightKind::Disc { radius } => LightShape::Disc { radius: size(radius) },
        LightKind::Rectangle { width, height } => {
            LightShape::Rectangle { half_size: 0.5 * Vec2::new(size(width), size(height)) }
        }
        LightKind::Tube { length, radius } => {
            LightShape::Tube { half_length: 0.5 * size(length), radius: size(radius) }
        }
        LightKind::Sun { angle } => LightShape::Sun { half_angle: 0.5 * within(angle, LightKind::ANGLES).to_radians() },
        LightKind::Directional | LightKind::Point | LightKind::Spot { .. } => LightShape::Point,
    };
    if has_changed {
        warn("is a light of another size: sizes are in 1e-6..=1e6 m, and a sun's angle in 1e-3..=90 degrees");
    }
    shape
}

/// A cone with 0 ≤ inner < outer ≤ 90° and outer at least 0.01°, from half angles in degrees.
fn cone(inner: f32, outer: f32, warn: &mut impl FnMut(&'static str)) -> LightShape {
    let clamped = outer.clamp(0.01, 90.0);
    // Strictly less: the smoothing between them divides by a difference.
    let inside = inner.clamp(0.0, 0.9999 * clamped);
    if clamped != outer || inner < 0.0 || inner > outer {
        warn("has a cone out of range: angles are clamped to 0 <= inner < outer <= 90 degrees, outer at least 0.01");
    }
    let outer = clamped.to_radians().min(std::f32::consts::FRAC_PI_2);
    LightShape::Spot { inner: inside.to_radians(), outer }
}
