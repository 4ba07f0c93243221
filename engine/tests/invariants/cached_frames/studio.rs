//! The world that random edits change.

use glam::{Quat, Vec3, Vec3Swizzles, Vec4};
use lightwell::assets::{
    AlphaMode, Anisotropy, AssetId, Attenuation, Clearcoat, Iridescence, Material, Mesh, Shape, Sheen,
};
use lightwell::render::{GiMethod, Layer, ReferenceSettings, RenderSettings};
use lightwell::scene::{Extractor, Scene, SceneView};
use lightwell::world::*;
use proptest::prelude::*;
use std::sync::Arc;

const THINGS: usize = 3;
const LIGHTS: usize = 3;
const MISTS: usize = 2;
/// Places that fog may have.
const PLACES: usize = 3;
const KINDS: [LightKind; 8] = [
    LightKind::Point,
    LightKind::Directional,
    LightKind::Spot { inner: 20.0, outer: 50.0 },
    LightKind::Sun { angle: 5.0 },
    LightKind::Sphere { radius: 0.2 },
    LightKind::Disc { radius: 0.3 },
    LightKind::Rectangle { width: 0.5, height: 0.3 },
    LightKind::Tube { length: 0.6, radius: 0.05 },
];

/// What a fog may be, no fog at all included.
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

/// What particles may be, none at all included.
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
    LightComesOrGoes(usize),
    LightMoves(usize, usize),
    LightKind(usize, usize),
    LightStrength(usize, usize),
    LightFeedsIndirect(usize),
    LightCastsShadow(usize),
    LightColor(usize),
    LightRange(usize),
    LightMaps(usize),
    Sky(usize),
    Camera(usize),
    Lens(usize),
    VolumeMoves(usize),
    FogComesOrGoes(usize),
    FogMoves(usize, usize),
    Fog(usize, usize),
    Sparks(usize),
    Time(usize),
    Size(usize),
    Method(usize),
    Setting(usize),
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
        1 => (thing, 0..SURFACES).prop_map(|(thing, surface)| Surface(thing, surface)),
        3 => light.clone().prop_map(LightComesOrGoes),
        1 => (light.clone(), 0..3usize).prop_map(|(light, at)| LightMoves(light, at)),
        1 => (light.clone(), 0..KINDS.len()).prop_map(|(light, kind)| LightKind(light, kind)),
        1 => (light.clone(), 0..3usize).prop_map(|(light, strength)| LightStrength(light, strength)),
        2 => light.clone().prop_map(LightFeedsIndirect),
        1 => light.clone().prop_map(LightCastsShadow),
        1 => light.clone().prop_map(LightColor),
        1 => light.clone().prop_map(LightRange),
        1 => light.prop_map(LightMaps),
        2 => (0..SKIES).prop_map(Sky),
        1 => (0..3usize).prop_map(Camera),
        1 => (0..3usize).prop_map(Lens),
        1 => (0..2usize).prop_map(VolumeMoves),
        2 => fog.clone().prop_map(FogComesOrGoes),
        1 => (fog.clone(), 0..PLACES).prop_map(|(fog, at)| FogMoves(fog, at)),
        2 => (fog, 0..FOGS.len()).prop_map(|(fog, kind)| Fog(fog, kind)),
        2 => (0..SPARKS.len()).prop_map(Sparks),
        1 => (0..3usize).prop_map(Time),
        1 => (0..2usize).prop_map(Size),
        3 => (0..METHODS.len()).prop_map(Method),
        3 => (0..SETTINGS).prop_map(Setting),
        1 => (0..3usize).prop_map(Shown),
        1 => Just(Nothing),
    ]
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
        studio.settings.reference = ReferenceSettings { samples: 1, samples_a_frame: 1, ..Default::default() };
    },
];

const SETTINGS: usize = 26;

const SURFACES: usize = 11;
const SKIES: usize = 7;

/// A solid body of glass.
fn glass_body(color: Vec3, roughness: f32) -> Material {
    let volume = Some(Attenuation { color, distance: 0.5 });
    Material { transmission: 1.0, roughness, volume, ..Material::new("body") }
}

/// The world that is edited, and how it is drawn.
pub struct Studio {
    world: GameWorld,
    extractor: Extractor,
    pub scene: Scene,
    things: [Option<bevy_ecs::entity::Entity>; THINGS],
    lights: [Option<bevy_ecs::entity::Entity>; LIGHTS],
    mists: [Option<bevy_ecs::entity::Entity>; MISTS],
    volume: bevy_ecs::entity::Entity,
    fire: bevy_ecs::entity::Entity,
    eye: bevy_ecs::entity::Entity,
    shapes: [Arc<Mesh>; 2],
    surfaces: [Arc<Material>; SURFACES],
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
        let surfaces = [
            Material::diffuse("white", Vec3::splat(0.7)),
            Material::diffuse("red", Vec3::new(0.7, 0.1, 0.1)),
            Material { roughness: 0.2, metallic: 0.8, ..Material::new("metal") },
            Material { emissive: Vec3::new(1.0, 2.0, 0.5), ..Material::new("lamp") },
            Material {
                alpha_mode: AlphaMode::Blend,
                base_color: Vec4::new(0.4, 0.7, 0.9, 0.5),
                ..Material::new("veil")
            },
            Material { transmission: 0.9, double_sided: true, roughness: 0.3, ..Material::new("pane") },
            glass_body(Vec3::new(0.9, 0.4, 0.2), 0.0),
            glass_body(Vec3::new(0.2, 0.4, 0.9), 0.0),
            Material {
                clearcoat: Clearcoat { factor: 0.8, roughness: 0.2, ..Default::default() },
                ..Material::new("paint")
            },
            Material {
                sheen: Sheen { color: Vec3::new(0.9, 0.5, 0.5), roughness: 0.5 },
                iridescence: Iridescence { factor: 0.5, ..Default::default() },
                ..Material::new("silk")
            },
            Material {
                anisotropy: Anisotropy { strength: 0.7, rotation: 0.4 },
                metallic: 1.0,
                roughness: 0.4,
                ..Material::new("brushed")
            },
        ];
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
            shapes: [Shape::Box { size: [0.5; 3] }, Shape::Sphere { radius: 0.3, segments: 12, rings: 6 }]
                .map(|shape| Arc::new(shape.mesh().expect("a valid shape"))),
            surfaces: surfaces.map(|surface| Arc::new(Material { id: AssetId::fresh(), ..surface })),
            size: [24, 16],
            settings: RenderSettings::default(),
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
        studio.insert(eye, lightwell::world::Camera { fov: 70.0, primary: true, ..Default::default() });
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

    fn insert(&mut self, entity: bevy_ecs::entity::Entity, component: impl bevy_ecs::bundle::Bundle) {
        self.world.ecs.entity_mut(entity).insert(component);
    }

    fn spawn(&mut self, name: &str, mesh: Arc<Mesh>, at: Vec3) -> bevy_ecs::entity::Entity {
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

    fn thing<C: bevy_ecs::component::Component<Mutability = bevy_ecs::component::Mutable>>(
        &mut self,
        index: usize,
        change: impl FnOnce(&mut C),
    ) {
        let Some(entity) = self.things[index] else { return };
        if let Some(mut component) = self.world.ecs.get_mut::<C>(entity) {
            change(&mut component);
        }
    }

    fn light(&mut self, index: usize, change: impl FnOnce(&mut Light)) {
        let Some(entity) = self.lights[index] else { return };
        if let Some(mut light) = self.world.ecs.get_mut::<Light>(entity) {
            change(&mut light);
        }
    }

    /// A setting of the method that is on.
    fn set(&mut self, which: usize) {
        match (self.settings.gi, which) {
            (GiMethod::CLPV, 0) => self.clpv(|clpv| clpv.bounces = Bounces::Count(1)),
            (GiMethod::CLPV, 1) => self.clpv(|clpv| clpv.bounces = Bounces::Converged),
            (GiMethod::CLPV, 2) => self.clpv(|clpv| clpv.cascades = 3 - clpv.cascades.clamp(1, 2)),
            (GiMethod::CLPV, 3) => self.clpv(|clpv| clpv.gather_filter = 6 - clpv.gather_filter.min(6)),
            (GiMethod::CLPV, 4) => self.clpv(|clpv| clpv.occlusion = !clpv.occlusion),
            (GiMethod::CLPV, 5) => self.clpv(|clpv| clpv.camera_blockers = !clpv.camera_blockers),
            (GiMethod::CLPV, 6) => self.clpv(|clpv| clpv.placement = ClpvPlacement::Camera { ahead: 0.5 }),
            (GiMethod::CLPV, 7) => self.clpv(|clpv| clpv.placement = ClpvPlacement::Fixed),
            (GiMethod::VPL, 0) => self.vpl(|vpl| vpl.view_driven = !vpl.view_driven),
            (GiMethod::VPL, 1) => self.vpl(|vpl| vpl.visibility = VirtualVisibility::None),
            (GiMethod::VPL, 2) => self.vpl(|vpl| vpl.visibility = VirtualVisibility::ShadowRays),
            (GiMethod::VPL, 3) => self.vpl(|vpl| vpl.near_rays = 1 - vpl.near_rays.min(1)),
            (GiMethod::VPL, 4) => self.vpl(|vpl| vpl.accumulation = Accumulation::ByTheLetter),
            (GiMethod::VPL, 5) => self.vpl(|vpl| vpl.accumulation = Accumulation::Batched),
            (GiMethod::VPL, 6) => self.vpl(|vpl| vpl.candidates = 9 - vpl.candidates.clamp(1, 8)),
            (GiMethod::VPL, 7) => self.vpl(|vpl| {
                *vpl = InstantRadiosity { particles: 16, shading: VirtualShading::AsPublished, ..Default::default() };
            }),
            (GiMethod::SLC, 0) => self.slc(|slc| slc.culling = LightCulling::Tiled),
            (GiMethod::SLC, 1) => self.slc(|slc| slc.culling = LightCulling::None),
            (GiMethod::SLC, 2) => self.slc(|slc| slc.filter_radius = 8 - slc.filter_radius.min(8)),
            (GiMethod::SLC, 3) => self.slc(|slc| slc.delta = Delta::Relative(1e-2)),
            (GiMethod::SLC, 4) => self.slc(|slc| slc.seed += 1),
            (_, 8) => self.settings.each_light_alone = !self.settings.each_light_alone,
            (_, 9) => self.settings.exposure = 1.0 - self.settings.exposure,
            (_, 10) => self.settings.mlaa = !self.settings.mlaa,
            (_, 11) => {
                let mut settings = self.world.ecs.resource_mut::<SceneSettings>();
                settings.sky_light = !settings.sky_light;
            }
            (GiMethod::CLPV, 20) => self.clpv(|clpv| clpv.gradient_damping = 2.0 - clpv.gradient_damping),
            (GiMethod::CLPV, 21) => self.clpv(|clpv| clpv.outside_fade = 2.0 - clpv.outside_fade),
            (GiMethod::CLPV, 22) => self.clpv(|clpv| {
                clpv.formulas = match clpv.formulas {
                    Formulas::Corrected => Formulas::Printed,
                    Formulas::Printed => Formulas::Corrected,
                };
            }),
            (GiMethod::CLPV, 23) => self.clpv(|clpv| {
                clpv.gloss_march = match clpv.gloss_march {
                    GlossMarch::Off => GlossMarch::InverseDistance,
                    GlossMarch::InverseDistance => GlossMarch::InverseSquare,
                    GlossMarch::InverseSquare => GlossMarch::Off,
                };
            }),
            (GiMethod::CLPV, 24) => self.clpv(|clpv| clpv.ambient_occlusion = 0.5 - clpv.ambient_occlusion),
            (GiMethod::CLPV, 25) => self.clpv(|clpv| clpv.rsm_samples = 200 - clpv.rsm_samples),
            (_, 12..) => self.effect(which - 12),
            _ => {}
        }
    }

    /// Something that the lens of the camera does, on or off.
    fn effect(&mut self, which: usize) {
        let eye = self.eye;
        let Some(mut camera) = self.world.ecs.get_mut::<lightwell::world::Camera>(eye) else { return };
        let lens = &mut camera.lens;
        let blur = |focus| DepthOfField { focus, f_number: 0.2, ..DepthOfField::default() };
        match which {
            0 => lens.depth_of_field = if lens.depth_of_field.is_some() { None } else { Some(blur(1.5)) },
            1 => lens.depth_of_field = Some(blur(3.0)),
            2 => lens.bloom = if lens.bloom.is_some() { None } else { Some(Bloom::default()) },
            3 => lens.tone_map = if lens.tone_map == ToneMap::AgX { ToneMap::Reinhard } else { ToneMap::AgX },
            4 => {
                let exposure = Exposure::Photographic { f_number: 2.0, shutter: 0.02, iso: 400.0 };
                lens.exposure = if lens.exposure == exposure { Exposure::Automatic } else { exposure };
            }
            5 => lens.vignette = 0.5 - lens.vignette,
            6 => lens.sharpening = 0.5 - lens.sharpening,
            _ => lens.grain = 0.1 - lens.grain,
        }
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
            Edit::LightKind(index, kind) => self.light(index, |light| light.kind = KINDS[kind]),
            Edit::LightStrength(index, strength) => {
                self.light(index, |light| light.intensity = [0.0, 1.0, 6.0][strength]);
            }
            Edit::LightFeedsIndirect(index) => self.light(index, |light| light.indirect = !light.indirect),
            Edit::LightCastsShadow(index) => self.light(index, |light| light.casts_shadow = !light.casts_shadow),
            Edit::LightColor(index) => self.light(index, |light| light.color = light.color.zxy() * 0.9 + 0.05),
            Edit::LightRange(index) => self.light(index, |light| {
                light.range = if light.range.is_some() { None } else { Some(1.5) };
            }),
            Edit::LightMaps(index) => self.light(index, |light| {
                (light.shadow_size, light.rsm_size) = if light.rsm_size == 16 { (32, 8) } else { (64, 16) };
            }),
            Edit::Sky(sky) => {
                let mut settings = self.world.ecs.resource_mut::<SceneSettings>();
                settings.sky = if sky == 1 { Vec3::splat(0.2) } else { Vec3::ZERO };
                // Two of them have nearly the same mean.
                let (blue, grey) = (Vec3::new(0.1, 0.2, 0.5), Vec3::splat(0.4));
                settings.environment = [
                    None,
                    None,
                    Some(Environment::Gradient { zenith: blue, horizon: grey, ground: Vec3::ZERO }),
                    Some(Environment::Gradient { zenith: Vec3::ZERO, horizon: grey, ground: blue }),
                    Some(Environment::Gradient { zenith: grey, horizon: blue, ground: grey }),
                    Some(Environment::Physical { haze: 1.0, ground: grey, altitude: 0.0, sun: None }),
                    Some(Environment::Physical { haze: 20.0, ground: blue, altitude: 500.0, sun: None }),
                ][sky]
                    .clone();
            }
            Edit::Lens(lens) => {
                let (fov, near, projection) = [
                    (70.0, 0.1, Projection::Perspective),
                    (40.0, 0.2, Projection::Perspective),
                    (70.0, 0.1, Projection::Orthographic { height: 2.0 }),
                ][lens];
                if let Some(mut camera) = self.world.ecs.get_mut::<lightwell::world::Camera>(self.eye) {
                    (camera.fov, camera.near, camera.projection) = (fov, near, projection);
                }
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
            Edit::Setting(which) => self.set(which),
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
