//! The system that writes what tracks say of fields, after [`animate`](super::super::animate) has sampled them.

use super::super::SceneSettings;
use super::super::rest_pose::RestPose;
use super::held::{Held, HeldFields, own_text};
use super::path::{SCENE, ron_options, split};
use super::rest_values::RestSettings;
use super::text;
use super::types::FieldTypes;
use super::value::{FieldSample, written};
use bevy_ecs::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Values of animated fields in this frame, of entities and of the scene; the last track holds.
#[derive(Resource, Default)]
pub(in crate::world) struct Wanted {
    pub entities: Vec<(Entity, Vec<FieldSample>)>,
    pub scene: Vec<FieldSample>,
}

/// Writes the fields that tracks are for, and gives those that they have left their own values back.
pub(in crate::world) fn drive(
    world: &mut World,
    posed: &mut QueryState<(Entity, &'static RestPose)>,
    mut told: Local<HashSet<String>>,
) {
    let wanted = std::mem::take(&mut *world.resource_mut::<Wanted>());
    let mut entities: BTreeMap<Entity, Vec<FieldSample>> = wanted.entities.into_iter().collect();
    for (entity, rest) in posed.iter(world) {
        if !rest.fields.is_empty() {
            entities.entry(entity).or_default();
        }
    }
    if !entities.is_empty() {
        let types = world.resource::<FieldTypes>().clone();
        for (entity, samples) in entities {
            for fault in drive_entity(world, &types, entity, &samples) {
                tell(&mut told, fault);
            }
        }
    }
    if let Some(fault) = drive_settings(world, &wanted.scene) {
        tell(&mut told, fault);
    }
}

fn tell(told: &mut HashSet<String>, fault: String) {
    if told.insert(fault.clone()) {
        log::warn!("a track of keys is not played: {fault}");
    }
}

/// Gives what is wrong with the samples.
fn drive_entity(world: &mut World, types: &FieldTypes, entity: Entity, samples: &[FieldSample]) -> Vec<String> {
    let held = world.get::<RestPose>(entity).map(|rest| rest.fields.clone()).unwrap_or_default();
    let paths = samples.iter().map(|sample| sample.path.as_str()).chain(held.keys().map(String::as_str));
    let names: BTreeSet<&str> = paths.map(|path| split(path).0).collect();
    let (mut now, mut faults) = (HeldFields::new(), Vec::new());
    for name in names {
        let kind = types.get(name);
        let Some((kind, shown)) = kind.and_then(|kind| Some((kind, kind.text(world, entity)?))) else {
            if samples.iter().any(|sample| split(&sample.path).0 == name) {
                faults.push(format!("the entity has no `{name}` whose fields it could change"));
            }
            continue;
        };
        let own = own_text(&shown, name, &held);
        let (text, driven) = driven(&own, name, samples, &mut faults);
        if text != shown
            && let Err(fault) = kind.put(&text, world, entity)
        {
            faults.push(format!("`{name}` cannot be {text}: {}", fault.code));
            now.extend(held.iter().filter(|(path, _)| split(path).0 == name).map(|(p, h)| (p.clone(), h.clone())));
            continue;
        }
        // What was written may read otherwise than it was written.
        let shown = if driven.is_empty() { String::new() } else { kind.text(world, entity).unwrap_or(text) };
        now.extend(holds(&shown, driven));
    }
    if let Some(mut rest) = world.get_mut::<RestPose>(entity).filter(|rest| rest.fields != now) {
        rest.fields = now;
    }
    faults
}

fn drive_settings(world: &mut World, samples: &[FieldSample]) -> Option<String> {
    let held = std::mem::take(&mut world.get_resource_or_init::<RestSettings>().0);
    if samples.is_empty() && held.is_empty() {
        return None;
    }
    let shown = ron_options().to_string(world.get_resource::<SceneSettings>()?).ok()?;
    let mut faults = Vec::new();
    let (text, driven) = driven(&own_text(&shown, SCENE, &held), SCENE, samples, &mut faults);
    let settings = match ron_options().from_str::<SceneSettings>(&text) {
        Ok(settings) => settings,
        Err(fault) => {
            world.resource_mut::<RestSettings>().0 = held;
            return Some(format!("the scene's settings cannot be {text}: {}", fault.code));
        }
    };
    if text != shown {
        world.insert_resource(settings);
    }
    let shown = ron_options().to_string(world.get_resource::<SceneSettings>()?).ok()?;
    world.resource_mut::<RestSettings>().0 = holds(&shown, driven).collect();
    faults.pop()
}

/// Path and own value of a field that a track changes.
type Driven = (String, String);

/// The component's text with what the samples say of it, and the fields that they are for.
fn driven(own: &str, component: &str, samples: &[FieldSample], faults: &mut Vec<String>) -> (String, Vec<Driven>) {
    let (mut text, mut fields) = (own.to_owned(), Vec::new());
    for sample in samples {
        let (name, steps) = split(&sample.path);
        if name != component {
            continue;
        }
        let change = || -> Result<(String, String), String> {
            let present = text::get(own, &steps)?;
            let value = written(present, &sample.lanes[..sample.count]).map_err(|wanted| format!("wants {wanted}"))?;
            Ok((text::replace(&text, &steps, &value)?, present.to_owned()))
        };
        match change() {
            Ok((changed, present)) => {
                text = changed;
                fields.push((sample.path.clone(), present));
            }
            Err(fault) => faults.push(format!("`{}` {fault}", sample.path)),
        }
    }
    (text, fields)
}

fn holds(shown: &str, driven: Vec<Driven>) -> impl Iterator<Item = (String, Held)> {
    driven.into_iter().filter_map(move |(path, own)| {
        let shown = text::get(shown, &split(&path).1).ok()?.to_owned();
        Some((path, Held { own, shown }))
    })
}
