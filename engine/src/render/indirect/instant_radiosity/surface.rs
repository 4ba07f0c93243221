//! Surfaces as particles find them.

use super::intersection::CastHit;
use crate::assets::{AlphaMode, Texture, UvMap};
use crate::bvh::Ray;
use crate::render::indirect::lobe_reflectance::lobe_reflectance;
use crate::scene::{Primitive, Scene, texel};
use crate::scene::{SceneBvh, vertex_indices, world_normal};
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) position: Vec3,
    /// How far rounding may have moved it \[m\].
    pub(super) error: f32,
}

/// A surface that a particle met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Met {
    pub(super) position: Vec3,
    /// Unit, on the side that the particle came from.
    pub(super) geometric_normal: Vec3,
    /// Interpolated, unit. Normal maps are left out: they bend light by less than it spreads.
    pub(super) normal: Vec3,
    /// Diffuse reflectance.
    pub(super) albedo: Vec3,
    /// F0.
    pub(super) normal_reflectance: Vec3,
    /// F90.
    pub(super) grazing_reflectance: f32,
    pub(super) roughness: f32,
    pub(super) error: f32,
}

/// The point of a triangle, with the second and third barycentric coordinate.
pub(super) fn point(_scene: &Scene, bvh: &SceneBvh, triangle: u32, [u, v]: [f32; 2]) -> Point {
    let [a, b, c] = bvh.triangles[triangle as usize].corners;
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    Point { position: (1.0 - u - v) * a + u * b + v * c, error: largest * 2.0_f32.powi(-20) }
}

/// Texture coordinates of a point on a triangle.
#[derive(Clone, Copy)]
struct Place {
    uvs: [[f32; 2]; 2],
    /// Vertex colour.
    color: Vec4,
}

impl Place {
    fn new(primitive: &Primitive, triangle: u32, [u, v]: [f32; 2]) -> Self {
        let weights = [1.0 - u - v, u, v];
        let vertices = vertex_indices(primitive, triangle);
        let mix = |uvs: [[f32; 2]; 3]| [0, 1].map(|i| (0..3).map(|c| weights[c] * uvs[c][i]).sum());
        let first = mix(vertices.map(|vertex| primitive.mesh.vertices[vertex].uv));
        if primitive.mesh.extras.is_none() {
            return Self { uvs: [first, [0.0; 2]], color: Vec4::ONE };
        }
        let extras = vertices.map(|vertex| primitive.mesh.extra(vertex));
        let color = (0..3).map(|c| weights[c] * Vec4::from(extras[c].rgba())).sum();
        Self { uvs: [first, mix(extras.map(|extra| extra.uv))], color }
    }

    fn texel(&self, texture: &Option<Arc<Texture>>, map: &UvMap) -> Vec4 {
        texture.as_ref().map_or(Vec4::ONE, |texture| texel(texture, map.apply(self.uvs)))
    }
}

/// Emitted radiance [W/(m² sr)].
pub(super) fn emitted(scene: &Scene, bvh: &SceneBvh, triangle: u32, barycentric: [f32; 2]) -> Vec3 {
    let triangle = &bvh.triangles[triangle as usize];
    let primitive = &scene.primitives[triangle.primitive as usize];
    let place = Place::new(primitive, triangle.triangle, barycentric);
    let material = &primitive.material;
    let texel = place.texel(&material.emissive_texture, &material.uv.emissive).truncate();
    let radiance = material.emissive * texel * if material.unlit { place.color.truncate() } else { Vec3::ONE };
    if radiance.is_finite() { radiance.clamp(Vec3::ZERO, Vec3::splat(1e30)) } else { Vec3::ZERO }
}

/// Whether the surface is cut out there by its alpha.
pub(super) fn is_cut_out(scene: &Scene, bvh: &SceneBvh, triangle: u32, barycentric: [f32; 2]) -> bool {
    let triangle = &bvh.triangles[triangle as usize];
    let primitive = &scene.primitives[triangle.primitive as usize];
    let cutoff = match primitive.material.alpha_mode {
        AlphaMode::Opaque => return false,
        AlphaMode::Mask(cutoff) => cutoff,
        AlphaMode::Blend => 0.5,
    };
    let place = Place::new(primitive, triangle.triangle, barycentric);
    let material = &primitive.material;
    let texel = place.texel(&material.base_color_texture, &material.uv.base_color);
    material.base_color.w * place.color.w * texel.w < cutoff
}

/// The hit of a particle; none at the back of a single-sided surface, which stops light and returns none.
pub(super) fn meet(scene: &Scene, bvh: &SceneBvh, ray: &Ray, cast: &CastHit) -> Option<Met> {
    match cast.box_normal {
        Some(normal) => Some(on_box(scene, bvh, ray, cast, normal)),
        None => on_triangle(scene, bvh, cast.triangle, cast.barycentric, ray.direction),
    }
}

/// The hit on the box that stands for an object: its place and normal, with the object's material.
fn on_box(scene: &Scene, bvh: &SceneBvh, ray: &Ray, cast: &CastHit, normal: Vec3) -> Met {
    let triangle = &bvh.triangles[cast.triangle as usize];
    let primitive = &scene.primitives[triangle.primitive as usize];
    let position = ray.at(cast.t);
    let largest = position.abs().max(ray.origin.abs()).max_element();
    let met = with_material(primitive, &Place::new(primitive, triangle.triangle, cast.barycentric));
    Met { position, error: largest * 2.0_f32.powi(-20), geometric_normal: normal, normal, ..met }
}

/// The hit of a ray of that direction on a triangle; none at the back of a single-sided surface.
pub(super) fn on_triangle(
    scene: &Scene,
    bvh: &SceneBvh,
    index: u32,
    barycentric: [f32; 2],
    direction: Vec3,
) -> Option<Met> {
    let triangle = &bvh.triangles[index as usize];
    let primitive = &scene.primitives[triangle.primitive as usize];
    let outward = triangle.area_normal().normalize_or_zero();
    let back = outward.dot(direction) > 0.0;
    if back && !primitive.material.double_sided {
        return None;
    }
    let turn = if back { -1.0 } else { 1.0 };
    let [u, v] = barycentric;
    let vertices = vertex_indices(primitive, triangle.triangle);
    let normals = vertices
        .map(|vertex| world_normal(&primitive.world_from_object, primitive.mesh.vertices[vertex].normal.into()));
    let normal = turn * ((1.0 - u - v) * normals[0] + u * normals[1] + v * normals[2]).normalize_or_zero();
    let at = point(scene, bvh, index, barycentric);
    let geometric_normal = turn * outward;
    let met = with_material(primitive, &Place::new(primitive, triangle.triangle, barycentric));
    Some(Met {
        position: at.position,
        error: at.error,
        geometric_normal,
        normal: if normal == Vec3::ZERO { geometric_normal } else { normal },
        ..met
    })
}

/// The material's part of a hit.
fn with_material(primitive: &Primitive, place: &Place) -> Met {
    let material = &primitive.material;
    let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    let maps = &material.uv;
    let texel = place.texel(&material.base_color_texture, &maps.base_color);
    let base = (material.base_color * place.color * texel).truncate();
    let base = if base.is_finite() { base.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ZERO };
    let rough = place.texel(&material.metallic_roughness_texture, &maps.metallic_roughness);
    let metallic = unit(material.metallic * rough.z);
    let specular = unit(material.specular * place.texel(&material.specular_texture, &maps.specular).w);
    let tint = place.texel(&material.specular_color_texture, &maps.specular_color).truncate();
    let dielectric = (0.04 * material.dielectric_reflectance() * tint).clamp(Vec3::ZERO, Vec3::ONE) * specular;
    Met {
        position: Vec3::ZERO,
        geometric_normal: Vec3::Y,
        normal: Vec3::Y,
        albedo: base * (1.0 - metallic),
        normal_reflectance: dielectric.lerp(base, metallic),
        grazing_reflectance: specular + (1.0 - specular) * metallic,
        roughness: unit(material.roughness * rough.y),
        error: 0.0,
    }
}

impl Met {
    /// Roughness and F90, and √F0, packed as [`super::trace_particles::VirtualLight`] has them; none for diffuse surfaces.
    pub(super) fn gloss(&self) -> Option<(u32, u32)> {
        if self.normal_reflectance == Vec3::ZERO && self.grazing_reflectance <= 0.0 {
            return None;
        }
        let unit = |value: f32| (value.clamp(0.0, 1.0) * 65535.0).round() as u32;
        let root = |value: f32| (value.clamp(0.0, 1.0).sqrt() * 1023.0).round() as u32;
        let [r, g, b] = self.normal_reflectance.to_array().map(root);
        // Bits are left where both are zero: a perfect mirror is glossy too.
        Some((unit(self.roughness).max(1) | unit(self.grazing_reflectance) << 16, r | g << 10 | b << 20))
    }

    /// Share of the light from a direction (cosine to the normal) that is reflected at all. A particle goes on
    /// diffusely with all of it: the energy of the specular part is kept, its direction is not. Diffuse light loses Schlick's term averaged
    /// over the hemisphere, F0 + (F90−F0)/21.
    pub(super) fn reflectance(&self, cosine: f32) -> Vec3 {
        if self.normal_reflectance == Vec3::ZERO && self.grazing_reflectance <= 0.0 {
            return self.albedo;
        }
        let specular = lobe_reflectance(self.normal_reflectance, self.grazing_reflectance, self.roughness, cosine);
        let largest = self.normal_reflectance.max_element();
        let lost = largest + (self.grazing_reflectance - largest) / 21.0;
        (self.albedo * (1.0 - lost) + specular).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diffuse_surface_reflects_its_albedo_and_a_smooth_metal_its_color() {
        let met = Met {
            position: Vec3::ZERO,
            geometric_normal: Vec3::Y,
            normal: Vec3::Y,
            albedo: Vec3::splat(0.6),
            normal_reflectance: Vec3::ZERO,
            grazing_reflectance: 0.0,
            roughness: 0.5,
            error: 0.0,
        };
        assert_eq!(met.reflectance(0.7), Vec3::splat(0.6));
        let metal = Met {
            albedo: Vec3::ZERO,
            normal_reflectance: Vec3::new(0.9, 0.6, 0.3),
            grazing_reflectance: 1.0,
            roughness: 0.1,
            ..met
        };
        // A smooth mirror returns F0 at normal incidence, within the fit's few per cent.
        assert!((metal.reflectance(1.0) - metal.normal_reflectance).abs().max_element() < 0.06, "{metal:?}");
    }
}
