//! Help, units and ranges of fields, read from the documentation comments of the types themselves.

use std::collections::HashMap;
use std::ops::RangeInclusive;

/// What is known of a field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Note {
    /// Its documentation.
    pub help: String,
    /// Its unit.
    pub unit: Option<&'static str>,
    /// What its values may be.
    pub range: Option<RangeInclusive<f64>>,
    /// Whether it is a colour.
    pub color: bool,
    /// The field beside it, and the variant of that, with which alone it counts.
    pub only: Option<(String, String)>,
}

/// Units as the comments write them, and as they are shown.
const UNITS: [(&str, &str); 18] = [
    ("degrees/s", "°/s"),
    ("degrees", "°"),
    ("W/(m² sr)", "W/(m² sr)"),
    ("W/m²", "W/m²"),
    ("W/sr", "W/sr"),
    ("m/s²", "m/s²"),
    ("m/s", "m/s"),
    ("1/s", "1/s"),
    ("1/m", "1/m"),
    ("nm", "nm"),
    ("mm", "mm"),
    ("m", "m"),
    ("s", "s"),
    ("texels", "texels"),
    ("pixels", "px"),
    ("cells", "cells"),
    ("rad", "rad"),
    ("ticks", "ticks"),
];

/// The notes of all types.
#[derive(Debug, Default)]
pub struct Docs(HashMap<String, Note>);

impl Docs {
    /// Reads source texts.
    pub fn read(sources: &[&str]) -> Self {
        let mut docs = Self::default();
        sources.iter().for_each(|source| docs.add(source));
        docs
    }

    /// The note of `Type`, `Type.field`, `Enum.Variant` or `Enum.Variant.field`.
    pub fn note(&self, key: &str) -> Note {
        self.0.get(key).cloned().unwrap_or_default()
    }

    /// Adds a comment on `Type`, `Type.field`, `Enum.Variant` or `Enum.Variant.field`.
    pub fn insert(&mut self, key: &str, help: &str) {
        self.keep(key, &mut help.to_owned());
    }

    /// Reads the comments of one source text.
    pub fn add(&mut self, source: &str) {
        let (mut comment, mut renamed) = (String::new(), None);
        // The type, and the variant, that the present line stands in.
        let mut scopes: Vec<String> = Vec::new();
        for line in source.lines() {
            let line = line.trim();
            if let Some(text) = line.strip_prefix("///") {
                comment.push_str(text.trim());
                comment.push(' ');
            } else if line.starts_with("#[") {
                renamed = quoted_after(line, "rename = ").or(renamed);
            } else if let Some(name) = ["pub struct ", "pub enum "].iter().find_map(|p| line.strip_prefix(p)) {
                let name = renamed.take().unwrap_or_else(|| identifier(name).to_owned());
                self.keep(&name, &mut comment);
                scopes = if line.ends_with('{') { vec![name] } else { Vec::new() };
            } else if let Some(scope) = scopes.last().cloned() {
                let word = identifier(line.strip_prefix("pub ").unwrap_or(line));
                if line.starts_with('}') {
                    scopes.pop();
                } else if !comment.is_empty() && !word.is_empty() {
                    let key = format!("{scope}.{word}");
                    self.keep(&key, &mut comment);
                    if line.ends_with('{') {
                        scopes.push(key);
                    }
                }
                comment.clear();
                renamed = None;
            } else {
                comment.clear();
                renamed = None;
            }
        }
    }

    fn keep(&mut self, key: &str, comment: &mut String) {
        let help = std::mem::take(comment).trim().replace("\\[", "[").replace("\\]", "]");
        if !help.is_empty() {
            // The first one counts: types of files come before those of the world.
            self.0.entry(key.to_owned()).or_insert_with(|| Note::of(help));
        }
    }
}

impl Note {
    fn of(help: String) -> Self {
        let written = |unit: &str| help.contains(&format!("[{unit}]")) || help.contains(&format!("({unit})"));
        let unit = UNITS.iter().find(|(text, _)| written(text)).map(|(_, shown)| *shown);
        let lower = help.to_lowercase();
        let color = lower.contains("linear rgb") || lower.contains("linear (r, g, b)");
        Self { unit, range: range(&help), color, only: only(&help), help }
    }
}

/// The condition in words like "with `transport: Sweep` alone".
fn only(help: &str) -> Option<(String, String)> {
    let (before, _) = help.split_once("` alone")?;
    let (_, condition) = before.rsplit_once('`')?;
    let (field, variant) = condition.split_once(": ")?;
    Some((field.to_owned(), variant.to_owned()))
}

/// The range in words like `0..1` or `1 to 4`.
fn range(help: &str) -> Option<RangeInclusive<f64>> {
    let words: Vec<&str> = help.split(|c: char| c.is_whitespace() || ",;()".contains(c)).collect();
    let number = |word: &str| word.trim_end_matches(['.', ':']).replace('−', "-").parse::<f64>().ok();
    let dotted = words.iter().find_map(|word| {
        let (low, high) = word.split_once("..")?;
        Some(number(low)?..=number(high)?)
    });
    let spoken = words.windows(3).find(|w| w[1] == "to").and_then(|w| Some(number(w[0])?..=number(w[2])?));
    dotted.or(spoken).filter(|range| range.start() < range.end())
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

fn quoted_after(line: &str, word: &str) -> Option<String> {
    let rest = &line[line.find(word)? + word.len()..];
    let rest = rest.strip_prefix('"')?;
    Some(rest[..rest.find('"')?].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use lightwell::files::DESCRIBED;

    #[test]
    fn notes_come_from_the_engine_itself() {
        let docs = Docs::read(&DESCRIBED);
        assert_eq!(docs.note("Camera.fov").unit, Some("°"));
        assert_eq!(docs.note("Camera.near").unit, Some("m"));
        assert_eq!(docs.note("Clpv.cascades").range, Some(1.0..=4.0));
        assert_eq!(docs.note("LightKind.Spot.inner").unit, Some("°"));
        assert!(docs.note("LightKind.Directional").help.contains("Parallel"));
        assert!(docs.note("Light.color").color);
        assert_eq!(docs.note("Material.metallic").unit, None);
        assert_eq!(docs.note("Material.roughness").range, Some(0.0..=1.0));
        assert!(docs.note("Transform.rotation").help.contains("look_at"), "the file's type, not the world's");
        let only = |field: &str| docs.note(&format!("Clpv.{field}")).only.map(|(_, variant)| variant);
        assert_eq!(
            (only("quality"), only("steps"), only("cells")),
            (Some("Sweep".into()), Some("Diffusion".into()), None)
        );
        let [extinction, anisotropy] = ["extinction", "anisotropy"].map(|field| docs.note(&format!("Fog.{field}")));
        assert_eq!((extinction.unit, extinction.range), (Some("1/m"), Some(0.0..=1e6)));
        assert_eq!((anisotropy.unit, anisotropy.range), (None, Some(-0.95..=0.95)));
        assert_eq!(docs.note("FogShape.Box.size").unit, Some("m"));
        assert!(docs.note("Fog.albedo").color && docs.note("Fog.albedo").range == Some(0.0..=1.0));
        assert_eq!(docs.note("Nothing.at_all"), Note::default());
    }
}
