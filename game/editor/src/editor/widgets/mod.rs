//! Widgets for any value that scene files can hold, by its shape and its documentation.

mod groups;
mod numbers;
mod text;

pub use text::{edited_text, endings, pick_file};

use super::custom_component::CustomComponent;
use super::docs::{Docs, Note};
use super::schema::Shape;
use super::value::{Value, float};
use egui::{Response, Ui};
use lightwell::files;
use numbers::{boolean, integer, number, numbers};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

/// Starting values of what zeros would make invalid, or dull.
const STARTERS: [(&str, &str); 18] = [
    ("Override.light", "(kind:Point,intensity:10.0)"),
    ("Override.mesh", "Box()"),
    ("Override.material", "()"),
    ("LightKind.Spot", "Spot(inner:20.0,outer:30.0)"),
    ("LightKind.Sun", "Sun(angle:0.53)"),
    ("LightKind.Sphere", "Sphere(radius:0.1)"),
    ("LightKind.Disc", "Disc(radius:0.3)"),
    ("LightKind.Rectangle", "Rectangle(width:1.0,height:0.6)"),
    ("LightKind.Tube", "Tube(length:1.2,radius:0.02)"),
    ("Exposure.Photographic", "Photographic(f_number:8.0,shutter:0.02,iso:100.0)"),
    ("Environment.Physical", "Physical(haze:1.0,ground:(0.3,0.3,0.3),altitude:0.0)"),
    ("FogShape.Box", "Box(size:(4.0,2.0,4.0))"),
    ("FogShape.Sphere", "Sphere(radius:1.0)"),
    ("Spin", "Spin(axis:(0.0,1.0,0.0),degrees_per_second:90.0)"),
    ("Orbit", "Orbit(radius:1.0,period:4.0)"),
    ("Keys", "Keys(target:Translation,keys:[(0.0,(0.0,0.0,0.0)),(1.0,(0.0,1.0,0.0))])"),
    ("Field", "Field(\"transform.translation\")"),
    ("Transform.scale", "1.0"),
];

/// What widgets need to know of the rest.
pub struct Kit {
    docs: Docs,
    /// Components of a game.
    pub own: Vec<CustomComponent>,
    /// Shapes of types that read several forms.
    customs: HashMap<&'static str, (&'static str, Shape)>,
    /// Named materials of the scene.
    pub materials: Vec<String>,
    /// Folders that assets are looked for in.
    pub folders: Vec<std::path::PathBuf>,
    /// Fields that are marked, each with what is said of it, for the component that is shown.
    pub marks: BTreeMap<String, String>,
    /// Fields that a game has changed, with what is said of each, for the component that is shown.
    pub differences: BTreeMap<String, String>,
    /// The one of them that is to be applied to the scene.
    pub applied: RefCell<Option<String>>,
}

impl Default for Kit {
    fn default() -> Self {
        let customs = HashMap::from([
            ("MaterialRef", ("Material", Shape::of::<files::MaterialFile>())),
            ("ModelFile", ("Model", Shape::of::<files::ModelDetails>())),
            ("TextureFile", ("Texture", Shape::of::<files::SampledTexture>())),
        ]);
        Self {
            docs: Docs::read(&files::DESCRIBED),
            own: Vec::new(),
            customs,
            materials: Vec::new(),
            folders: Vec::new(),
            marks: BTreeMap::new(),
            differences: BTreeMap::new(),
            applied: RefCell::default(),
        }
    }
}

/// A field's name as people read it.
pub fn title(name: &str) -> String {
    let mut chars = name.chars();
    let first: String = chars.next().into_iter().flat_map(char::to_uppercase).collect();
    first + &chars.as_str().replace('_', " ")
}

impl Kit {
    /// Adds components of a game with their help.
    pub fn add_own(&mut self, own: Vec<CustomComponent>) {
        for note in own.iter().flat_map(|component| &component.notes) {
            self.docs.insert(note.key, note.help);
        }
        self.own.extend(own);
    }

    /// The note of a field.
    pub fn note(&self, key: &str) -> Note {
        self.docs.note(key)
    }

    /// A valid value to begin with.
    pub fn starter(&self, key: &str, shape: &Shape) -> Value {
        let known = STARTERS.iter().find(|(k, _)| *k == key).map(|(_, text)| (*text).to_owned());
        let text = known.unwrap_or_else(|| match shape {
            Shape::Float(_) => float(self.note(key).range.map_or(1.0, |r| *r.end()), true),
            Shape::Integer(_) => "1".into(),
            Shape::Bool => "true".into(),
            Shape::Struct(..) => "()".into(),
            Shape::Option(inner) => self.starter(key, inner).print(),
            other => other.sample(),
        });
        Value::parse(&text).unwrap_or_default()
    }

    /// A labelled row of a field; true if it changed.
    pub fn row(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value) -> bool {
        let note = self.note(key);
        match shape.inner() {
            _ if is_plain(shape, value) => ui.horizontal(|ui| self.labelled(ui, name, key, shape, value, &note)).inner,
            _ => {
                self.mark(ui, name);
                let header = egui::CollapsingHeader::new(title(name)).id_salt((key, name)).default_open(true);
                let response = header.show(ui, |ui| self.value(ui, name, key, shape, value, &note));
                help(response.header_response, &note);
                response.body_returned.unwrap_or(false)
            }
        }
    }

    fn labelled(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value, note: &Note) -> bool {
        let width = (ui.available_width() * 0.34).clamp(60.0, 120.0);
        let height = ui.spacing().interact_size.y;
        let label = egui::Label::new(title(name)).truncate().sense(egui::Sense::hover());
        let layout = egui::Layout::left_to_right(egui::Align::Center).with_main_align(egui::Align::Min);
        let label = ui.allocate_ui_with_layout([width, height].into(), layout, |ui| {
            ui.set_min_width(width);
            ui.add(label)
        });
        help(label.inner, note);
        self.mark(ui, name);
        ui.push_id(name, |ui| self.value(ui, name, key, shape, value, note)).inner
    }

    /// The sign of a field that is marked.
    fn mark(&self, ui: &mut Ui, name: &str) {
        if let Some(what) = self.differences.get(name) {
            let sign = egui::RichText::new("●").color(super::menu::PLAYS);
            let response = ui.add(egui::Button::new(sign).frame(false).small()).on_hover_text(what);
            named(&response, &format!("Apply {} to the scene", title(name)));
            if response.clicked() {
                self.applied.replace(Some(name.to_owned()));
            }
        }
        if let Some(why) = self.marks.get(name) {
            let sign = egui::Label::new(egui::RichText::new("*").color(ui.visuals().warn_fg_color));
            let response = ui.add(sign.sense(egui::Sense::hover())).on_hover_text(why);
            // What a screen reader says of a text is its value.
            let said = format!("{}: {why}", title(name));
            response.ctx.accesskit_node_builder(response.id, |node| node.set_value(said));
        }
    }

    /// The widget of a component; true if it changed.
    pub fn body(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value) -> bool {
        self.value(ui, name, key, shape, value, &self.note(key))
    }

    /// The widget of a value; true if it changed.
    fn value(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value, note: &Note) -> bool {
        match shape {
            Shape::Option(inner) => self.option(ui, name, key, inner, value, note),
            Shape::Bool => boolean(ui, name, value),
            Shape::Integer(signed) => integer(ui, name, value, note, *signed),
            Shape::Float(single) => number(ui, name, value, note, *single),
            Shape::Text => self.text(ui, name, key, value),
            Shape::Tuple(items) => match items.iter().all(|i| matches!(i, Shape::Float(_) | Shape::Integer(_))) {
                true => numbers(ui, name, value, note, matches!(items.first(), Some(Shape::Integer(_)))),
                false => self.tuple(ui, key, items, value),
            },
            Shape::Struct(ty, fields) => self.fields(ui, ty_or(ty, key), fields, value),
            Shape::Enum(ty, variants) => self.choice(ui, name, ty, variants, value, note),
            Shape::List(item) => self.list(ui, key, item, value),
            Shape::Map(item) => self.map(ui, key, item, value),
            Shape::Custom(ty) => self.custom(ui, name, key, ty, value, note),
            Shape::Unit | Shape::Unknown => self.by_value(ui, name, key, value, note),
        }
    }

    /// The fields of a structure; true if one changed.
    pub fn fields(&self, ui: &mut Ui, ty: &str, fields: &[(&'static str, Shape)], value: &mut Value) -> bool {
        let mut changed = false;
        for (name, shape) in fields {
            let key = format!("{ty}.{name}");
            let written = value.field(name).cloned();
            let empty = match shape {
                Shape::Option(_) => Some("None"),
                Shape::Bool => Some("false"),
                Shape::Text => Some("\"\""),
                Shape::List(_) => Some("[]"),
                Shape::Map(_) => Some("{}"),
                // Left out as it has its default, which the text does not tell.
                _ => None,
            };
            let Some(mut field) = written.clone().or_else(|| Value::parse(empty?)) else { continue };
            let counts = self
                .note(&key)
                .only
                .is_none_or(|(other, variant)| value.field(&other).is_none_or(|now| now.head == variant));
            if ui.add_enabled_ui(counts, |ui| self.row(ui, name, &key, shape, &mut field)).inner {
                changed = true;
                match field.head == "None" && field.group.is_none() && written.is_none() {
                    true => value.remove(name),
                    false => value.set(name, field),
                }
            }
        }
        changed
    }
}

fn ty_or<'a>(ty: &'a str, key: &'a str) -> &'a str {
    if ty.is_empty() { key } else { ty }
}

/// Whether a value fits beside its label.
fn is_plain(shape: &Shape, value: &Value) -> bool {
    match shape {
        Shape::Option(inner) => value.head == "None" && value.group.is_none() || is_plain(inner, value),
        Shape::Struct(..) | Shape::List(_) | Shape::Map(_) => false,
        Shape::Enum(_, variants) => {
            let shape = variants.iter().find(|(name, _)| *name == value.head).map(|(_, shape)| shape);
            !matches!(shape, Some(Shape::Struct(..)))
        }
        Shape::Tuple(items) => items.iter().all(|i| matches!(i, Shape::Float(_) | Shape::Integer(_))),
        Shape::Custom(_) | Shape::Unknown => value.group.is_none() || value.numbers().is_some_and(|n| !n.is_empty()),
        _ => true,
    }
}

/// Gives a widget without text a name, for those who cannot see it and for tests.
pub fn named(response: &Response, name: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}

fn help(response: Response, note: &Note) {
    if note.help.is_empty() {
        return;
    }
    let response = response.on_hover_text(&note.help);
    if let Some((field, variant)) = &note.only {
        let why = format!("{}\n\nGreyed out, since {} is not {variant}.", note.help, title(field));
        response.on_disabled_hover_text(why);
    }
}
