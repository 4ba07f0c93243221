//! The measurements of a change.

use super::cases::{Case, Room, State};
use super::figures::{CaseFigures, SameView, Sealed};
use super::{AFTER, Course};
use crate::bench::noise::{self, Converged, local_means, percentile};
use crate::bench::picture;
use crate::bench::variant::Variant;
use anyhow::{Context, Result};
use lightwell::gpu::Gpu;
use lightwell::measure::{Image, srgb_encode};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, Switch};
use lightwell_runtime::session::Session;
use std::path::Path;
use std::sync::Arc;

/// Error of means of 13×13, relative to the mean of the converged picture, that counts as near it.
const WITHIN: f64 = 0.05;
/// Share of the pixels that a residue bounds.
const MOST: f64 = 0.95;
const NEARLY_ALL: f64 = 0.99;
/// Change of a pixel from which on it counts as changed \[255ths\].
const CHANGED: f64 = 2.0;
/// Frames that the camera is elsewhere before it comes back.
const AWAY: u32 = 16;
/// Frames of the flight through a closed box.
const FLIGHT: u32 = 32;

/// Where rooms lie, and what draws them.
pub struct Rig<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// Options of the command line.
    pub common: &'a Common,
    /// Folder of the results.
    pub folder: &'a Path,
}

impl Rig<'_> {
    /// A session with a room, whose frames are averaged with those before or stand alone.
    fn open(&self, room: Room, average: Switch) -> Result<Session> {
        let rooms = self.folder.join("rooms");
        std::fs::create_dir_all(&rooms).with_context(|| format!("cannot make the folder {}", rooms.display()))?;
        let path = rooms.join(room.file());
        std::fs::write(&path, room.text()).with_context(|| format!("cannot write {}", path.display()))?;
        let variant = Variant { average: Some(average), ..Variant::new("", GiMethod::CLPV, Vec::new()) };
        Session::open(self.gpu.clone(), &path.to_string_lossy(), &variant.look(None), self.common)
    }

    /// Measures a change.
    ///
    /// # Errors
    /// If it cannot be drawn, or a picture not be written.
    pub fn case(&self, case: &Case, course: &Course) -> Result<CaseFigures> {
        let mut single = self.open(case.room, Switch::Off)?;
        // Direct light is right at once: what a window shows late is indirect light.
        let mut direct = |left| {
            let view = case.apply(&mut single, left, course.size)?;
            noise::direct(&mut single, &view, 1)
        };
        let [direct_before, direct] = [direct(1)?, direct(0)?];
        let truth = Light::of_total(self.converged(case, course)?, &direct);
        let rested = Light::of_indirect(self.rested(case, course)?, &direct);
        let mut session = self.open(case.room, Switch::On)?;
        let lead = case.lead.unwrap_or(course.lead);
        let mut frames = Vec::new();
        let mut before = None;
        for number in 0..lead + course.after {
            let left = lead.saturating_sub(number);
            let view = case.apply(&mut session, left, course.size)?;
            draw(&mut session, &view, Layer::Indirect)?;
            match left {
                0 => frames.push(Light::of_indirect(session.radiance()?, &direct)),
                1 => before = Some(Light::of_indirect(session.radiance()?, &direct_before)),
                _ => {}
            }
        }
        let before = before.context("nothing was drawn before the change")?;
        let figures = judge(case, &before, &frames, &truth, &rested);
        self.picture(case, &before, &frames, &truth)?;
        Ok(CaseFigures { course: course.in_words(), ..figures })
    }

    /// All light that single images of the last state converge to.
    fn converged(&self, case: &Case, course: &Course) -> Result<Image> {
        let mut session = self.open(case.room, Switch::Off)?;
        let view = case.apply(&mut session, 0, course.size)?;
        let mut mean = Converged::new(course.size);
        mean.advance_to(course.images, &mut session, &view, &mut || ())?;
        Ok(crate::bench::error::mean(&mean.halves()?))
    }

    /// Indirect light in a window that has stood in the last state for as many frames as the last one that is judged.
    fn rested(&self, case: &Case, course: &Course) -> Result<Image> {
        let mut session = self.open(case.room, Switch::On)?;
        for _ in 0..AFTER[AFTER.len() - 1] {
            let view = case.apply(&mut session, 0, course.size)?;
            draw(&mut session, &view, Layer::Indirect)?;
        }
        session.radiance()
    }

    fn picture(&self, case: &Case, before: &Light, frames: &[Light], truth: &Light) -> Result<()> {
        let after = AFTER.iter().filter_map(|&frame| Some((frames.get(frame as usize - 1)?, format!("frame {frame}"))));
        let all = std::iter::once((before, "before".to_owned())).chain(after).chain([(truth, "converged".to_owned())]);
        let images: Vec<(Image, String)> = all.map(|(light, text)| (light.total.clone(), text)).collect();
        let path = self.folder.join(case.picture());
        picture::row(&path, case.name, &images, exposure(before, truth))
    }

    /// The same view twice: a window that has looked elsewhere in between, and a single image.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn same_view(&self, course: &Course) -> Result<SameView> {
        let twice = |average| -> Result<[f64; 2]> {
            let mut session = self.open(Room::Plain, average)?;
            let away = &super::cases::CASES[0];
            let mut pictures = Vec::new();
            for stay in 0..2 {
                for frame in 0..if stay > 0 { AWAY } else { 0 } {
                    let mut view = away.apply(&mut session, 0, course.size)?;
                    view.camera = noise::turned(view.camera, 5.0 * (frame + 1) as f32);
                    draw(&mut session, &view, Layer::Total)?;
                }
                for _ in 0..course.lead {
                    let view = away.apply(&mut session, 0, course.size)?;
                    draw(&mut session, &view, Layer::Total)?;
                }
                pictures.push(session.radiance()?);
            }
            let exposure = picture::exposure(&pictures[0]);
            let changes = changes(&pictures[1], &pictures[0], exposure);
            Ok([percentile(changes.clone(), MOST), percentile(changes, 1.0)])
        };
        Ok(SameView { course: course.in_words(), window: twice(Switch::On)?, single: twice(Switch::Off)? })
    }

    /// The brightest value of a closed box in the sun while the camera flies through it.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn sealed(&self, course: &Course) -> Result<Sealed> {
        let brightest = |average| -> Result<[f64; 2]> {
            let mut session = self.open(Room::Sealed, average)?;
            let (mut radiance, mut shown) = (0.0_f64, 0.0_f64);
            for left in (0..FLIGHT).rev() {
                let view = State::in_the_box(left).apply(&mut session, course.size)?;
                draw(&mut session, &view, Layer::Total)?;
                let image = session.radiance()?;
                radiance = image.values().map(f64::from).fold(radiance, f64::max);
                shown = image.values().map(|value| on_screen(value, 1.0).round()).fold(shown, f64::max);
            }
            Ok([shown, radiance])
        };
        Ok(Sealed { course: course.in_words(), window: brightest(Switch::On)?, single: brightest(Switch::Off)? })
    }
}

fn draw(session: &mut Session, view: &SceneView, only: Layer) -> Result<()> {
    let settings = RenderSettings { only, ..session.render_settings(false) };
    session.render(view, &settings).map(drop)
}

/// Light of an image.
struct Light {
    total: Image,
    indirect: Image,
}

impl Light {
    fn of_total(total: Image, direct: &Image) -> Self {
        let indirect = added(&total, direct, -1.0);
        Self { total, indirect }
    }

    fn of_indirect(indirect: Image, direct: &Image) -> Self {
        let total = added(&indirect, direct, 1.0);
        Self { total, indirect }
    }
}

/// An image and another one times a factor.
fn added(image: &Image, other: &Image, factor: f32) -> Image {
    let mut sum = image.clone();
    for (pixel, other) in sum.pixels_mut().iter_mut().zip(other.pixels()) {
        *pixel = [0, 1, 2].map(|c| pixel[c] + factor * other[c]);
    }
    sum
}

/// The exposure of a camera that sees both and does not adapt: the brighter one is well exposed.
fn exposure(before: &Light, truth: &Light) -> f64 {
    picture::exposure(&before.total).min(picture::exposure(&truth.total))
}

/// A value as pictures of reports show it \[255ths\].
fn on_screen(value: f32, exposure: f64) -> f64 {
    let exposed = (f64::from(value) * exposure).max(0.0);
    255.0 * f64::from(srgb_encode((exposed / (1.0 + exposed)) as f32))
}

/// Change of each pixel, of the channel that changes most \[255ths\].
fn changes(image: &Image, other: &Image, exposure: f64) -> Vec<f64> {
    let pixels = image.pixels().iter().zip(other.pixels());
    let change = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|c| (on_screen(a[c], exposure) - on_screen(b[c], exposure)).abs()).fold(0.0, f64::max)
    };
    pixels.map(change).collect()
}

/// The part of a change that is left: 1 before it, 0 after. Noise is in it only by chance, since it is not like the change. None:
/// nothing changes.
pub(super) fn left_of_change(image: &Image, before: &Image, after: &Image) -> Option<f64> {
    let (mut along, mut length) = (0.0, 0.0);
    for ((a, b), r) in image.values().zip(before.values()).zip(after.values()) {
        let [a, b, r] = [a, b, r].map(f64::from);
        along += (a - r) * (b - r);
        length += (b - r) * (b - r);
    }
    (length > 0.0).then(|| along / length)
}

/// Error of means of 13×13, relative to the mean of the truth.
pub(super) fn coarse_error(image: &Image, truth: &Image) -> f64 {
    let error = noise::difference(image, truth);
    let coarse = local_means(&error, truth.size(), &vec![true; error.len()]);
    let square: f64 = coarse.as_flattened().iter().map(|value| value * value).sum();
    let scale = truth.mean();
    if scale > 0.0 { (square / (3 * coarse.len().max(1)) as f64).sqrt() / scale } else { 0.0 }
}

/// The first frame, from 1, from which on all are near; none: the last is not.
pub(super) fn near_from(errors: &[f64], within: f64) -> Option<u32> {
    let last_far = errors.iter().rposition(|error| *error > within);
    let first = last_far.map_or(0, |index| index + 1);
    (first < errors.len()).then_some(first as u32 + 1)
}

fn judge(case: &Case, before: &Light, frames: &[Light], truth: &Light, rested: &Light) -> CaseFigures {
    let exposure = exposure(before, truth);
    let distance = |light: &Light| changes(&light.total, &truth.total, exposure);
    let errors: Vec<f64> = frames.iter().map(|light| coarse_error(&light.total, &truth.total)).collect();
    let changed: Vec<bool> = distance(before).iter().map(|change| *change > CHANGED).collect();
    let at = |frame: u32| frames.get(frame as usize - 1);
    let residue = |light: &Light, share: f64| percentile(distance(light), share);
    let left = |light: &Light| left_of_change(&light.indirect, &before.indirect, &truth.indirect);
    let where_changed = |light: &Light| {
        let pixels = distance(light).into_iter().zip(&changed).filter(|(_, changed)| **changed);
        percentile(pixels.map(|(value, _)| value).collect(), MOST)
    };
    let compares = !case.moves_camera;
    CaseFigures {
        name: case.name.to_owned(),
        rival: case.rival.map(str::to_owned),
        course: String::new(),
        within: near_from(&errors, WITHIN),
        errors: AFTER.iter().filter_map(|&frame| errors.get(frame as usize - 1).copied()).collect(),
        frames: frames.len() as u32,
        left: AFTER.iter().filter_map(|&frame| left(at(frame)?)).filter(|_| compares).collect(),
        residue: AFTER.iter().filter_map(|&frame| Some(residue(at(frame)?, MOST))).collect(),
        nearly_all: AFTER.iter().filter_map(|&frame| Some(residue(at(frame)?, NEARLY_ALL))).collect(),
        where_changed: AFTER.iter().filter_map(|&f| Some(where_changed(at(f)?))).filter(|_| compares).collect(),
        rested: residue(rested, MOST),
        picture: case.picture(),
    }
}

impl Case {
    /// File of its picture.
    fn picture(&self) -> String {
        format!("pictures/{}.png", picture::file_name(self.name))
    }
}
