//! Procedural shapes: parameters, defaults and their validation. The triangles are made in `shape_mesh`.

use super::AssetError;
use serde::{Deserialize, Serialize};

/// Most segments, sides, rings or subdivisions along one direction.
pub const MAX_SEGMENTS: u32 = 4096;
/// Most vertices of one shape.
const MAX_VERTICES: u64 = 1 << 22;
/// Largest size \[m\]; beyond it squares leave the range of float arithmetic.
const MAX_SIZE: f32 = 1e12;
/// Smallest size \[m\].
const MIN_SIZE: f32 = 1e-12;

/// A procedural mesh centred on the origin, Y up, with outward normals, texture coordinates and tangents.
///
/// Lengths are in metres. All shapes but [`Shape::Quad`] and [`Shape::Plane`] are closed surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
    /// Rectangle in the plane z = 0, facing +Z: two triangles.
    Quad {
        /// Width along x and height along y.
        #[serde(default = "one2")]
        size: [f32; 2],
    },
    /// Rectangle in the plane y = 0, facing +Y, divided into a grid.
    Plane {
        /// Lengths along x and z.
        #[serde(default = "one2")]
        size: [f32; 2],
        /// Grid cells along x and z.
        #[serde(default = "one_cell")]
        subdivisions: [u32; 2],
    },
    /// Box of 12 triangles.
    Box {
        /// Edge lengths along x, y and z.
        #[serde(default = "one3")]
        size: [f32; 3],
    },
    /// Sphere of latitude rings.
    Sphere {
        /// Radius.
        #[serde(default = "half")]
        radius: f32,
        /// Divisions around the axis, at least 3.
        #[serde(default = "segments")]
        segments: u32,
        /// Divisions from pole to pole, at least 2.
        #[serde(default = "rings")]
        rings: u32,
    },
    /// Cylinder along y with flat caps.
    Cylinder {
        /// Radius.
        #[serde(default = "half")]
        radius: f32,
        /// Height.
        #[serde(default = "one")]
        height: f32,
        /// Divisions around the axis, at least 3.
        #[serde(default = "segments")]
        segments: u32,
    },
    /// Cone along y, its tip on top, with a flat base.
    Cone {
        /// Radius of the base.
        #[serde(default = "half")]
        radius: f32,
        /// Height.
        #[serde(default = "one")]
        height: f32,
        /// Divisions around the axis, at least 3.
        #[serde(default = "segments")]
        segments: u32,
    },
    /// Torus around y.
    Torus {
        /// Distance of the tube's centre from the axis.
        #[serde(default = "half")]
        radius: f32,
        /// Radius of the tube, below `radius`.
        #[serde(default = "tube")]
        tube: f32,
        /// Divisions around the axis, at least 3.
        #[serde(default = "segments")]
        segments: u32,
        /// Divisions around the tube, at least 3.
        #[serde(default = "rings")]
        sides: u32,
    },
    /// Cylinder along y with hemispherical ends.
    Capsule {
        /// Radius of cylinder and ends.
        #[serde(default = "quarter")]
        radius: f32,
        /// Height of the cylindrical part; the whole is higher by twice the radius.
        #[serde(default = "half")]
        height: f32,
        /// Divisions around the axis, at least 3.
        #[serde(default = "segments")]
        segments: u32,
        /// Divisions of each hemisphere from rim to pole, at least 1.
        #[serde(default = "cap_rings")]
        rings: u32,
    },
}

fn one() -> f32 {
    1.0
}
fn half() -> f32 {
    0.5
}
fn quarter() -> f32 {
    0.25
}
fn tube() -> f32 {
    0.2
}
fn one2() -> [f32; 2] {
    [1.0; 2]
}
fn one3() -> [f32; 3] {
    [1.0; 3]
}
fn one_cell() -> [u32; 2] {
    [1; 2]
}
fn segments() -> u32 {
    32
}
fn rings() -> u32 {
    16
}
fn cap_rings() -> u32 {
    8
}

impl Default for Shape {
    fn default() -> Self {
        Self::Box { size: one3() }
    }
}

impl Shape {
    /// Name of the variant, as scene files write it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Quad { .. } => "Quad",
            Self::Plane { .. } => "Plane",
            Self::Box { .. } => "Box",
            Self::Sphere { .. } => "Sphere",
            Self::Cylinder { .. } => "Cylinder",
            Self::Cone { .. } => "Cone",
            Self::Torus { .. } => "Torus",
            Self::Capsule { .. } => "Capsule",
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// A length that is not finite, not positive or out of range; too few or too many divisions; a torus whose tube
    /// reaches its axis.
    pub fn validate(&self) -> Result<(), AssetError> {
        match *self {
            Self::Quad { size } => self.lengths("size", &size),
            Self::Box { size } => self.lengths("size", &size),
            Self::Plane { size, subdivisions: [x, z] } => {
                self.lengths("size", &size)?;
                self.divisions("subdivisions", x, 1)?;
                self.divisions("subdivisions", z, 1)?;
                self.total(x, z)
            }
            Self::Sphere { radius, segments, rings } => {
                self.lengths("radius", &[radius])?;
                self.divisions("segments", segments, 3)?;
                self.divisions("rings", rings, 2)?;
                self.total(segments, rings)
            }
            Self::Cylinder { radius, height, segments } | Self::Cone { radius, height, segments } => {
                self.lengths("radius", &[radius])?;
                self.lengths("height", &[height])?;
                self.divisions("segments", segments, 3)
            }
            Self::Torus { radius, tube, segments, sides } => {
                self.lengths("radius", &[radius])?;
                self.lengths("tube", &[tube])?;
                if tube >= radius {
                    return Err(self.error("tube", format!("{tube} must be smaller than radius {radius}")));
                }
                self.divisions("segments", segments, 3)?;
                self.divisions("sides", sides, 3)?;
                self.total(segments, sides)
            }
            Self::Capsule { radius, height, segments, rings } => {
                self.lengths("radius", &[radius])?;
                self.lengths("height", &[height])?;
                self.divisions("segments", segments, 3)?;
                self.divisions("rings", rings, 1)?;
                self.total(segments, rings.saturating_mul(2))
            }
        }
    }

    fn error(&self, field: &'static str, problem: String) -> AssetError {
        AssetError::Shape { shape: self.kind(), field, problem }
    }

    fn lengths(&self, field: &'static str, values: &[f32]) -> Result<(), AssetError> {
        match values.iter().find(|v| !(MIN_SIZE..=MAX_SIZE).contains(*v)) {
            Some(v) => {
                Err(self
                    .error(field, format!("{v} is out of range: lengths lie between {MIN_SIZE:e} and {MAX_SIZE:e} m")))
            }
            None => Ok(()),
        }
    }

    fn divisions(&self, field: &'static str, value: u32, least: u32) -> Result<(), AssetError> {
        if (least..=MAX_SEGMENTS).contains(&value) {
            return Ok(());
        }
        Err(self.error(field, format!("{value} is out of range: {least} to {MAX_SEGMENTS}")))
    }

    fn total(&self, a: u32, b: u32) -> Result<(), AssetError> {
        let vertices = (u64::from(a) + 1) * (u64::from(b) + 1);
        if vertices <= MAX_VERTICES {
            return Ok(());
        }
        let problem = format!("and the other divisions make {vertices} vertices; at most {MAX_VERTICES} are allowed");
        Err(self.error(if matches!(self, Self::Plane { .. }) { "subdivisions" } else { "segments" }, problem))
    }
}
