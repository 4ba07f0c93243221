//! Common parts of the tests of surfels.

use crate::assets::{Material, Mesh};
use crate::scene::{Primitive, SceneId};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// A static primitive of grey stone.
pub fn primitive(id: u64, mesh: Arc<Mesh>, place: Affine3A) -> Primitive {
    Primitive {
        id: SceneId(id),
        bounds: mesh.bounds.transformed(&place),
        world_from_object: place,
        material: Arc::new(Material::diffuse("stone", Vec3::splat(0.5))),
        mesh,
        casts_shadow: true,
        moving: false,
        geometry_revision: 1,
        material_revision: 1,
    }
}
