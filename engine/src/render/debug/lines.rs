//! Batches of lines over the image, dim where a surface lies before them: those of debug views, and those of a game.

use super::overlay;
use super::shapes;
use super::{DebugView, Line, cascade_color};
use crate::graph::{Contents, Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::light_volumes::{Volume, sweep};
use crate::world::Transport;
use glam::Vec3;

/// Most lines of the ray hierarchy: twelve a box.
const MOST_BVH_LINES: usize = 12 << 14;

/// Declares the pass, if any view asks for lines; the result is the display image with them.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    volumes: &[Volume],
    display: Handle<Texture>,
) -> Handle<Texture> {
    let views = [DebugView::Lights, DebugView::Cameras, DebugView::Cascades, DebugView::Bvh, DebugView::Directions];
    let debug = &frame.settings.debug;
    if debug.lines.is_empty() && !views.iter().any(|view| debug.shows(*view)) {
        return display;
    }
    let lines = collect(frame, volumes);
    if lines.is_empty() {
        graph.skip("debug lines", "the scene has nothing of what is to be shown");
        return display;
    }
    let mut pass = graph.raster("debug lines");
    let display = pass.color(display, Contents::Kept);
    frame.bind_view(&mut pass);
    pass.values("lines", &lines);
    pass.read("depth", gbuffer.depth);
    pass.step().draw(overlay::pipeline("debug/lines.wgsl", false), [6, lines.len() as u32]);
    pass.finish();
    display
}

fn collect(frame: &Frame, volumes: &[Volume]) -> Vec<Line> {
    let (scene, debug) = (frame.scene, &frame.settings.debug);
    let mut lines = debug.lines.clone();
    if debug.shows(DebugView::Lights) {
        lines.extend(scene.lights.iter().flat_map(|light| shapes::light_lines(light, &frame.bounds)));
    }
    if debug.shows(DebugView::Cameras) {
        let [width, height] = frame.view.size.map(|edge| edge as f32);
        let depth = 0.2 * frame.bounds.size().length().max(1.0);
        let eye = frame.view.camera.world_from_view;
        // Seen from the eye itself, its pyramid would be a frame around the image.
        let others = scene.cameras.iter().filter(|camera| !camera.world_from_view.abs_diff_eq(eye, 1e-4));
        lines.extend(others.flat_map(|camera| shapes::camera_lines(camera, width / height.max(1.0), depth)));
    }
    if debug.shows(DebugView::Cascades) {
        let boxes = volumes.iter().enumerate();
        lines.extend(boxes.flat_map(|(level, volume)| shapes::box_lines(&volume.bounds(), cascade_color(level))));
    }
    if let Some(rays) = frame.rays.filter(|_| debug.shows(DebugView::Bvh)) {
        let boxes = rays.bvh.trees().flat_map(|tree| shapes::bvh_lines(tree, debug.bvh_level, MOST_BVH_LINES));
        lines.extend(boxes.take(MOST_BVH_LINES));
    }
    if debug.shows(DebugView::Directions) {
        lines.extend(directions(frame, volumes));
    }
    lines
}

fn directions(frame: &Frame, volumes: &[Volume]) -> Vec<Line> {
    let (Some(clpv), Some(volume)) = (&frame.scene.clpv, volumes.last()) else { return Vec::new() };
    let directions = match clpv.settings.transport {
        Transport::Sweep => sweep::directions(sweep::quality(frame, &clpv.settings)),
        // Light is passed to the six neighbours.
        Transport::Diffusion => [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]).collect(),
    };
    let bounds = volume.bounds();
    shapes::direction_lines(&directions, bounds.center(), 0.3 * bounds.size().min_element())
}
