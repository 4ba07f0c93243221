//! Broken and extreme input: a finite image, or an error that says what is wrong.

use super::rig::Rig;
use super::setup::{Grid, Method};
use anyhow::Result;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What came of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// An image, finite everywhere.
    Image,
    /// An error in words.
    Refused(String),
    /// Neither: what happened.
    Broken(String),
}

/// Scenes by name.
pub fn scenes() -> Vec<(&'static str, String)> {
    let ball = "(name: \"Ball\", transform: (translation: (0, 0.5, 0)), mesh: Sphere(radius: 0.5)),";
    let floor = "(name: \"Floor\", mesh: Box(size: (4, 0.1, 4))),";
    let lamp =
        "(name: \"Lamp\", transform: (translation: (1, 2, 1)), light: (kind: Point, intensity: 3, rsm_size: 16)),";
    let camera = "(name: \"Camera\", transform: (translation: (0, 1, 3), look_at: (0, 0.5, 0)), camera: (fov: 45)),";
    let methods = "(name: \"Methods\", clpv: (quality: Low), vpl: (particles: 16), slc: (rsm_size: 16)),";
    let scene = |entities: &[&str]| format!("Scene(entities: [\n{}\n])\n", entities.join("\n"));
    let whole = |change: &str| scene(&[floor, ball, lamp, camera, methods, change]);
    let with_lamp = |kind: &str, intensity: &str| {
        whole(&format!(
            "(name: \"Extra\", transform: (translation: (-1, 1.5, 1)), light: (kind: {kind}, intensity: {intensity})),"
        ))
    };
    let with_clpv = |fields: &str| {
        scene(&[floor, ball, lamp, camera, &format!("(name: \"Methods\", clpv: (quality: Low, {fields})),")])
    };
    let with_camera = |at: &str, fields: &str| {
        scene(&[
            floor,
            ball,
            lamp,
            methods,
            &format!("(name: \"Camera\", transform: (translation: {at}), camera: ({fields})),"),
        ])
    };
    vec![
        ("an empty scene", scene(&[])),
        ("a camera alone", scene(&[camera])),
        ("no lamp", scene(&[floor, ball, camera, methods])),
        ("no object", scene(&[lamp, camera, methods])),
        ("scale zero", whole("(name: \"Flat\", transform: (scale: 0), mesh: Sphere(radius: 1)),")),
        (
            "scale zero along one axis",
            whole("(name: \"Flat\", transform: (scale: (1, 0, 1)), mesh: Sphere(radius: 1)),"),
        ),
        ("scale NaN", whole("(name: \"Odd\", transform: (scale: NaN), mesh: Sphere(radius: 1)),")),
        ("a scale of 1e30", whole("(name: \"Huge\", transform: (scale: 1e30), mesh: Sphere(radius: 1)),")),
        ("a place of 1e30", whole("(name: \"Far\", transform: (translation: (1e30, 0, 0)), mesh: Sphere(radius: 1)),")),
        ("a radius of 1e-30", whole("(name: \"Dot\", mesh: Sphere(radius: 1e-30)),")),
        ("a radius below zero", whole("(name: \"Odd\", mesh: Sphere(radius: -1)),")),
        ("a lamp in a wall", whole("(name: \"Inside\", light: (kind: Point, intensity: 3, rsm_size: 16)),")),
        (
            "a lamp on the camera",
            whole("(name: \"On\", transform: (translation: (0, 1, 3)), light: (kind: Point, intensity: 3)),"),
        ),
        ("a camera in an object", with_camera("(0, 0.5, 0)", "fov: 45")),
        ("a camera at a lamp", with_camera("(1, 2, 1)", "fov: 45")),
        ("a field of view of 0", with_camera("(0, 1, 3)", "fov: 0")),
        ("a field of view of 180", with_camera("(0, 1, 3)", "fov: 180")),
        ("a near plane of 0", with_camera("(0, 1, 3)", "fov: 45, near: 0")),
        ("a far plane before the near one", with_camera("(0, 1, 3)", "fov: 45, near: 1, far: 0.5")),
        ("parallel lines of sight", with_camera("(0, 1, 3)", "projection: Orthographic(height: 3), near: 0")),
        ("parallel in an object", with_camera("(0, 0.5, 0)", "projection: Orthographic(height: 1e-3), near: 0")),
        ("an image of no height", with_camera("(0, 1, 3)", "projection: Orthographic(height: 0)")),
        ("an image of 1000 km", with_camera("(0, 1, 3)", "projection: Orthographic(height: 1e6)")),
        ("a cell size of 0", with_clpv("cell_size: Meters(0)")),
        ("a cell size of NaN", with_clpv("cell_size: Meters(NaN)")),
        ("a cell size of 1e-30", with_clpv("cell_size: Meters(1e-30)")),
        ("a cell size of 1e30", with_clpv("cell_size: Meters(1e30)")),
        ("no cells", with_clpv("cells: (0, 8, 8), cell_size: Meters(0.2)")),
        ("a million cells along an axis", with_clpv("cells: (1000000, 8, 8), cell_size: Meters(0.2)")),
        ("a million cascades", with_clpv("transport: Diffusion, cascades: 1000000")),
        ("four thousand million steps", with_clpv("transport: Diffusion, steps: 4000000000")),
        ("an intensity of 1e30", with_lamp("Point", "1e30")),
        ("an intensity of 1e38", with_lamp("Directional", "1e38")),
        ("an intensity below zero", with_lamp("Point", "-1")),
        ("an intensity of NaN", with_lamp("Point", "NaN")),
        ("a spot light without width", with_lamp("Spot(inner: 0, outer: 0)", "3")),
        ("a spot light of half a turn", with_lamp("Spot(inner: 90, outer: 90)", "3")),
        ("a spot light inside out", with_lamp("Spot(inner: 60, outer: 30)", "3")),
        (
            "a shadow map of a million texels",
            whole("(name: \"Wide\", light: (kind: Point, intensity: 1, shadow_size: 1000000)),"),
        ),
        (
            "virtual lights without number",
            scene(&[floor, ball, lamp, camera, "(name: \"M\", vpl: (particles: 4000000000)),"]),
        ),
        (
            "a light map of a million texels",
            scene(&[floor, ball, lamp, camera, "(name: \"M\", slc: (rsm_size: 1000000)),"]),
        ),
        (
            "a million lamps",
            whole(
                "(name: \"Lamps\", transform: (scale: 1e-3), children: [], prefab: \"many.prefab.ron\", repeat: Grid(count: (100, 100, 100), spacing: (1, 1, 1))),",
            ),
        ),
        (
            "a material of albedo 1",
            format!(
                "Scene(materials: {{\"w\": (color: (1, 1, 1))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "a material brighter than light",
            format!(
                "Scene(materials: {{\"w\": (color: (9, 9, 9))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "an object that shines 1e30",
            format!(
                "Scene(materials: {{\"w\": (color: (1, 1, 1), emissive: (1e30, 1e30, 1e30))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "a sky of 1e30",
            format!("Scene(settings: (sky: (1e30, 1e30, 1e30)), entities: [{floor}{ball}{lamp}{camera}{methods}])"),
        ),
        ("an object in itself", scene(&[floor, ball, ball, lamp, camera, methods])),
    ]
}

/// Tries one with a method.
pub fn attempt(rig: &mut Rig, method: Method, text: &str) -> Outcome {
    rig.take_not_finite();
    let drawn = catch_unwind(AssertUnwindSafe(|| -> Result<()> {
        let mut session = rig.open(text, &method.look(Grid::Auto, 0))?;
        rig.draw(&mut session, false).map(drop)
    }));
    match (drawn, rig.take_not_finite()) {
        (Ok(Ok(())), 0) => Outcome::Image,
        (Ok(Ok(())), values) => Outcome::Broken(format!("{values} values are not finite")),
        (Ok(Err(error)), _) => Outcome::Refused(format!("{error:#}")),
        (Err(panic), _) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Outcome::Broken(format!("panic: {}", text.unwrap_or("without words")))
        }
    }
}
