//! The room that is stressed: a box with a block and a ball in it under three lights, as the text of a scene.

use lightwell::render::GiMethod;
use lightwell_runtime::cli::{LookArgs, Only, TraceArgs};
use std::fmt::Write;

/// A light method under stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Direct light with shadow maps.
    Direct,
    /// Light propagation volumes as in the thesis.
    Diffusion,
    /// Light propagation volumes, swept.
    Sweep,
    /// The same with radiance in flight in half precision.
    HalfSweep,
    /// The same as scenes use it: of medium quality, with rays that gather the light.
    Gather,
    /// Instant radiosity.
    Vpl,
    /// Stochastic light culling.
    Slc,
    /// The path tracer.
    Reference,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Direct,
        Self::Diffusion,
        Self::Sweep,
        Self::HalfSweep,
        Self::Gather,
        Self::Vpl,
        Self::Slc,
        Self::Reference,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Diffusion => "diffusion",
            Self::Sweep => "sweep",
            Self::HalfSweep => "half sweep",
            Self::Gather => "gather",
            Self::Vpl => "vpl",
            Self::Slc => "slc",
            Self::Reference => "reference",
        }
    }

    /// Whether its images have noise, which other random numbers change.
    pub fn is_random(self) -> bool {
        matches!(self, Self::Vpl | Self::Reference)
    }

    /// Bounces of light that it has, if not all.
    pub fn bounces(self) -> Option<u32> {
        if self == Self::Slc { Some(1) } else { None }
    }

    /// How its volumes carry light, as a scene writes it.
    pub fn transport(self) -> &'static str {
        match self {
            Self::Diffusion => "transport: Diffusion",
            Self::HalfSweep => "transport: Sweep, precision: Half",
            _ => "transport: Sweep",
        }
    }

    /// Quality of its volumes, as a scene writes it: rays gather from medium on.
    pub fn quality(self) -> &'static str {
        if self == Self::Gather { "quality: Medium" } else { "quality: Low" }
    }

    /// The layer that is drawn: the light that the method itself computes.
    pub fn look(self, grid: Grid, seed: u32) -> LookArgs {
        let (gi, only) = match self {
            Self::Direct => (GiMethod::NONE, Only::Direct),
            Self::Diffusion | Self::Sweep | Self::HalfSweep | Self::Gather => (GiMethod::CLPV, Only::Indirect),
            Self::Vpl => (GiMethod::VPL, Only::Indirect),
            Self::Slc => (GiMethod::SLC, Only::Indirect),
            Self::Reference => (GiMethod::REFERENCE, Only::Indirect),
        };
        let spp = [4, 8, 16][grid as usize];
        LookArgs { gi: Some(gi), only, trace: TraceArgs { spp, seed, bounces: None }, ..LookArgs::default() }
    }
}

/// Where the cells are; for methods without cells, how many lights or samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// Around the whole scene (few lights or samples).
    Auto,
    /// Around the room, in cells of its own (more).
    Fixed,
    /// Ahead of the camera, snapped to its cells (most).
    Camera,
}

impl Grid {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Fixed, Self::Camera];
}

/// Which lights are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lamps {
    /// A spot light, a point light, and a sun.
    All,
    /// The spot light and the point light.
    Inside,
    /// The sun.
    Sun,
}

/// Edge of a cell of [`Grid::Fixed`] [units of the room].
pub const CELL: f32 = 0.125;

/// The room in one state: a row of the matrix, and one change.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Light method.
    pub method: Method,
    /// Its cells.
    pub grid: Grid,
    /// Length of a unit \[m\]; the room is two units wide.
    pub scale: f32,
    /// Factor on all light.
    pub intensity: f32,
    /// Euler angles of the room \[degrees\].
    pub tilt: [f32; 3],
    /// Place of the room [units].
    pub position: [f32; 3],
    /// Turned by 90° about the vertical axis, after the tilt.
    pub quarter_turn: bool,
    /// Reflected in the plane x = position.x.
    pub mirrored: bool,
    /// Lights that are on.
    pub lamps: Lamps,
    /// Entities and lights listed in the reverse order.
    pub reversed: bool,
    /// Shift of the point light [units].
    pub moved: f32,
    /// Seed of the random numbers.
    pub seed: u32,
}

struct Entity {
    name: &'static str,
    place: [f32; 3],
    turn: [f32; 3],
    parts: String,
}

fn vector(v: [f32; 3]) -> String {
    format!("({:e}, {:e}, {:e})", v[0], v[1], v[2])
}

impl Setup {
    /// Factor on the intensity of lights that spread, to keep the irradiance: E = I/d².
    fn spread(&self) -> f32 {
        self.intensity * self.scale * self.scale
    }

    fn lengths(&self, v: [f32; 3]) -> String {
        vector(v.map(|x| x * self.scale))
    }

    /// An entity's line; reflected where the room is: (x, y, z) → (−x, y, z), and angles about y and z change sign.
    fn line(&self, entity: &Entity) -> String {
        let Entity { name, place: [x, y, z], turn: [a, b, c], parts } = entity;
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        // Around its middle, in which the volumes stand.
        let (place, turn) = (self.lengths([sign * x, *y - 1.0, *z]), vector([*a, sign * b, sign * c]));
        format!("(name: \"{name}\", transform: (translation: {place}, rotation: {turn}), {parts}),\n")
    }

    fn slab(&self, name: &'static str, place: [f32; 3], size: [f32; 3], material: &str) -> Entity {
        let parts = format!("mesh: Box(size: {}), material: \"{material}\"", self.lengths(size));
        Entity { name, place, turn: [0.0; 3], parts }
    }

    fn walls(&self) -> Vec<Entity> {
        vec![
            self.slab("Floor", [0.0, -0.05, 0.0], [2.2, 0.1, 2.0], "white"),
            self.slab("Ceiling", [0.0, 2.05, 0.0], [2.2, 0.1, 2.0], "white"),
            self.slab("Back", [0.0, 1.0, -1.05], [2.2, 2.2, 0.1], "white"),
            self.slab("Left", [-1.05, 1.0, 0.0], [0.1, 2.0, 2.0], "red"),
            self.slab("Right", [1.05, 1.0, 0.0], [0.1, 2.0, 2.0], "green"),
            Entity { turn: [0.0, 17.0, 0.0], ..self.slab("Block", [-0.4, 0.5, -0.3], [0.6, 1.0, 0.6], "white") },
            Entity {
                name: "Ball",
                place: [0.4, 0.35, 0.3],
                turn: [0.0; 3],
                parts: format!("mesh: Sphere(radius: {:e}), material: \"satin\"", 0.35 * self.scale),
            },
        ]
    }

    fn lamps(&self) -> Vec<Entity> {
        let lamp = |name, place, turn, kind: &str, intensity: f32, lit: bool| {
            // Not zero: a dark light has no light map, and the diffusion takes its blockers from those.
            let intensity = if lit { intensity } else { 1e-20 * intensity };
            let parts = format!("light: (kind: {kind}, intensity: {intensity:e}, rsm_size: 64, shadow_size: 256)");
            Entity { name, place, turn, parts }
        };
        let (inside, sun) = (self.lamps != Lamps::Sun, self.lamps != Lamps::Inside);
        let point = [-0.4 + self.moved, 1.3, 0.6];
        vec![
            lamp("Spot", [0.2, 1.9, 0.1], [-90.0, 0.0, 0.0], "Spot(inner: 30, outer: 55)", 6.0 * self.spread(), inside),
            lamp("Point", point, [0.0; 3], "Point", 1.5 * self.spread(), inside),
            lamp("Sun", [0.0, 3.0, 3.0], [-35.0, 20.0, 0.0], "Directional", 2.0 * self.intensity, sun),
        ]
    }

    fn settings_of_methods(&self) -> Entity {
        // Ahead of the camera the coarsest volume holds the room: the second of the diffusion, the sweep's only one.
        let has_two = self.grid == Grid::Camera && self.method == Method::Diffusion;
        let cell = CELL * self.scale * if self.grid == Grid::Camera && !has_two { 2.0 } else { 1.0 };
        let (place, size) = match self.grid {
            Grid::Auto => ("Fixed", "Auto".to_owned()),
            Grid::Fixed => ("Fixed", format!("Meters({cell:e})")),
            Grid::Camera => ("Camera(ahead: 0.5)", format!("Meters({cell:e})")),
        };
        let cells = 32;
        let (quality, transport) = (self.method.quality(), self.method.transport());
        let (particles, rsm) = ([32, 64, 128][self.grid as usize], [32, 64, 64][self.grid as usize]);
        let cascades = if has_two { 2 } else { 1 };
        let seed = self.seed;
        let parts = format!(
            "clpv: ({quality}, {transport}, placement: {place}, cell_size: {size}, cells: ({cells}, {cells}, \
             {cells}), cascades: {cascades}, steps: 12), vpl: (particles: {particles}, seed: {seed}), slc: (rsm_size: {rsm}, interleave: 2, seed: {seed})"
        );
        Entity { name: "Methods", place: [0.0, 1.0, 0.0], turn: [0.0; 3], parts }
    }

    /// The scene as a file holds it.
    pub fn text(&self) -> String {
        // Beside the middle: the edges of a room seen from its middle run through the centres of pixels, where two
        // surfaces are equally far.
        let camera = Entity {
            name: "Camera",
            place: [0.0131, 1.0071, 3.6],
            turn: [0.0; 3],
            parts: format!("camera: (fov: 38, near: {:e})", 0.05 * self.scale),
        };
        let mut entities = self.walls();
        entities.extend(self.lamps());
        entities.push(self.settings_of_methods());
        entities.push(camera);
        if self.reversed {
            entities.reverse();
        }
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        let [a, b, c] = self.tilt;
        let turn = if self.quarter_turn { sign * 90.0 } else { 0.0 };
        let mut text = String::from(
            "Scene(materials: {\"white\": (color: (0.7, 0.7, 0.7), specular: 0), \"red\": (color: (0.6, 0.1, 0.1), \
             specular: 0), \"green\": (color: (0.15, 0.5, 0.1), specular: 0), \"satin\": (color: (0.5, 0.5, 0.6), \
             roughness: 0.5)}, entities: [\n",
        );
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "(name: \"Place\", transform: (translation: {}, rotation: (0, {turn}, 0)), children: [\n\
             (name: \"Room\", transform: (rotation: {}), children: [",
            self.lengths(self.position),
            vector([a, sign * b, sign * c]),
        );
        entities.iter().for_each(|entity| text.push_str(&self.line(entity)));
        text + "])])])\n"
    }
}
