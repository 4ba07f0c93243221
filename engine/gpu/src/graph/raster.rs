//! Raster passes that name each input once, as compute passes do.

use super::bindings::{Inputs, PassBindings, bindings, bound};
use super::builder::Graph;
use super::context::PassContext;
use super::desc::TextureDesc;
use super::error::PassError;
use super::handle::{Handle, PassId, Texture};
use super::report::Counts;
use crate::gpu::{Binding, RasterKey, ShaderDef};
use std::ops::{Deref, DerefMut};

/// Draws of things outside the graph, such as the objects of a scene.
pub trait Draws {
    /// Changes with what is drawn, and with how.
    fn key(&self) -> u64;

    /// Whether there is nothing to draw.
    fn is_empty(&self) -> bool;

    /// Draws into a render pass.
    ///
    /// # Errors
    /// If a shader does not compile, or the bindings do not fit it.
    fn draw(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        bound: &DrawBindings,
    ) -> Result<(), PassError>;
}

/// The bindings and defines of a pass for its draws.
pub struct DrawBindings<'r> {
    /// Group 0 of the pipelines, by the shader's names.
    pub group: Vec<(&'static str, Binding<'r>)>,
    /// Defines of the shaders.
    pub defines: Vec<(&'static str, ShaderDef)>,
}

/// The contents of a target before the first draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Contents {
    /// Zeros: transparent, or infinitely far in reversed depth.
    Cleared,
    /// The contents from before the pass.
    Kept,
}

impl Contents {
    fn load<V>(self, zero: V) -> wgpu::LoadOp<V> {
        match self {
            Self::Cleared => wgpu::LoadOp::Clear(zero),
            Self::Kept => wgpu::LoadOp::Load,
        }
    }
}

/// A raster pass that is being declared. Its [`PassBindings`] go into its content key, with its targets,
/// the pipelines and what is drawn.
///
/// It declares its targets, then a [`step`](RasterBuilder::step) for each render pass, and ends with
/// [`finish`](RasterBuilder::finish). A layer of the targets is cleared by the first step that draws into it.
pub struct RasterBuilder<'g, 'a> {
    bindings: PassBindings<'g, 'a>,
    targets: Targets,
    copies: Vec<[Handle<Texture>; 2]>,
    steps: Vec<Drawing<'a>>,
    counts: Counts,
}

/// The targets of a pass.
#[derive(Default)]
struct Targets {
    colors: Vec<(Handle<Texture>, Contents)>,
    /// The contents are `None` where depth is only tested against.
    depth: Option<(Handle<Texture>, Option<Contents>)>,
}

/// One render pass.
struct Drawing<'a> {
    /// The layer of the targets that is drawn into; `None`: the default view.
    layer: Option<u32>,
    is_first: bool,
    inputs: Inputs<'a>,
    draws: What<'a>,
}

enum What<'a> {
    Instances(Box<RasterKey>, Box<dyn FnOnce() -> [u32; 2] + 'a>),
    Draws(Box<dyn Draws + 'a>, Vec<(&'static str, ShaderDef)>),
}

impl<'a> Graph<'a> {
    /// Starts the declaration of a raster pass. Its name is its debug label and its timer.
    ///
    /// ```ignore
    /// let mut pass = graph.raster("outline");
    /// let display = pass.color(display, Contents::Kept);
    /// pass.read("mask", mask);
    /// pass.step().draw(pipeline, [3, 1]);
    /// pass.finish();
    /// ```
    pub fn raster(&mut self, name: impl Into<String>) -> RasterBuilder<'_, 'a> {
        let bindings = PassBindings::new(self.pass(name));
        RasterBuilder {
            bindings,
            targets: Targets::default(),
            copies: Vec::new(),
            steps: Vec::new(),
            counts: Counts::default(),
        }
    }
}

impl<'g, 'a> Deref for RasterBuilder<'g, 'a> {
    type Target = PassBindings<'g, 'a>;

    fn deref(&self) -> &Self::Target {
        &self.bindings
    }
}

impl DerefMut for RasterBuilder<'_, '_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.bindings
    }
}

impl<'g, 'a> RasterBuilder<'g, 'a> {
    /// Draws into a texture, the next output of fragment shaders, and returns its next version.
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn color(&mut self, handle: Handle<Texture>, contents: Contents) -> Handle<Texture> {
        self.bindings.pass.key(&("color", contents));
        let written = self.bindings.pass.write(handle);
        self.targets.colors.push((written, contents));
        written
    }

    /// Tests depth and stores it in a texture, and returns its next version.
    #[must_use = "later passes read the version that this returns; assign to `_` if there is none"]
    pub fn depth(&mut self, handle: Handle<Texture>, contents: Contents) -> Handle<Texture> {
        self.bindings.pass.key(&("depth", contents));
        let written = self.bindings.pass.write(handle);
        self.targets.depth = Some((written, Some(contents)));
        written
    }

    /// Tests depth against a texture that shaders may read too.
    pub fn test_depth(&mut self, handle: Handle<Texture>) {
        self.bindings.pass.key(&"tested depth");
        self.bindings.read_unless_written(handle);
        self.targets.depth = Some((handle, None));
    }

    /// Copies a texture into a target of the pass before anything is drawn.
    pub fn copy(&mut self, from: Handle<Texture>, to: Handle<Texture>) {
        self.bindings.pass.key(&"copy");
        self.bindings.read_unless_written(from);
        self.copies.push([from, to]);
    }

    /// Adds to what the pass counts besides draws and triangles.
    pub fn count(&mut self, counts: Counts) {
        self.counts += counts;
    }

    /// Begins a render pass into all targets. All that was bound to the pass before is bound to it too, and what is bound and
    /// defined from here on is this step's alone.
    pub fn step(&mut self) -> RasterStep<'_, 'g, 'a> {
        let common = [self.bindings.inputs.len(), self.bindings.defines.len()];
        RasterStep { pass: self, layer: None, common }
    }

    /// Ends the declaration.
    pub fn finish(self) -> PassId {
        let Self { bindings: PassBindings { mut pass, inputs, shared, refusal, .. }, targets, copies, steps, counts } =
            self;
        // Group 1 is that of materials.
        let refusal = refusal.or(shared.map(|_| "raster passes share no group"));
        pass.key(&steps.len());
        let label = pass.name().to_owned();
        pass.execute(move |cx| {
            if let Some(why) = refusal {
                return Err(PassError::message(why));
            }
            *cx.counts() += counts;
            copies.into_iter().for_each(|copied| copy(cx, copied));
            let common = bound(cx, inputs);
            let common = bindings(&common);
            steps.into_iter().try_for_each(|step| targets.draw(cx, &label, &common, step))
        })
    }
}

/// A render pass that is being declared; it binds as the pass does. It is drawn by the method that ends it.
#[must_use = "a step is drawn by the method that ends it"]
pub struct RasterStep<'p, 'g, 'a> {
    pass: &'p mut RasterBuilder<'g, 'a>,
    layer: Option<u32>,
    /// How many inputs and defines of the pass are not this step's alone.
    common: [usize; 2],
}

impl<'g, 'a> Deref for RasterStep<'_, 'g, 'a> {
    type Target = PassBindings<'g, 'a>;

    fn deref(&self) -> &Self::Target {
        self.pass
    }
}

impl DerefMut for RasterStep<'_, '_, '_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        self.pass
    }
}

impl<'a> RasterStep<'_, '_, 'a> {
    /// Draws into one layer of the targets, counted from 0.
    pub fn layer(&mut self, layer: u32) {
        self.layer = Some(layer);
    }

    /// Draws so many vertices of so many instances, with what is bound as group 0 and defined.
    pub fn draw(self, pipeline: RasterKey, counts: [u32; 2]) {
        self.draw_later(pipeline, &counts, move || counts);
    }

    /// As [`RasterStep::draw`], of vertices and instances that are counted when the pass runs: the same as long as `revision`
    /// is, or what the pass reads.
    pub fn draw_later(
        self,
        mut pipeline: RasterKey,
        revision: &impl std::hash::Hash,
        counts: impl FnOnce() -> [u32; 2] + 'a,
    ) {
        pipeline.defs.extend(self.pass.bindings.defines.iter().cloned());
        let revision = super::key::hash(revision);
        self.pass.bindings.pass.key(&(&pipeline, revision));
        self.end(What::Instances(Box::new(pipeline), Box::new(counts)));
    }

    /// Draws what lies outside the graph.
    pub fn draws(self, draws: impl Draws + 'a) {
        let defines = self.pass.bindings.defines.clone();
        self.pass.bindings.pass.key(&(draws.key(), &defines));
        self.end(What::Draws(Box::new(draws), defines));
    }

    fn end(self, draws: What<'a>) {
        let Self { pass, layer, common: [inputs, defines] } = self;
        pass.bindings.pass.key(&layer);
        let inputs = pass.bindings.inputs.split_off(inputs);
        pass.bindings.defines.truncate(defines);
        let is_first = pass.steps.iter().all(|step| step.layer != layer);
        pass.steps.push(Drawing { layer, is_first, inputs, draws });
    }
}

impl Targets {
    fn draw(
        &self,
        cx: &mut PassContext,
        label: &str,
        common: &[(&'static str, Binding)],
        step: Drawing,
    ) -> Result<(), PassError> {
        let contents = |contents: Contents| if step.is_first { contents } else { Contents::Kept };
        let is_cleared = |declared: Contents| contents(declared) == Contents::Cleared;
        let depth_is_cleared = matches!(self.depth, Some((_, Some(depth))) if is_cleared(depth));
        let is_cleared = depth_is_cleared || self.colors.iter().any(|(_, color)| is_cleared(*color));
        if matches!(&step.draws, What::Draws(draws, _) if draws.is_empty()) && !is_cleared {
            return Ok(());
        }
        let own = bound(cx, step.inputs);
        let group: Vec<_> = bindings(&own).into_iter().chain(common.iter().copied()).collect();
        let view = |handle: Handle<Texture>| match step.layer {
            None => cx.view(handle),
            Some(layer) => {
                let (texture, dimension) = (cx.texture(handle), wgpu::TextureViewDimension::D2);
                cx.gpu.view_of_layers(texture, dimension, layer..layer + 1)
            }
        };
        let store = wgpu::StoreOp::Store;
        let colors: Vec<_> =
            self.colors.iter().map(|(handle, declared)| (view(*handle), contents(*declared))).collect();
        let colors = colors.iter().map(|(view, contents)| {
            let ops = wgpu::Operations { load: contents.load(wgpu::Color::TRANSPARENT), store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        });
        let colors: Vec<_> = colors.collect();
        let depth = self.depth.map(|(handle, declared)| (view(handle), declared.map(contents)));
        let depth = depth.as_ref().map(|(view, contents)| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: contents.map(|contents| wgpu::Operations { load: contents.load(0.0), store }),
            stencil_ops: None,
        });
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &colors,
            depth_stencil_attachment: depth,
            ..Default::default()
        };
        let mut pass = cx.render_pass(&descriptor).forget_lifetime();
        match step.draws {
            What::Draws(draws, defines) => draws.draw(cx, &mut pass, &DrawBindings { group, defines }),
            What::Instances(pipeline, counts) => draw_instances(cx, &mut pass, &pipeline, &group, counts()),
        }
    }
}

fn draw_instances(
    cx: &mut PassContext,
    pass: &mut wgpu::RenderPass<'_>,
    key: &RasterKey,
    group: &[(&str, Binding)],
    [vertices, instances]: [u32; 2],
) -> Result<(), PassError> {
    if vertices == 0 || instances == 0 {
        return Ok(());
    }
    let pipeline = cx.gpu.pipelines.raster(cx.gpu, key)?;
    let no_raster = || PassError::message(format!("`{}` makes no raster pipeline", key.shader));
    let group = pipeline.bind(cx.gpu, 0, group)?;
    pass.set_pipeline(pipeline.raster().ok_or_else(no_raster)?);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..vertices, 0..instances);
    cx.counts().draws += 1;
    if key.primitive.topology == wgpu::PrimitiveTopology::TriangleList {
        cx.counts().triangles += u64::from(vertices / 3) * u64::from(instances);
    }
    Ok(())
}

fn copy(cx: &mut PassContext, copied: [Handle<Texture>; 2]) {
    let [from, to] = copied.map(|handle| cx.texture(handle).clone());
    cx.encoder().copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
    cx.counts().bytes += TextureDesc::of(&from).bytes();
}
