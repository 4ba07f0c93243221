//! Triangles that emit light, and the chance of each to be sampled.

use super::geometry::NONE;
use crate::assets::{AssetId, Texture};
use crate::bvh::Bvh;
use crate::scene::SceneBvh;
use crate::scene::{Primitive, Scene};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// `Emitter` of `lib/ray_scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Emitter {
    /// Chance that this triangle or one before it is chosen.
    cumulative: f32,
    /// Chance of this triangle over its area [1/m²].
    density: f32,
    /// Index of the triangle on the device.
    triangle: u32,
    padding: u32,
}

/// A primitive that emits light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    primitive: usize,
    is_moving: bool,
    /// Mean radiance.
    radiance: f32,
    /// The emitter of its first triangle.
    first: usize,
}

/// All triangles of primitives that emit light, in the order of the scene: that of the leaves depends on the frames
/// before, and the same frame would draw others. Those without flux are never drawn.
#[derive(Default)]
pub(super) struct Emitters {
    sources: Vec<Source>,
    /// Flux and area of each.
    sizes: Vec<[f64; 2]>,
    /// Mean colour of emissive textures, which takes its time to find.
    mean_colors: HashMap<AssetId, Vec3>,
    /// For each triangle of the scene its emitter, or [`NONE`]. Empty if nothing emits light.
    of_triangle: Vec<u32>,
}

/// What has changed of emitters that move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Followed {
    Nothing,
    /// Their places and sizes.
    Sizes,
    /// And which triangles emit light.
    Triangles,
}

impl Emitters {
    /// Finds them. True if triangles of static primitives have other emitters than before.
    pub(super) fn collect(&mut self, scene: &Scene, bvh: &SceneBvh) -> bool {
        let mut sources = Vec::new();
        let mut first = 0;
        for (index, primitive) in scene.primitives.iter().enumerate() {
            let radiance = mean_radiance(primitive, &mut self.mean_colors);
            if radiance > 0.0 {
                sources.push(Source { primitive: index, is_moving: primitive.moving, radiance, first });
                first += bvh.triangles_of(index).len();
            }
        }
        let statics = |sources: &[Source]| -> Vec<[usize; 2]> {
            sources.iter().filter(|s| !s.is_moving).map(|s| [s.primitive, s.first]).collect()
        };
        let are_others = statics(&sources) != statics(&self.sources);
        self.sources = sources;
        self.sizes = vec![[0.0; 2]; first];
        self.of_triangle = if first > 0 { vec![NONE; bvh.triangles.len()] } else { Vec::new() };
        for index in 0..self.sources.len() {
            self.measure(self.sources[index], bvh);
        }
        are_others
    }

    /// Takes the new sizes of dynamic objects that have changed since a version of them.
    pub(super) fn follow(&mut self, bvh: &SceneBvh, since: u64) -> Followed {
        let has_changed = |source: &Source| bvh.movers.object(source.primitive).is_some_and(|o| o.version > since);
        let sources = self.sources.iter().filter(|source| source.is_moving && has_changed(source));
        let sources: Vec<Source> = sources.copied().collect();
        let mut has_others = false;
        for source in &sources {
            has_others |= self.measure(*source, bvh);
        }
        match (sources.is_empty(), has_others) {
            (true, _) => Followed::Nothing,
            (false, false) => Followed::Sizes,
            (false, true) => Followed::Triangles,
        }
    }

    /// Whether any triangle has another emitter than before.
    fn measure(&mut self, source: Source, bvh: &SceneBvh) -> bool {
        let mut has_others = false;
        for (index, emitter) in bvh.triangles_of(source.primitive).zip(source.first..) {
            let area = f64::from(0.5 * bvh.triangles[index].area_normal().length());
            let flux = f64::from(source.radiance) * area;
            // Without area there is nothing to sample, and the density has no meaning.
            let is_sampled = flux > 0.0 && flux.is_finite();
            self.sizes[emitter] = if is_sampled { [flux, area] } else { [0.0; 2] };
            let named = if is_sampled { emitter as u32 } else { NONE };
            has_others |= std::mem::replace(&mut self.of_triangle[index], named) != named;
        }
        has_others
    }

    /// The emitter of a triangle of the scene, or [`NONE`].
    pub(super) fn of(&self, triangle: u32) -> u32 {
        self.of_triangle.get(triangle as usize).copied().unwrap_or(NONE)
    }

    /// The list for the device; each is chosen in proportion to the flux that it sends out, area times mean radiance.
    /// `trees` are the hierarchies, each with the index of its first triangle on the device.
    pub(super) fn list<'a>(&self, trees: impl Iterator<Item = (&'a Bvh, u32)>) -> Vec<Emitter> {
        let total: f64 = self.sizes.iter().map(|[flux, _]| flux).sum();
        if !(total > 0.0) {
            return Vec::new();
        }
        let mut sum = 0.0;
        let emitter = |&[flux, area]: &[f64; 2]| {
            sum += flux;
            let density = if area > 0.0 { flux / total / area } else { 0.0 };
            Emitter { cumulative: (sum / total) as f32, density: density as f32, triangle: 0, padding: 0 }
        };
        let mut list: Vec<Emitter> = self.sizes.iter().map(emitter).collect();
        for (tree, first) in trees {
            for (&index, place) in tree.order.iter().zip(first..) {
                if let Some(emitter) = list.get_mut(self.of(index) as usize) {
                    emitter.triangle = place;
                }
            }
        }
        list
    }
}

/// Largest channel of the mean emitted radiance; zero for what only the camera sees. Bounded so that sums over all
/// triangles stay finite.
fn mean_radiance(primitive: &Primitive, mean_colors: &mut HashMap<AssetId, Vec3>) -> f32 {
    let material = &primitive.material;
    if !(material.emissive.max_element() > 0.0) || !primitive.casts_shadow {
        return 0.0;
    }
    let mean = |texture: &Arc<Texture>| *mean_colors.entry(texture.id).or_insert_with(|| texture.mean_color());
    let texture = material.emissive_texture.as_ref().map_or(Vec3::ONE, mean);
    let radiance = (material.emissive * texture).max_element();
    if radiance.is_finite() { radiance.min(1e30) } else { 0.0 }
}
