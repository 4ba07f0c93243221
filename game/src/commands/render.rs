//! `lightwell render`: images of a scene in files.

use crate::cli::{Common, RenderArgs};
use crate::session::Session;
use crate::{jitter, progress};
use anyhow::{Context, Result};
use indicatif::ProgressBar;
use lightwell::measure::{self, Image, srgb_decode};
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use std::path::{Path, PathBuf};

/// Renders one image, or one for each frame.
///
/// # Errors
/// If the scene cannot be loaded or drawn, or a file cannot be written.
pub fn run(args: &RenderArgs, common: &Common) -> Result<()> {
    let mut session = Session::headless(&args.scene, &args.look, common)?;
    let shot = Shot { size: args.size, aa: args.aa, linear: extension_is(&args.output, "exr") };
    let Some(frames) = args.frames.clone() else {
        session.set_seconds(args.time.unwrap_or(0.0));
        let bar = progress::bar(u64::from(args.aa), "rendering");
        shot.write(&mut session, &args.output, &bar)?;
        bar.finish_and_clear();
        return Ok(());
    };
    let bar = progress::bar((frames.end - frames.start) * u64::from(args.aa), "rendering frames");
    for frame in frames {
        session.set_ticks(frame);
        shot.write(&mut session, &numbered(&args.output, frame), &bar)?;
    }
    bar.finish_and_clear();
    Ok(())
}

/// How an image is taken.
pub struct Shot {
    /// Size [pixels].
    pub size: [u32; 2],
    /// Number of frames that are averaged.
    pub aa: u32,
    /// Linear radiance instead of what a screen shows.
    pub linear: bool,
}

impl Shot {
    /// Draws the scene as it stands and writes the image, making its folder if need be.
    ///
    /// # Errors
    /// If the scene cannot be drawn or the file not be written.
    pub fn write(&self, session: &mut Session, path: &Path, bar: &ProgressBar) -> Result<()> {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let settings = session.render_settings(!self.linear);
        let camera = session.camera()?;
        let mut sum = vec![[0.0f64; 3]; self.size[0] as usize * self.size[1] as usize];
        for index in 0..self.aa {
            let view = SceneView { camera: camera.clone(), size: self.size, jitter: jitter::shift(index, self.aa) };
            session.render(&view, &settings)?;
            if self.aa == 1 && !self.linear {
                let (size, rgb) = session.display_bytes()?;
                bar.inc(1);
                return Ok(measure::write_png_rgb8(path, size, &rgb)?);
            }
            self.add(session, &settings, &mut sum)?;
            bar.inc(1);
        }
        let count = f64::from(self.aa);
        let pixels = sum.iter().map(|pixel| pixel.map(|value| (value / count) as f32)).collect();
        let image = Image::from_pixels(self.size[0], self.size[1], pixels).context("the image is incomplete")?;
        if let Some([x, y]) = image.first_non_finite() {
            log::warn!("{}: NaN or infinity in the image, first at column {x} of row {y}", path.display());
        }
        Ok(measure::write_image(path, &image)?)
    }

    /// Adds the frame in linear light: radiance, or the light that a screen would send out.
    fn add(&self, session: &Session, settings: &RenderSettings, sum: &mut [[f64; 3]]) -> Result<()> {
        if settings.display {
            let (_, rgb) = session.display_bytes()?;
            for (total, byte) in sum.as_flattened_mut().iter_mut().zip(rgb) {
                *total += f64::from(srgb_decode(f32::from(byte) / 255.0));
            }
            return Ok(());
        }
        let image = session.radiance()?;
        for (total, value) in sum.as_flattened_mut().iter_mut().zip(image.values()) {
            *total += f64::from(value);
        }
        Ok(())
    }
}

fn extension_is(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

/// The file of a frame: its number, of four digits or more, for `{}` in the name, else with `_` before the ending.
pub fn numbered(path: &Path, frame: u64) -> PathBuf {
    let number = format!("{frame:04}");
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = match (name.contains("{}"), name.rsplit_once('.')) {
        (true, _) => name.replace("{}", &number),
        (false, Some((stem, ending))) => format!("{stem}_{number}.{ending}"),
        (false, None) => format!("{name}_{number}"),
    };
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered() {
        assert_eq!(numbered(Path::new("a/b.png"), 7), Path::new("a/b_0007.png"));
        assert_eq!(numbered(Path::new("a/{}.png"), 12345), Path::new("a/12345.png"));
        assert_eq!(numbered(Path::new("x_{}_y.v2.exr"), 3), Path::new("x_0003_y.v2.exr"));
    }
}
