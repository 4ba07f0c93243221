//! A window that measures itself: how soon it shows something, how often while it plays, how soon it answers a turn of the
//! camera, and how fast it comes to rest. It ends by itself.
//!
//! ```text
//! open ─ first picture ─ with indirect light ─ play ─ turns while it plays ─ pause, rest ─ turns at rest ─ the file
//! ```

use super::player::Player;
use anyhow::Result;
use lightwell_runtime::window_figures::{RESTED, WindowFigures};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long the scene plays for its rate: first it settles on a size.
const SETTLING: Duration = Duration::from_secs(6);
const PLAYING: Duration = Duration::from_secs(8);
/// Turns of the camera that are measured, and how far each goes \[pixels of a drag\].
const TURNS: usize = 8;
const TURN: f32 = 24.0;
/// From one turn's picture to the next turn: at rest the picture is being refined by then.
const BETWEEN: Duration = Duration::from_millis(700);
/// Longest wait for rest.
const PATIENCE: Duration = Duration::from_secs(120);

/// Where the window is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Pictures come in.
    Opening,
    /// The scene plays: settling, then counted.
    Playing,
    /// It comes to rest.
    Resting,
    /// The camera is turned, while the scene plays or while it rests.
    Turning { at_rest: bool },
    /// All is measured.
    Done,
}

/// What the window measures of itself.
#[derive(Debug)]
pub struct Measurement {
    file: PathBuf,
    started: Instant,
    phase: Phase,
    since: Instant,
    last_picture: Instant,
    /// When the camera was turned, until a picture shows that.
    turned: Option<Instant>,
    figures: WindowFigures,
}

/// What the picture that has come shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Size \[pixels\].
    pub size: [u32; 2],
    /// When it was begun.
    pub begun: Instant,
    /// Whether it has indirect light.
    pub is_indirect: bool,
    /// Frames of a view at rest in it.
    pub rested: Option<u32>,
}

impl Measurement {
    /// Of a program that was started then; the figures go to the file.
    pub fn new(file: PathBuf, started: Instant) -> Self {
        Self {
            file,
            started,
            phase: Phase::Opening,
            since: started,
            last_picture: started,
            turned: None,
            figures: WindowFigures::default(),
        }
    }

    fn enter(&mut self, phase: Phase) {
        (self.phase, self.since, self.turned) = (phase, Instant::now(), None);
    }

    /// Takes note of a picture.
    pub fn picture(&mut self, shown: Shown) {
        let (now, since) = (Instant::now(), self.since.elapsed());
        let after = self.started.elapsed().as_secs_f64();
        match self.phase {
            Phase::Opening if self.figures.first_picture == 0.0 => {
                self.figures.first_picture = after;
                if shown.is_indirect {
                    self.figures.first_indirect = after;
                }
            }
            Phase::Opening if shown.is_indirect => {
                self.figures.first_indirect = after;
                self.enter(Phase::Playing);
            }
            Phase::Playing if since > SETTLING => {
                self.figures.frames.push((now - self.last_picture).as_secs_f64());
                self.figures.played_size = shown.size;
                if since > SETTLING + PLAYING {
                    self.enter(Phase::Turning { at_rest: false });
                }
            }
            Phase::Resting => {
                let frames = shown.rested.unwrap_or(0);
                while RESTED.get(self.figures.rested.len()).is_some_and(|wanted| frames >= *wanted) {
                    self.figures.rested.push(since.as_secs_f64());
                }
                if self.figures.rested.len() == RESTED.len() || since > PATIENCE {
                    self.enter(Phase::Turning { at_rest: true });
                }
            }
            Phase::Turning { at_rest } => {
                if let Some(turned) = self.turned.filter(|turned| shown.begun >= *turned) {
                    let list = if at_rest { &mut self.figures.answers_at_rest } else { &mut self.figures.answers };
                    list.push(turned.elapsed().as_secs_f64());
                    let is_last = list.len() == TURNS;
                    (self.turned, self.since) = (None, now);
                    if is_last {
                        self.enter(if at_rest { Phase::Done } else { Phase::Resting });
                    }
                }
            }
            Phase::Opening | Phase::Playing | Phase::Done => {}
        }
        self.last_picture = now;
    }

    /// Whether it has counted the pictures of a scene that plays, and not yet what they took.
    fn has_counted(&self) -> bool {
        self.phase == Phase::Turning { at_rest: false } && self.figures.spent.is_empty()
    }

    /// Whether the scene is to play.
    fn plays(&self) -> bool {
        matches!(self.phase, Phase::Opening | Phase::Playing | Phase::Turning { at_rest: false })
    }

    /// Whether it wants something done.
    pub fn is_waiting(&self) -> bool {
        self.phase == Phase::Done || self.is_turn_due()
    }

    fn is_turn_due(&self) -> bool {
        matches!(self.phase, Phase::Turning { .. }) && self.turned.is_none() && self.since.elapsed() > BETWEEN
    }

    /// Whether the camera is to be turned now.
    fn turns(&mut self) -> bool {
        let is_due = self.is_turn_due();
        if is_due {
            self.turned = Some(Instant::now());
        }
        is_due
    }
}

impl Player {
    /// Does what the measurement wants next: as an input would.
    ///
    /// # Errors
    /// If the figures cannot be written.
    pub(super) fn go_on_measuring(&mut self) -> Result<()> {
        let Some(measurement) = &mut self.measurement else { return Ok(()) };
        if measurement.phase == Phase::Done {
            measurement.figures.adapter = self.session.gpu.info.name.clone();
            measurement.figures.view = self.editor.view.size;
            self.ended = true;
            return measurement.figures.write(&measurement.file);
        }
        if measurement.has_counted() {
            measurement.figures.note_spent(&self.profiler);
        }
        self.clock.playing = measurement.plays();
        if measurement.turns() {
            let camera = self.session.camera()?;
            self.camera.look(&camera, [TURN, 0.0]);
            self.stale = true;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn shown(is_indirect: bool, rested: u32) -> Shown {
        Shown { size: [64, 48], begun: Instant::now(), is_indirect, rested: Some(rested) }
    }

    #[test]
    fn phases_follow_each_other_and_end() {
        let mut measurement = Measurement::new(PathBuf::from("unused"), Instant::now());
        measurement.picture(shown(false, 0));
        assert!(measurement.phase == Phase::Opening && measurement.figures.first_picture > 0.0 && measurement.plays());
        measurement.picture(shown(true, 0));
        assert!(measurement.phase == Phase::Playing && measurement.figures.first_indirect > 0.0);
        measurement.since = Instant::now().checked_sub(SETTLING + PLAYING + BETWEEN).unwrap();
        measurement.picture(shown(true, 0));
        assert_eq!((measurement.phase, measurement.figures.frames.len()), (Phase::Turning { at_rest: false }, 1));
        for at_rest in [false, true] {
            for _ in 0..TURNS {
                measurement.since = Instant::now().checked_sub(2 * BETWEEN).unwrap();
                let before = shown(true, 0);
                assert!(measurement.turns() && !measurement.turns());
                measurement.picture(before);
                assert!(measurement.turned.is_some(), "it was begun before the turn");
                measurement.picture(shown(true, 0));
            }
            if !at_rest {
                assert!(measurement.phase == Phase::Resting && !measurement.plays());
                measurement.picture(shown(true, 20));
                assert_eq!(measurement.figures.rested.len(), 2);
                measurement.picture(shown(true, 64));
            }
        }
        assert_eq!(measurement.phase, Phase::Done);
        let [playing, resting] = [&measurement.figures.answers, &measurement.figures.answers_at_rest].map(Vec::len);
        assert_eq!((playing, resting, measurement.figures.rested.len()), (TURNS, TURNS, RESTED.len()));
    }
}
