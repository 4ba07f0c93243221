//! The particles as cached nodes of the frame: shot where lights, surfaces or settings changed, chosen from where the
//! view did, else kept.

use super::resampling;
use super::trace_particles::{Candidate, DISTANT, Particles, Setup, Shot, VirtualLight, candidates, simulate};
use super::{IntersectionCounts, VplError};
use crate::assets::AssetId;
use crate::gpu::Gpu;
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext};
use crate::render::frame::Frame;
use crate::render::rays::RayScene;
use crate::scene::{Aabb, Frustum, Scene};
use crate::world::{Accumulation, InstantRadiosity, ShadowLookup, VirtualPlacement, VirtualShading, VirtualVisibility};
use glam::Vec3;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;

/// Virtual lights and the scene that their rays are cast into. Keeps what was shot.
pub struct VirtualLights {
    pub(super) rays: RayScene,
    colors: HashMap<AssetId, Vec3>,
    /// The settings in use.
    pub(super) settings: InstantRadiosity,
    known: Option<String>,
    /// Most lights that there can be to choose from.
    most: u64,
    /// Most lights that the device binds at once.
    pub(super) most_bound: u64,
    shot: RefCell<Shot>,
    particles: RefCell<Particles>,
    /// How many of them the pass `reach` wrote last: known when it has run or was kept, like its buffer.
    reached: Cell<u32>,
}

/// Lights on the device.
#[derive(Clone, Copy)]
pub(super) struct Lights {
    /// Those that are summed.
    pub(super) buffer: Handle<Buffer>,
    /// All, the ones that reach nothing drawn with them.
    pub(super) all: Handle<Buffer>,
    /// Who knows how many are summed.
    pub(super) count: LightCount,
}

/// How many lights a buffer holds. Most are known only when the passes before have run.
#[derive(Clone, Copy)]
pub(super) enum LightCount {
    /// So many.
    Known(u32),
    /// All that the particles left.
    All,
    /// Those that reach what the view draws.
    Reached,
}

impl VirtualLights {
    /// Nothing shot yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            rays: RayScene::new(gpu),
            colors: HashMap::new(),
            settings: InstantRadiosity::default(),
            known: None,
            most: 0,
            most_bound: gpu.limits.max_storage_buffer_binding_size / size_of::<VirtualLight>() as u64,
            shot: RefCell::default(),
            particles: RefCell::default(),
            reached: Cell::new(0),
        }
    }

    /// Updates the scene for rays, and finds how many lights there can be. Costs nothing if nothing changed.
    ///
    /// # Errors
    /// If the scene is larger than the device can bind.
    pub fn update(&mut self, gpu: &Gpu, scene: &Scene) -> Result<(), VplError> {
        self.settings = scene.vpl.clone().unwrap_or_default();
        self.rays.update(gpu, scene)?;
        let key = self.key(scene);
        if self.known.as_ref() != Some(&key) {
            let setup = Setup::new(scene, &self.rays.bvh, &self.settings, &mut self.colors);
            self.most = match self.settings.placement {
                VirtualPlacement::Particles => setup.capacity(),
                VirtualPlacement::Rsm => u64::from(self.settings.particles) + 6 * scene.lights.len() as u64,
            };
            self.known = Some(key);
        }
        let limit = gpu.limits.max_buffer_size;
        let each = if self.is_chosen() { size_of::<Candidate>() } else { size_of::<VirtualLight>() };
        let needed = self.most.saturating_mul(each as u64);
        if needed > limit {
            let particles = self.settings.particles;
            return Err(VplError::TooMany {
                particles,
                candidates: candidates(&self.settings),
                lights: self.most,
                needed: needed >> 20,
                limit: limit >> 20,
                possible: (u128::from(particles) * u128::from(limit) / u128::from(needed)) as u64,
            });
        }
        Ok(())
    }

    /// Whether lights are chosen from more than are kept.
    fn is_chosen(&self) -> bool {
        self.settings.placement == VirtualPlacement::Particles && candidates(&self.settings) > 1
    }

    /// A buffer of as many lights as can be kept.
    fn desc(&self) -> BufferDesc {
        BufferDesc::new(self.most_kept() * size_of::<VirtualLight>() as u64, wgpu::BufferUsages::STORAGE)
    }

    /// Most lights that can be kept of those.
    pub(super) fn most_kept(&self) -> u64 {
        let kept = if self.is_chosen() { candidates(&self.settings) } else { 1 };
        self.most.div_ceil(kept.into())
    }

    /// Writes lights for shading.
    fn write(&self, cx: &mut PassContext, buffer: Handle<Buffer>, lights: &[VirtualLight]) {
        let bytes: &[u8] = bytemuck::cast_slice(lights);
        let counts = cx.counts();
        counts.lights += lights.len() as u64;
        counts.bytes += bytes.len() as u64;
        if !bytes.is_empty() {
            cx.gpu.write_buffer(cx.buffer(buffer), 0, bytes);
        }
    }

    /// Results of the last tracing of particles.
    pub fn particles(&self) -> std::cell::Ref<'_, Particles> {
        self.particles.borrow()
    }

    /// Intersection tests of the last simulation.
    pub fn casts(&self) -> IntersectionCounts {
        self.particles.borrow().casts
    }

    /// Whether the report's formulas are asked for, which hold for the main lights too.
    pub(in crate::render) fn published(&self) -> Option<&InstantRadiosity> {
        (self.settings.shading == VirtualShading::AsPublished).then_some(&self.settings)
    }

    /// Number of lights to sum, once the passes that write them have run or were kept.
    pub(super) fn count(&self, lights: &Lights) -> u32 {
        match lights.count {
            LightCount::Known(count) => count,
            LightCount::All => self.particles.borrow().lights.len() as u32,
            LightCount::Reached => self.reached.get(),
        }
    }

    /// All that particles depend on. Settings of the shading are left out.
    pub(super) fn key(&self, scene: &Scene) -> String {
        let settings = InstantRadiosity {
            accumulation: Accumulation::default(),
            visibility: VirtualVisibility::default(),
            view_driven: false,
            shadow_bias: 0.0,
            shadow_slope_bias: 0.0,
            shadow_samples: 0,
            shadow_offset: 0.0,
            shadow_lookup: ShadowLookup::default(),
            near_rays: 0,
            ..self.settings.clone()
        };
        let r = scene.revisions;
        let sky = (scene.sky.to_array().map(f32::to_bits), scene.sky_map.as_ref().map(|map| map.id));
        format!("{} {} {} {} {sky:?} {settings:?}", scene.identity, r.geometry, r.materials, r.lights)
    }
}

/// Declares the particles, and which of their lights the view needs.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, state: &'a VirtualLights) -> Option<Lights> {
    if state.most == 0 {
        graph.skip("particles", "nothing in the scene feeds indirect light, or no surface reflects any");
        return None;
    }
    let shot = declare_shots(graph, frame, state);
    let buffer = declare_choice(graph, frame, state, shot);
    if let Some(why) = why_all(state, frame) {
        graph.skip("reach", why);
        return Some(Lights { buffer, all: buffer, count: LightCount::All });
    }
    Some(declare_reach(graph, frame, state, buffer))
}

/// Why lights are summed that face nothing drawn; none where they are left out.
fn why_all(state: &VirtualLights, frame: &Frame) -> Option<&'static str> {
    if !state.settings.view_driven {
        Some("`view_driven` is off")
    } else if frame.settings.virtual_light.is_some() {
        Some("one light is shown by itself")
    } else if state.published().is_some() {
        Some("the report's lights shine to both sides of their surface")
    } else {
        None
    }
}

/// Declares the shooting. What the particles left stays on the processor; the device has the number of candidates.
fn declare_shots<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, state: &'a VirtualLights) -> Handle<Buffer> {
    let count = graph.retained_buffer("candidates", BufferDesc::new(4, wgpu::BufferUsages::STORAGE));
    // By hand, as the two passes after it: the host traces the particles.
    let mut pass = graph.pass("particles");
    let count = pass.write(count);
    pass.key(&state.key(frame.scene));
    let scene = frame.scene;
    pass.execute(move |cx| {
        let setup = Setup::new(scene, &state.rays.bvh, &state.settings, &mut state.colors.clone());
        let shot = simulate(scene, &state.rays.bvh, &state.settings, &setup);
        log::debug!("particles: {} shot, {} candidates, {:?}", shot.shot, shot.candidates.len(), shot.casts);
        cx.counts().paths += shot.shot;
        cx.gpu.write_buffer(cx.buffer(count), 0, &(shot.candidates.len() as u32).to_le_bytes());
        *state.shot.borrow_mut() = shot;
        Ok(())
    });
    count
}

/// Declares which candidates become lights.
fn declare_choice<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    state: &'a VirtualLights,
    shot: Handle<Buffer>,
) -> Handle<Buffer> {
    let buffer = graph.retained_buffer("virtual lights", state.desc());
    let mut pass = graph.pass("choice");
    pass.read(shot);
    let buffer = pass.write(buffer);
    let for_view = state.is_chosen();
    pass.key(&for_view.then(|| frame.view_key()));
    let (scene, view) = (frame.scene, frame.view);
    pass.execute(move |cx| {
        let (shot, settings) = (state.shot.borrow(), &state.settings);
        let particles = match for_view {
            true => resampling::for_view(&shot, scene, &state.rays.bvh, settings, view),
            false => resampling::all(&shot, scene, settings),
        };
        state.write(cx, buffer, &particles.lights);
        *state.particles.borrow_mut() = particles;
        Ok(())
    });
    buffer
}

/// Declares which lights can reach what is drawn: those with a drawn surface's box before their plane.
fn declare_reach<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    state: &'a VirtualLights,
    all: Handle<Buffer>,
) -> Lights {
    let reached = graph.retained_buffer("reached lights", state.desc());
    let mut pass = graph.pass("reach");
    pass.read(all);
    let buffer = pass.write(reached);
    pass.key(&(frame.geometry_key(), frame.view_key()));
    let frustum = frame.frustum();
    let scene = frame.scene;
    pass.execute(move |cx| {
        let lights = reaching(&state.particles.borrow().lights, scene, &frustum);
        state.write(cx, buffer, &lights);
        state.reached.set(lights.len() as u32);
        Ok(())
    });
    Lights { buffer, all, count: LightCount::Reached }
}

/// The lights before whose plane some primitive lies that the frustum may hold. Conservative: what is left out lights
/// nothing that is drawn.
fn reaching(lights: &[VirtualLight], scene: &Scene, frustum: &Frustum) -> Vec<VirtualLight> {
    let drawn: Vec<Aabb> =
        scene.primitives.iter().map(|primitive| primitive.bounds).filter(|bounds| frustum.intersects(bounds)).collect();
    let faces = |light: &&VirtualLight| {
        let (place, normal) = (Vec3::from(light.place), Vec3::from(light.normal));
        let before = |bounds: &Aabb| {
            let foremost = Vec3::select(normal.cmpge(Vec3::ZERO), bounds.max, bounds.min);
            normal.dot(foremost - place) > 0.0
        };
        light.kind == DISTANT || drawn.iter().any(before)
    };
    lights.iter().filter(faces).copied().collect()
}
