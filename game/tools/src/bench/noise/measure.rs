//! The measurements of a scene.

use super::change::{Change, PLAYED};
use super::converged::{self, Converged};
use super::figures::{JumpFigures, LayerNoise, Row, SceneFigures};
use super::measures::{Jumps, Screen, error_and_noise, noise};
use super::{Course, pictures};
use crate::bench::reference::{References, Wanted};
use crate::bench::rooms::near_edges;
use crate::bench::variant::Variant;
use crate::capture;
use anyhow::{Context, Result};
use lightwell::gpu::Gpu;
use lightwell::measure::{Image, compare};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, Switch};
use lightwell_runtime::session::Session;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Qualities whose single images are measured.
const QUALITIES: [&str; 4] = ["Low", "Medium", "High", "Ultra"];
/// The quality whose images everything is measured against.
const TRUTH: &str = "High";
/// Frames after a sudden change that are measured.
const AFTER: [u32; 3] = [1, 3, 8];
/// Frames of direct light that are averaged.
const DIRECT: u32 = 8;
/// Noise of the converged image over the least error that is taken with it.
const NOISE: f64 = 0.25;
/// Frames that the converged image begins with.
const FIRST_FRAMES: u32 = 64;

/// A scene on a device.
pub struct Subject {
    first: Session,
    camera: Option<String>,
}

/// An image that is measured, all light.
pub struct Shot {
    pub what: String,
    pub frame: u32,
    pub image: Image,
}

impl Subject {
    /// Loads a scene.
    ///
    /// # Errors
    /// If it cannot be loaded.
    pub fn open(gpu: &Arc<Gpu>, scene: &str, camera: Option<&str>, common: &Common) -> Result<Self> {
        let first = Session::open(gpu.clone(), scene, &Variant::path_tracing(1).look(camera), common)?;
        Ok(Self { first, camera: camera.map(str::to_owned) })
    }

    /// Name of the scene.
    pub fn name(&self) -> String {
        self.first.name()
    }

    /// The scene once more, in some quality or its own, each frame averaged with those before or alone.
    fn again(&self, quality: Option<&str>, average: Switch) -> Result<Session> {
        let sets = quality.map(|quality| ("clpv.quality".to_owned(), quality.to_owned()));
        let variant =
            Variant { average: Some(average), ..Variant::new("", GiMethod::CLPV, sets.into_iter().collect()) };
        let mut session = self.first.again(&variant.look(self.camera.as_deref()))?;
        session.set_ticks(PLAYED[1]);
        Ok(session)
    }
}

/// Frames of a window at rest that are measured: powers of two.
fn doubled(most: u32) -> Vec<u32> {
    (0..32).map(|power| 1 << power).take_while(|frame| *frame <= most).collect()
}

/// Measures all of a scene; `told` hears what is done next.
///
/// # Errors
/// If it cannot be drawn or traced, an image holds NaN, or a picture cannot be written.
pub fn measure(
    subject: &mut Subject,
    course: &Course,
    folder: &Path,
    told: &mut dyn FnMut(&str),
) -> Result<SceneFigures> {
    let begun = Instant::now();
    let mut shots = Vec::new();
    for quality in QUALITIES {
        told(&format!("one image of {quality}"));
        shots.push(single(subject, quality, course.size)?);
    }
    for (change, frames) in changes(subject, course)? {
        told(&format!("window, {}", change.in_words()));
        shots.extend(window(subject, &change, &frames, course)?);
    }
    told("blocks that jump");
    let (jumps, flat) = jumps(subject, course)?;
    told("converged image");
    let mut high = subject.again(Some(TRUTH), Switch::Off)?;
    let view = SceneView { camera: high.camera()?, size: course.size, jitter: [0.0; 2] };
    let near = near_edges(&mut high, course.size)?;
    let truth = truth(&mut high, &view, &shots, &near, course)?;
    told("path-traced reference");
    let traced = traced(subject, course)?;
    told("pictures");
    let rows = shots.iter().map(|shot| row(shot, &truth, &near, traced)).collect::<Result<Vec<_>>>()?;
    let files = pictures::write(folder, &subject.name(), &shots, &truth.total, &near)?;
    Ok(SceneFigures {
        name: subject.name(),
        course: course.in_words(),
        frames: truth.frames,
        noise: truth.noise,
        limited: truth.limited,
        near_edges: near.iter().filter(|near| **near).count() as f64 / near.len().max(1) as f64,
        bias: [truth.mean(Layer::Indirect) / traced[0] - 1.0, truth.mean(Layer::Total) / traced[1] - 1.0]
            .map(|bias| if bias.is_finite() { bias } else { 0.0 }),
        rows,
        jumps,
        flat,
        pictures: files,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

/// All changes that the scene has, with the frames after each that are measured.
fn changes(subject: &mut Subject, course: &Course) -> Result<Vec<(Change, Vec<u32>)>> {
    let session = &mut subject.first;
    let mut all = vec![(Change::Rest, doubled(course.rest)), (Change::play(session)?, vec![1])];
    let sudden = [Change::light(session), Change::object(session, course.size)?, Some(Change::Turn)];
    all.extend(sudden.into_iter().flatten().map(|change| (change, AFTER.to_vec())));
    session.set_ticks(PLAYED[1]);
    Ok(all)
}

fn single(subject: &Subject, quality: &str, size: [u32; 2]) -> Result<Shot> {
    let mut session = subject.again(Some(quality), Switch::Off)?;
    let settings = session.render_settings(false);
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    session.render(&view, &settings)?;
    Ok(Shot { what: format!("one image, `{quality}`"), frame: 1, image: session.radiance()? })
}

/// Frames of a window after a change. A frame after which the scene is in its last state is the first.
fn window(subject: &Subject, change: &Change, frames: &[u32], course: &Course) -> Result<Vec<Shot>> {
    let mut session = subject.again(None, Switch::On)?;
    let settings = session.render_settings(false);
    let lead = change.lead(course.lead);
    let last = frames.iter().copied().max().unwrap_or(0);
    let mut shots = Vec::new();
    for number in 0..lead + last {
        let camera = change.apply(&mut session, lead.saturating_sub(number))?;
        session.render(&SceneView { camera, size: course.size, jitter: [0.0; 2] }, &settings)?;
        let after = (number + 1).saturating_sub(lead);
        if frames.contains(&after) {
            // Of motion the number of all frames counts.
            let frame = if matches!(change, Change::Play { .. }) { number + 1 } else { after };
            let what = format!("window, {}", change.in_words());
            shots.push(Shot { what, frame, image: session.radiance()? });
        }
    }
    Ok(shots)
}

/// What everything is measured against.
struct Truth {
    total: [Image; 2],
    direct: Image,
    frames: u32,
    noise: f64,
    limited: bool,
}

impl Truth {
    fn halves(&self, layer: Layer) -> [Image; 2] {
        match layer {
            Layer::Indirect => self.total.each_ref().map(|half| less(half, &self.direct)),
            _ => self.total.clone(),
        }
    }

    fn mean(&self, layer: Layer) -> f64 {
        let [first, second] = self.halves(layer);
        0.5 * (first.mean() + second.mean())
    }
}

/// All light without the direct light.
fn less(total: &Image, direct: &Image) -> Image {
    let mut indirect = total.clone();
    for (pixel, direct) in indirect.pixels_mut().iter_mut().zip(direct.pixels()) {
        *pixel = [0, 1, 2].map(|c| pixel[c] - direct[c]);
    }
    indirect
}

/// Draws the converged image until its noise is small against every error away from edges, or the limit is reached.
fn truth(session: &mut Session, view: &SceneView, shots: &[Shot], near: &[bool], course: &Course) -> Result<Truth> {
    let direct = converged::direct(session, view, DIRECT)?;
    let away: Vec<bool> = near.iter().map(|near| !near).collect();
    let part = if away.contains(&true) { &away } else { near };
    let mut mean = Converged::new(course.size);
    let mut wanted = FIRST_FRAMES.min(course.most_frames);
    loop {
        mean.advance_to(wanted, session, view, &mut || ())?;
        let truth =
            Truth { total: mean.halves()?, direct: direct.clone(), frames: mean.frames, noise: 0.0, limited: false };
        let halves = truth.halves(Layer::Indirect);
        let (mut excess, mut own) = (0.0_f64, 0.0);
        for shot in shots {
            let [error, noise] = error_and_noise(&less(&shot.image, &direct), &halves, part);
            (excess, own) = (excess.max(noise / (NOISE * error.max(1e-4))), noise);
        }
        let limited = excess > 1.0 && mean.frames >= course.most_frames;
        if excess <= 1.0 || limited {
            return Ok(Truth { noise: own, limited, ..truth });
        }
        // Noise falls with the root of the frames; what it is now is uncertain.
        let more = (f64::from(mean.frames) * (1.1 * excess * excess).clamp(1.5, 4.0)).ceil() as u32;
        wanted = more.min(course.most_frames);
    }
}

/// Means of path-traced indirect and all light.
fn traced(subject: &mut Subject, course: &Course) -> Result<[f64; 2]> {
    let session = &mut subject.first;
    session.set_ticks(PLAYED[1]);
    let references = References { cache: course.cache.clone(), stored: None, bless: false };
    let (scene, rate) = (session.name(), session.settings().frame_rate);
    let time = PLAYED[1] as f64 / f64::from(rate.max(1));
    let wanted = Wanted { scene: &scene, time, size: course.size, bounces: None, samples: course.samples };
    let found = references.get(session, &wanted, &mut |_| {})?;
    Ok([found.estimate.indirect().mean(), found.estimate.total().mean()])
}

fn row(shot: &Shot, truth: &Truth, near: &[bool], traced: [f64; 2]) -> Result<Row> {
    let context = || format!("{}, frame {}", shot.what, shot.frame);
    let layer = |image: &Image, layer, traced: f64| -> Result<LayerNoise> {
        let halves = truth.halves(layer);
        let found = compare(image, &crate::bench::error::mean(&halves)).with_context(context)?;
        let away: Vec<bool> = near.iter().map(|near| !near).collect();
        Ok(LayerNoise {
            edges: noise(image, &halves, near),
            elsewhere: noise(image, &halves, &away),
            shift: found.bias,
            bias: if traced > 0.0 { image.mean() / traced - 1.0 } else { 0.0 },
            flip: found.flip,
        })
    };
    Ok(Row {
        what: shot.what.clone(),
        frame: shot.frame,
        indirect: layer(&less(&shot.image, &truth.direct), Layer::Indirect, traced[0])?,
        total: layer(&shot.image, Layer::Total, traced[1])?,
    })
}

/// Blocks that jump from frame to frame as the scene plays, with averaging, without, and in the converged picture; and what the
/// last frame without averaging differs by from its average in flat parts \[255ths\].
fn jumps(subject: &mut Subject, course: &Course) -> Result<(Vec<JumpFigures>, Option<f64>)> {
    let change = Change::play(&mut subject.first)?;
    let mut all = Vec::new();
    let mut flat = None;
    for (what, quality, average, images) in [
        ("averaged", None, Switch::On, 1),
        ("single images", None, Switch::Off, 1),
        ("converged", Some(TRUTH), Switch::Off, course.images),
    ] {
        let mut session = subject.again(quality, average)?;
        let mut jumps = Jumps::default();
        let mut before: Option<Screen> = None;
        let frames = course.played.min(change.lead(0));
        for left in (0..=frames).rev() {
            let camera = change.apply(&mut session, left)?;
            let now = Screen::new(&displayed(&mut session, &camera, course.size, images)?);
            if let Some(before) = &before {
                jumps.add(before, &now);
            }
            before = Some(now);
        }
        if let (Some(first), None, Switch::Off) = (&before, quality, average) {
            let settings = RenderSettings { mlaa: false, ..session.display_settings() };
            let mean = capture::take(&mut session, course.size, course.images, &settings)?;
            flat = first.flat_difference(&Screen::new(&mean));
        }
        all.push(JumpFigures { what: what.to_owned(), jumps });
    }
    Ok((all, flat))
}

/// What a screen shows: a frame as a window draws it, or a mean of images with shifted pixel grids.
fn displayed(
    session: &mut Session,
    camera: &lightwell::scene::SceneCamera,
    size: [u32; 2],
    images: u32,
) -> Result<Image> {
    let mut settings = session.display_settings();
    if images == 1 {
        session.render(&SceneView { camera: camera.clone(), size, jitter: [0.0; 2] }, &settings)?;
        return capture::display(session);
    }
    (settings.mlaa, settings.images) = (false, images);
    let mut sum = vec![[0.0_f64; 3]; (size[0] * size[1]) as usize];
    for index in 0..images {
        let view = SceneView { camera: camera.clone(), size, jitter: crate::jitter::shift(index, images) };
        session.render(&view, &settings)?;
        for (sum, value) in sum.as_flattened_mut().iter_mut().zip(capture::display(session)?.values()) {
            *sum += f64::from(value) / f64::from(images);
        }
    }
    let pixels = sum.iter().map(|pixel| pixel.map(|value| value as f32)).collect();
    Image::from_pixels(size[0], size[1], pixels).context("the image is incomplete")
}
