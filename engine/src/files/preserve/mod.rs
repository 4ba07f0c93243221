//! A save as an edit of the file's text: what it means is compared with what is to be saved, and only what differs is
//! written. All else stays byte for byte: comments, order, numbers as they were written, fields that say what is the
//! default anyway.
//!
//! Three trees of the same shape are walked side by side: the text's, what it means (`before`) and what it shall mean
//! (`after`), both as the writer of new files would say them, defaults included. Fields are told by their keys, entities
//! by their names, see [`align`]; what an item takes along when it goes or moves is said in [`layout`].

mod align;
mod edit;
mod groups;
mod layout;
mod moves;
mod rows;
mod style;

pub use align::same;

use super::tree::Node;
use edit::Edit;
use moves::Moves;
use style::Style;

/// Makes of a value what is printed for it, by the keys that lead to it: its holder's and its own.
pub type Print<'a> = &'a dyn Fn(&str, &str, &Node) -> Node;

/// The text of a file that meant `before` and shall mean `after`.
pub fn edited(text: &str, before: &Node, after: &Node, print: Print) -> String {
    let (mark, body) = match text.strip_prefix('\u{feff}') {
        Some(body) => ("\u{feff}", body),
        None => ("", text),
    };
    let root = Node::parse(body);
    let old = Old { text: body, node: &root };
    let edit = Edit::new(Style::of(body, &root), print, Moves::of(old, before, after));
    let value = edit.root(old, before, after);
    [mark, &body[..root.span.start], &value, &body[root.span.end..]].concat()
}

/// A value of a text.
#[derive(Clone, Copy)]
struct Old<'t> {
    text: &'t str,
    node: &'t Node,
}

impl<'t> Old<'t> {
    /// Another value of the same text.
    fn at(self, node: &'t Node) -> Self {
        Self { node, ..self }
    }

    fn as_str(self) -> &'t str {
        &self.text[self.node.span.clone()]
    }

    /// The value inside of a `Some(…)` that need not be written.
    fn unwrapped(self, before: &Node) -> Self {
        let group = self.node.group.as_ref().filter(|_| self.node.head == "Some" && before.head != "Some");
        match group.map(|group| &group.items[..]) {
            Some([only]) if only.key.is_none() => self.at(&only.node),
            _ => self,
        }
    }
}
