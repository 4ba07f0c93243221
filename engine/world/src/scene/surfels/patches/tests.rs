use super::super::group::triangles;
use super::super::{SurfelCloud, fixture};
use super::*;
use crate::assets::Shape;
use crate::scene::{Primitive, Revisions, Scene};
use glam::Affine3A;

fn primitive(id: u64, shape: Shape, place: Affine3A) -> Primitive {
    fixture::primitive(id, Arc::new(shape.mesh().expect("a valid shape")), place)
}

fn scene(primitives: Vec<Primitive>) -> Scene {
    let revisions = Revisions { geometry: 1, ..Default::default() };
    Scene { identity: 1, revisions, primitives, ..Default::default() }
}

/// A point within a triangle, and its outward normal, in the world.
fn points(primitive: &Primitive) -> impl Iterator<Item = (Vec3, Vec3)> {
    let place = primitive.world_from_object;
    let turned = if place.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    triangles(&primitive.mesh).flat_map(move |triangle| {
        let [a, b, c] = triangle.corners.map(|corner| place.transform_point3(corner));
        let normal = turned * (b - a).cross(c - a).normalize_or_zero();
        let weights = [[0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9], [0.34, 0.33, 0.33]];
        weights.map(|[u, v, w]| (u * a + v * b + w * c, normal))
    })
}

/// Every point of every surface has a patch whose surfels lie near it and face its way, however the object is turned,
/// scaled or mirrored, and it is the same object's.
#[test]
fn every_point_of_a_surface_has_a_patch_nearby() {
    let places = [
        Affine3A::IDENTITY,
        Affine3A::from_rotation_y(0.4) * Affine3A::from_rotation_x(1.1) * Affine3A::from_translation(Vec3::splat(3.0)),
        Affine3A::from_scale_rotation_translation(Vec3::splat(2.5), glam::Quat::from_rotation_z(0.3), Vec3::X * 9.0),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 0.5, 1.0),
            glam::Quat::from_rotation_z(0.3),
            Vec3::X * -9.0,
        ),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(-1.0, 1.0, 1.0),
            glam::Quat::from_rotation_y(0.3),
            Vec3::Y * 9.0,
        ),
    ];
    let shapes = [
        Shape::Box { size: [1.0, 2.0, 0.1] },
        Shape::Sphere { radius: 0.7, segments: 24, rings: 12 },
        Shape::Box { size: [0.05, 0.9, 0.05] },
    ];
    for cell in [0.1, 0.45] {
        for shape in &shapes {
            let primitives = (1..).zip(&places).map(|(id, place)| primitive(id, shape.clone(), *place)).collect();
            let scene = scene(primitives);
            let mut cloud = SurfelCloud::default();
            cloud.update(&scene, cell);
            let patches = &cloud.patches;
            let (mut facing, mut all) = (0, 0);
            let is_small = matches!(shape, Shape::Box { size } if size[0] < cell && size[2] < cell);
            for (index, primitive) in scene.primitives.iter().enumerate() {
                let group = cloud.place_of_primitive[index];
                let grid = cells_from_world(&cloud.places[group as usize], patches.size);
                for (point, normal) in points(primitive) {
                    let turned = grid.transform_vector3(normal).normalize();
                    let patch = patches.at(group, grid.transform_point3(point), turned).expect("a patch");
                    let [first, count] = patches.ranges[patch as usize].map(|v| v as usize);
                    let surfels = &cloud.surfels[first..first + count];
                    assert!(surfels.iter().all(|surfel| surfel.group() == group as usize));
                    let place = cloud.places[group as usize];
                    let nearest = surfels.iter().map(|s| place.transform_point3(s.position.into()).distance(point));
                    let nearest = nearest.fold(f32::INFINITY, f32::min);
                    assert!(nearest < 5.0 * patches.size, "{nearest} m, patches of {} m", patches.size);
                    let faces =
                        surfels.iter().any(|s| crate::scene::world_normal(&place, s.normal.into()).dot(normal) > 0.4);
                    facing += u32::from(faces);
                    all += 1;
                }
            }
            // Some sides of what is smaller than a cell have no surfels, and others answer for them.
            let least = if is_small { 0.5 } else { 0.9 };
            assert!(f64::from(facing) > least * f64::from(all), "{facing} of {all} face the same way");
        }
    }
}

#[test]
fn each_surfel_is_in_one_patch_and_objects_that_move_keep_theirs() {
    let mut scene = scene(vec![primitive(1, Shape::Box { size: [1.0; 3] }, Affine3A::IDENTITY)]);
    let mut cloud = SurfelCloud::default();
    cloud.update(&scene, 0.2);
    let mut next = 0;
    for [first, count] in &cloud.patches.ranges {
        assert!(*first == next && *count > 0);
        next += count;
    }
    assert_eq!(next as usize, cloud.surfels.len());
    let (ranges, table) = (cloud.patches.ranges.clone(), cloud.patches.table.clone());
    scene.primitives[0].world_from_object = Affine3A::from_rotation_y(1.0) * Affine3A::from_translation(Vec3::ONE);
    scene.revisions.geometry += 1;
    cloud.update(&scene, 0.2);
    assert!(cloud.patches.ranges == ranges && cloud.patches.table == table);
}

/// A thin wall stands on a floor, across its grid, and neither has a patch on both sides of the other: a point at the foot
/// of the wall finds a patch of its own side, even where its cell has surfels on the other side alone.
#[test]
fn patches_end_at_walls() {
    let turn = Affine3A::from_rotation_y(0.3) * Affine3A::from_rotation_x(0.2);
    for (width, angle) in [(0.01, 0.0), (0.01, 0.6), (0.12, 1.2)] {
        let wall = turn * Affine3A::from_translation(Vec3::new(0.013, 0.9, 0.0)) * Affine3A::from_rotation_y(angle);
        let floor = Shape::Box { size: [4.0, 0.2, 4.0] };
        let place = turn * Affine3A::from_translation(Vec3::Y * -0.1);
        // The wall goes through the floor.
        let upright = Shape::Box { size: [width, 2.4, 9.0] };
        let scene = scene(vec![primitive(1, floor, place), primitive(2, upright, wall)]);
        let mut cloud = SurfelCloud::default();
        cloud.update(&scene, 0.2);
        let side = |point: Vec3| wall.inverse().transform_point3(point).x;
        let mut parted = 0;
        for [first, count] in cloud.patches.ranges.clone() {
            let surfels = &cloud.surfels[first as usize..][..count as usize];
            let sides = surfels.iter().filter(|s| s.group() == 0);
            let sides: Vec<f32> = sides.map(|s| side(cloud.places[0].transform_point3(s.position.into()))).collect();
            parted += u32::from(sides.iter().any(|side| side.abs() < 0.1));
            assert!(sides.windows(2).all(|pair| pair[0] * pair[1] > 0.0), "a patch on both sides: {sides:?}");
        }
        assert!(parted > 20, "{parted} patches at the wall");
        let grid = cells_from_world(&cloud.places[0], cloud.patches.size);
        let normal = grid.transform_vector3(turn.transform_vector3(Vec3::Y)).normalize();
        for step in 0..200 {
            let along = 0.016 * step as f32 - 1.6;
            for from_wall in [-0.05, -0.005, 0.005, 0.05] {
                let across = from_wall + (0.5 * width).copysign(from_wall);
                let foot = wall.transform_point3(Vec3::new(across, -0.9, along));
                let inner = place.inverse().transform_point3(foot);
                if inner.x.abs().max(inner.z.abs()) > 1.9 {
                    continue;
                }
                let patch = cloud.patches.at(0, grid.transform_point3(foot), normal).expect("a patch");
                let surfel = &cloud.surfels[cloud.patches.ranges[patch as usize][0] as usize];
                let found = side(cloud.places[0].transform_point3(surfel.position.into()));
                assert!(found * from_wall > 0.0, "{from_wall} m from the wall, {found} m from it the surfels");
            }
        }
    }
}

/// Occluders of an object are recomputed where they change, and only there.
#[test]
fn walls_that_come_and_go_leave_the_patches_that_are_made_anew() {
    let floor = primitive(1, Shape::Box { size: [4.0, 0.2, 4.0] }, Affine3A::from_translation(Vec3::Y * -0.1));
    let far = primitive(2, Shape::Box { size: [4.0, 0.2, 4.0] }, Affine3A::from_translation(Vec3::Y * -8.0));
    let wall = |x: f32| {
        let place = Affine3A::from_translation(Vec3::new(x, 0.5, 0.0));
        primitive(3, Shape::Box { size: [0.02, 0.98, 4.0] }, place)
    };
    let lost = |moving: bool| Primitive { moving, ..wall(0.3) };
    let states = [vec![], vec![wall(0.05)], vec![wall(0.3)], vec![lost(true)], vec![lost(false)], vec![]];
    let (mut kept, mut counts) = (SurfelCloud::default(), Vec::new());
    for (revision, walls) in (1..).zip(states) {
        let mut scene = scene([floor.clone(), far.clone()].into_iter().chain(walls).collect());
        scene.revisions.geometry = revision;
        kept.update(&scene, 0.2);
        let mut fresh = SurfelCloud::default();
        fresh.update(&scene, 0.2);
        assert!(kept.surfels == fresh.surfels && kept.patches.ranges == fresh.patches.ranges, "state {revision}");
        assert!(kept.patches.table == fresh.patches.table, "state {revision}");
        let of_floor = |range: &&[u32; 2]| kept.surfels[range[0] as usize].group() == 0;
        counts.push(kept.patches.ranges.iter().filter(of_floor).count());
    }
    assert!(counts[1] > counts[0] && counts[2] > counts[0] && counts[4] == counts[2], "{counts:?}");
    assert!(counts[3] == counts[0] && counts[5] == counts[0], "{counts:?}");
}
