//! The world that random edits change.

use super::fields::{self, Field, with_field};
use super::looks::{self, LOOKS};
use super::surfaces::{self, PLAIN, SKY_IMAGES, STATES, TEXTURES};
use bevy_ecs::component::{Component, Mutable};
use bevy_ecs::entity::Entity;
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{CubeTable, Deform, Influences, Material, Mesh, MorphTarget, Shape};
use lightwell::render::debug::DebugView;
use lightwell::render::{GiMethod, Layer, ReferenceSettings, RenderSettings};
use lightwell::scene::{Extractor, Scene, SceneView};
use lightwell::world::*;
use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

const THINGS: usize = 3;
const LIGHTS: usize = 3;
const MISTS: usize = 2;
/// Places that fog may have.
const PLACES: usize = 3;
/// States of fog, without any effect among them.
const FOGS: [Fog; 7] = {
    let shape = FogShape::Everywhere;
    let fog = Fog { shape, extinction: 0.3, albedo: Vec3::ONE, anisotropy: 0.0, falloff: 0.0 };
    let ball = FogShape::Sphere { radius: 0.8 };
    [
        fog,
        lightwell::world::Fog { extinction: 0.0, ..fog },
        lightwell::world::Fog { falloff: 2.0, anisotropy: 0.7, ..fog },
        lightwell::world::Fog { shape: ball, extinction: 2.0, albedo: Vec3::new(0.9, 0.5, 0.2), ..fog },
        lightwell::world::Fog { shape: ball, extinction: 2.0, albedo: Vec3::new(0.2, 0.5, 0.9), ..fog },
        lightwell::world::Fog { shape: ball, extinction: 5.0, albedo: Vec3::ZERO, ..fog },
        lightwell::world::Fog { shape: FogShape::Box { size: Vec3::new(1.5, 1.0, 0.5) }, anisotropy: -0.4, ..fog },
    ]
};

/// States of particles, without any among them.
const SPARKS: [Particles; 4] = {
    let sparks = Particles {
        rate: 20.0,
        life: 1.0,
        source: Vec3::splat(0.3),
        velocity: Vec3::Y,
        spread: 30.0,
        speed_variation: 0.5,
        gravity: Vec3::new(0.0, -1.0, 0.0),
        radius: 0.03,
        end_radius: 0.01,
        color: Vec3::ONE,
        end_color: Vec3::new(1.0, 0.2, 0.1),
        radiance: 40.0,
        seed: 0,
    };
    [
        Particles { rate: 0.0, ..sparks },
        sparks,
        Particles { end_color: Vec3::ONE, radiance: 80.0, ..sparks },
        Particles { rate: 7.3, seed: 5, ..sparks },
    ]
};

/// One change. Numbers choose among a few states each, so that states come back.
#[derive(Clone, Copy, Debug)]
pub enum Edit {
    ThingComesOrGoes(usize),
    ThingMoves(usize, usize),
    ThingTurns(usize),
    ThingCastsShadow(usize),
    ThingHides(usize),
    Shape(usize),
    Surface(usize, usize),
    /// A texture of a thing, in one of its states.
    Texture(usize, usize, usize),
    LightComesOrGoes(usize),
    LightMoves(usize, usize),
    FigureComesOrGoes,
    /// Pose of the skin, and weight of the morph target.
    Pose(usize, usize),
    FigureChanges,
    Sky(usize),
    Camera(usize),
    VolumeMoves(usize),
    FogComesOrGoes(usize),
    FogMoves(usize, usize),
    Fog(usize, usize),
    Sparks(usize),
    Time(usize),
    Size(usize),
    Method(usize),
    /// A field by its path gets a value; the number chooses the light or fog.
    Set(usize, &'static str, &'static str),
    /// A field of the method in use, by number, gets one of its values.
    Tune(usize, usize),
    /// A setting of the frame.
    Look(usize),
    /// A debug view, on or off.
    Overlay(usize),
    Shown(usize),
    Nothing,
}

pub fn edit() -> impl Strategy<Value = Edit> {
    use Edit::*;
    let (thing, light, fog) = (0..THINGS, 0..LIGHTS, 0..MISTS);
    prop_oneof![
        1 => thing.clone().prop_map(ThingComesOrGoes),
        1 => (thing.clone(), 0..5usize).prop_map(|(thing, at)| ThingMoves(thing, at)),
        1 => thing.clone().prop_map(ThingTurns),
        1 => thing.clone().prop_map(ThingCastsShadow),
        1 => thing.clone().prop_map(ThingHides),
        1 => thing.clone().prop_map(Shape),
        1 => (thing.clone(), 0..PLAIN).prop_map(|(thing, surface)| Surface(thing, surface)),
        2 => (thing, 0..TEXTURES.len(), 0..STATES).prop_map(|(thing, texture, state)| Texture(thing, texture, state)),
        3 => light.clone().prop_map(LightComesOrGoes),
        1 => (light, 0..3usize).prop_map(|(light, at)| LightMoves(light, at)),
        2 => set(0..LIGHTS, &fields::LIGHT),
        1 => Just(FigureComesOrGoes),
        2 => (0..3usize, 0..2usize).prop_map(|(joint, weight)| Pose(joint, weight)),
        1 => Just(FigureChanges),
        2 => (0..SKIES).prop_map(Sky),
        1 => (0..3usize).prop_map(Camera),
        1 => set(0..1, &fields::CAMERA),
        2 => set(0..1, &fields::LENS),
        1 => set(0..1, &fields::SCENE),
        1 => (0..2usize).prop_map(VolumeMoves),
        2 => fog.clone().prop_map(FogComesOrGoes),
        1 => (fog.clone(), 0..PLACES).prop_map(|(fog, at)| FogMoves(fog, at)),
        1 => (fog, 0..FOGS.len()).prop_map(|(fog, kind)| Fog(fog, kind)),
        1 => set(0..MISTS, &fields::FOG),
        1 => (0..SPARKS.len()).prop_map(Sparks),
        1 => set(0..1, &fields::PARTICLES),
        1 => (0..3usize).prop_map(Time),
        1 => (0..2usize).prop_map(Size),
        3 => (0..METHODS.len()).prop_map(Method),
        6 => (0..64usize, 0..8usize).prop_map(|(field, value)| Tune(field, value)),
        4 => (0..LOOKS.len()).prop_map(Look),
        1 => (0..DebugView::ALL.len()).prop_map(Overlay),
        1 => (0..3usize).prop_map(Shown),
        1 => Just(Nothing),
    ]
}

/// An edit that gives a field of a table one of its values.
fn set(index: std::ops::Range<usize>, table: &'static [Field]) -> impl Strategy<Value = Edit> {
    (index, 0..table.len(), 0..8usize).prop_map(move |(index, field, value)| {
        let (path, values) = table[field];
        Edit::Set(index, path, values[value % values.len()])
    })
}

/// The methods of indirect light, each with the settings that make it another set of passes.
pub const METHODS: [fn(&mut Studio); 13] = [
    |studio| studio.settings.gi = GiMethod::NONE,
    |studio| studio.clpv(|clpv| *clpv = Studio::sweep(0)),
    |studio| studio.clpv(|clpv| *clpv = Studio::sweep(2)),
    |studio| studio.clpv(|clpv| *clpv = Clpv { precision: Precision::Half, ..Studio::sweep(2) }),
    // As scenes have it: cells around all of the scene, rays as the quality has them.
    |studio| studio.clpv(|clpv| *clpv = Clpv { quality: Quality::Medium, ..Default::default() }),
    |studio| studio.clpv(|clpv| *clpv = Clpv { transport: Transport::Diffusion, steps: 6, ..Studio::sweep(0) }),
    |studio| studio.vpl(|vpl| *vpl = InstantRadiosity { particles: 16, ..Default::default() }),
    |studio| studio.vpl(|vpl| *vpl = Studio::lights_of_maps()),
    |studio| studio.slc(|slc| *slc = Studio::few_lights()),
    |studio| {
        studio.slc(|slc| {
            *slc = StochasticLightCulling { culling: LightCulling::Clustered, ..Studio::few_lights() };
        })
    },
    |studio| {
        studio.slc(|slc| {
            *slc = StochasticLightCulling { culling: LightCulling::Splatting, ..Studio::few_lights() };
        })
    },
    |studio| {
        studio.slc(|slc| {
            *slc = StochasticLightCulling { visibility: LightVisibility::ShadowRays, ..Studio::few_lights() }
        })
    },
    |studio| {
        studio.settings.gi = GiMethod::REFERENCE;
    },
];

const SKIES: usize = 7 + SKY_IMAGES;

/// A box of which a joint poses the upper half, and a morph target widens it.
fn bending() -> Arc<Mesh> {
    let mut mesh = Shape::Box { size: [0.4, 1.0, 0.4] }.mesh().expect("a box");
    let mut skin = Influences::default();
    mesh.vertices.iter().for_each(|v| skin.push([(u16::from(v.position[1] > 0.0), 1.0)].into_iter()));
    let positions = mesh.vertices.iter().map(|v| [0.0, 0.0, 0.5 * v.position[2]]).collect();
    let targets = vec![MorphTarget { positions, ..Default::default() }];
    mesh.deform = Some(Arc::new(Deform { skin: Some(skin), targets, flat: false }));
    Arc::new(mesh)
}

/// The world that is edited, and how it is drawn.
pub struct Studio {
    world: GameWorld,
    extractor: Extractor,
    pub scene: Scene,
    things: [Option<Entity>; THINGS],
    lights: [Option<Entity>; LIGHTS],
    mists: [Option<Entity>; MISTS],
    volume: Entity,
    fire: Entity,
    eye: Entity,
    /// A mesh with a skin and a morph target: its model and the joint that poses it.
    figure: Option<[Entity; 2]>,
    shapes: [Arc<Mesh>; 2],
    bending: Arc<Mesh>,
    surfaces: [Arc<Material>; PLAIN],
    textured: Vec<[Arc<Material>; STATES]>,
    size: [u32; 2],
    pub settings: RenderSettings,
}

impl Studio {
    /// A floor and two walls with a box, a lamp, light volumes and a camera.
    pub fn new() -> Self {
        let mut world = GameWorld::new();
        let eye = world.spawn("eye", None);
        let volume = world.spawn("volume", None);
        let fire = world.spawn("fire", None);
        let mut studio = Self {
            world,
            extractor: Extractor::new(),
            scene: Scene::default(),
            things: [None; THINGS],
            lights: [None; LIGHTS],
            mists: [None; MISTS],
            volume,
            fire,
            eye,
            figure: None,
            shapes: [Shape::Box { size: [0.5; 3] }, Shape::Sphere { radius: 0.3, segments: 12, rings: 6 }]
                .map(|shape| Arc::new(shape.mesh().expect("a valid shape"))),
            bending: bending(),
            surfaces: surfaces::plain(),
            textured: surfaces::textured(),
            size: [24, 16],
            settings: RenderSettings {
                reference: ReferenceSettings { samples: 1, samples_a_frame: 1, ..Default::default() },
                ..Default::default()
            },
        };
        for (name, size, at) in [
            ("floor", [4.0, 0.2, 4.0], Vec3::new(0.0, -0.1, 0.0)),
            ("back", [4.0, 2.0, 0.2], Vec3::new(0.0, 1.0, -1.6)),
            ("side", [0.2, 2.0, 4.0], Vec3::new(-1.6, 1.0, 0.0)),
        ] {
            let mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
            studio.spawn(name, mesh, at);
        }
        studio.insert(volume, Transform::from_translation(Vec3::Y));
        studio.insert(fire, Transform::from_translation(Vec3::new(0.7, 0.3, 0.5)));
        studio.insert(volume, Self::sweep(2));
        studio.insert(eye, Camera { fov: 70.0, primary: true, ..Default::default() });
        studio.apply(Edit::Camera(0));
        studio.apply(Edit::ThingComesOrGoes(0));
        studio.apply(Edit::LightComesOrGoes(0));
        studio
    }

    fn sweep(rays: u32) -> Clpv {
        Clpv {
            quality: Quality::Low,
            gather_rays: GatherRays::Count(rays),
            gather_points: GatherRays::Count(rays / 2),
            cells: [8; 3],
            cell_size: CellSize::Meters(0.6),
            ..Default::default()
        }
    }

    fn lights_of_maps() -> InstantRadiosity {
        let visibility = VirtualVisibility::ShadowRays;
        InstantRadiosity { particles: 16, placement: VirtualPlacement::Rsm, visibility, ..Default::default() }
    }

    fn few_lights() -> StochasticLightCulling {
        StochasticLightCulling { rsm_size: 16, ..Default::default() }
    }

    fn insert(&mut self, entity: Entity, component: impl bevy_ecs::bundle::Bundle) {
        self.world.ecs.entity_mut(entity).insert(component);
    }

    fn spawn(&mut self, name: &str, mesh: Arc<Mesh>, at: Vec3) -> Entity {
        let entity = self.world.spawn(name, None);
        let material = Arc::clone(&self.surfaces[0]);
        self.insert(entity, MeshRenderer { mesh, material, casts_shadow: true, visible: true });
        self.insert(entity, Transform::from_translation(at));
        entity
    }

    fn clpv(&mut self, change: impl FnOnce(&mut Clpv)) {
        self.settings.gi = GiMethod::CLPV;
        let mut clpv = self.world.ecs.get::<Clpv>(self.volume).cloned().unwrap_or_default();
        change(&mut clpv);
        self.insert(self.volume, clpv);
    }

    fn vpl(&mut self, change: impl FnOnce(&mut InstantRadiosity)) {
        self.settings.gi = GiMethod::VPL;
        let mut vpl = self.world.ecs.get::<InstantRadiosity>(self.volume).cloned().unwrap_or_default();
        vpl.particles = vpl.particles.min(16);
        change(&mut vpl);
        self.insert(self.volume, vpl);
    }

    fn slc(&mut self, change: impl FnOnce(&mut StochasticLightCulling)) {
        self.settings.gi = GiMethod::SLC;
        let known = self.world.ecs.get::<StochasticLightCulling>(self.volume).cloned();
        let mut slc = known.unwrap_or_else(Self::few_lights);
        change(&mut slc);
        self.insert(self.volume, slc);
    }

    fn thing<C: Component<Mutability = Mutable>>(&mut self, index: usize, change: impl FnOnce(&mut C)) {
        let Some(entity) = self.things[index] else { return };
        if let Some(mut component) = self.world.ecs.get_mut::<C>(entity) {
            change(&mut component);
        }
    }

    /// Gives a field of a component a value; nothing if the entity has no such component.
    fn edit<C>(&mut self, entity: Option<Entity>, field: &str, value: &str)
    where
        C: Component<Mutability = Mutable> + Serialize + DeserializeOwned,
    {
        let component = entity.and_then(|entity| self.world.ecs.get_mut::<C>(entity));
        if let Some(mut component) = component {
            *component = with_field(&*component, field, value);
        }
    }

    fn set(&mut self, index: usize, path: &str, value: &str) {
        let (component, field) = path.split_once('.').expect("a component and a field");
        match component {
            "clpv" => self.edit::<Clpv>(Some(self.volume), field, value),
            "vpl" => self.edit::<InstantRadiosity>(Some(self.volume), field, value),
            "slc" => self.edit::<StochasticLightCulling>(Some(self.volume), field, value),
            "light" => self.edit::<Light>(self.lights[index], field, value),
            "fog" => self.edit::<lightwell::world::Fog>(self.mists[index], field, value),
            "camera" => self.edit::<Camera>(Some(self.eye), field, value),
            "particles" => self.edit::<Particles>(Some(self.fire), field, value),
            "lens" => self.set_lens(field, value),
            "scene" => {
                let mut settings = self.world.ecs.resource_mut::<SceneSettings>();
                *settings = with_field(&*settings, field, value);
            }
            _ => panic!("no component is called `{component}`"),
        }
    }

    fn set_lens(&mut self, field: &str, value: &str) {
        let Some(mut camera) = self.world.ecs.get_mut::<Camera>(self.eye) else { return };
        camera.lens = with_field(&camera.lens, field, value);
        let Some(file) = camera.lens.grading.clone().filter(|_| field == "grading") else { return };
        let entries = (0..8_u32).map(|at| match file.as_str() {
            "dark" => [at & 1, at >> 1 & 1, at >> 2 & 1].map(|value| 0.5 * value as f32),
            _ => [at >> 2 & 1, at >> 1 & 1, at & 1].map(|value| value as f32),
        });
        let lines: String = entries.map(|[r, g, b]| format!("{r} {g} {b}\n")).collect();
        let table = CubeTable::parse(&format!("LUT_3D_SIZE 2\n{lines}")).expect("a colour table");
        self.insert(self.eye, GradingTable { file, table: Arc::new(table) });
    }

    /// The field and value of [`Edit::Tune`]; `None` if the method has no settings.
    fn tuned(&self, field: usize, value: usize) -> Option<(&'static str, &'static str)> {
        let table: &[Field] = match self.settings.gi {
            GiMethod::CLPV => &fields::CLPV,
            GiMethod::VPL => &fields::VPL,
            GiMethod::SLC => &fields::SLC,
            _ => return None,
        };
        let (path, values) = table[field % table.len()];
        Some((path, values[value % values.len()]))
    }

    /// The edit in words, as it acts now.
    pub fn describe(&self, edit: Edit) -> String {
        match edit {
            Edit::Tune(field, value) => format!("Tune({field}, {value}) = {:?}", self.tuned(field, value)),
            Edit::Look(look) => format!("Look({look}) = {}", LOOKS[look].0),
            Edit::Overlay(view) => format!("Overlay({view}) = {}", DebugView::ALL[view]),
            Edit::Texture(thing, texture, state) => {
                format!("Texture({thing}, {texture}, {state}) = {}", TEXTURES[texture].0)
            }
            _ => format!("{edit:?}"),
        }
    }

    fn figure_comes_or_goes(&mut self) {
        if let Some([model, _]) = self.figure.take() {
            self.world.ecs.despawn(model);
            return;
        }
        let model = self.world.spawn("figure", None);
        let [low, joint] = ["low", "joint"].map(|name| self.world.spawn(name, Some(model)));
        let inverse_bind = Arc::new(vec![Affine3A::IDENTITY; 2]);
        let posed = Posed::new(self.bending.clone(), Some(model)).with_skin(model, vec![low, joint], inverse_bind);
        let (mesh, material) = (self.bending.clone(), self.surfaces[1].clone());
        self.insert(low, (posed, MeshRenderer { mesh, material, casts_shadow: true, visible: true }));
        self.insert(model, (MorphWeights(vec![0.0]), Transform::from_translation(Vec3::new(0.1, 0.5, 0.1))));
        self.figure = Some([model, joint]);
    }

    fn pose(&mut self, joint: usize, weight: usize) {
        let Some([model, entity]) = self.figure else { return };
        let lean = Vec3::new([0.0, 0.3, 0.6][joint], 0.0, 0.0);
        self.insert(entity, Transform::from_translation(lean));
        self.insert(model, MorphWeights(vec![[0.0, 0.7][weight]]));
    }

    pub fn apply(&mut self, edit: Edit) {
        match edit {
            Edit::ThingComesOrGoes(index) => match self.things[index].take() {
                Some(entity) => drop(self.world.ecs.despawn(entity)),
                None => {
                    let mesh = Arc::clone(&self.shapes[0]);
                    let at = Vec3::new(index as f32 * 0.8 - 0.8, 0.25, 0.3);
                    self.things[index] = Some(self.spawn(&format!("thing {index}"), mesh, at));
                }
            },
            Edit::ThingMoves(index, at) => {
                let at = [
                    Vec3::new(0.6, 0.25, 0.2),
                    Vec3::new(-0.6, 0.3, 0.0),
                    Vec3::new(0.2, 0.8, -0.4),
                    Vec3::Z * 9.0,
                    Vec3::Y * 9.0,
                ][at];
                self.thing(index, |transform: &mut Transform| transform.translation = at);
            }
            Edit::ThingTurns(index) => self.thing(index, |transform: &mut Transform| {
                transform.rotation = (Quat::from_rotation_y(0.3) * transform.rotation).normalize();
            }),
            Edit::ThingCastsShadow(index) => {
                self.thing(index, |renderer: &mut MeshRenderer| renderer.casts_shadow = !renderer.casts_shadow);
            }
            Edit::ThingHides(index) => {
                self.thing(index, |renderer: &mut MeshRenderer| renderer.visible = !renderer.visible);
            }
            Edit::Shape(index) => {
                let [first, second] = self.shapes.clone();
                self.thing(index, |renderer: &mut MeshRenderer| {
                    renderer.mesh = if Arc::ptr_eq(&renderer.mesh, &first) { second } else { first };
                });
            }
            Edit::Surface(index, surface) => {
                let surface = Arc::clone(&self.surfaces[surface]);
                self.thing(index, |renderer: &mut MeshRenderer| renderer.material = surface);
            }
            Edit::LightComesOrGoes(index) => match self.lights[index].take() {
                Some(entity) => drop(self.world.ecs.despawn(entity)),
                None => {
                    let entity = self.world.spawn(&format!("light {index}"), None);
                    let intensity = 3.0 + index as f32;
                    self.insert(entity, Light { intensity, shadow_size: 64, rsm_size: 16, ..Default::default() });
                    self.lights[index] = Some(entity);
                    self.apply(Edit::LightMoves(index, index));
                }
            },
            Edit::LightMoves(index, at) => {
                let Some(entity) = self.lights[index] else { return };
                let at = [Vec3::new(0.8, 1.6, 0.6), Vec3::new(-0.9, 1.1, 0.9), Vec3::new(0.0, 1.8, -0.6)][at];
                let mut transform = Transform::from_translation(at);
                transform.rotation = Quat::from_rotation_arc(Vec3::NEG_Z, (-at).normalize());
                self.insert(entity, transform);
            }
            Edit::Texture(index, texture, state) => {
                let surface = Arc::clone(&self.textured[texture][state]);
                self.thing(index, |renderer: &mut MeshRenderer| renderer.material = surface);
            }
            Edit::FigureComesOrGoes => self.figure_comes_or_goes(),
            Edit::Pose(joint, weight) => self.pose(joint, weight),
            Edit::FigureChanges => {
                if let Some([model, _]) = self.figure {
                    self.insert(model, Transform::from_translation(Vec3::new(-0.4, 0.6, 0.5)));
                }
            }
            Edit::Sky(sky) => {
                let image = sky.checked_sub(SKIES - SKY_IMAGES).map(surfaces::sky_image);
                if let Some((_, loaded)) = &image {
                    self.world.ecs.insert_resource(loaded.clone());
                }
                let mut settings = self.world.ecs.resource_mut::<SceneSettings>();
                settings.sky = if sky == 1 { Vec3::splat(0.2) } else { Vec3::ZERO };
                // Two of them have nearly the same mean.
                let (blue, grey) = (Vec3::new(0.1, 0.2, 0.5), Vec3::splat(0.4));
                settings.environment = match sky {
                    2 => Some(Environment::Gradient { zenith: blue, horizon: grey, ground: Vec3::ZERO }),
                    3 => Some(Environment::Gradient { zenith: Vec3::ZERO, horizon: grey, ground: blue }),
                    4 => Some(Environment::Gradient { zenith: grey, horizon: blue, ground: grey }),
                    5 => Some(Environment::Physical { haze: 1.0, ground: grey, altitude: 0.0, sun: None }),
                    6 => Some(Environment::Physical { haze: 20.0, ground: blue, altitude: 500.0, sun: None }),
                    _ => image.map(|(environment, _)| environment),
                };
            }
            Edit::VolumeMoves(place) => {
                let at = [Vec3::Y, Vec3::new(0.3, 1.1, -0.2)][place];
                self.insert(self.volume, Transform::from_translation(at));
            }
            Edit::Camera(place) => {
                let at = [Vec3::new(1.6, 1.3, 2.0), Vec3::new(0.2, 1.0, 2.4), Vec3::new(1.9, 0.4, 0.3)][place];
                let mut transform = Transform::from_translation(at);
                let direction = (Vec3::new(-0.3, 0.5, -0.3) - at).normalize();
                transform.rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
                self.insert(self.eye, transform);
            }
            Edit::FogComesOrGoes(index) => match self.mists[index].take() {
                Some(entity) => drop(self.world.ecs.despawn(entity)),
                None => {
                    let entity = self.world.spawn(&format!("fog {index}"), None);
                    self.insert(entity, FOGS[3 * index]);
                    self.mists[index] = Some(entity);
                    self.apply(Edit::FogMoves(index, index));
                }
            },
            Edit::FogMoves(index, at) => {
                let Some(entity) = self.mists[index] else { return };
                let at = [Vec3::new(0.2, 0.6, 0.4), Vec3::new(-0.5, 1.0, -0.2), Vec3::Y * 9.0][at];
                let turn = Quat::from_rotation_z(at.x);
                self.insert(
                    entity,
                    Transform::from_translation(at).with_rotation(turn).with_scale(Vec3::new(1.0, at.y, 1.0)),
                );
            }
            Edit::Fog(index, kind) => {
                let Some(entity) = self.mists[index] else { return };
                self.insert(entity, FOGS[kind]);
            }
            Edit::Sparks(kind) => self.insert(self.fire, SPARKS[kind]),
            Edit::Time(time) => self.world.set_seconds([0.0, 0.35, 1.2][time]),
            Edit::Size(size) => self.size = [[24, 16], [16, 24]][size],
            Edit::Method(method) => METHODS[method](self),
            Edit::Set(index, path, value) => self.set(index, path, value),
            Edit::Tune(field, value) => {
                if let Some((path, value)) = self.tuned(field, value) {
                    self.set(0, path, value);
                }
            }
            Edit::Look(look) => LOOKS[look].1(&mut self.settings),
            Edit::Overlay(view) => looks::view(&mut self.settings, view),
            Edit::Shown(layer) => self.settings.only = [Layer::Total, Layer::Indirect, Layer::Direct][layer],
            Edit::Nothing => {}
        }
    }

    pub fn view(&mut self) -> SceneView {
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
        SceneView { camera: self.scene.cameras[0].clone(), size: self.size, jitter: [0.0; 2] }
    }
}
