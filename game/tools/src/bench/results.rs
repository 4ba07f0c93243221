//! What a run found: `results.json`.

use super::growth::{Growth, Pair};
use super::variant::SweepPoint;
use anyhow::{Context, Result, bail};
use lightwell::files::replace_file;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Everything that a run found. Every finished measurement is written at once, so that a run can be taken up again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Where and with what it was measured.
    pub header: Header,
    /// What is compared.
    pub variants: Vec<VariantFigures>,
    /// The scenes.
    pub scenes: Vec<SceneFigures>,
    /// Times, counts and memory.
    pub timings: Vec<Timing>,
    /// Errors against the reference.
    pub errors: Vec<ErrorFigures>,
    /// Frame-to-frame change beyond the reference's own.
    pub flicker: Vec<Flicker>,
    /// Path tracing on the device against the host.
    pub throughput: Vec<ThroughputFigures>,
    /// How cost grows with what a scene holds.
    #[serde(default)]
    pub growth: Vec<Growth>,
    /// Pairs of scenes whose ratio is bounded.
    #[serde(default)]
    pub pairs: Vec<Pair>,
    /// What the reader should know.
    pub notes: Vec<String>,
}

/// Where and with what a run was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The graphics adapter.
    pub adapter: String,
    /// Its kind: `DiscreteGpu`, `Cpu`, …
    pub device_type: String,
    /// Its driver and the driver's version.
    pub driver: String,
    /// The graphics interface.
    pub backend: String,
    /// Operating system, processor kind and number of threads.
    pub system: String,
    /// Version of the program.
    pub version: String,
    /// Commit of the source tree, with `-dirty` where files differ from it.
    pub commit: Option<String>,
    /// Hash of the program and its shaders.
    pub program: String,
    /// When the run began (UTC).
    pub date: String,
    /// The settings of the last run, in words.
    pub settings: String,
    /// The last run's command line.
    #[serde(default)]
    pub command: String,
}

impl Header {
    /// Checks that results may be added to those that `path` holds under this header.
    ///
    /// # Errors
    /// If they come of another adapter, driver or program.
    pub fn check_same_source(&self, now: &Self, path: &Path) -> Result<()> {
        for (what, then, now) in [
            ("adapter", &self.adapter, &now.adapter),
            ("driver", &self.driver, &now.driver),
            ("build of the program or its shaders", &self.program, &now.program),
        ] {
            if then != now {
                bail!(
                    "{} holds results of another {what} ({then}, now {now}); add --fresh to replace them, or give another \
                     folder",
                    path.display()
                );
            }
        }
        Ok(())
    }
}

/// One of the things that are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantFigures {
    /// Name.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Whether it traces paths.
    pub traced: bool,
    /// The sweep that it is a point of, with the scene where its settings depend on that.
    pub sweep: Option<SweepPoint>,
    /// The only scene that it is for.
    pub scene: Option<String>,
}

/// A scene in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneFigures {
    /// Name.
    pub name: String,
    /// Primitives drawn.
    pub primitives: usize,
    /// Triangles of all primitives.
    pub triangles: usize,
    /// Lights in words: `1 spot`.
    pub lights: String,
    /// Light propagation volumes in words.
    pub volumes: String,
    /// Size of the light propagation volumes in cells, all cascades together.
    pub cells: Option<u64>,
    /// Propagation steps.
    pub steps: Option<u32>,
}

/// Median, least and greatest of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Least.
    pub min: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of some values; none of no values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        let middle = sorted.len() / 2;
        let median = if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) };
        Some(Self { median, min, max })
    }
}

/// What of a frame is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Mode {
    /// Everything, in every frame.
    Full,
    /// What has changed since the frame before; the scene's clock runs.
    Animated,
    /// What the shift of the pixels changes: an image that is averaged with others of the same scene.
    Shifted,
}

/// Counts by name.
pub type CountMap = BTreeMap<String, u64>;

/// Times of one variant in one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// What was computed.
    pub mode: Mode,
    /// Frames measured.
    pub frames: usize,
    /// Time of each stage on the device [ms].
    pub stages: BTreeMap<String, Spread>,
    /// Time of all stages on the device [ms]; of path tracing the time from start to end.
    pub total: Spread,
    /// Time of the frame from start to end [ms].
    pub wall: Spread,
    /// Counts of each stage in the first measured frame.
    pub counts: BTreeMap<String, CountMap>,
    /// Merges of blocker volumes in the first measured frame.
    pub merges: Option<u64>,
    /// Passes that the table of stages does not know.
    pub unknown_passes: Vec<String>,
    /// Memory that the frame's targets take [bytes].
    pub allocated_bytes: u64,
    /// Most memory that the whole process took so far [bytes].
    pub peak_bytes: Option<u64>,
}

/// Errors of one layer of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerError {
    /// Mean of the reference [W/(m² sr)].
    pub mean: f64,
    /// Root mean square error, without the reference's noise.
    pub rmse: f64,
    /// The same, relative to the mean.
    #[serde(with = "finite")]
    pub nrmse: f64,
    /// The same with the reference's noise in it.
    #[serde(with = "finite")]
    pub noisy_nrmse: f64,
    /// Relative error of the mean.
    #[serde(with = "finite")]
    pub bias: f64,
    /// 95th percentile of the relative error.
    #[serde(with = "finite")]
    pub p95: f64,
    /// Mean FLIP.
    pub flip: f64,
    /// Noise of the reference, relative to its mean.
    #[serde(with = "finite")]
    pub noise: f64,
}

/// Errors of one variant in one scene at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorFigures {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Time [s].
    pub time: f64,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Frames averaged.
    pub aa: u32,
    /// Indirect bounces of the reference; none: unlimited.
    pub bounces: Option<u32>,
    /// Samples a pixel of the reference.
    pub reference_spp: u32,
    /// All light.
    pub total: LayerError,
    /// Direct light.
    pub direct: LayerError,
    /// Indirect light.
    pub indirect: LayerError,
    /// Pictures, relative to the folder of the results.
    pub pictures: Vec<String>,
}

/// Flicker of one variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flicker {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Variant.
    pub variant: String,
    /// Frames.
    pub frames: u32,
    /// Root mean square of the frame-to-frame change of indirect light beyond the reference's, over the mean.
    #[serde(with = "finite")]
    pub change: f64,
    /// The reference's own change in the same measure.
    #[serde(with = "finite")]
    pub reference: f64,
    /// What of that is not steady: second differences over √3, beyond the reference's, over the mean. Noise that is
    /// another one in each frame has as much of it as of change, a change that goes on evenly none.
    #[serde(default)]
    pub tremble: Option<f64>,
    /// The reference's own in the same measure.
    #[serde(default)]
    pub reference_tremble: Option<f64>,
    /// Error of the frames, each against the reference of its time: root mean square over the mean.
    #[serde(default)]
    pub error: Option<f64>,
    /// Their mean over the reference's, less 1.
    #[serde(default)]
    pub bias: Option<f64>,
    /// Error of all light of the frames, in the same measure.
    #[serde(default)]
    pub total_error: Option<f64>,
    /// Its mean over the reference's, less 1.
    #[serde(default)]
    pub total_bias: Option<f64>,
    /// The change, where each frame is averaged over shifts by parts of a pixel.
    #[serde(default)]
    pub smooth: Option<f64>,
    /// The picture of it, relative to the folder of the results.
    #[serde(default)]
    pub picture: Option<String>,
}

/// Path tracing on the device against the host over the same hierarchies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThroughputFigures {
    /// All that it depends on.
    pub key: String,
    /// Scene.
    pub scene: String,
    /// Paths that each traced.
    pub paths: u64,
    /// Threads of the host.
    pub threads: usize,
    /// Paths a second on the device.
    pub device: f64,
    /// Paths a second on the host.
    pub host: f64,
}

/// JSON knows no infinity: it becomes null.
pub mod finite {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes a number.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    /// Reads a number.
    ///
    /// # Errors
    /// Those of the deserializer.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

/// The results in their file.
pub struct Store {
    path: PathBuf,
    /// The results.
    pub results: Results,
}

impl Store {
    /// Takes up the results of a folder, or begins new ones.
    ///
    /// # Errors
    /// If the folder holds results of another adapter or program, or cannot be read.
    pub fn open(folder: &Path, header: Header, fresh: bool) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join("results.json");
        let old = if fresh { None } else { read(&path)? };
        let results = match old {
            None => Results { header, ..Results::default() },
            Some(old) => {
                old.header.check_same_source(&header, &path)?;
                Results { header: Header { date: old.header.date.clone(), ..header }, ..old }
            }
        };
        Ok(Self { path, results })
    }

    /// Writes the results in one step.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.results)?;
        write_whole(&self.path, text.as_bytes())
    }

    /// Adds a note once.
    pub fn note(&mut self, note: String) {
        if !self.results.notes.contains(&note) {
            self.results.notes.push(note);
        }
    }
}

fn read(path: &Path) -> Result<Option<Results>> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let read = serde_json::from_str(&text);
    read.map(Some).with_context(|| format!("{} holds no results; add --fresh to replace it", path.display()))
}

/// Writes a file so that at every moment there is either the old or the whole new one.
///
/// # Errors
/// If it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_file(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn spreads() {
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Some(Spread { median: 2.0, min: 1.0, max: 3.0 }));
        assert_eq!(Spread::of(&[4.0, 1.0]).unwrap().median, 2.5);
    }

    #[test]
    fn results_survive_their_file_infinity_included() {
        let dir = tempfile::tempdir().unwrap();
        let mut store = Store::open(dir.path(), Header::default(), false).unwrap();
        store.results.flicker.push(Flicker {
            key: "k".into(),
            scene: "s".into(),
            variant: "v".into(),
            frames: 2,
            change: f64::INFINITY,
            reference: 0.5,
            tremble: Some(0.25),
            smooth: Some(0.125),
            ..Flicker::default()
        });
        store.save().unwrap();
        let again = Store::open(dir.path(), Header::default(), false).unwrap();
        assert_eq!(again.results, store.results);
        assert!(Store::open(dir.path(), Header::default(), true).unwrap().results.flicker.is_empty());
    }

    #[test]
    fn results_of_another_device_or_build_are_not_mixed() {
        let dir = tempfile::tempdir().unwrap();
        Store::open(dir.path(), Header::default(), false).unwrap().save().unwrap();
        for header in [
            Header { adapter: "other".into(), ..Header::default() },
            Header { program: "other".into(), ..Header::default() },
        ] {
            let message = Store::open(dir.path(), header, false).err().unwrap().to_string();
            assert!(message.contains("--fresh"), "{message}");
        }
        std::fs::write(dir.path().join("results.json"), "{").unwrap();
        assert!(Store::open(dir.path(), Header::default(), false).is_err());
    }
}
