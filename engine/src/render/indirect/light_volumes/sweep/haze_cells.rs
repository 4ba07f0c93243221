//! All light in each cell, for media to scatter. See `indirect/light_volumes/sweep/haze_cells.wgsl`.

use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, PassBindings};
use crate::render::indirect::light_volumes::volume::Volume;
use wgpu::BufferUsages;

/// Light in cells that rays look up on their way through media: see `lib/haze_along.wgsl`.
#[derive(Clone, Copy)]
pub(crate) struct HazeCells {
    pub volume: Volume,
    pub light: Handle<Buffer>,
    /// Whether it is straight from the lights alone, and light that is scattered once more counts as if it went on.
    pub are_lamps_alone: bool,
}

impl HazeCells {
    fn defines(&self) -> impl Iterator<Item = (&'static str, ShaderDef)> {
        let alone = self.are_lamps_alone.then_some("LAMPS_ALONE");
        ["HAZE"].into_iter().chain(alone).map(|name| (name, ShaderDef::Flag(true)))
    }

    /// Binds it to a pass that looks it up.
    pub fn bind(&self, pass: &mut PassBindings) {
        self.defines().for_each(|(name, value)| pass.define(name, value));
        pass.uniform("haze_volume", &self.volume.uniform());
        pass.read("haze_cells", self.light);
    }
}

/// Declares the pass: the light of the lamps, and that of the sweep by axis.
pub(super) fn declare(
    graph: &mut Graph<'_>,
    volume: &Volume,
    lamp_light: Handle<Buffer>,
    axes: Handle<Buffer>,
) -> HazeCells {
    let desc = BufferDesc::new(32 * u64::from(volume.cell_count()), BufferUsages::STORAGE);
    let light = graph.retained_buffer("haze, all light in cells", desc);
    let shader = ComputeKey::new("indirect/light_volumes/sweep/haze_cells.wgsl", "main");
    let mut pass = graph.compute("haze cells", shader);
    pass.uniform("volume", &volume.uniform());
    pass.read("lamp_light", lamp_light);
    pass.read("axes", axes);
    let light = pass.write("haze_cells", light);
    pass.count(Counts { cells: volume.cell_count().into(), ..Counts::default() });
    pass.dispatch_items(volume.cell_count());
    let volume = *volume;
    HazeCells { volume, light, are_lamps_alone: false }
}
