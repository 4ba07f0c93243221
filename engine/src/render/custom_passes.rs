//! Passes of a game's own: between the light of the scene and the screen.

use super::geometry::gbuffer::GBuffer;
use crate::graph::{Graph, Handle, Texture};

/// The images that a custom pass can read.
pub struct Picture<'a> {
    /// Linear radiance [W/(m² sr)], rgba32float, with what passes before this one made of it.
    pub radiance: Handle<Texture>,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// Size \[pixels\].
    pub size: [u32; 2],
}

/// Declares a pass, and gives the radiance that it writes.
pub(super) type ExtraPass = Box<dyn Fn(&mut Graph<'_>, &Picture<'_>) -> Handle<Texture> + Send + Sync>;

/// Declares all of them, one after the other.
pub(super) fn declare(
    graph: &mut Graph<'_>,
    passes: &[ExtraPass],
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
    size: [u32; 2],
) -> Handle<Texture> {
    passes.iter().fold(radiance, |radiance, pass| pass(graph, &Picture { radiance, gbuffer, size }))
}
