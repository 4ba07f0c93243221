//! The plan of a run: scenes, variants, sizes and times, from the command line.

use super::results::Mode;
use super::variant::{Method, SweepPoint, Variant, methods};
use crate::cli::{BenchArgs, Sweep};
use anyhow::{Result, bail};
use lightwell::render::Runs;
use lightwell::world::{CellSize, Clpv};
use lightwell_runtime::scene_path;

/// Scenes that a run without names measures: those that ship first.
const SCENES: [&str; 10] = [
    "cornell",
    "bleeding_gloss",
    "meeting_room",
    "night_court",
    "cathedral",
    "courtyard",
    "conference",
    "dabrovic",
    "sibenik",
    "sponza",
];
/// Steps of `--sweep steps`.
const SWEPT_STEPS: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// Factors on the cells of `--sweep grid`.
const SWEPT_GRIDS: [f32; 4] = [0.5, 1.0, 2.0, 4.0];
/// Frames in which flicker is measured in a whole run, and the largest image: a scene shall cost minutes, not hours.
const FLICKER: (u32, [u32; 2]) = (9, [128; 2]);
/// Frames averaged for an error, if not said.
const IMAGES: u32 = 16;
/// Samples a pixel of references, if not said.
const REFERENCE_SAMPLES: u32 = 1024;
/// Most cells along an axis.
const MOST_CELLS: u32 = 128;

/// The plan of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Scenes.
    pub scenes: Vec<String>,
    /// Whether a scene that cannot be loaded is left out rather than an error.
    pub lenient: bool,
    /// Variants of all scenes.
    pub variants: Vec<Variant>,
    /// Settings that are swept; the variants depend on the scene.
    pub sweeps: Vec<Sweep>,
    /// Sizes at which times are taken [pixels].
    pub time_sizes: Vec<[u32; 2]>,
    /// Size at which errors are taken [pixels].
    pub error_size: [u32; 2],
    /// Frames averaged for an error.
    pub aa: u32,
    /// Frames timed.
    pub frames: u32,
    /// Frames before those.
    pub warm_up: u32,
    /// Time after which a variant that was timed once is timed no more [ms].
    pub budget: f64,
    /// Times at which errors are taken [s]; none: from the scene's loop.
    pub times: Vec<f64>,
    /// Samples a pixel of the references.
    pub reference_spp: u32,
    /// Indirect bounces of the references.
    pub bounces: Vec<Option<u32>>,
    /// Frames of the measurement of flicker, and its image size [pixels].
    pub flicker: Option<(u32, [u32; 2])>,
    /// Whether paths a second are measured.
    pub throughput: bool,
    quick: bool,
}

/// One measurement of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// Times of all variants, round robin.
    Time {
        /// Image size [pixels].
        size: [u32; 2],
        /// The part of a frame that is computed.
        mode: Mode,
    },
    /// Errors of all variants at one time.
    Errors {
        /// Time [s].
        time: f64,
        /// Indirect bounces of the reference.
        bounces: Option<u32>,
    },
    /// Flicker of all variants.
    Flicker {
        /// Frames.
        frames: u32,
        /// Image size [pixels].
        size: [u32; 2],
    },
    /// Paths a second.
    Throughput,
}

impl Plan {
    /// Reads the command line.
    ///
    /// # Errors
    /// A method that does not exist, a variant that is none, or two of one name.
    pub fn of(args: &BenchArgs) -> Result<Self> {
        let or = |given: &[u32], full: &[u32], quick: &[u32]| {
            if given.is_empty() { if args.quick { quick } else { full }.to_vec() } else { given.to_vec() }
        };
        let quick = |quick: u32, full: u32| if args.quick { quick } else { full };
        let time_sizes = match args.time_size.is_empty() {
            false => args.time_size.clone(),
            true if args.quick => vec![[512; 2]],
            true => vec![[512; 2], [1024; 2]],
        };
        let scenes = match args.scenes.is_empty() {
            true if !args.growth.is_empty() => Vec::new(),
            true => SCENES.iter().filter(|scene| scene_path::find(scene).is_ok()).map(|s| (*s).to_owned()).collect(),
            false => args.scenes.clone(),
        };
        let error_size = args.error_size.unwrap_or([quick(128, 256); 2]);
        let flicker = args.flicker.unwrap_or(quick(0, FLICKER.0));
        Ok(Self {
            scenes,
            lenient: args.scenes.is_empty(),
            variants: variants(args, &or(&args.spp, &[1, 4, 16, 64, 256], &[1, 4, 16]))?,
            sweeps: args.sweep.clone(),
            time_sizes,
            error_size,
            aa: args.aa.unwrap_or(IMAGES),
            frames: args.frames.unwrap_or(quick(7, 20)),
            warm_up: args.warm_up,
            budget: if args.quick { 4e3 } else { 6e4 },
            times: args.times.clone(),
            reference_spp: args.reference_spp.unwrap_or(REFERENCE_SAMPLES),
            bounces: if args.bounces.is_empty() { vec![None] } else { args.bounces.iter().map(|b| b.0).collect() },
            flicker: (flicker > 0).then(|| (flicker, [0, 1].map(|i| error_size[i].min(FLICKER.1[i])))),
            throughput: args.throughput,
            quick: args.quick,
        })
    }

    /// Times at which errors are taken in a scene whose animation is so long [s], on whole frames of its clock.
    pub fn times_of(&self, duration: Option<f32>, frame_rate: u32) -> Vec<f64> {
        if !self.times.is_empty() {
            return self.times.clone();
        }
        let Some(duration) = duration.map(f64::from).filter(|duration| *duration > 0.0) else { return vec![0.0] };
        let rate = f64::from(frame_rate.max(1));
        let at = |share: f64| (share * duration * rate).round() / rate;
        if self.quick { vec![at(1.0 / 3.0)] } else { vec![0.0, at(1.0 / 3.0), at(2.0 / 3.0)] }
    }

    /// All measurements of a scene.
    pub fn tasks(&self, times: &[f64]) -> Vec<Task> {
        let mut tasks = Vec::new();
        for &bounces in &self.bounces {
            tasks.extend(times.iter().map(|&time| Task::Errors { time, bounces }));
        }
        for &size in &self.time_sizes {
            tasks.push(Task::Time { size, mode: Mode::Full });
            tasks.extend((!self.quick).then_some(Task::Time { size, mode: Mode::Animated }));
        }
        // What the errors' images cost beyond their first.
        let first = self.time_sizes.first().filter(|_| self.aa > 1);
        tasks.extend(first.map(|&size| Task::Time { size, mode: Mode::Shifted }));
        tasks.extend(self.flicker.map(|(frames, size)| Task::Flicker { frames, size }));
        tasks.extend(self.throughput.then_some(Task::Throughput));
        tasks
    }

    /// The variants of a scene with that light volume: those of all scenes, and the points of the sweeps.
    pub fn variants_of(&self, clpv: Option<&Clpv>) -> Vec<Variant> {
        let mut variants = self.variants.clone();
        if let Some(clpv) = clpv {
            variants.extend(self.sweeps.iter().flat_map(|sweep| points(*sweep, clpv)));
        }
        variants
    }

    /// The settings in words.
    pub fn in_words(&self) -> String {
        let size = |[width, height]: [u32; 2]| format!("{width}×{height}");
        let sizes: Vec<String> = self.time_sizes.iter().map(|&s| size(s)).collect();
        format!(
            "times at {} over {} frames after {} to warm up; errors at {} with {} frames averaged, against {} samples a pixel",
            sizes.join(" and "),
            self.frames,
            self.warm_up,
            size(self.error_size),
            self.aa,
            self.reference_spp,
        ) + &self
            .flicker
            .map_or(String::new(), |(frames, at)| format!("; flicker at {} over {frames} frames", size(at)))
    }
}

/// The variants that the command line asks for, path tracing with so many samples each.
///
/// # Errors
/// A method that does not exist, a variant that is none, or two of one name.
pub fn variants(args: &BenchArgs, spp: &[u32]) -> Result<Vec<Variant>> {
    let mut variants = Vec::new();
    for name in &args.method {
        if !methods().iter().any(|(_, preset)| preset.name == name) {
            let known: Vec<&str> = methods().iter().map(|(_, preset)| preset.name).collect();
            bail!("there is no method `{name}`; there are {}", known.join(", "));
        }
    }
    let wanted = |(_, preset): &Method| match args.method.is_empty() {
        true => preset.runs == Runs::Always || (preset.runs == Runs::Thorough && !args.quick),
        false => args.method.iter().any(|wanted| wanted == preset.name),
    };
    for method in methods().into_iter().filter(wanted) {
        let variant = Variant::of(method);
        if variant.is_traced() {
            variants.extend(spp.iter().map(|&spp| Variant::path_tracing(spp.max(1))));
        } else {
            variants.push(variant);
        }
    }
    for text in &args.variant {
        variants.push(Variant::parse(text)?);
    }
    for (index, variant) in variants.iter().enumerate() {
        if variants[..index].iter().any(|other| other.name == variant.name) {
            bail!("there are two variants `{}`; give each a name of its own", variant.name);
        }
    }
    Ok(variants)
}

/// The points of a sweep around the scene's settings.
fn points(sweep: Sweep, clpv: &Clpv) -> Vec<Variant> {
    let point = |name: String, axis: &str, value: f64, sets: Vec<(String, String)>| {
        let what = sets.iter().map(|(path, value)| format!("{path}={value}")).collect::<Vec<_>>().join(", ");
        let sweep = Some(SweepPoint { axis: axis.to_owned(), value });
        let diffusion = [("clpv.transport".to_owned(), "Diffusion".to_owned())];
        let sets = diffusion.into_iter().chain(sets).collect();
        Variant { what, sweep, ..Variant::new(&name, lightwell::render::GiMethod::CLPV, sets) }
    };
    let set = |field: &str, value: String| (format!("clpv.{field}"), value);
    match sweep {
        Sweep::Steps => SWEPT_STEPS
            .iter()
            .map(|&n| point(format!("{n} steps"), "steps", f64::from(n), vec![set("steps", n.to_string())]))
            .collect(),
        Sweep::Grid => {
            let mut points = Vec::new();
            for factor in SWEPT_GRIDS {
                let [x, y, z] = clpv.cells.map(|n| ((n as f32 * factor).round() as u32).max(1));
                if x.max(y).max(z) > MOST_CELLS {
                    continue;
                }
                let mut sets = vec![set("cells", format!("({x}, {y}, {z})"))];
                if let CellSize::Meters(size) = clpv.cell_size {
                    sets.push(set("cell_size", format!("Meters({})", size / factor)));
                }
                points.push(point(format!("{x}×{y}×{z} cells"), "grid", f64::from(x.max(y).max(z)), sets));
            }
            points
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cli::BenchLine;
    use clap::Parser;

    fn args(more: &[&str]) -> BenchArgs {
        let base = ["bench", "cornell", "-o", "x"];
        BenchLine::try_parse_from(base.iter().chain(more)).unwrap().args
    }

    fn names(plan: &Plan) -> Vec<String> {
        plan.variants.iter().map(|variant| variant.name.clone()).collect()
    }

    #[test]
    fn the_whole_plan() {
        let plan = Plan::of(&args(&[])).unwrap();
        let traced = [1, 4, 16, 64, 256].map(|spp| format!("path tracing {spp} spp"));
        let sweeps = [
            "none",
            "clpv",
            "sweep low",
            "sweep medium",
            "sweep high",
            "sweep ultra",
            "gather medium",
            "gather high",
            "gather ultra",
            "filtered paths 1 spp",
            "filtered paths 4 spp",
        ];
        let sweeps = sweeps.map(str::to_owned);
        let culled = ["slc coarse", "slc", "slc fine", "slc no visibility"].map(str::to_owned);
        let radiosity = [64, 256, 1024, 4096].map(|particles| format!("vpl {particles}"));
        assert_eq!(names(&plan), [&sweeps[..], &radiosity, &culled, &traced].concat());
        assert_eq!(plan.times_of(Some(6.0), 30), [0.0, 2.0, 4.0]);
        assert_eq!(plan.times_of(None, 30), [0.0]);
        let tasks = plan.tasks(&[0.0, 2.0]);
        assert_eq!(tasks[0], Task::Errors { time: 0.0, bounces: None });
        let modes = [Mode::Full, Mode::Animated];
        let times = [512, 1024].map(|edge| modes.map(|mode| Task::Time { size: [edge; 2], mode }));
        assert_eq!(tasks[2..6], times.concat());
        let shifted = Task::Time { size: [512; 2], mode: Mode::Shifted };
        assert_eq!(tasks[6..], [shifted.clone(), Task::Flicker { frames: 9, size: [128; 2] }]);
        let without = Plan::of(&args(&["--flicker", "0"])).unwrap();
        assert_eq!(without.tasks(&[0.0, 2.0]), tasks[..7]);
        let single = Plan::of(&args(&["--aa", "1"])).unwrap();
        assert!(!single.tasks(&[0.0]).contains(&shifted));
    }

    #[test]
    fn the_quick_plan_is_small_and_may_be_changed() {
        let plan = Plan::of(&args(&["--quick"])).unwrap();
        assert_eq!((plan.error_size, plan.time_sizes.len()), ([128; 2], 1));
        assert!(!names(&plan).contains(&"sweep ultra".to_owned()));
        assert_eq!(plan.times_of(Some(6.0), 30), [2.0]);
        let more =
            ["--quick", "--method", "clpv", "--variant", "long: clpv.steps=64", "--times", "0,1", "--flicker", "4"];
        let plan = Plan::of(&args(&more)).unwrap();
        assert_eq!(names(&plan), ["clpv", "long"]);
        assert_eq!(plan.times_of(Some(6.0), 30), [0.0, 1.0]);
        assert!(plan.tasks(&[0.0]).contains(&Task::Flicker { frames: 4, size: [128; 2] }));
        assert_eq!(Plan::of(&args(&["--quick"])).unwrap().flicker, None);
        let plan = Plan::of(&args(&["--bounces", "inf,1"])).unwrap();
        assert_eq!(plan.bounces, [None, Some(1)]);
    }

    #[test]
    fn sweeps_follow_the_scene() {
        let plan = Plan::of(&args(&["--method", "none", "--sweep", "grid", "--sweep", "steps"])).unwrap();
        let clpv = Clpv { cells: [8, 8, 7], cell_size: CellSize::Meters(0.3), ..Clpv::default() };
        let variants = plan.variants_of(Some(&clpv));
        assert_eq!(variants.len(), 1 + SWEPT_GRIDS.len() + SWEPT_STEPS.len());
        let fine = variants.iter().find(|variant| variant.name == "16×16×14 cells").unwrap();
        let sets =
            [("clpv.transport", "Diffusion"), ("clpv.cells", "(16, 16, 14)"), ("clpv.cell_size", "Meters(0.15)")];
        assert_eq!(fine.sets, sets.map(|(path, value)| (path.to_owned(), value.to_owned())));
        assert_eq!(plan.variants_of(None).len(), 1);
    }

    #[test]
    fn mistakes_are_named() {
        for (more, what) in [
            (&["--method", "magic"][..], "magic"),
            (&["--variant", "clpv: clpv.steps=1"], "two variants"),
            (&["--variant", "no name"], "NAME"),
        ] {
            let message = format!("{:#}", Plan::of(&args(more)).unwrap_err());
            assert!(message.contains(what), "{message}");
        }
    }
}
