//! A room as the text of a scene file.

use super::lights::{Kind, PlacedLight};
use super::room::Room;
use super::solid::{Form, Item, Part};
use super::surfaces::Surface;
use glam::{DQuat, DVec3};
use std::fmt::Write as _;

/// A number with so many digits after the point at most.
fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A length [m], to a hundredth of a millimetre.
fn length(value: f64) -> String {
    number(value, 5)
}

fn tuple(values: [f64; 3], digits: usize) -> String {
    let [x, y, z] = values.map(|value| number(value, digits));
    format!("({x}, {y}, {z})")
}

fn point(at: DVec3) -> String {
    tuple(at.to_array(), 5)
}

fn quaternion(turn: DQuat) -> String {
    let [x, y, z, w] = turn.to_array().map(|value| number(value, 8));
    format!("({x}, {y}, {z}, {w})")
}

fn transform(at: DVec3, turn: DQuat) -> String {
    match turn == DQuat::IDENTITY {
        true => format!("transform: (translation: {})", point(at)),
        false => format!("transform: (translation: {}, rotation: {})", point(at), quaternion(turn)),
    }
}

fn mesh(form: Form) -> String {
    match form {
        Form::Box(size) => format!("Box(size: {})", point(size)),
        Form::Sphere(radius) => format!("Sphere(radius: {})", length(radius)),
        Form::Cylinder(radius, height) => format!("Cylinder(radius: {}, height: {})", length(radius), length(height)),
        Form::Cone(radius, height) => format!("Cone(radius: {}, height: {})", length(radius), length(height)),
        Form::Torus(radius, tube) => format!("Torus(radius: {}, tube: {})", length(radius), length(tube)),
        Form::Capsule(radius, height) => format!("Capsule(radius: {}, height: {})", length(radius), length(height)),
        Form::Sheet(width, height) => format!("Quad(size: ({}, {}))", length(width), length(height)),
    }
}

fn material(surface: &Surface) -> String {
    let mut text = format!("color: {}", tuple(surface.color, 4));
    for (name, value, default) in [
        ("roughness", surface.roughness, 1.0),
        ("metallic", surface.metallic, 0.0),
        ("specular", surface.specular, 1.0),
    ] {
        if value != default {
            let _ = write!(text, ", {name}: {}", number(value, 4));
        }
    }
    if surface.emissive != [0.0; 3] {
        let _ = write!(text, ", emissive: {}", tuple(surface.emissive, 5));
    }
    if surface.double_sided {
        text += ", double_sided: true";
    }
    format!("        \"{}\": ({text}),\n", surface.name)
}

fn part(part: &Part, name: &str, at: DVec3, turn: DQuat) -> String {
    let place = transform(at, turn);
    format!("(name: \"{name}\", {place}, mesh: {}, material: \"{}\"),\n", mesh(part.form), part.material)
}

fn item(item: &Item) -> String {
    if let [only] = &item.parts[..] {
        let at = item.at + item.turn * only.at;
        return format!("            {}", part(only, &item.name, at, item.turn * only.turn));
    }
    let mut text = format!("            (name: \"{}\", {}, children: [\n", item.name, transform(item.at, item.turn));
    for solid in &item.parts {
        let _ = write!(text, "                {}", part(solid, &solid.name, solid.at, solid.turn));
    }
    text + "            ]),\n"
}

fn light(light: &PlacedLight, index: usize) -> String {
    let kind = match light.kind {
        Kind::Point => "Point".to_owned(),
        Kind::Spot(inner, outer) => format!("Spot(inner: {}, outer: {})", number(inner, 2), number(outer, 2)),
        Kind::Sun => "Directional".to_owned(),
    };
    let look = match light.kind {
        Kind::Point => String::new(),
        _ => format!(", look_at: {}", point(light.to)),
    };
    format!(
        "            (name: \"Light {}\", transform: (translation: {}{look}), light: (kind: {kind}, color: {}, intensity: {})),\n",
        index + 1,
        point(light.from),
        tuple(light.color, 4),
        number(light.intensity, 5),
    )
}

impl Room {
    /// The scene's file.
    pub fn scene_text(&self, seed: u64) -> String {
        let facts = &self.facts;
        let mut text = format!("// Room {} of seed {seed}, made by `lightwell bench --rooms`.\nScene(\n", facts.index);
        let _ = writeln!(text, "    description: \"{}\",", facts.description);
        if self.lighting.sky != [0.0; 3] {
            let _ = writeln!(text, "    settings: (sky: {}),", tuple(self.lighting.sky, 5));
        }
        text += "    materials: {\n";
        self.materials.iter().for_each(|surface| text += &material(surface));
        text += "    },\n    entities: [\n        (name: \"Light volumes\", clpv: ()),\n";
        let _ = writeln!(
            text,
            "        (name: \"Room\", transform: (translation: {}, rotation: {}), children: [",
            point(self.origin),
            tuple(self.rotation, 3)
        );
        let camera = &self.viewpoint;
        let _ = writeln!(
            text,
            "            (name: \"Camera\", transform: (translation: {}, look_at: {}), camera: (fov: {}, near: {}, primary: true)),",
            point(camera.from),
            point(camera.to),
            number(camera.field, 2),
            length(camera.near)
        );
        self.lighting.lights.iter().enumerate().for_each(|(index, one)| text += &light(one, index));
        self.items.iter().for_each(|one| text += &item(one));
        text + "        ]),\n    ],\n)\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!([number(1.0, 4), number(-0.00001, 4), number(0.25, 4)], ["1", "0", "0.25"]);
        assert_eq!(number(100.0, 0), "100");
        assert_eq!(point(DVec3::new(1.5, -2.0, 0.000_014)), "(1.5, -2, 0.00001)");
    }
}
