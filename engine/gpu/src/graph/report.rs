//! Reports of frames, for people and for tests.

use std::fmt;
use std::ops::AddAssign;

use super::cache::CacheFigures;
use super::desc::ResourceDesc;
use crate::gpu::HostCounts;

/// Counts of a pass's work, which do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Draw calls.
    pub draws: u64,
    /// Compute dispatches.
    pub dispatches: u64,
    /// Triangles drawn.
    pub triangles: u64,
    /// Texels computed.
    pub texels: u64,
    /// Grid cells computed.
    pub cells: u64,
    /// Lights evaluated.
    pub lights: u64,
    /// Light sources injected into volumes.
    pub injections: u64,
    /// Views merged into volumes of blockers that held views already.
    pub merges: u64,
    /// Light paths traced.
    pub paths: u64,
    /// Rays cast into the scene for indirect light, shadow rays among them, where their number is known beforehand: those
    /// of path tracing are not counted. Near surfaces may cost some more.
    pub rays: u64,
    /// Bytes uploaded or copied.
    pub bytes: u64,
}

impl Counts {
    /// All counts with their names.
    pub fn named(&self) -> [(&'static str, u64); 11] {
        [
            ("draws", self.draws),
            ("dispatches", self.dispatches),
            ("triangles", self.triangles),
            ("texels", self.texels),
            ("cells", self.cells),
            ("lights", self.lights),
            ("injections", self.injections),
            ("merges", self.merges),
            ("paths", self.paths),
            ("rays", self.rays),
            ("bytes", self.bytes),
        ]
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.draws += other.draws;
        self.dispatches += other.dispatches;
        self.triangles += other.triangles;
        self.texels += other.texels;
        self.cells += other.cells;
        self.lights += other.lights;
        self.injections += other.injections;
        self.merges += other.merges;
        self.paths += other.paths;
        self.rays += other.rays;
        self.bytes += other.bytes;
    }
}

/// Prints the counts that are not 0.
impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = self.named().into_iter().filter(|(_, count)| *count > 0);
        let counts: Vec<String> = counts.map(|(name, count)| format!("{count} {name}")).collect();
        f.pad(&counts.join(", "))
    }
}

/// Whether a pass ran.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PassState {
    /// It ran.
    Ran,
    /// Its results of an earlier frame are reused.
    Cached,
    /// Nobody wanted what it makes.
    Culled,
    /// The caller left it out, and says why.
    Skipped(String),
}

impl fmt::Display for PassState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Ran => "ran",
            Self::Cached => "cached",
            Self::Culled => "culled",
            Self::Skipped(_) => "skipped",
        })
    }
}

/// The report of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassReport {
    /// Its name.
    pub name: String,
    /// Whether it ran.
    pub state: PassState,
    /// Why, in words.
    pub why: String,
    /// Counts of its work.
    pub counts: Counts,
    /// Time on the device \[ms\]; `None` if it did not run or the device cannot tell.
    pub gpu_ms: Option<f64>,
    /// Time to record it \[ms\].
    pub cpu_ms: f64,
}

impl PassReport {
    pub(super) fn new(name: String, state: PassState, why: String) -> Self {
        Self { name, state, why, counts: Counts::default(), gpu_ms: None, cpu_ms: 0.0 }
    }
}

/// One resource of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ResourceReport {
    /// Its name.
    pub name: String,
    /// Its description.
    pub desc: ResourceDesc,
    /// Its size \[bytes\].
    pub bytes: u64,
    /// The other transient resources in the same memory.
    pub aliased_with: Vec<String>,
    /// Whether its content is kept over frames.
    pub retained: bool,
    /// Whether it is the caller's.
    pub imported: bool,
}

/// The report of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameReport {
    /// All passes in the order of declaration, then the skipped ones.
    pub passes: Vec<PassReport>,
    /// Warnings: what the scene asks for and the frame does not show, with entity, reason and help.
    pub warnings: Vec<String>,
    /// All resources that had memory.
    pub resources: Vec<ResourceReport>,
    /// All memory that the cache holds \[bytes\].
    pub allocated_bytes: u64,
    /// Other contents of the cache.
    pub cache: CacheFigures,
    /// How often commands were submitted.
    pub submits: u64,
    /// Requests to the device by the frame, by the scene's update before it, and by other threads meanwhile.
    pub host: HostCounts,
    /// Time that the host took for the frame, with the scene's update and all waits \[ms\].
    pub host_ms: f64,
}

impl FrameReport {
    /// The report of one pass.
    pub fn pass(&self, name: &str) -> Option<&PassReport> {
        self.passes.iter().find(|pass| pass.name == name)
    }

    /// Whether a pass of that name ran.
    pub fn ran(&self, name: &str) -> bool {
        self.pass(name).is_some_and(|pass| pass.state == PassState::Ran)
    }

    /// The number of passes that ran.
    pub fn ran_count(&self) -> usize {
        self.passes.iter().filter(|pass| pass.state == PassState::Ran).count()
    }

    /// The counts of all passes together.
    pub fn total(&self) -> Counts {
        let mut total = Counts::default();
        self.passes.iter().for_each(|pass| total += pass.counts);
        total
    }

    /// Time on the device of all passes together \[ms\]; `None` if the device cannot tell.
    pub fn gpu_ms(&self) -> Option<f64> {
        let times: Vec<f64> = self.passes.iter().filter_map(|pass| pass.gpu_ms).collect();
        (!times.is_empty() || self.ran_count() == 0).then(|| times.iter().fold(0.0, |sum, time| sum + time))
    }

    /// The report without times and without what the host asked of the device, which depends on what earlier frames left:
    /// equal on all machines that do the same work.
    pub fn without_times(&self) -> Self {
        let passes = self.passes.iter().map(|pass| PassReport { gpu_ms: None, cpu_ms: 0.0, ..pass.clone() });
        Self { passes: passes.collect(), host: HostCounts::default(), host_ms: 0.0, ..self.clone() }
    }
}

/// The warnings of the frame, a table of its passes, and its memory.
impl fmt::Display for FrameReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.passes.iter().map(|pass| pass.name.chars().count()).max().unwrap_or(0).max(4);
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        writeln!(f, "{:width$}  {:7}  {:>9}  {:>9}  why; work", "pass", "state", "GPU [ms]", "CPU [ms]")?;
        for pass in &self.passes {
            let gpu = pass.gpu_ms.map_or("-".into(), |ms| format!("{ms:.3}"));
            let cpu = if pass.state == PassState::Ran { format!("{:.3}", pass.cpu_ms) } else { "-".into() };
            write!(f, "{:width$}  {:7}  {gpu:>9}  {cpu:>9}  {}", pass.name, pass.state, pass.why)?;
            match pass.counts == Counts::default() {
                true => writeln!(f)?,
                false => writeln!(f, "; {}", pass.counts)?,
            }
        }
        let total = self.gpu_ms().map_or("-".into(), |ms| format!("{ms:.3}"));
        writeln!(f, "{:width$}  {:7}  {total:>9}  {:>9}  {}", "all", self.ran_count(), "", self.total())?;
        writeln!(f, "host: {:.3} ms, {}", self.host_ms, self.host)?;
        let CacheFigures { retained_bytes, pooled_bytes, retained, pooled, created, evicted } = self.cache;
        let [all, retained_mib, pooled_mib] =
            [self.allocated_bytes, retained_bytes, pooled_bytes].map(|bytes| bytes as f64 / (1024.0 * 1024.0));
        writeln!(
            f,
            "memory: {all:.1} MiB ({retained} retained {retained_mib:.1} MiB, {pooled} shared {pooled_mib:.1} MiB), {created} made, {evicted} let go"
        )?;
        let aliased = self.resources.iter().filter(|resource| !resource.aliased_with.is_empty());
        aliased.into_iter().try_for_each(|resource| {
            writeln!(
                f,
                "  `{}` ({}) shares memory with {}",
                resource.name,
                resource.desc,
                resource.aliased_with.join(", ")
            )
        })
    }
}
