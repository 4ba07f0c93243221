//! The edges of fog that is selected: it has no surface that could be outlined.

use super::Editor;
use super::gizmo::Lens;
use super::stage::Stage;
use bevy_ecs::prelude::Entity;
use egui::{Color32, Painter, Stroke};
use glam::{Affine3A, DVec3, Vec2, Vec3};
use lightwell::render::debug::box_edges;
use lightwell::scene::Aabb;
use lightwell::world::{Fog, FogShape, GameWorld, GlobalTransform};
use std::f32::consts::TAU;

/// Most selected entities whose fog is shown.
const MOST: usize = 64;
/// Segments of a circle.
const SEGMENTS: usize = 48;

/// Draws the box or the three circles of each selected fog.
pub fn show(painter: &Painter, editor: &Editor, stage: &Stage, lens: &Lens) {
    let stroke = Stroke::new(1.0, Color32::from_rgb(255, 170, 60));
    for (_, entity) in editor.selected(stage.world).iter().rev().take(MOST) {
        for [a, b] in outline_of(stage.world, *entity, stage.facts.scene.origin) {
            if let Some((a, b)) = lens.segment(a, b) {
                painter.line_segment([a, b], stroke);
            }
        }
    }
}

/// Lines around the fog of the entity and of all below it, from an origin \[m\].
pub fn outline_of(world: &GameWorld, entity: Entity, origin: DVec3) -> Vec<[Vec3; 2]> {
    let fog = |part: Entity| {
        let (fog, place) = world.ecs.get::<Fog>(part).zip(world.ecs.get::<GlobalTransform>(part))?;
        Some(outline(fog.shape, &place.relative_to(origin)))
    };
    world.subtree(entity).into_iter().filter_map(fog).flatten().collect()
}

/// Lines around a space; none around one without edges.
fn outline(shape: FogShape, place: &Affine3A) -> Vec<[Vec3; 2]> {
    let lines: Vec<[Vec3; 2]> = match shape {
        FogShape::Everywhere => Vec::new(),
        FogShape::Box { size } => box_edges(&Aabb { min: -0.5 * size, max: 0.5 * size }).to_vec(),
        FogShape::Sphere { radius } => {
            let planes = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
            planes.into_iter().flat_map(|(x, y)| circle(x * radius, y * radius)).collect()
        }
    };
    let in_world = lines.into_iter().map(|ends| ends.map(|end| place.transform_point3(end)));
    in_world.filter(|[a, b]| a.is_finite() && b.is_finite()).collect()
}

fn circle(x: Vec3, y: Vec3) -> impl Iterator<Item = [Vec3; 2]> {
    let at = move |i: usize| {
        let turn = Vec2::from_angle(TAU * i as f32 / SEGMENTS as f32);
        x * turn.x + y * turn.y
    };
    (0..SEGMENTS).map(move |i| [at(i), at(i + 1)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn bounds(lines: &[[Vec3; 2]]) -> Aabb {
        Aabb::from_points(lines.iter().copied().flatten())
    }

    #[test]
    fn the_outline_is_that_of_the_turned_and_scaled_space() {
        let scale = Vec3::new(2.0, 1.0, 3.0);
        let turn = Quat::from_rotation_y(0.5 * std::f32::consts::PI);
        let place = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::Y);
        let found = outline(FogShape::Box { size: Vec3::new(4.0, 2.0, 1.0) }, &place);
        let (min, max) = (bounds(&found).min, bounds(&found).max);
        assert_eq!(found.len(), 12);
        assert!(min.abs_diff_eq(Vec3::new(-1.5, 0.0, -4.0), 1e-5) && max.abs_diff_eq(Vec3::new(1.5, 2.0, 4.0), 1e-5));
        let ball = bounds(&outline(FogShape::Sphere { radius: 0.5 }, &place));
        assert!(ball.max.abs_diff_eq(Vec3::new(1.5, 1.5, 1.0), 1e-5), "{ball:?}");
    }

    #[test]
    fn what_has_no_edges_has_no_outline() {
        assert!(outline(FogShape::Everywhere, &Affine3A::IDENTITY).is_empty());
        let lost = Affine3A::from_translation(Vec3::NAN);
        assert!(outline(FogShape::Sphere { radius: 1.0 }, &lost).is_empty());
    }
}
