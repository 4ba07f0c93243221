//! What all passes of one frame share: the scene, the view, and their keys.

use super::history::History;
use super::rays::RayScene;
use super::scene_gpu::GpuScene;
use super::scene_gpu::surfels::GpuSurfels;
use super::settings::RenderSettings;
use super::views::Views;
use crate::gpu::{Gpu, ShaderDef};
use crate::graph::{PassBindings, TextureDesc, Tracked};
use crate::scene::{Aabb, Frustum, ProbePoint, Scene, SceneView};
use encase::ShaderType;
use glam::{Mat4, UVec2, Vec4};

/// `View` of `lib/view.wgsl`.
#[derive(Clone, Copy, ShaderType)]
pub(crate) struct ViewUniform {
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    eye: Vec4,
    axis: Vec4,
    size: UVec2,
    pixel: f32,
    reach: f32,
}

/// Why a pass fails that casts rays.
const NO_RAYS: &str = "the scene is not ready for rays";

/// A result of a method that the next frame may go on with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Names of the passes that make it. If one is skipped, nothing is kept.
    pub passes: &'static [&'static str],
    /// The state that the result is of: equal numbers, equal layout and contents.
    pub state: [u64; 2],
}

/// Inputs of a frame. Cheap to clone into the closure of a pass.
#[derive(Clone)]
pub struct Frame<'a> {
    /// The scene's arrays.
    pub scene: &'a Scene,
    /// The same scene on the device.
    pub gpu_scene: &'a GpuScene,
    /// Its surfaces as surfels, where a method needs them.
    pub surfels: &'a GpuSurfels,
    /// The scene as rays see it, where a method casts any.
    pub rays: Option<&'a RayScene>,
    /// The same for the borders of shadows. Not where rays are there only to be shown.
    pub shadow_rays: Option<&'a RayScene>,
    /// Why there are none for the final gather, if there should be.
    pub refused_rays: Option<&'a str>,
    /// The view.
    pub view: &'a SceneView,
    /// The same view with another shift of the pixel grid, at whose pixels light is gathered: see
    /// [`RenderSettings::gathered_at`]. None: at those of `view`.
    pub gathered_at: Option<&'a SceneView>,
    /// Settings.
    pub settings: &'a RenderSettings,
    /// Bounds of all primitives.
    pub bounds: Aabb,
    /// Points whose indirect light is asked for.
    pub probes: &'a [ProbePoint],
    /// How the views of the last frame were drawn.
    pub views: &'a Views,
    /// What the method [kept](super::indirect::IndirectMethod::keeps) of the frame before, if this one may continue from it.
    pub kept: Option<Kept>,
    /// The frames before, whose light this one's is averaged with.
    pub(in crate::render) history: &'a History,
}

impl<'a> Frame<'a> {
    /// The frame that light is gathered in; none: this one.
    pub fn gathering(&self) -> Option<Self> {
        self.gathered_at.map(|view| Self { view, gathered_at: None, ..self.clone() })
    }

    /// An image of linear values for the pixels of the frame, rgba32float.
    pub fn image_desc(&self) -> TextureDesc {
        let [width, height] = self.view.size;
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage)
    }

    /// Of random numbers: other ones for each of the shifted images, and of the frames, that are averaged. Shaders hash
    /// it.
    pub fn seed(&self) -> u32 {
        let [x, y] = self.view.jitter.map(f32::to_bits);
        let number = self.number().map_or(0, |number| number.wrapping_mul(0x85eb_ca6b));
        x ^ y.rotate_left(16).wrapping_mul(0x9e37_79b9) ^ number
    }

    /// Of this frame among those that are averaged; none: it stands for itself.
    pub fn number(&self) -> Option<u32> {
        self.history.step().map(|step| step.number)
    }

    /// How many images there will be, or have been, in the mean that this frame is for.
    pub fn images(&self) -> u32 {
        self.history.step().map_or(self.settings.images.max(1), |step| 1 + step.rested)
    }

    /// Changes with anything that a drawn surface depends on.
    pub fn geometry_key(&self) -> (u64, u64, u64) {
        (self.scene.identity, self.scene.revisions.geometry, self.scene.revisions.materials)
    }

    /// Changes with any participating medium.
    pub fn media_key(&self) -> (u64, u64) {
        (self.scene.identity, self.scene.revisions.media)
    }

    /// Changes with the camera, the image size and the jitter; equal bits give equal keys.
    pub fn view_key(&self) -> ([u32; 16], [u32; 2]) {
        (self.view.clip_from_world().to_cols_array().map(f32::to_bits), self.view.size)
    }

    /// The view volume of the camera.
    pub fn frustum(&self) -> Frustum {
        Frustum::new(&self.view.clip_from_world())
    }

    /// A buffer with the view's matrices for the shaders.
    pub fn view_uniform(&self, gpu: &Gpu) -> wgpu::Buffer {
        gpu.uniform("view", &self.view_values())
    }

    /// Binds that to a pass.
    pub(super) fn bind_view(&self, pass: &mut PassBindings) {
        pass.uniform("view", &self.view_values());
    }

    /// Binds to a pass where the patches of surfels lie.
    pub(super) fn bind_patches(&self, pass: &mut PassBindings<'_, 'a>) {
        self.surfels.patches().bind(pass, &(self.geometry_key(), self.surfels.revision()));
    }

    /// Lets a pass cast rays that ask for surfaces and lights.
    pub(super) fn bind_rays(&self, pass: &mut PassBindings<'_, 'a>) {
        match self.rays {
            Some(rays) => rays.bind_all(pass),
            None => pass.refuse(NO_RAYS),
        }
    }

    /// Lets a pass cast rays that ask for surfaces alone.
    pub(super) fn bind_ray_surfaces(&self, pass: &mut PassBindings<'_, 'a>) {
        match self.rays {
            Some(rays) => rays.bind_surfaces(pass),
            None => pass.refuse(NO_RAYS),
        }
    }

    /// Binds the sky by direction to a pass, or lets it know that the sky is even.
    pub(super) fn bind_sky(&self, pass: &mut PassBindings<'_, 'a>) {
        match &self.scene.sky_map {
            Some(map) => pass.tracked("sky", Tracked::texture(self.gpu_scene.sky(), &map.id)),
            None => pass.flag("EVEN_SKY", true),
        }
    }

    /// Binds to a pass where objects that moved stood in the frame before.
    pub(super) fn bind_motions(&self, pass: &mut PassBindings<'_, 'a>) {
        let Some((step, moved)) = self.history.step().zip(self.history.motions().buffer()) else { return };
        pass.define("MOVED", ShaderDef::Flag(true));
        pass.tracked("moved", Tracked::buffer(moved, &step.key()));
    }

    /// The contents of that buffer.
    pub(super) fn view_values(&self) -> ViewUniform {
        ViewUniform {
            clip_from_world: self.view.clip_from_world(),
            world_from_clip: self.view.world_from_clip(),
            eye: self.view.eye_point(),
            axis: self.view.axis(),
            size: self.view.size.into(),
            pixel: self.view.pixel_width(),
            reach: self.reach(),
        }
    }

    /// Distance from the eye to the farthest corner of the scene's bounds, rounded up to a power of two so that it rarely
    /// changes \[m\].
    fn reach(&self) -> f32 {
        let eye = self.view.eye();
        let farthest = self.bounds.corners().iter().map(|corner| corner.distance(eye)).fold(0.0, f32::max);
        let reach = farthest.log2().ceil().exp2();
        if reach.is_finite() { reach } else { 0.0 }
    }
}

/// Workgroups of 64 threads for that many items, spread over two dimensions where one would be over the limit.
pub(in crate::render) fn linear_groups(items: u32) -> [u32; 3] {
    let groups = items.div_ceil(64).max(1);
    let x = groups.min(32_768);
    [x, groups.div_ceil(x), 1]
}
