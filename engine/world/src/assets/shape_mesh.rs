//! Triangles of the procedural shapes: flat grids, and profiles turned around the y axis.
//!
//! In all of them the bitangent is `normal × tangent` (handedness +1) and points up the texture image, as glTF wants.

use super::{AssetError, Mesh, Shape, Vertex};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

impl Shape {
    /// Makes the triangles.
    ///
    /// # Errors
    /// Those of [`Shape::validate`].
    pub fn mesh(&self) -> Result<Mesh, AssetError> {
        self.validate()?;
        Ok(build(self))
    }
}

/// Makes the triangles of a shape whose parameters are valid.
fn build(shape: &Shape) -> Mesh {
    let mut b = Builder::default();
    match *shape {
        Shape::Quad { size } => b.grid(Vec3::ZERO, Vec3::X * size[0], Vec3::Y * size[1], [1, 1]),
        Shape::Plane { size, subdivisions } => {
            b.grid(Vec3::ZERO, Vec3::X * size[0], Vec3::NEG_Z * size[1], subdivisions);
        }
        Shape::Box { size } => b.cuboid(Vec3::from(size)),
        Shape::Sphere { radius, segments, rings } => b.lathe(&arc(radius, 0.0, -FRAC_PI_2, FRAC_PI_2, rings), segments),
        Shape::Cylinder { radius, height, segments } => {
            b.lathe(&side(radius, radius, height), segments);
            b.disc(0.5 * height, 1.0, radius, segments);
            b.disc(-0.5 * height, -1.0, radius, segments);
        }
        Shape::Cone { radius, height, segments } => {
            b.lathe(&side(radius, 0.0, height), segments);
            b.disc(-0.5 * height, -1.0, radius, segments);
        }
        Shape::Torus { radius, tube, segments, sides } => b.lathe(&circle(radius, tube, sides), segments),
        Shape::Capsule { radius, height, segments, rings } => {
            let mut profile = arc(radius, -0.5 * height, -FRAC_PI_2, 0.0, rings);
            profile.extend(arc(radius, 0.5 * height, 0.0, FRAC_PI_2, rings));
            b.lathe(&profile, segments);
        }
    }
    Mesh::new(shape.kind(), b.vertices, b.indices)
}

/// A point of a profile: `x` is the distance from the axis, `y` the height.
struct ProfilePoint {
    place: Vec2,
    normal: Vec2,
}

/// Straight side from the bottom radius to the top radius.
fn side(bottom: f32, top: f32, height: f32) -> [ProfilePoint; 2] {
    let normal = Vec2::new(height, bottom - top).normalize();
    [
        ProfilePoint { place: Vec2::new(bottom, -0.5 * height), normal },
        ProfilePoint { place: Vec2::new(top, 0.5 * height), normal },
    ]
}

/// Arc of latitude `from..to` around a point on the axis; exactly on the axis at the poles.
fn arc(radius: f32, center: f32, from: f32, to: f32, steps: u32) -> Vec<ProfilePoint> {
    let point = |i: u32| {
        let t = i as f32 / steps as f32;
        let angle = from + (to - from) * t;
        let pole = angle.abs() >= FRAC_PI_2 * (1.0 - 1e-6);
        let normal = if pole { Vec2::new(0.0, angle.signum()) } else { Vec2::new(angle.cos(), angle.sin()) };
        ProfilePoint { place: normal * radius + Vec2::new(0.0, center), normal }
    };
    (0..=steps).map(point).collect()
}

/// The tube of a torus, from its inner side around below and back; the last point repeats the first exactly.
fn circle(radius: f32, tube: f32, sides: u32) -> Vec<ProfilePoint> {
    let point = |i: u32| {
        let angle = (i % sides) as f32 / sides as f32 * TAU - PI;
        let normal = Vec2::new(angle.cos(), angle.sin());
        ProfilePoint { place: normal * tube + Vec2::new(radius, 0.0), normal }
    };
    (0..=sides).map(point).collect()
}

/// Cosine and sine of step `i` of `segments` around the axis; the last step is the first one exactly.
fn turn(i: u32, segments: u32) -> (f32, f32) {
    let (sin, cos) = ((i % segments) as f32 / segments as f32 * TAU).sin_cos();
    (cos, sin)
}

#[derive(Default)]
struct Builder {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

impl Builder {
    fn vertex(&mut self, position: Vec3, normal: Vec3, tangent: Vec3, uv: Vec2) {
        self.vertices.push(Vertex {
            position: position.to_array(),
            normal: normal.to_array(),
            tangent: tangent.extend(1.0).to_array(),
            uv: uv.to_array(),
        });
    }

    /// Flat rectangle around `center` with the edges `right` and `up`, facing `right × up`.
    fn grid(&mut self, center: Vec3, right: Vec3, up: Vec3, cells: [u32; 2]) {
        let base = self.vertices.len() as u32;
        let tangent = right.normalize();
        let normal = tangent.cross(up.normalize());
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let uv = Vec2::new(i as f32 / cells[0] as f32, 1.0 - j as f32 / cells[1] as f32);
                let position = center + right * (uv.x - 0.5) + up * (0.5 - uv.y);
                self.vertex(position, normal, tangent, uv);
            }
        }
        self.cells(base, cells);
    }

    /// Two triangles for each cell of a lattice of `cells + 1` vertices, rows going up.
    fn cells(&mut self, base: u32, cells: [u32; 2]) {
        let row = cells[0] + 1;
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let a = base + j * row + i;
                self.indices.extend([a, a + 1, a + row + 1, a, a + row + 1, a + row]);
            }
        }
    }

    fn cuboid(&mut self, size: Vec3) {
        let faces = [
            (Vec3::NEG_Z, Vec3::Y),
            (Vec3::Z, Vec3::Y),
            (Vec3::X, Vec3::NEG_Z),
            (Vec3::X, Vec3::Z),
            (Vec3::X, Vec3::Y),
            (Vec3::NEG_X, Vec3::Y),
        ];
        for (right, up) in faces {
            let normal = right.cross(up);
            self.grid(normal * size * 0.5, right * size, up * size, [1, 1]);
        }
    }

    /// Turns a profile, given from the bottom up along the outside, around the y axis. Points on the axis give one
    /// triangle a segment instead of two.
    fn lathe(&mut self, profile: &[ProfilePoint], segments: u32) {
        let base = self.vertices.len() as u32;
        let steps = profile.len() as u32 - 1;
        for (j, point) in profile.iter().enumerate() {
            for i in 0..=segments {
                let (cos, sin) = turn(i, segments);
                let around = |v: Vec2| Vec3::new(v.x * cos, v.y, -v.x * sin);
                let uv = Vec2::new(i as f32 / segments as f32, 1.0 - j as f32 / steps as f32);
                self.vertex(around(point.place), around(point.normal), Vec3::new(-sin, 0.0, -cos), uv);
            }
        }
        let row = segments + 1;
        for (j, pair) in (0u32..).zip(profile.windows(2)) {
            for i in 0..segments {
                let a = base + j * row + i;
                if pair[0].place.x > 0.0 {
                    self.indices.extend([a, a + 1, a + row + 1]);
                }
                if pair[1].place.x > 0.0 {
                    self.indices.extend([a, a + row + 1, a + row]);
                }
            }
        }
    }

    /// Flat disc at height `y` facing up (`facing` 1) or down (−1).
    fn disc(&mut self, y: f32, facing: f32, radius: f32, segments: u32) {
        let base = self.vertices.len() as u32;
        let normal = Vec3::Y * facing;
        self.vertex(Vec3::Y * y, normal, Vec3::X, Vec2::splat(0.5));
        for i in 0..segments {
            let (cos, sin) = turn(i, segments);
            let position = Vec3::new(radius * cos, y, -radius * sin);
            self.vertex(position, normal, Vec3::X, Vec2::new(0.5 + 0.5 * cos, 0.5 - 0.5 * sin * facing));
        }
        for i in 0..segments {
            let (a, b) = (base + 1 + i, base + 1 + (i + 1) % segments);
            self.indices.extend(if facing > 0.0 { [base, a, b] } else { [base, b, a] });
        }
    }
}
