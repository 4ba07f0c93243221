//! Triangles that emit light, and the chance of each to be sampled.

use super::geometry::NONE;
use crate::assets::{AssetId, Texture};
use crate::bvh::SceneBvh;
use crate::scene::{Primitive, Scene};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// `Emitter` of `lib/rays.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Emitter {
    /// Chance that this triangle or one before it is chosen.
    cumulative: f32,
    /// Chance of this triangle over its area [1/m²].
    density: f32,
    /// Place of the triangle in the order of the leaves.
    triangle: u32,
    padding: u32,
}

/// All emitters of a scene.
pub(super) struct Emitters {
    /// In the order of the scene: that of the leaves depends on the frames before, and the same frame would draw others.
    pub(super) list: Vec<Emitter>,
    /// For each triangle in the order of the leaves its emitter, or [`NONE`].
    pub(super) of_triangle: Vec<u32>,
}

/// Finds them; each is chosen in proportion to the flux that it sends out, area times mean radiance. `mean_colors`
/// keeps what takes its time to find.
pub(super) fn collect(scene: &Scene, bvh: &SceneBvh, mean_colors: &mut HashMap<AssetId, Vec3>) -> Emitters {
    let radiance: Vec<f32> = scene.primitives.iter().map(|p| mean_radiance(p, mean_colors)).collect();
    let mut found = Vec::new();
    let mut of_triangle = vec![NONE; bvh.bvh.order.len()];
    let mut total = 0.0_f64;
    let mut places = vec![None; bvh.triangles.len()];
    for (place, &index) in bvh.bvh.order.iter().enumerate() {
        places[index as usize] = Some(place);
    }
    for (triangle, place) in bvh.triangles.iter().zip(places) {
        let Some(place) = place else { continue };
        let area = 0.5 * triangle.area_normal().length();
        let radiance = radiance[triangle.primitive as usize];
        let flux = f64::from(radiance) * f64::from(area);
        // Without area there is nothing to sample, and the density has no meaning.
        if flux > 0.0 && flux.is_finite() {
            total += flux;
            of_triangle[place] = found.len() as u32;
            found.push((flux, f64::from(area), total, place as u32));
        }
    }
    let emitter = |(flux, area, sum, triangle): (f64, f64, f64, u32)| Emitter {
        cumulative: (sum / total) as f32,
        density: (flux / total / area) as f32,
        triangle,
        padding: 0,
    };
    Emitters { list: found.into_iter().map(emitter).collect(), of_triangle }
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
