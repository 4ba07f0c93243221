//! A run: what is missing in the results is measured, scene by scene.

use super::fixture::{self, Fixture};
use super::plan::{Plan, Task};
use super::reference::{References, Wanted};
use super::results::{ErrorFigures, Flicker, Mode, Store, ThroughputFigures, Timing};
use super::{
    cliffs, error, flicker, growth, host, instant_radiosity, light_culling, machine, noise, report, response, rooms,
    thesis, timing, window,
};
use crate::cli::BenchArgs;
use anyhow::{Context, Result, bail};
use lightwell::gpu::Gpu;
use lightwell::render::reference::{TraceSettings, measure_throughput};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::Common;
use lightwell_runtime::progress;
use lightwell_runtime::progress::Bar;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Units of the bar for each million of pixels drawn, about as many as of paths traced.
const DRAWN: f64 = 0.6;
/// Size and samples of the measurement of paths a second.
const THROUGHPUT: ([u32; 2], u32, u32) = ([128, 128], 32, 5);

/// Takes the measurements that are missing, and writes results, report, plots and images; gives the report's path.
///
/// # Errors
/// If a scene cannot be loaded or drawn, or a file not be written.
pub fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    if let Some(count) = args.rooms {
        return rooms::run(args, count, common);
    }
    if args.thesis {
        return thesis::run(args, common);
    }
    if args.light_culling {
        return light_culling::run(args, common);
    }
    if args.instant_radiosity {
        return instant_radiosity::run(args, common);
    }
    if args.cliffs {
        return cliffs::run(args, common);
    }
    if args.noise {
        return noise::run(args, common);
    }
    if args.response {
        return response::run(args, common);
    }
    if args.window {
        return window::run(args, common);
    }
    let plan = Plan::of(args)?;
    if args.host {
        return host::run(args, &plan.scenes, plan.lenient, common);
    }
    let gpu = fixture::open_gpu(common)?;
    let header = machine::header(&gpu, plan.in_words())?;
    let mut store = Store::open(&args.output, header, args.fresh)?;
    let stored = References::stored_folder();
    if args.bless && stored.is_none() {
        bail!("--bless stores references in tests/references/bench, and there is no such folder here or above");
    }
    let references = References { cache: args.cache.clone(), stored, bless: args.bless };
    let bar = progress::bar(1000, "bench");
    let mut run = Run { plan, references, folder: args.output.clone(), camera: args.camera.clone(), bar, units: 0.0 };
    let scenes = run.plan.scenes.clone();
    for (index, scene) in scenes.iter().enumerate() {
        let left = scenes.len() - index - 1;
        match Fixture::open(gpu.clone(), scene, args.camera.as_deref(), common) {
            Ok(fixture) => run.scene(fixture, &gpu, &mut store, left).with_context(|| format!("scene `{scene}`"))?,
            Err(error) if run.plan.lenient => store.note(format!("`{scene}` was left out: {error:#}")),
            Err(error) => return Err(error),
        }
        report::write(&run.folder, &store.results)?;
    }
    if !args.growth.is_empty() {
        let folder = run.folder.join("growth");
        let course = growth::Course { gpu: &gpu, common, folder, frames: run.plan.frames, quick: args.quick };
        growth::run(&args.growth, &course, &mut store, &run.bar)?;
    }
    run.bar.finish_and_clear();
    store.save()?;
    report::write(&run.folder, &store.results)
}

struct Run {
    plan: Plan,
    references: References,
    folder: PathBuf,
    camera: Option<String>,
    bar: Bar,
    /// Work done and work known so far.
    units: f64,
}

impl Run {
    fn scene(&mut self, mut fixture: Fixture, gpu: &Arc<Gpu>, store: &mut Store, scenes_left: usize) -> Result<()> {
        let variants = self.plan.variants_of(fixture.clpv()?.as_ref());
        fixture.add(&variants)?;
        let (duration, rate) = fixture.clock();
        let tasks = self.plan.tasks(&self.plan.times_of(duration, rate));
        // Scenes to come are taken to be as much work as this one.
        let work: f64 = tasks.iter().map(|task| self.work(task, &fixture)).sum();
        self.bar.set_length((self.units + work * (scenes_left + 1) as f64).ceil() as u64);
        let begun = self.units;
        fixture.set_seconds(0.0);
        let results = &mut store.results;
        let figures = fixture.figures()?;
        results.scenes.retain(|scene| scene.name != figures.name);
        results.scenes.push(figures);
        for figures in fixture.variant_figures() {
            results.variants.retain(|known| (&known.name, &known.scene) != (&figures.name, &figures.scene));
            results.variants.push(figures);
        }
        let mut done = 0.0;
        for task in &tasks {
            self.task(task, &mut fixture, gpu, store)?;
            store.save()?;
            done += self.work(task, &fixture);
            self.units = begun + done;
            self.bar.set_position(self.units as u64);
        }
        Ok(())
    }

    /// How much work a task is, in millions of paths or so.
    fn work(&self, task: &Task, fixture: &Fixture) -> f64 {
        let millions = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height) * 1e-6;
        let all =
            |cost: &dyn Fn(&super::variant::Variant) -> f64| fixture.runners.iter().map(|(v, _)| cost(v)).sum::<f64>();
        match task {
            Task::Errors { .. } => {
                let image = |v: &super::variant::Variant| match v.is_traced() {
                    true => f64::from(v.spp),
                    false => 2.0 * DRAWN * f64::from(self.plan.aa),
                };
                millions(self.plan.error_size) * (f64::from(self.plan.reference_spp) + all(&image))
            }
            Task::Time { size, mode } => {
                let frames = self.plan.frames;
                let frame = |v: &super::variant::Variant| match v.is_traced() {
                    true if *mode == Mode::Full => f64::from(timing::rounds(v, frames) * v.spp),
                    true => 0.0,
                    false => DRAWN * f64::from(frames + self.plan.warm_up),
                };
                millions(*size) * all(&frame)
            }
            Task::Flicker { frames, size } => {
                let image = |v: &super::variant::Variant| match v.is_traced() {
                    true => f64::from(v.spp),
                    false => 2.0 * DRAWN * f64::from(1 + self.plan.aa),
                };
                let spp = f64::from(self.flicker_samples());
                millions(*size) * f64::from(*frames) * (spp + all(&image))
            }
            Task::Throughput => 2.0 * millions(THROUGHPUT.0) * f64::from(THROUGHPUT.1 * THROUGHPUT.2),
        }
    }

    fn task(&self, task: &Task, fixture: &mut Fixture, gpu: &Arc<Gpu>, store: &mut Store) -> Result<()> {
        match *task {
            Task::Errors { time, bounces } => self.errors(fixture, store, time, bounces),
            Task::Time { size, mode } => self.times(fixture, store, size, mode),
            Task::Flicker { frames, size } => self.flicker(fixture, store, frames, size),
            Task::Throughput => self.throughput(fixture, gpu, store),
        }
    }

    /// Says what is done, and moves the bar.
    fn says(&self, scene: &str, what: &str) {
        self.bar.set_message(format!("{scene}: {what}"));
    }

    fn errors(&self, fixture: &mut Fixture, store: &mut Store, time: f64, bounces: Option<u32>) -> Result<()> {
        let size = self.plan.error_size;
        let look = error::Look { time, size, aa: self.plan.aa, bounces };
        let scene = fixture.name();
        let mut missing = Vec::new();
        for index in 0..fixture.runners.len() {
            let what = format!("error {look:?} {} {:?}", self.plan.reference_spp, self.camera);
            let key = fixture.key(index, &[time], &what)?;
            if !store
                .results
                .errors
                .iter()
                .any(|error| error.key == key && pictures_exist(&self.folder, &error.pictures))
            {
                missing.push((index, key));
            }
        }
        if missing.is_empty() {
            return Ok(());
        }
        fixture.set_seconds(time);
        self.says(&scene, "reference");
        let wanted = Wanted { scene: &scene, time, size, bounces, samples: self.plan.reference_spp };
        let (begun, pixels) = (self.bar.position(), f64::from(size[0] * size[1]) * 1e-6);
        let found = self.references.get(fixture.tracer(), &wanted, &mut |done| {
            self.bar.set_position(begun + (f64::from(done) * pixels) as u64);
        })?;
        found.note.into_iter().for_each(|note| store.note(note));
        for (index, key) in missing {
            let name = fixture.runners[index].0.name.clone();
            self.says(&scene, &format!("error of {name}"));
            let figures = error::measure(fixture, index, &look, &found.estimate, &self.folder)?;
            let errors = &mut store.results.errors;
            errors.retain(|old| {
                (&old.scene, &old.variant, old.time, old.size, old.bounces) != (&scene, &name, time, size, bounces)
            });
            errors.push(ErrorFigures { key, ..figures });
            store.save()?;
        }
        Ok(())
    }

    fn times(&self, fixture: &mut Fixture, store: &mut Store, size: [u32; 2], mode: Mode) -> Result<()> {
        let scene = fixture.name();
        let course = timing::Course {
            size,
            mode,
            warm_up: self.plan.warm_up,
            aa: self.plan.aa,
            frames: self.plan.frames,
            budget: self.plan.budget,
        };
        // Path tracing keeps nothing from frame to frame, and its time grows with the pixels: once is enough.
        let once = mode == Mode::Full && Some(&size) == self.plan.time_sizes.first();
        let which: Vec<usize> =
            (0..fixture.runners.len()).filter(|&index| once || !fixture.runners[index].0.is_traced()).collect();
        let (_, rate) = fixture.clock();
        let last = f64::from(course.warm_up + course.frames) / f64::from(rate.max(1));
        let names: Vec<String> = which.iter().map(|&index| fixture.runners[index].0.identity()).collect();
        let mut keys = Vec::new();
        for &index in &which {
            // What stands beside it in the turns belongs to a measurement.
            keys.push(fixture.key(index, &[0.0, last], &format!("time {course:?} {names:?} {:?}", self.camera))?);
        }
        if keys.iter().all(|key| store.results.timings.iter().any(|timing| timing.key == *key)) {
            return Ok(());
        }
        let pixels = f64::from(size[0] * size[1]) * 1e-6;
        let (begun, mut done) = (self.bar.position(), 0.0);
        let measured = timing::measure(fixture, &which, &course, &mut |variant| {
            self.says(&scene, &format!("times at {}×{}", size[0], size[1]));
            done += pixels * if variant.is_traced() { f64::from(variant.spp) } else { DRAWN };
            self.bar.set_position(begun + done as u64);
        })?;
        let timings = &mut store.results.timings;
        for (timing, key) in measured.into_iter().zip(keys) {
            timings
                .retain(|old| (&old.scene, &old.variant, old.size, old.mode) != (&scene, &timing.variant, size, mode));
            timings.push(Timing { key, ..timing });
        }
        Ok(())
    }

    /// References of many frames are cheaper ones; their noise cancels.
    fn flicker_samples(&self) -> u32 {
        (self.plan.reference_spp / 8).max(2)
    }

    fn flicker(&self, fixture: &mut Fixture, store: &mut Store, frames: u32, size: [u32; 2]) -> Result<()> {
        let (duration, rate) = fixture.clock();
        // Nothing moves.
        let Some(duration) = duration.filter(|duration| *duration > 0.0) else { return Ok(()) };
        let scene = fixture.name();
        let samples = self.flicker_samples();
        // At a third of the loop, as errors are: what moves often rests at its ends.
        let first = (duration / 3.0 * rate as f32).round() as u32;
        let course = flicker::Course { size, first, frames, aa: self.plan.aa, samples };
        let seconds = |frame: u32| f64::from(frame) / f64::from(rate.max(1));
        let times = [seconds(first), seconds(first + frames)];
        let mut missing = Vec::new();
        for index in 0..fixture.runners.len() {
            let key = fixture.key(index, &times, &format!("flicker {course:?} {:?}", self.camera))?;
            let exists = |flicker: &Flicker| pictures_exist(&self.folder, flicker.picture.as_slice());
            if !store.results.flicker.iter().any(|flicker| flicker.key == key && exists(flicker)) {
                missing.push((index, key));
            }
        }
        if missing.is_empty() {
            return Ok(());
        }
        let which: Vec<usize> = missing.iter().map(|(index, _)| *index).collect();
        self.says(&scene, "flicker");
        let (references, folder) = (&self.references, &self.folder);
        let measured = flicker::measure(fixture, &which, &course, references, folder, &mut |_| self.bar.tick())?;
        for (flicker, (_, key)) in measured.into_iter().zip(missing) {
            let all = &mut store.results.flicker;
            all.retain(|old| (&old.scene, &old.variant) != (&scene, &flicker.variant));
            all.push(Flicker { key, ..flicker });
        }
        Ok(())
    }

    fn throughput(&self, fixture: &mut Fixture, gpu: &Arc<Gpu>, store: &mut Store) -> Result<()> {
        let scene = fixture.name();
        let key = fixture.key(0, &[0.0], &format!("throughput {THROUGHPUT:?}"))?;
        if store.results.throughput.iter().any(|throughput| throughput.key == key) {
            return Ok(());
        }
        self.says(&scene, "paths a second");
        fixture.set_seconds(0.0);
        let session = fixture.tracer();
        let (size, samples, rounds) = THROUGHPUT;
        let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
        let settings = TraceSettings::default();
        match measure_throughput(gpu, session.scene(), &view, &settings, samples, rounds)? {
            None => store.note(format!(
                "`{scene}`: paths a second are not compared; the host's tracer knows diffuse surfaces without textures only"
            )),
            Some(found) => {
                let all = &mut store.results.throughput;
                all.retain(|old| old.scene != scene);
                let (paths, threads, device, host) = (found.paths, found.threads, found.device, found.host);
                all.push(ThroughputFigures { key, scene, paths, threads, device, host });
            }
        }
        Ok(())
    }
}

fn pictures_exist(folder: &Path, pictures: &[String]) -> bool {
    pictures.iter().all(|picture| folder.join(picture).is_file())
}
