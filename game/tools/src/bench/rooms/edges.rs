//! Pixels near a geometric edge: where surfaces begin, end or bend.

use crate::capture;
use anyhow::Result;
use glam::Vec3;
use lightwell::measure::Image;
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::{SceneCamera, SceneView};
use lightwell_runtime::session::Session;

/// Distance from an edge within which a pixel counts as near to it [pixels].
pub const NEAR: i32 = 4;
/// Cosine of the angle between normals beyond which there is an edge between them: 25°.
const BEND: f32 = 0.906;
/// Step between two surfaces that makes an edge, in pixels' widths at their distance.
const STEP: f32 = 0.5;

/// For each pixel whether it is near a geometric edge.
///
/// # Errors
/// If the scene cannot be drawn.
pub fn near_edges(session: &mut Session, size: [u32; 2]) -> Result<Vec<bool>> {
    let settings = RenderSettings { gi: GiMethod::NONE, average: false, ..session.render_settings(false) };
    let mut layer = |only| capture::take(session, size, 1, &RenderSettings { only, ..settings.clone() });
    let (depth, normal) = (layer(Layer::Depth)?, layer(Layer::Normal)?);
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    Ok(widen(&edges(&depth, &normal, &view.camera), size))
}

/// The surface of a pixel: place relative to the eye and normal; none for the sky.
fn surfaces(depth: &Image, normal: &Image, camera: &SceneCamera) -> Vec<Option<(Vec3, Vec3)>> {
    let [width, height] = depth.size().map(|edge| edge as f32);
    let reach = camera.half_height();
    let of = |index: usize| {
        let (column, row) = (index as u32 % depth.size()[0], index as u32 / depth.size()[0]);
        let x = reach * (2.0 * (column as f32 + 0.5) - width) / height;
        let y = reach * (1.0 - 2.0 * (row as f32 + 0.5) / height);
        let along = Vec3::from(camera.world_from_view.matrix3 * glam::Vec3A::new(x, y, -1.0)).normalize();
        let distance = depth.pixels()[index][0];
        let normal = Vec3::from_array(normal.pixels()[index].map(|value| 2.0 * value - 1.0)).normalize_or_zero();
        (distance > 0.0).then_some((along * distance, normal))
    };
    (0..depth.pixels().len()).map(of).collect()
}

fn edges(depth: &Image, normal: &Image, camera: &SceneCamera) -> Vec<bool> {
    let surfaces = surfaces(depth, normal, camera);
    let [width, height] = depth.size().map(|edge| edge as usize);
    let pixel = 2.0 * camera.half_height() / height as f32;
    let differ = |a: usize, b: usize| match (surfaces[a], surfaces[b]) {
        (None, None) => false,
        (Some((p, n)), Some((q, m))) => {
            let step = STEP * pixel * p.length().min(q.length());
            // A surface seen at a grazing angle goes far from pixel to pixel: what counts is the way off its plane.
            n.dot(m) < BEND || (q - p).dot(n).abs() > step || (q - p).dot(m).abs() > step
        }
        _ => true,
    };
    let mut found = vec![false; width * height];
    for y in 0..height {
        for x in 0..width {
            let here = y * width + x;
            for there in [(x + 1 < width).then_some(here + 1), (y + 1 < height).then_some(here + width)] {
                if let Some(there) = there.filter(|&there| differ(here, there)) {
                    (found[here], found[there]) = (true, true);
                }
            }
        }
    }
    found
}

/// All pixels within [`NEAR`] of one that is set.
fn widen(edges: &[bool], size: [u32; 2]) -> Vec<bool> {
    let [width, height] = size.map(|edge| edge as i32);
    let mut near = vec![false; edges.len()];
    for (index, _) in edges.iter().enumerate().filter(|(_, edge)| **edge) {
        let (column, row) = (index as i32 % width, index as i32 / width);
        for dy in -NEAR..=NEAR {
            for dx in -NEAR..=NEAR {
                let (x, y) = (column + dx, row + dy);
                if dx * dx + dy * dy <= NEAR * NEAR && (0..width).contains(&x) && (0..height).contains(&y) {
                    near[(y * width + x) as usize] = true;
                }
            }
        }
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_widened_by_a_disc() {
        let mut edges = vec![false; 21 * 21];
        edges[10 * 21 + 10] = true;
        let near = widen(&edges, [21, 21]);
        // Points of the whole numbers' grid within a circle of radius 4.
        assert_eq!(near.iter().filter(|near| **near).count(), 49);
        assert!(near[10 * 21 + 14] && !near[14 * 21 + 14]);
    }
}
