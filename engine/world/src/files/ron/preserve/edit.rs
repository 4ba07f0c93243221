//! Values whose meaning changed.

use super::align::same;
use super::moves::Moves;
use super::old::Old;
use super::style::{Style, indent_at, whole};
use crate::files::ron::tree::{Group, Node};
use std::cell::Cell;

/// Makes of a value what is printed for it, by the keys that lead to it: its holder's and its own.
pub type Print<'a> = &'a dyn Fn(&str, &str, &Node) -> Node;

/// The keys that lead to a value.
#[derive(Clone, Copy)]
pub struct Keys<'a> {
    /// Of the group that holds it.
    pub holder: &'a str,
    /// Its own.
    pub own: &'a str,
}

impl<'a> Keys<'a> {
    /// Those of a value inside of this one.
    pub fn inner(self, key: &'a str) -> Self {
        Self { holder: self.own, own: key }
    }
}

/// The edit of a text.
pub struct Edit<'a> {
    pub style: Style,
    pub moves: Moves<'a>,
    print: Print<'a>,
    /// Items that were put into groups so far.
    pub inserted: Cell<usize>,
}

impl<'a> Edit<'a> {
    pub fn new(style: Style, print: Print<'a>, moves: Moves<'a>) -> Self {
        Self { style, print, moves, inserted: Cell::new(0) }
    }

    /// The text of the outermost value.
    pub fn root(&self, old: Old, before: &Node, after: &Node) -> String {
        let value = self.value(old, before, after, Keys { holder: "", own: "" });
        self.fitting(value, "", 0, self.inserted.get() > 0)
    }

    /// The text of a value that meant `before` and shall mean `after`.
    pub fn value(&self, old: Old, before: &Node, after: &Node, keys: Keys) -> String {
        if same(before, after) {
            return old.as_str().to_owned();
        }
        let inner = old.unwrapped(before);
        let value = self.changed(inner, before, after, keys);
        let start = &old.text[old.node.span.start..inner.node.span.start];
        [start, &value, &old.text[inner.node.span.end..old.node.span.end]].concat()
    }

    fn changed(&self, old: Old, before: &Node, after: &Node, keys: Keys) -> String {
        let groups = (&old.node.group, &before.group, &after.group);
        let (Some(text), Some(was), Some(is)) = groups else {
            return self.replaced(old, after, keys);
        };
        if before.head != after.head || was.open != is.open {
            return self.replaced(old, after, keys);
        }
        let has_keys = |group: &Group| group.items.iter().all(|item| item.key.is_some());
        let counts = [text, was, is].map(|group| group.items.len());
        match was.open {
            '[' if text.open == '[' && counts[0] == counts[1] => self.list(old, [text, was, is], keys),
            '(' | '{' if text.open == was.open && [text, was, is].into_iter().all(has_keys) => {
                self.fields(old, [text, was, is], keys)
            }
            '(' if counts == [counts[0]; 3] && ![text, was, is].into_iter().any(has_keys) => {
                self.tuple(old, [text, was, is], keys)
            }
            _ => self.replaced(old, after, keys),
        }
    }

    fn tuple(&self, old: Old, [text, was, is]: [&Group; 3], keys: Keys) -> String {
        let mut out = String::new();
        let mut at = old.node.span.start;
        for (item, (was, is)) in text.items.iter().zip(was.items.iter().zip(&is.items)) {
            out.push_str(&old.text[at..item.node.span.start]);
            out.push_str(&self.value(old.at(&item.node), &was.node, &is.node, keys));
            at = item.node.span.end;
        }
        out + &old.text[at..old.node.span.end]
    }

    /// Another value in the place of one.
    fn replaced(&self, old: Old, after: &Node, keys: Keys) -> String {
        let number = |text: &str| text.parse::<f64>().ok();
        if after.group.is_none() && old.node.group.is_none() {
            let was = &old.node.head;
            return match number(was).zip(number(&after.head)) {
                Some((was, is)) if was == is && was.is_sign_negative() == is.is_sign_negative() => old.as_str().into(),
                // A whole number stays one.
                Some(_) if !was.contains(['.', 'e', 'E']) => whole(&after.head).unwrap_or(&after.head).to_owned(),
                _ => self.printed(after, keys).compact(),
            };
        }
        let line = old.text[..old.node.span.start].rfind('\n').map_or(0, |end| end + 1);
        let used = old.text[line..old.node.span.start].chars().count();
        self.style.pretty(&self.printed(after, keys), indent_at(old.text, old.node.span.start), used)
    }

    /// The new text of a value.
    pub fn printed(&self, node: &Node, keys: Keys) -> Node {
        let mut node = (self.print)(keys.holder, keys.own, node);
        self.style.numbers(&mut node);
        node
    }

    /// A group of one line that was given items: over several lines, if it has become too long.
    pub fn fitting(&self, value: String, indent: &str, used: usize, was_given: bool) -> String {
        let is_long = used + value.chars().count() > self.style.width;
        match was_given && is_long && !value.contains('\n') {
            true => self.style.broken(&value, indent),
            false => value,
        }
    }
}
