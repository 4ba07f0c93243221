//! The window's surface: sizes, loss, and putting images on it.

use anyhow::{Context, Result, bail};
use lightwell::gpu::{Gpu, GpuOptions, instance_descriptor};
use std::sync::Arc;
use wgpu::CurrentSurfaceTexture;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// How often a frame tries to give the surface its size.
const TRIES: u32 = 4;
/// Refusals in a row after which there must be another reason than a busy device.
const MANY: u32 = 2000;

/// The surface of a window.
pub struct Screen {
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    window: Arc<Window>,
    config: wgpu::SurfaceConfiguration,
    /// Whether the surface has taken the configuration, or how often it has refused it since.
    refused: u32,
    /// Format of the views: without sRGB conversion, since images are encoded already.
    view_format: wgpu::TextureFormat,
}

impl Screen {
    /// Opens the device for a window, and the window's surface.
    ///
    /// # Errors
    /// If no adapter can present on the window.
    pub fn open(event_loop: &ActiveEventLoop, window: Arc<Window>, options: &GpuOptions) -> Result<(Gpu, Self)> {
        let display = Box::new(event_loop.owned_display_handle());
        let instance =
            wgpu::Instance::new(instance_descriptor(wgpu::InstanceDescriptor::new_with_display_handle(display)));
        let surface = instance.create_surface(Arc::clone(&window)).context("the window has no drawing surface")?;
        let gpu = Gpu::for_window(options, &instance, &surface)?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .with_context(|| format!("adapter `{}` cannot draw on this window", gpu.info.name))?;
        let capabilities = surface.get_capabilities(&gpu.adapter);
        // For what was painted before: see `UiPainter::paint_window`.
        config.usage |= capabilities.usages & wgpu::TextureUsages::COPY_DST;
        let formats = capabilities.formats;
        if let Some(plain) =
            formats.iter().find(|f| !f.is_srgb() && f.remove_srgb_suffix().target_pixel_byte_cost() == Some(4))
        {
            config.format = *plain;
        }
        config.present_mode = wgpu::PresentMode::AutoVsync;
        let view_format = config.format.remove_srgb_suffix();
        if view_format != config.format {
            config.view_formats.push(view_format);
        }
        let mut screen = Self { instance, surface, window, config, refused: 0, view_format };
        screen.configure(&gpu);
        Ok((gpu, screen))
    }

    /// Format that is drawn in: holds sRGB-encoded values as they are.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.view_format
    }

    /// Size \[pixels\]; none while the window is minimised.
    pub fn size(&self) -> Option<[u32; 2]> {
        let size = self.window.inner_size();
        (size.width > 0 && size.height > 0).then_some([size.width, size.height])
    }

    /// Tells the surface of its size; false if it does not take it now. It does not while another thread hands work to
    /// the device, as that does which draws the picture.
    fn configure(&mut self, gpu: &Gpu) -> bool {
        for _ in 0..TRIES {
            let errors = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
            self.surface.configure(&gpu.device, &self.config);
            let Some(error) = pollster::block_on(errors.pop()) else {
                self.refused = 0;
                return true;
            };
            self.refused += 1;
            if self.refused == MANY {
                log::error!("the window cannot be drawn on: {error}");
            }
        }
        false
    }

    /// The next image of the window, to be drawn and presented. None if there is none just now, as while it is
    /// hidden: try again later.
    ///
    /// # Errors
    /// If the surface was lost and cannot be made anew.
    pub fn acquire(&mut self, gpu: &Gpu) -> Result<Option<wgpu::SurfaceTexture>> {
        let Some([width, height]) = self.size() else { return Ok(None) };
        let limit = gpu.limits.max_texture_dimension_2d;
        let size = [width.min(limit), height.min(limit)];
        if [self.config.width, self.config.height] != size || self.refused > 0 {
            [self.config.width, self.config.height] = size;
            if !self.configure(gpu) {
                return Ok(None);
            }
        }
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => {
                    return Ok(Some(texture));
                }
                CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(None),
                CurrentSurfaceTexture::Outdated => {
                    if !self.configure(gpu) {
                        return Ok(None);
                    }
                }
                CurrentSurfaceTexture::Lost => {
                    if let Some(reason) = gpu.device_lost() {
                        bail!("the graphics device was lost: {reason}");
                    }
                    let surface = self.instance.create_surface(Arc::clone(&self.window));
                    self.surface = surface.context("the window's drawing surface was lost")?;
                    if !self.configure(gpu) {
                        return Ok(None);
                    }
                }
                CurrentSurfaceTexture::Validation => return Ok(None),
            }
        }
        Ok(None)
    }

    /// A view of the window's image in [`Screen::format`].
    pub fn view(&self, texture: &wgpu::SurfaceTexture) -> wgpu::TextureView {
        let format = Some(self.view_format);
        texture.texture.create_view(&wgpu::TextureViewDescriptor { format, ..Default::default() })
    }
}
