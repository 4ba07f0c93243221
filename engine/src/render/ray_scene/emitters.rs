//! Triangles that emit light, and the chance of each to be sampled.

use super::geometry::NONE;
use crate::assets::{AssetId, Texture};
use crate::bvh::SceneBvh;
use crate::scene::{Primitive, Scene};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
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
    instance: u32,
    /// In the order of the leaves of its mesh.
    triangle: u32,
}

/// All emitters of a scene.
pub(super) struct Emitters {
    /// Ordered by instance, then as the mesh's leaves are.
    pub(super) list: Vec<Emitter>,
    /// For each instance its first emitter, or [`NONE`].
    pub(super) first: Vec<u32>,
}

/// Finds them; each is chosen in proportion to the flux that it sends out, area times mean radiance.
pub(super) fn collect(scene: &Scene, bvh: &SceneBvh, mean_colors: &mut HashMap<AssetId, Vec3>) -> Emitters {
    let mut list = Vec::new();
    let mut first = Vec::with_capacity(bvh.instances.len());
    let mut total = 0.0_f64;
    for (instance, index) in bvh.instances.iter().zip(0..) {
        let radiance = mean_radiance(&scene.primitives[instance.primitive as usize], mean_colors);
        if !(radiance > 0.0) || !instance.casts_shadow {
            first.push(NONE);
            continue;
        }
        first.push(list.len() as u32);
        let mesh = &bvh.meshes[instance.mesh as usize].bvh;
        for (&triangle, place) in mesh.bvh.order.iter().zip(0..) {
            let area = world_area(mesh.corners()[triangle as usize], &instance.world_from_object);
            // Without area there is nothing to sample, and the density has no meaning.
            let flux = if area > 0.0 { f64::from(radiance) * f64::from(area) } else { 0.0 };
            total += flux;
            list.push((flux, area, total, index, place));
        }
    }
    let share = |value: f64| if total > 0.0 { (value / total) as f32 } else { 0.0 };
    let emitter = |&(flux, area, sum, instance, triangle): &(f64, f32, f64, u32, u32)| Emitter {
        cumulative: share(sum),
        density: if flux > 0.0 { (flux / total / f64::from(area)) as f32 } else { 0.0 },
        instance,
        triangle,
    };
    Emitters { list: list.iter().map(emitter).collect(), first }
}

/// Largest channel of the mean emitted radiance, bounded so that sums over all triangles stay finite.
fn mean_radiance(primitive: &Primitive, mean_colors: &mut HashMap<AssetId, Vec3>) -> f32 {
    let material = &primitive.material;
    if !(material.emissive.max_element() > 0.0) {
        return 0.0;
    }
    let mut mean = |texture: &Arc<Texture>| *mean_colors.entry(texture.id).or_insert_with(|| texture.mean_color());
    let texture = material.emissive_texture.as_ref().map_or(Vec3::ONE, &mut mean);
    let radiance = (material.emissive * texture).max_element();
    if radiance.is_finite() { radiance.min(1e30) } else { 0.0 }
}

fn world_area(corners: [Vec3; 3], world_from_object: &Affine3A) -> f32 {
    let [a, b, c] = corners.map(|corner| world_from_object.transform_point3(corner));
    let area = 0.5 * (b - a).cross(c - a).length();
    if area.is_finite() { area } else { 0.0 }
}
