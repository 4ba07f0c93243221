//! The picture of the window: begun when there is something new to see, taken up when it is finished.

use super::measurement::Shown;
use super::player::Player;
use super::render_thread::{Begun, Finished, Purpose};
use anyhow::Result;
use lightwell::graph::{FrameReport, GraphError};
use lightwell::profile::FrameRecorder;
use lightwell::render::{GiMethod, MOST_FRAMES, RenderError, RenderSettings};
use lightwell::scene::{SceneCamera, SceneView};
use lightwell_runtime::session::Objects;
use std::time::{Duration, Instant};

/// For so long after a change the view counts as in motion: pictures have the size that the frame budget says.
const CALM: Duration = Duration::from_millis(400);

/// Pictures that come as soon are shown in the same frame of the interface that asked for them.
pub(super) const SOON: Duration = Duration::from_millis(20);

/// What is known of the picture that the window shows.
#[derive(Default)]
pub struct Picture {
    /// The picture, apart from what is being drawn.
    pub shown: Option<wgpu::Texture>,
    /// What is seen where in it.
    pub objects: Option<Objects>,
    /// Samples of the path tracer, so far and when it is finished.
    pub tracing: Option<(u32, u32)>,
    /// Whether it gets better with further frames.
    is_settling: bool,
    /// What it was made of; empty: it is to be drawn anew.
    key: String,
    view: Option<SceneView>,
    /// What was to be seen in it, whatever its size, and when that changed.
    subject: String,
    changed: Option<Instant>,
    /// Whether the picture that was begun last is one of motion.
    is_moving: bool,
    /// Whether it has indirect light, as the first one has not.
    is_whole_light: bool,
}

impl Picture {
    /// Size \[pixels\]; none before the first one.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.shown.as_ref().map(|texture| [texture.width(), texture.height()])
    }

    /// Has it drawn anew even if nothing changed.
    pub fn forget(&mut self) {
        self.key.clear();
    }

    /// Takes note of what is to be seen: whether that is new.
    fn note(&mut self, subject: &str) -> bool {
        let is_new = self.subject != subject;
        if is_new {
            subject.clone_into(&mut self.subject);
            self.changed = Some(Instant::now());
        }
        is_new
    }

    /// When the view comes to rest, if nothing changes until then; none: it rests.
    fn rests_at(&self) -> Option<Instant> {
        self.changed.map(|changed| changed + CALM).filter(|at| *at > Instant::now())
    }

    /// Whether it is drawn again though nothing changed.
    pub(super) fn gets_better(&self) -> bool {
        self.is_settling || self.tracing.is_some_and(|(samples, target)| samples < target)
    }
}

impl Player {
    /// The camera that is drawn with.
    pub(super) fn eye(&self) -> Result<SceneCamera> {
        Ok(self.camera.apply(&self.session.camera()?))
    }

    /// Begins the next picture, of the view or of an export, and takes it up if it comes within a time; whether it did.
    pub(super) fn next_picture(&mut self, frame: &mut FrameRecorder, patience: Duration) -> Result<bool> {
        if self.render_thread.is_idle() {
            self.begin_next();
        } else if self.budget.is_some() && self.job.is_none() && !self.picture.is_moving {
            self.drop_outdated();
        }
        self.take_picture(frame, patience)
    }

    /// Begins the next picture, of the view or of an export.
    pub(super) fn begin_next(&mut self) {
        if self.job.is_some() {
            self.continue_export();
        } else if self.editor.view.is_shown && self.editor.view.size[0] > 0 {
            self.begin_picture().unwrap_or_else(|error| self.failed(&error));
        }
    }

    /// Drops a picture of the view at rest once something else is to be seen: it may take seconds, and one of motion does
    /// not.
    fn drop_outdated(&mut self) {
        let Ok((_, _, subject)) = self.wanted() else { return };
        if self.picture.note(&subject) {
            self.render_thread.drop_frame();
        }
    }

    fn begin_picture(&mut self) -> Result<()> {
        let (mut view, mut settings, subject) = self.wanted()?;
        // The first picture comes soon: indirect light takes longer, and so does making its shaders.
        let is_first = self.picture.shown.is_none();
        if is_first && settings.gi != GiMethod::REFERENCE {
            settings.gi = GiMethod::NONE;
        }
        self.picture.is_whole_light = !is_first;
        self.picture.note(&subject);
        let rests_at = self.picture.rests_at();
        self.picture.is_moving = self.clock.playing || self.play.is_some() || rests_at.is_some();
        if let Some(budget) = self.budget.as_ref().filter(|_| self.picture.is_moving) {
            view.size = budget.size(view.size);
            settings.update = budget.update().max(settings.update);
            // At rest it is drawn in full size.
            if let Some(at) = rests_at {
                self.repaint_at = Some(self.repaint_at.map_or(at, |known| known.min(at)));
            }
        }
        let key = format!("{subject} {:?} {is_first}", view.size);
        if key == self.picture.key && !self.picture.gets_better() {
            return self.measure_late();
        }
        if let Some(play) = &mut self.play {
            play.light.ask(play.playing.game(), &mut self.session.rendering);
        }
        self.render_thread.begin(&mut self.session, view.clone(), settings, Purpose::View)?;
        (self.picture.key, self.picture.view) = (key, Some(view));
        Ok(())
    }

    /// The view in full size, how it is drawn, and a text that is equal for what looks equal.
    fn wanted(&self) -> Result<(SceneView, RenderSettings, String)> {
        let limit = self.session.gpu.limits.max_texture_dimension_2d;
        let size = self.editor.view.size.map(|edge| ((edge as f32 * self.scale).ceil() as u32).clamp(1, limit));
        let view = SceneView { camera: self.eye()?, size, jitter: [0.0; 2] };
        let world = self.world();
        let shown = self.session.rendering.display_settings(world);
        let mut settings = RenderSettings { beside: self.session.beside, ..shown };
        settings.debug.outlined = self.editor.outlined(world);
        // One sample a frame: the image gets better while it is looked at.
        settings.reference.samples_a_frame = 1;
        let (scene, shaders) = (self.session.scene(), self.session.gpu.shaders.revision());
        let subject = format!(
            "{shaders} {} {:?} {:?} {:?} {settings:?} {:?}",
            scene.identity, scene.revisions, scene.vpl, scene.slc, view.camera
        );
        Ok((view, settings, subject))
    }

    /// How large the picture is drawn and why, and how far one at rest is.
    pub(super) fn said_of_size(&self) -> Option<String> {
        let budget = self.budget.as_ref()?;
        let averaged = self.session.rendering.renderer.averaged();
        match averaged.filter(|_| !self.picture.is_moving && self.render_thread.is_idle()) {
            Some(frames) => Some(format!("at rest: {frames} of {MOST_FRAMES} frames")),
            None => Some(budget.status()),
        }
    }

    /// Measures the error that had to wait.
    fn measure_late(&mut self) -> Result<()> {
        match (&self.picture.view, self.meter.due()) {
            (Some(view), Some(due)) if due <= Instant::now() && self.play.is_none() => {
                self.meter.read(&mut self.comparison, &mut self.session, view)?
            }
            _ => return Ok(()),
        }
        self.stale = true;
        Ok(())
    }

    /// Takes up the picture once it is finished; waits for that at most so long. Whether there is one.
    pub(super) fn take_picture(&mut self, frame: &mut FrameRecorder, patience: Duration) -> Result<bool> {
        let Some(Finished { begun, result }) = self.render_thread.take(&mut self.session, patience)? else {
            return Ok(false);
        };
        frame.beside("render", begun.start);
        self.stale = true;
        match result {
            Ok(report) => {
                for pass in &report.passes {
                    if let Some(time) = pass.gpu_ms {
                        frame.gpu(&pass.name, time);
                    }
                }
                if begun.purpose == Purpose::View {
                    self.note_time(&report, begun.start.elapsed());
                }
                self.report = report;
                self.frame_error = None;
                self.show_picture();
                self.note_shown(&begun);
                let measured = match begun.purpose {
                    // The session's settings are those of the edited scene.
                    Purpose::View if self.play.is_some() => Ok(()),
                    Purpose::View => self.meter.read(&mut self.comparison, &mut self.session, &begun.view),
                    Purpose::Export => {
                        self.keep_exported();
                        Ok(())
                    }
                };
                measured.unwrap_or_else(|error| self.failed(&error));
            }
            // A frame that was dropped is drawn anew as it is to be now.
            Err(RenderError::Graph(GraphError::Stopped)) => self.picture.forget(),
            Err(error) => {
                if begun.purpose == Purpose::Export {
                    self.end_export(&format!("the export ended: {error}"), true);
                }
                self.failed(&error.into());
            }
        }
        if let Some(later) = self.meter.due() {
            self.repaint_at = Some(self.repaint_at.map_or(later, |at| at.min(later)));
        }
        for request in std::mem::take(&mut self.waiting) {
            self.answer(request);
        }
        Ok(true)
    }

    /// Tells the measurement what came.
    fn note_shown(&mut self, begun: &Begun) {
        let Some(measurement) = self.measurement.as_mut().filter(|_| begun.purpose == Purpose::View) else { return };
        let averaged = self.session.rendering.renderer.averaged();
        measurement.picture(Shown {
            size: begun.view.size,
            begun: begun.start,
            is_indirect: self.picture.is_whole_light,
            // At rest it has its full size.
            rested: averaged.filter(|_| !self.picture.is_moving),
        });
    }

    /// Tells the budget how long a frame took, on the render thread or on the device. One that the path tracer worked on
    /// tells nothing.
    fn note_time(&mut self, report: &FrameReport, took: Duration) {
        let counts = self.picture.is_moving && self.session.tracing().is_none();
        let Some(budget) = self.budget.as_mut().filter(|_| counts) else { return };
        let device: f64 = report.passes.iter().filter_map(|pass| pass.gpu_ms).sum();
        let seconds = took.as_secs_f64().max(1e-3 * device) as f32;
        budget.note(seconds, seconds);
    }

    /// Copies what was drawn: the next picture is drawn over it in several passes.
    fn show_picture(&mut self) {
        self.picture.objects = self.session.rendering.objects();
        self.picture.tracing = self.session.tracing();
        self.picture.is_settling = self.session.rendering.renderer.is_settling();
        let gpu = self.session.gpu.clone();
        let Some(display) = self.session.display_texture() else { return };
        let size = display.size();
        let copy = self.picture.shown.take().filter(|texture| texture.size() == size);
        let copy = copy.unwrap_or_else(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: display.format(),
                usage: wgpu::TextureUsages::COPY_DST
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
        encoder.copy_texture_to_texture(display.as_image_copy(), copy.as_image_copy(), size);
        gpu.queue.submit([encoder.finish()]);
        self.ui.set_image(&gpu, Some(&copy));
        self.picture.shown = Some(copy);
    }

    fn failed(&mut self, error: &anyhow::Error) {
        let text = format!("{error:#}");
        if self.frame_error.as_ref() != Some(&text) {
            log::error!("{text}");
            self.stale = true;
        }
        self.frame_error = Some(text);
    }
}
