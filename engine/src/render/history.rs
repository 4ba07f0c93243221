//! The frames before: which of them this one goes on with, and how much they count. Where light or objects move, older
//! frames count for little: [`MOST_WHILE_CHANGING`].

use super::settings::RenderSettings;
use crate::gpu::Gpu;
use crate::scene::{Scene, SceneView};
use glam::Mat4;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Frames of a view that rests that are averaged.
pub const MOST_FRAMES: u32 = 64;

/// Frames before that count at most while light or objects change: in the mean 0.7ⁿ of the light of n frames ago is left,
/// 6 % after eight.
const MOST_WHILE_CHANGING: f32 = 7.0 / 3.0;
/// For so many frames after a change.
const UNREST: u32 = 8;

/// What a frame does with those before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Frames since the first of them; other random numbers in each.
    pub number: u32,
    /// Distinguishes one row of frames from another.
    pub row: u64,
    /// Frames since the picture last changed in any way.
    pub rested: u32,
    /// Frames before that count at most.
    pub most: f32,
    /// The same of what mirrors.
    pub most_glossy: f32,
    /// Whether the camera is where it was.
    pub is_still: bool,
    pub clip_from_world_before: Mat4,
    pub world_from_clip_before: Mat4,
}

/// The light of the frames before, and what is known of the last.
#[derive(Default)]
pub(crate) struct History {
    step: Option<Step>,
    last: Option<Seen>,
    /// Frames since the picture last changed in any way, and since its light did.
    rested: u32,
    even: u32,
    row: u64,
    /// Whether the last frame showed no indirect light.
    is_idle: bool,
    /// Written in turns: this frame's, and that of the frame before.
    targets: Option<[Target; 2]>,
}

/// What a frame was made of.
#[derive(Clone, Copy, PartialEq)]
struct Seen {
    /// What must be the same for two frames to have anything to do with each other.
    subject: u64,
    /// Anything that light depends on.
    light: u64,
    clip_from_world: Mat4,
    world_from_clip: Mat4,
}

pub(crate) struct Target {
    /// What a white surface reflects [W/(m² sr)], and how many frames are in it.
    pub light: wgpu::TextureView,
    /// Bits of the depth, and the normal.
    pub surface: wgpu::TextureView,
}

impl History {
    /// Begins a frame whose light is averaged with that of the frames before.
    pub fn begin(&mut self, gpu: &Gpu, scene: &Scene, view: &SceneView, settings: &RenderSettings) {
        self.is_idle = false;
        let seen = Seen::new(scene, view, settings, gpu.shaders.revision());
        let before = self.last.filter(|last| last.subject == seen.subject).zip(self.step);
        let Some((last, step)) = before.filter(|_| self.targets.is_some()) else {
            self.targets = Some([(); 2].map(|()| Target::new(gpu, view.size)));
            self.start(seen);
            return;
        };
        let is_still = last.clip_from_world == seen.clip_from_world;
        self.even = if last.light == seen.light { self.even.saturating_add(1) } else { 0 };
        self.rested = if is_still && self.even > 0 { self.rested.saturating_add(1) } else { 0 };
        if self.is_at_rest() {
            return;
        }
        let most = if self.even < UNREST { MOST_WHILE_CHANGING } else { (MOST_FRAMES - 1) as f32 };
        self.step = Some(Step {
            number: step.number.wrapping_add(1),
            row: self.row,
            rested: self.rested,
            most,
            most_glossy: if is_still { most } else { MOST_WHILE_CHANGING },
            is_still,
            clip_from_world_before: last.clip_from_world,
            world_from_clip_before: last.world_from_clip,
        });
        self.last = Some(seen);
    }

    /// Takes note of a frame that shows no indirect light: those that do go on after it.
    pub fn skip(&mut self) {
        self.is_idle = true;
    }

    /// What the frame that was begun does; none: it is not averaged.
    pub fn step(&self) -> Option<Step> {
        self.step
    }

    /// Where its light and that of the frame before are kept, in turns.
    pub fn targets(&self) -> Option<&[Target; 2]> {
        self.targets.as_ref()
    }

    /// Whether more frames would make the picture better.
    pub fn is_settling(&self) -> bool {
        self.step.is_some() && !self.is_idle && !self.is_at_rest()
    }

    /// Forgets all frames, after one that is not averaged or has failed.
    pub fn forget(&mut self) {
        *self = Self { row: self.row, ..Self::default() };
    }

    fn start(&mut self, seen: Seen) {
        self.row += 1;
        (self.rested, self.even) = (0, UNREST);
        self.step = Some(Step {
            number: 0,
            row: self.row,
            rested: 0,
            most: 0.0,
            most_glossy: 0.0,
            is_still: false,
            clip_from_world_before: seen.clip_from_world,
            world_from_clip_before: seen.world_from_clip,
        });
        self.last = Some(seen);
    }

    fn is_at_rest(&self) -> bool {
        self.rested >= MOST_FRAMES + UNREST
    }
}

impl Seen {
    fn new(scene: &Scene, view: &SceneView, settings: &RenderSettings, shaders: u64) -> Self {
        let hash = |value: &dyn Fn(&mut DefaultHasher)| {
            let mut hasher = DefaultHasher::new();
            value(&mut hasher);
            hasher.finish()
        };
        let revisions = scene.revisions;
        let methods = format!("{:?} {:?} {:?}", scene.clpv, scene.vpl, scene.slc);
        // Where the origin moves, places of before mean nothing.
        let origin = scene.origin.to_array().map(f64::to_bits);
        let subject = (scene.identity, origin, view.size, settings.gi, settings.virtual_light, shaders);
        let light = (revisions.geometry, revisions.materials, revisions.lights, revisions.settings, methods);
        Self {
            subject: hash(&|hasher| subject.hash(hasher)),
            light: hash(&|hasher| light.hash(hasher)),
            clip_from_world: view.clip_from_world(),
            world_from_clip: view.world_from_clip(),
        }
    }
}

impl Target {
    fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Self {
        let make = |label, format| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        Self {
            light: make("light of earlier frames", wgpu::TextureFormat::Rgba32Float),
            surface: make("surfaces of earlier frames", wgpu::TextureFormat::Rg32Uint),
        }
    }
}
