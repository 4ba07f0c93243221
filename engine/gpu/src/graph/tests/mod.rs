//! Tests of compilation and caching without a device, and one with.
#![allow(clippy::unwrap_used)]

mod caching;
mod compute;
mod device;
mod errors;
mod frame_pacing;
mod memory;
mod property;
mod simulation;
mod steps;

use wgpu::{TextureFormat, TextureUsages};

use super::{Graph, Handle, PassId, Texture, TextureDesc};

/// A description that only its size tells from others.
fn desc(size: u32) -> TextureDesc {
    TextureDesc::d2(size, size, TextureFormat::R32Uint, TextureUsages::STORAGE_BINDING)
}

/// Declares a pass that reads some textures and writes others; returns their next versions.
fn pass<const N: usize>(
    graph: &mut Graph<'_>,
    name: &str,
    key: Option<u64>,
    reads: &[Handle<Texture>],
    writes: [Handle<Texture>; N],
) -> ([Handle<Texture>; N], PassId) {
    let mut pass = graph.pass(name);
    reads.iter().for_each(|&handle| pass.read(handle));
    let written = writes.map(|handle| pass.write(handle));
    if let Some(key) = key {
        pass.key(&key);
    }
    (written, pass.execute(|_| Ok(())))
}
