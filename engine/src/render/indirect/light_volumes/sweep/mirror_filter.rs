//! The filter over mirror reflections and what is seen through rough glass, by how far their surfaces blur them. See
//! `indirect/light_volumes/sweep/mirror_filter.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, PassBindings, Texture};
use crate::render::direct::Region;
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::surfaces::Surfaces;
use encase::ShaderType;
use glam::UVec2;
use std::f32::consts::FRAC_1_SQRT_2;

/// Standard deviation of the filter over the GGX α of the lobe: both together are about a sixth wider than the lobe.
const WIDTH: f32 = 1.0;
/// The same for what is far brighter than all around it. The lobe itself shows nothing sharper.
const STRAY_WIDTH: f32 = 1.5;

/// `MirrorFilter` of `indirect/light_volumes/sweep/mirror_filter.wgsl`.
#[derive(ShaderType)]
pub(crate) struct MirrorFilterUniform {
    view: ViewUniform,
    origin: UVec2,
    size: UVec2,
    width: f32,
    stray_width: f32,
    turn: u32,
}

/// What is above its surroundings, and the rest.
#[derive(Clone, Copy)]
struct Parts {
    rest: Handle<Texture>,
    strays: Handle<Texture>,
}

/// Declares the passes over what mirrors reflect; the result is as the input, with less noise.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    mirrored: Handle<Texture>,
) -> Handle<Texture> {
    let inputs = vec![("normal", gbuffer.normal), ("object", gbuffer.object), ("depth", gbuffer.depth)];
    let [width, height] = frame.view.size;
    let region = Region { origin: UVec2::ZERO, size: UVec2::new(width, height) };
    let (width, of) = (width_of(frame), Of::Mirrors(gbuffer.surfaces));
    Filter { width, region, inputs, at_last: Vec::new(), of }.declare(graph, frame, mirrored)
}

/// What is seen of glass.
#[derive(Clone, Copy)]
pub(in crate::render) struct InGlass {
    /// Radiance \[W/(m² sr)\] that passes it and that it reflects, but for its glow, and how far off it is \[m\].
    pub seen: Handle<Texture>,
    /// Radiance that lights make of it themselves \[W/(m² sr)\].
    pub glow: Handle<Texture>,
    /// Where it is rough, see `lib/rough_glass.wgsl`.
    pub rough: Handle<Texture>,
}

/// The same over what is seen through glass and in it, with the glow in the end.
pub(in crate::render) fn declare_through_glass<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    glass: InGlass,
    region: Region,
) -> Handle<Texture> {
    let (inputs, at_last) = (vec![("rough_glass", glass.rough)], vec![("glow_at_glass", glass.glow)]);
    Filter { width: width_of(frame), region, inputs, at_last, of: Of::Glass }.declare(graph, frame, glass.seen)
}

/// Width of the filter over that of the lobe. As with the filter of the gather: the more images, the narrower.
fn width_of(frame: &Frame) -> f32 {
    WIDTH / (frame.images().max(1) as f32).cbrt()
}

/// What shows an image.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    Mirrors(Surfaces),
    Glass,
}

impl Of {
    fn name(self, name: &str) -> String {
        match self {
            Self::Mirrors(surfaces) => surfaces.name(&format!("mirror{name}")),
            Self::Glass => format!("glass{name}"),
        }
    }

    fn define(self, pass: &mut PassBindings) {
        match self {
            Self::Mirrors(surfaces) => surfaces.define_for(pass),
            Self::Glass => pass.flag("THROUGH_GLASS", true),
        }
    }
}

struct Filter {
    width: f32,
    region: Region,
    inputs: Vec<(&'static str, Handle<Texture>)>,
    /// Inputs of the last pass alone.
    at_last: Vec<(&'static str, Handle<Texture>)>,
    of: Of,
}

/// Entry point of a pass, and the number of its turn.
#[derive(Clone, Copy)]
struct Step(&'static str, u32);

impl Filter {
    fn declare<'a>(&self, graph: &mut Graph<'a>, frame: &Frame<'a>, shown: Handle<Texture>) -> Handle<Texture> {
        let parts = self.images(graph, frame, [", without strays", ", strays"]);
        let parts = self.pass(graph, frame, " strays", Step("part", 0), &[("mirrored", shown)], parts);
        let once = self.images(graph, frame, [", without strays, once filtered", ", strays, once filtered"]);
        let inputs = |parts: Parts| [("mirrored", parts.rest), ("strays", parts.strays)];
        let once = self.pass(graph, frame, " filter, once", Step("filter_lobes", 0), &inputs(parts), once);
        let filtered = graph.retained_texture(self.of.name(", filtered"), frame.image_desc());
        let outputs = vec![("filtered", filtered)];
        let inputs: Vec<_> = inputs(once).into_iter().chain(self.at_last.iter().copied()).collect();
        let again = self.pass_of(graph, frame, " filter", Step("filter_lobes", 1), &inputs, outputs);
        again.first().copied().unwrap_or(filtered)
    }

    fn images<'a>(&self, graph: &mut Graph<'a>, frame: &Frame<'a>, names: [&str; 2]) -> Parts {
        let [rest, strays] = names.map(|name| graph.texture(self.of.name(name), frame.image_desc()));
        Parts { rest, strays }
    }

    fn pass<'a>(
        &self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        name: &str,
        step: Step,
        inputs: &[(&'static str, Handle<Texture>)],
        Parts { rest, strays }: Parts,
    ) -> Parts {
        let outputs = vec![("filtered", rest), ("strays_out", strays)];
        let outputs = self.pass_of(graph, frame, name, step, inputs, outputs);
        match outputs[..] {
            [rest, strays] => Parts { rest, strays },
            _ => Parts { rest, strays },
        }
    }

    fn pass_of<'a>(
        &self,
        graph: &mut Graph<'a>,
        frame: &Frame<'a>,
        name: &str,
        Step(entry, turn): Step,
        inputs: &[(&'static str, Handle<Texture>)],
        outputs: Vec<(&'static str, Handle<Texture>)>,
    ) -> Vec<Handle<Texture>> {
        let Region { origin, size } = self.region;
        // Two turns together are as wide as one of √2 times the width.
        let [width, stray_width] = [self.width, STRAY_WIDTH].map(|width| width * FRAC_1_SQRT_2);
        let uniform = MirrorFilterUniform { view: frame.view_values(), origin, size, width, stray_width, turn };
        let shader = ComputeKey::new("indirect/light_volumes/sweep/mirror_filter.wgsl", entry);
        let mut pass = graph.compute(self.of.name(name), shader);
        self.of.define(&mut pass);
        pass.flag("LAST", turn > 0);
        pass.uniform("mirror_filter", &uniform);
        self.inputs.iter().chain(inputs).for_each(|(name, input)| pass.read(name, *input));
        let written = outputs.into_iter().map(|(name, output)| pass.write(name, output)).collect();
        pass.dispatch_over(size.into());
        written
    }
}
