//! Dynamic objects have a ray hierarchy of their own: images do not depend on which one holds a surface, and uploads are
//! of what moved.

use crate::support::Stage;
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, GpuOptions, RayNodes, default_shader_dir};
use lightwell::measure::Image;
use lightwell::render::RayScene;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::scene::LightShape;

/// Index of a box and of a panel that emits light among the primitives of [`room`].
const BOX: usize = 6;
const PANEL: usize = 7;

/// The layouts of hierarchies: one of them suits the adapter.
const LAYOUTS: [RayNodes; 2] = [RayNodes::Lists, RayNodes::Wide];

fn gpu(layout: RayNodes) -> Gpu {
    let mut gpu = crate::support::gpu();
    gpu.ray_nodes = layout;
    gpu
}

fn idle_gpu(layout: RayNodes) -> Gpu {
    let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("shaders") };
    let mut gpu = Gpu::noop(&options).expect("a device that does nothing");
    gpu.ray_nodes = layout;
    gpu
}

fn place_of_box(step: u32) -> Affine3A {
    let at = Vec3::new(0.3 * step as f32 - 0.4, -0.7, 0.1);
    Affine3A::from_rotation_translation(Quat::from_rotation_y(0.3 + step as f32), at)
}

/// A room with a box on its floor, a panel below its ceiling, a ball and a floor beside the room of an edge of its own.
fn room(plain: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.9), Vec3::ZERO, 24);
    stage.add_room(Vec3::splat(-1.0), Vec3::splat(2.0), Vec3::new(0.7, 0.6, 0.5));
    stage.add(Shape::Box { size: [0.5, 0.6, 0.4] }, Vec3::new(0.2, 0.5, 0.8), place_of_box(0));
    let mut panel = Material::diffuse("panel", Vec3::splat(0.3));
    panel.emissive = Vec3::new(3.0, 2.0, 1.0);
    let down = Affine3A::from_rotation_translation(Quat::from_rotation_x(3.0), Vec3::new(0.1, 0.8, -0.2));
    stage.add_material(Shape::Plane { size: [0.5, 0.3], subdivisions: [1, 1] }, panel, down);
    let ball = Affine3A::from_translation(Vec3::new(0.5, -0.2, -0.4));
    stage.add(Shape::Sphere { radius: 0.3, segments: 48, rings: 24 }, Vec3::splat(0.6), ball);
    let beside = Affine3A::from_translation(Vec3::new(0.0, -5.0, 0.0));
    stage.add(Shape::Plane { size: [plain, plain], subdivisions: [1, 1] }, Vec3::splat(0.5), beside);
    stage.light(LightShape::Point, Vec3::splat(0.5), Vec3::new(-0.5, 0.5, 0.3), Vec3::NEG_Y);
    stage
}

fn trace(gpu: &Gpu, tracer: &mut PathTracer, stage: &Stage) -> Image {
    let settings = TraceSettings { bounces: Some(2), seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("it can be traced");
    tracer.advance(gpu, 4).expect("it can be traced");
    tracer.estimate(gpu).expect("it can be read").total()
}

fn largest_difference(a: &Image, b: &Image) -> f32 {
    a.values().zip(b.values()).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

#[test]
fn images_do_not_tell_what_counts_as_moving() {
    let [lists, wide] = LAYOUTS.map(gpu);
    // Beside a floor of 1000 km boxes are kept as they are.
    for plain in [4.0, 1e6] {
        let mut stage = room(plain);
        let expected = trace(&lists, &mut PathTracer::new(&lists), &stage);
        assert!(expected.mean() > 0.05, "there is light");
        let found = trace(&wide, &mut PathTracer::new(&wide), &stage);
        assert_eq!(largest_difference(&found, &expected), 0.0, "lists and wide nodes, plain of {plain} m");
        let count = stage.scene.primitives.len();
        for moving in [vec![BOX], vec![PANEL], vec![0, 3, BOX, PANEL, 8], (0..count).collect()] {
            for (index, primitive) in stage.scene.primitives.iter_mut().enumerate() {
                primitive.moving = moving.contains(&index);
            }
            for gpu in [&lists, &wide] {
                let found = trace(gpu, &mut PathTracer::new(gpu), &stage);
                let difference = largest_difference(&found, &expected);
                let layout = gpu.ray_nodes;
                assert!(difference <= 1e-6, "{moving:?} moving, {layout:?}, plain of {plain} m: {difference}");
            }
        }
    }
}

#[test]
fn what_followed_is_what_is_made_from_nothing() {
    for layout in LAYOUTS {
        let gpu = gpu(layout);
        let mut stage = room(4.0);
        for index in [BOX, PANEL] {
            stage.scene.primitives[index].moving = true;
        }
        stage.scene.revisions.statics = 1;
        let mut follower = PathTracer::new(&gpu);
        for step in 0..4 {
            stage.scene.primitives[BOX].world_from_object = place_of_box(step);
            if step == 2 {
                // The panel emits from a larger area.
                let panel = &mut stage.scene.primitives[PANEL].world_from_object;
                *panel *= Affine3A::from_scale(Vec3::splat(1.5));
            }
            stage.scene.revisions.geometry += 1;
            let followed = trace(&gpu, &mut follower, &stage);
            let fresh = trace(&gpu, &mut PathTracer::new(&gpu), &stage);
            assert_eq!(largest_difference(&followed, &fresh), 0.0, "{layout:?}, step {step}");
        }
    }
}

/// Two balls of several rows of triangles each may move, and do in turns.
#[test]
fn rows_that_did_not_move_are_kept() {
    for layout in LAYOUTS {
        let gpu = gpu(layout);
        let mut stage = room(4.0);
        let balls = stage.scene.primitives.len();
        for at in [Vec3::new(-0.5, -0.3, 0.0), Vec3::new(0.1, 0.3, -0.5)] {
            let ball = Shape::Sphere { radius: 0.25, segments: 128, rings: 64 };
            stage.add(ball, Vec3::new(0.2, 0.7, 0.4), Affine3A::from_translation(at));
        }
        for primitive in &mut stage.scene.primitives[balls..] {
            primitive.moving = true;
        }
        stage.scene.revisions.statics = 1;
        let mut follower = PathTracer::new(&gpu);
        for (step, moved) in [balls, balls + 1, balls, balls + 1].into_iter().enumerate() {
            stage.scene.primitives[moved].world_from_object.translation.y += 0.07 * (step + 1) as f32;
            stage.scene.revisions.geometry += 1;
            let followed = trace(&gpu, &mut follower, &stage);
            let fresh = trace(&gpu, &mut PathTracer::new(&gpu), &stage);
            assert_eq!(largest_difference(&followed, &fresh), 0.0, "{layout:?}, step {step}");
        }
    }
}

/// What has flown farther away than wide nodes can say takes them along, and what comes back brings them back.
#[test]
fn objects_may_leave_for_any_distance_and_return() {
    let gpu = gpu(RayNodes::Wide);
    let mut stage = room(4.0);
    stage.scene.primitives[BOX].moving = true;
    stage.scene.revisions.statics = 1;
    let mut follower = PathTracer::new(&gpu);
    let seen: Vec<Image> = [0.0, 1e18, 1e30, f32::INFINITY, 0.0]
        .map(|away| {
            let place = Affine3A::from_translation(Vec3::X * away) * place_of_box(0);
            stage.scene.primitives[BOX].world_from_object = place;
            stage.scene.revisions.geometry += 1;
            let followed = trace(&gpu, &mut follower, &stage);
            let fresh = trace(&gpu, &mut PathTracer::new(&gpu), &stage);
            assert_eq!(largest_difference(&followed, &fresh), 0.0, "{away} m away");
            followed
        })
        .into();
    assert_eq!(largest_difference(&seen[0], &seen[4]), 0.0);
    assert!(largest_difference(&seen[0], &seen[1]) > 0.01, "the box is seen");
    assert_eq!(largest_difference(&seen[1], &seen[3]), 0.0, "from afar it makes no difference");
}

/// Of all that may move, what rests is hardly uploaded again.
#[test]
fn uploads_leave_out_what_could_move_and_does_not() {
    for layout in LAYOUTS {
        let gpu = idle_gpu(layout);
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 8);
        stage.add(Shape::Box { size: [0.2; 3] }, Vec3::splat(0.5), Affine3A::from_translation(Vec3::X * 3.0));
        for index in 0..4 {
            let ball = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
            stage.add(ball, Vec3::splat(0.5), Affine3A::from_translation(Vec3::X * (3.0 * index as f32 - 4.5)));
        }
        stage.scene.revisions.statics = 1;
        for primitive in &mut stage.scene.primitives {
            primitive.moving = true;
        }
        let mut rays = RayScene::new(&gpu);
        let mut upload = |stage: &mut Stage, moved: std::ops::Range<usize>| {
            for primitive in &mut stage.scene.primitives[moved] {
                primitive.world_from_object.translation.y += 0.1;
            }
            stage.scene.revisions.geometry += 1;
            let before = gpu.counts();
            rays.update(&gpu, &stage.scene).expect("it fits");
            gpu.counts().since(&before).uploaded
        };
        upload(&mut stage, 0..0);
        let [all, one] = [0..5, 0..1].map(|moved| upload(&mut stage, moved));
        assert!(one < all / 4, "{layout:?}: {one} bytes where one of five moved, {all} where all did");
    }
}

#[test]
fn uploads_follow_what_moves() {
    for layout in LAYOUTS {
        let gpu = idle_gpu(layout);
        for tells in [true, false] {
            let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 8);
            let ball = Shape::Sphere { radius: 1.0, segments: 256, rings: 128 };
            stage.add(ball, Vec3::splat(0.5), Affine3A::IDENTITY);
            for index in 0..20 {
                let at = Affine3A::from_translation(Vec3::X * (2.0 + index as f32));
                stage.add(Shape::Box { size: [0.2; 3] }, Vec3::splat(0.5), at);
            }
            stage.scene.revisions.statics = u64::from(tells);
            let mut rays = RayScene::new(&gpu);
            let mut upload = |stage: &Stage| {
                let before = gpu.counts();
                rays.update(&gpu, &stage.scene).expect("it fits");
                gpu.counts().since(&before).uploaded
            };
            for movers in [1, 20] {
                for primitive in &mut stage.scene.primitives[1..=movers] {
                    primitive.moving = true;
                }
                stage.scene.revisions.geometry += 1;
                stage.scene.revisions.statics += u64::from(tells);
                let whole = upload(&stage);
                assert!(whole > 7_000_000, "{layout:?}: {whole} bytes at first");
                assert_eq!(upload(&stage), 0, "nothing changed");
                for primitive in &mut stage.scene.primitives[1..=movers] {
                    primitive.world_from_object.translation.y += 0.1;
                }
                stage.scene.revisions.geometry += 1;
                let followed = upload(&stage);
                // A triangle has 96 bytes, and less than two boxes in each of eight lists; wide nodes take less.
                let most = 12 * movers as u64 * (96 + 2 * 8 * 16) + 64;
                assert!(
                    followed > 0 && followed <= most,
                    "{layout:?}, {movers} moved: {followed} bytes of {most} at most"
                );
            }
        }
    }
}
