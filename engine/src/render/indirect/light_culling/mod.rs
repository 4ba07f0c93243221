//! Stochastic light culling: one bounce of indirect light from many virtual lights, each with a random range (Tokuyoshi
//! and Harada 2016, "Stochastic Light Culling"; with bounding ellipsoids of GGX lobes 2017, "Stochastic Light Culling
//! for VPLs on GGX Microsurfaces").
//!
//! ```text
//! rsm (a light), particles ─ virtual lights ─ error bound ─ ranges ─┐
//! gbuffer ───────────────────────────────── cull tiles ──┴─ shade ─ filter
//! ```
//! To compare there are the paper's rivals: spheres as bounds, tiles with 32 slices of depth, and splatting, which draws
//! the ranges in place of culling and shading.
//!
//! A light with intensity I(ω) is accepted at a distance l with p = min(I/(δ·l²), 1) > ξ, and its contribution is divided
//! by p: the mean over ξ is the sum over all lights. Since ξ is one number a light, the points that accept it lie within
//! l² = I(ω)/(δ·ξ), for which there are tight bounds: a sphere for the diffuse lobe, a spheroid for the GGX lobe.

mod cull;
mod filter;
mod lights;
pub mod lobe;
#[cfg(test)]
mod lobe_tests;
mod method;
mod particle_lights;
mod presets;
mod shade;
mod splat;
mod warnings;

#[cfg(test)]
pub(crate) use lights::{ChancesUniform, CullingUniform, DeltaUniform, PlaceUniform};
#[cfg(test)]
pub(crate) use particle_lights::{ParticleLight, PlacingUniform};

use crate::gpu::{Gpu, ShaderDef};
use crate::graph::{Buffer, Graph, Handle, PassBindings, Texture, TextureDesc};
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::world::{LightCulling, LightLobes, LightVisibility, StochasticLightCulling};
use glam::Vec3;

pub(in crate::render) use method::LightCullingMethod;

/// Name of the retained texture of what diffuse surfaces answer to; its alpha is the number of lights tested.
pub const TESTED: &str = "slc diffuse";
/// Name of the retained texture of specular light; its alpha is the number of lights accepted.
pub const ACCEPTED: &str = "slc specular";
/// Edge of a tile \[pixels of a subset's image\].
const TILE: u32 = 16;
/// Slices of depth in a tile: HalfZ, and clustered shading as the paper of 2017 compares it (section 7).
const HALVES: u32 = 2;
const CLUSTERS: u32 = 32;
/// Lights that a turn of the loop over all lights takes, without rays.
const LIGHTS_A_TURN: u64 = 4;

/// The settings of a scene: its own or the default ones.
pub(in crate::render) fn settings(scene: &crate::scene::Scene) -> StochasticLightCulling {
    scene.slc.clone().unwrap_or_default().sanitized()
}

/// Whether shadow rays are cast.
pub(in crate::render) fn casts_rays(settings: &StochasticLightCulling) -> bool {
    settings.visibility == LightVisibility::ShadowRays
}

/// Shared settings of all passes.
#[derive(Clone)]
struct Method {
    settings: StochasticLightCulling,
    /// Virtual lights of a subset.
    lights: u32,
    /// Tiles of a subset's image.
    tiles: [u32; 2],
    /// ξ of this frame.
    seed: u32,
    /// Root of the ray hierarchy.
    root: u32,
    /// Radiance of the sky, where rays are cast \[W/(m² sr)\]; of one that differs by direction the mean.
    sky: Vec3,
}

/// The virtual lights of a frame.
#[derive(Clone, Copy)]
struct Sources {
    ranges: Handle<Buffer>,
    /// The lights as shading reads them.
    texels: Handle<Texture>,
    bound: Handle<Buffer>,
}

/// Unfiltered light.
#[derive(Clone, Copy)]
struct Shaded {
    diffuse: Handle<Texture>,
    specular: Handle<Texture>,
}

impl Method {
    fn subsets(&self) -> u32 {
        self.settings.interleave * self.settings.interleave
    }

    /// Slices of depth in a tile.
    fn slices(&self) -> u32 {
        if self.settings.culling == LightCulling::Clustered { CLUSTERS } else { HALVES }
    }

    /// Lets a shader that reads or writes masks know the number of slices.
    fn define_slices(&self, pass: &mut PassBindings) {
        if self.slices() != HALVES {
            pass.define("SLICES", ShaderDef::Uint(self.slices()));
        }
    }

    /// Whether diffuse and GGX lobes shine.
    fn lobes(&self) -> [bool; 2] {
        [LightLobes::Specular, LightLobes::Diffuse].map(|other| self.settings.lobes != other)
    }

    /// Words of a mask of all lights of a subset: as many as workgroups fill at once.
    fn words(&self) -> u32 {
        self.lights.div_ceil(256).max(1) * 8
    }

    /// Words of all masks with their summaries.
    fn mask_words(&self) -> u64 {
        let tiles = u64::from(self.tiles[0]) * u64::from(self.tiles[1]) * u64::from(self.subsets());
        let words = self.words();
        tiles * u64::from(self.slices()) * 2 * u64::from(words + words.div_ceil(32))
    }
}

/// Declares all passes of indirect light; the result is reflected radiance, rgba32float. None, with the reason in the
/// report, if no light feeds it.
///
/// # Errors
/// If the lights or their masks do not fit the device.
fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gpu: &Gpu,
) -> Result<Option<Handle<Texture>>, RenderError> {
    let settings = settings(frame.scene);
    let maps = lights::maps(graph, frame, &settings);
    let of_maps: u64 = maps.iter().map(|map| lights::lights_of(map, settings.interleave)).sum();
    let lights = of_maps + u64::from(particle_lights::count(frame.scene));
    let sky = if casts_rays(&settings) { frame.scene.sky } else { Vec3::ZERO };
    if lights == 0 && sky == Vec3::ZERO {
        graph.skip("slc", "no light feeds indirect light");
        return Ok(None);
    }
    let [width, height] = frame.view.size;
    let covered = TILE * settings.interleave;
    let method = Method {
        // Under a sky alone there is one light of no flux.
        lights: u32::try_from(lights).unwrap_or(u32::MAX).max(1),
        tiles: [width.div_ceil(covered), height.div_ceil(covered)],
        seed: settings.seed ^ frame.seed(),
        root: frame.rays.map_or(0, |rays| rays.root()),
        sky,
        settings,
    };
    check_memory(gpu, &method, frame.view.size)?;
    splat::check(gpu, &method, frame.view.size)?;
    check_loops(gpu, &method)?;
    let sources = lights::declare(graph, frame, &maps, &method);
    let shaded = match method.settings.culling {
        LightCulling::None => {
            graph.skip("slc cull", "all lights are shaded at every pixel");
            shade::declare(graph, frame, gbuffer, &method, sources, None)
        }
        LightCulling::Splatting => {
            graph.skip("slc cull", "all lights are drawn");
            splat::declare(graph, frame, gbuffer, &method, sources)
        }
        LightCulling::Tiled | LightCulling::Clustered => {
            let culled = cull::declare(graph, frame, gbuffer, &method, sources);
            shade::declare(graph, frame, gbuffer, &method, sources, Some(culled))
        }
    };
    Ok(Some(filter::declare(graph, frame, gbuffer, &method, shaded)))
}

/// Whether all buffers can be bound.
fn check_memory(gpu: &Gpu, method: &Method, size: [u32; 2]) -> Result<(), RenderError> {
    let limit = gpu.limits.max_storage_buffer_binding_size;
    let count = u64::from(method.lights) * u64::from(method.subsets());
    let culling = method.settings.culling;
    let is_masked = matches!(culling, LightCulling::Tiled | LightCulling::Clustered);
    let masks = if is_masked { 4 * method.mask_words() } else { 0 };
    let frames = if is_masked { cull::FRAME_BYTES * count } else { 0 };
    let pixels = 4 * u64::from(size[0]) * u64::from(size[1]);
    let of_masks = match culling {
        LightCulling::Clustered => "a smaller `slc.rsm_size`, or `Tiled` culling, whose masks are a 16th of that",
        _ => "a smaller `slc.rsm_size`",
    };
    let needs = [
        (lights::LIGHT_BYTES * count, format!("{count} virtual lights"), "a smaller `slc.rsm_size`"),
        (masks, format!("the light masks of {count} virtual lights, `{culling:?}`,"), of_masks),
        (frames, format!("the frames of {count} virtual lights"), "a smaller `slc.rsm_size`"),
        (pixels, "the slices of so many pixels".to_owned(), "a smaller image"),
    ];
    match needs.into_iter().find(|(bytes, ..)| *bytes > limit) {
        None => Ok(()),
        Some((bytes, what, help)) => Err(RenderError::method(format!(
            "stochastic light culling: {what} take {} MiB, and this adapter binds at most {} MiB at once: use {help}",
            bytes.div_ceil(1 << 20),
            limit >> 20
        ))),
    }
}

/// lavapipe ends all loops of a thread after 65,535 turns together, without a word: the sum over all lights would lack
/// some. A ray takes up to some hundred turns.
fn check_loops(gpu: &Gpu, method: &Method) -> Result<(), RenderError> {
    const MOST: u64 = 65_535;
    let unculled = method.settings.culling == LightCulling::None && gpu.is_software();
    let lobes = method.lobes().into_iter().filter(|shines| *shines).count() as u64;
    let a_lobe = match casts_rays(&method.settings) {
        true => 256 * u64::from(method.lights),
        false => u64::from(method.lights) / LIGHTS_A_TURN + u64::from(method.lights) % LIGHTS_A_TURN,
    };
    let turns = lobes * a_lobe;
    if !unculled || turns <= MOST {
        return Ok(());
    }
    Err(RenderError::method(format!(
        "stochastic light culling: all {} lights of a pixel take up to {turns} turns of a loop, which software drivers end after {MOST}: use a \
         larger `slc.interleave`, a smaller `slc.rsm_size`, or no shadow rays",
        method.lights
    )))
}

/// A texture of four floats a pixel.
fn image_desc(frame: &Frame) -> TextureDesc {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage)
}
