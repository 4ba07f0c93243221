//! Lights, cameras, boxes and directions as lines.

use crate::bvh::Bvh;
use crate::render::debug_settings::Line;
use crate::scene::{Aabb, LightShape, SceneCamera, SceneLight};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Segments of a circle.
const SEGMENTS: usize = 48;
/// Irradiance that bounds a light without a range [W/m²].
const FAINT: f32 = 0.1;

/// The twelve edges of a box.
pub fn box_edges(bounds: &Aabb) -> [[Vec3; 2]; 12] {
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    };
    const EDGES: [[usize; 2]; 12] =
        [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
    EDGES.map(|edge| edge.map(corner))
}

/// A box as lines.
pub(super) fn box_lines(bounds: &Aabb, color: Vec3) -> impl Iterator<Item = Line> + use<> {
    box_edges(bounds).into_iter().map(move |[from, to]| Line::new(from, to, color))
}

fn circle(center: Vec3, x: Vec3, y: Vec3, color: Vec3) -> impl Iterator<Item = Line> {
    let at = move |i: usize| {
        let turn = Vec2::from_angle(TAU * i as f32 / SEGMENTS as f32);
        center + x * turn.x + y * turn.y
    };
    (0..SEGMENTS).map(move |i| Line::new(at(i), at(i + 1), color))
}

/// How far the light reaches \[m\]: its range, or where it is faint, but no farther than `most`.
fn reach(light: &SceneLight, most: f32) -> f32 {
    light.range.unwrap_or_else(|| (light.intensity.max_element().max(0.0) / FAINT).sqrt()).min(most)
}

/// Hue of a light at full brightness.
fn hue(light: &SceneLight) -> Vec3 {
    let color = light.intensity.max(Vec3::ZERO);
    let brightest = color.max_element();
    // The exponent is that of a screen, near enough.
    if brightest > 0.0 { (color / brightest).powf(1.0 / 2.2) } else { Vec3::splat(0.5) }
}

/// The volume of a light: a sphere, a cone, the surface that it has, or parallel arrows on the scene's bounds.
pub(super) fn light_lines(light: &SceneLight, bounds: &Aabb) -> Vec<Line> {
    let color = hue(light);
    let most = 2.0 * bounds.size().length().max(1.0);
    let turn = Quat::from_rotation_arc(Vec3::Z, light.direction.normalize_or(Vec3::Z));
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn * axis);
    match light.shape {
        LightShape::Point => {
            let r = reach(light, most);
            let circles = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
            circles.into_iter().flat_map(|(a, b)| circle(light.position, a * r, b * r, color)).collect()
        }
        LightShape::Spot { inner, outer } => {
            let r = reach(light, most);
            let rim = |angle: f32| (light.position + z * (r * angle.cos()), r * angle.sin());
            let (center, radius) = rim(outer);
            let sides = [x, -x, y, -y].map(|side| Line::new(light.position, center + side * radius, color));
            let inner = (inner > 0.0).then(|| rim(inner));
            let inner = inner.into_iter().flat_map(|(center, r)| circle(center, x * r, y * r, 0.6 * color));
            sides.into_iter().chain(circle(center, x * radius, y * radius, color)).chain(inner).collect()
        }
        LightShape::Sphere { .. }
        | LightShape::Disc { .. }
        | LightShape::Rectangle { .. }
        | LightShape::Tube { .. } => surface_lines(light, color),
        LightShape::Directional | LightShape::Sun { .. } => {
            let half = 0.5 * bounds.size();
            let spread = 0.6 * half.length();
            let from = bounds.center() - z * half.length();
            let length = 0.5 * spread;
            let starts = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i as f32, j as f32)));
            let arrow = |(i, j): (f32, f32)| {
                let start = from + (x * i + y * j) * spread;
                let tip = start + z * length;
                let barb = |side: Vec3| Line::new(tip, tip - z * (0.2 * length) + side * (0.1 * length), color);
                [Line::new(start, tip, color), barb(x), barb(-x)]
            };
            starts.flat_map(arrow).collect()
        }
    }
}

/// The outline of a light's surface; of a flat one with a line to the side that it shines to.
fn surface_lines(light: &SceneLight, color: Vec3) -> Vec<Line> {
    let (center, axis) = (light.position, light.axis);
    let across = light.direction.cross(axis);
    let toward = |length: f32| Line::new(center, center + light.direction * length, color);
    match light.shape {
        LightShape::Sphere { radius: r } => {
            let circles = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
            circles.into_iter().flat_map(|(a, b)| circle(center, a * r, b * r, color)).collect()
        }
        LightShape::Disc { radius: r } => circle(center, axis * r, across * r, color).chain([toward(r)]).collect(),
        LightShape::Rectangle { half_size } => {
            let (x, y) = (axis * half_size.x, across * half_size.y);
            let corners = [x + y, y - x, -x - y, x - y].map(|corner| center + corner);
            let edges = (0..4).map(|i| Line::new(corners[i], corners[(i + 1) % 4], color));
            edges.chain([toward(half_size.min_element())]).collect()
        }
        LightShape::Tube { half_length, radius } => {
            let ends = [-half_length, half_length].map(|along| center + axis * along);
            let rims = ends.into_iter().flat_map(|end| circle(end, light.direction * radius, across * radius, color));
            let sides = [light.direction, across, -light.direction, -across].map(|side| side * radius);
            let sides = sides.map(|side| Line::new(ends[0] + side, ends[1] + side, color));
            rims.chain(sides).collect()
        }
        _ => Vec::new(),
    }
}

/// The view volume of a camera: its pyramid or box up to `depth` \[m\], with a mark on the upper edge.
pub(super) fn camera_lines(camera: &SceneCamera, aspect: f32, depth: f32) -> Vec<Line> {
    const COLOR: Vec3 = Vec3::new(0.55, 0.8, 1.0);
    let half = camera.half_height();
    let is_parallel = camera.is_orthographic();
    let depth = camera.far.unwrap_or(depth).min(depth).max(camera.near);
    let at = |x: f32, y: f32, d: f32| {
        let wide = if is_parallel { half } else { half * d };
        camera.world_from_view.transform_point3(Vec3::new(x * aspect * wide, y * wide, -d))
    };
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut lines = Vec::new();
    for (i, (x, y)) in corners.into_iter().enumerate() {
        let (next_x, next_y) = corners[(i + 1) % 4];
        lines.push(Line::new(at(x, y, camera.near), at(x, y, depth), COLOR));
        for d in [camera.near, depth] {
            lines.push(Line::new(at(x, y, d), at(next_x, next_y, d), COLOR));
        }
    }
    let top = at(0.0, 1.35, depth);
    lines.push(Line::new(at(-0.3, 1.0, depth), top, COLOR));
    lines.push(Line::new(top, at(0.3, 1.0, depth), COLOR));
    lines
}

/// Boxes of one level of a hierarchy, and of the leaves above it; every branch has its own hue.
pub(super) fn bvh_lines(bvh: &Bvh, level: u32, most: usize) -> Vec<Line> {
    let mut open = vec![(0_usize, 0_u32, 0.0_f32)];
    let mut lines = Vec::new();
    while let Some((index, depth, hue)) = open.pop() {
        let Some(node) = bvh.nodes.get(index) else { continue };
        if lines.len() >= most {
            break;
        }
        if depth == level || node.count > 0 {
            lines.extend(box_lines(&node.bounds(), rainbow(hue)));
            continue;
        }
        let step = 0.5_f32.powi(depth as i32 + 1);
        let first = node.first as usize;
        open.extend([(first, depth + 1, hue), (first + 1, depth + 1, hue + step)]);
    }
    lines
}

/// A saturated colour; 0 and 1 are red.
fn rainbow(hue: f32) -> Vec3 {
    let channel = |shift: f32| (((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.15, 1.0);
    Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0))
}

/// Directions as a star around a point; the colour is that of the axes.
pub(super) fn direction_lines(directions: &[Vec3], center: Vec3, length: f32) -> Vec<Line> {
    let line = |d: &Vec3| Line::new(center + 0.15 * length * *d, center + length * *d, 0.2 + 0.8 * d.abs());
    directions.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneId;

    fn light(shape: LightShape) -> SceneLight {
        SceneLight {
            id: SceneId(1),
            name: "light".into(),
            shape,
            intensity: Vec3::new(0.4, 0.2, 0.0),
            position: Vec3::new(1.0, 2.0, 3.0),
            direction: Vec3::NEG_Y,
            axis: Vec3::X,
            range: None,
            casts_shadow: true,
            indirect: true,
            shadow_size: 64,
            rsm_size: 64,
            revision: 1,
        }
    }

    const BOUNDS: Aabb = Aabb { min: Vec3::splat(-5.0), max: Vec3::splat(5.0) };

    #[test]
    fn a_box_has_four_edges_along_each_axis() {
        let edges = box_edges(&Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) });
        for (axis, length) in [(0, 1.0), (1, 2.0), (2, 3.0)] {
            let along = edges.iter().filter(|[a, b]| (*b - *a)[axis] == length && (*b - *a).length() == length);
            assert_eq!(along.count(), 4);
        }
    }

    #[test]
    fn a_point_light_ends_where_it_is_faint_or_at_its_range() {
        let mut point = light(LightShape::Point);
        for expected in [2.0, 0.7] {
            for line in light_lines(&point, &BOUNDS) {
                let distance = Vec3::from(line.from).distance(point.position);
                assert!((distance - expected).abs() < 1e-4, "{distance}, not {expected}");
            }
            point.range = Some(0.7);
        }
    }

    #[test]
    fn a_cone_opens_by_its_angle() {
        let spot = light(LightShape::Spot { inner: 0.0, outer: 0.5 });
        let lines = light_lines(&spot, &BOUNDS);
        for line in &lines[..4] {
            let side = (Vec3::from(line.to) - spot.position).normalize();
            assert!((side.dot(Vec3::NEG_Y).acos() - 0.5).abs() < 1e-4);
        }
    }

    #[test]
    fn a_level_of_a_hierarchy_holds_everything() {
        let boxes: Vec<Aabb> =
            (0..64).map(|i| Aabb { min: Vec3::splat(i as f32), max: Vec3::splat(i as f32 + 0.5) }).collect();
        let bvh = Bvh::new(&boxes, 2);
        for (level, least) in [(0, 1), (3, 4), (40, 32)] {
            let lines = bvh_lines(&bvh, level, 1 << 20);
            assert!(lines.len() >= 12 * least, "level {level}: {}", lines.len());
            let ends = lines.iter().flat_map(|line| [line.from, line.to].map(Vec3::from));
            let all = Aabb::from_points(ends);
            assert_eq!((all.min, all.max), (Vec3::ZERO, Vec3::splat(63.5)));
        }
    }
}
