//! The sky around the scene.

use crate::assets::SkyMap;
use bevy_ecs::prelude::Resource;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A sky that is not the same in all directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Environment {
    /// Changes with height alone; radiances [W/(m² sr)], linear RGB. See [`SkyMap::gradient`].
    Gradient {
        /// Straight up.
        zenith: Vec3,
        /// At the horizon.
        horizon: Vec3,
        /// Straight down.
        #[serde(default)]
        ground: Vec3,
    },
    /// An equirectangular `.hdr` or `.exr` image, twice as wide as high; its middle lies towards −Z.
    Image {
        /// Path, relative to the scene's file.
        file: String,
        /// Turn about the vertical, counter-clockwise seen from above \[degrees\].
        #[serde(default)]
        rotation: f32,
        /// Radiance [W/(m² sr)] of the image's value 1.
        #[serde(default = "one")]
        intensity: f32,
    },
    /// The sky of clear or hazy air, lit by a distant light of the scene whose light it dims and colours: that light's
    /// intensity is the irradiance outside the air. See [`Atmosphere`](crate::assets::Atmosphere).
    Physical {
        /// Aerosols, relative to clear air: 0 none, 5 a hazy day, 0..100.
        #[serde(default = "one")]
        haze: f32,
        /// Diffuse reflectance of the ground, 0..1.
        #[serde(default = "ground")]
        ground: Vec3,
        /// Height of the scene above the sea \[m\].
        #[serde(default)]
        altitude: f32,
        /// Name of the light that is the sun; without one it is the first light of kind `Sun` or `Directional`.
        #[serde(default)]
        sun: Option<String>,
    },
}

fn one() -> f32 {
    1.0
}

fn ground() -> Vec3 {
    Vec3::splat(0.3)
}

/// The sky's image that was loaded, with the environment that asked for it.
#[derive(Clone, Debug, Resource)]
pub struct EnvironmentImage {
    /// The request.
    pub environment: Environment,
    /// The image.
    pub map: Arc<SkyMap>,
}

impl EnvironmentImage {
    /// The map that was loaded, if the environment is the same image: turned and brightened otherwise perhaps.
    pub fn map_for(&self, wanted: &Environment) -> Option<&Arc<SkyMap>> {
        match (&self.environment, wanted) {
            (Environment::Image { file: known, .. }, Environment::Image { file, .. }) if known == file => {
                Some(&self.map)
            }
            _ => None,
        }
    }

    /// The map of an environment of the same image.
    pub fn made_for(&self, wanted: &Environment) -> Option<Arc<SkyMap>> {
        let map = self.map_for(wanted)?;
        if *wanted == self.environment {
            return Some(map.clone());
        }
        let (Environment::Image { intensity: known, .. }, Environment::Image { rotation, intensity, .. }) =
            (&self.environment, wanted)
        else {
            return None;
        };
        // What was loaded black has no image left to brighten.
        let factor = if *known > 0.0 { (intensity / known).max(0.0) } else { 0.0 };
        let is_finite = factor.is_finite() && rotation.is_finite();
        is_finite.then(|| Arc::new(map.varied(factor, rotation.to_radians())))
    }
}
