//! Broken and extreme input: what is stated of each comes out, a finite image, a black one, or an error that says what is
//! wrong.

use super::rig::Rig;
use super::setup::{Grid, Method};
use anyhow::Result;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The outcome of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// An image, finite everywhere, that shows light.
    Lit,
    /// A black image.
    Black,
    /// An error in words.
    Refused(String),
    /// Neither: what happened.
    Broken(String),
}

/// The required outcome of one, whatever the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stated {
    /// A finite image that shows light.
    Lit,
    /// A finite image, black or not: what is odd may hide all else.
    Drawn,
    /// A black image.
    Black,
    /// An error that says this.
    Refused(&'static str),
    /// With instant radiosity an error that says this, otherwise a finite image that shows light.
    RefusedByVpl(&'static str),
}

impl Stated {
    /// Whether it came out so.
    pub fn holds(self, method: Method, outcome: &Outcome) -> bool {
        match (self, outcome) {
            (Self::RefusedByVpl(part), Outcome::Refused(why)) => method == Method::Vpl && why.contains(part),
            (Self::Refused(part), Outcome::Refused(why)) => why.contains(part),
            (Self::RefusedByVpl(_), outcome) => method != Method::Vpl && *outcome == Outcome::Lit,
            (Self::Lit, outcome) => *outcome == Outcome::Lit,
            (Self::Black, outcome) => *outcome == Outcome::Black,
            (Self::Drawn, outcome) => matches!(outcome, Outcome::Lit | Outcome::Black),
            (Self::Refused(_), _) => false,
        }
    }
}

/// Prefabs that the scenes name, which lie beside them: a lamp, ten thousand of them, and a fog.
pub const PREFABS: [(&str, &str); 3] = [
    (
        "one_lamp.prefab.ron",
        "Prefab(entities: [(name: \"Lamp\", light: (kind: Point, intensity: 1e-3, casts_shadow: false, indirect: false))])",
    ),
    (
        "many_lamps.prefab.ron",
        "Prefab(entities: [(name: \"Rows\", prefab: \"one_lamp.prefab.ron\", repeat: Grid(count: (100, 1, 100), spacing: (0.1, 0.1, 0.1)))])",
    ),
    (
        "fog.prefab.ron",
        "Prefab(entities: [(name: \"Fog\", fog: (shape: Sphere(radius: 0.2), extinction: 1, falloff: 0.1))])",
    ),
];

/// Scenes by name, with what must come of them.
pub fn scenes() -> Vec<(&'static str, Stated, String)> {
    use Stated::{Black, Drawn, Lit, Refused, RefusedByVpl};
    let ball = "(name: \"Ball\", transform: (translation: (0, 0.5, 0)), mesh: Sphere(radius: 0.5)),";
    let floor = "(name: \"Floor\", mesh: Box(size: (4, 0.1, 4))),";
    let lamp =
        "(name: \"Lamp\", transform: (translation: (1, 2, 1)), light: (kind: Point, intensity: 3, rsm_size: 16)),";
    let camera = "(name: \"Camera\", transform: (translation: (0, 1, 3), look_at: (0, 0.5, 0)), camera: (fov: 45)),";
    let methods = "(name: \"Methods\", clpv: (quality: Low), vpl: (particles: 64), slc: (rsm_size: 16)),";
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
    let with_fog =
        |fields: &str| whole(&format!("(name: \"Fog\", transform: (translation: (0, 0.5, 0)), fog: ({fields})),"));
    let with_particles = |fields: &str| {
        whole(&format!("(name: \"Fire\", transform: (translation: (0.8, 0.4, 0.4)), particles: ({fields})),"))
    };
    let with_glass = |fields: &str| {
        whole(&format!(
            "(name: \"Glass\", transform: (translation: (0.3, 0.5, 0.8)), mesh: Sphere(radius: 0.3), material: ({fields})),"
        ))
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
        ("an empty scene", Refused("the scene has no camera"), scene(&[])),
        ("a camera alone", Black, scene(&[camera])),
        ("no lamp", Black, scene(&[floor, ball, camera, methods])),
        ("no object", Black, scene(&[lamp, camera, methods])),
        ("scale zero", Lit, whole("(name: \"Flat\", transform: (scale: 0), mesh: Sphere(radius: 1)),")),
        (
            "scale zero along one axis",
            Lit,
            whole("(name: \"Flat\", transform: (scale: (1, 0, 1)), mesh: Sphere(radius: 1)),"),
        ),
        (
            "scale NaN",
            Refused("`scale` is not finite"),
            whole("(name: \"Odd\", transform: (scale: NaN), mesh: Sphere(radius: 1)),"),
        ),
        ("a scale of 1e30", Drawn, whole("(name: \"Huge\", transform: (scale: 1e30), mesh: Sphere(radius: 1)),")),
        (
            "a place of 1e30",
            Drawn,
            whole("(name: \"Far\", transform: (translation: (1e30, 0, 0)), mesh: Sphere(radius: 1)),"),
        ),
        ("a radius of 1e-30", Refused("lengths lie between"), whole("(name: \"Dot\", mesh: Sphere(radius: 1e-30)),")),
        ("a radius below zero", Refused("lengths lie between"), whole("(name: \"Odd\", mesh: Sphere(radius: -1)),")),
        ("a lamp in a wall", Lit, whole("(name: \"Inside\", light: (kind: Point, intensity: 3, rsm_size: 16)),")),
        (
            "a lamp on the camera",
            Lit,
            whole("(name: \"On\", transform: (translation: (0, 1, 3)), light: (kind: Point, intensity: 3)),"),
        ),
        ("a camera in an object", Drawn, with_camera("(0, 0.5, 0)", "fov: 45")),
        ("a camera at a lamp", Black, with_camera("(1, 2, 1)", "fov: 45")),
        ("a field of view of 0", Refused("between 0 and 180 degrees"), with_camera("(0, 1, 3)", "fov: 0")),
        ("a field of view of 180", Refused("between 0 and 180 degrees"), with_camera("(0, 1, 3)", "fov: 180")),
        ("a near plane of 0", Refused("use a distance above zero"), with_camera("(0, 1, 3)", "fov: 45, near: 0")),
        (
            "a far plane before the near one",
            Refused("put the far plane behind"),
            with_camera("(0, 1, 3)", "fov: 45, near: 1, far: 0.5"),
        ),
        ("parallel lines of sight", Lit, with_camera("(0, 1, 3)", "projection: Orthographic(height: 3), near: 0")),
        ("parallel in an object", Drawn, with_camera("(0, 0.5, 0)", "projection: Orthographic(height: 1e-3), near: 0")),
        (
            "an image of no height",
            Refused("Orthographic(height: …)"),
            with_camera("(0, 1, 3)", "projection: Orthographic(height: 0)"),
        ),
        ("an image of 1000 km", Drawn, with_camera("(0, 1, 3)", "projection: Orthographic(height: 1e6)")),
        ("a cell size of 0", Refused("use a length above zero"), with_clpv("cell_size: Meters(0)")),
        ("a cell size of NaN", Refused("use a length above zero"), with_clpv("cell_size: Meters(NaN)")),
        ("a cell size of 1e-30", Drawn, with_clpv("cell_size: Meters(1e-30)")),
        ("a cell size of 1e30", Drawn, with_clpv("cell_size: Meters(1e30)")),
        ("no cells", Refused("use 1 to 128 cells"), with_clpv("cells: (0, 8, 8), cell_size: Meters(0.2)")),
        (
            "a million cells along an axis",
            Refused("use 1 to 128 cells"),
            with_clpv("cells: (1000000, 8, 8), cell_size: Meters(0.2)"),
        ),
        ("a million cascades", Refused("use 1 to 4"), with_clpv("transport: Diffusion, cascades: 1000000")),
        ("four thousand million steps", Refused("use 0 to 1024"), with_clpv("transport: Diffusion, steps: 4000000000")),
        ("glass", Lit, with_glass("transmission: 1, roughness: 0, volume: ()")),
        ("a ball that is a thin wall", Lit, with_glass("transmission: 1, roughness: 0, double_sided: true")),
        ("glass that takes all light", Lit, with_glass("transmission: 1, volume: (color: (0, 0, 0), distance: 1e-6)")),
        ("glass of the largest index", Lit, with_glass("transmission: 1, ior: 10, roughness: 0, volume: ()")),
        ("glass that is only air", Lit, with_glass("transmission: 1, ior: 1, roughness: 1, volume: ()")),
        ("glass of metal", Lit, with_glass("transmission: 1, metallic: 1, volume: ()")),
        ("glass that shines", Lit, with_glass("transmission: 1, emissive: (5, 5, 5), volume: ()")),
        ("blended glass", Lit, with_glass("transmission: 1, alpha: 0.5, alpha_mode: Blend, volume: ()")),
        (
            "a lamp in fog in glass",
            Lit,
            whole(
                "(name: \"Ball of glass\", transform: (translation: (0, 0.6, 0.9)), mesh: Sphere(radius: 0.4), material: (transmission: 1, roughness: 0.2, volume: ()), children: [(name: \"Inside\", light: (kind: Point, intensity: 1), fog: (shape: Sphere(radius: 0.3), extinction: 2))]),",
            ),
        ),
        (
            "a camera in glass",
            Drawn,
            whole(
                "(name: \"Around\", transform: (translation: (0, 1, 3)), mesh: Sphere(radius: 0.5), material: (transmission: 1, double_sided: true, volume: ())),",
            ),
        ),
        (
            "glass that parts colours as far as can be",
            Lit,
            with_glass("transmission: 1, roughness: 0, dispersion: 100, volume: ()"),
        ),
        ("a smooth coat", Lit, with_glass("clearcoat: ()")),
        (
            "a rough coat on metal that shines",
            Lit,
            with_glass("clearcoat: (roughness: 1), metallic: 1, emissive: (5, 5, 5)"),
        ),
        ("sheen of no roughness", Lit, with_glass("sheen: (roughness: 0)")),
        ("sheen on metal", Lit, with_glass("sheen: (roughness: 1), metallic: 1, roughness: 0")),
        (
            "a highlight as long as can be",
            Lit,
            with_glass("anisotropy: (strength: 1, rotation: 1e30), roughness: 0, metallic: 1"),
        ),
        ("a film of no thickness", Lit, with_glass("iridescence: (thickness: 0)")),
        (
            "a film of the largest index",
            Lit,
            with_glass("iridescence: (ior: 10, thickness: 100000), metallic: 1, roughness: 0"),
        ),
        (
            "all layers at once",
            Lit,
            with_glass("clearcoat: (factor: 0.5), sheen: (), anisotropy: (), iridescence: (), roughness: 0.3"),
        ),
        (
            "layers on glass",
            Lit,
            with_glass("transmission: 1, clearcoat: (), sheen: (), anisotropy: (), iridescence: (), volume: ()"),
        ),
        ("a coat above 1", Refused("use 0 to 1"), with_glass("clearcoat: (factor: 2)")),
        ("a film of NaN", Refused("use 0 to 100000"), with_glass("iridescence: (thickness: NaN)")),
        ("an index of refraction of 0", Refused("use 1 to 10"), with_glass("transmission: 1, ior: 0")),
        ("an index of refraction of NaN", Refused("use 1 to 10"), with_glass("transmission: 1, ior: NaN")),
        ("transmission above 1", Refused("use 0 to 1"), with_glass("transmission: 2")),
        (
            "absorption over no distance",
            Refused("`distance` is 0"),
            with_glass("transmission: 1, volume: (distance: 0)"),
        ),
        ("fog that lets no light pass", Drawn, with_fog("extinction: 1e6")),
        ("fog of 1e-30", Lit, with_fog("extinction: 1e-30")),
        ("fog of nothing", Lit, with_fog("extinction: 0")),
        ("fog of 1 µm", Lit, with_fog("extinction: 1e6, shape: Box(size: (1e-6, 1e-6, 1e-6))")),
        ("a ball of fog of 1 µm", Lit, with_fog("extinction: 1e6, shape: Sphere(radius: 1e-6)")),
        ("a ball of fog of 1000 km", Drawn, with_fog("extinction: 1e-6, shape: Sphere(radius: 1e6)")),
        ("fog that ends above its base", Drawn, with_fog("extinction: 1e6, falloff: 1e6")),
        ("a thin layer of fog", Drawn, with_fog("extinction: 1e6, falloff: 1e6, shape: Box(size: (4, 1e-6, 4))")),
        ("fog that scatters onward", Drawn, with_fog("extinction: 0.2, albedo: (1, 1, 1), anisotropy: 0.95")),
        ("fog that scatters back", Drawn, with_fog("extinction: 0.2, albedo: (1, 1, 1), anisotropy: -0.95")),
        ("black smoke", Drawn, with_fog("extinction: 5, albedo: (0, 0, 0)")),
        (
            "fog scaled to nothing",
            Lit,
            whole("(name: \"Fog\", transform: (scale: (1, 0, 1)), fog: (shape: Box(size: (1, 1, 1)), extinction: 1)),"),
        ),
        (
            "fog scaled by 1e30",
            Drawn,
            whole("(name: \"Fog\", transform: (scale: 1e30), fog: (shape: Sphere(radius: 1), extinction: 1)),"),
        ),
        (
            "fog at a place of 1e30",
            Lit,
            whole(
                "(name: \"Fog\", transform: (translation: (1e30, 0, 0)), fog: (shape: Sphere(radius: 1), extinction: 1)),",
            ),
        ),
        (
            "a hundred fogs",
            Drawn,
            whole(
                "(name: \"Fogs\", prefab: \"fog.prefab.ron\", repeat: Grid(count: (10, 1, 10), spacing: (0.3, 0.3, 0.3))),",
            ),
        ),
        ("an extinction below zero", Refused("use 0 to 1e6 [1/m]"), with_fog("extinction: -0.1")),
        ("an extinction of NaN", Refused("use 0 to 1e6 [1/m]"), with_fog("extinction: NaN")),
        ("an extinction of 1e30", Refused("use 0 to 1e6 [1/m]"), with_fog("extinction: 1e30")),
        ("fog brighter than light", Refused("use 0 to 1"), with_fog("albedo: (2, 2, 2)")),
        ("an anisotropy of 1", Refused("use -0.95 to 0.95"), with_fog("anisotropy: 1")),
        ("an anisotropy of NaN", Refused("use -0.95 to 0.95"), with_fog("anisotropy: NaN")),
        ("a falloff below zero", Refused("`falloff` is -1"), with_fog("falloff: -1")),
        ("a box of fog without height", Refused("1e-6 to 1e6 m"), with_fog("shape: Box(size: (1, 0, 1))")),
        ("a ball of fog without end", Refused("1e-6 to 1e6 m"), with_fog("shape: Sphere(radius: inf)")),
        ("sparks", Lit, with_particles("")),
        ("sparks and no other light", Lit, scene(&[floor, ball, camera, methods, "(name: \"Fire\", particles: ()),"])),
        ("one particle", Lit, with_particles("rate: 0.5, life: 0.1")),
        ("no particle", Lit, with_particles("rate: 0")),
        ("particles that are born and die at once", Lit, with_particles("rate: 1e6, life: 0.001")),
        ("particles of no size", Lit, with_particles("radius: 0, end_radius: 0")),
        ("particles of 1e-30 m", Lit, with_particles("radius: 1e-30, end_radius: 1e-30")),
        ("particles of 1 km", Drawn, with_particles("rate: 4, radius: 1e3, end_radius: 1e3")),
        ("particles of 1e12", Drawn, with_particles("radiance: 1e12")),
        ("particles without light", Lit, with_particles("radiance: 0")),
        (
            "particles that fly 1e4 m/s",
            Drawn,
            with_particles("velocity: (0, 1e4, 0), life: 1e3, rate: 0.1, spread: 180"),
        ),
        (
            "particles scaled to nothing",
            Lit,
            whole("(name: \"Fire\", transform: (translation: (0.8, 0.4, 0.4), scale: 0), particles: ()),"),
        ),
        (
            "particles at a place of 1e30",
            Drawn,
            whole("(name: \"Fire\", transform: (translation: (1e30, 0, 0)), particles: ()),"),
        ),
        ("a rate of 1e9", Refused("use 0 to 1e6 [1/s]"), with_particles("rate: 1e9")),
        ("a rate of NaN", Refused("use 0 to 1e6 [1/s]"), with_particles("rate: NaN")),
        ("a hundred thousand particles", Refused("at most 65536"), with_particles("rate: 1e5, life: 1")),
        ("a life of 0", Refused("use 0.001 to 1e4 s"), with_particles("life: 0")),
        ("a particle's radius below zero", Refused("use 0 to 1e3 m"), with_particles("radius: -1")),
        ("a velocity of NaN", Refused("`velocity` is"), with_particles("velocity: (NaN, 0, 0)")),
        ("a radiance without end", Refused("use 0 to 1e12"), with_particles("radiance: inf")),
        ("an intensity of 1e30", Lit, with_lamp("Point", "1e30")),
        ("an intensity of 1e38", Lit, with_lamp("Directional", "1e38")),
        ("an intensity below zero", Refused("use finite numbers from zero up"), with_lamp("Point", "-1")),
        ("an intensity of NaN", Refused("use finite numbers from zero up"), with_lamp("Point", "NaN")),
        ("a spot light without width", Refused("0 ≤ inner < outer ≤ 90"), with_lamp("Spot(inner: 0, outer: 0)", "3")),
        (
            "a spot light of half a turn",
            Refused("0 ≤ inner < outer ≤ 90"),
            with_lamp("Spot(inner: 90, outer: 90)", "3"),
        ),
        ("a spot light inside out", Refused("0 ≤ inner < outer ≤ 90"), with_lamp("Spot(inner: 60, outer: 30)", "3")),
        (
            "a shadow map of a million texels",
            Refused("use 16 to 8192 texels"),
            whole("(name: \"Wide\", light: (kind: Point, intensity: 1, shadow_size: 1000000)),"),
        ),
        (
            "virtual lights without number",
            RefusedByVpl("virtual lights cannot be made"),
            scene(&[floor, ball, lamp, camera, "(name: \"M\", vpl: (particles: 4000000000)),"]),
        ),
        (
            "a light map of a million texels",
            Refused("use 8 to 4096 texels"),
            scene(&[floor, ball, lamp, camera, "(name: \"M\", slc: (rsm_size: 1000000)),"]),
        ),
        (
            "a million lamps at once",
            Refused("ask for 1 to 10,000 copies"),
            whole(
                "(name: \"Lamps\", prefab: \"one_lamp.prefab.ron\", repeat: Grid(count: (100, 100, 100), spacing: (1, 1, 1))),",
            ),
        ),
        (
            "a million lamps in a hundred prefabs",
            Refused("entities"),
            whole(
                "(name: \"Lamps\", prefab: \"many_lamps.prefab.ron\", repeat: Grid(count: (1, 100, 1), spacing: (1, 1, 1))),",
            ),
        ),
        (
            "a thousand lamps",
            Lit,
            whole(
                "(name: \"Lamps\", transform: (translation: (0, 1, 0)), prefab: \"one_lamp.prefab.ron\", repeat: Grid(count: (10, 10, 10), spacing: (0.3, 0.05, 0.3))),",
            ),
        ),
        (
            "a material of albedo 1",
            Lit,
            format!(
                "Scene(materials: {{\"w\": (color: (1, 1, 1))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "a material brighter than light",
            Refused("use 0 to 1"),
            format!(
                "Scene(materials: {{\"w\": (color: (9, 9, 9))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "an object that shines 1e30",
            Lit,
            format!(
                "Scene(materials: {{\"w\": (color: (1, 1, 1), emissive: (1e30, 1e30, 1e30))}}, entities: [{floor}{lamp}{camera}{methods}(name: \"Box\", mesh: Box(size: (1, 1, 1)), material: \"w\"),])"
            ),
        ),
        (
            "a sky of 1e30",
            Lit,
            format!("Scene(settings: (sky: (1e30, 1e30, 1e30)), entities: [{floor}{ball}{lamp}{camera}{methods}])"),
        ),
        (
            "an object in itself",
            Refused("two siblings are named `Ball`"),
            scene(&[floor, ball, ball, lamp, camera, methods]),
        ),
    ]
}

/// Tries one with a method.
pub fn attempt(rig: &mut Rig, method: Method, text: &str) -> Outcome {
    rig.take_not_finite();
    let drawn = catch_unwind(AssertUnwindSafe(|| -> Result<bool> {
        let mut session = rig.open(text, &method.look(Grid::Auto, 0))?;
        Ok(rig.draw(&mut session, false)?.values().any(|value| value > 0.0))
    }));
    match (drawn, rig.take_not_finite()) {
        (Ok(Ok(true)), 0) => Outcome::Lit,
        (Ok(Ok(false)), 0) => Outcome::Black,
        (Ok(Ok(_)), values) => Outcome::Broken(format!("{values} values are not finite")),
        (Ok(Err(error)), _) => Outcome::Refused(format!("{error:#}")),
        (Err(panic), _) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Outcome::Broken(format!("panic: {}", text.unwrap_or("without words")))
        }
    }
}
