//! The parts of an interface that changed since it was painted: the damage. Where drivers draw in software, painting a whole window
//! costs as much as a frame of the scene that plays in it.

use egui::epaint::ClippedShape;
use egui::{Rect, Shape, TextureId, Vec2};

/// Most parts that are painted apart.
const MOST_PARTS: usize = 8;
/// Share of the window beyond which all of it is painted.
const MOST_SHARE: f32 = 0.7;
/// What edges are softened beyond a shape \[points\].
const SOFT: f32 = 2.0;

/// What is to be painted again \[points\]: parts that have no pixel in common. None: all.
pub(super) type Damage = Option<Vec<Rect>>;

/// What changed from one run of an interface to the next, in a window of a size \[pixels\] with so many pixels a point. Shapes with
/// the textures that were `touched` count as changed.
pub(super) fn between(
    before: &[ClippedShape],
    now: &[ClippedShape],
    touched: &[TextureId],
    (size, scale): ([u32; 2], f32),
) -> Damage {
    let screen = Rect::from_min_size(egui::Pos2::ZERO, Vec2::from(size.map(|edge| edge as f32)) / scale);
    let mut parts = Vec::new();
    let mut add = |shape: &ClippedShape| add_part(&mut parts, aligned(bounds(shape)?.intersect(screen), scale));
    let same = |(a, b): &(&ClippedShape, &ClippedShape)| a == b;
    let start = before.iter().zip(now).take_while(same).count();
    let [old, new] = [&before[start..], &now[start..]];
    let end = old.iter().rev().zip(new.iter().rev()).take_while(same).count();
    let [old, new] = [&old[..old.len() - end], &new[..new.len() - end]];
    // Where there are as many as before, only those that differ.
    let is_new = |at: usize| old.len() != new.len() || old[at] != new[at];
    for shapes in [old, new] {
        (0..shapes.len()).filter(|at| is_new(*at)).try_for_each(|at| add(&shapes[at]))?;
    }
    now.iter().filter(|shape| is_touched(shape, touched)).try_for_each(&mut add)?;
    let share = parts.iter().map(Rect::area).sum::<f32>() / screen.area().max(1.0);
    (share <= MOST_SHARE).then_some(parts)
}

/// The shapes that paint those parts anew, over a background.
pub(super) fn shapes(all: &[ClippedShape], parts: &[Rect], background: egui::Color32) -> Vec<ClippedShape> {
    let mut shapes = Vec::new();
    for part in parts {
        shapes.push(ClippedShape::new(*part, Shape::rect_filled(part.expand(2.0 * SOFT), 0.0, background)));
        let inside = |shape: &&ClippedShape| bounds(shape).is_none_or(|bounds| bounds.intersects(*part));
        shapes.extend(all.iter().filter(inside).map(|shape| {
            let clip_rect = shape.clip_rect.intersect(*part);
            ClippedShape { clip_rect, ..shape.clone() }
        }));
    }
    shapes.retain(|shape| shape.clip_rect.is_positive());
    shapes
}

fn is_touched(shape: &ClippedShape, touched: &[TextureId]) -> bool {
    fn shows(shape: &Shape, touched: &[TextureId]) -> bool {
        match shape {
            Shape::Vec(parts) => parts.iter().any(|part| shows(part, touched)),
            shape => touched.contains(&shape.texture_id()),
        }
    }
    !touched.is_empty() && shows(&shape.shape, touched)
}

/// What a shape covers at most; none: that is not known.
fn bounds(shape: &ClippedShape) -> Option<Rect> {
    let is_plain = shape.transform_after_tessellation == egui::emath::TSTransform::IDENTITY;
    let covered = match &shape.shape {
        Shape::Callback(_) => return None,
        Shape::Noop => return Some(Rect::NOTHING),
        _ if !is_plain => return Some(shape.clip_rect),
        drawn => drawn.visual_bounding_rect(),
    };
    Some(covered.expand(SOFT).intersect(shape.clip_rect))
}

/// Out to whole pixels.
fn aligned(part: Rect, scale: f32) -> Rect {
    let [min, max] = [part.min, part.max].map(|corner| corner.to_vec2() * scale);
    Rect::from_min_max((min.floor() / scale).to_pos2(), (max.ceil() / scale).to_pos2())
}

/// Adds a part to those known, so that they stay apart and few; always something, for use with `?`.
fn add_part(parts: &mut Vec<Rect>, mut part: Rect) -> Option<()> {
    if !part.is_positive() {
        return Some(());
    }
    loop {
        // Edges that touch share no pixel, but scissors round.
        if let Some(at) = parts.iter().position(|known| known.intersects(part)) {
            part |= parts.swap_remove(at);
        } else if parts.len() >= MOST_PARTS {
            let growth = |known: &Rect| known.union(part).area() - known.area();
            let nearest = (0..parts.len()).min_by(|a, b| growth(&parts[*a]).total_cmp(&growth(&parts[*b])));
            nearest.into_iter().for_each(|at| part |= parts.swap_remove(at));
        } else {
            parts.push(part);
            return Some(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Color32, Pos2, pos2};

    const SIZE: [u32; 2] = [200, 100];

    fn screen() -> Rect {
        Rect::from_min_size(Pos2::ZERO, Vec2::new(200.0, 100.0))
    }

    fn square(x: f32, y: f32, color: Color32) -> ClippedShape {
        let rect = Rect::from_min_size(pos2(x, y), Vec2::splat(10.0));
        ClippedShape::new(screen(), Shape::rect_filled(rect, 0.0, color))
    }

    fn picture(id: u64) -> ClippedShape {
        let rect = Rect::from_min_size(pos2(100.0, 20.0), Vec2::splat(50.0));
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        ClippedShape::new(screen(), Shape::image(TextureId::User(id), rect, whole, Color32::WHITE))
    }

    fn changed(before: &[ClippedShape], now: &[ClippedShape], touched: &[TextureId]) -> Damage {
        between(before, now, touched, (SIZE, 1.0))
    }

    #[test]
    fn only_what_changed_is_painted() {
        let before = [square(5.0, 5.0, Color32::RED), square(50.0, 50.0, Color32::RED), picture(1)];
        assert_eq!(changed(&before, &before, &[]), Some(Vec::new()));
        let now = [square(5.0, 5.0, Color32::BLUE), before[1].clone(), before[2].clone()];
        assert_eq!(changed(&before, &now, &[]), Some(vec![Rect::from_min_max(pos2(3.0, 3.0), pos2(17.0, 17.0))]));
        let both = changed(&before, &now, &[TextureId::User(1)]);
        assert_eq!(both.map(|parts| parts.len()), Some(2), "and the picture");
        assert_eq!(changed(&before, &before, &[TextureId::User(2)]), Some(Vec::new()), "no shape shows that texture");
        let moved = [square(5.0, 5.0, Color32::RED), square(150.0, 50.0, Color32::RED), picture(1)];
        assert_eq!(changed(&before, &moved, &[]).map(|parts| parts.len()), Some(2), "where it was and where it is");
        let more = [before[0].clone(), square(20.0, 70.0, Color32::RED), before[1].clone(), before[2].clone()];
        assert_eq!(changed(&before, &more, &[]).map(|parts| parts.len()), Some(1));
        assert_eq!(changed(&more, &before, &[]).map(|parts| parts.len()), Some(1));
        assert_eq!(changed(&more, &before, &[TextureId::User(1)]).map(|parts| parts.len()), Some(2));
    }

    #[test]
    fn much_is_painted_whole_and_parts_stay_few_and_apart() {
        let whole = |color| ClippedShape::new(screen(), Shape::rect_filled(screen(), 0.0, color));
        assert_eq!(changed(&[whole(Color32::RED)], &[whole(Color32::BLUE)], &[]), None);
        let squares: Vec<_> =
            (0..40).map(|i| square((i % 8) as f32 * 25.0, (i / 8) as f32 * 20.0, Color32::BLUE)).collect();
        let mut parts = Vec::new();
        squares.iter().for_each(|shape| {
            add_part(&mut parts, aligned(bounds(shape).unwrap_or(screen()).intersect(screen()), 1.0));
        });
        assert!(parts.len() <= MOST_PARTS, "{parts:?}");
        for (at, part) in parts.iter().enumerate() {
            assert!(parts[at + 1..].iter().all(|other| !other.intersect(*part).is_positive()), "{parts:?}");
        }
        assert!(squares.iter().all(|shape| {
            parts.iter().any(|part| part.contains_rect(shape.shape.visual_bounding_rect().intersect(screen())))
        }));
    }
}
