//! The context of a running pass: its declared resources, an encoder and its counts.

use std::cell::{OnceCell, RefCell};

use super::cache::Target;
use super::cost::{Costs, SUBMIT_MS};
use super::error::PassError;
use super::frame_pacing::{FramePacing, LONG_PASS, Submitted};
use super::handle::{Buffer, Handle, Texture, Version};
use super::plan::Layout;
use super::report::Counts;
use crate::gpu::{BindError, Binding, ComputeKey, Gpu, Pipeline, TimestampQueries};
use std::sync::Arc;

/// Time of a submit above which nothing is submitted behind it \[ms\].
const LONG_SUBMIT: f64 = 2.0 * LONG_PASS;

/// Records the passes of a frame into one encoder, or several where passes submit in between.
pub(super) struct Recorder<'g> {
    pub(super) gpu: &'g Gpu,
    encoder: wgpu::CommandEncoder,
    pub queries: Option<TimestampQueries>,
    pub submits: u64,
    pub costs: Costs,
    /// Time that what is recorded since the last submit is going to take, as far as it is known \[ms\].
    spent: f64,
    pacing: Option<Arc<FramePacing>>,
    /// The last submit of an interruptible frame.
    flying: Option<Submitted>,
}

impl<'g> Recorder<'g> {
    pub fn new(gpu: &'g Gpu, queries: Option<TimestampQueries>, pacing: Option<Arc<FramePacing>>) -> Self {
        let (encoder, costs) = (new_encoder(gpu), Costs::default());
        Self { gpu, encoder, queries, submits: 0, costs, spent: 0.0, pacing, flying: None }
    }

    /// Begins a pass, in a submit of its own if that is full; true if it is timed.
    pub fn begin(&mut self, name: &str) -> bool {
        let (most, unknown) = match self.pacing.as_deref() {
            Some(pacing) if pacing.is_interruptible() => (LONG_PASS, LONG_PASS),
            _ if self.gpu.is_software() => (f64::MAX, 0.0),
            _ => (SUBMIT_MS, 0.0),
        };
        let cost = self.costs.ms(name).unwrap_or(unknown);
        if Costs::is_full(self.spent, cost, most) {
            self.submit();
        }
        self.spent += cost;
        self.encoder.push_debug_group(name);
        let encoder = &mut self.encoder;
        self.queries.as_mut().is_some_and(|queries| queries.begin(encoder, name))
    }

    pub fn end(&mut self, timed: bool) {
        if let Some(queries) = self.queries.as_mut().filter(|_| timed) {
            queries.end(&mut self.encoder);
        }
        self.encoder.pop_debug_group();
    }

    /// Between passes: takes note of progress.
    pub fn pause(&mut self) {
        self.pacing.iter().for_each(|pacing| pacing.step());
    }

    /// Submits what was recorded so far. An interruptible frame waits for the submit before this one, so that the device has
    /// work while the next passes are recorded, and others wait for two short submits at most. It waits for a long one itself.
    fn submit(&mut self) {
        let recorded = std::mem::replace(&mut self.encoder, new_encoder(self.gpu));
        self.gpu.submit(Some(recorded));
        self.submits += 1;
        let spent = std::mem::take(&mut self.spent);
        if self.pacing.as_deref().is_some_and(FramePacing::is_interruptible) {
            let now = Submitted::note(self.gpu);
            let awaited = if spent > LONG_SUBMIT { Some(now) } else { self.flying.replace(now) };
            awaited.into_iter().for_each(|awaited| awaited.wait(self.gpu));
        }
    }

    /// Submits what is left, between passes.
    pub fn submit_last(&mut self) {
        if let Some(queries) = &self.queries {
            queries.resolve(&mut self.encoder);
        }
        let recorded = std::mem::replace(&mut self.encoder, new_encoder(self.gpu));
        self.gpu.submit(Some(recorded));
        self.submits += 1;
    }
}

/// Submits what was recorded, and waits for it where others are to have their turn.
fn submit(gpu: &Gpu, recorded: wgpu::CommandEncoder, pacing: Option<&FramePacing>) {
    gpu.submit(Some(recorded));
    if pacing.is_some_and(FramePacing::is_interruptible) {
        Submitted::note(gpu).wait(gpu);
    }
}

fn new_encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}

/// The context that a running pass gets.
pub struct PassContext<'c> {
    /// The device.
    pub gpu: &'c Gpu,
    encoder: &'c mut wgpu::CommandEncoder,
    /// The compute pass that consecutive dispatches share, while it is open.
    compute: Option<wgpu::ComputePass<'static>>,
    submits: &'c mut u64,
    costs: &'c mut Costs,
    /// Time of what is recorded before this pass and not submitted yet \[ms\].
    spent: &'c mut f64,
    pacing: Option<&'c FramePacing>,
    name: &'c str,
    counts: Counts,
    /// Work of this pass since the last submit, and all of it.
    work: [u64; 2],
    resources: Resources<'c>,
}

/// The resources that a pass may use.
pub(super) struct Resources<'c> {
    pub graph: u64,
    pub layout: &'c Layout,
    pub targets: &'c [Option<Target>],
    /// The versions that the pass reads, overwrites or makes.
    pub declared: &'c [Version],
    /// Stand-in for a resource that the pass has not declared: the pass fails in the end, but
    /// need not handle that at each use.
    pub stand_in: OnceCell<(wgpu::Texture, wgpu::Buffer)>,
    pub misused: RefCell<Option<String>>,
}

impl<'c> PassContext<'c> {
    pub(super) fn new(recorder: &'c mut Recorder<'_>, name: &'c str, resources: Resources<'c>) -> Self {
        let Recorder { gpu, encoder, submits, costs, spent, pacing, .. } = recorder;
        let (pacing, counts, work) = (pacing.as_deref(), Counts::default(), [0; 2]);
        Self { gpu, encoder, compute: None, submits, costs, spent, pacing, name, counts, work, resources }
    }

    /// Its counts, and the first resource that it used without having declared it.
    pub(super) fn finish(mut self) -> (Counts, Option<String>) {
        self.compute = None;
        if self.work[1] > 0 {
            self.costs.record(self.name, self.work[1]);
        }
        (self.counts, self.resources.misused.into_inner())
    }

    /// The encoder that the frame is recorded with, inside the debug group of this pass.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.compute = None;
        self.encoder
    }

    /// Begins a render pass.
    pub fn render_pass(&mut self, descriptor: &wgpu::RenderPassDescriptor) -> wgpu::RenderPass<'_> {
        self.compute = None;
        self.gpu.render_pass(self.encoder, descriptor)
    }

    /// The counts of this pass for the report: add to them.
    pub fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }

    /// How much work one submit of this pass may hold, in units of its own such as rays: on software drivers
    /// `on_software`, elsewhere what takes 50 ms by the times of earlier frames. Only work whose result does not depend
    /// on the pieces may be cut by it.
    pub fn work_a_submit(&self, on_software: u64) -> u64 {
        self.costs.units_a_submit(self.name, self.gpu.is_software(), on_software)
    }

    /// Tells how much work is recorded next; what is recorded before it is submitted if one submit cannot hold both.
    /// `on_software` as for [`PassContext::work_a_submit`]. Long work calls it every now and then: a submit of more than
    /// about a second may cost the device.
    ///
    /// # Errors
    /// If the frame is not wanted any more. The pass then ends with this error, and its targets count as not written.
    pub fn work(&mut self, units: u64, on_software: u64) -> Result<(), PassError> {
        if self.pacing.is_some_and(FramePacing::is_stopped) {
            return Err(PassError::Stopped);
        }
        let [since, all] = self.work;
        if since > 0 && since.saturating_add(units) > self.work_a_submit(on_software) {
            self.submit();
        }
        self.work = [self.work[0].saturating_add(units), all.saturating_add(units)];
        Ok(())
    }

    /// Submits what is recorded so far and continues with a fresh encoder.
    pub fn submit(&mut self) {
        self.compute = None;
        self.encoder.pop_debug_group();
        let recorded = std::mem::replace(self.encoder, new_encoder(self.gpu));
        submit(self.gpu, recorded, self.pacing);
        *self.submits += 1;
        (*self.spent, self.work[0]) = (0.0, 0);
        self.encoder.push_debug_group(self.name);
    }

    /// The texture of a version that this pass has declared. For any other handle the pass fails
    /// when it returns, and this gives a stand-in of one texel.
    pub fn texture(&self, handle: Handle<Texture>) -> &wgpu::Texture {
        match self.resources.target(handle.graph, handle.at) {
            Some(Target::Texture(texture, _)) => texture,
            _ => &self.resources.stand_in(self.gpu).0,
        }
    }

    /// The default view of a texture, as for [`PassContext::texture`].
    pub fn view(&self, handle: Handle<Texture>) -> wgpu::TextureView {
        match self.resources.target(handle.graph, handle.at) {
            Some(Target::Texture(_, view)) => view.clone(),
            _ => self.resources.stand_in(self.gpu).0.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    /// The buffer of a version that this pass has declared, as for [`PassContext::texture`].
    pub fn buffer(&self, handle: Handle<Buffer>) -> &wgpu::Buffer {
        match self.resources.target(handle.graph, handle.at) {
            Some(Target::Buffer(buffer)) => buffer,
            _ => &self.resources.stand_in(self.gpu).1,
        }
    }

    /// Runs a compute shader over a number of workgroups, with group 0 bound by WGSL names.
    ///
    /// # Errors
    /// If the shader does not compile, or the bindings do not fit it.
    pub fn dispatch(
        &mut self,
        key: &ComputeKey,
        bindings: &[(&str, Binding)],
        groups: [u32; 3],
    ) -> Result<(), PassError> {
        self.dispatch_threads(key, bindings, &[], None, |_| Groups::Count(groups))
    }

    /// Like [`PassContext::dispatch`], with group 1 bound by `shared`, over workgroups counted here or in a buffer.
    ///
    /// # Errors
    /// Those of [`PassContext::dispatch`].
    pub fn dispatch_with<'g>(
        &mut self,
        key: &ComputeKey,
        bindings: &[(&str, Binding)],
        shared: &BindGroup,
        groups: impl Into<Groups<'g>>,
    ) -> Result<(), PassError> {
        self.dispatch_threads(key, bindings, &[], Some(shared), |_| groups.into())
    }

    /// As [`PassContext::dispatch`], with the number of workgroups by their size. Of the `common` bindings those are bound
    /// that the shader uses.
    pub(super) fn dispatch_threads<'g>(
        &mut self,
        key: &ComputeKey,
        bindings: &[(&str, Binding)],
        common: &[(&str, Binding)],
        shared: Option<&BindGroup>,
        groups: impl FnOnce([u32; 3]) -> Groups<'g>,
    ) -> Result<(), PassError> {
        let dispatch = Dispatch::new(self.gpu, key, bindings, common, shared)?;
        self.record(&dispatch, groups(dispatch.workgroup_size));
        Ok(())
    }

    /// Records a dispatch into the compute pass that the one before it has opened: the device is told to wait for what
    /// the one wrote only where the other touches it.
    fn record(&mut self, dispatch: &Dispatch, groups: Groups<'_>) {
        let (gpu, encoder) = (self.gpu, &mut *self.encoder);
        let pass = self.compute.get_or_insert_with(|| begin_compute_pass(gpu, encoder).forget_lifetime());
        dispatch.record(gpu, pass, groups);
        self.counts.dispatches += 1;
    }
}

/// The number of workgroups of a dispatch, along each axis.
#[derive(Clone, Copy, Debug)]
pub enum Groups<'b> {
    /// It is known when the dispatch is recorded.
    Count([u32; 3]),
    /// The device finds it in a buffer with the usage `INDIRECT`.
    Buffer {
        /// The buffer: three words.
        counts: &'b wgpu::Buffer,
        /// Where they begin \[bytes\].
        offset: u64,
        /// Their upper bound, which devices run that cannot read counts from a buffer.
        most: [u32; 3],
    },
}

impl From<[u32; 3]> for Groups<'_> {
    fn from(count: [u32; 3]) -> Self {
        Self::Count(count)
    }
}

/// Makes the bind group of a pipeline.
#[doc(hidden)]
pub type BindGroup<'a> = dyn Fn(&Gpu, &Pipeline) -> Result<wgpu::BindGroup, BindError> + 'a;

/// Records a dispatch outside of any pass: group 0 from the bindings, group 1 by `shared`.
///
/// # Errors
/// If the shader does not compile, or the bindings do not fit it.
#[doc(hidden)]
pub fn record_dispatch(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    key: &ComputeKey,
    bindings: &[(&str, Binding)],
    shared: Option<&BindGroup>,
    groups: [u32; 3],
) -> Result<(), PassError> {
    let dispatch = Dispatch::new(gpu, key, bindings, &[], shared)?;
    dispatch.record(gpu, &mut begin_compute_pass(gpu, encoder), Groups::Count(groups));
    Ok(())
}

fn begin_compute_pass<'e>(gpu: &Gpu, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::ComputePass<'e> {
    gpu.count(|counts| counts.compute_passes += 1);
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default())
}

/// A compute shader with all that it binds.
struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    workgroup_size: [u32; 3],
    own: wgpu::BindGroup,
    shared: Option<wgpu::BindGroup>,
}

impl Dispatch {
    fn new(
        gpu: &Gpu,
        key: &ComputeKey,
        bindings: &[(&str, Binding)],
        common: &[(&str, Binding)],
        shared: Option<&BindGroup>,
    ) -> Result<Self, PassError> {
        let pipeline = gpu.pipelines.compute(gpu, key)?;
        let used = common.iter().filter(|(name, _)| pipeline.declares(0, name));
        let own = pipeline.bind(gpu, 0, &bindings.iter().chain(used).copied().collect::<Vec<_>>())?;
        let shared = shared.map(|bind| bind(gpu, &pipeline)).transpose()?;
        let compute = pipeline.compute().cloned();
        let no_compute = || PassError::message(format!("`{}` in `{}` is not a compute shader", key.entry, key.shader));
        let workgroup_size = pipeline.workgroup_size();
        Ok(Self { pipeline: compute.ok_or_else(no_compute)?, workgroup_size, own, shared })
    }

    fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass, groups: Groups<'_>) {
        gpu.count(|counts| counts.dispatches += 1);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.own, &[]);
        if let Some(shared) = &self.shared {
            pass.set_bind_group(1, shared, &[]);
        }
        match groups {
            Groups::Buffer { counts, offset, .. } if gpu.dispatches_indirectly => {
                pass.dispatch_workgroups_indirect(counts, offset);
            }
            Groups::Count([x, y, z]) | Groups::Buffer { most: [x, y, z], .. } => pass.dispatch_workgroups(x, y, z),
        }
    }
}

impl Resources<'_> {
    fn target(&self, graph: u64, at: Version) -> Option<&Target> {
        let declared = graph == self.graph && self.declared.contains(&at);
        let target = self.targets.get(at.resource).filter(|_| declared).and_then(Option::as_ref);
        if target.is_none() {
            self.misused.borrow_mut().get_or_insert_with(|| self.describe(graph, at));
        }
        target
    }

    fn describe(&self, graph: u64, at: Version) -> String {
        match self.layout.resources.get(at.resource).filter(|_| graph == self.graph) {
            Some(resource) => format!("`{}` (version {})", resource.name, at.number),
            None => "a resource of another graph".into(),
        }
    }

    fn stand_in(&self, gpu: &Gpu) -> &(wgpu::Texture, wgpu::Buffer) {
        self.stand_in.get_or_init(|| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("stand-in"),
                size: wgpu::Extent3d::default(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            let descriptor =
                wgpu::BufferDescriptor { label: Some("stand-in"), size: 16, usage, mapped_at_creation: false };
            (texture, gpu.create_buffer(&descriptor))
        })
    }
}
