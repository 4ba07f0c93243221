//! Texels of reflective shadow maps, drawn in proportion to the flux that they receive or reflect. See `lib/rsm_draw.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassBuilder, PassContext, PassError};
use crate::render::frame::linear_groups;
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

/// All that an outcome depends on besides the maps: lights, the box, scale, number, seed, weight.
type Key = (Vec<(u64, u32)>, [[u32; 3]; 2], [u32; 3], Weight);

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
        let mut draw = Self { maps, uniform, wanted, cumulative };
        let mut pass = graph.pass(name);
        draw.read_maps(&mut pass);
        let (weights, cumulative) = (pass.write(weights), pass.write(cumulative));
        draw.cumulative = cumulative;
        // Not the seed and the number: the sum does not depend on them.
        let (lights, reach, _, weight) = draw.key();
        pass.key(&(lights, reach, scale.to_bits(), strips, weight));
        let mut weighed = draw.clone();
        (weighed.uniform.points, weighed.uniform.seed) = (0, 0);
        pass.execute(move |cx| weighed.weigh(cx, weights));
        draw
    }

    fn weigh(&self, cx: &mut PassContext, weights: Handle<Buffer>) -> Result<(), PassError> {
        let [weights, cumulative] = [weights, self.cumulative].map(|handle| cx.buffer(handle).clone());
        let weigh = self.wanted.weight.shader(SHADER, "weigh");
        for map in &self.maps {
            self.dispatch_map(cx, &weigh, map, &[("weights", Binding::Buffer(&weights))], linear_groups(map.strips()))?;
        }
        let uniform = cx.gpu.uniform("draw", &self.uniform);
        let group = [
            ("draw", Binding::Buffer(&uniform)),
            ("weights", Binding::Buffer(&weights)),
            ("cumulative", Binding::Buffer(&cumulative)),
        ];
        cx.dispatch(&ComputeKey::new(SHADER, "sum_up"), &group, [1, 1, 1])
    }

    /// How many texels are drawn.
    pub fn points(&self) -> u32 {
        self.wanted.points
    }

    /// A shader that draws by the same weight.
    pub fn shader(&self, path: &'static str, entry: &'static str) -> ComputeKey {
        self.wanted.weight.shader(path, entry)
    }

    /// All that a pass depends on which draws texels, besides what it reads.
    pub fn key(&self) -> Key {
        let lights = self.maps.iter().map(|map| (map.rsm.light.revision, map.rsm.index)).collect();
        let Wanted { reach, scale, points, seed, weight } = self.wanted;
        let corners = [reach.min, reach.max].map(|corner| corner.to_array().map(f32::to_bits));
        (lights, corners, [scale.to_bits(), points, seed], weight)
    }

    /// Says that a pass reads all maps and the sum.
    pub fn read(&self, pass: &mut PassBuilder<'_, 'a>) {
        self.read_maps(pass);
        pass.read(self.cumulative);
    }

    fn read_maps(&self, pass: &mut PassBuilder<'_, 'a>) {
        for Map { rsm, .. } in self.maps.iter().filter(|map| map.layer == 0) {
            [rsm.base_color, rsm.normal, rsm.specular, rsm.depth].into_iter().for_each(|input| pass.read(input));
        }
    }

    /// The uniform and the sum, for a shader that needs no map.
    pub fn sums(&self, cx: &PassContext) -> [(&'static str, wgpu::Buffer); 2] {
        let uniform = cx.gpu.uniform("draw", &self.uniform);
        [("draw", uniform), ("cumulative", cx.buffer(self.cumulative).clone())]
    }

    /// Runs an entry point that draws all texels: once a map, and each sample acts where its texel lies.
    pub fn dispatch(&self, cx: &mut PassContext, key: &ComputeKey, more: &[(&str, Binding)]) -> Result<(), PassError> {
        let cumulative = cx.buffer(self.cumulative).clone();
        let more = [&[("cumulative", Binding::Buffer(&cumulative))], more].concat();
        let groups = linear_groups(self.points());
        self.maps.iter().try_for_each(|map| self.dispatch_map(cx, key, map, &more, groups))
    }

    fn dispatch_map(
        &self,
        cx: &mut PassContext,
        key: &ComputeKey,
        map: &Map,
        more: &[(&str, Binding)],
        groups: [u32; 3],
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let draw = DrawUniform { first_strip: map.first_strip, light: map.rsm.index, ..self.uniform };
        let draw = gpu.uniform("draw", &draw);
        let light = LightUniform::buffer(gpu, map.rsm.light);
        let rsm = gpu.uniform("rsm", &map.rsm.layer_uniform(map.layer, 1.0));
        let textures = [
            ("base_color", map.rsm.base_color),
            ("normal", map.rsm.normal),
            ("specular", map.rsm.specular),
            ("depth", map.rsm.depth),
        ];
        let textures = textures.map(|(name, handle)| (name, cx.view(handle)));
        let mut group =
            vec![("draw", Binding::Buffer(&draw)), ("light", Binding::Buffer(&light)), ("rsm", Binding::Buffer(&rsm))];
        group.extend(textures.iter().map(|(name, view)| (*name, Binding::Texture(view))));
        group.extend_from_slice(more);
        cx.dispatch(key, &group, groups)
    }
}
