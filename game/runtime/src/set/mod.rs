//! `--set PATH=VALUE`: changes a value of a loaded scene.

mod clip;
mod custom_component;

use anyhow::{Result, anyhow, bail};
use bevy_ecs::prelude::{ChildOf, Component, Entity};
use glam::{EulerRot, Quat, Vec3};
use lightwell::files::{self, SceneInfo, suggestion};
use lightwell::world::fields::text;
use lightwell::world::{
    Animation, Camera, Clpv, Fog, GameWorld, InstantRadiosity, Light, MeshRenderer, Name, Particles, SceneSettings,
    StochasticLightCulling, Transform,
};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Sets one value. `target` is `scene.FIELD`, `clpv.FIELD`, `vpl.FIELD`, `slc.FIELD`, `preset`, `clip` or
/// `ENTITY.COMPONENT.FIELD`, where an entity is its name,
/// or its path `PARENT/CHILD`, and a field may be one inside of another (`kind.outer`, `color.0`). `value` is
/// written as in scene files.
///
/// # Errors
/// If nothing lies at the path, with what there is instead, or the value does not fit there.
pub fn apply(world: &mut GameWorld, target: &str, value: &str) -> Result<()> {
    if target == "preset" {
        return apply_preset(world, value);
    }
    if target == "clip" {
        return clip::apply(world, value);
    }
    if let Some(field) = target.strip_prefix("scene.") {
        let settings = world.ecs.get_resource::<SceneSettings>().cloned().unwrap_or_default();
        world.ecs.insert_resource(changed(&settings, field, value)?);
        return Ok(());
    }
    if let Some(field) = target.strip_prefix("clpv.") {
        let mut query = world.ecs.query::<(Entity, &Clpv)>();
        let Some((entity, clpv)) = query.iter(&world.ecs).min_by_key(|(entity, _)| *entity) else {
            bail!("no entity of the scene has a `clpv` component");
        };
        let clpv = changed(clpv, field, value)?;
        world.ecs.entity_mut(entity).insert(clpv);
        return Ok(());
    }
    if let Some(field) = target.strip_prefix("vpl.") {
        let mut query = world.ecs.query::<(Entity, &InstantRadiosity)>();
        let Some((entity, vpl)) = query.iter(&world.ecs).min_by_key(|(entity, _)| *entity) else {
            bail!("no entity of the scene has a `vpl` component; `--gi vpl` gives it one");
        };
        let vpl = changed(vpl, field, value)?;
        world.ecs.entity_mut(entity).insert(vpl);
        return Ok(());
    }
    if let Some(field) = target.strip_prefix("slc.") {
        return set_light_culling(world, field, value);
    }
    let (entity, name, rest) = find_entity(world, target)?;
    let (component, field) = rest
        .split_once('.')
        .ok_or_else(|| anyhow!("write `{name}.COMPONENT.FIELD`; `{name}` has {}", components(world, entity)))?;
    match component {
        "transform" => edit_transform(world, entity, field, value),
        "mesh" => edit::<MeshRenderer, MeshValue>(world, entity, field, value),
        "light" => edit::<Light, Light>(world, entity, field, value),
        "camera" => edit::<Camera, Camera>(world, entity, field, value),
        "clpv" => edit::<Clpv, Clpv>(world, entity, field, value),
        "vpl" => edit::<InstantRadiosity, InstantRadiosity>(world, entity, field, value),
        "slc" => edit::<StochasticLightCulling, StochasticLightCulling>(world, entity, field, value),
        "fog" => edit::<Fog, Fog>(world, entity, field, value),
        "particles" => edit::<Particles, Particles>(world, entity, field, value),
        "animation" => edit::<Animation, Animation>(world, entity, field, value),
        own => custom_component::edit(world, entity, own, field, value),
    }
    .and_then(|found| match found {
        true => Ok(()),
        false => bail!("`{name}` has no `{component}`; it has {}", components(world, entity)),
    })
}

/// Sets several values, one after the other.
///
/// # Errors
/// As [`apply`], with the path and value that it is about.
pub fn apply_all(world: &mut GameWorld, sets: &[(String, String)]) -> Result<()> {
    let mut sets = sets.iter();
    sets.try_for_each(|(target, value)| {
        apply(world, target, value).map_err(|error| anyhow!("--set {target}={value}: {error}"))
    })
}

/// Adds something to a world and sets several values for this run: no save of the scene writes them.
///
/// # Errors
/// As [`apply_all`].
pub fn override_values(
    world: &mut GameWorld,
    path: &Path,
    sets: &[(String, String)],
    add: impl FnOnce(&mut GameWorld),
) -> Result<()> {
    let said = sets.iter().map(|(target, value)| format!("--set {target}={value}")).collect();
    files::override_values(world, path, said, |world| {
        add(world);
        apply_all(world, sets)
    })
}

/// Changes the settings of stochastic light culling; a scene without them gets the default ones to change.
fn set_light_culling(world: &mut GameWorld, field: &str, value: &str) -> Result<()> {
    let mut query = world.ecs.query::<(Entity, &StochasticLightCulling)>();
    let found = query.iter(&world.ecs).min_by_key(|(entity, _)| *entity);
    let (entity, settings) = found.map_or_else(Default::default, |(entity, slc)| (Some(entity), slc.clone()));
    let settings = changed(&settings, field, value)?;
    let entity = entity.unwrap_or_else(|| world.spawn("Light culling", None));
    world.ecs.entity_mut(entity).insert(settings);
    Ok(())
}

/// Makes the changes that the scene's file lists under a name.
fn apply_preset(world: &mut GameWorld, name: &str) -> Result<()> {
    let presets = world.ecs.get_resource::<SceneInfo>().map(|info| info.presets.clone()).unwrap_or_default();
    let Some(changes) = presets.get(name) else {
        let known: Vec<&str> = presets.keys().map(String::as_str).collect();
        match known.is_empty() {
            true => bail!("the scene has no presets"),
            false => bail!("the scene has no preset `{name}`; it has {}", known.join(", ")),
        }
    };
    for change in changes {
        let (target, value) = change.split_once('=').ok_or_else(|| anyhow!("`{change}` is not PATH=VALUE"))?;
        if target.trim() == "preset" {
            bail!("preset `{name}`: a preset cannot make another one");
        }
        apply(world, target.trim(), value.trim()).map_err(|error| anyhow!("preset `{name}`, {change}: {error}"))?;
    }
    Ok(())
}

/// What of a component can be set, and how it gets there.
trait Values<C>: Serialize + DeserializeOwned {
    fn of(component: &C) -> Self;
    fn put(self, component: &mut C);
}

impl<C: Clone + Serialize + DeserializeOwned> Values<C> for C {
    fn of(component: &C) -> Self {
        component.clone()
    }
    fn put(self, component: &mut C) {
        *component = self;
    }
}

/// A transform as `--set` shows it.
#[derive(Serialize, Deserialize)]
struct TransformValue {
    translation: Vec3,
    /// Angles about x, y and z [degrees]: roll (z) first, then pitch (x), then heading (y), as in scene files.
    rotation: Vec3,
    scale: Vec3,
}

impl Values<Transform> for TransformValue {
    fn of(component: &Transform) -> Self {
        let (y, x, z) = component.rotation.to_euler(EulerRot::YXZ);
        let rotation = Vec3::new(x, y, z).map(f32::to_degrees);
        Self { translation: component.translation, rotation, scale: component.scale }
    }
    fn put(self, component: &mut Transform) {
        let angles = self.rotation.map(f32::to_radians);
        component.translation = self.translation;
        component.rotation = Quat::from_euler(EulerRot::YXZ, angles.y, angles.x, angles.z);
        component.scale = self.scale;
    }
}

/// What of a mesh renderer can be set.
#[derive(Serialize, Deserialize)]
struct MeshValue {
    visible: bool,
    casts_shadow: bool,
}

impl Values<MeshRenderer> for MeshValue {
    fn of(component: &MeshRenderer) -> Self {
        Self { visible: component.visible, casts_shadow: component.casts_shadow }
    }
    fn put(self, component: &mut MeshRenderer) {
        component.visible = self.visible;
        component.casts_shadow = self.casts_shadow;
    }
}

/// Changes a component through what of it can be set; false if the entity has none of that kind.
fn edit<C: Component + Clone, V: Values<C>>(
    world: &mut GameWorld,
    entity: Entity,
    field: &str,
    value: &str,
) -> Result<bool> {
    let Some(mut component) = world.ecs.get::<C>(entity).cloned() else { return Ok(false) };
    changed(&V::of(&component), field, value)?.put(&mut component);
    world.ecs.entity_mut(entity).insert(component);
    Ok(true)
}

/// Changes the transform that the entity has without its animation; false if it has none.
fn edit_transform(world: &mut GameWorld, entity: Entity, field: &str, value: &str) -> Result<bool> {
    if world.ecs.get::<Transform>(entity).is_none() {
        return Ok(false);
    }
    let mut transform = world.rest_transform(entity);
    changed(&TransformValue::of(&transform), field, value)?.put(&mut transform);
    world.set_rest_transform(entity, transform);
    Ok(true)
}

/// The same value with one field written anew.
fn changed<T: Serialize + DeserializeOwned>(current: &T, field: &str, value: &str) -> Result<T> {
    let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    let text = changed_text(&options.to_string(current)?, field, value)?;
    options.from_str(&text).or_else(|error| match in_its_case(value, &error.code) {
        Some(value) => changed(current, field, &value),
        None => Err(misfit(field, value, &error.code)),
    })
}

/// The value with the variant of an enum that it names in other letters, such as `high`, as the enum has it.
fn in_its_case(value: &str, fault: &ron::Error) -> Option<String> {
    let ron::Error::NoSuchEnumVariant { expected, found, .. } = fault else { return None };
    let meant = expected.iter().find(|name| name.eq_ignore_ascii_case(found))?;
    (**meant != **found).then(|| value.replacen(found.as_str(), meant, 1))
}

fn changed_text(current: &str, field: &str, value: &str) -> Result<String> {
    let fields: Vec<&str> = field.split('.').collect();
    text::replace(current, &fields, value).map_err(|error| anyhow!(error))
}

fn misfit(field: &str, value: &str, fault: &ron::Error) -> anyhow::Error {
    let meant = match fault {
        ron::Error::NoSuchEnumVariant { expected, found, .. } => suggestion(found, expected.iter().copied()),
        _ => None,
    };
    match meant.filter(|words| words.starts_with("did you mean")) {
        Some(meant) => anyhow!("`{value}` does not fit `{field}`; {meant} {fault}"),
        None => anyhow!("`{value}` does not fit `{field}`: {fault}"),
    }
}

/// The entity that the path begins with: itself, its name, and what follows it in the path.
fn find_entity<'a>(world: &mut GameWorld, target: &'a str) -> Result<(Entity, String, &'a str)> {
    let mut query = world.ecs.query::<(Entity, &Name)>();
    let entities: Vec<(Entity, String)> =
        query.iter(&world.ecs).map(|(entity, _)| (entity, path_of(world, entity))).collect();
    let rest_after = |name: &str| target.strip_prefix(name)?.strip_prefix('.');
    let by_path = entities.iter().filter_map(|(entity, path)| Some((*entity, path.clone(), rest_after(path)?)));
    if let Some(found) = by_path.max_by_key(|(_, path, _)| path.len()) {
        return Ok(found);
    }
    let by_name = entities.iter().filter_map(|(entity, path)| {
        let name = path.rsplit('/').next().unwrap_or(path);
        Some((*entity, path.clone(), rest_after(name)?))
    });
    let mut found: Vec<_> = by_name.collect();
    let shortest = found.iter().map(|(_, _, rest)| rest.len()).min();
    found.retain(|(_, _, rest)| Some(rest.len()) == shortest);
    let mut known: Vec<&str> = match found.len() {
        1 => return Ok(found.swap_remove(0)),
        0 => entities.iter().map(|(_, path)| path.as_str()).collect(),
        _ => found.iter().map(|(_, path, _)| path.as_str()).collect(),
    };
    known.sort_unstable();
    let hidden = known.len().saturating_sub(MOST_NAMES);
    known.truncate(MOST_NAMES);
    let more = if hidden > 0 { format!(" and {hidden} more") } else { String::new() };
    let names = known.join(", ");
    if found.is_empty() {
        bail!("no such thing; paths begin with `scene`, `clpv`, `vpl` or an entity: {names}{more}");
    }
    bail!("several entities have that name; give the path of one: {names}{more}")
}

/// Most names that an error lists.
const MOST_NAMES: usize = 40;

/// Names from the root down to the entity, joined by `/`.
fn path_of(world: &GameWorld, entity: Entity) -> String {
    let mut names = Vec::new();
    let mut next = Some(entity);
    while let Some(entity) = next {
        names.extend(world.ecs.get::<Name>(entity).map(|name| name.0.clone()));
        next = world.ecs.get::<ChildOf>(entity).map(|parent| parent.parent());
    }
    names.reverse();
    names.join("/")
}

/// The names of the components of the entity that can be set.
fn components(world: &GameWorld, entity: Entity) -> String {
    let ecs = &world.ecs;
    let has = [
        ("transform", ecs.get::<Transform>(entity).is_some()),
        ("mesh", ecs.get::<MeshRenderer>(entity).is_some()),
        ("light", ecs.get::<Light>(entity).is_some()),
        ("camera", ecs.get::<Camera>(entity).is_some()),
        ("clpv", ecs.get::<Clpv>(entity).is_some()),
        ("vpl", ecs.get::<InstantRadiosity>(entity).is_some()),
        ("slc", ecs.get::<StochasticLightCulling>(entity).is_some()),
        ("fog", ecs.get::<Fog>(entity).is_some()),
        ("particles", ecs.get::<Particles>(entity).is_some()),
        ("animation", ecs.get::<Animation>(entity).is_some()),
    ];
    let built_in = has.iter().filter(|(_, has)| *has).map(|(name, _)| *name);
    let own = custom_component::names(world, entity);
    let names: Vec<String> = built_in.chain(own).map(|name| format!("`{name}`")).collect();
    if names.is_empty() { "nothing that can be set".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests;
