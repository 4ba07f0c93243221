//! What changes: rooms as the text of their files, and where everything stands so many frames before it rests.

use crate::bench::noise::turned;
use anyhow::{Context, Result};
use glam::camera::rh::view::look_at_affine3a;
use glam::{Quat, Vec3};
use lightwell::scene::SceneView;
use lightwell::world::{GameWorld, Light, Transform};
use lightwell_runtime::session::Session;

/// Frames of motion before everything stops.
const MOTION: u32 = 32;
/// Frames of motion before a shadow is looked at.
const LONG_MOTION: u32 = 96;
/// Intensity of the light that changes \[W/sr\].
const KEY: f32 = 10.0;

/// A room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// A room of 6 m with two lights and an object that moves.
    Plain,
    /// Two rooms with a door between them. The camera stands in the dim one.
    Doors,
    /// A closed box in the sun.
    Sealed,
}

impl Room {
    /// Name of its file.
    pub fn file(self) -> &'static str {
        match self {
            Self::Plain => "plain.scene.ron",
            Self::Doors => "doors.scene.ron",
            Self::Sealed => "sealed.scene.ron",
        }
    }

    /// Its scene.
    pub fn text(self) -> String {
        let head = "Scene(gi: Clpv, materials: {\"wall\": (color: (0.7, 0.7, 0.65), specular: 0), \
                    \"red\": (color: (0.6, 0.1, 0.1), specular: 0), \"blue\": (color: (0.1, 0.2, 0.6), specular: 0)}, ";
        let camera = "(name: \"Camera\", transform: (translation: (2, 1.6, 2.4), look_at: (-0.6, 1, -1)), camera: (fov: 70)),\n\
                      (name: \"Light volume\", transform: (translation: (0, 1.5, 0)), clpv: (quality: Medium)),\n";
        let things = match self {
            Self::Plain => String::from(
                "(name: \"Ball\", transform: (translation: (-1.6, 0.5, -1.8)), mesh: Sphere(radius: 0.5), material: \"wall\"),\n\
                 (name: \"Chest\", transform: (translation: (1.8, 0.4, -2.2)), mesh: Box(size: (1, 0.8, 0.6)), material: \"wall\"),\n\
                 (name: \"Mover\", mesh: Box(size: (0.7, 1.2, 0.7)), material: \"wall\"),\n\
                 (name: \"Key\", light: (kind: Point, intensity: 10)),\n\
                 (name: \"Fill\", transform: (translation: (-2.2, 2.6, 2.2)), light: (kind: Point, intensity: 1.5)),\n",
            ),
            Self::Doors => {
                wall_with_door()
                    + "(name: \"Mover\", mesh: Box(size: (0.7, 1.2, 0.7)), material: \"wall\"),\n\
                   (name: \"Key\", light: (kind: Point, intensity: 10)),\n\
                   (name: \"Fill\", transform: (translation: (2.2, 2.6, 2.2)), light: (kind: Point, intensity: 0.3)),\n"
            }
            Self::Sealed => String::from(
                "(name: \"Ball\", transform: (translation: (-1.6, 0.5, -1.8)), mesh: Sphere(radius: 0.5), material: \"wall\"),\n\
                 (name: \"Sun\", transform: (rotation: (-40, 30, 0)), light: (kind: Directional, intensity: 10)),\n",
            ),
        };
        let settings = if self == Self::Sealed { "settings: (sky: (1, 1, 1)), " } else { "" };
        format!("{head}{settings}entities: [\n{camera}{}{things}])\n", walls())
    }
}

/// Six walls of 10 cm around 6×3×6 m that go through each other at their edges, so that no light passes there.
fn walls() -> String {
    let wall = |name: &str, at: [f32; 3], size: [f32; 3], material: &str| {
        let [[x, y, z], [w, h, d]] = [at, size];
        format!(
            "(name: \"{name}\", transform: (translation: ({x}, {y}, {z})), mesh: Box(size: ({w}, {h}, {d})), \
             material: \"{material}\"),\n"
        )
    };
    [
        wall("Floor", [0.0, -0.05, 0.0], [6.2, 0.1, 6.2], "wall"),
        wall("Ceiling", [0.0, 3.05, 0.0], [6.2, 0.1, 6.2], "wall"),
        wall("Left", [-3.05, 1.5, 0.0], [0.1, 3.2, 6.2], "red"),
        wall("Right", [3.05, 1.5, 0.0], [0.1, 3.2, 6.2], "blue"),
        wall("Back", [0.0, 1.5, -3.05], [6.2, 3.2, 0.1], "wall"),
        wall("Front", [0.0, 1.5, 3.05], [6.2, 3.2, 0.1], "wall"),
    ]
    .concat()
}

/// A wall across the room with a doorway of 1 m, and a door that turns about one of its sides.
fn wall_with_door() -> String {
    String::from(
        "(name: \"Across, left\", transform: (translation: (-1.75, 1.5, 0)), mesh: Box(size: (2.5, 3, 0.1)), material: \"wall\"),\n\
         (name: \"Across, right\", transform: (translation: (1.75, 1.5, 0)), mesh: Box(size: (2.5, 3, 0.1)), material: \"wall\"),\n\
         (name: \"Across, above\", transform: (translation: (0, 2.55, 0)), mesh: Box(size: (1, 0.9, 0.1)), material: \"wall\"),\n\
         (name: \"Hinge\", transform: (translation: (-0.5, 1.05, 0)), children: [\n\
         (name: \"Door\", transform: (translation: (0.5, 0, 0)), mesh: Box(size: (1, 2.1, 0.05)), material: \"blue\")]),\n",
    )
}

/// Where everything stands in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Intensity of the light that changes, over its own.
    key: f32,
    /// Where it is.
    key_at: Vec3,
    /// Where the object is that moves.
    mover: Vec3,
    /// Angle of the door \[degrees\].
    door: f32,
    eye: Vec3,
    look_at: Vec3,
    /// Turn of the camera about the vertical \[degrees\].
    turn: f32,
}

/// Something that changes.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// The name of the same with the nearest rival, if it has it.
    pub rival: Option<&'static str>,
    /// Where it happens.
    pub room: Room,
    /// Frames before the last state; none: as many as a window rests before a sudden change.
    pub lead: Option<u32>,
    /// Whether the camera moves, so that pictures before and after show other things.
    pub moves_camera: bool,
    /// The state so many frames before the last.
    state: fn(f32) -> State,
}

/// All that changes.
pub const CASES: [Case; 10] = [
    Case::sudden("light switched off", None, Room::Plain, |left| State { key: step(left, 1.0, 0.0), ..plain() }),
    Case::sudden("light switched on", None, Room::Plain, |left| State { key: step(left, 0.0, 1.0), ..plain() }),
    Case::sudden("light moved by 3 m", Some("step response of a moved lamp"), Room::Plain, |left| State {
        key_at: Vec3::new(step(left, -1.5, 1.5), 2.5, -1.0),
        ..plain()
    }),
    Case::sudden("door opened", Some("door room"), Room::Doors, |left| State {
        door: step(left, 0.0, 95.0),
        ..doors()
    }),
    Case::sudden("door shut", Some("door room"), Room::Doors, |left| State { door: step(left, 95.0, 0.0), ..doors() }),
    Case {
        lead: Some(MOTION),
        ..Case::sudden("object stops, 3 cm a frame", None, Room::Plain, |left| State {
            mover: plain().mover - Vec3::new(0.03 * left, 0.0, 0.0),
            ..plain()
        })
    },
    Case {
        lead: Some(LONG_MOTION),
        ..Case::sudden("shadow after 96 frames of motion", Some("stale shadow after 96 frames"), Room::Plain, |left| {
            State { mover: plain().mover + Vec3::new((left * std::f32::consts::TAU / 96.0).sin(), 0.0, 0.0), ..plain() }
        })
    },
    Case {
        moves_camera: true,
        ..Case::sudden("camera jumps", Some("history rebuilt after a jump"), Room::Plain, |left| match left > 0.0 {
            true => State { eye: Vec3::new(-2.0, 1.2, -2.0), look_at: Vec3::new(1.0, 1.0, 2.0), ..plain() },
            false => plain(),
        })
    },
    Case {
        lead: Some(MOTION),
        moves_camera: true,
        ..Case::sudden("camera walks, 1 cm and 0.3° a frame", Some("camera motion"), Room::Plain, |left| State {
            eye: plain().eye - Vec3::new(0.0, 0.0, 0.01 * left),
            turn: 0.3 * left,
            ..plain()
        })
    },
    Case {
        lead: Some(MOTION),
        moves_camera: true,
        ..Case::sudden("fast flight, 14 cm and 3° a frame", None, Room::Plain, |left| State {
            eye: plain().eye - Vec3::new(0.0, 0.0, 0.14 * left),
            turn: 3.0 * left,
            ..plain()
        })
    },
];

fn step(left: f32, before: f32, after: f32) -> f32 {
    if left > 0.0 { before } else { after }
}

fn plain() -> State {
    State {
        key: 1.0,
        key_at: Vec3::new(1.5, 2.5, -1.0),
        mover: Vec3::new(0.2, 0.6, -0.9),
        door: 0.0,
        eye: Vec3::new(2.0, 1.6, 2.4),
        look_at: Vec3::new(-0.6, 1.0, -1.0),
        turn: 0.0,
    }
}

fn doors() -> State {
    State {
        key_at: Vec3::new(0.8, 2.5, -1.6),
        mover: Vec3::new(-2.0, 0.6, 0.9),
        look_at: Vec3::new(-0.6, 0.9, 0.4),
        ..plain()
    }
}

impl Case {
    const fn sudden(name: &'static str, rival: Option<&'static str>, room: Room, state: fn(f32) -> State) -> Self {
        Self { name, rival, room, lead: None, moves_camera: false, state }
    }

    /// Brings the room to where it is so many frames before the last state, and gives the view.
    ///
    /// # Errors
    /// If something of the room is missing.
    pub fn apply(&self, session: &mut Session, left: u32, size: [u32; 2]) -> Result<SceneView> {
        (self.state)(left as f32).apply(session, size)
    }
}

impl State {
    /// The camera of a flight through a closed box, so many frames before its end.
    pub fn in_the_box(left: u32) -> Self {
        State { eye: Vec3::new(2.0, 1.6, 2.4 - 0.14 * left as f32), turn: 5.0 * left as f32, ..plain() }
    }

    /// Puts everything there that the room has.
    ///
    /// # Errors
    /// If there is no camera.
    pub fn apply(&self, session: &mut Session, size: [u32; 2]) -> Result<SceneView> {
        let world = &mut *session.parts().world;
        let turn = Quat::from_rotation_y(self.door.to_radians());
        place(world, "Key", |transform| transform.translation = self.key_at);
        place(world, "Mover", |transform| transform.translation = self.mover);
        place(world, "Hinge", |transform| transform.rotation = turn);
        let key = world.find("Key").and_then(|entity| world.ecs.get_mut::<Light>(entity));
        if let Some(mut light) = key.filter(|light| light.intensity != KEY * self.key) {
            light.intensity = KEY * self.key;
        }
        session.set_ticks(0);
        let mut camera = session.camera().context("the room has no camera")?;
        camera.world_from_view = look_at_affine3a(self.eye, self.look_at, Vec3::Y).inverse();
        Ok(SceneView { camera: turned(camera, self.turn), size, jitter: [0.0; 2] })
    }
}

/// Changes the place of an entity, if the room has it. What stays where it is is not written: it would count as changed.
fn place(world: &mut GameWorld, name: &str, change: impl Fn(&mut Transform)) {
    let Some(mut transform) = world.find(name).and_then(|entity| world.ecs.get_mut::<Transform>(entity)) else {
        return;
    };
    let mut changed = *transform;
    change(&mut changed);
    if changed != *transform {
        *transform = changed;
    }
}
