//! Temporal history: which earlier frames this one continues, and how much they count. Where light or objects move, older
//! frames count for little ([`MOST_WHILE_CHANGING`]), unless it is known how their light has changed.

use super::light_steps::LightSteps;
use super::motion::Motions;
use super::pixel_shift;
use super::scene_gpu::surfels::GpuSurfels;
use super::settings::RenderSettings;
use super::surfaces::Surfaces;
use crate::gpu::Gpu;
use crate::scene::{Scene, SceneView};
use crate::world::DepthOfField;
use glam::Mat4;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Frames of a view that rests that are averaged.
pub const MOST_FRAMES: u32 = 256;

/// How far the long mean may be from the quick one, in mean deviations of a frame, while light or objects change. The quick
/// mean takes 0.3 of each frame, so that 0.3/(2 − 0.3) of a frame's variance is left in it; a mean deviation is √(2/π) of a
/// standard one; and three standard deviations are noise: 3·√0.176·√(π/2).
const TOLERANCE: f32 = 1.6;
/// Frames before that count at most while light or objects change: in the mean 0.7ⁿ of the light of n frames ago is left,
/// 6 % after eight.
const MOST_WHILE_CHANGING: f32 = 7.0 / 3.0;
/// The same where the light of patches tells how it changes, so that frames count that were drawn in other light.
const MOST_WHILE_FOLLOWED: f32 = 24.0;
/// Of `PatchHistory` of `light_volumes/radiosity/change.wgsl`.
const PATCH_BYTES: u64 = 32;
/// For so many frames after a change.
const UNREST: u32 = 8;

/// How a frame uses those before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Frames since the first of them; other random numbers in each.
    pub number: u32,
    /// Distinguishes one row of frames from another.
    pub row: u64,
    /// Frames since the image last changed in any way.
    pub rested: u32,
    /// Frames before that count at most.
    pub most: f32,
    /// The same where it is known how the light of patches changed.
    pub most_followed: f32,
    /// The same of what mirrors.
    pub most_glossy: f32,
    /// Whether the camera is where it was.
    pub is_still: bool,
    /// How far the long mean may be from the quick one, in mean deviations of a frame.
    pub tolerance: f32,
    pub clip_from_world_before: Mat4,
    pub world_from_clip_before: Mat4,
    /// Shift of the pixel grid in pixels, each in −½..½: another one in each frame where the mean over frames smooths edges.
    pub jitter: [f32; 2],
    /// Clip from world space without that shift, now and in the frame before.
    pub unshifted: [Mat4; 2],
}

impl Step {
    /// Another one for each frame: the content of what is kept of the frames before.
    pub fn key(&self) -> (u64, u32) {
        (self.row, self.number)
    }
}

/// The light of the frames before, and what is known of the last.
#[derive(Default)]
pub(crate) struct History {
    step: Option<Step>,
    last: Option<Seen>,
    /// Frames since the image last changed in any way, and since its light did.
    rested: u32,
    even: u32,
    row: u64,
    /// Whether the last frame showed no indirect light.
    is_idle: bool,
    /// Written alternately: the image of this frame, and that of the frame before.
    targets: Option<[Target; 2]>,
    motions: Motions,
    lights: LightSteps,
    /// Irradiance of the patches of surfels of a layout [W/m²], and what of its changes was not followed.
    patches: Option<(u64, InTurns<wgpu::Buffer>)>,
    /// Radiance with smooth edges [W/(m² sr)], see `post/temporal_antialiasing.wgsl`.
    colors: Option<InTurns<wgpu::TextureView>>,
    /// Radiance that mirrors reflect [W/(m² sr)], see `indirect/mirror_average.wgsl`.
    mirrors: Option<InTurns<wgpu::TextureView>>,
    /// The same of second lobes.
    second_lobes: Option<InTurns<wgpu::TextureView>>,
}

/// A pair that frames write alternately: the one of this frame, and that of the frame before.
pub(crate) struct InTurns<T> {
    /// The frame that it is for.
    number: u32,
    is_known: bool,
    pair: [T; 2],
}

impl<T> InTurns<T> {
    fn new(number: u32, pair: [T; 2]) -> Self {
        Self { number, is_known: false, pair }
    }

    fn go_on(&mut self, number: u32) {
        if self.number != number {
            self.is_known = self.number.wrapping_add(1) == number;
            self.number = number;
        }
    }

    /// Whether the frame before has written it.
    pub fn is_known(&self) -> bool {
        self.is_known
    }

    /// Where this frame writes, and where the one before did.
    pub fn now_and_before(&self) -> [&T; 2] {
        let now = (self.number % 2) as usize;
        [&self.pair[now], &self.pair[1 - now]]
    }
}

/// The inputs of a frame.
#[derive(Clone, Copy, PartialEq)]
struct Seen {
    /// Equal in two frames that show the same subject: else nothing of the earlier one is of use.
    subject: u64,
    /// Anything that light depends on.
    light: u64,
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    /// Without the shift by part of a pixel.
    unshifted: Mat4,
    /// What the image is focused on.
    focus: Option<DepthOfField>,
}

pub(crate) struct Target {
    /// Radiance that a white surface reflects [W/(m² sr)]: rgba32uint, see `accumulate.wgsl`.
    pub light: wgpu::TextureView,
    /// Depth and normal, how much a frame's light deviates, and the number of frames in it.
    pub surface: wgpu::TextureView,
}

impl History {
    /// Begins a frame whose light is averaged with that of the frames before.
    pub fn begin(&mut self, gpu: &Gpu, scene: &Scene, view: &SceneView, settings: &RenderSettings) {
        self.is_idle = false;
        self.motions.update(gpu, scene);
        self.lights.update(&scene.lights);
        let subject = subject(scene, view, settings, gpu.shaders.revision());
        let before = self.last.filter(|last| last.subject == subject).zip(self.step);
        let before = before.filter(|_| self.targets.is_some());
        let is_smooth = pixel_shift::is_possible(settings, view);
        let number = before.map_or(0, |(_, step)| step.number.wrapping_add(1));
        let jitter = if is_smooth { pixel_shift::of_frame(number) } else { view.jitter };
        let seen = Seen::new(subject, scene, view, jitter);
        match before {
            Some((last, step)) => self.go_on(last, seen, step, jitter),
            None => {
                self.targets = Some([(); 2].map(|()| Target::new(gpu, view.size)));
                self.start(seen, jitter);
            }
        }
        if is_smooth {
            self.keep_colors(gpu, view.size);
        }
    }

    fn go_on(&mut self, last: Seen, seen: Seen, step: Step, jitter: [f32; 2]) {
        let is_still = last.unshifted == seen.unshifted && last.focus == seen.focus;
        self.even = if last.light == seen.light { self.even.saturating_add(1) } else { 0 };
        self.rested = if is_still && self.even > 0 { self.rested.saturating_add(1) } else { 0 };
        if self.is_at_rest() {
            return;
        }
        let is_changing = self.even < UNREST;
        let all = (MOST_FRAMES - 1) as f32;
        let most = if is_changing { MOST_WHILE_CHANGING } else { all };
        self.step = Some(Step {
            number: step.number.wrapping_add(1),
            row: self.row,
            rested: self.rested,
            most,
            most_followed: if is_changing { MOST_WHILE_FOLLOWED } else { all },
            most_glossy: if is_still { most } else { MOST_WHILE_CHANGING },
            is_still,
            tolerance: if is_changing { TOLERANCE } else { f32::MAX },
            clip_from_world_before: last.clip_from_world,
            world_from_clip_before: last.world_from_clip,
            jitter,
            unshifted: [seen.unshifted, last.unshifted],
        });
        self.last = Some(seen);
    }

    /// Takes note of a frame that shows no indirect light: those that do go on after it.
    pub fn skip(&mut self) {
        self.is_idle = true;
    }

    /// The use of history by the frame that was begun; none: it is not averaged.
    pub fn step(&self) -> Option<Step> {
        self.step
    }

    /// Where its light and that of the frame before are stored, alternately.
    pub fn targets(&self) -> Option<&[Target; 2]> {
        self.targets.as_ref()
    }

    /// Where objects that moved stood a frame ago.
    pub fn motions(&self) -> &Motions {
        &self.motions
    }

    /// Makes room for the light of the surfels' patches, if the frame is averaged.
    pub fn keep_patches(&mut self, gpu: &Gpu, surfels: &GpuSurfels) {
        let Some(number) = self.step.map(|step| step.number) else { return };
        match self.patches.as_mut().filter(|(layout, _)| *layout == surfels.layout()) {
            Some((_, known)) => known.go_on(number),
            None => {
                let size = PATCH_BYTES * u64::from(surfels.patch_count().max(1));
                let buffer = |()| {
                    gpu.create_buffer(&wgpu::BufferDescriptor {
                        label: Some("light of patches of earlier frames"),
                        size,
                        usage: wgpu::BufferUsages::STORAGE,
                        mapped_at_creation: false,
                    })
                };
                self.patches = Some((surfels.layout(), InTurns::new(number, [(); 2].map(buffer))));
            }
        }
    }

    /// The light of the patches; none: the frame is not averaged, or has none.
    pub fn patches(&self) -> Option<&InTurns<wgpu::Buffer>> {
        self.step.and(self.patches.as_ref()).map(|(_, patches)| patches)
    }

    /// Whether it is known how the light of patches changes: the frame before had the same ones.
    pub fn follows_patches(&self) -> bool {
        self.patches().is_some_and(InTurns::is_known)
    }

    fn keep_colors(&mut self, gpu: &Gpu, size: [u32; 2]) {
        let Some(number) = self.step.map(|step| step.number) else { return };
        keep(&mut self.colors, gpu, "smooth radiance of earlier frames", size, number);
    }

    /// Makes room for what mirrors among these surfaces show, if the frame is averaged.
    pub fn keep_mirrors(&mut self, gpu: &Gpu, size: [u32; 2], surfaces: Surfaces) {
        let Some(number) = self.step.map(|step| step.number) else { return };
        let kept = match surfaces {
            Surfaces::Nearest => &mut self.mirrors,
            Surfaces::SecondLobes => &mut self.second_lobes,
        };
        keep(kept, gpu, &surfaces.name("mirrored radiance of earlier frames"), size, number);
    }

    /// History of mirror reflections of these surfaces; none: the frame is not averaged, or has no mirrors.
    pub fn mirrors(&self, surfaces: Surfaces) -> Option<&InTurns<wgpu::TextureView>> {
        let kept = match surfaces {
            Surfaces::Nearest => &self.mirrors,
            Surfaces::SecondLobes => &self.second_lobes,
        };
        of_frame(kept, self.step?.number)
    }

    /// The radiance whose edges the mean over frames smooths; none: that is not wanted.
    pub fn colors(&self) -> Option<&InTurns<wgpu::TextureView>> {
        of_frame(&self.colors, self.step?.number)
    }

    /// Whether light may have changed lately in the frame that was begun, so that it is not the plain mean of all.
    pub fn is_changing(&self) -> bool {
        self.step.is_some_and(|step| step.tolerance < f32::MAX)
    }

    /// Whether a light has changed by much since the frame before, in a scene of that extent \[m\].
    pub fn has_light_jumped(&self, extent: f32) -> bool {
        self.lights.have_jumped(extent)
    }

    /// Whether more frames would make the image better.
    pub fn is_settling(&self) -> bool {
        self.step.is_some() && !self.is_idle && !self.is_at_rest()
    }

    /// How many frames a view that rests is averaged over so far.
    pub fn averaged(&self) -> Option<u32> {
        self.step.map(|step| (step.rested + 1).min(MOST_FRAMES))
    }

    /// Forgets all frames, after one that is not averaged or has failed.
    pub fn forget(&mut self) {
        *self = Self { row: self.row, ..Self::default() };
    }

    fn start(&mut self, seen: Seen, jitter: [f32; 2]) {
        self.row += 1;
        (self.patches, self.colors, self.mirrors, self.second_lobes) = (None, None, None, None);
        (self.rested, self.even) = (0, UNREST);
        self.step = Some(Step {
            number: 0,
            row: self.row,
            rested: 0,
            most: 0.0,
            most_followed: 0.0,
            most_glossy: 0.0,
            is_still: false,
            tolerance: f32::MAX,
            clip_from_world_before: seen.clip_from_world,
            world_from_clip_before: seen.world_from_clip,
            jitter,
            unshifted: [seen.unshifted; 2],
        });
        self.last = Some(seen);
    }

    fn is_at_rest(&self) -> bool {
        self.rested >= MOST_FRAMES + UNREST
    }
}

fn hash_of(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Equal in two frames that show the same subject: else nothing of the earlier one is of use.
fn subject(scene: &Scene, view: &SceneView, settings: &RenderSettings, shaders: u64) -> u64 {
    // Where the origin moves, places of before mean nothing.
    let origin = scene.origin.to_array().map(f64::to_bits);
    hash_of((scene.identity, origin, view.size, settings.gi, settings.virtual_light, shaders))
}

impl Seen {
    fn new(subject: u64, scene: &Scene, view: &SceneView, jitter: [f32; 2]) -> Self {
        let revisions = scene.revisions;
        let methods = format!("{:?} {:?} {:?} {}", scene.clpv, scene.vpl, scene.slc, revisions.methods);
        let shifted = SceneView { jitter, ..view.clone() };
        Self {
            subject,
            light: hash_of((
                [revisions.geometry, revisions.materials, revisions.lights, revisions.media, revisions.settings],
                methods,
            )),
            clip_from_world: shifted.clip_from_world(),
            world_from_clip: shifted.world_from_clip(),
            unshifted: view.clip_from_world(),
            focus: view.camera.lens.depth_of_field,
        }
    }
}

/// Takes the two images of earlier frames, or declares them.
fn keep(images: &mut Option<InTurns<wgpu::TextureView>>, gpu: &Gpu, label: &str, size: [u32; 2], number: u32) {
    match images {
        Some(known) => known.go_on(number),
        None => *images = Some(InTurns::new(number, [(); 2].map(|()| target(gpu, label, size)))),
    }
}

fn of_frame(images: &Option<InTurns<wgpu::TextureView>>, number: u32) -> Option<&InTurns<wgpu::TextureView>> {
    images.as_ref().filter(|images| images.number == number)
}

/// A texture of four whole numbers a pixel that passes write and later frames read.
fn target(gpu: &Gpu, label: &str, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

impl Target {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        Self {
            light: target(gpu, "light of earlier frames", size),
            surface: target(gpu, "surfaces of earlier frames", size),
        }
    }
}
