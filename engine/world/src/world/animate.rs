//! The system that plays animations: writes what they say at the clock's time, and only where it differs.

use super::clips::{self, Called, ClipTarget, Clips, MorphWeights};
use super::descendants::TrackTarget;
use super::fields::{SCENE, Wanted, split};
use super::rest_pose::RestPose;
use super::sample::{MaterialSample, Sample};
use super::{Animation, Camera, Clock, Identity, Light, LightKind, MeshRenderer, Name, Projection, Transform};
use crate::assets::{AlphaMode, Anisotropy, AssetId, Clearcoat, Iridescence, Material, Sheen};
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
    identity: Option<&'static Identity>,
    rest: &'static mut RestPose,
    transform: Option<&'static mut Transform>,
    light: Option<&'static mut Light>,
    camera: Option<&'static mut Camera>,
    renderer: Option<&'static mut MeshRenderer>,
    weights: Option<&'static mut MorphWeights>,
}

type Moved = (Option<Ref<'static, Animation>>, Option<&'static ClipTarget>, Option<&'static TrackTarget>, Animated);

/// Entities that may be animated: by tracks of their own, by a clip of their model, or by a track of an ancestor.
/// See [`callers`].
type Moves = Or<(With<Animation>, With<ClipTarget>, With<TrackTarget>)>;
type Still = (Without<Animation>, Without<ClipTarget>, Without<TrackTarget>);

/// Brings all animated entities to the pose of the clock's time.
pub(super) fn animate(
    clock: Res<Clock>,
    mut animated: Query<Moved, Moves>,
    players: Query<(Entity, &Animation, Option<&Clips>)>,
    mut wanted: ResMut<Wanted>,
) {
    let mut of_scene = Vec::new();
    for (animation, _, _, mut item) in &mut animated {
        if let Some(animation) = animation.filter(|a| a.is_changed()) {
            check(&animation, &mut item);
        }
    }
    let sound = players.iter().filter(|(_, animation, _)| animation.validate().is_ok());
    let playing = clips::playing(&clock, sound);
    for (animation, clip, track, mut item) in &mut animated {
        let base = item.transform.as_deref().map(|t| item.rest.transform(t)).unwrap_or_default();
        let mut sample = Sample::default();
        for (player, called) in callers(clip, track) {
            if let Some(playing) = playing.get(&player) {
                clips::sample(playing, &called, &base, &mut sample);
            }
        }
        if let Some(animation) = animation.filter(|_| !item.rest.faulty) {
            sample = animation.sample_over(sample, &clock, &base);
        }
        pose(&sample, &mut item);
        let (scene, own): (Vec<_>, Vec<_>) = sample.fields.into_iter().partition(|f| split(&f.path).0 == SCENE);
        if !own.is_empty() {
            wanted.entities.push((item.entity, own));
        }
        if !scene.is_empty() {
            of_scene.push((item.identity.copied(), scene));
        }
    }
    // Whose word is the last does not depend on the order in which the world keeps its entities.
    of_scene.sort_by_key(|(identity, _)| *identity);
    wanted.scene.extend(of_scene.into_iter().flat_map(|(_, fields)| fields));
}

/// The animations that may move the entity, in the order in which they are applied.
fn callers<'a>(clip: Option<&ClipTarget>, track: Option<&'a TrackTarget>) -> Vec<(Entity, Called<'a>)> {
    let mut callers: Vec<(Entity, Called)> = Vec::new();
    if let Some(target) = clip {
        callers.push((target.player, Called { node: Some(target.node), names: Vec::new() }));
    }
    for (player, name) in track.iter().flat_map(|target| &target.0) {
        match callers.iter_mut().find(|(known, _)| known == player) {
            Some((_, called)) => called.names.push(name),
            None => callers.push((*player, Called { node: None, names: vec![name] })),
        }
    }
    callers
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
pub(super) fn put_to_rest(mut commands: Commands, mut left: Query<Animated, Still>) {
    for mut item in &mut left {
        pose(&Sample::default(), &mut item);
        // Fields by path are given back after this.
        if item.rest.fields.is_empty() {
            commands.entity(item.entity).remove::<RestPose>();
        }
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
    if let Some(shown) = &mut item.weights {
        let animated = weighted(rest.weights.as_ref().unwrap_or(&shown.0), &sample.weights);
        let now = drive(&mut rest.weights, animated, shown.0.clone());
        if !now.iter().map(|w| w.to_bits()).eq(shown.0.iter().map(|w| w.to_bits())) {
            shown.0 = now;
        }
    }
    if let Some(light) = &mut item.light {
        shine(sample, rest, light);
    }
    if let Some(camera) = &mut item.camera {
        project(sample, rest, camera);
    }
    if let Some(renderer) = &mut item.renderer {
        let visible = drive(&mut rest.visible, sample.visible, renderer.visible);
        if visible != renderer.visible {
            renderer.visible = visible;
        }
        let casts_shadow = drive(&mut rest.casts_shadow, sample.casts_shadow, renderer.casts_shadow);
        if casts_shadow != renderer.casts_shadow {
            renderer.casts_shadow = casts_shadow;
        }
        paint(&sample.material, rest, renderer);
    }
}

fn shine(sample: &Sample, rest: &mut RestPose, light: &mut Mut<Light>) {
    let own = rest.kind.unwrap_or(light.kind);
    let kind = match own {
        LightKind::Spot { inner, outer } if sample.inner.is_some() || sample.outer.is_some() => {
            let outer = sample.outer.unwrap_or(outer).max(1e-3);
            Some(LightKind::Spot { inner: sample.inner.unwrap_or(inner).min(0.999 * outer), outer })
        }
        _ => None,
    };
    let now = Light {
        kind: drive(&mut rest.kind, kind, light.kind),
        color: drive(&mut rest.color, sample.color, light.color),
        intensity: drive(&mut rest.intensity, sample.intensity, light.intensity),
        range: drive(&mut rest.range, sample.range.map(Some), light.range),
        ..Light::clone(light)
    };
    let bits = |l: &Light| (l.intensity.to_bits(), vector_bits(l.color), l.range.map(f32::to_bits));
    if bits(&now) != bits(light) || now.kind != light.kind {
        **light = now;
    }
}

/// The weights of morph targets with those that are animated; none if there are none such.
fn weighted(own: &[f32], animated: &[(usize, f32)]) -> Option<Vec<f32>> {
    let mut weights = own.to_vec();
    for (index, weight) in animated {
        if let Some(slot) = weights.get_mut(*index) {
            *slot = *weight;
        }
    }
    (!animated.is_empty()).then_some(weights)
}

fn project(sample: &Sample, rest: &mut RestPose, camera: &mut Mut<Camera>) {
    let own = rest.projection.unwrap_or(camera.projection);
    let projection = match own {
        Projection::Orthographic { .. } => sample.height.map(|height| Projection::Orthographic { height }),
        Projection::Perspective => None,
    };
    let fov = drive(&mut rest.fov, sample.fov, camera.fov);
    let projection = drive(&mut rest.projection, projection, camera.projection);
    if fov.to_bits() != camera.fov.to_bits() || projection != camera.projection {
        (camera.fov, camera.projection) = (fov, projection);
    }
}

/// The value to show: the animated one, while the entity's own is held; else the entity's own.
fn drive<T: Clone>(held: &mut Option<T>, animated: Option<T>, current: T) -> T {
    match animated {
        Some(value) => {
            held.get_or_insert(current);
            value
        }
        None => held.take().unwrap_or(current),
    }
}

/// Materials are immutable and shared: an animated one is rebuilt whenever it changes.
fn paint(sample: &MaterialSample, rest: &mut RestPose, renderer: &mut Mut<MeshRenderer>) {
    let is_ours = rest.animated_material.as_ref().is_some_and(|m| Arc::ptr_eq(m, &renderer.material));
    if *sample == MaterialSample::default() {
        if let Some(own) = rest.material.take().filter(|own| is_ours && !Arc::ptr_eq(own, &renderer.material)) {
            renderer.material = own;
        }
        rest.animated_material = None;
        return;
    }
    if !is_ours {
        rest.material = Some(renderer.material.clone());
    }
    let Some(own) = &rest.material else { return };
    let now = painted(own, sample);
    if paint_bits(&renderer.material) != paint_bits(&now) {
        let material = if paint_bits(own) == paint_bits(&now) { own.clone() } else { Arc::new(now) };
        renderer.material = material;
    }
    rest.animated_material = Some(renderer.material.clone());
}

fn painted(own: &Material, sample: &MaterialSample) -> Material {
    let color = sample.color.unwrap_or(own.base_color.truncate());
    let layers = &sample.layers;
    Material {
        id: AssetId::fresh(),
        base_color: color.extend(sample.alpha.unwrap_or(own.base_color.w)),
        metallic: sample.metallic.unwrap_or(own.metallic),
        roughness: sample.roughness.unwrap_or(own.roughness),
        emissive: sample.emissive.unwrap_or(own.emissive),
        specular: sample.specular.unwrap_or(own.specular),
        specular_color: sample.specular_color.unwrap_or(own.specular_color),
        transmission: sample.transmission.unwrap_or(own.transmission),
        normal_scale: sample.normal_scale.unwrap_or(own.normal_scale),
        double_sided: sample.double_sided.unwrap_or(own.double_sided),
        dispersion: layers.dispersion.unwrap_or(own.dispersion),
        clearcoat: Clearcoat {
            factor: layers.clearcoat.unwrap_or(own.clearcoat.factor),
            roughness: layers.clearcoat_roughness.unwrap_or(own.clearcoat.roughness),
            ..own.clearcoat
        },
        sheen: Sheen {
            color: layers.sheen_color.unwrap_or(own.sheen.color),
            roughness: layers.sheen_roughness.unwrap_or(own.sheen.roughness),
        },
        anisotropy: Anisotropy {
            strength: layers.anisotropy.unwrap_or(own.anisotropy.strength),
            rotation: layers.anisotropy_rotation.unwrap_or(own.anisotropy.rotation),
        },
        iridescence: Iridescence {
            factor: layers.iridescence.unwrap_or(own.iridescence.factor),
            thickness: layers.iridescence_thickness.unwrap_or(own.iridescence.thickness),
            ..own.iridescence
        },
        alpha_mode: match (own.alpha_mode, sample.alpha_cutoff) {
            (AlphaMode::Mask(_), Some(cutoff)) => AlphaMode::Mask(cutoff),
            (mode, _) => mode,
        },
        ..Material::clone(own)
    }
}

fn paint_bits(m: &Material) -> ([u32; 17], [u32; 11]) {
    let ([r, g, b, a], [x, y, z]) = (m.base_color.to_array(), m.emissive.to_array());
    let [i, j, k] = m.specular_color.to_array();
    let cutoff = if let AlphaMode::Mask(cutoff) = m.alpha_mode { cutoff } else { 0.0 };
    let sides = f32::from(u8::from(m.double_sided));
    let base = [
        r,
        g,
        b,
        a,
        x,
        y,
        z,
        m.metallic,
        m.roughness,
        m.specular,
        i,
        j,
        k,
        m.transmission,
        m.normal_scale,
        cutoff,
        sides,
    ];
    (base.map(f32::to_bits), layer_bits(m))
}

fn layer_bits(m: &Material) -> [u32; 11] {
    let [r, g, b] = m.sheen.color.to_array();
    let (coat, film, stretch) = (m.clearcoat, m.iridescence, m.anisotropy);
    [
        coat.factor,
        coat.roughness,
        r,
        g,
        b,
        m.sheen.roughness,
        stretch.strength,
        stretch.rotation,
        film.factor,
        film.thickness,
        m.dispersion,
    ]
    .map(f32::to_bits)
}

/// Compared by bits, so that frames do not depend on the sign of a zero that was there before.
fn bits(t: &Transform) -> [u32; 10] {
    let ([a, b, c], [d, e, f, g], [h, i, j]) = (t.translation.to_array(), t.rotation.to_array(), t.scale.to_array());
    [a, b, c, d, e, f, g, h, i, j].map(f32::to_bits)
}

fn vector_bits(v: Vec3) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}
