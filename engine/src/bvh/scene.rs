//! The hierarchy over the instances of a scene, in world space.

use super::{Bvh, MeshBvh, MeshHit, Ray};
use crate::assets::{AssetId, Mesh, Vertex};
use crate::scene::{Aabb, Scene};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// What a ray is for, which decides what it can meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// What the camera sees: everything but the backs of single-sided surfaces, as when drawn by triangles.
    Camera,
    /// Light on its way: whatever casts shadows, from both sides.
    Light,
}

/// A mesh at its place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index in [`Scene::primitives`].
    pub primitive: u32,
    /// Index in [`SceneBvh::meshes`].
    pub mesh: u32,
    /// Object from world space.
    pub object_from_world: Affine3A,
    /// World from the space of the mesh's hierarchy.
    pub world_from_object: Affine3A,
    /// World bounds.
    pub bounds: Aabb,
    /// Whether light meets it; else only the camera does.
    pub casts_shadow: bool,
    /// Whether the camera sees its back faces.
    pub double_sided: bool,
}

/// Where a ray meets a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Index of the instance.
    pub instance: u32,
    /// Where on its mesh.
    pub mesh: MeshHit,
}

/// All surfaces of a scene, ready for rays. [`SceneBvh::update`] does only what a change needs: moved objects cost a
/// new top level, and a mesh is built once.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// The meshes that the instances use.
    pub meshes: Vec<Arc<TracedMesh>>,
    /// Instances, in the order of the scene's primitives. Those that no ray can meet are left out.
    pub instances: Vec<Instance>,
    /// The hierarchy over the instances; each leaf holds one.
    pub top: Bvh,
    built: HashMap<AssetId, Arc<TracedMesh>>,
}

/// A mesh with its hierarchy.
#[derive(Debug)]
pub struct TracedMesh {
    /// Its vertices and triangles.
    pub mesh: Arc<Mesh>,
    /// The hierarchy over its triangles.
    pub bvh: MeshBvh,
}

impl TracedMesh {
    fn new(mesh: Arc<Mesh>) -> Arc<Self> {
        let bvh = MeshBvh::new(&mesh);
        Arc::new(Self { mesh, bvh })
    }
}

impl SceneBvh {
    /// The hierarchies of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mut bvh = Self::default();
        bvh.update(scene);
        bvh
    }

    /// Brings everything up to date with the scene.
    pub fn update(&mut self, scene: &Scene) {
        let used: HashMap<AssetId, &Arc<Mesh>> = scene.primitives.iter().map(|p| (p.mesh.id, &p.mesh)).collect();
        self.built.retain(|id, _| used.contains_key(id));
        self.meshes.clear();
        self.instances.clear();
        let mut places: HashMap<AssetId, u32> = HashMap::new();
        for (primitive, index) in scene.primitives.iter().zip(0..) {
            let built = self.built.entry(primitive.mesh.id).or_insert_with(|| TracedMesh::new(primitive.mesh.clone()));
            let world_from_object = primitive.world_from_object;
            let (mesh, world_from_object, object_from_world) = match inverse(&world_from_object) {
                Some(inverse) => {
                    let meshes = &mut self.meshes;
                    let mesh = *places.entry(primitive.mesh.id).or_insert_with(|| push(meshes, built.clone()));
                    (mesh, world_from_object, inverse)
                }
                // A transform that flattens has no inverse: the triangles themselves go to world space.
                None => {
                    let flat =
                        push(&mut self.meshes, TracedMesh::new(Arc::new(moved(&built.mesh, &world_from_object))));
                    (flat, Affine3A::IDENTITY, Affine3A::IDENTITY)
                }
            };
            let Some(root) = self.meshes[mesh as usize].bvh.bvh.nodes.first() else { continue };
            let bounds = root.bounds().transformed(&world_from_object);
            self.instances.push(Instance {
                primitive: index,
                mesh,
                object_from_world,
                world_from_object,
                bounds: grown(&bounds),
                casts_shadow: primitive.casts_shadow,
                double_sided: primitive.material.double_sided,
            });
        }
        let boxes: Vec<Aabb> = self.instances.iter().map(|instance| instance.bounds).collect();
        self.top = Bvh::new(&boxes, 1);
    }

    /// The nearest surface that the ray meets before `t_max`. Alpha is not looked at.
    pub fn closest_hit(&self, ray: &Ray, t_max: f32, kind: RayKind) -> Option<SceneHit> {
        let mut closest: Option<SceneHit> = None;
        self.top.traverse(ray, t_max, |index, bound| {
            let instance = &self.instances[index as usize];
            if kind == RayKind::Light && !instance.casts_shadow {
                return bound;
            }
            let local = ray.transformed(&instance.object_from_world);
            let mesh = &self.meshes[instance.mesh as usize].bvh;
            let culled = kind == RayKind::Camera && !instance.double_sided;
            let seen = |hit: &MeshHit| !culled || is_front(mesh.corners()[hit.triangle as usize], &local);
            match mesh.closest_hit(&local, bound, seen) {
                Some(hit) => {
                    closest = Some(SceneHit { t: hit.t, instance: index, mesh: hit });
                    hit.t
                }
                None => bound,
            }
        });
        closest
    }

    /// Whether anything that casts shadows lies on the ray before `t_max`.
    pub fn is_blocked(&self, ray: &Ray, t_max: f32) -> bool {
        self.closest_hit(ray, t_max, RayKind::Light).is_some()
    }
}

/// Whether the ray meets the side from which the corners run counter-clockwise.
fn is_front(corners: [Vec3; 3], ray: &Ray) -> bool {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(ray.direction) < 0.0
}

fn push(meshes: &mut Vec<Arc<TracedMesh>>, mesh: Arc<TracedMesh>) -> u32 {
    meshes.push(mesh);
    meshes.len() as u32 - 1
}

/// The inverse, where there is one to speak of: the volume of the transformed unit cube against the product of its
/// edges tells how flat it is.
fn inverse(transform: &Affine3A) -> Option<Affine3A> {
    let m = transform.matrix3;
    let edges = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let flatness = m.determinant().abs() / edges;
    let inverse = transform.inverse();
    // The negated comparison is true for NaN.
    if !(flatness > 1e-6) || !inverse.is_finite() { None } else { Some(inverse) }
}

/// The mesh with its vertices in the target space. Normals go by the cofactor matrix, which singular transforms have
/// too.
fn moved(mesh: &Mesh, transform: &Affine3A) -> Mesh {
    let m = transform.matrix3;
    let (x, y, z) = (Vec3::from(m.x_axis), Vec3::from(m.y_axis), Vec3::from(m.z_axis));
    let normal = |n: Vec3| (y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z).normalize_or_zero();
    let vertex = |vertex: &Vertex| {
        let tangent = transform.transform_vector3(Vec3::from_slice(&vertex.tangent[..3])).normalize_or_zero();
        Vertex {
            position: transform.transform_point3(vertex.position.into()).to_array(),
            normal: normal(vertex.normal.into()).to_array(),
            tangent: tangent.extend(vertex.tangent[3]).to_array(),
            uv: vertex.uv,
        }
    };
    Mesh::new(mesh.name.clone(), mesh.vertices.iter().map(vertex).collect(), mesh.indices.clone())
}

/// A little larger than computed: the corners that rays meet are rounded on another way than the box is.
fn grown(bounds: &Aabb) -> Aabb {
    let margin = 4.0 * f32::EPSILON * bounds.min.abs().max(bounds.max.abs());
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}
