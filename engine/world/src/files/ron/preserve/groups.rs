//! Fields and elements that change, come, go and move.

use super::align::{Alignment, same};
use super::edit::{Edit, Keys};
use super::layout::Layout;
use super::old::Old;
use super::rows::{Body, Row, Shape, carried};
use crate::files::ron::renamed::present_name;
use crate::files::ron::tree::{Group, Item, Node, OWN};

impl Edit<'_> {
    /// A group of fields, or a map.
    pub fn fields(&self, old: Old, [text, was, is]: [&Group; 3], keys: Keys) -> String {
        let shape = Shape::of(old, text, &self.style, false);
        let meant = |group: &'_ Group, item: &Item| field_of(group, item, keys).cloned();
        let mut renamed = renamed_keys(was, is);
        let mut rows: Vec<Row> = Vec::new();
        for (index, item) in text.items.iter().enumerate() {
            let (node, inner) = (old.at(&item.node), keys.inner(&item.key_text));
            let prefix = &old.text[item.span.start..item.node.span.start];
            let so_far = self.inserted.get();
            let (prefix, value, key) = match (meant(was, item), meant(is, item)) {
                (None, None) => (prefix.to_owned(), node.as_str().to_owned(), &item.key),
                // It is written, and the writer would not have said it.
                (None, Some(is)) => (prefix.to_owned(), self.value(node, &item.node, &is, inner), &item.key),
                (Some(was), Some(is)) => (prefix.to_owned(), self.value(node, &was, &is, inner), &item.key),
                (Some(_), None) => match renamed.iter().position(|(from, _)| Some(from) == item.key.as_ref()) {
                    Some(pair) => {
                        let (_, new) = renamed.swap_remove(pair);
                        let prefix = prefix.replacen(&item.key_text, &new.key_text, 1);
                        (prefix, node.as_str().to_owned(), &new.key)
                    }
                    None => continue,
                },
            };
            let was_given = self.inserted.get() > so_far;
            rows.push(Row::kept(&shape, index, self.fitting_item(&shape, prefix, value, was_given), key.clone()));
        }
        self.add_fields(&mut rows, &shape, [text, was, is], keys);
        shape.assembled(old, text, &self.style, rows)
    }

    /// Adds the fields that are not written yet: each behind the one that the writer says before it, and entries of maps
    /// at the end.
    fn add_fields(&self, rows: &mut Vec<Row>, shape: &Shape, [text, was, is]: [&Group; 3], keys: Keys) {
        let mut behind = 0;
        for item in &is.items {
            if let Some(place) = rows.iter().position(|row| row.key == item.key) {
                behind = place + 1;
                continue;
            }
            let is_written = text.items.iter().any(|old| present_key(old, keys) == item.key.as_deref());
            if is_written || was.get(&item.key).is_some_and(|was| same(was, &item.node)) {
                continue;
            }
            let prefix = item.prefix();
            let value = self.written(&item.node, keys.inner(&item.key_text), shape, prefix.chars().count());
            let place = if is.open == '{' { rows.len() } else { behind };
            rows.insert(place, Row::new(Body::bare(prefix + &value), item.key.clone()));
            behind = place + 1;
            self.inserted.set(self.inserted.get() + 1);
        }
    }

    /// A list.
    pub fn list(&self, old: Old, [text, was, is]: [&Group; 3], keys: Keys) -> String {
        let alignment = Alignment::of(&was.items, &is.items);
        let opens = is.items.iter().any(|item| item.node.group.is_some());
        let shape = Shape::of(old, text, &self.style, opens);
        let mut rows = Vec::new();
        for (item, (from, stays)) in is.items.iter().zip(alignment.from.iter().zip(&alignment.stays)) {
            let so_far = self.inserted.get();
            let Some(index) = *from else {
                rows.push(Row::new(self.element(item, &shape, keys), None));
                self.inserted.set(so_far + 1);
                continue;
            };
            let value = self.value(old.at(&text.items[index].node), &was.items[index].node, &item.node, keys.inner(""));
            if *stays {
                let value = self.fitting_item(&shape, String::new(), value, self.inserted.get() > so_far);
                rows.push(Row::kept(&shape, index, value, None));
            } else {
                rows.push(Row::new(carried(&shape.layout, old, index, &value, &shape), None));
            }
        }
        shape.assembled(old, text, &self.style, rows)
    }

    /// An element that was not in the list: from elsewhere in the file, or new.
    fn element(&self, item: &Item, shape: &Shape, keys: Keys) -> Body {
        let Some(moved) = self.moves.get(&item.node) else {
            return Body::bare(self.written(&item.node, keys.inner(""), shape, 0));
        };
        let value = self.value(moved.list.at(moved.node), moved.before, &item.node, keys.inner(""));
        carried(&Layout::of(moved.list.text, moved.group), moved.list, moved.index, &value, shape)
    }

    /// A new value, `used` characters behind the start of its item. What it holds of entities that stood elsewhere keeps
    /// its text.
    fn written(&self, node: &Node, keys: Keys, shape: &Shape, used: usize) -> String {
        let (bare, holds_moved) = self.moves.without_moved(node);
        let printed = self.printed(&bare, keys);
        let text = match &shape.lines {
            Some(lines) => self.style.pretty(&printed, lines, lines.chars().count() + used),
            None => printed.compact(),
        };
        if !holds_moved {
            return text;
        }
        let text = format!("{}{text}", shape.lines.as_ref().unwrap_or(&shape.outer));
        self.value(Old { text: &text, node: &Node::parse(&text) }, &bare, node, keys)
    }

    /// The text of an item, over several lines if it was given more than fits.
    fn fitting_item(&self, shape: &Shape, prefix: String, value: String, was_given: bool) -> String {
        let Some(lines) = &shape.lines else { return prefix + &value };
        let used = lines.chars().count() + prefix.chars().count() + 1;
        let value = self.fitting(value, lines, used, was_given);
        prefix + &value
    }
}

/// The key that an item of a file has now: components of the engine had other names.
fn present_key<'i>(item: &'i Item, keys: Keys) -> Option<&'i str> {
    let key = item.key.as_deref()?;
    Some(present_name(key).filter(|_| keys.own == OWN).unwrap_or(key))
}

/// The meaning of a field of the text.
fn field_of<'g>(group: &'g Group, item: &Item, keys: Keys) -> Option<&'g Node> {
    let present = || group.get(&present_key(item, keys).map(str::to_owned));
    group.get(&item.key).or_else(present)
}

/// Keys of a map that say now what gone ones said.
fn renamed_keys<'g>(was: &'g Group, is: &'g Group) -> Vec<(String, &'g Item)> {
    if was.open != '{' {
        return Vec::new();
    }
    let mut new: Vec<&Item> = is.items.iter().filter(|item| was.get(&item.key).is_none()).collect();
    let gone = was.items.iter().filter(|item| is.get(&item.key).is_none());
    let pair = |old: &Item| {
        let found = new.iter().position(|item| same(&item.node, &old.node))?;
        Some((old.key.clone()?, new.swap_remove(found)))
    };
    gone.filter_map(pair).collect()
}
