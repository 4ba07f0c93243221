//! The sky, and what its air does to the light of the sun.

use super::context::{Context, Part};
use crate::assets::{Atmosphere, AtmosphereTables, SkyMap};
use crate::scene::{Scene, SunDisc};
use crate::world::{
    Environment, EnvironmentImage, GlobalTransform, Identity, Light, LightKind, Name, Orientation, SceneSettings,
    forward,
};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::Vec3;
use std::f32::consts::PI;
use std::sync::Arc;

/// Steps of the sun's elevation in which the sky changes \[rad\]: a twentieth of a degree.
const STEP: f32 = 0.05 * PI / 180.0;
/// Half the angle of the smallest disc \[rad\], as in `direct/area.wgsl`: rounding would make another one of what is smaller.
const LEAST: f32 = 5e-4;
/// Radiance of the brightest disc, so that sums with it stay finite [W/(m² sr)].
const MAX_RADIANCE: f32 = 1e30;

type Row = (Entity, &'static Identity, Option<&'static Name>, &'static Orientation, &'static Light);
type Suns = Query<'static, 'static, Row, With<GlobalTransform>>;

/// Extracted sky of the world, with the inputs of its map.
pub(super) struct Sky {
    state: SystemState<(Suns,)>,
    /// The sky's radiance as the world has it.
    radiance: Option<[u32; 3]>,
    /// Inputs of the scene's map: the environment, the loaded image, and the sun.
    environment: Option<Environment>,
    image: Option<Arc<SkyMap>>,
    lit_by: Option<LitBy>,
    tables: Option<AtmosphereTables>,
    sun: Option<Sun>,
    /// The sky below a sun of irradiance 1, by the step of its elevation.
    unit: Option<(i32, SkyMap)>,
    /// Counts changes of the air and of which light the sun is.
    version: u64,
}

/// The light that is the sun.
#[derive(Clone, Copy, PartialEq)]
struct Sun {
    entity: Entity,
    /// Unit direction towards it.
    toward: Vec3,
    /// Irradiance outside the air [W/m²].
    irradiance: Vec3,
    /// Half the angle of its disc \[rad\]; 0: it has none.
    half_angle: f32,
}

/// Inputs of a physical sky besides its air.
#[derive(Clone, Copy, PartialEq)]
struct LitBy {
    step: i32,
    turn: f32,
    irradiance: Vec3,
}

/// Attenuation of sunlight by the air.
#[derive(Clone, Copy)]
pub(super) struct Air<'a> {
    physical: Option<(Entity, &'a AtmosphereTables)>,
    /// Changes where another light, or all light that is dimmed, is to be looked at again.
    pub version: u64,
}

impl Air<'_> {
    /// Share of a light that arrives, by the direction that it travels in.
    pub fn passes(&self, light: Entity, direction: Vec3) -> Vec3 {
        match self.physical {
            Some((sun, tables)) if sun == light => tables.sunlight(-direction.y),
            _ => Vec3::ONE,
        }
    }
}

impl Sky {
    pub fn new(world: &mut World) -> Self {
        Self {
            state: SystemState::new(world),
            radiance: None,
            environment: None,
            image: None,
            lit_by: None,
            tables: None,
            sun: None,
            unit: None,
            version: 0,
        }
    }

    /// Finds out which light is the sun, where air dims it.
    pub fn find_sun(&mut self, world: &mut World) {
        let environment = world.get_resource::<SceneSettings>().and_then(|s| s.environment.clone());
        let (atmosphere, sun) = match &environment {
            Some(Environment::Physical { haze, ground, altitude, sun }) => {
                let atmosphere = Atmosphere { haze: *haze, ground: *ground, altitude: *altitude }.sanitized();
                (Some(atmosphere), self.first_sun(world, sun.as_deref()))
            }
            _ => (None, None),
        };
        if self.tables.as_ref().map(AtmosphereTables::atmosphere) != atmosphere.as_ref() {
            self.tables = atmosphere.map(AtmosphereTables::new);
            (self.unit, self.lit_by) = (None, None);
            self.version += 1;
        }
        if self.sun.map(|sun| sun.entity) != sun.map(|sun| sun.entity) {
            self.version += 1;
        }
        self.sun = sun;
    }

    /// The first distant light, or the first of them with a name.
    fn first_sun(&mut self, world: &mut World, wanted: Option<&str>) -> Option<Sun> {
        let (suns,) = self.state.get(world).ok()?;
        let is_wanted = |name: Option<&Name>| wanted.is_none_or(|wanted| name.is_some_and(|name| name.0 == wanted));
        let distant = suns.iter().filter(|(_, _, name, _, light)| {
            matches!(light.kind, LightKind::Directional | LightKind::Sun { .. }) && is_wanted(*name)
        });
        let (entity, _, _, orientation, light) = distant.min_by_key(|(_, identity, ..)| identity.id())?;
        let product = light.color * light.intensity;
        let irradiance = if product.is_finite() { product.max(Vec3::ZERO) } else { Vec3::ZERO };
        let half_angle = match light.kind {
            LightKind::Sun { angle } if angle.is_finite() => (0.5 * angle).to_radians().clamp(0.0, 0.25 * PI),
            _ => 0.0,
        };
        Some(Sun { entity, toward: -Vec3::from(forward(orientation)), irradiance, half_angle })
    }

    pub fn air(&self) -> Air<'_> {
        let physical = self.sun.zip(self.tables.as_ref()).map(|(sun, tables)| (sun.entity, tables));
        Air { physical, version: self.version }
    }

    /// Keeps the scene's sky current; a map is made again only if what it is made of has changed.
    pub fn extract(&mut self, world: &World, scene: &mut Scene, context: &mut Context) {
        let settings = world.get_resource::<SceneSettings>();
        scene.sky_light = settings.is_none_or(|s| s.sky_light);
        self.extract_map(world, settings, scene, context);
        self.extract_disc(scene, context);
        if scene.sky_map.is_none() {
            self.extract_radiance(settings, scene, context);
        }
    }

    fn extract_map(
        &mut self,
        world: &World,
        settings: Option<&SceneSettings>,
        scene: &mut Scene,
        context: &mut Context,
    ) {
        let environment = settings.and_then(|s| s.environment.clone());
        let loaded = world.get_resource::<EnvironmentImage>();
        let map = environment.as_ref().and_then(|environment| loaded.and_then(|image| image.map_for(environment)));
        let is_stale = map.is_some_and(|map| self.image.as_ref().is_none_or(|known| !Arc::ptr_eq(map, known)));
        let lit_by = self.tables.as_ref().and(self.sun).map(LitBy::of);
        if self.environment == environment && !is_stale && self.lit_by == lit_by {
            return;
        }
        context.log.begin_all(Part::Sky);
        scene.sky_map = match &environment {
            Some(Environment::Gradient { zenith, horizon, ground }) => {
                Some(Arc::new(SkyMap::gradient(*zenith, *horizon, *ground)))
            }
            Some(Environment::Image { file, .. }) => {
                if map.is_none() {
                    let message = format!("the sky's image {file} is not loaded: load the scene again from its file");
                    context.log.warn_of_sky(message);
                }
                environment.as_ref().and_then(|environment| loaded?.made_for(environment))
            }
            Some(Environment::Physical { sun, .. }) => {
                if lit_by.is_none() {
                    context.log.warn_of_sky(without_sun(sun.as_deref()));
                }
                lit_by.and_then(|lit_by| self.physical(lit_by))
            }
            None => None,
        };
        (self.image, self.environment, self.lit_by, self.radiance) = (map.cloned(), environment, lit_by, None);
        scene.sky = scene.sky_map.as_ref().map_or(Vec3::ZERO, |map| map.mean());
        scene.revisions.settings = context.revisions.next();
    }

    /// The sky of the air below the sun.
    fn physical(&mut self, lit_by: LitBy) -> Option<Arc<SkyMap>> {
        let unit = match self.unit.take().filter(|(step, _)| *step == lit_by.step) {
            Some(unit) => unit,
            None => (lit_by.step, self.tables.as_ref()?.sky((lit_by.step as f32 * STEP).sin())),
        };
        let (_, map) = self.unit.insert(unit);
        Some(Arc::new(map.lit(lit_by.irradiance, lit_by.turn)))
    }

    /// The sun as it is seen in the sky.
    fn extract_disc(&self, scene: &mut Scene, context: &mut Context) {
        let disc = self.sun.zip(self.tables.as_ref()).filter(|(sun, _)| sun.half_angle > 0.0).map(|(sun, tables)| {
            let half_angle = sun.half_angle.max(LEAST);
            let sine = half_angle.sin();
            let irradiance = sun.irradiance * tables.sunlight(sun.toward.y);
            let radiance = (irradiance / (PI * sine * sine)).min(Vec3::splat(MAX_RADIANCE));
            SunDisc { toward: sun.toward, half_angle, radiance }
        });
        if scene.sun_disc != disc {
            scene.sun_disc = disc;
            scene.revisions.settings = context.revisions.next();
        }
    }

    fn extract_radiance(&mut self, settings: Option<&SceneSettings>, scene: &mut Scene, context: &mut Context) {
        let wanted = settings.map_or(Vec3::ZERO, |s| s.sky);
        let sky = if wanted.is_finite() && wanted.cmpge(Vec3::ZERO).all() { wanted } else { Vec3::ZERO };
        let bits = Some(wanted.to_array().map(f32::to_bits));
        if self.radiance != bits {
            self.radiance = bits;
            // A warning of the environment stays.
            if self.environment.is_none() {
                context.log.begin_all(Part::Sky);
            }
            if sky != wanted {
                let message = format!("the sky's radiance {wanted} is negative or not finite; it is black now");
                context.log.warn_of_sky(message);
            }
        }
        if sky != scene.sky || scene.revisions.settings == 0 {
            scene.sky = sky;
            scene.revisions.settings = context.revisions.next();
        }
    }
}

impl LitBy {
    fn of(sun: Sun) -> Self {
        let step = (sun.toward.y.clamp(-1.0, 1.0).asin() / STEP).round() as i32;
        // The sun of the map is towards −Z.
        let turn = -sun.toward.x.atan2(-sun.toward.z);
        Self { step, turn, irradiance: sun.irradiance }
    }
}

fn without_sun(wanted: Option<&str>) -> String {
    match wanted {
        Some(name) => format!(
            "the physical sky has no sun: there is no light `{name}` of kind Sun or Directional; the colour `sky` is shown"
        ),
        None => {
            "the physical sky has no sun: add a light of kind Sun or Directional; the colour `sky` is shown".to_owned()
        }
    }
}
