//! Loads scenes and draws them without a window, for the headless scene tests.

use lightwell::assets::AssetLibrary;
use lightwell::files::{LoadOptions, load_scene};
use lightwell::gpu::{Gpu, GpuOptions, default_shader_dir, read_texture_f32};
use lightwell::graph::FrameReport;
use lightwell::measure::Image;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings};
use lightwell::render::{RenderSettings, Renderer};
use lightwell::scene::{Extractor, Scene, SceneCamera, SceneView};
use lightwell::world::GameWorld;
use std::path::{Path, PathBuf};

/// Root of the source tree.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A folder named by an environment variable. Tests that ask for it say `#[needs("THE_VARIABLE")]` and fail without it.
pub fn folder_from_env(variable: &str) -> PathBuf {
    std::env::var_os(variable).map(PathBuf::from).unwrap_or_else(|| panic!("{variable} is not set"))
}

/// A loaded scene with its renderer.
pub struct Stage {
    gpu: Gpu,
    world: GameWorld,
    extractor: Extractor,
    /// The scene as the renderer sees it.
    pub scene: Scene,
    renderer: Renderer,
    size: [u32; 2],
}

impl Stage {
    /// Loads a scene file or a model; panics with the loader's message if that fails.
    pub fn open(path: &Path, models: Option<PathBuf>, size: [u32; 2]) -> Self {
        let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("the shader folder") };
        let gpu = Gpu::headless(&options).unwrap_or_else(|error| panic!("{error}"));
        let mut library = AssetLibrary::new();
        let world = load_scene(path, &mut library, &LoadOptions { models, ..Default::default() })
            .unwrap_or_else(|error| panic!("{error}"));
        let renderer = Renderer::new(&gpu);
        let mut stage = Self { gpu, world, extractor: Extractor::new(), scene: Scene::default(), renderer, size };
        stage.set_seconds(0.0);
        stage
    }

    /// Moves everything to where it is at that time.
    pub fn set_seconds(&mut self, seconds: f64) {
        self.world.set_seconds(seconds);
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
    }

    /// The scene's own camera.
    pub fn camera(&self) -> SceneCamera {
        let cameras = &self.scene.cameras;
        cameras.iter().find(|camera| camera.primary).or(cameras.first()).expect("a camera").clone()
    }

    /// Draws a frame; the pixel grid is shifted by `jitter`.
    pub fn draw(&mut self, settings: &RenderSettings, jitter: [f32; 2]) -> FrameReport {
        let view = SceneView { camera: self.camera(), size: self.size, jitter };
        self.renderer.render(&self.gpu, &self.scene, &view, settings).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Path-traces the view, with so many samples a pixel.
    pub fn trace(&self, settings: &TraceSettings, samples: u32) -> Estimate {
        let view = SceneView { camera: self.camera(), size: self.size, jitter: [0.0; 2] };
        let mut tracer = PathTracer::new(&self.gpu);
        tracer.begin(&self.gpu, &self.scene, &view, settings).unwrap_or_else(|error| panic!("{error}"));
        tracer.advance(&self.gpu, samples).unwrap_or_else(|error| panic!("{error}"));
        tracer.estimate(&self.gpu).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Linear radiance of the last frame.
    pub fn radiance(&self) -> Image {
        self.read(self.renderer.radiance())
    }

    /// The last frame as a display shows it, sRGB-encoded values of 0..1.
    pub fn display(&self) -> Image {
        self.read(self.renderer.display())
    }

    /// The renderer, with what it kept of the last frame.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Mean of the last channel of a retained texture.
    pub fn mean_alpha(&self, name: &str) -> f64 {
        let texture = self.renderer.target(name).expect("a retained texture");
        let pixels = read_texture_f32(&self.gpu, texture).expect("readable").rgba;
        pixels.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / pixels.len() as f64
    }

    fn read(&self, texture: Option<&wgpu::Texture>) -> Image {
        let pixels = read_texture_f32(&self.gpu, texture.expect("a frame")).expect("readable");
        let image = Image::from_rgba(pixels.width, pixels.height, &pixels.rgba).expect("all pixels");
        assert_eq!(image.first_non_finite(), None, "a pixel is not finite");
        image
    }

    /// Mean radiance over jittered frames: the box filter of a pixel, sampled by the Hammersley set.
    pub fn averaged(&mut self, settings: &RenderSettings, samples: u32) -> Image {
        let settings = &RenderSettings { images: samples, ..settings.clone() };
        let mut sum = Image::filled(self.size[0], self.size[1], [0.0; 3]);
        let half = 0.5 / samples as f32;
        for i in 0..samples {
            let (x, y) = (i as f32 / samples as f32, i.reverse_bits() as f32 / 2.0_f32.powi(32));
            self.draw(settings, [x + half - 0.5, y + half - 0.5]);
            for (sum, pixel) in sum.pixels_mut().iter_mut().zip(self.radiance().pixels()) {
                for (sum, value) in sum.iter_mut().zip(pixel) {
                    *sum += value / samples as f32;
                }
            }
        }
        sum
    }
}
