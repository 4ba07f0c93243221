//! The shape of a RON text: where each value stands, and a writer that keeps short groups on one line.
//!
//! `ron` gives the place of a syntax error, but a value that is well formed and still wrong (a negative size, a name
//! given twice) is found later, when only the values are left. The tree finds the place again by the value's path.

use std::ops::Range;

/// The field of entities that holds components of a game: names within them mean something else.
pub const OWN: &str = "components";

/// One step from a value to a value inside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Field of a structure, or key of a map.
    Key(String),
    /// Element of a list or tuple.
    Index(usize),
}

/// A value in a RON text.
#[derive(Clone, Debug)]
pub struct Node {
    /// Bytes that it covers.
    pub span: Range<usize>,
    /// A literal, or the name before a group's bracket, may be empty.
    pub(in crate::files) head: String,
    /// The bracketed rest, if any.
    pub(in crate::files) group: Option<Group>,
}

#[derive(Clone, Debug)]
pub(in crate::files) struct Group {
    pub open: char,
    pub items: Vec<Item>,
    /// Bytes between the brackets.
    pub inside: Range<usize>,
}

#[derive(Clone, Debug)]
pub(in crate::files) struct Item {
    pub key: Option<String>,
    pub key_text: String,
    pub node: Node,
    /// Bytes from the key to the end of the value.
    pub span: Range<usize>,
    /// Byte of the comma behind it.
    pub comma: Option<usize>,
}

/// Longest line that the writer makes where it has a choice (characters).
pub(in crate::files) const WIDTH: usize = 110;

impl Node {
    /// The value at the path, or the innermost one on the way there.
    pub fn find(&self, path: &[Step]) -> &Node {
        let mut node = self;
        for step in path {
            match node.child(step) {
                Some(child) => node = child,
                None => break,
            }
        }
        node
    }

    fn child(&self, step: &Step) -> Option<&Node> {
        let items = &self.group.as_ref()?.items;
        match step {
            Step::Index(index) => items.get(*index).map(|item| &item.node),
            Step::Key(key) => items.iter().find(|item| item.key.as_deref() == Some(key)).map(|item| &item.node),
        }
    }

    /// Drops the fields of this group that say the same as `default`, except those to keep.
    pub fn drop_defaults(&mut self, default: &Node, keep: &[&str]) {
        let (Some(group), Some(other)) = (&mut self.group, &default.group) else { return };
        group.items.retain(|item| {
            let Some(key) = &item.key else { return true };
            let same =
                other.items.iter().any(|d| d.key.as_ref() == Some(key) && d.node.compact() == item.node.compact());
            keep.contains(&key.as_str()) || !same
        });
    }

    /// Writes a plain `None` where `ron` writes the raw name `r#None` for a variant that is not the option's.
    pub fn unraw(&mut self) {
        if let Some(plain) = self.head.strip_prefix("r#").filter(|_| self.group.is_none()) {
            self.head = plain.to_owned();
        }
    }

    /// Calls `f` with the key of every field in the tree as written (keys of maps in quotes) and its value, outermost
    /// first. What is inside of a game's components is left out.
    pub fn for_each_field(&mut self, f: &mut impl FnMut(&str, &mut Node)) {
        let Some(group) = &mut self.group else { return };
        for item in &mut group.items {
            if item.key.is_some() {
                f(&item.key_text, &mut item.node);
            }
            if item.key_text != OWN {
                item.node.for_each_field(f);
            }
        }
    }

    /// Calls `f` with the key of every field of this group alone.
    pub fn for_each_direct_field(&mut self, f: &mut impl FnMut(&str, &mut Node)) {
        let items = self.group.iter_mut().flat_map(|group| &mut group.items);
        items.filter(|item| item.key.is_some()).for_each(|item| f(&item.key_text, &mut item.node));
    }

    /// A group that holds the value alone, under a key.
    pub fn within(self, key: &str) -> Self {
        let item = Item { key: Some(unquote(key)), key_text: key.to_owned(), span: 0..0, comma: None, node: self };
        Self { span: 0..0, head: String::new(), group: Some(Group { open: '(', items: vec![item], inside: 0..0 }) }
    }

    /// The value that the group holds alone.
    pub fn into_only(self) -> Option<Self> {
        self.group.and_then(|mut group| group.items.pop()).map(|item| item.node)
    }

    /// The value on one line.
    pub fn compact(&self) -> String {
        let Some(group) = &self.group else { return self.head.clone() };
        let items: Vec<String> = group.items.iter().map(Item::compact).collect();
        let newtype = group.open == '(' && items.len() == 1 && group.items[0].key.is_none() && self.head.is_empty();
        let comma = if newtype { "," } else { "" };
        format!("{}{}{}{comma}{}", self.head, group.open, items.join(", "), closing(group.open))
    }

    /// The value over as many lines as it needs.
    pub fn pretty(&self) -> String {
        let mut out = String::new();
        self.write(&mut out, 0, 0);
        out
    }

    fn write(&self, out: &mut String, indent: usize, used: usize) {
        let compact = self.compact();
        let Some(group) = &self.group else {
            out.push_str(&compact);
            return;
        };
        // Lists of structures read best one a line, even if short; the outermost group is always opened.
        let is_list = group.open == '[' && group.items.iter().any(|i| i.node.group.is_some());
        if indent > 0 && !is_list && used + compact.chars().count() < WIDTH || group.items.is_empty() {
            out.push_str(&compact);
            return;
        }
        out.push_str(&self.head);
        out.push(group.open);
        out.push('\n');
        for item in &group.items {
            let pad = 4 * (indent + 1);
            out.push_str(&" ".repeat(pad));
            let key = item.prefix();
            out.push_str(&key);
            item.node.write(out, indent + 1, pad + key.chars().count());
            out.push_str(",\n");
        }
        out.push_str(&" ".repeat(4 * indent));
        out.push(closing(group.open));
    }
}

impl Group {
    /// The value of a key.
    pub fn get(&self, key: &Option<String>) -> Option<&Node> {
        self.items.iter().find(|item| item.key == *key).map(|item| &item.node)
    }
}

impl Item {
    /// The key with its colon.
    pub fn prefix(&self) -> String {
        if self.key.is_some() { format!("{}: ", self.key_text) } else { String::new() }
    }

    fn compact(&self) -> String {
        self.prefix() + &self.node.compact()
    }
}

pub(in crate::files) fn closing(open: char) -> char {
    match open {
        '(' => ')',
        '[' => ']',
        _ => '}',
    }
}

/// The text of a string literal as the file means it; other text stays as it is.
pub(in crate::files) fn unquote(text: &str) -> String {
    ron::from_str::<String>(text).unwrap_or_else(|_| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(k: &str) -> Step {
        Step::Key(k.into())
    }

    #[test]
    fn finds_values_by_path_past_comments_and_strings() {
        let text = "// c ( [\n(a: \"x, (\", /* ) */ b: [ (c: Box(size: (1, -2, 3))), 7 ], m: {\"k /*\": 5})";
        let tree = Node::parse(text);
        let at = |path: &[Step]| &text[tree.find(path).span.clone()];
        assert_eq!(at(&[key("a")]), "\"x, (\"");
        assert_eq!(at(&[key("b"), Step::Index(0), key("c"), key("size"), Step::Index(1)]), "-2");
        assert_eq!(at(&[key("b"), Step::Index(1)]), "7");
        assert_eq!(at(&[key("m"), key("k /*")]), "5");
        assert_eq!(at(&[key("b"), key("nothing")]), "[ (c: Box(size: (1, -2, 3))), 7 ]");
    }

    #[test]
    fn writes_short_groups_on_one_line_and_reads_its_own_text() {
        let text = format!("(a:[(x:1,y:(2,3)),(x:4)],long:[{}],e:())", "(name:\"some name\"),".repeat(12));
        let pretty = Node::parse(&text).pretty();
        assert!(pretty.contains("        (x: 1, y: (2, 3)),\n"), "{pretty}");
        assert_eq!(Node::parse(&pretty).pretty(), pretty);
    }
}
