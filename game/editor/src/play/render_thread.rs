//! The thread that draws, so that the window answers while light is computed.

use anyhow::{Result, bail};
use lightwell::gpu::Gpu;
use lightwell::graph::{FramePacing, FrameReport, Timing};
use lightwell::render::{RenderError, RenderSettings, Renderer};
use lightwell::scene::{Scene, SceneView};
use lightwell_runtime::session::Session;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What a picture is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To be looked at.
    View,
    /// To be written as a file.
    Export,
}

/// A picture that was begun.
#[derive(Clone, Debug)]
pub struct Begun {
    /// What for.
    pub purpose: Purpose,
    /// What is seen.
    pub view: SceneView,
    /// When it was begun.
    pub start: Instant,
}

/// A picture that is finished.
pub struct Finished {
    /// As it was begun.
    pub begun: Begun,
    /// What was done, or why it failed.
    pub result: Result<FrameReport, RenderError>,
}

struct Work {
    renderer: Renderer,
    scene: Scene,
    view: SceneView,
    settings: RenderSettings,
}

struct Done {
    renderer: Renderer,
    result: Result<FrameReport, RenderError>,
}

/// Draws pictures, one at a time. While it does, the session has a renderer that has drawn nothing.
pub struct RenderThread {
    work: Option<Sender<Work>>,
    done: Receiver<Done>,
    thread: Option<JoinHandle<()>>,
    pacing: Arc<FramePacing>,
    stand_in: Option<Renderer>,
    begun: Option<Begun>,
    arrived: Option<Done>,
    is_gone: bool,
}

impl RenderThread {
    /// With nothing to do yet.
    pub fn new(gpu: &Arc<Gpu>) -> Self {
        let (work, orders) = channel::<Work>();
        let (finished, done) = channel();
        let device = Arc::clone(gpu);
        let thread = std::thread::spawn(move || {
            for Work { mut renderer, scene, view, settings } in orders {
                let result = renderer.render(&device, &scene, &view, &settings);
                if finished.send(Done { renderer, result }).is_err() {
                    return;
                }
            }
        });
        let pacing = Arc::new(FramePacing::new(&gpu.info));
        let (stand_in, begun, arrived) = (None, None, None);
        Self { work: Some(work), done, thread: Some(thread), pacing, stand_in, begun, arrived, is_gone: false }
    }

    /// Whether nothing is being drawn.
    pub fn is_idle(&self) -> bool {
        self.begun.is_none()
    }

    /// For how long the picture has been drawn, and how many of its passes are done.
    pub fn progress(&self) -> Option<(Duration, (usize, usize))> {
        Some((self.begun.as_ref()?.start.elapsed(), self.pacing.progress()))
    }

    /// Begins a picture of the scene as it stands.
    ///
    /// # Errors
    /// If the thread is gone, or a picture is being drawn.
    pub fn begin(
        &mut self,
        session: &mut Session,
        view: SceneView,
        settings: RenderSettings,
        purpose: Purpose,
    ) -> Result<()> {
        let Some(work) = self.work.as_ref().filter(|_| self.begun.is_none()) else {
            bail!("a picture is being drawn already");
        };
        let mut renderer = self.stand_in.take().unwrap_or_else(|| session.rendering.new_renderer());
        std::mem::swap(&mut session.rendering.renderer, &mut renderer);
        renderer.set_pacing(Some(Arc::clone(&self.pacing)));
        if purpose == Purpose::View {
            renderer.set_timing(Timing::Late);
        }
        self.pacing.restart();
        let order = Work { renderer, scene: session.scene().clone(), view: view.clone(), settings };
        if work.send(order).is_err() {
            bail!("the thread that draws has ended");
        }
        self.begun = Some(Begun { purpose, view, start: Instant::now() });
        Ok(())
    }

    /// Drops the picture that is being drawn, after the pass that runs: it comes as [`GraphError::Stopped`].
    ///
    /// [`GraphError::Stopped`]: lightwell::graph::GraphError::Stopped
    pub fn drop_frame(&self) {
        self.pacing.drop_frame();
    }

    /// Whether there is something to [`RenderThread::take`].
    pub fn is_finished(&mut self) -> bool {
        if self.arrived.is_none() && self.begun.is_some() {
            match self.done.try_recv() {
                Ok(done) => self.arrived = Some(done),
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => self.is_gone = true,
            }
        }
        self.arrived.is_some() || self.is_gone
    }

    /// The picture, once it is finished; waits for that at most so long.
    ///
    /// # Errors
    /// If the thread is gone.
    pub fn take(&mut self, session: &mut Session, patience: Duration) -> Result<Option<Finished>> {
        let Some(begun) = self.begun.clone() else { return Ok(None) };
        let done = match self.arrived.take() {
            Some(done) => Ok(done),
            None => self.done.recv_timeout(patience),
        };
        let Done { mut renderer, result } = match done {
            Ok(done) => done,
            Err(RecvTimeoutError::Timeout) => return Ok(None),
            Err(RecvTimeoutError::Disconnected) => bail!("the thread that draws has ended"),
        };
        std::mem::swap(&mut session.rendering.renderer, &mut renderer);
        self.stand_in = Some(renderer);
        self.begun = None;
        if let Ok(report) = &result {
            self.pacing.adapt(report);
        }
        Ok(Some(Finished { begun, result }))
    }
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.pacing.stop();
        self.work = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell_runtime::cli::{Common, LookArgs};

    const SCENE: &str = r#"Scene(entities: [
        (name: "Camera", transform: (translation: (0, 1, 4)), camera: ()),
        (name: "Lamp", transform: (translation: (0, 3, 1)), light: (kind: Point, intensity: 30)),
        (name: "Floor", mesh: Plane(size: (6, 6))),
        (name: "Ball", transform: (translation: (0, 0.5, 0)), mesh: Sphere(radius: 0.5)),
    ])"#;

    #[test]
    fn pictures_of_the_thread_are_the_same_and_the_session_lives_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scene.ron");
        std::fs::write(&path, SCENE).unwrap();
        let look = LookArgs::default();
        let mut session = Session::headless(path.to_str().unwrap(), &look, &Common::default()).unwrap();
        let view = SceneView { camera: session.camera().unwrap(), size: [48, 32], jitter: [0.0; 2] };
        let settings = RenderSettings { no_cache: true, ..session.display_settings() };
        let plain = session.render(&view, &settings).unwrap();
        let wanted = session.display_bytes().unwrap();

        let mut render_thread = RenderThread::new(&session.gpu);
        for interruptible in [false, true] {
            render_thread.pacing.set_interruptible(interruptible);
            render_thread.begin(&mut session, view.clone(), settings.clone(), Purpose::View).unwrap();
            assert!(!render_thread.is_idle() && render_thread.progress().is_some());
            assert!(
                render_thread.begin(&mut session, view.clone(), settings.clone(), Purpose::View).is_err(),
                "one at a time"
            );
            session.set_seconds(1.0);
            let start = Instant::now();
            while !render_thread.is_finished() {
                assert!(start.elapsed() < Duration::from_secs(60));
                std::thread::sleep(Duration::from_millis(1));
            }
            let finished = render_thread.take(&mut session, Duration::ZERO).unwrap().unwrap();
            let report = finished.result.unwrap();
            assert_eq!(report.ran_count(), plain.ran_count());
            assert_eq!(render_thread.pacing.progress().0, report.ran_count(), "all passes are counted");
            let more = report.submits.cmp(&plain.submits);
            assert!(
                if interruptible { more.is_ge() } else { more.is_eq() },
                "interruptible frames are cut into more submits: {} and {}",
                report.submits,
                plain.submits
            );
            assert!(session.display_bytes().unwrap() == wanted, "the same bits");
            assert!(render_thread.is_idle() && render_thread.take(&mut session, Duration::ZERO).unwrap().is_none());
        }
        // Ended in the middle of a picture, it ends soon.
        render_thread.begin(&mut session, view, settings, Purpose::View).unwrap();
        drop(render_thread);
    }
}
