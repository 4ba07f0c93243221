//! The components that entities are made of. All of them are plain data that scene files hold as they are.

use crate::assets::{Material, Mesh};
use bevy_ecs::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::sync::Arc;

use super::lens::Lens;
use crate::core::{DEFAULT_NEAR, ORTHOGRAPHIC_HEIGHTS};
pub use crate::core::{GlobalTransform, LightKind, Orientation, Transform};

/// The entity's persistent name: unique among its siblings, shown in the inspector and in errors.
#[derive(Component, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Name(pub String);

/// A mesh with a material, drawn where the entity stands.
#[derive(Component, Clone, Debug)]
pub struct MeshRenderer {
    /// Geometry, shared.
    pub mesh: Arc<Mesh>,
    /// Surface, shared.
    pub material: Arc<Material>,
    /// Whether it casts shadows.
    pub casts_shadow: bool,
    /// Whether it is drawn at all.
    pub visible: bool,
}

impl MeshRenderer {
    /// Makes the surface emit light: radiance [W/(m² sr)], linear RGB. The material is this entity's own from then on.
    pub fn set_emissive(&mut self, radiance: Vec3) {
        if self.material.emissive != radiance {
            self.own_material().emissive = radiance;
        }
    }

    /// Sets the base colour, linear RGB, 0..1. The material is this entity's own from then on.
    pub fn set_color(&mut self, color: Vec3) {
        if self.material.base_color.truncate() != color {
            let material = self.own_material();
            material.base_color = color.extend(material.base_color.w);
        }
    }

    /// A copy of the material under an identity of its own: what has an identity never changes.
    fn own_material(&mut self) -> &mut Material {
        self.material = Arc::new(Material { id: crate::assets::AssetId::fresh(), ..(*self.material).clone() });
        Arc::make_mut(&mut self.material)
    }
}

/// A light source (radiometry as in `KHR_lights_punctual`, read as radiometric RGB). Spheres, discs, rectangles, tubes and suns
/// have a surface of even radiance: their shadows are soft, and surfaces that mirror show their shape. The entity's scale does
/// not change their size, and the camera does not see them.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Kind.
    pub kind: LightKind,
    /// Colour, linear RGB, multiplies the intensity.
    #[serde(default = "white")]
    pub color: Vec3,
    /// Intensity; unit by kind.
    pub intensity: f32,
    /// Distance beyond which there is no light \[m\]; none: no bound.
    #[serde(default)]
    pub range: Option<f32>,
    /// Whether it casts shadows.
    #[serde(default = "yes")]
    pub casts_shadow: bool,
    /// Whether it feeds indirect light. A light that does not interact needs no RSM.
    #[serde(default = "yes")]
    pub indirect: bool,
    /// Edge of the shadow map \[texels\], of each face for a point light.
    #[serde(default = "default_shadow_size")]
    pub shadow_size: u32,
    /// Edge of the reflective shadow map \[texels\], of each face for a point light.
    #[serde(default = "default_rsm_size")]
    pub rsm_size: u32,
}

fn white() -> Vec3 {
    Vec3::ONE
}
fn yes() -> bool {
    true
}
fn default_shadow_size() -> u32 {
    1024
}
fn default_rsm_size() -> u32 {
    128
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Point,
            color: Vec3::ONE,
            intensity: 1.0,
            range: None,
            casts_shadow: true,
            indirect: true,
            shadow_size: default_shadow_size(),
            rsm_size: default_rsm_size(),
        }
    }
}

/// How a camera projects what it sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Projection {
    /// What is farther away is smaller. The camera's field of view counts.
    #[default]
    Perspective,
    /// Along parallel lines: all is drawn to one scale, whatever its distance.
    Orthographic {
        /// Height of what is seen \[m\].
        height: f32,
    },
}

impl Projection {
    /// Heights that an orthographic camera may have \[m\].
    pub const HEIGHTS: RangeInclusive<f32> = ORTHOGRAPHIC_HEIGHTS;
}

/// A camera looking along −Z.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Perspective, or orthographic with the height of what is seen.
    pub projection: Projection,
    /// Vertical field of view \[degrees\]; with `projection: Perspective` alone.
    pub fov: f32,
    /// Near plane \[m\]; an orthographic camera may have it at 0.
    pub near: f32,
    /// Far plane \[m\]; none: infinite, or 100 heights away for an orthographic camera.
    pub far: Option<f32>,
    /// The camera that is used when none is named.
    pub primary: bool,
    /// What the camera makes of the light that it sees.
    pub lens: Lens,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            projection: Projection::Perspective,
            fov: 60.0,
            near: DEFAULT_NEAR,
            far: None,
            primary: false,
            lens: Lens::default(),
        }
    }
}

/// Where a light propagation volume lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ClpvPlacement {
    /// Centred on the entity.
    #[default]
    Fixed,
    /// Follows the view's camera: each cascade lies `ahead` of the way from its centre to its border before the
    /// eye along the view direction (0: centred on the eye), snapped to whole cells.
    Camera {
        /// Shift along the view direction as a fraction of the half extent, 0..1.
        ahead: f32,
    },
}

/// Edge of a cell of the finest cascade.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum CellSize {
    /// Fits the scene's bounds: the coarsest cascade just covers them.
    #[default]
    Auto,
    /// Length \[m\].
    Meters(f32),
}

/// How light gets from cell to cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Transport {
    /// Directions are kept: for each of many the light is swept once through the grid. Accurate; the default.
    #[default]
    Sweep,
    /// The thesis's propagation step by step, with four SH coefficients a cell. Off by 65 to 100 % of the indirect
    /// light whatever the grid, and kept as the measure of the thesis's tables.
    Diffusion,
}

/// How often light is reflected on its way (sweep transport).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Bounces {
    /// Without end: what is left after the bounces that are swept follows as a geometric series.
    #[default]
    Converged,
    /// So many reflections, 1 to 32. One: camera, surface, surface, light.
    Count(u32),
}

/// Accuracy against cost (sweep transport): directions, with [`CellSize::Auto`] the cells, and with
/// [`GatherRays::Auto`] the rays too. Where rays gather the light, the volumes are those of the step below: errors of
/// theirs are evened out over all that a pixel sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Quality {
    /// 96 directions for the first bounce; Auto: 24³ cells, no rays.
    Low,
    /// 4 rays. Without them 192 directions; 40³ cells.
    Medium,
    /// 8 rays. Without them 432 directions; 64³ cells.
    #[default]
    High,
    /// 16 rays. Without them 768 directions; 88³ cells.
    Ultra,
}

/// How many rays of a pixel gather light at the visible surfaces (sweep transport).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum GatherRays {
    /// As many as the quality says.
    #[default]
    Auto,
    /// So many, 0 to 16; 0: the volumes are looked up at the visible surfaces themselves.
    Count(u32),
    /// So many, 1 to 16, each of which goes on as a path over all further bounces instead of ending in light that is kept
    /// at the surfaces it meets: path tracing (Kajiya 1986) behind the same filter. Right in the mean whatever the surfaces
    /// are, with more noise and more rays than `Count`. For `gather_rays` alone.
    Paths(u32),
}

/// How precisely light is kept on its way from cell to cell (sweep transport). What is summed up is in single precision
/// either way, and so are sources and blockers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Precision {
    /// 32 bits a number.
    #[default]
    Single,
    /// 16 bits a number, under an exposure that follows the brightest source: half the memory traffic of the sweep.
    Half,
}

/// Which form of the thesis's formulas the diffusion uses (Šefčík 2016, sections 3.10 and 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Formulas {
    /// Flux is conserved: what a face receives is Δω_f·I, and blockers return a share of the flux that they stop.
    #[default]
    Corrected,
    /// As the thesis prints them: Δω_f/4π (3.5) loses most of the flux in each step, and the reflection of blockers (3.7)
    /// is added without being taken from the flux that passes.
    Printed,
}

/// How the diffusion reflects light in glossy surfaces: it marches along the reflected ray (Šefčík 2016, sections 3.10.4
/// and 5.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum GlossMarch {
    /// Surfaces reflect diffusely alone.
    #[default]
    Off,
    /// Steps are weighted by 1/d, as section 5.6 has it.
    InverseDistance,
    /// Steps are weighted by 1/d², as section 3.10.4 has it.
    InverseSquare,
}

/// Cascaded light propagation volumes: indirect light for the scene that holds this component.
///
/// Design and formulas: Petr Šefčík, "Computing global illumination in real-time using Cascaded Light Propagation
/// Volumes" (2016), chapters 3.10 and 5; Kaplanyan and Dachsbacher 2010.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Clpv {
    /// How light gets from cell to cell.
    pub transport: Transport,
    /// How often light is reflected; with `transport: Sweep` alone.
    pub bounces: Bounces,
    /// Accuracy against cost; with `transport: Sweep` alone.
    pub quality: Quality,
    /// Where the volumes lie.
    pub placement: ClpvPlacement,
    /// Rays of a pixel that gather light at the visible surfaces. They find what is smaller than a cell, glossy reflection
    /// included, and cost more the larger the image is. With `transport: Sweep` alone.
    pub gather_rays: GatherRays,
    /// Surface points that lights reach that each visible surface looks at beside its rays, each by a shadow ray and
    /// chosen from four. They are drawn from reflective shadow maps by their light, and find the small bright patches that
    /// rays mostly miss. `Auto`: a quarter as many as rays.
    pub gather_points: GatherRays,
    /// Rays of a pixel that shows a polished metal (roughness up to 0.25), and less on other smooth surfaces, by the share
    /// of the specular lobe, but one at least. They follow that lobe, as far as mirrors that they meet lead on. `Count(0)`:
    /// the rays that gather bring what mirrors show. `Auto`: as many as rays, and one in a window's frames.
    pub mirror_rays: GatherRays,
    /// Radius of the filter over gathered light \[pixels\], 0 to 32; 0: none. It is that of a single image: where n are
    /// averaged, the filter is ∛n times narrower.
    pub gather_filter: u32,
    /// Sweeps light along other directions in each frame where frames are averaged, as windows do: single small emitters
    /// then show no rays, and every frame sweeps. With `transport: Sweep` alone.
    pub vary_directions: bool,
    /// How precisely light is kept on its way; with `transport: Sweep` alone.
    pub precision: Precision,
    /// Number of nested volumes, 1 to 4; each has twice the cell size of the one before. With [`CellSize::Auto`] the
    /// sweep's coarsest covers the scene and the finer ones lie before the camera. Each costs about as much as the first.
    pub cascades: u32,
    /// Cells along x, y and z, the same in each cascade; 1 to 128. The sweep with [`CellSize::Auto`] takes its own.
    pub cells: [u32; 3],
    /// Cell size of the finest cascade.
    pub cell_size: CellSize,
    /// Propagation steps, 0 to 1024. Each step moves light by one cell; with `transport: Diffusion` alone.
    pub steps: u32,
    /// Whether blockers stop light on its way; with `transport: Diffusion` alone.
    pub occlusion: bool,
    /// Whether blocked light bounces back, multiplied by the blocker's reflectance; with `transport: Diffusion` alone.
    pub bounce: bool,
    /// Factor b on the blocking β = bβ: 4/3 makes a full wall opaque at SH order 2; 1 is the thesis's. With
    /// `transport: Diffusion` alone.
    pub blocker_scale: f32,
    /// Blockers are taken from the camera's G-buffer too; with `transport: Diffusion` alone.
    pub camera_blockers: bool,
    /// Factor k on the looked-up irradiance: 2/3 is exact for isotropic light, 1 for beams along an axis. With
    /// `transport: Diffusion` alone.
    pub gain: f32,
    /// Width of the border over which a cascade fades into the next coarser one, in cells; with `transport: Diffusion`
    /// alone.
    pub border_fade: f32,
    /// Width of the border over which the coarsest cascade fades into the unlit outside, in cells; 0: it is whole up to its
    /// border. With `transport: Diffusion` alone.
    pub outside_fade: f32,
    /// Which form of the thesis's formulas is used; with `transport: Diffusion` alone.
    pub formulas: Formulas,
    /// Strength s of the gradient damping; 0: none. Light whose coefficients differ by g times themselves over a cell along
    /// the normal is divided by 1 + s·g², which darkens what leaks through walls, and true gradients too. With
    /// `transport: Diffusion` alone.
    pub gradient_damping: f32,
    /// What glossy surfaces reflect; with `transport: Diffusion` alone.
    pub gloss_march: GlossMarch,
    /// Radius within which surfaces that the camera sees keep the volumes' light from each other \[m\], by screen-space
    /// ambient occlusion; 0: none. With `transport: Diffusion` alone.
    pub ambient_occlusion: f32,
    /// Texels of all reflective shadow maps that are injected, drawn in proportion to the flux that they reflect, 0 to
    /// 65536; 0: all texels. With `transport: Diffusion` alone.
    pub rsm_samples: u32,
}

impl Default for Clpv {
    fn default() -> Self {
        Self {
            transport: Transport::Sweep,
            bounces: Bounces::Converged,
            quality: Quality::High,
            placement: ClpvPlacement::Fixed,
            gather_rays: GatherRays::Auto,
            gather_points: GatherRays::Auto,
            mirror_rays: GatherRays::Auto,
            gather_filter: 8,
            vary_directions: false,
            precision: Precision::Single,
            cascades: 1,
            cells: [16, 16, 16],
            cell_size: CellSize::Auto,
            steps: 32,
            occlusion: true,
            bounce: true,
            blocker_scale: 4.0 / 3.0,
            camera_blockers: false,
            gain: 2.0 / 3.0,
            border_fade: 2.0,
            outside_fade: 0.0,
            formulas: Formulas::Corrected,
            gradient_damping: 0.0,
            gloss_march: GlossMarch::Off,
            ambient_occlusion: 0.0,
            rsm_samples: 0,
        }
    }
}

/// Radiance of the sky and other things that belong to the whole scene.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneSettings {
    /// Radiance of the sky [W/(m² sr)], linear RGB, alike in all directions.
    pub sky: Vec3,
    /// A sky that differs by direction, in place of the constant one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment: Option<super::Environment>,
    /// Whether the sky lights the scene where the method of indirect light brings no light of the sky itself: with
    /// `none`, with the diffusion, and with light culling without shadow rays.
    pub sky_light: bool,
    /// Display exposure as a power of two. Never touches a measured image.
    pub exposure: f32,
    /// Exposes the display image by its own brightness, as [`Exposure::Automatic`](super::Exposure::Automatic) does, for
    /// cameras without an exposure of their own; `exposure` comes on top.
    pub auto_exposure: bool,
    /// Speed of the fly camera [m/s].
    pub move_speed: f32,
    /// Length of one animation loop \[s\]; `render --frames` and `play` wrap there. None: no loop.
    pub duration: Option<f32>,
    /// Frames a second of the fixed clock.
    pub frame_rate: u32,
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            sky: Vec3::ZERO,
            environment: None,
            sky_light: true,
            exposure: 0.0,
            auto_exposure: false,
            move_speed: 3.0,
            duration: None,
            frame_rate: 30,
        }
    }
}
