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
mod old;
mod rows;
mod style;

pub use align::same;

use super::tree::Node;
use edit::{Edit, Print};
use moves::Moves;
use old::Old;
use style::Style;

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
