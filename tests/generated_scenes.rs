//! Scenes of random boxes, balls, lamps and materials, at scales from a micrometre to a thousand kilometres and lights
//! from 10⁻¹² to 10¹²: whatever the light method, every pixel is finite, and a second run gives the same bits.
//!
//! The scenes are the same in every run. `LIGHTWELL_SCENES=1000` tries more; what fails is made as small as it can be
//! and printed as the text of a scene.

use lightwell_runtime::cli::Common;
use lightwell_tools::scene_test::{Options, Outcome, TestCase, run};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use std::fmt::Write as _;
use std::path::Path;

/// A scene but for its scale, which is the same for all lengths.
#[derive(Clone, Debug)]
struct Generated {
    /// Length of a unit \[m\].
    scale: f32,
    /// Distance from the origin, in units.
    offset: f32,
    /// Factor on all light.
    intensity: f32,
    sky: [f32; 3],
    fov: f32,
    volume: String,
    materials: Vec<Surface>,
    bodies: Vec<Body>,
    lamps: Vec<Lamp>,
    method: &'static str,
}

#[derive(Clone, Debug)]
struct Surface {
    color: [f32; 3],
    roughness: f32,
    metallic: f32,
    specular: f32,
    glow: f32,
}

#[derive(Clone, Debug)]
struct Body {
    shape: (u32, [f32; 3]),
    place: [f32; 3],
    turn: [f32; 3],
    scale: &'static str,
    material: usize,
}

#[derive(Clone, Debug)]
struct Lamp {
    kind: &'static str,
    place: [f32; 3],
    turn: [f32; 3],
    rsm_size: u32,
    shadow_size: u32,
    casts_shadow: bool,
}

const MATERIALS: usize = 4;

fn one_of<T: Clone + std::fmt::Debug + 'static>(values: &[T]) -> impl Strategy<Value = T> + use<T> {
    prop::sample::select(values.to_vec())
}

fn triple(low: f32, high: f32) -> impl Strategy<Value = [f32; 3]> {
    [low..high, low..high, low..high]
}

fn surface() -> impl Strategy<Value = Surface> {
    let color = prop_oneof![Just([0.0; 3]), Just([1.0; 3]), triple(0.0, 1.0)];
    let glow = prop_oneof![3 => Just(0.0), 1 => 0.0..2.0_f32];
    (color, one_of(&[0.0, 1e-3, 0.3, 1.0]), one_of(&[0.0, 0.5, 1.0]), one_of(&[0.0, 0.04, 1.0]), glow)
        .prop_map(|(color, roughness, metallic, specular, glow)| Surface { color, roughness, metallic, specular, glow })
}

fn body() -> impl Strategy<Value = Body> {
    let edge = || one_of(&[1e-4, 0.2, 1.0, 30.0]);
    let scales = ["1", "0", "(1, 0, 1)", "(-1, 1, 1)", "1e-6", "(1000, 0.001, 1)"];
    ((0..3_u32, [edge(), edge(), edge()]), triple(-2.0, 2.0), triple(-180.0, 180.0), one_of(&scales), 0..MATERIALS)
        .prop_map(|(shape, place, turn, scale, material)| Body { shape, place, turn, scale, material })
}

fn lamp() -> impl Strategy<Value = Lamp> {
    let kinds = ["Directional", "Point", "Spot(outer: 0.1, inner: 0)", "Spot(outer: 89, inner: 40)"];
    let place = prop_oneof![1 => Just([0.0; 3]), 3 => triple(-2.0, 3.0)];
    (one_of(&kinds), place, triple(-180.0, 180.0), one_of(&[4, 16, 64]), one_of(&[16, 64, 512]), any::<bool>())
        .prop_map(|(kind, place, turn, rsm_size, shadow_size, casts_shadow)| Lamp {
            kind,
            place,
            turn,
            rsm_size,
            shadow_size,
            casts_shadow,
        })
}

/// Settings of the volumes; `UNIT` stands for the scale.
fn volume() -> impl Strategy<Value = String> {
    let cells = one_of(&["(1, 1, 1)", "(16, 2, 5)", "(24, 24, 24)", "(48, 1, 48)"]);
    let size = one_of(&["Auto", "Auto", "Meters(1e-3)", "Meters(0.2)", "Meters(1e3)"]);
    let placement = one_of(&["Fixed", "Camera(ahead: 0.5)"]);
    let transport = one_of(&["Sweep", "Sweep", "Diffusion"]);
    let bounces = one_of(&["Converged", "Count(1)", "Count(8)"]);
    let gather = one_of(&[
        "gather_rays: Auto",
        "gather_rays: Count(0)",
        "gather_rays: Count(1), gather_filter: 0",
        "gather_rays: Count(3), gather_filter: 32",
    ]);
    (transport, cells, size, placement, 1..5_u32, bounces, gather).prop_map(
        |(transport, cells, size, placement, cascades, bounces, gather)| {
            format!(
                "quality: Low, transport: {transport}, cells: {cells}, cell_size: {size}, placement: {placement}, \
                 cascades: {cascades}, bounces: {bounces}, {gather}"
            )
        },
    )
}

fn generated() -> impl Strategy<Value = Generated> {
    let world = (
        one_of(&[1.0, 1e-6, 1e-3, 1e3, 1e6]),
        one_of(&[0.0, 0.0, 1e2, 1e5]),
        one_of(&[1.0, 1e-12, 1e-6, 1e6, 1e12]),
        prop_oneof![Just([0.0; 3]), triple(0.0, 1.0)],
        one_of(&[45.0, 1.0, 90.0, 170.0]),
    );
    let parts = (vec(surface(), MATERIALS), vec(body(), 0..6), vec(lamp(), 0..4));
    (world, volume(), parts, one_of(&["Clpv", "Clpv", "Vpl", "Slc", "Reference"])).prop_map(
        |((scale, offset, intensity, sky, fov), volume, (materials, bodies, lamps), method)| Generated {
            scale,
            offset,
            intensity,
            sky,
            fov,
            volume,
            materials,
            bodies,
            lamps,
            method,
        },
    )
}

fn vector(v: [f32; 3]) -> String {
    format!("({:e}, {:e}, {:e})", v[0], v[1], v[2])
}

impl Generated {
    fn place(&self, at: [f32; 3]) -> String {
        vector([at[0] + self.offset, at[1], at[2] - self.offset].map(|x| x * self.scale))
    }

    fn light(&self, color: [f32; 3], factor: f32) -> String {
        vector(color.map(|c| c * self.intensity * factor))
    }

    /// The scene as a file holds it.
    fn text(&self) -> String {
        let mut text = format!("Scene(settings: (sky: {}), materials: {{\n", self.light(self.sky, 1.0));
        for (i, m) in self.materials.iter().enumerate() {
            let _ = writeln!(
                text,
                "\"m{i}\": (color: {}, roughness: {:e}, metallic: {:e}, specular: {:e}, emissive: {}),",
                vector(m.color),
                m.roughness,
                m.metallic,
                m.specular,
                self.light([1.0, 0.8, 0.6], m.glow)
            );
        }
        let _ = writeln!(
            text,
            "}}, entities: [\n(name: \"Camera\", transform: (translation: {}, look_at: {}), camera: (fov: {}, near: {:e})),\n\
             (name: \"Volume\", transform: (translation: {}), clpv: ({}), vpl: (particles: 16), slc: (rsm_size: 32)),\n\
             (name: \"Floor\", transform: (translation: {}), mesh: Box(size: {}), material: \"m0\"),",
            self.place([0.0, 1.0, 4.0]),
            self.place([0.0, 0.5, 0.0]),
            self.fov,
            0.01 * self.scale,
            self.place([0.0, 1.0, 0.0]),
            self.volume,
            self.place([0.0, -0.1, 0.0]),
            vector([6.0, 0.2, 6.0].map(|x| x * self.scale)),
        );
        self.bodies.iter().enumerate().for_each(|(i, body)| self.write_body(&mut text, i, body));
        self.lamps.iter().enumerate().for_each(|(i, lamp)| self.write_lamp(&mut text, i, lamp));
        text + "])\n"
    }

    fn write_body(&self, text: &mut String, index: usize, body: &Body) {
        let [x, y, z] = body.shape.1.map(|edge| edge * self.scale);
        let mesh = match body.shape.0 {
            0 => format!("Box(size: {})", vector([x, y, z])),
            1 => format!("Sphere(radius: {x:e})"),
            _ => format!("Cylinder(radius: {x:e}, height: {y:e})"),
        };
        let _ = writeln!(
            text,
            "(name: \"Body {index}\", transform: (translation: {}, rotation: {}, scale: {}), mesh: {mesh}, material: \"m{}\"),",
            self.place(body.place),
            vector(body.turn),
            body.scale,
            body.material
        );
    }

    fn write_lamp(&self, text: &mut String, index: usize, lamp: &Lamp) {
        // The same irradiance whatever the scale: a lamp's falls with the square of its distance.
        let reach = if lamp.kind == "Directional" { 1.0 } else { self.scale * self.scale };
        let _ = writeln!(
            text,
            "(name: \"Lamp {index}\", transform: (translation: {}, rotation: {}), light: (kind: {}, intensity: {:e}, \
             rsm_size: {}, shadow_size: {}, casts_shadow: {})),",
            self.place(lamp.place),
            vector(lamp.turn),
            lamp.kind,
            self.intensity * reach,
            lamp.rsm_size,
            lamp.shadow_size,
            lamp.casts_shadow
        );
    }
}

fn number_of_scenes() -> u32 {
    std::env::var("LIGHTWELL_SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(64)
}

fn check(folder: &Path, scene: &Generated) -> Result<(), String> {
    let text = scene.text();
    let test = format!(
        "SceneTest(description: \"generated\", scene: \"a.scene.ron\", times: [0], size: (32, 32), gi: {}, \
         expect: (deterministic: true))",
        scene.method
    );
    let path = folder.join("a.test.ron");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).map_err(|error| error.to_string());
    write("a.scene.ron", &text)?;
    write("a.test.ron", &test)?;
    let options = Options { common: Common::default(), bless: false, output: folder.join("out") };
    let case = TestCase { name: "a".into(), path };
    match run(&case, &options, &mut None).outcome {
        Outcome::Passed => Ok(()),
        Outcome::Skipped(reason) => Err(reason),
        Outcome::Failed(faults) => Err(format!("{}\n{}\n{text}", scene.method, faults.join("\n"))),
    }
}

#[test]
fn every_scene_gives_a_finite_image_and_the_same_one_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = ProptestConfig { cases: number_of_scenes(), failure_persistence: None, ..Default::default() };
    let mut runner =
        TestRunner::new_with_rng(config, proptest::test_runner::TestRng::deterministic_rng(Default::default()));
    let found = runner.run(&generated(), |scene| check(folder.path(), &scene).map_err(TestCaseError::fail));
    if let Err(TestError::Fail(reason, _)) = &found {
        panic!("{reason}");
    }
    found.expect("scenes are generated");
}
