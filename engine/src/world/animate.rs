//! The system that plays animations: writes what they say at the clock's time, and only where it differs.

use super::rest::RestPose;
use super::sample::Sample;
use super::{Animation, Camera, Clock, Light, MeshRenderer, Name, Transform};
use crate::assets::{AssetId, Material};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use glam::Vec3;
use std::sync::Arc;

/// An animated entity.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Animated {
    entity: Entity,
    name: Option<&'static Name>,
    rest: &'static mut RestPose,
    transform: Option<&'static mut Transform>,
    light: Option<&'static mut Light>,
    camera: Option<&'static mut Camera>,
    renderer: Option<&'static mut MeshRenderer>,
}

/// Brings all animated entities to the pose of the clock's time.
pub(super) fn animate(clock: Res<Clock>, mut animated: Query<(Ref<Animation>, Animated)>) {
    for (animation, mut item) in &mut animated {
        if animation.is_changed() {
            check(&animation, &mut item);
        }
        let base = item.transform.as_deref().map(|t| item.rest.transform(t)).unwrap_or_default();
        let sample = if item.rest.faulty { Sample::default() } else { animation.sample(&clock, &base) };
        pose(&sample, &mut item);
    }
}

fn check(animation: &Animation, item: &mut AnimatedItem) {
    let fault = animation.validate().err();
    if let Some(fault) = &fault {
        let name = item.name.map_or_else(|| item.entity.to_string(), |n| format!("`{}`", n.0));
        log::warn!("the animation of {name} is not played: {fault}");
    }
    item.rest.faulty = fault.is_some();
}

/// Gives entities that have lost their animation their own values back.
pub(super) fn put_to_rest(mut commands: Commands, mut left: Query<Animated, Without<Animation>>) {
    for mut item in &mut left {
        pose(&Sample::default(), &mut item);
        commands.entity(item.entity).remove::<RestPose>();
    }
}

fn pose(sample: &Sample, item: &mut AnimatedItem) {
    let rest = &mut *item.rest;
    if let Some(transform) = &mut item.transform {
        let now = Transform {
            translation: drive(&mut rest.translation, sample.translation, transform.translation),
            rotation: drive(&mut rest.rotation, sample.rotation, transform.rotation),
            scale: drive(&mut rest.scale, sample.scale, transform.scale),
        };
        if bits(&now) != bits(transform) {
            **transform = now;
        }
    }
    if let Some(light) = &mut item.light {
        let intensity = drive(&mut rest.intensity, sample.intensity, light.intensity);
        let color = drive(&mut rest.color, sample.color, light.color);
        if intensity.to_bits() != light.intensity.to_bits() || vector_bits(color) != vector_bits(light.color) {
            (light.intensity, light.color) = (intensity, color);
        }
    }
    if let Some(camera) = &mut item.camera {
        let fov = drive(&mut rest.fov, sample.fov, camera.fov);
        if fov.to_bits() != camera.fov.to_bits() {
            camera.fov = fov;
        }
    }
    if let Some(renderer) = &mut item.renderer {
        emit(sample.emissive, rest, renderer);
    }
}

/// The value to show: the animated one, while the entity's own is held; else the entity's own.
fn drive<T: Copy>(held: &mut Option<T>, animated: Option<T>, current: T) -> T {
    match animated {
        Some(value) => {
            held.get_or_insert(current);
            value
        }
        None => held.take().unwrap_or(current),
    }
}

/// Materials are immutable and shared: an animated emission makes one of its own whenever it changes.
fn emit(emissive: Option<Vec3>, rest: &mut RestPose, renderer: &mut Mut<MeshRenderer>) {
    let is_ours = rest.animated_material.as_ref().is_some_and(|m| Arc::ptr_eq(m, &renderer.material));
    match emissive {
        Some(emissive) => {
            if !is_ours {
                rest.material = Some(renderer.material.clone());
            }
            let Some(own) = &rest.material else { return };
            if vector_bits(renderer.material.emissive) != vector_bits(emissive) {
                let material = if vector_bits(own.emissive) == vector_bits(emissive) {
                    own.clone()
                } else {
                    Arc::new(Material { id: AssetId::fresh(), emissive, ..Material::clone(own) })
                };
                renderer.material = material;
            }
            rest.animated_material = Some(renderer.material.clone());
        }
        None => {
            if let Some(own) = rest.material.take().filter(|own| is_ours && !Arc::ptr_eq(own, &renderer.material)) {
                renderer.material = own;
            }
            rest.animated_material = None;
        }
    }
}

/// Compared by bits, so that frames do not depend on the sign of a zero that was there before.
fn bits(t: &Transform) -> [u32; 10] {
    let ([a, b, c], [d, e, f, g], [h, i, j]) = (t.translation.to_array(), t.rotation.to_array(), t.scale.to_array());
    [a, b, c, d, e, f, g, h, i, j].map(f32::to_bits)
}

fn vector_bits(v: Vec3) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}
