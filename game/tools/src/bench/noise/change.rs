//! What is done to a scene before the state in which everything is compared: nothing, it plays, a light is off, an object stands
//! elsewhere, the camera looks elsewhere.

use anyhow::{Context, Result};
use bevy_ecs::prelude::Entity;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use lightwell::scene::{Primitive, SceneCamera, SceneId, SceneView};
use lightwell::world::{Identity, Light, MeshRenderer, Transform};
use lightwell_runtime::session::Session;

/// The ticks of the scene's clock that are played; everything is compared at the last. Those of the first report of blocks that
/// flash.
pub const PLAYED: [u64; 2] = [26, 42];
/// Turn of the camera from frame to frame, in a scene in which nothing moves \[degrees\].
const PAN: f32 = 0.5;
/// Turn of the camera all at once \[degrees\].
pub const TURN: f32 = 20.0;
/// Share of the image that an object that is moved should cover.
const OBJECT: f32 = 0.04;

/// A change, after which the scene is as its file has it at the last tick.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// None.
    Rest,
    /// The scene plays, or the camera pans where nothing moves.
    Play { pan: bool },
    /// A light was off, and is switched on to what it is.
    Light { id: SceneId, name: String, intensity: f32 },
    /// An object stood elsewhere.
    Object { id: SceneId, name: String, place: Vec3, aside: Vec3 },
    /// The camera looked elsewhere.
    Turn,
}

impl Change {
    /// What plays in the scene: itself, or the camera.
    ///
    /// # Errors
    /// If there is no camera.
    pub fn play(session: &mut Session) -> Result<Self> {
        let mut state = |tick| -> Result<_> {
            session.set_ticks(tick);
            let revisions = session.scene().revisions;
            let seen = [revisions.geometry, revisions.materials, revisions.lights, revisions.media, revisions.settings];
            Ok((seen, session.camera()?.world_from_view))
        };
        Ok(Self::Play { pan: state(PLAYED[0])? == state(PLAYED[1])? })
    }

    /// The first light that shines and can be switched. None: there is none.
    pub fn light(session: &mut Session) -> Option<Self> {
        session.set_ticks(PLAYED[1]);
        let shines = |light: &&lightwell::scene::SceneLight| light.intensity.max_element() > 0.0;
        let lights: Vec<(SceneId, String)> =
            session.scene().lights.iter().filter(shines).map(|light| (light.id, light.name.clone())).collect();
        lights.into_iter().find_map(|(id, name)| {
            let intensity = set_intensity(session, id, 0.0)?;
            // The animation of a light has the last word.
            session.set_ticks(PLAYED[1]);
            let is_off = !session.scene().lights.iter().filter(shines).any(|light| light.id == id);
            set_intensity(session, id, intensity);
            session.set_ticks(PLAYED[1]);
            is_off.then_some(Self::Light { id, name, intensity })
        })
    }

    /// An object that stands still, is seen whole and is neither small nor large, by its own width to the side. None: there is
    /// none.
    ///
    /// # Errors
    /// If there is no camera.
    pub fn object(session: &mut Session, size: [u32; 2]) -> Result<Option<Self>> {
        session.set_ticks(PLAYED[1]);
        let camera = session.camera()?;
        let view = SceneView { camera: camera.clone(), size, jitter: [0.0; 2] };
        let fit = |primitive: &Primitive| {
            let share = seen_share(primitive, &view)?;
            Some((share / OBJECT).ln().abs())
        };
        let stands =
            |primitive: &&Primitive| !primitive.moving && primitive.blocks_light() && !primitive.is_particles();
        let mut objects: Vec<(f32, SceneId, Affine3A, Vec3)> = session
            .scene()
            .primitives
            .iter()
            .filter(stands)
            .filter_map(|p| Some((fit(p)?, p.id, p.world_from_object, p.bounds.size())))
            .collect();
        objects.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(objects.into_iter().find_map(|(_, id, world_from_object, extent)| {
            let (entity, transform) = object(session, id)?;
            let right = Vec3::from(camera.world_from_view.matrix3.x_axis);
            let aside = right * extent.dot(right.abs());
            let parent = world_from_object.matrix3 * transform.matrix().matrix3.inverse();
            let aside = Vec3::from(parent.inverse() * Vec3A::from(aside));
            let name = session.world().name(entity).to_owned();
            aside.is_finite().then_some(Self::Object { id, name, place: transform.translation, aside })
        }))
    }

    /// Its name in tables.
    pub fn in_words(&self) -> String {
        match self {
            Self::Rest => "at rest".to_owned(),
            Self::Play { pan: false } => "as it plays".to_owned(),
            Self::Play { pan: true } => "as the camera pans".to_owned(),
            Self::Light { name, .. } => format!("`{name}` switched on"),
            Self::Object { name, .. } => format!("`{name}` moved by its width"),
            Self::Turn => format!("camera turned by {TURN}°"),
        }
    }

    /// Frames before the last state, of those that may be waited for.
    pub fn lead(&self, rest: u32) -> u32 {
        match self {
            Self::Rest => 0,
            Self::Play { .. } => (PLAYED[1] - PLAYED[0]) as u32,
            Self::Light { .. } | Self::Object { .. } | Self::Turn => rest,
        }
    }

    /// Brings the scene to where it is so many frames before the last state; gives the camera then.
    ///
    /// # Errors
    /// If there is no camera.
    pub fn apply(&self, session: &mut Session, left: u32) -> Result<SceneCamera> {
        let (mut tick, mut turn) = (PLAYED[1], 0.0);
        match self {
            Self::Rest => {}
            Self::Play { pan } => {
                tick -= u64::from(left);
                turn = if *pan { PAN * left as f32 } else { 0.0 };
            }
            Self::Light { id, intensity, .. } => {
                set_intensity(session, *id, if left > 0 { 0.0 } else { *intensity }).context("the light is gone")?;
            }
            Self::Object { id, place, aside, .. } => {
                let (entity, _) = object(session, *id).context("the object is gone")?;
                let world = &mut session.parts().world.ecs;
                let mut transform = world.get_mut::<Transform>(entity).context("the object is gone")?;
                let now = if left > 0 { *place + *aside } else { *place };
                // What is only written counts as changed.
                if transform.translation != now {
                    transform.translation = now;
                }
            }
            Self::Turn => turn = if left > 0 { TURN } else { 0.0 },
        }
        session.set_ticks(tick);
        Ok(turned(session.camera()?, turn))
    }
}

/// The camera, turned about the vertical \[degrees\].
pub fn turned(mut camera: SceneCamera, degrees: f32) -> SceneCamera {
    if degrees != 0.0 {
        camera.world_from_view.matrix3 = Mat3A::from_rotation_y(degrees.to_radians()) * camera.world_from_view.matrix3;
    }
    camera
}

/// Sets the intensity of a light; gives what it was. None: there is no such light.
fn set_intensity(session: &mut Session, id: SceneId, intensity: f32) -> Option<f32> {
    let world = &mut session.parts().world.ecs;
    let mut lights = world.query::<(&Identity, &mut Light)>();
    let (_, mut light) = lights.iter_mut(world).find(|(identity, _)| identity.id() == id)?;
    let before = light.intensity;
    // What is only written counts as changed.
    if before != intensity {
        light.intensity = intensity;
    }
    Some(before)
}

/// The entity of a primitive and its place.
fn object(session: &mut Session, id: SceneId) -> Option<(Entity, Transform)> {
    let world = &mut session.parts().world.ecs;
    let mut objects = world.query_filtered::<(Entity, &Identity, &Transform), bevy_ecs::prelude::With<MeshRenderer>>();
    let (entity, _, transform) = objects.iter(world).find(|(_, identity, _)| identity.id() == id)?;
    Some((entity, *transform))
}

/// Share of the image that the box around a primitive covers, if it is seen whole.
fn seen_share(primitive: &Primitive, view: &SceneView) -> Option<f32> {
    let clip_from_world = view.clip_from_world();
    let (mut least, mut most) = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
    for corner in primitive.bounds.corners() {
        let clip = clip_from_world * corner.extend(1.0);
        if clip.w <= 0.0 {
            return None;
        }
        let seen = clip.truncate() / clip.w;
        (least, most) = (least.min(seen), most.max(seen));
    }
    let is_whole = least.truncate().min_element() >= -1.0 && most.truncate().max_element() <= 1.0;
    let extent = (most - least).truncate();
    let share = 0.25 * extent.x * extent.y;
    (is_whole && share > 0.0).then_some(share)
}
