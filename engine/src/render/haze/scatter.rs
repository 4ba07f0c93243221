//! What media scatter towards the eye, slice by slice. See `haze/scatter.wgsl`.

use super::as_bindings;
use super::grid::Grid;
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError, Texture};
use crate::render::direct::lamps::{Bound, Lamps};
use crate::render::frame::{Frame, linear_groups};
use crate::render::indirect::light_volumes::Field;
use wgpu::BufferUsages;

/// Declares the pass; the result is light over density, and optical depth, by column and slice.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    depth: Handle<Texture>,
    grid: &Grid,
    lamps: Option<Lamps<'a>>,
    field: Option<Field>,
) -> Handle<Buffer> {
    let scattered = graph.buffer("haze, light by slice", BufferDesc::new(grid.bytes(), BufferUsages::STORAGE));
    let mut pass = graph.pass("haze scatter");
    pass.read(depth);
    lamps.iter().flat_map(Lamps::maps).for_each(|map| pass.read(map));
    field.iter().flat_map(Field::buffers).for_each(|&buffer| pass.read(buffer));
    let scattered = pass.write(scattered);
    pass.key(&(frame.media_key(), grid.key(), frame.view_key(), lamps.as_ref().map(Lamps::key)));
    pass.key(&field.as_ref().map(|field| (field.define(), frame.scene.revisions.clpv, frame.settings.gi)));
    let work = Work { frame: frame.clone(), depth, grid: *grid, lamps, field, scattered };
    pass.execute(move |cx| work.run(cx));
    scattered
}

struct Work<'a> {
    frame: Frame<'a>,
    depth: Handle<Texture>,
    grid: Grid,
    lamps: Option<Lamps<'a>>,
    field: Option<Field>,
    scattered: Handle<Buffer>,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        cx.counts().cells += u64::from(self.grid.cells());
        // Apart from the lights: together they are more than Mesa's software driver (22.3) compiles without a crash.
        let lamps = self.lamps.as_ref().filter(|lamps| !lamps.is_empty());
        if self.field.is_some() || lamps.is_none() {
            self.dispatch(cx, None, self.field.as_ref())?;
        }
        match lamps {
            Some(lamps) => lamps.dispatch(cx, |cx, lamps| self.dispatch(cx, Some(lamps), None)),
            None => Ok(()),
        }
    }

    /// Adds light from the lamps that are bound, or else from the field.
    fn dispatch(&self, cx: &mut PassContext, lamps: Option<Bound>, field: Option<&Field>) -> Result<(), PassError> {
        let mut buffers = vec![
            ("view", self.frame.view_uniform(cx.gpu)),
            ("haze", self.grid.uniform(cx.gpu)),
            ("scattered", cx.buffer(self.scattered).clone()),
        ];
        buffers.extend(self.frame.gpu_scene.media_binding(cx.gpu));
        let mut key = self.frame.gpu_scene.with_media(ComputeKey::new("haze/scatter.wgsl", "main"));
        if let Some(field) = field {
            key = key.def(field.define(), ShaderDef::Flag(true));
            // What surfaces look up by their normals is not asked for.
            buffers.extend(field.bindings(cx).into_iter().filter(|(name, _)| *name != "facing"));
        }
        if let Some(lamps) = &lamps {
            key = key.def("LIT", ShaderDef::Flag(true));
            key = lamps.define.into_iter().fold(key, |key, (name, value)| key.def(name, value));
        }
        if lamps.as_ref().is_some_and(|lamps| !lamps.is_first || self.field.is_some()) {
            key = key.def("MORE", ShaderDef::Flag(true));
        }
        let depth = cx.view(self.depth);
        let mut bindings = as_bindings(&buffers);
        bindings.push(("depth", Binding::Texture(&depth)));
        bindings.extend(lamps.into_iter().flat_map(|lamps| lamps.bindings));
        cx.dispatch(&key, &bindings, linear_groups(self.grid.cells()))
    }
}
