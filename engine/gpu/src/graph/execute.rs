//! Executing a plan: memory, then each pass with its debug group and timestamps, then the report.

use std::cell::{OnceCell, RefCell};
use std::time::Instant;

use super::cache::{Target, TargetCache};
use super::context::{PassContext, Recorder, Resources};
use super::desc::ResourceDesc;
use super::error::{GraphError, PassError};
use super::handle::Version;
use super::plan::{Layout, Place, Plan, Step};
use super::report::{FrameReport, PassState};
use crate::gpu::Gpu;

impl Plan<'_> {
    /// Runs the passes and submits their work.
    ///
    /// # Errors
    /// If a pass fails, those before it have been submitted and stay in the cache; what the failed
    /// pass writes is invalid, and the passes after it do not run. If the device refuses something,
    /// everything that the frame wrote is let go.
    pub fn execute(self, gpu: &Gpu, cache: &mut TargetCache) -> Result<FrameReport, GraphError> {
        if self.stamp != cache.stamp() {
            return Err(GraphError::StalePlan);
        }
        let written = self.written_slots();
        let pacing = cache.pacing.clone();
        let mut recorder = Recorder::new(gpu, cache.timer.begin(gpu, self.steps.len()), pacing);
        recorder.costs = std::mem::take(&mut cache.costs);
        gpu.audit.set(cache.audit.is_some());
        let result = check(gpu, "a frame", || self.run(gpu, cache, &mut recorder)).and_then(|result| result);
        gpu.audit.set(false);
        cache.end_frame();
        gpu.end_frame(cache.figures().evicted > 0);
        let times = cache.timer.end(gpu, recorder.queries.take());
        cache.costs = std::mem::take(&mut recorder.costs);
        for (name, ms) in &times {
            ms.iter().for_each(|ms| cache.costs.measure(name, *ms));
        }
        if matches!(result, Err(GraphError::Device { .. })) {
            cache.drop_frame(&written);
        }
        let mut report = result?;
        for (name, ms) in times {
            if let Some(pass) = report.passes.iter_mut().find(|pass| pass.name == name && pass.state == PassState::Ran)
            {
                pass.gpu_ms = ms;
            }
        }
        report.cache = cache.figures();
        report.allocated_bytes = report.cache.retained_bytes + report.cache.pooled_bytes;
        report.submits = recorder.submits;
        Ok(report)
    }

    fn run(
        mut self,
        gpu: &Gpu,
        cache: &mut TargetCache,
        recorder: &mut Recorder<'_>,
    ) -> Result<FrameReport, GraphError> {
        let targets = check(gpu, "the memory of a frame", || self.place(gpu, cache))?;
        let resources = self.layout.reports();
        let steps = std::mem::take(&mut self.steps);
        let pacing = cache.pacing.clone();
        pacing.iter().for_each(|pacing| pacing.begin(steps.len()));
        for step in steps {
            if pacing.as_ref().is_some_and(|pacing| pacing.is_stopped()) {
                recorder.submit_last();
                return Err(GraphError::Stopped);
            }
            if let Err(error) = self.run_step(step, &targets, cache, recorder) {
                // The cache counts on the work that earlier passes recorded: it must be submitted.
                recorder.submit_last();
                return Err(error);
            }
            recorder.pause();
        }
        recorder.submit_last();
        Ok(FrameReport { passes: self.reports, resources, ..Default::default() })
    }

    fn run_step(
        &mut self,
        step: Step<'_>,
        targets: &[Option<Target>],
        cache: &mut TargetCache,
        recorder: &mut Recorder<'_>,
    ) -> Result<(), GraphError> {
        let Step { pass, name, reads, writes, recipe, work } = step;
        let slots = || writes.iter().filter(|write| write.retained);
        slots().for_each(|write| cache.begin_write(&self.layout.resources[write.from.resource].name));
        let start = Instant::now();
        let timed = recorder.begin(&name);
        let declared: Vec<Version> =
            reads.into_iter().chain(writes.iter().flat_map(|write| [write.from, write.from.next()])).collect();
        let resources = Resources {
            graph: self.graph,
            layout: &self.layout,
            targets,
            declared: &declared,
            stand_in: OnceCell::new(),
            misused: RefCell::new(None),
        };
        let gpu = recorder.gpu;
        let mut context = PassContext::new(recorder, &name, resources);
        gpu.audit.take();
        let result = work(&mut context);
        let (counts, undeclared) = context.finish();
        recorder.end(timed);
        let report = &mut self.reports[pass];
        report.counts = counts;
        report.cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        let misused = undeclared.map_or(Ok(()), |resource| Err(PassError::Undeclared { resource }));
        match misused.and(result) {
            Ok(()) => {}
            Err(PassError::Stopped) => return Err(GraphError::Stopped),
            Err(reason) => return Err(GraphError::Pass { pass: name, reason }),
        }
        if let Some(audited) = &mut cache.audit {
            audited.check(&recipe, gpu.audit.take())?;
        }
        for write in slots() {
            cache.end_write(
                &self.layout.resources[write.from.resource].name,
                write.from.number + 1,
                write.key,
                &recipe,
            );
        }
        Ok(())
    }

    fn place(&mut self, gpu: &Gpu, cache: &mut TargetCache) -> Vec<Option<Target>> {
        let mut targets = cache.begin_frame(&self.layout, &mut |desc, label| make(gpu, desc, label));
        for (resource, target) in self.layout.resources.iter_mut().zip(&mut targets) {
            if let Place::Imported(imported) = &mut resource.place {
                *target = imported.take();
            }
        }
        targets
    }

    fn written_slots(&self) -> Vec<String> {
        let Layout { resources, .. } = &self.layout;
        let written = resources.iter().filter(|resource| matches!(resource.place, Place::Slot { written: true }));
        written.map(|resource| resource.name.clone()).collect()
    }
}

/// Does something with the device and turns what it refuses into an error.
fn check<T>(gpu: &Gpu, place: &str, work: impl FnOnce() -> T) -> Result<T, GraphError> {
    let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let value = work();
    let refused = pollster::block_on(validation.pop());
    let refused = pollster::block_on(memory.pop()).or(refused);
    match refused {
        Some(error) => Err(GraphError::Device { place: place.into(), message: error.to_string() }),
        None => Ok(value),
    }
}

fn make(gpu: &Gpu, desc: &ResourceDesc, label: &str) -> Target {
    match desc {
        ResourceDesc::Texture(desc) => {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: desc.extent(),
                mip_level_count: desc.mips,
                sample_count: 1,
                dimension: desc.dimension,
                format: desc.format,
                usage: desc.usage,
                view_formats: &[],
            });
            Target::of_texture(texture, desc.view)
        }
        ResourceDesc::Buffer(desc) => Target::Buffer(gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: desc.size,
            usage: desc.usage,
            mapped_at_creation: false,
        })),
    }
}
