//! Texels of reflective shadow maps, drawn in proportion to the flux that they receive or reflect. See `lib/rsm_draw.wgsl`.

use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, ComputeBuilder, Graph, Handle, PassBindings};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use crate::scene::Aabb;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// `STRIP` of `lib/rsm_draw.wgsl`.
const STRIP: u32 = 32;

const SHADER: &str = "indirect/light_volumes/sweep/rsm_samples.wgsl";

/// `Draw` of `lib/rsm_draw.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct DrawUniform {
    low: Vec3,
    first_strip: u32,
    high: Vec3,
    strips: u32,
    points: u32,
    seed: u32,
    scale: f32,
    light: u32,
}

/// By what texels are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Weight {
    /// The flux that they receive.
    Received,
    /// The flux that they reflect diffusely.
    Reflected,
}

impl Weight {
    /// A shader that draws by it.
    pub fn shader(self, path: &'static str, entry: &'static str) -> ComputeKey {
        let reflected = (self == Self::Reflected).then_some(("REFLECTED", ShaderDef::Flag(true)));
        ComputeKey { defs: reflected.into_iter().collect(), ..ComputeKey::new(path, entry) }
    }
}

/// What is drawn.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Texels beyond this box are not drawn \[m\].
    pub reach: Aabb,
    /// A power of two with which all flux is below 2³⁸ \[1/W\].
    pub scale: f32,
    /// How many are drawn.
    pub points: u32,
    /// Of the random numbers.
    pub seed: u32,
    /// By what.
    pub weight: Weight,
}

/// One view of a light.
#[derive(Clone)]
struct Map<'a> {
    rsm: Rsm<'a>,
    layer: usize,
    first_strip: u32,
}

impl Map<'_> {
    fn strips(&self) -> u32 {
        strips_of(&self.rsm)
    }
}

/// Strips of one view.
fn strips_of(rsm: &Rsm) -> u32 {
    rsm.size.div_ceil(STRIP) * rsm.size
}

/// Maps to draw from, with the sum of their weights.
#[derive(Clone)]
pub(super) struct Draw<'a> {
    maps: Vec<Map<'a>>,
    uniform: DrawUniform,
    wanted: Wanted,
    cumulative: Handle<Buffer>,
}

impl<'a> Draw<'a> {
    /// Declares the sum of the weights; `names` are those of the pass and of its temporary buffer. There must be a map.
    pub fn declare<'r>(
        graph: &mut Graph<'a>,
        [name, temporary]: [&str; 2],
        rsms: impl Iterator<Item = &'r Rsm<'a>>,
        wanted: Wanted,
    ) -> Self
    where
        'a: 'r,
    {
        let (mut maps, mut strips) = (Vec::new(), 0);
        for rsm in rsms {
            for layer in 0..rsm.views.len() {
                maps.push(Map { rsm: rsm.clone(), layer, first_strip: strips });
                strips += strips_of(rsm);
            }
        }
        let Wanted { reach, scale, points, seed, .. } = wanted;
        let uniform =
            DrawUniform { low: reach.min, first_strip: 0, high: reach.max, strips, points, seed, scale, light: 0 };
        let desc = BufferDesc::new(4 * u64::from(strips), BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let cumulative = graph.retained_buffer(name, desc.clone());
        let weights = graph.buffer(temporary, desc);
        let mut pass = graph.compute(name, wanted.weight.shader(SHADER, "weigh"));
        let _ = pass.write("weights", weights);
        let cumulative = pass.write("cumulative", cumulative);
        // Not the seed and the number: the sum does not depend on them.
        let weighed = Self { maps, uniform: DrawUniform { points: 0, seed: 0, ..uniform }, wanted, cumulative };
        for map in &weighed.maps {
            let mut step = pass.step("weigh");
            weighed.bind_map(&mut step, map);
            step.over_items(map.strips());
        }
        let mut step = pass.step_of(ComputeKey::new(SHADER, "sum_up"));
        step.uniform("draw", &weighed.uniform);
        step.in_groups([1, 1, 1]);
        pass.finish();
        Self { uniform, ..weighed }
    }

    /// How many texels are drawn.
    pub fn points(&self) -> u32 {
        self.wanted.points
    }

    /// A shader that draws by the same weight.
    pub fn shader(&self, path: &'static str, entry: &'static str) -> ComputeKey {
        self.wanted.weight.shader(path, entry)
    }

    /// Binds the uniform and the sum to a step that needs no map.
    pub fn bind_sums(&self, step: &mut PassBindings) {
        step.uniform("draw", &self.uniform);
        step.read("cumulative", self.cumulative);
    }

    /// Declares the steps of a shader that draws all texels: once a map, and each sample acts where its texel lies.
    pub fn declare_steps(&self, pass: &mut ComputeBuilder<'_, 'a>, shader: &ComputeKey) {
        for map in &self.maps {
            let mut step = pass.step_of(shader.clone());
            self.bind_map(&mut step, map);
            step.read("cumulative", self.cumulative);
            step.over_items(self.points());
        }
    }

    fn bind_map(&self, step: &mut PassBindings, Map { rsm, layer, first_strip }: &Map) {
        step.uniform("draw", &DrawUniform { first_strip: *first_strip, light: rsm.index, ..self.uniform });
        step.uniform("light", &LightUniform::new(rsm.light));
        step.uniform("rsm", &rsm.layer_uniform(*layer, 1.0));
        step.read("base_color", rsm.base_color);
        step.read("normal", rsm.normal);
        step.read("specular", rsm.specular);
        step.read("depth", rsm.depth);
    }
}
