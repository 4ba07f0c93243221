//! Values of the text that is edited.

use crate::files::ron::tree::Node;

/// A value of a text.
#[derive(Clone, Copy)]
pub struct Old<'t> {
    pub text: &'t str,
    pub node: &'t Node,
}

impl<'t> Old<'t> {
    /// Another value of the same text.
    pub fn at(self, node: &'t Node) -> Self {
        Self { node, ..self }
    }

    pub fn as_str(self) -> &'t str {
        &self.text[self.node.span.clone()]
    }

    /// The value inside of a `Some(…)` that need not be written.
    pub fn unwrapped(self, before: &Node) -> Self {
        let group = self.node.group.as_ref().filter(|_| self.node.head == "Some" && before.head != "Some");
        match group.map(|group| &group.items[..]) {
            Some([only]) if only.key.is_none() => self.at(&only.node),
            _ => self,
        }
    }
}
