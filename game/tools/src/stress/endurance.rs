//! Long runs: thousands of frames of the animated scenes in one session, which must neither grow nor drift.

use anyhow::Result;
use bevy_ecs::entity::Entity;
use lightwell::gpu::Gpu;
use lightwell::measure::Image;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::session::Session;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

/// Image size [pixels].
const SIZE: [u32; 2] = [48, 48];
/// Frames after which all that a scene draws with is there: what moves is first drawn with all else, then over it.
const SETTLED: u32 = 8;
/// Growth of the process that the allocator may keep for itself [MiB].
const SLACK: u64 = 64;

/// The result of a run.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Endured {
    scene: String,
    frames: u32,
    seconds: f64,
    /// Memory of the process after the first loop (after half of the frames, where they are fewer than two loops), and at
    /// the end, where the system tells [MiB].
    memory: Option<[u64; 2]>,
    /// Bytes of targets on the device, then and at the end.
    targets: [u64; 2],
    entities: [usize; 2],
    not_finite: u32,
    /// Whether the first frame, drawn again at the end, is the same bit for bit.
    returns: bool,
}

/// Scenes that ship, with the share of the frames that each runs: two loops of 24 s are 1,440 frames.
pub const SCENES: [(&str, u32); 17] = [
    ("cornell", 1),
    ("bleeding_gloss", 1),
    ("glossy_ring", 20),
    ("vpl_report", 10),
    ("gallery", 10),
    ("studio", 10),
    ("plaza", 10),
    ("smoke", 20),
    ("embers", 20),
    ("glassware", 20),
    ("showroom", 20),
    ("lens", 10),
    ("glasshouse", 10),
    ("meeting_room", 10),
    ("night_court", 7),
    ("cathedral", 7),
    ("courtyard", 7),
];

/// Plays a scene over and over for so many frames, drawn with the coarsest settings of its method.
///
/// # Errors
/// If it cannot be drawn.
pub fn endure(gpu: Arc<Gpu>, scene: &str, frames: u32, common: &Common, drawn: &dyn Fn()) -> Result<Endured> {
    let start = Instant::now();
    let mut session = Session::open(gpu, scene, &LookArgs::default(), common)?;
    if session.scene().clpv.is_some() {
        // A ray a pixel, so that the hierarchy of the rays is followed too.
        let coarsest = [("clpv.quality", "Low"), ("clpv.bounces", "Count(2)"), ("clpv.gather_rays", "Count(1)")];
        let sets = coarsest.map(|(path, value)| (path.to_owned(), value.to_owned())).to_vec();
        session = session.again(&LookArgs { sets, ..LookArgs::default() })?;
    }
    let settings = session.settings();
    let rate = settings.frame_rate.max(1);
    let frames_a_loop = (settings.duration.unwrap_or(10.0) * rate as f32).round().max(1.0) as u32;
    let mut not_finite = 0;
    let mut draw = |session: &mut Session, frame: u32| -> Result<(Image, u64)> {
        session.set_seconds(f64::from(frame % frames_a_loop) / f64::from(rate));
        let view = SceneView { camera: session.camera()?, size: SIZE, jitter: [0.0; 2] };
        let report = session.render(&view, &session.render_settings(false))?;
        let image = session.radiance()?;
        not_finite += u32::from(image.first_non_finite().is_some());
        Ok((image, report.allocated_bytes))
    };
    let first = draw(&mut session, 0)?.0;
    let mut early = (None, 0, 0);
    let mut last = 0;
    for frame in 1..frames {
        last = draw(&mut session, frame)?.1;
        // All that the scene ever shows has been seen after its first loop.
        if frame == frames_a_loop.max(frames / 10).min(frames / 2).max(SETTLED).min(frames - 1) {
            early = (memory(), last, entities(&mut session));
        }
        drawn();
    }
    let returns = draw(&mut session, 0)?.0.first_bit_difference(&first).is_none();
    Ok(Endured {
        scene: scene.to_owned(),
        frames,
        seconds: start.elapsed().as_secs_f64(),
        memory: early.0.zip(memory()).map(|(early, late)| [early, late]),
        targets: [early.1, last],
        entities: [early.2, entities(&mut session)],
        not_finite,
        returns,
    })
}

fn entities(session: &mut Session) -> usize {
    let world = &mut session.parts().world.ecs;
    world.query::<Entity>().iter(world).count()
}

/// Memory of the process, where the system tells [MiB].
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}

impl Endured {
    /// The violated bounds, in words.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut check = |holds: bool, what: String| {
            if !holds {
                faults.push(format!("{}: {what}", self.scene));
            }
        };
        check(self.not_finite == 0, format!("{} frames hold values that are not finite", self.not_finite));
        check(self.returns, "the first frame is another one at the end".to_owned());
        let [early, late] = self.entities;
        check(early == late, format!("{early} entities became {late}"));
        // Targets differ a little from frame to frame, as lights come into view and leave it.
        let [early, late] = self.targets;
        check(late <= early + early / 4, format!("{early} bytes of targets became {late}"));
        let [early, late] = self.memory.unwrap_or_default();
        check(late <= early + early / 20 + SLACK, format!("the process grew from {early} to {late} MiB"));
        faults
    }
}

/// A line for each run.
pub fn table(runs: &[Endured]) -> String {
    let mut text = format!(
        "{:16} {:>7} {:>9} {:>19} {:>25} {:>10} {:>11} {:>8}\n",
        "long runs", "frames", "time [s]", "process [MiB]", "targets [KiB]", "entities", "not finite", "returns"
    );
    for run in runs {
        let memory = run.memory.map_or(String::new(), |[early, late]| format!("{early} .. {late}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:16} {:>7} {:>9.0} {memory:>19} {:>25} {:>10} {:>11} {:>8}",
            run.scene,
            run.frames,
            run.seconds,
            format!("{} .. {}", run.targets[0] / 1024, run.targets[1] / 1024),
            run.entities[1],
            run.not_finite,
            if run.returns { "yes" } else { "NO" }
        );
    }
    text
}
