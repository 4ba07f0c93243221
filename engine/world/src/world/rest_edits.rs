//! Entities at rest: what they are without their animation, read and edited.

use super::rest_pose::RestPose;
use super::{Camera, GameWorld, Light, MeshRenderer, Transform};
use crate::assets::Material;
use bevy_ecs::prelude::*;
use std::sync::Arc;

impl GameWorld {
    /// The transform without animation, as files hold it; the default for an entity without one.
    pub fn rest_transform(&self, entity: Entity) -> Transform {
        let current = self.ecs.get::<Transform>(entity).copied().unwrap_or_default();
        self.ecs.get::<RestPose>(entity).map_or(current, |rest| rest.transform(&current))
    }

    /// Sets the transform without animation: the way to move an entity that may be animated.
    pub fn set_rest_transform(&mut self, entity: Entity, transform: Transform) {
        let Ok(mut entity) = self.ecs.get_entity_mut(entity) else { return };
        let mut now = transform;
        if let (Some(mut rest), Some(current)) = (entity.get::<RestPose>().cloned(), entity.get::<Transform>().copied())
        {
            now.translation = hold(&mut rest.translation, transform.translation, current.translation);
            now.rotation = hold(&mut rest.rotation, transform.rotation, current.rotation);
            now.scale = hold(&mut rest.scale, transform.scale, current.scale);
            entity.insert(rest);
        }
        entity.insert(now);
    }

    /// The light without animation, as files hold it.
    pub fn rest_light(&self, entity: Entity) -> Option<Light> {
        let light = self.rest_component::<Light>(entity, "light")?;
        let Some(rest) = self.ecs.get::<RestPose>(entity) else { return Some(light) };
        let (intensity, color) = (rest.intensity.unwrap_or(light.intensity), rest.color.unwrap_or(light.color));
        let (range, kind) = (rest.range.unwrap_or(light.range), rest.kind.unwrap_or(light.kind));
        Some(Light { intensity, color, range, kind, ..light })
    }

    /// Sets the light without animation: the way to change one that may be animated.
    pub fn set_rest_light(&mut self, entity: Entity, light: Light) {
        self.release_fields(entity, "light");
        let Ok(mut entity) = self.ecs.get_entity_mut(entity) else { return };
        let mut now = light;
        if let (Some(mut rest), Some(current)) = (entity.get::<RestPose>().cloned(), entity.get::<Light>()) {
            now.intensity = hold(&mut rest.intensity, now.intensity, current.intensity);
            now.color = hold(&mut rest.color, now.color, current.color);
            now.range = hold(&mut rest.range, now.range, current.range);
            now.kind = hold(&mut rest.kind, now.kind, current.kind);
            entity.insert(rest);
        }
        entity.insert(now);
    }

    /// Sets the camera without animation.
    pub fn set_rest_camera(&mut self, entity: Entity, camera: Camera) {
        self.release_fields(entity, "camera");
        let Ok(mut entity) = self.ecs.get_entity_mut(entity) else { return };
        let mut now = camera;
        if let (Some(mut rest), Some(current)) = (entity.get::<RestPose>().cloned(), entity.get::<Camera>()) {
            now.fov = hold(&mut rest.fov, now.fov, current.fov);
            now.projection = hold(&mut rest.projection, now.projection, current.projection);
            entity.insert(rest);
        }
        entity.insert(now);
    }

    /// The camera without animation, as files hold it.
    pub fn rest_camera(&self, entity: Entity) -> Option<Camera> {
        let camera = self.rest_component::<Camera>(entity, "camera")?;
        let Some(rest) = self.ecs.get::<RestPose>(entity) else { return Some(camera) };
        let (fov, projection) = (rest.fov.unwrap_or(camera.fov), rest.projection.unwrap_or(camera.projection));
        Some(Camera { fov, projection, ..camera })
    }

    /// Whether the entity's mesh is drawn without animation, as files hold it.
    pub fn rest_visible(&self, entity: Entity) -> Option<bool> {
        let current = self.ecs.get::<MeshRenderer>(entity)?.visible;
        Some(self.ecs.get::<RestPose>(entity).and_then(|rest| rest.visible).unwrap_or(current))
    }

    /// Whether the entity's mesh casts shadows without animation, as files hold it.
    pub fn rest_casts_shadow(&self, entity: Entity) -> Option<bool> {
        let current = self.ecs.get::<MeshRenderer>(entity)?.casts_shadow;
        Some(self.ecs.get::<RestPose>(entity).and_then(|rest| rest.casts_shadow).unwrap_or(current))
    }

    /// The material without animation, as files hold it.
    pub fn rest_material(&self, entity: Entity) -> Option<Arc<Material>> {
        let current = &self.ecs.get::<MeshRenderer>(entity)?.material;
        let rest = self.ecs.get::<RestPose>(entity);
        // One that the animation did not make is an edit that it has not seen yet.
        let animated = rest.filter(|r| r.animated_material.as_ref().is_some_and(|m| Arc::ptr_eq(m, current)));
        Some(animated.and_then(|r| r.material.clone()).unwrap_or_else(|| current.clone()))
    }
}

/// Where the rest value is held apart, changes that and leaves the current one.
fn hold<T: Copy>(rest: &mut Option<T>, value: T, current: T) -> T {
    match rest {
        Some(held) => {
            *held = value;
            current
        }
        None => value,
    }
}
