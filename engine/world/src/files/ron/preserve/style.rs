//! How a file is written, so that what is new looks like what is there.

use super::layout::Layout;
use crate::files::ron::tree::{Node, OWN, WIDTH, closing};
use std::ops::Range;

/// How a file is written.
pub struct Style {
    /// Its line ends.
    pub newline: &'static str,
    /// One step of indentation.
    pub unit: String,
    /// Characters of the longest line that is its author's own.
    pub width: usize,
    /// Whether whole numbers are written without a point.
    plain_numbers: bool,
}

impl Style {
    /// The style of a text with its shape.
    pub fn of(text: &str, root: &Node) -> Self {
        let group = root.group.as_ref();
        let unit = group.and_then(|group| Layout::of(text, group).indent().map(str::to_owned));
        let pointed = text.match_indices(".0").any(|(at, _)| !text[at + 2..].starts_with(|c: char| c.is_ascii_digit()));
        Self {
            newline: if text.contains("\r\n") { "\r\n" } else { "\n" },
            unit: unit.filter(|unit| !unit.is_empty()).unwrap_or_else(|| "    ".into()),
            width: text.lines().map(|line| line.chars().count()).max().unwrap_or(0).max(WIDTH),
            plain_numbers: !pointed,
        }
    }

    /// The value with numbers as the file has them.
    pub fn numbers(&self, node: &mut Node) {
        if !self.plain_numbers {
            return;
        }
        if let Some(whole) = whole(&node.head).filter(|_| node.group.is_none()) {
            node.head = whole.to_owned();
        }
        let items = node.group.iter_mut().flat_map(|group| &mut group.items);
        // What components unknown to this program mean is not known.
        items.filter(|item| item.key_text != OWN).for_each(|item| self.numbers(&mut item.node));
    }

    /// The value over as many lines as it needs, at an indentation and with `used` characters before it on its line.
    pub fn pretty(&self, node: &Node, indent: &str, used: usize) -> String {
        let compact = node.compact();
        let Some(group) = &node.group else { return compact };
        let is_list = group.open == '[' && group.items.iter().any(|item| item.node.group.is_some());
        if group.items.is_empty() || !is_list && used + compact.chars().count() <= WIDTH {
            return compact;
        }
        let inner = format!("{indent}{}", self.unit);
        let mut out = format!("{}{}", node.head, group.open);
        for item in &group.items {
            let key = item.prefix();
            let value = self.pretty(&item.node, &inner, inner.chars().count() + key.chars().count());
            out.extend([self.newline, &inner, &key, &value, ","]);
        }
        out.extend([self.newline, indent]);
        out.push(closing(group.open));
        out
    }

    /// A group of one line with a line for each of its items.
    pub fn broken(&self, text: &str, indent: &str) -> String {
        let node = Node::parse(text);
        let Some(group) = &node.group else { return text.to_owned() };
        let inside: &Range<usize> = &group.inside;
        let mut out = text[..inside.start].to_owned();
        for chunk in Layout::of(text, group).chunks {
            let parts = [chunk.lead, &text[chunk.core.clone()], chunk.between, ",", chunk.trail];
            out.extend([self.newline, indent, &self.unit]);
            out.extend(parts);
        }
        out.extend([self.newline, indent, &text[inside.end..]]);
        out
    }
}

/// A whole number without its point.
pub fn whole(number: &str) -> Option<&str> {
    let whole = number.strip_suffix(".0")?;
    whole.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit()).then_some(whole)
}

/// The blanks that the line of a byte begins with.
pub fn indent_at(text: &str, at: usize) -> &str {
    let line = &text[text[..at].rfind('\n').map_or(0, |end| end + 1)..];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

/// The text with its lines, the first one apart, indented differently. Lines that begin inside of a string stay.
pub fn reindented(text: &str, from: &str, to: &str) -> String {
    if from == to {
        return text.to_owned();
    }
    let strings = crate::files::ron::scan::strings(text);
    let mut out = String::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let is_text = at == 0 || strings.iter().any(|string| string.start < at && at < string.end);
        match line.strip_prefix(from).filter(|_| !is_text) {
            Some(rest) if !rest.trim().is_empty() => out.extend([to, rest]),
            _ => out.push_str(line),
        }
        at += line.len();
    }
    out
}
