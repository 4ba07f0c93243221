//! Mends the JSON of a document before it is read, so that a fault costs its part and not the model.
//!
//! The text is held against the schema of glTF 2.0. A value of the wrong type, out of its range, or that refers to nothing is taken
//! away where it may be missing. Where it may not, the object that holds it is broken: an element of a collection
//! becomes one that means nothing and keeps its number, and what refers to it is treated as if it were not there.
//! Collections come in the order in which they refer to each other, so that one pass finds all.

mod misplaced;
mod schema;
mod text;

pub(super) use misplaced::move_misplaced;
pub(super) use text::{Parsed, parse};

use super::remarks::Remarks;
use gltf::json::Value;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use schema::{COLLECTIONS, Collection, Field, Is, Need};
use std::collections::{HashMap, HashSet};

/// Mends a document.
pub(super) fn mend(root: &mut Value, remarks: &mut Remarks) {
    let mut mender = Mender { counts: HashMap::new(), broken: HashSet::new(), remarks };
    mender.shapes(root);
    for collection in &COLLECTIONS {
        mender.collection(root, collection);
    }
    // Messages about the document as a whole begin with the name of the field.
    let _ = mender.fields(root, schema::ROOT, "");
}

/// The version as glTF writes it: some write a number, or leave the fraction out.
pub(super) fn version(root: &mut Value, remarks: &mut Remarks) {
    let Some(version) = root.get_mut("asset").and_then(|asset| asset.get_mut("version")) else { return };
    let number = match &*version {
        Value::Number(number) => number.as_f64(),
        Value::String(text) if !text.contains('.') || text.trim() != text => text.trim().parse().ok(),
        _ => None,
    };
    if let Some(number) = number.filter(|number: &f64| (0.0..100.0).contains(number)) {
        remarks.fault(format!("asset.version: is {version} and must be a text such as \"2.0\"; taken as {number:.1}"));
        *version = Value::from(format!("{number:.1}"));
    }
}

/// Takes channels away that move no node: the specification says to ignore them. Extensions give them other targets.
pub(super) fn ignore_targetless(root: &mut Value, remarks: &mut Remarks) {
    let animations = root.get_mut("animations").and_then(Value::as_array_mut);
    for (index, animation) in animations.into_iter().flatten().enumerate() {
        let at = place("animation", index, animation);
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        let mut number = 0;
        channels.retain(|channel| {
            let target = channel.get("target").and_then(Value::as_object);
            let is_ignored = target.is_some_and(|target| target.get("node").is_none_or(Value::is_null));
            if is_ignored {
                remarks.push(format!("{at}, channel {number}: moves no node; ignored"));
            }
            number += 1;
            !is_ignored
        });
    }
}

struct Mender<'a> {
    /// Elements of each collection.
    counts: HashMap<&'static str, usize>,
    /// Elements that mean nothing.
    broken: HashSet<(&'static str, usize)>,
    remarks: &'a mut Remarks,
}

/// The array of a collection.
fn elements<'v>(root: &'v mut Value, collection: &Collection) -> Option<&'v mut Vec<Value>> {
    let holder = collection.within.iter().try_fold(root, |value, name| value.get_mut(*name))?;
    holder.get_mut(collection.name)?.as_array_mut()
}

impl Mender<'_> {
    /// Takes away what should be an array or an object and is none, and counts the elements of the collections, to which earlier
    /// ones may refer.
    fn shapes(&mut self, root: &mut Value) {
        for collection in &COLLECTIONS {
            let holder = collection.within.iter().try_fold(&mut *root, |value, name| value.get_mut(*name));
            let Some(holder) = holder.and_then(Value::as_object_mut) else { continue };
            let is_wrong = holder.get(collection.name).is_some_and(|value| !value.is_array());
            if is_wrong {
                holder.remove(collection.name);
                self.remarks.fault(format!("{}: must be an array; ignored", collection.name));
            }
            let count = holder.get(collection.name).and_then(Value::as_array).map_or(0, Vec::len);
            self.counts.insert(collection.name, count);
        }
    }

    fn collection(&mut self, root: &mut Value, collection: &Collection) {
        let Some(elements) = elements(root, collection) else { return };
        for (index, element) in elements.iter_mut().enumerate() {
            let at = place(collection.one, index, element);
            if let Err(problem) = self.element(element, collection, &at) {
                self.remarks.fault(format!("{at}{problem}; left out"));
                self.broken.insert((collection.name, index));
                *element = gltf::json::deserialize::from_str(collection.stub).unwrap_or_default();
            }
        }
    }

    fn element(&mut self, element: &mut Value, collection: &Collection, at: &str) -> Result<(), String> {
        if collection.name == "animations" {
            self.samplers(element, at);
        }
        self.fields(element, collection.fields, at)?;
        (collection.check)(element)
    }

    /// The samplers of an animation: those that are broken lose their channels.
    fn samplers(&mut self, animation: &mut Value, at: &str) {
        self.broken.retain(|(collection, _)| *collection != schema::ANIMATION_SAMPLERS);
        let samplers = animation.get_mut("samplers").and_then(Value::as_array_mut);
        let samplers = samplers.map(std::mem::take).unwrap_or_default();
        self.counts.insert(schema::ANIMATION_SAMPLERS, samplers.len());
        let mut mended = Vec::with_capacity(samplers.len());
        for (index, mut sampler) in samplers.into_iter().enumerate() {
            if let Err(problem) = self.fields(&mut sampler, schema::ANIMATION_SAMPLER, at) {
                self.remarks.fault(format!("{at}, sampler {index}{problem}; left out"));
                self.broken.insert((schema::ANIMATION_SAMPLERS, index));
                sampler = gltf::json::deserialize::from_str(r#"{"input":0,"output":0}"#).unwrap_or_default();
            }
            mended.push(sampler);
        }
        if let Some(animation) = animation.as_object_mut() {
            animation.insert("samplers".into(), Value::Array(mended));
        }
    }

    /// Mends the fields of an object.
    ///
    /// # Errors
    /// Why the object is of no use.
    fn fields(&mut self, object: &mut Value, fields: &[Field], at: &str) -> Result<(), String> {
        let Some(object) = object.as_object_mut() else { return Err(": must be an object".into()) };
        for field in fields {
            let here = || if at.is_empty() { field.name.to_owned() } else { format!("{at}, {}", field.name) };
            let is_required = matches!(field.need, Need::Required);
            let is_none = object.get(field.name).is_some_and(|value| !is_required && stands_for_none(value, &field.is));
            if is_none && let Some(value) = object.remove(field.name) {
                self.remarks.fault(format!("{}: is {value}; taken for none", here()));
            }
            let Some(value) = object.get_mut(field.name).filter(|value| !value.is_null()) else {
                object.remove(field.name);
                match field.need {
                    Need::Required => return Err(format!(": has no `{}`", field.name)),
                    _ => continue,
                }
            };
            let here = here();
            let Err(problem) = self.value(value, &field.is, &here) else { continue };
            match field.need {
                Need::Optional => {
                    self.remarks.fault(format!("{here}{problem}; ignored"));
                    object.remove(field.name);
                }
                Need::Required | Need::Vital => return Err(format!(", {}{problem}", field.name)),
            }
        }
        Ok(())
    }

    /// Mends a value.
    ///
    /// # Errors
    /// Why it is of no use.
    fn value(&mut self, value: &mut Value, is: &Is, at: &str) -> Result<(), String> {
        match is {
            Is::Flag if value.is_boolean() => Ok(()),
            Is::Flag => self.flag(value, at),
            Is::Text if value.is_string() => Ok(()),
            Is::Text => Err(": must be a text".into()),
            Is::Word(words) => self.word(value, words, at),
            Is::Number => number(value).map(drop),
            Is::Numbers(count) => self.numbers(value, *count, at),
            Is::ColorAndAlpha => {
                if let Some(color) = value.as_array_mut().filter(|color| color.len() == 3) {
                    self.remarks.fault(format!("{at}: has no alpha; taken as 1"));
                    color.push(Value::from(1));
                }
                self.numbers(value, Some(4), at)
            }
            Is::Stride => self.whole(value, 1, 1 << 16, at).map(drop),
            Is::Whole(least, most) => self.whole(value, *least, *most, at).map(drop),
            Is::Code(codes) => match self.whole(value, 0, u64::from(u32::MAX), at)? {
                code if codes.contains(&code) => Ok(()),
                code => Err(format!(": {code} is none of {codes:?}")),
            },
            Is::To(collection) => self.reference(value, collection, at),
            Is::References(collection) => {
                let Some(items) = value.as_array_mut() else { return Err(": must be an array".into()) };
                items.iter_mut().try_for_each(|item| self.reference(item, collection, at))
            }
            Is::Set(is) => self.set(value, is, at),
            Is::List { item, stub } => self.list(value, item, stub, at),
            Is::Attributes => self.attributes(value, at),
            Is::Part(fields) => self.fields(value, fields, at),
        }
    }

    /// True or false. Some exporters write 1 and 0, or texts.
    fn flag(&mut self, value: &mut Value, at: &str) -> Result<(), String> {
        let meant = match (value.as_f64(), value.as_str()) {
            (Some(1.0), _) | (_, Some("true" | "True")) => true,
            (Some(0.0), _) | (_, Some("false" | "False")) => false,
            _ => return Err(": must be true or false".into()),
        };
        self.remarks.fault(format!("{at}: is {}; taken as {meant}", shown(value)));
        *value = Value::from(meant);
        Ok(())
    }

    /// One of some texts. Some exporters write them in another case.
    fn word(&mut self, value: &mut Value, words: &[&str], at: &str) -> Result<(), String> {
        let found = value.as_str().unwrap_or_default();
        if words.contains(&found) {
            return Ok(());
        }
        let Some(meant) = words.iter().find(|word| word.eq_ignore_ascii_case(found)) else {
            return Err(format!(": is {}, and none of {}", shown(value), words.join(", ")));
        };
        self.remarks.fault(format!("{at}: is {}; taken as {meant}", shown(value)));
        *value = Value::from(*meant);
        Ok(())
    }

    /// An array of numbers. Those beyond the wanted count, such as the alpha of a colour that has none, are dropped.
    fn numbers(&mut self, value: &mut Value, count: Option<usize>, at: &str) -> Result<(), String> {
        let Some(items) = value.as_array_mut() else { return Err(": must be an array of numbers".into()) };
        let found = items.len();
        if let Some(count) = count.filter(|count| *count < found) {
            self.remarks.fault(format!("{at}: has {found} numbers; the first {count} are taken"));
            items.truncate(count);
        }
        if count.is_some_and(|count| count != items.len()) {
            return Err(format!(": has {found} numbers"));
        }
        items.iter().try_for_each(|item| number(item).map(drop))
    }

    /// A number without a fraction. Some exporters write such ones as `12.0`.
    fn whole(&mut self, value: &mut Value, least: u64, most: u64, at: &str) -> Result<u64, String> {
        let found = match (value.as_u64(), value.as_f64()) {
            (Some(found), _) => found,
            (None, Some(real)) if real >= 0.0 && real.fract() == 0.0 && real < 2f64.powi(53) => {
                self.remarks.fault(format!("{at}: {} is written as a real number; taken as whole", shown(value)));
                *value = Value::from(real as u64);
                real as u64
            }
            _ => return Err(format!(": is {} and must be a whole number", shown(value))),
        };
        match found {
            found if found < least => Err(format!(": is {found} and must be at least {least}")),
            found if found > most => Err(format!(": is {found}, which is too large")),
            found => Ok(found),
        }
    }

    fn reference(&mut self, value: &mut Value, collection: &'static str, at: &str) -> Result<(), String> {
        let index = self.whole(value, 0, u64::from(u32::MAX - 1), at)? as usize;
        let count = self.counts.get(collection).copied().unwrap_or(0);
        let one = schema::one_of(collection);
        if index >= count {
            return Err(format!(": refers to {one} {index}, but there are {count}"));
        }
        match self.broken.contains(&(collection, index)) {
            true => Err(format!(": refers to {one} {index}, which is broken")),
            false => Ok(()),
        }
    }

    /// A list from which items may be taken away.
    fn set(&mut self, value: &mut Value, is: &Is, at: &str) -> Result<(), String> {
        let Some(items) = value.as_array_mut() else { return Err(": must be an array".into()) };
        let mut index = 0;
        items.retain_mut(|item| {
            let here = format!("{at} {index}");
            index += 1;
            let result = self.value(item, is, &here);
            if let Err(problem) = &result {
                self.remarks.fault(format!("{here}{problem}; left out"));
            }
            result.is_ok()
        });
        Ok(())
    }

    /// A list in which items keep their number.
    fn list(&mut self, value: &mut Value, is: &Is, stub: &str, at: &str) -> Result<(), String> {
        let Some(items) = value.as_array_mut() else { return Err(": must be an array".into()) };
        for (index, item) in items.iter_mut().enumerate() {
            let here = format!("{at} {index}");
            if let Err(problem) = self.value(item, is, &here) {
                self.remarks.fault(format!("{here}{problem}; left out"));
                *item = gltf::json::deserialize::from_str(stub).unwrap_or_default();
            }
        }
        Ok(())
    }

    /// Accessors by the names of attributes.
    fn attributes(&mut self, value: &mut Value, at: &str) -> Result<(), String> {
        let Some(attributes) = value.as_object_mut() else { return Err(": must be an object".into()) };
        for (old, new) in
            [("TEXCOORD", "TEXCOORD_0"), ("COLOR", "COLOR_0"), ("JOINT", "JOINTS_0"), ("WEIGHT", "WEIGHTS_0")]
        {
            if !attributes.contains_key(new)
                && let Some(accessor) = attributes.remove(old)
            {
                self.remarks.fault(format!("{at}: {old} is a name of glTF 1.0; taken as {new}"));
                attributes.insert(new.into(), accessor);
            }
        }
        attributes.retain(|name, accessor| {
            let semantic = gltf::json::deserialize::from_value::<Checked<Semantic>>(Value::from(name.as_str()));
            let problem = match semantic.unwrap_or(Checked::Invalid) {
                Checked::Invalid => Err(": is no attribute of glTF; names of others begin with `_`".into()),
                Checked::Valid(_) => self.reference(accessor, "accessors", at),
            };
            if let Err(problem) = &problem {
                self.remarks.fault(format!("{at}, {name}{problem}; ignored"));
            }
            problem.is_ok()
        });
        Ok(())
    }
}

/// Whether a value is a way to say that there is nothing: a reference to −1, or a stride of 0.
fn stands_for_none(value: &Value, is: &Is) -> bool {
    match is {
        Is::To(_) => value.as_f64() == Some(-1.0),
        Is::Stride => value.as_f64() == Some(0.0),
        _ => false,
    }
}

fn number(value: &Value) -> Result<f64, String> {
    match value.as_f64() {
        // Those beyond the range of floats are looked at where they are used.
        Some(number) => Ok(number),
        None => Err(format!(": {} is no number", shown(value))),
    }
}

/// A value as messages show it.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Names an element, with its own name if it has one.
fn place(one: &str, index: usize, element: &Value) -> String {
    match element.get("name").and_then(Value::as_str).filter(|name| !name.is_empty()) {
        Some(name) => format!("{one} {index} \"{name}\""),
        None => format!("{one} {index}"),
    }
}
