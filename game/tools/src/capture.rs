//! Images of a loaded scene, averaged over shifted pixel grids.

use crate::jitter;
use anyhow::{Context, Result};
use lightwell::measure::{Image, srgb_decode};
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;

/// Draws the scene as it stands and gives the image: linear radiance, or the light that a screen would send out if
/// the settings ask for the display image. `aa` frames with shifted pixel grids are averaged.
///
/// # Errors
/// If there is no camera, or the scene cannot be drawn.
pub fn take(session: &mut Session, size: [u32; 2], aa: u32, settings: &RenderSettings) -> Result<Image> {
    take_telling(session, size, aa, settings, &mut || ())
}

/// As [`take`]; `drawn` is called after each frame.
///
/// # Errors
/// As [`take`].
pub fn take_telling(
    session: &mut Session,
    size: [u32; 2],
    aa: u32,
    settings: &RenderSettings,
    drawn: &mut dyn FnMut(),
) -> Result<Image> {
    let camera = session.camera()?;
    // Shifted images are averaged anyway, each by itself.
    let settings = &RenderSettings { average: settings.average && aa == 1, images: aa, ..settings.clone() };
    let mut sum = vec![[0.0f64; 3]; size[0] as usize * size[1] as usize];
    for index in 0..aa {
        let view = SceneView { camera: camera.clone(), size, jitter: jitter::shift(index, aa) };
        session.render(&view, settings)?;
        let image = if settings.display { display(session)? } else { session.radiance()? };
        for (total, value) in sum.as_flattened_mut().iter_mut().zip(image.values()) {
            *total += f64::from(value);
        }
        drawn();
    }
    let count = f64::from(aa);
    let pixels = sum.iter().map(|pixel| pixel.map(|value| (value / count) as f32)).collect();
    Image::from_pixels(size[0], size[1], pixels).context("the image is incomplete")
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
