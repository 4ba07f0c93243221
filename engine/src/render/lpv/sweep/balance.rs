//! What surfaces may reflect of a bounce: as much as the light lost on them, and no more.

use super::super::linear_groups;
use super::super::volume::Volume;
use super::Level;
use super::emit::Sources;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use encase::ShaderType;
use glam::{UVec2, UVec3};
use wgpu::BufferUsages;

/// `Balance` of `lpv/sweep/balance.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct BalanceUniform {
    nodes: UVec3,
    block: f32,
    scale: f32,
    most: f32,
    padding: UVec2,
}

/// Distance of the lattice's nodes \[cells\]. Light is lost up to two cells from the surfel that claims it: in Cornell
/// a lattice of 2 cells errs by 22 %, of 4 by 11 %, of 8 by 8 %; without any it is 10 %, and 26 % in a furnished room
/// where 8 cells leave 21 %.
const BLOCK: u32 = 8;
/// Largest share of its claim that a surfel keeps: more than all, since in a corner less is claimed than was lost.
const MOST: f32 = 2.0;

impl BalanceUniform {
    /// The lattice over a volume.
    pub fn new(volume: &Volume, scale: f32) -> Self {
        let nodes = volume.cells.map(|n| n.div_ceil(BLOCK) + 1);
        Self { nodes, block: BLOCK as f32, scale, most: MOST, padding: UVec2::ZERO }
    }

    fn count(&self) -> u32 {
        self.nodes.element_product()
    }
}

/// Declares the balance of a bounce; the result is what is `received` times the share that the surfels keep.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    sources: &Sources<'_, 'a>,
    level: &Level,
    received: Handle<Buffer>,
    bounce: u32,
) -> Handle<Buffer> {
    let name = format!("balance, bounce {}", bounce + 1);
    let volume = level.volume;
    let uniform = BalanceUniform::new(&volume, sources.scale);
    let desc =
        |bytes| BufferDesc::new(bytes * u64::from(uniform.count()), BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let claims = graph.buffer(format!("{name}, claims"), desc(8));
    let shares = graph.buffer(format!("{name}, shares"), desc(4));
    let (surfels, axes, count) = (sources.surfels, level.bounce.axes, sources.count);
    let mut pass = graph.pass(name);
    pass.read(surfels);
    pass.read(axes);
    let (received, claims, shares) = (pass.write(received), pass.write(claims), pass.write(shares));
    pass.key(&(volume.key(), sources.scale.to_bits(), bounce));
    pass.execute(move |cx| {
        let buffers = [surfels, received, axes, claims, shares].map(|handle| cx.buffer(handle).clone());
        let [surfels, received, axes, claims, shares] = &buffers;
        cx.encoder().clear_buffer(claims, 0, None);
        let box_of_cells = cx.gpu.uniform("volume", &volume.uniform());
        let lattice = cx.gpu.uniform("balance", &uniform);
        cx.dispatch(
            &ComputeKey::new("lpv/sweep/balance.wgsl", "claim"),
            &[
                ("volume", Binding::Buffer(&box_of_cells)),
                ("balance", Binding::Buffer(&lattice)),
                ("surfels", Binding::Buffer(surfels)),
                ("received", Binding::Buffer(received)),
                ("claims", Binding::Buffer(claims)),
            ],
            linear_groups(count),
        )?;
        cx.dispatch(
            &ComputeKey::new("lpv/sweep/balance.wgsl", "share"),
            &[
                ("volume", Binding::Buffer(&box_of_cells)),
                ("balance", Binding::Buffer(&lattice)),
                ("claims", Binding::Buffer(claims)),
                ("axes", Binding::Buffer(axes)),
                ("shares", Binding::Buffer(shares)),
            ],
            [uniform.nodes.x, uniform.nodes.y, uniform.nodes.z],
        )?;
        cx.dispatch(
            &ComputeKey::new("lpv/sweep/balance.wgsl", "keep"),
            &[
                ("volume", Binding::Buffer(&box_of_cells)),
                ("balance", Binding::Buffer(&lattice)),
                ("surfels", Binding::Buffer(surfels)),
                ("received", Binding::Buffer(received)),
                ("shares", Binding::Buffer(shares)),
            ],
            linear_groups(count),
        )
    });
    received
}
