//! Small scenes made by hand, for tests that check light against a formula.
#![allow(dead_code, reason = "each test file uses a part of it")]

pub mod grid;

use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Mesh, Shape};
use lightwell::gpu::{Gpu, GpuOptions, ImageF32, default_shader_dir, read_texture_f32};
use lightwell::graph::FrameReport;
use lightwell::measure::Image;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{
    LightShape, MediumShape, Primitive, Revisions, Scene, SceneCamera, SceneClpv, SceneId, SceneLight, SceneMedium,
    SceneView, ViewProjection,
};
use lightwell::world::Clpv;
use std::sync::Arc;

/// The device that tests run on.
pub fn gpu() -> Gpu {
    let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("shaders") };
    Gpu::headless(&options).expect("a Vulkan driver")
}

/// A scene whose arrays the test fills itself.
pub struct Stage {
    pub scene: Scene,
    pub view: SceneView,
    next: u64,
}

impl Stage {
    /// Nothing but a camera that looks from `eye` to `target`, with a square image of 90° and the given edge.
    pub fn new(eye: Vec3, target: Vec3, edge: u32) -> Self {
        let up = if (target - eye).normalize().y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
        let forward = (target - eye).normalize();
        let right = forward.cross(up).normalize();
        let rotation = glam::Mat3::from_cols(right, right.cross(forward), -forward);
        let camera = SceneCamera {
            id: SceneId(1),
            name: "camera".into(),
            world_from_view: Affine3A::from_mat3_translation(rotation, eye),
            projection: ViewProjection::Perspective { vertical_fov: std::f32::consts::FRAC_PI_2 },
            near: 0.01,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
        };
        let scene = Scene {
            identity: 1,
            revisions: Revisions {
                geometry: 1,
                materials: 1,
                lights: 1,
                media: 1,
                cameras: 1,
                clpv: 1,
                methods: 0,
                settings: 1,
                statics: 0,
            },
            ..Default::default()
        };
        Self { scene, view: SceneView { camera, size: [edge, edge], jitter: [0.0; 2] }, next: 10 }
    }

    fn fresh(&mut self) -> SceneId {
        self.next += 1;
        SceneId(self.next)
    }

    /// Adds a shape of a diffuse reflectance.
    pub fn add(&mut self, shape: Shape, albedo: Vec3, world_from_object: Affine3A) {
        self.add_material(shape, Material::diffuse("surface", albedo), world_from_object);
    }

    /// Adds a shape of any material.
    pub fn add_material(&mut self, shape: Shape, material: Material, world_from_object: Affine3A) {
        self.add_mesh(shape.mesh().expect("a valid shape"), material, world_from_object);
    }

    /// Adds a mesh.
    pub fn add_mesh(&mut self, mesh: Mesh, material: Material, world_from_object: Affine3A) {
        let mesh = Arc::new(mesh);
        let id = self.fresh();
        self.scene.primitives.push(Primitive {
            id,
            bounds: mesh.bounds.transformed(&world_from_object),
            mesh,
            material: Arc::new(material),
            world_from_object,
            casts_shadow: true,
            moving: false,
            geometry_revision: 1,
            material_revision: 1,
        });
        self.scene.revisions.geometry += 1;
        self.scene.revisions.materials += 1;
    }

    /// Adds a closed room of inward-facing walls with its lower corner at `min`.
    pub fn add_room(&mut self, min: Vec3, size: Vec3, albedo: Vec3) {
        let center = min + 0.5 * size;
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut inward = Vec3::ZERO;
                inward[axis] = -sign;
                let turn = Quat::from_rotation_arc(Vec3::Y, inward);
                let extent = (turn.inverse() * size).abs();
                let at = center - 0.5 * size * inward;
                let floor = Shape::Plane { size: [extent.x, extent.z], subdivisions: [1, 1] };
                self.add(floor, albedo, Affine3A::from_rotation_translation(turn, at));
            }
        }
    }

    /// Adds light propagation volumes centred on a point.
    pub fn clpv(&mut self, center: Vec3, settings: Clpv) {
        self.scene.clpv = Some(SceneClpv { settings, center });
        self.scene.revisions.clpv += 1;
    }

    /// Adds a light.
    pub fn light(&mut self, shape: LightShape, intensity: Vec3, position: Vec3, direction: Vec3) -> &mut SceneLight {
        let id = self.fresh();
        self.scene.lights.push(SceneLight {
            id,
            name: "light".into(),
            shape,
            intensity,
            position,
            direction: direction.normalize(),
            axis: direction.normalize().any_orthonormal_vector(),
            range: None,
            casts_shadow: true,
            indirect: true,
            shadow_size: 512,
            rsm_size: 64,
            revision: 1,
        });
        self.scene.lights.last_mut().expect("just added")
    }

    /// Adds a medium of that extinction \[1/m\] that scatters all light which it takes, to all sides alike.
    pub fn medium(&mut self, shape: MediumShape, world_from_local: Affine3A, extinction: f32) -> &mut SceneMedium {
        let id = self.fresh();
        self.scene.revisions.media += 1;
        self.scene.media.push(SceneMedium {
            id,
            name: "medium".into(),
            shape,
            local_from_world: world_from_local.inverse(),
            base: world_from_local.translation.into(),
            up: Vec3::Y,
            extinction,
            albedo: Vec3::ONE,
            anisotropy: 0.0,
            falloff: 0.0,
        });
        self.scene.media.last_mut().expect("just added")
    }

    /// Ray through the centre of a pixel: unit direction in world space.
    pub fn ray(&self, x: u32, y: u32) -> Vec3 {
        self.ray_at(x as f32 + 0.5, y as f32 + 0.5)
    }

    /// The same through any place in the image \[pixels\].
    pub fn ray_at(&self, x: f32, y: f32) -> Vec3 {
        let [width, height] = self.view.size.map(|s| s as f32);
        let tangent = self.view.camera.half_height();
        let ndc = glam::Vec2::new(x / width * 2.0 - 1.0, 1.0 - y / height * 2.0);
        let local = Vec3::new(ndc.x * tangent * width / height, ndc.y * tangent, -1.0);
        self.view.camera.world_from_view.transform_vector3(local).normalize()
    }

    /// Draws one layer with a fresh renderer.
    pub fn render(&self, gpu: &Gpu, gi: GiMethod, only: Layer) -> ImageF32 {
        let mut renderer = Renderer::new(gpu);
        self.render_with(gpu, &mut renderer, &RenderSettings { gi, only, ..Default::default() }).0
    }

    /// Draws with a renderer that may hold earlier results.
    pub fn render_with(
        &self,
        gpu: &Gpu,
        renderer: &mut Renderer,
        settings: &RenderSettings,
    ) -> (ImageF32, FrameReport) {
        let report = renderer.render(gpu, &self.scene, &self.view, settings).unwrap_or_else(|e| panic!("{e}"));
        let image = read_texture_f32(gpu, renderer.radiance().expect("an image")).expect("readable");
        for pixel in &image.rgba {
            assert!(pixel.iter().all(|c| c.is_finite()), "a pixel is {pixel:?}");
        }
        (image, report)
    }
}

/// RGB of a pixel.
pub fn rgb(image: &ImageF32, x: u32, y: u32) -> Vec3 {
    let [r, g, b, _] = image.rgba[(x + y * image.width) as usize];
    Vec3::new(r, g, b)
}

/// Root of the mean square difference over the mean, and the difference of the means over it.
pub fn error(found: &ImageF32, expected: &Image) -> (f64, f64) {
    let (mut square, mut difference, mut total) = (0.0, 0.0, 0.0);
    for (a, b) in found.rgba.iter().zip(expected.pixels()) {
        for channel in 0..3 {
            let (a, b) = (f64::from(a[channel]), f64::from(b[channel]));
            square += (a - b).powi(2);
            difference += a - b;
            total += b;
        }
    }
    let values = 3.0 * found.rgba.len() as f64;
    ((square / values).sqrt() / (total / values), difference / total)
}

/// Share of a change from one image to another that has not been followed yet: by least squares over all pixels.
pub fn left_of(before: &Image, after: &Image, found: &ImageF32) -> f64 {
    let (mut along, mut square) = (0.0, 0.0);
    for ((before, after), found) in before.pixels().iter().zip(after.pixels()).zip(&found.rgba) {
        for channel in 0..3 {
            let way = f64::from(before[channel]) - f64::from(after[channel]);
            along += way * (f64::from(found[channel]) - f64::from(after[channel]));
            square += way * way;
        }
    }
    along / square
}
