//! Cameras, rigid and with parameters in range.

use super::context::{Context, Part, name_or_id};
use super::sorted::Elements;
use crate::assets::CubeTable;
use crate::scene::{Scene, SceneCamera, ViewProjection};
use crate::world::{Camera, GlobalTransform, GradingTable, Identity, Lens, Name, Orientation, Projection};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::Affine3A;
use std::sync::Arc;

type Row = (
    Entity,
    &'static Identity,
    Option<&'static Name>,
    &'static GlobalTransform,
    &'static Orientation,
    &'static Camera,
    Option<&'static GradingTable>,
);
type IsChanged = Or<(
    Changed<GlobalTransform>,
    Changed<Orientation>,
    Changed<Camera>,
    Changed<GradingTable>,
    Changed<Name>,
    Added<Identity>,
)>;
type Params = (
    Query<'static, 'static, Row, IsChanged>,
    Query<'static, 'static, (), (With<Camera>, With<GlobalTransform>, With<Orientation>)>,
    RemovedComponents<'static, 'static, Camera>,
    RemovedComponents<'static, 'static, GlobalTransform>,
);

/// Warning for a lens whose value in that field is out of range.
fn out_of_range(field: &str) -> &'static str {
    match field {
        "exposure" => "is a camera without `exposure`: its `f_number`, `shutter` or `iso` is out of its range",
        "depth_of_field" => "is a camera without `depth_of_field`: one of its values is out of its range",
        "bloom" => "is a camera without `bloom`: its `scatter` or `radius` is out of its range",
        "vignette" => "is a camera without `vignette`: it is not in 0..=0.99",
        "sharpening" => "is a camera without `sharpening`: it is not in 0..=1",
        "grain" => "is a camera without `grain`: it is not in 0..=0.5",
        _ => "is a camera whose `lens` has a value out of its range: it does without",
    }
}

/// The state of the world's cameras as of the last extraction.
pub(super) struct Cameras {
    state: SystemState<Params>,
    elements: Elements<SceneCamera>,
}

impl Cameras {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world), elements: Elements::default() }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((changed, living, mut no_camera, mut no_place)) = self.state.get_mut(world) else { return };
        let elements = &mut self.elements;
        let mut gone: Vec<Entity> = no_camera.read().chain(no_place.read()).filter(|e| !living.contains(*e)).collect();
        if context.is_late {
            gone.extend(elements.entities().filter(|e| !living.contains(*e)));
        }
        for entity in gone {
            elements.remove(entity);
            context.log.forget(entity, Part::Camera);
        }
        for (entity, identity, name, place, orientation, camera, table) in &changed {
            context.log.begin(entity, Part::Camera);
            let world_from_view =
                Affine3A { matrix3: orientation.0, translation: place.relative_to(scene.origin).translation };
            if !world_from_view.is_finite() {
                context.log.warn(
                    entity,
                    Part::Camera,
                    name,
                    "is a camera that cannot be used: its place in the world is not finite",
                );
                elements.remove(entity);
                continue;
            }
            let (projection, near, far) =
                projection(camera, |message| context.log.warn(entity, Part::Camera, name, message));
            let (lens, without) = camera.lens.in_range();
            for field in without {
                context.log.warn(entity, Part::Camera, name, out_of_range(field));
            }
            let new = SceneCamera {
                id: identity.id(),
                name: name_or_id(entity, name),
                world_from_view,
                projection,
                near,
                far,
                primary: camera.primary,
                grading: grading(&lens, table),
                lens,
            };
            match elements.get(&mut scene.cameras, entity) {
                Some(old) if *old != new => {
                    *old = new;
                    scene.revisions.cameras = context.revisions.next();
                }
                Some(_) => {}
                None => elements.add(entity, new),
            }
        }
        if elements.apply(&mut scene.cameras) {
            scene.revisions.cameras = context.revisions.next();
        }
    }
}

/// The table that the lens asks for, if that is the one that was loaded.
fn grading(lens: &Lens, table: Option<&GradingTable>) -> Option<Arc<CubeTable>> {
    let table = table.filter(|table| lens.grading.as_ref() == Some(&table.file))?;
    Some(table.table.clone())
}

/// Projection, near and far plane in range. Warns of what had to be changed.
fn projection(camera: &Camera, mut warn: impl FnMut(&'static str)) -> (ViewProjection, f32, Option<f32>) {
    let default = Camera::default();
    let (projection, is_at_eye) = match camera.projection {
        Projection::Perspective => {
            let fov = if camera.fov.is_finite() { camera.fov.clamp(0.01, 179.0) } else { default.fov };
            if fov != camera.fov {
                warn("is a camera with another field of view: the one it has is not in 0.01..=179 degrees");
            }
            (ViewProjection::Perspective { vertical_fov: fov.to_radians() }, false)
        }
        Projection::Orthographic { height } => {
            let is_valid = Projection::HEIGHTS.contains(&height);
            if !is_valid {
                warn("is an orthographic camera of another height: the one it has is not in 1e-6..=1e9 m");
            }
            (ViewProjection::Orthographic { height: if is_valid { height } else { 1.0 } }, camera.near == 0.0)
        }
    };
    let is_near_valid = camera.near.is_finite() && (camera.near > 0.0 || is_at_eye);
    if !is_near_valid {
        warn("is a camera with another near plane: the one it has is not above zero");
    }
    let near = if is_near_valid { camera.near } else { default.near };
    let far = camera.far.filter(|far| *far != f32::INFINITY);
    let beyond = far.filter(|far| *far > near);
    if far != beyond {
        warn("is a camera without a far plane: the one it has is not beyond the near plane");
    }
    (projection, near, beyond)
}
