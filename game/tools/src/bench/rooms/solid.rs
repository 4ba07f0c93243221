//! Solids that rooms are built from, and rays through them.

use glam::{DQuat, DVec3};

/// Shape of a solid, centred on its origin, as scene files have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Edge lengths [m].
    Box(DVec3),
    /// Radius [m].
    Sphere(f64),
    /// Radius and height [m], along y.
    Cylinder(f64, f64),
    /// Radius of the base and height [m], tip on top.
    Cone(f64, f64),
    /// Distance of the tube's centre from the axis, and radius of the tube [m], around y.
    Torus(f64, f64),
    /// Radius, and height of the cylindrical part [m], along y.
    Capsule(f64, f64),
    /// Width and height [m] of a rectangle in z = 0, which both sides show.
    Sheet(f64, f64),
}

impl Form {
    /// Half of the edges of the box around it [m].
    pub fn half(self) -> DVec3 {
        match self {
            Self::Box(size) => 0.5 * size,
            Self::Sphere(radius) => DVec3::splat(radius),
            Self::Cylinder(radius, height) | Self::Cone(radius, height) => DVec3::new(radius, 0.5 * height, radius),
            Self::Torus(radius, tube) => DVec3::new(radius + tube, tube, radius + tube),
            Self::Capsule(radius, height) => DVec3::new(radius, 0.5 * height + radius, radius),
            Self::Sheet(width, height) => DVec3::new(0.5 * width, 0.5 * height, 1e-4),
        }
    }
}

/// A solid within an item.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name, unique in its item.
    pub name: String,
    /// Shape.
    pub form: Form,
    /// Centre [m], relative to the item.
    pub at: DVec3,
    /// Rotation, relative to the item.
    pub turn: DQuat,
    /// Name of the material.
    pub material: String,
}

/// Something that stands in a room, or a part of the building: solids that are moved together.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Name, unique in the room.
    pub name: String,
    /// Where its origin is [m].
    pub at: DVec3,
    /// Rotation.
    pub turn: DQuat,
    /// Its parts.
    pub parts: Vec<Part>,
}

impl Item {
    /// An item at the origin, without parts.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), at: DVec3::ZERO, turn: DQuat::IDENTITY, parts: Vec::new() }
    }

    /// Adds a solid that is not turned.
    pub fn add(&mut self, name: impl Into<String>, form: Form, at: DVec3, material: &str) {
        self.add_turned(name, form, at, DQuat::IDENTITY, material);
    }

    /// Adds a solid.
    pub fn add_turned(&mut self, name: impl Into<String>, form: Form, at: DVec3, turn: DQuat, material: &str) {
        self.parts.push(Part { name: name.into(), form, at, turn, material: material.to_owned() });
    }

    /// The box around it where it stands: least and greatest coordinates [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for part in &self.parts {
            let (centre, turn, half) = (self.at + self.turn * part.at, self.turn * part.turn, part.form.half());
            let reach = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (turn * (axis * half)).abs());
            let reach = reach[0] + reach[1] + reach[2];
            (low, high) = (low.min(centre - reach), high.max(centre + reach));
        }
        (low, high)
    }

    /// A point in the space of a part.
    fn inside(&self, part: &Part, point: DVec3) -> DVec3 {
        part.turn.conjugate() * (self.turn.conjugate() * (point - self.at) - part.at)
    }

    /// Distance of a point from the boxes around its solids [m], 0 within one.
    pub fn distance(&self, point: DVec3) -> f64 {
        let of = |part: &Part| (self.inside(part, point).abs() - part.form.half()).max(DVec3::ZERO).length();
        self.parts.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Distance along a ray, of unit direction, to the first of its solids [m]; infinite if there is none. All but
    /// spheres are taken to be boxes.
    pub fn hit(&self, from: DVec3, along: DVec3) -> f64 {
        self.parts.iter().map(|part| self.hit_part(part, from, along)).fold(f64::INFINITY, f64::min)
    }

    fn hit_part(&self, part: &Part, from: DVec3, along: DVec3) -> f64 {
        let origin = self.inside(part, from);
        let along = part.turn.conjugate() * (self.turn.conjugate() * along);
        if let Form::Sphere(radius) = part.form {
            let (b, c) = (origin.dot(along), origin.length_squared() - radius * radius);
            let root = b * b - c;
            return if root >= 0.0 && -b - root.sqrt() > 0.0 { -b - root.sqrt() } else { f64::INFINITY };
        }
        let half = part.form.half();
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d, h) = (origin[axis], along[axis], half[axis]);
            if d.abs() < 1e-12 {
                if o.abs() > h {
                    return f64::INFINITY;
                }
                continue;
            }
            let (a, b) = ((-h - o) / d, (h - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        if enter < leave { enter } else { f64::INFINITY }
    }
}

/// A rotation about an axis by 2·atan(t): for |t| ≤ 1 up to a quarter turn either way. No angle function is needed, and so
/// none that rounds differently from machine to machine.
pub fn turn(axis: DVec3, t: f64) -> DQuat {
    let scale = 1.0 / (1.0 + t * t).sqrt();
    let vector = axis * (t * scale);
    DQuat::from_xyzw(vector.x, vector.y, vector.z, scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_turned_boxes_and_balls() {
        let mut item = Item::new("a");
        item.add_turned("b", Form::Box(DVec3::new(2.0, 2.0, 0.2)), DVec3::ZERO, turn(DVec3::Y, 1.0), "m");
        item.at = DVec3::new(0.0, 0.0, -5.0);
        assert!((item.hit(DVec3::ZERO, DVec3::NEG_Z) - 4.0).abs() < 1e-9, "a quarter turn shows the edge");
        assert!((item.distance(DVec3::new(0.6, 0.0, -5.0)) - 0.5).abs() < 1e-9);
        assert_eq!(item.hit(DVec3::ZERO, DVec3::Z), f64::INFINITY);
        let (low, high) = item.bounds();
        assert!((low - DVec3::new(-0.1, -1.0, -6.0)).length() < 1e-9 && high.z < -3.9, "{low} {high}");
        let mut ball = Item::new("c");
        ball.add("d", Form::Sphere(0.5), DVec3::new(0.0, 0.0, -2.0), "m");
        assert!((ball.hit(DVec3::ZERO, DVec3::NEG_Z) - 1.5).abs() < 1e-9);
    }
}
