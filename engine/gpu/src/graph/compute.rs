//! Compute passes that name each input once: the content key, the bind groups, the workgroups and the counts follow from it.

use super::bindings::{Bound, Inputs, PassBindings, SharedGroup, bindings, bound};
use super::builder::Graph;
use super::context::{Groups, PassContext};
use super::error::PassError;
use super::handle::{Buffer, Handle, PassId};
use super::report::Counts;
use crate::gpu::{Binding, ComputeKey, Gpu, Pipeline, uniform_bytes};
use encase::ShaderType;
use encase::internal::WriteInto;
use std::ops::{Deref, DerefMut};

/// A compute pass that is being declared. Its [`PassBindings`] go into its content key.
///
/// A pass of one dispatch ends with one of `dispatch_…`. Others declare a [`step`](ComputeBuilder::step) for each dispatch,
/// in their order, and end with [`finish`](ComputeBuilder::finish).
pub struct ComputeBuilder<'g, 'a> {
    bindings: PassBindings<'g, 'a>,
    shader: ComputeKey,
    operations: Vec<Operation<'a>>,
    counts: Counts,
}

/// A part of a pass; they follow each other in order.
enum Operation<'a> {
    Clear(Handle<Buffer>),
    Copy([Handle<Buffer>; 2]),
    Dispatch(Box<Dispatch<'a>>),
}

/// A dispatch, or several that differ by a uniform and their workgroups alone.
struct Dispatch<'a> {
    shader: ComputeKey,
    inputs: Inputs<'a>,
    threads: Threads,
    /// The buffer that holds the number of workgroups.
    counted_in: Option<Handle<Buffer>>,
    work: Option<PieceWork>,
    pieces: Option<Pieces<'a>>,
}

/// How a dispatch is cut.
struct Pieces<'a> {
    work: PieceWork,
    /// Rows or items of a workgroup: pieces are whole ones.
    of_group: u32,
    name: &'static str,
    /// The uniforms of the dispatches of a piece.
    uniforms: Box<dyn Fn(Piece) -> Vec<Vec<u8>> + 'a>,
}

impl<'a> Graph<'a> {
    /// Starts the declaration of a compute pass. Its name is its debug label and its timer.
    ///
    /// ```ignore
    /// let mut pass = graph.compute("bloom up 2", ComputeKey::new("post/bloom.wgsl", "up_main"));
    /// pass.uniform("bloom", &BloomUniform { share });
    /// pass.read("finer", image);
    /// let result = pass.write("result", result);
    /// pass.dispatch_over(size);
    /// ```
    pub fn compute(&mut self, name: impl Into<String>, shader: ComputeKey) -> ComputeBuilder<'_, 'a> {
        let bindings = PassBindings::new(self.pass(name));
        ComputeBuilder { bindings, shader, operations: Vec::new(), counts: Counts::default() }
    }

    /// Declares a pass that fills a buffer with zeros; the result is that buffer.
    pub fn clear(&mut self, name: impl Into<String>, buffer: Handle<Buffer>) -> Handle<Buffer> {
        let mut pass = self.pass(name);
        let buffer = pass.write(buffer);
        pass.key(&());
        pass.execute(move |cx| {
            clear(cx, buffer);
            Ok(())
        });
        buffer
    }
}

impl<'g, 'a> Deref for ComputeBuilder<'g, 'a> {
    type Target = PassBindings<'g, 'a>;

    fn deref(&self) -> &Self::Target {
        &self.bindings
    }
}

impl DerefMut for ComputeBuilder<'_, '_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.bindings
    }
}

impl<'g, 'a> ComputeBuilder<'g, 'a> {
    /// Adds to what the pass counts besides texels and dispatches.
    pub fn count(&mut self, counts: Counts) {
        self.counts += counts;
    }

    /// Begins a dispatch of the pass's shader, at that entry point. All that was bound to the pass before is bound to it where
    /// the entry point uses it, and what is bound and defined from here on is this step's alone.
    pub fn step(&mut self, entry: &'static str) -> Step<'_, 'g, 'a> {
        let shader = ComputeKey { entry, ..self.shader.clone() };
        self.step_of(shader)
    }

    /// As [`ComputeBuilder::step`], with another shader.
    pub fn step_of(&mut self, mut shader: ComputeKey) -> Step<'_, 'g, 'a> {
        shader.defs.extend(self.bindings.defines.iter().cloned());
        let common = [self.bindings.inputs.len(), self.bindings.defines.len()];
        Step { pass: self, shader, common, work: None }
    }

    /// Fills a buffer that the pass writes with zeros, before the steps that follow.
    pub fn clear(&mut self, written: Handle<Buffer>) {
        let key = ("clear", self.bindings.pass.resource_name(written).map(str::to_owned));
        self.bindings.pass.key(&key);
        self.operations.push(Operation::Clear(written));
    }

    /// Copies a buffer into one that the pass writes, before the steps that follow.
    pub fn copy(&mut self, from: Handle<Buffer>, to: Handle<Buffer>) {
        self.bindings.read_unless_written(from);
        let key = ["copy", "to"].map(str::to_owned).into_iter().zip([from, to]);
        let key: Vec<_> =
            key.map(|(what, at)| (what, self.bindings.pass.resource_name(at).map(str::to_owned))).collect();
        self.bindings.pass.key(&key);
        self.operations.push(Operation::Copy([from, to]));
    }

    /// Ends the declaration: a thread for each texel of an image, which are counted.
    pub fn dispatch_over(self, size: [u32; 2]) -> PassId {
        self.dispatch(|step| step.over(size))
    }

    /// Ends the declaration: a thread for each cell of a volume.
    pub fn dispatch_over_volume(self, size: [u32; 3]) -> PassId {
        self.dispatch(|step| step.over_volume(size))
    }

    /// Ends the declaration: a thread for each of so many items, see [`Step::over_items`].
    pub fn dispatch_items(self, items: u32) -> PassId {
        self.dispatch(|step| step.over_items(items))
    }

    /// Ends the declaration: so many workgroups.
    pub fn dispatch_groups(self, groups: [u32; 3]) -> PassId {
        self.dispatch(|step| step.in_groups(groups))
    }

    /// Ends the declaration: a thread for each texel of an image, see [`Step::over_rows`].
    pub fn dispatch_rows<T: ShaderType + WriteInto>(
        self,
        size: [u32; 2],
        work: PieceWork,
        name: &'static str,
        uniform: impl Fn(Piece) -> T + 'a,
    ) -> PassId {
        self.dispatch(|step| step.over_rows(size, work, name, uniform))
    }

    /// Ends the declaration: a thread for each of so many items, see [`Step::over_pieces`].
    pub fn dispatch_pieces<T: ShaderType + WriteInto>(
        self,
        items: u32,
        work: PieceWork,
        name: &'static str,
        uniforms: impl Fn(Piece) -> Vec<T> + 'a,
    ) -> PassId {
        self.dispatch(|step| step.over_pieces(items, work, name, uniforms))
    }

    /// Ends the declaration of a pass of steps.
    pub fn finish(self) -> PassId {
        let Self { bindings: PassBindings { mut pass, inputs, shared, refusal, .. }, operations, counts, .. } = self;
        // A pass may have no step at all.
        pass.key(&operations.len());
        pass.execute(move |cx| {
            if let Some(why) = refusal {
                return Err(PassError::message(why));
            }
            *cx.counts() += counts;
            let common = bound(cx, inputs);
            let run = Run { common: bindings(&common), shared: shared.as_deref() };
            operations.into_iter().try_for_each(|operation| run.operation(cx, operation))
        })
    }

    /// One dispatch that all is bound to.
    fn dispatch(mut self, end: impl FnOnce(Step<'_, 'g, 'a>)) -> PassId {
        let shader = self.shader.clone();
        end(Step { pass: &mut self, shader, common: [0; 2], work: None });
        self.finish()
    }
}

/// A dispatch of a pass that is being declared; it binds as the pass does. It is dispatched by the method that ends it.
#[must_use = "a step is dispatched by the method that ends it"]
pub struct Step<'p, 'g, 'a> {
    pass: &'p mut ComputeBuilder<'g, 'a>,
    shader: ComputeKey,
    /// How many inputs and defines of the pass are not this step's alone.
    common: [usize; 2],
    work: Option<PieceWork>,
}

impl<'g, 'a> Deref for Step<'_, 'g, 'a> {
    type Target = ComputeBuilder<'g, 'a>;

    fn deref(&self) -> &Self::Target {
        self.pass
    }
}

impl DerefMut for Step<'_, '_, '_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        self.pass
    }
}

impl<'a> Step<'_, '_, 'a> {
    /// Says how much work it is, so that no submit takes too long, see [`PassContext::work`].
    pub fn work(&mut self, units: u64, on_software: u64) {
        self.work = Some(PieceWork { units, on_software });
    }

    /// A thread for each texel of an image, which are counted.
    pub fn over(self, [width, height]: [u32; 2]) {
        self.pass.counts.texels += u64::from(width) * u64::from(height);
        self.over_uncounted([width, height]);
    }

    /// A thread for each texel of an image that is none of the frame's.
    pub fn over_uncounted(self, [width, height]: [u32; 2]) {
        self.end(Threads::Image([width, height, 1]), None, None);
    }

    /// A thread for each cell of a volume.
    pub fn over_volume(self, size: [u32; 3]) {
        self.end(Threads::Image(size), None, None);
    }

    /// A thread for each of so many items, in rows of workgroups where one row would be over the limits of devices. The shader
    /// is to leave those past the last.
    pub fn over_items(self, items: u32) {
        self.end(Threads::Items(items), None, None);
    }

    /// So many workgroups.
    pub fn in_groups(self, groups: [u32; 3]) {
        self.end(Threads::Groups(groups), None, None);
    }

    /// As many workgroups as a buffer with the usage `INDIRECT` says, in three words from `offset` \[bytes\] on; at most
    /// `most`.
    pub fn in_groups_of(self, counts: Handle<Buffer>, offset: u64, most: [u32; 3]) {
        self.pass.bindings.read_unless_written(counts);
        let name = self.pass.bindings.pass.resource_name(counts).map(str::to_owned);
        self.pass.bindings.pass.key(&name);
        self.end(Threads::Counted { offset, most }, Some(counts), None);
    }

    /// A thread for each texel of an image, in as many submits of whole rows as their work takes. `uniform` is what the
    /// shader binds under that name for some rows.
    pub fn over_rows<T: ShaderType + WriteInto>(
        self,
        [width, height]: [u32; 2],
        work: PieceWork,
        name: &'static str,
        uniform: impl Fn(Piece) -> T + 'a,
    ) {
        self.pass.counts.texels += u64::from(width) * u64::from(height);
        let uniforms = Box::new(move |piece| vec![uniform_bytes(name, &uniform(piece))]);
        let pieces = Pieces { work, of_group: ROWS_OF_A_GROUP, name, uniforms };
        self.end(Threads::Image([width, height, 1]), None, Some(pieces));
    }

    /// A thread for each of so many items, in as many submits of whole workgroups as their work takes. There is a dispatch
    /// for each of the `uniforms` that the shader binds under that name for some items.
    pub fn over_pieces<T: ShaderType + WriteInto>(
        self,
        items: u32,
        work: PieceWork,
        name: &'static str,
        uniforms: impl Fn(Piece) -> Vec<T> + 'a,
    ) {
        let bytes = move |piece| uniforms(piece).iter().map(|uniform| uniform_bytes(name, uniform)).collect();
        let pieces = Pieces { work, of_group: ITEMS_OF_A_GROUP, name, uniforms: Box::new(bytes) };
        self.end(Threads::Items(items), None, Some(pieces));
    }

    fn end(self, threads: Threads, counted_in: Option<Handle<Buffer>>, pieces: Option<Pieces<'a>>) {
        let Self { pass, mut shader, common: [inputs, defines], work } = self;
        let inputs = pass.bindings.inputs.split_off(inputs);
        shader.defs.extend(pass.bindings.defines.drain(defines..));
        pass.bindings.pass.key(&(&shader, threads));
        if let Some(pieces) = &pieces {
            let whole = Piece { first: 0, count: threads.pieces_of() };
            pass.bindings.pass.key(&(pieces.name, (pieces.uniforms)(whole)));
        }
        let dispatch = Dispatch { shader, inputs, threads, counted_in, work, pieces };
        pass.operations.push(Operation::Dispatch(Box::new(dispatch)));
    }
}

/// The bindings that the dispatches of a pass have in common.
struct Run<'r, 'a> {
    common: Vec<(&'static str, Binding<'r>)>,
    shared: Option<&'r (dyn SharedGroup + 'a)>,
}

impl Run<'_, '_> {
    fn operation(&self, cx: &mut PassContext, operation: Operation) -> Result<(), PassError> {
        match operation {
            Operation::Clear(buffer) => clear(cx, buffer),
            Operation::Copy([from, to]) => {
                let [from, to] = [from, to].map(|handle| cx.buffer(handle).clone());
                cx.encoder().copy_buffer_to_buffer(&from, 0, &to, 0, from.size());
            }
            Operation::Dispatch(dispatch) => return self.dispatch(cx, *dispatch),
        }
        Ok(())
    }

    fn dispatch(&self, cx: &mut PassContext, dispatch: Dispatch) -> Result<(), PassError> {
        let Dispatch { shader, inputs, threads, counted_in, work, pieces } = dispatch;
        if let Some(PieceWork { units, on_software }) = work {
            cx.work(units, on_software)?;
        }
        let own = bound(cx, inputs);
        let own = bindings(&own);
        let Some(pieces) = pieces else {
            let counts = counted_in.map(|handle| cx.buffer(handle).clone());
            return self.record(cx, &shader, &own, |workgroup| threads.groups(workgroup, counts.as_ref()));
        };
        let work = pieces.work;
        for piece in work.pieces(cx, threads.pieces_of(), pieces.of_group) {
            cx.work(u64::from(piece.count) * work.units, work.on_software)?;
            let threads = threads.of_piece(piece.count);
            for uniform in (pieces.uniforms)(piece) {
                let uniform = Bound::uniform(cx.gpu, pieces.name, uniform);
                let all: Vec<_> = own.iter().copied().chain([(pieces.name, uniform.binding())]).collect();
                self.record(cx, &shader, &all, |workgroup| threads.groups(workgroup, None))?;
            }
        }
        Ok(())
    }

    fn record<'b>(
        &self,
        cx: &mut PassContext,
        shader: &ComputeKey,
        own: &[(&str, Binding)],
        groups: impl FnOnce([u32; 3]) -> Groups<'b>,
    ) -> Result<(), PassError> {
        match self.shared {
            Some(shared) => {
                let bind = |gpu: &Gpu, pipeline: &Pipeline| shared.bind(gpu, pipeline);
                cx.dispatch_threads(shader, own, &self.common, Some(&bind), groups)
            }
            None => cx.dispatch_threads(shader, own, &self.common, None, groups),
        }
    }
}

fn clear(cx: &mut PassContext, buffer: Handle<Buffer>) {
    let buffer = cx.buffer(buffer).clone();
    cx.encoder().clear_buffer(&buffer, 0, None);
}

/// Some rows of an image, or some of many items.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The first of them.
    pub first: u32,
    /// How many there are.
    pub count: u32,
}

/// How much work a row of an image or an item is, so that no submit takes too long.
#[derive(Clone, Copy, Debug)]
pub struct PieceWork {
    /// Units of work, such as rays, of a row or an item.
    pub units: u64,
    /// Units that a submit of a software driver may hold, see [`PassContext::work_a_submit`].
    pub on_software: u64,
}

/// Rows of a workgroup of images.
const ROWS_OF_A_GROUP: u32 = 8;
/// Items of a workgroup.
const ITEMS_OF_A_GROUP: u32 = 64;

impl PieceWork {
    fn pieces(self, cx: &PassContext, all: u32, of_group: u32) -> impl Iterator<Item = Piece> + use<> {
        let groups = cx.work_a_submit(self.on_software) / self.units.max(1) / u64::from(of_group);
        let step = groups.clamp(1, 1 << 16) as u32 * of_group;
        let piece = move |first| Piece { first, count: (all - first).min(step) };
        (0..all).step_by(step as usize).map(piece)
    }
}

/// How many threads a shader is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Threads {
    Image([u32; 3]),
    Items(u32),
    Groups([u32; 3]),
    /// The device finds the number of workgroups in a buffer.
    Counted {
        offset: u64,
        most: [u32; 3],
    },
}

/// Workgroups of one row of them.
const MOST_OF_A_ROW: u32 = 32_768;

impl Threads {
    /// Rows or items, which pieces are made of.
    fn pieces_of(self) -> u32 {
        match self {
            Self::Image([_, height, _]) => height,
            Self::Items(items) => items,
            Self::Groups(_) | Self::Counted { .. } => 1,
        }
    }

    fn of_piece(self, count: u32) -> Self {
        match self {
            Self::Image([width, _, depth]) => Self::Image([width, count, depth]),
            Self::Items(_) => Self::Items(count),
            whole => whole,
        }
    }

    fn groups(self, workgroup: [u32; 3], counts: Option<&wgpu::Buffer>) -> Groups<'_> {
        let count = match (self, counts) {
            (Self::Counted { offset, most }, Some(counts)) => return Groups::Buffer { counts, offset, most },
            (Self::Groups(groups) | Self::Counted { most: groups, .. }, _) => groups,
            (Self::Image(size), _) => std::array::from_fn(|axis| size[axis].div_ceil(workgroup[axis].max(1))),
            (Self::Items(items), _) => {
                let groups = items.div_ceil(workgroup.iter().product::<u32>().max(1)).max(1);
                let row = groups.min(MOST_OF_A_ROW);
                [row, groups.div_ceil(row), 1]
            }
        };
        Groups::Count(count)
    }
}
