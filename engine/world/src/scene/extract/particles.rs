//! Light-emitting particles: one primitive for all of a source, posed anew whenever time or the source has changed.

use super::context::{Context, Part, name_or_id};
use super::sorted::Elements;
use crate::assets::{Ball, Material, Mesh, material_of_balls, mesh_of_balls};
use crate::scene::{Primitive, Scene, SceneId};
use crate::world::{Clock, GlobalTransform, Identity, Name, Orientation, Particle, Particles, turn_of_particle};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::{Affine3A, Mat3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Added to an entity's identity for that of its particles, which may stand beside its mesh. Those of entities are counted
/// from 1.
const BESIDE: u64 = 1 << 31;

type Row = (
    Entity,
    &'static Identity,
    Option<&'static Name>,
    &'static GlobalTransform,
    &'static Orientation,
    &'static Particles,
);
type RowItem<'a> = (Entity, &'a Identity, Option<&'a Name>, &'a GlobalTransform, &'a Orientation, &'a Particles);
type Params = (Query<'static, 'static, Row>, Option<Res<'static, Clock>>);

/// The state of the world's sources of particles as of the last extraction.
pub(super) struct Sources {
    state: SystemState<Params>,
    shown: Shown,
}

/// Primitives of the particles of all sources.
#[derive(Default)]
struct Shown {
    elements: Elements<Primitive>,
    known: HashMap<Entity, Source>,
}

/// All that the particles of a source depend on.
#[derive(Clone, Copy, PartialEq)]
struct Moment {
    settings: Particles,
    seconds: f64,
    place: Affine3A,
    turn: Mat3A,
}

/// A source as it was shown last.
struct Source {
    moment: Moment,
    /// The mesh that the shown one is a pose of: it follows from the settings alone.
    rest: Arc<Mesh>,
    material: Arc<Material>,
}

impl Sources {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world), shown: Shown::default() }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((all, clock)) = self.state.get_mut(world) else { return };
        let (shown, seconds) = (&mut self.shown, clock.map_or(0.0, |clock| clock.seconds()));
        let gone: Vec<Entity> = shown.known.keys().copied().filter(|entity| !all.contains(*entity)).collect();
        for entity in gone {
            shown.hide(entity);
            context.log.forget(entity, Part::Particles);
        }
        for row in &all {
            match moment(row, seconds, scene, context) {
                Some(moment) if shown.known.get(&row.0).is_some_and(|known| known.moment == moment) => {}
                Some(moment) => shown.show(row, moment, scene, context),
                None => shown.hide(row.0),
            }
        }
        if shown.elements.apply(&mut scene.primitives) {
            scene.revisions.geometry = context.revisions.next();
            scene.revisions.statics = context.revisions.next();
        }
    }
}

impl Shown {
    fn hide(&mut self, entity: Entity) {
        self.known.remove(&entity);
        self.elements.remove(entity);
    }

    /// Shows the particles of a source as they are at a moment.
    fn show(&mut self, row: RowItem, moment: Moment, scene: &mut Scene, context: &mut Context) {
        let (entity, identity, name) = (row.0, row.1, row.2);
        let source = Source::new(moment, self.known.remove(&entity), &name_or_id(entity, name));
        let mesh = source.mesh();
        let place = Affine3A::from_translation(moment.place.translation.into());
        let revision = context.revisions.next();
        let new = Primitive {
            id: SceneId(identity.id().0 + BESIDE),
            bounds: mesh.bounds.transformed(&place),
            mesh,
            material: source.material.clone(),
            world_from_object: place,
            casts_shadow: true,
            moving: true,
            geometry_revision: revision,
            material_revision: revision,
        };
        self.known.insert(entity, source);
        match self.elements.get(&mut scene.primitives, entity) {
            Some(old) => {
                let has_material = old.material.id == new.material.id;
                let material_revision = if has_material { old.material_revision } else { revision };
                *old = Primitive { material_revision, ..new };
                scene.revisions.geometry = revision;
                scene.revisions.materials = scene.revisions.materials.max(material_revision);
            }
            None => {
                self.elements.add(entity, new);
                scene.revisions.materials = revision;
            }
        }
    }
}

impl Source {
    /// The source at a moment; what its settings have not changed is that of before.
    fn new(moment: Moment, before: Option<Self>, name: &str) -> Self {
        let settings = moment.settings;
        let (rest, material) = before.map_or((None, None), |before| {
            let then = before.moment.settings;
            let light = |of: &Particles| (of.radiance, of.color, of.end_color);
            let has_light = light(&then) == light(&settings);
            ((then == settings).then_some(before.rest), has_light.then_some(before.material))
        });
        let rest = rest.unwrap_or_else(|| {
            let balls = settings.typical().into_iter().map(Some);
            Arc::new(mesh(&settings, name, balls.collect(), None))
        });
        let material = material.unwrap_or_else(|| Arc::new(material_of_balls(name, |age| settings.radiance_at(age))));
        Self { moment, rest, material }
    }

    /// The mesh of the particles at the moment.
    fn mesh(&self) -> Arc<Mesh> {
        let Moment { settings, seconds, place, turn } = &self.moment;
        let particles = settings.at(*seconds, &place.matrix3, turn);
        Arc::new(mesh(settings, &self.rest.name, particles, Some(self.rest.clone())))
    }
}

/// The mesh of particles, those that are not there included, which have no size.
fn mesh(settings: &Particles, name: &str, particles: Vec<Option<Particle>>, rest: Option<Arc<Mesh>>) -> Mesh {
    let ball = |particle: &Option<Particle>| {
        particle.map_or(Ball::NONE, |particle| Ball {
            position: particle.position.to_array(),
            radius: particle.radius,
            radiance: settings.radiance_at(particle.age).to_array(),
            age: particle.age,
        })
    };
    let balls = particles.iter().map(ball).collect();
    let number = |slot: usize| particles[slot].map_or(0, |particle| particle.number);
    mesh_of_balls(name, balls, |slot| turn_of_particle(settings.seed, number(slot)), rest)
}

/// All that the particles of a source depend on; none if there are none that shine. Warns of what had to be changed.
fn moment(row: RowItem, seconds: f64, scene: &Scene, context: &mut Context) -> Option<Moment> {
    let (entity, _, name, place, orientation, particles) = row;
    context.log.begin(entity, Part::Particles);
    let mut warn = |message| context.log.warn(entity, Part::Particles, name, message);
    let (settings, is_sane) = particles.sanitized();
    if !is_sane {
        warn(
            "has particles with settings out of range; the nearest ones in range are used, with at most 65,536 particles at once",
        );
    }
    let place = place.relative_to(scene.origin);
    if !place.is_finite() {
        warn("has particles that are not drawn: its place in the world is not finite");
        return None;
    }
    let light = settings.radiance_at(0.0).max(settings.radiance_at(1.0));
    let is_seen = settings.radius.max(settings.end_radius) > 0.0 && light != Vec3::ZERO;
    let moment = Moment { settings, seconds, place, turn: orientation.0 };
    (is_seen && settings.count() > 0).then_some(moment)
}
