//! The path tracer on the device: progressive, seeded, and the same bits whatever the pieces it is traced in.

use super::content::traced_view;
use super::{Estimate, TraceSettings};
use crate::gpu::{self, Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc, record_dispatch};
use crate::measure::Image;
use crate::render::error::RenderError;
use crate::render::rays::{RayError, RayScene};
use crate::render::scene_gpu::sky::GpuSky;
use crate::render::settings::{Layer, ReferenceSettings};
use crate::scene::{Scene, SceneView};
use encase::ShaderType;
use glam::{UVec2, Vec2, Vec3};
use std::time::{Duration, Instant};

/// Time that one submit may take: a second may cost the device on desktop drivers.
const SUBMIT_TIME: Duration = Duration::from_millis(200);
/// Samples of a pixel that one dispatch traces at most; enough for threads to start new paths while others go on.
const SAMPLES_A_DISPATCH: u32 = 16;
/// The same on software drivers: lavapipe ends all loops of a thread after 65,535 turns together, without a word, and 16
/// paths among many turned objects came out 30 % too dark.
const SAMPLES_A_DISPATCH_ON_SOFTWARE: u32 = 1;

/// Why a scene cannot be traced.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The scene does not fit the device.
    #[error(transparent)]
    Scene(#[from] RayError),
    /// A shader does not compile, or the device refused something.
    #[error(transparent)]
    Pass(#[from] PassError),
    /// The image is larger than a buffer for its sums can be.
    #[error("an image of {width}x{height} pixels needs {needed} MiB for its sums, and this adapter binds {limit} MiB")]
    Size {
        /// Width \[pixels\].
        width: u32,
        /// Height \[pixels\].
        height: u32,
        /// Needed \[MiB\].
        needed: u64,
        /// Possible \[MiB\].
        limit: u64,
    },
    /// The sums could not be read back.
    #[error("the traced image could not be read back: {0}")]
    Read(String),
    /// Nothing was begun.
    #[error("nothing was traced yet")]
    Nothing,
}

impl From<TraceError> for RenderError {
    fn from(error: TraceError) -> Self {
        Self::Method { what: format!("path tracing: {error}"), source: Some(Box::new(error)) }
    }
}

/// `Trace` of `indirect/path_tracer/path_trace.wgsl`.
#[derive(Clone, ShaderType)]
pub(crate) struct TraceUniform {
    eye: Vec3,
    near: f32,
    right: Vec3,
    far: f32,
    up: Vec3,
    bounces: u32,
    forward: Vec3,
    seed: u32,
    sky: Vec3,
    root: u32,
    sun_toward: Vec3,
    sun_cosine: f32,
    sun_radiance: Vec3,
    size: UVec2,
    jitter: Vec2,
    first_row: u32,
    first_sample: u32,
    samples: u32,
    light_count: u32,
    emitter_count: u32,
    sky_turn: f32,
    lens_radius: f32,
    inverse_focus: f32,
}

/// `Resolve` of `indirect/path_tracer/resolve.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ResolveUniform {
    size: UVec2,
    even: u32,
    odd: u32,
    layer: u32,
}

/// What an image depends on; tracing goes on as long as it stays the same.
#[derive(Clone, Debug, PartialEq)]
struct Subject {
    scene: [u64; 6],
    view: SceneView,
    settings: TraceSettings,
    shaders: u64,
}

/// An image on its way.
pub(super) struct Progress {
    subject: Subject,
    uniform: TraceUniform,
    pub(super) sums: wgpu::Buffer,
    pub(super) samples: u32,
}

/// Traces one image at a time, progressively. See the [module](super).
pub struct PathTracer {
    scene: RayScene,
    sky: GpuSky,
    pub(super) progress: Option<Progress>,
    /// Measured so far, for the size of the pieces.
    paths_a_second: f64,
}

/// Rows and samples of one dispatch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    first_row: u32,
    rows: u32,
    first_sample: u32,
    samples: u32,
}

impl PathTracer {
    /// A tracer with nothing traced yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self { scene: RayScene::new(gpu), sky: GpuSky::new(gpu), progress: None, paths_a_second: 2e5 }
    }

    /// Takes up an image of the scene. If it is the one that is being traced, its samples are kept.
    ///
    /// # Errors
    /// If the scene or the image do not fit the device.
    pub fn begin(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        view: &SceneView,
        settings: &TraceSettings,
    ) -> Result<(), TraceError> {
        let r = &scene.revisions;
        let subject = Subject {
            scene: [scene.identity, r.geometry, r.materials, r.lights, r.settings, r.media],
            view: traced_view(view),
            settings: *settings,
            shaders: gpu.shaders.revision(),
        };
        if self.progress.as_ref().is_some_and(|progress| progress.subject == subject) {
            return Ok(());
        }
        let old = self.progress.take();
        self.scene.update(gpu, scene)?;
        self.sky.update(gpu, scene);
        let [width, height] = view.size;
        let bytes = 64 * u64::from(width) * u64::from(height);
        let limit = gpu.limits.max_storage_buffer_binding_size;
        if bytes > limit {
            return Err(TraceError::Size { width, height, needed: bytes.div_ceil(1 << 20), limit: limit >> 20 });
        }
        let sums = match old.map(|old| old.sums).filter(|sums| sums.size() == bytes) {
            Some(sums) => sums,
            None => gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("traced sums"),
                size: bytes.max(64),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        };
        let uniform = self.uniform(scene, view, settings);
        self.progress = Some(Progress { subject, uniform, sums, samples: 0 });
        Ok(())
    }

    /// Forgets what was traced.
    pub fn restart(&mut self) {
        self.progress = None;
    }

    /// Samples a pixel so far.
    pub fn samples(&self) -> u32 {
        self.progress.as_ref().map_or(0, |progress| progress.samples)
    }

    /// The scene as rays see it.
    pub fn scene(&self) -> &RayScene {
        &self.scene
    }

    /// Traces so many more samples a pixel, and waits for them.
    ///
    /// # Errors
    /// If nothing was begun, or a shader does not compile.
    pub fn advance(&mut self, gpu: &Gpu, samples: u32) -> Result<(), TraceError> {
        let new_encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut encoder = new_encoder();
        self.trace(gpu, samples, &mut |tracer, piece| {
            tracer.record(gpu, &mut encoder, piece)?;
            gpu.submit(Some(std::mem::replace(&mut encoder, new_encoder())));
            Ok(())
        })
    }

    /// Cuts the work into pieces that keep to [`SUBMIT_TIME`], and has each recorded and submitted.
    fn trace(
        &mut self,
        gpu: &Gpu,
        samples: u32,
        submit: &mut impl FnMut(&Self, Piece) -> Result<(), TraceError>,
    ) -> Result<(), TraceError> {
        let progress = self.progress.as_ref().ok_or(TraceError::Nothing)?;
        let [width, height] = progress.subject.view.size;
        let end = progress.samples.saturating_add(samples);
        let at_once = if gpu.is_software() { SAMPLES_A_DISPATCH_ON_SOFTWARE } else { SAMPLES_A_DISPATCH };
        while self.samples() < end {
            let first_sample = self.samples();
            let samples = (end - first_sample).min(at_once);
            let mut row = 0;
            while row < height {
                let paths_a_row = f64::from(width) * f64::from(samples);
                let rows = self.paths_a_second * SUBMIT_TIME.as_secs_f64() / paths_a_row;
                // Whole workgroups, eight rows high.
                let rows = ((rows / 8.0).clamp(1.0, 1e4) as u32 * 8).min(height - row);
                let start = Instant::now();
                submit(self, Piece { first_row: row, rows, first_sample, samples })?;
                gpu.wait();
                let rate = paths_a_row * f64::from(rows) / start.elapsed().as_secs_f64().max(1e-6);
                // Slowly up, quickly down: the next rows may see something harder.
                self.paths_a_second = rate.min(2.0 * self.paths_a_second);
                row += rows;
            }
            if let Some(progress) = &mut self.progress {
                progress.samples += samples;
            }
        }
        Ok(())
    }

    fn uniform(&self, scene: &Scene, view: &SceneView, settings: &TraceSettings) -> TraceUniform {
        let camera = &view.camera;
        let axes = camera.world_from_view.matrix3;
        let [width, height] = view.size.map(|size| size.max(1) as f32);
        let half_height = camera.half_height();
        TraceUniform {
            eye: view.eye(),
            near: camera.near,
            right: Vec3::from(axes.x_axis) * (half_height * width / height),
            far: camera.far_plane().unwrap_or(3e38),
            up: Vec3::from(axes.y_axis) * half_height,
            bounces: settings.bounces.unwrap_or(u32::MAX),
            forward: -Vec3::from(axes.z_axis),
            seed: settings.seed,
            sky: scene.sky,
            root: self.scene.root(),
            sun_toward: scene.sun_disc.map_or(Vec3::ZERO, |sun| sun.toward),
            sun_cosine: scene.sun_disc.map_or(2.0, |sun| sun.half_angle.cos()),
            sun_radiance: scene.sun_disc.map_or(Vec3::ZERO, |sun| sun.radiance),
            size: view.size.into(),
            jitter: view.jitter.into(),
            first_row: 0,
            first_sample: 0,
            samples: 0,
            light_count: self.scene.light_count,
            emitter_count: self.scene.emitter_count,
            sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
            lens_radius: camera.lens_radius().unwrap_or(0.0),
            inverse_focus: camera.lens.depth_of_field.map_or(0.0, |lens| lens.focus.recip()),
        }
    }

    fn record(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, piece: Piece) -> Result<(), TraceError> {
        let progress = self.progress.as_ref().ok_or(TraceError::Nothing)?;
        if piece.first_sample == 0 && piece.first_row == 0 {
            encoder.clear_buffer(&progress.sums, 0, None);
        }
        let Piece { first_row, rows, first_sample, samples } = piece;
        let uniform =
            gpu.uniform("trace", &TraceUniform { first_row, first_sample, samples, ..progress.uniform.clone() });
        let mut group = vec![("params", Binding::Buffer(&uniform)), ("sums", Binding::Buffer(&progress.sums))];
        let mut key = self.scene.shader("indirect/path_tracer/path_trace.wgsl", "main");
        if self.scene.has_glass() {
            key = key.def("GLASS_REFLECTS", ShaderDef::Flag(true));
        }
        if progress.subject.view.camera.is_orthographic() {
            key = key.def("ORTHOGRAPHIC", ShaderDef::Flag(true));
        }
        if progress.subject.view.camera.lens_radius().is_some() {
            key = key.def("THIN_LENS", ShaderDef::Flag(true));
        }
        if self.sky.is_map() {
            group.push(("sky", Binding::Texture(self.sky.view())));
        } else {
            key = key.def("EVEN_SKY", ShaderDef::Flag(true));
        }
        let groups = [progress.uniform.size.x.div_ceil(8), rows.div_ceil(8), 1];
        record_dispatch(gpu, encoder, &key, &group, Some(&|gpu, pipeline| self.scene.bind(gpu, pipeline)), groups)?;
        Ok(())
    }

    /// What was traced so far.
    ///
    /// # Errors
    /// If nothing was traced, or the device fails.
    pub fn estimate(&self, gpu: &Gpu) -> Result<Estimate, TraceError> {
        let progress = self.progress.as_ref().filter(|progress| progress.samples > 0).ok_or(TraceError::Nothing)?;
        let sums: Vec<[[f32; 4]; 4]> =
            gpu::read_buffer(gpu, &progress.sums).map_err(|error| TraceError::Read(error.to_string()))?;
        let [width, height] = progress.subject.view.size;
        let counts = [progress.samples.div_ceil(2), progress.samples / 2];
        let image = |half: usize, part: usize| {
            // The odd half of a single sample is the even one: two equal halves, whose noise is unknown.
            let half = if counts[half] == 0 { 0 } else { half };
            let count = f64::from(counts[half]);
            let mean = |pixel: &[[f32; 4]; 4]| {
                let [r, g, b, _] = pixel[2 * half + part];
                [r, g, b].map(|value| (f64::from(value) / count) as f32)
            };
            Image::from_pixels(width, height, sums.iter().map(mean).collect())
        };
        let layer = |part: usize| Some([image(0, part)?, image(1, part)?]);
        let incomplete = || TraceError::Read("it came back incomplete".into());
        Ok(Estimate {
            direct: layer(0).ok_or_else(incomplete)?,
            indirect: layer(1).ok_or_else(incomplete)?,
            samples: progress.samples,
        })
    }
}

/// Declares the pass that goes on tracing and shows what there is as a retained image of that name. At most `a_frame` samples a
/// pixel are added, until there are `samples`.
pub(crate) fn declare<'a>(
    graph: &mut Graph<'a>,
    tracer: &'a mut PathTracer,
    name: &str,
    layer: Layer,
    settings: &ReferenceSettings,
) -> Handle<Texture> {
    let (samples, a_frame) = (settings.samples, settings.samples_a_frame);
    let (size, key) = tracer
        .progress
        .as_ref()
        .map_or(([1, 1], String::new()), |progress| (progress.subject.view.size, format!("{:?}", progress.subject)));
    let [width, height] = size;
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let radiance = graph.retained_texture(name, desc);
    let done = tracer.samples();
    let more = samples.max(1).saturating_sub(done).min(a_frame.max(1));
    // By hand: how much is traced before each submit follows from how long the one before took.
    let mut pass = graph.pass("reference");
    let radiance = pass.write(radiance);
    pass.key(&(key, done + more, layer_index(layer)));
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let mut record = |tracer: &PathTracer, piece: Piece| {
            tracer.record(gpu, cx.encoder(), piece)?;
            let counts = cx.counts();
            counts.dispatches += 1;
            counts.paths += u64::from(piece.rows) * u64::from(width) * u64::from(piece.samples);
            cx.submit();
            Ok(())
        };
        let traced = gpu.audit.unnoted(|| tracer.trace(gpu, more, &mut record));
        traced.map_err(|error| PassError::message(error.to_string()))?;
        resolve(cx, tracer, radiance, layer)
    });
    radiance
}

fn resolve(cx: &mut PassContext, tracer: &PathTracer, target: Handle<Texture>, layer: Layer) -> Result<(), PassError> {
    let Some(progress) = &tracer.progress else { return Ok(()) };
    let size = progress.uniform.size;
    let uniform = ResolveUniform {
        size,
        even: progress.samples.div_ceil(2),
        odd: progress.samples / 2,
        layer: layer_index(layer),
    };
    let (uniform, view) = (cx.gpu.uniform("resolve", &uniform), cx.view(target));
    cx.counts().texels += u64::from(size.x) * u64::from(size.y);
    cx.dispatch(
        &ComputeKey::new("indirect/path_tracer/resolve.wgsl", "main"),
        &[
            ("params", Binding::Buffer(&uniform)),
            ("sums", Binding::Buffer(&progress.sums)),
            ("radiance", Binding::Texture(&view)),
        ],
        [size.x.div_ceil(8), size.y.div_ceil(8), 1],
    )
}

/// The constants of `indirect/path_tracer/resolve.wgsl`.
fn layer_index(layer: Layer) -> u32 {
    match layer {
        Layer::Direct => 1,
        Layer::Indirect => 2,
        _ => 0,
    }
}
