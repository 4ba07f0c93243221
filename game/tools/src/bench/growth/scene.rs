//! Scenes of a wanted size, as the text of their files: a floor under a sun, in a space of 20 m, with what grows on it.

use super::axis::{Axis, Series};
use std::fmt::Write;

/// Edge of the space \[m\].
const SPACE: f64 = 20.0;
/// Spheres that share the triangles.
const SPHERES: u64 = 100;

/// The image that a point is drawn in [pixels].
pub fn size(axis: Axis, count: u64) -> [u32; 2] {
    match axis {
        Axis::Pixels => [count.isqrt() as u32; 2],
        _ => [256; 2],
    }
}

/// The scene of a point.
pub fn text(axis: Axis, series: Series, count: u64) -> String {
    let mut text = String::from(
        "Scene(materials: {\"floor\": (color: (0.6, 0.6, 0.6), specular: 0), \"0\": (color: (0.7, 0.2, 0.2)), \
         \"1\": (color: (0.2, 0.6, 0.3)), \"2\": (color: (0.2, 0.3, 0.7)), \"3\": (color: (0.7, 0.7, 0.6), roughness: 0.3)}, \
         entities: [\n(name: \"Camera\", transform: (translation: (0, 14, 22), look_at: (0, 0, 0)), camera: (fov: 60)),\n\
         (name: \"Floor\", mesh: Plane(size: (24, 24)), material: \"floor\"),\n\
         (name: \"Wall\", transform: (translation: (0, 3, -12)), mesh: Box(size: (24, 6, 0.4)), material: \"0\"),\n",
    );
    if axis != Axis::Lights {
        text += "(name: \"Sun\", transform: (rotation: (-55, 30, 0)), light: (kind: Directional, intensity: 4)),\n";
    }
    text += &format!(
        "(name: \"Light volume\", transform: (translation: (0, 3, 0)), clpv: ({})),\n",
        volume(axis, series, count)
    );
    match axis {
        Axis::Objects => boxes(&mut text, count),
        Axis::Triangles => spheres(&mut text, count),
        Axis::Lights => {
            boxes(&mut text, 100);
            lights(&mut text, count);
        }
        Axis::Cells | Axis::Directions | Axis::Pixels => boxes(&mut text, 100),
    }
    text + "])\n"
}

fn volume(axis: Axis, series: Series, count: u64) -> String {
    let transport =
        if series == Series::Diffusion { "Diffusion, steps: 16, bounce: false" } else { "Sweep, bounces: Count(1)" };
    let grid = |edge: u64| format!("cell_size: Meters({:e}), cells: ({edge}, {edge}, {edge})", 26.0 / edge as f64);
    let quality = match (axis, count) {
        (Axis::Directions, 192) => "Medium",
        (Axis::Directions, 432) => "High",
        (Axis::Directions, 768) => "Ultra",
        _ => "Low",
    };
    let grid = match axis {
        Axis::Cells => grid((count as f64).cbrt().round() as u64),
        _ => grid(24),
    };
    format!("quality: {quality}, transport: {transport}, {grid}")
}

/// Places of so many things in a square, row by row, and the room that each has \[m\].
fn places(count: u64) -> (impl Iterator<Item = (u64, f64, f64)>, f64) {
    let edge = (count as f64).sqrt().ceil().max(1.0) as u64;
    let room = SPACE / edge as f64;
    let at = move |i: u64| (i as f64 + 0.5) * room - 0.5 * SPACE;
    ((0..count).map(move |i| (i, at(i % edge), at(i / edge))), room)
}

fn boxes(text: &mut String, count: u64) {
    let (places, room) = places(count);
    for (i, x, z) in places {
        // Of different heights and turns, and of one mesh, as crates and trees are.
        let (height, turn) = (0.3 + 0.7 * ((i * 7) % 10) as f64 / 10.0, (i * 37) % 90);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "(name: \"Box {i}\", transform: (translation: ({x:.4}, {:.4}, {z:.4}), rotation: (0, {turn}, 0), scale: ({:.4}, {:.4}, {:.4})), \
             mesh: Box(size: (1, 1, 1)), material: \"{}\"),",
            0.5 * room * height,
            0.5 * room,
            room * height,
            0.5 * room,
            i % 4
        );
    }
}

fn spheres(text: &mut String, count: u64) {
    // A sphere of s segments and s/2 rings has 2·s·(s/2 − 1) triangles.
    let segments = 1 + ((count / SPHERES) as f64).sqrt().ceil() as u64;
    let (places, room) = places(SPHERES);
    for (i, x, z) in places {
        // Each of another radius, so that none shares the triangles of another.
        let radius = 0.3 * room * (1.0 + i as f64 / SPHERES as f64);
        let _ = writeln!(
            text,
            "(name: \"Sphere {i}\", transform: (translation: ({x:.4}, {radius:.4}, {z:.4})), mesh: Sphere(radius: {radius:.6}, \
             segments: {segments}, rings: {}), material: \"{}\"),",
            (segments / 2).max(2),
            i % 4
        );
    }
}

fn lights(text: &mut String, count: u64) {
    let (places, _) = places(count);
    for (i, x, z) in places {
        let _ = writeln!(
            text,
            "(name: \"Lamp {i}\", transform: (translation: ({x:.4}, 0.6, {z:.4})), light: (kind: Point, intensity: 0.1, \
             range: 1, casts_shadow: false, indirect: false)),",
        );
    }
}
