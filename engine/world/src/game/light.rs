//! How bright it is somewhere: the light that reaches a point, for games whose rules ask for it.
//!
//! Direct light follows from the lights and what stands before them, on the CPU, at every step. Indirect light is
//! looked up where the renderer keeps it, in the light volumes, for all probes at once, and is there one frame later, in
//! windows up to three; it needs a scene with a `clpv` component, and frames that are drawn.

use super::space::SpatialQuery;
use crate::files::SceneData;
use crate::world::{GlobalTransform, Light, LightKind, Orientation, forward, right};
use bevy_ecs::prelude::*;
use glam::Vec3;

/// Measures the light where its entity stands.
///
/// Irradiance E [W/m²], linear RGB: of a surface with a normal, or without one the mean over all normals, a quarter of
/// the light that comes from all around (E = ∫L dω/4: even light of radiance L gives π·L either way).
#[derive(Component, SceneData, Clone, Copy, Debug, Default, PartialEq)]
pub struct LightProbe {
    /// Normal of the surface that is asked for, in the world; none: the mean over all.
    pub normal: Option<Vec3>,
    /// Where it measures, from the entity's place, along the axes of the world \[m\].
    pub offset: Vec3,
    /// Straight from lights, as of the last step [W/m²].
    #[serde(skip)]
    pub direct: Vec3,
    /// From surfaces and sky, as of the last frame [W/m²].
    #[serde(skip)]
    pub indirect: Vec3,
}

impl LightProbe {
    /// All light [W/m²].
    pub fn irradiance(&self) -> Vec3 {
        self.direct + self.indirect
    }

    /// All light as the eye weighs its colours (luminance of Rec. 709) [W/m²].
    pub fn brightness(&self) -> f32 {
        self.irradiance().dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }
}

/// Measures the direct light of all probes.
pub(super) fn update(
    space: Res<SpatialQuery>,
    mut probes: Query<(Entity, &mut LightProbe, &GlobalTransform)>,
    lights: Query<(&Light, &GlobalTransform, &Orientation)>,
) {
    for (entity, mut probe, place) in &mut probes {
        let at = Vec3::from(place.0.translation) + probe.offset;
        let normal = probe.normal.map(|n| n.normalize_or(Vec3::Y));
        let direct = lights
            .iter()
            .map(|(light, place, axes)| {
                let Some((irradiance, source)) = arriving(light, place, axes, at) else { return Vec3::ZERO };
                let share = normal.map_or(0.25, |n| n.dot((source - at).normalize_or_zero()).max(0.0));
                // What the probe measures on stands in nobody's light but its own.
                let lit = share > 0.0 && (!light.casts_shadow || space.is_clear(at, source, |other| other != entity));
                if lit { irradiance * share } else { Vec3::ZERO }
            })
            .sum::<Vec3>();
        if probe.direct != direct {
            probe.direct = direct;
        }
    }
}

/// How far away the sun is taken to stand for shadows \[m\].
const FAR: f32 = 1e4;

/// Irradiance of a surface that faces the light, and where the light is: I/d² with the window of a range and the
/// smoothing of a cone as in glTF's `KHR_lights_punctual`. Lights with a surface count as if they were far off.
fn arriving(light: &Light, place: &GlobalTransform, axes: &Orientation, at: Vec3) -> Option<(Vec3, Vec3)> {
    let intensity = light.color * light.intensity;
    let axis = Vec3::from(forward(axes));
    if matches!(light.kind, LightKind::Directional | LightKind::Sun { .. }) {
        return Some((intensity, at - axis * FAR));
    }
    let source = Vec3::from(place.0.translation);
    let way = at - source;
    let distance = way.length();
    let window = light.range.map_or(1.0, |range| (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0));
    let cone = match light.kind {
        LightKind::Spot { inner, outer } => {
            let (inner, outer) = (inner.to_radians().cos(), outer.to_radians().cos());
            let t = ((axis.dot(way / distance) - outer) / (inner - outer).max(1e-6)).clamp(0.0, 1.0);
            t * t
        }
        LightKind::Disc { .. } | LightKind::Rectangle { .. } => axis.dot(way / distance).max(0.0),
        LightKind::Tube { .. } => Vec3::from(right(axes)).cross(way / distance).length(),
        _ => 1.0,
    };
    let irradiance = intensity * (window * cone / (distance * distance));
    (irradiance.is_finite() && irradiance != Vec3::ZERO).then_some((irradiance, source))
}
