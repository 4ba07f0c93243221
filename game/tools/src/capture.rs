//! Images of a loaded scene, averaged over shifted pixel grids.

use crate::jitter;
use anyhow::{Context, Result};
use lightwell::measure::{Image, srgb_decode};
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;

/// Frames that an image is the mean of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Images whose light is gathered anew.
    pub images: u32,
    /// Shifts of the pixel grid at which each of them is drawn.
    pub edges: u32,
}

impl Sampling {
    /// So many images, of one frame each.
    pub const fn images(images: u32) -> Self {
        Self { images, edges: 1 }
    }

    /// Frames in all.
    pub const fn frames(self) -> u32 {
        self.images.saturating_mul(self.edges)
    }

    /// Shift of a frame's pixel grid, and of the one where its light is gathered, if that is shared. The shifts of an image
    /// fill the pixel as evenly as those of all.
    fn shifts(self, image: u32, edge: u32) -> ([f32; 2], Option<[f32; 2]>) {
        let own = jitter::shift(edge * self.images + image, self.frames());
        (own, (self.edges > 1).then(|| jitter::shift(image, self.images)))
    }
}

/// Draws the scene as it stands and gives the image: linear radiance, or the light that a screen would send out if
/// the settings ask for the display image. `aa` frames with shifted pixel grids are averaged.
///
/// # Errors
/// If there is no camera, or the scene cannot be drawn.
pub fn take(session: &mut Session, size: [u32; 2], aa: u32, settings: &RenderSettings) -> Result<Image> {
    take_telling(session, size, Sampling::images(aa), settings, &mut || ())
}

/// As [`take`]; `drawn` is called after each frame.
///
/// # Errors
/// As [`take`].
pub fn take_telling(
    session: &mut Session,
    size: [u32; 2],
    sampling: Sampling,
    settings: &RenderSettings,
    drawn: &mut dyn FnMut(),
) -> Result<Image> {
    let Sampling { images, edges } = sampling;
    let count = sampling.frames();
    // Shifted images are averaged anyway, each by itself.
    let mut settings = RenderSettings { average: settings.average && count == 1, images, ..settings.clone() };
    let mut sum = Sum::new(size);
    for (image, edge) in (0..images).flat_map(|image| (0..edges).map(move |edge| (image, edge))) {
        let jitter;
        (jitter, settings.gathered_at) = sampling.shifts(image, edge);
        sum.add(&frame(session, size, jitter, &settings)?);
        drawn();
    }
    sum.mean()
}

/// The mean over the frames of one image, of which the first one gathers the light: at each of those shifts.
///
/// # Errors
/// As [`take`].
pub fn take_at(session: &mut Session, size: [u32; 2], shifts: &[[f32; 2]], settings: &RenderSettings) -> Result<Image> {
    let gathered_at = shifts.first().copied().filter(|_| shifts.len() > 1);
    let settings = RenderSettings { gathered_at, ..settings.clone() };
    let mut sum = Sum::new(size);
    for &jitter in shifts {
        sum.add(&frame(session, size, jitter, &settings)?);
    }
    sum.mean()
}

fn frame(session: &mut Session, size: [u32; 2], jitter: [f32; 2], settings: &RenderSettings) -> Result<Image> {
    let view = SceneView { camera: session.camera()?, size, jitter };
    session.render(&view, settings)?;
    if settings.display { display(session) } else { session.radiance() }
}

/// Sum of frames.
struct Sum {
    size: [u32; 2],
    pixels: Vec<[f64; 3]>,
    frames: u32,
}

impl Sum {
    fn new(size: [u32; 2]) -> Self {
        Self { size, pixels: Vec::new(), frames: 0 }
    }

    fn add(&mut self, image: &Image) {
        // Only now is it known that the device can draw so large an image.
        self.pixels.resize(image.pixels().len(), [0.0; 3]);
        for (total, value) in self.pixels.as_flattened_mut().iter_mut().zip(image.values()) {
            *total += f64::from(value);
        }
        self.frames += 1;
    }

    fn mean(self) -> Result<Image> {
        let count = f64::from(self.frames);
        let pixels = self.pixels.iter().map(|pixel| pixel.map(|value| (value / count) as f32)).collect();
        Image::from_pixels(self.size[0], self.size[1], pixels).context("the image is incomplete")
    }
}

/// The last frame as a screen shows it, decoded to linear light of 0..1.
///
/// # Errors
/// If no display image was drawn or the device is lost.
pub fn display(session: &Session) -> Result<Image> {
    let ([width, height], bytes) = session.display_bytes()?;
    let light = |&[r, g, b]: &[u8; 3]| [r, g, b].map(|byte| srgb_decode(f32::from(byte) / 255.0));
    let pixels = bytes.as_chunks().0.iter().map(light).collect();
    Image::from_pixels(width, height, pixels).context("the display image is incomplete")
}
