//! Entities that stand elsewhere in the tree than they did, so that their text goes with them.

use super::align::{Alignment, likeness, name_of, same};
use super::old::Old;
use crate::files::ron::tree::{Group, Item, Node};
use std::collections::HashMap;

/// An entity in its old place.
#[derive(Clone, Copy)]
pub struct Moved<'a> {
    /// The list that holds it.
    pub list: Old<'a>,
    pub group: &'a Group,
    pub index: usize,
    /// Its text.
    pub node: &'a Node,
    /// The value of the text.
    pub before: &'a Node,
}

/// The entities that moved, by where they stand in the description of what is to be saved.
#[derive(Default)]
pub struct Moves<'a>(HashMap<usize, Moved<'a>>);

impl<'a> Moves<'a> {
    pub fn of(old: Old<'a>, before: &'a Node, after: &'a Node) -> Self {
        let mut moves = Self::default();
        let mut search = Search::default();
        search.compare(old, before, after);
        let (mut gone, mut came) = (Vec::new(), Vec::new());
        while !search.is_empty() {
            let fresh = std::mem::take(&mut search);
            gone.extend(fresh.gone.iter().copied());
            came.extend(fresh.came.iter().copied());
            for (moved, after) in pair(&mut gone, &mut came) {
                moves.0.insert(after.span.start, moved);
                search.compare(moved.list.at(moved.node), moved.before, after);
            }
            // What is really gone or new may have held, or hold, what moved.
            let is_left = |moved: &&Moved| gone.iter().any(|left| std::ptr::eq(left.node, moved.node));
            fresh.gone.iter().filter(is_left).for_each(|moved| search.children_gone(moved));
            let is_new = |after: &&&Node| moves.get(after).is_none();
            fresh.came.iter().filter(is_new).for_each(|after| search.children_came(after));
        }
        moves
    }

    pub fn get(&self, after: &Node) -> Option<&Moved<'a>> {
        self.0.get(&after.span.start)
    }

    /// The value without the entities in it that moved there, and whether there are any.
    pub fn without_moved(&self, node: &Node) -> (Node, bool) {
        let mut bare = node.clone();
        let holds = !self.0.is_empty() && self.take_moved(&mut bare);
        (bare, holds)
    }

    fn take_moved(&self, node: &mut Node) -> bool {
        let Some(group) = &mut node.group else { return false };
        let count = group.items.len();
        group.items.retain(|item| self.get(&item.node).is_none() || name_of(&item.node).is_none());
        let mut holds = group.items.len() < count;
        for item in &mut group.items {
            holds |= self.take_moved(&mut item.node);
        }
        holds
    }
}

/// Entities that are not in the lists where they were.
#[derive(Default)]
struct Search<'a> {
    gone: Vec<Moved<'a>>,
    came: Vec<&'a Node>,
}

impl<'a> Search<'a> {
    fn is_empty(&self) -> bool {
        self.gone.is_empty() && self.came.is_empty()
    }

    fn compare(&mut self, old: Old<'a>, before: &'a Node, after: &'a Node) {
        let groups = (&old.node.group, &before.group, &after.group);
        let (Some(text), Some(was), Some(is)) = groups else { return };
        if same(before, after) || before.head != after.head || was.open != is.open {
            return;
        }
        if was.open == '[' {
            return self.compare_lists(old, [text, was, is]);
        }
        for item in text.items.iter().filter(|item| item.key.is_some()) {
            match (was.get(&item.key), is.get(&item.key)) {
                (Some(was), Some(is)) => self.compare(old.at(&item.node), was, is),
                (Some(was), None) => self.all_gone(old.at(&item.node), was),
                _ => {}
            }
        }
        let new = is.items.iter().filter(|item| was.get(&item.key).is_none());
        new.for_each(|item| self.all_came(&item.node));
    }

    fn compare_lists(&mut self, old: Old<'a>, [text, was, is]: [&'a Group; 3]) {
        let is_entity = |item: &Item| name_of(&item.node).is_some();
        if text.items.len() != was.items.len() || !was.items.iter().chain(&is.items).all(is_entity) {
            return;
        }
        let alignment = Alignment::of(&was.items, &is.items);
        for (item, from) in is.items.iter().zip(&alignment.from) {
            match from {
                Some(index) => {
                    self.compare(old.at(&text.items[*index].node), &was.items[*index].node, &item.node);
                }
                None => self.came.push(&item.node),
            }
        }
        for index in alignment.gone(was.items.len()) {
            self.push_gone(old, text, was, index);
        }
    }

    fn push_gone(&mut self, list: Old<'a>, group: &'a Group, was: &'a Group, index: usize) {
        let (node, before) = (&group.items[index].node, &was.items[index].node);
        self.gone.push(Moved { list, group, index, node, before });
    }

    /// All entities of a list that is gone.
    fn all_gone(&mut self, old: Old<'a>, before: &'a Node) {
        let (Some(text), Some(was)) = (&old.node.group, &before.group) else { return };
        if text.items.len() == was.items.len() && was.open == '[' {
            let entities = (0..was.items.len()).filter(|index| name_of(&was.items[*index].node).is_some());
            entities.for_each(|index| self.push_gone(old, text, was, index));
        }
    }

    fn all_came(&mut self, after: &'a Node) {
        let items = after.group.iter().filter(|group| group.open == '[').flat_map(|group| &group.items);
        self.came.extend(items.map(|item| &item.node).filter(|node| name_of(node).is_some()));
    }

    fn children_gone(&mut self, moved: &Moved<'a>) {
        let children = Some("children".to_owned());
        let of = |node: &'a Node| node.group.as_ref().and_then(|group| group.get(&children));
        if let (Some(text), Some(before)) = (of(moved.node), of(moved.before)) {
            self.all_gone(moved.list.at(text), before);
        }
    }

    fn children_came(&mut self, after: &'a Node) {
        let children = after.group.as_ref().and_then(|group| group.get(&Some("children".to_owned())));
        children.into_iter().for_each(|children| self.all_came(children));
    }
}

/// Takes out pairs of what is gone and what came: entities of one name, the most alike first, and those of other names
/// that are equal but for their place.
fn pair<'a>(gone: &mut Vec<Moved<'a>>, came: &mut Vec<&'a Node>) -> Vec<(Moved<'a>, &'a Node)> {
    let mut pairs = Vec::new();
    came.retain(|after| {
        let score = |moved: &Moved| {
            let (equal, all) = likeness(moved.before, after);
            let is_named_so = name_of(moved.before) == name_of(after);
            (is_named_so || (equal == all && all > 0)).then_some((is_named_so, equal))
        };
        let best = (0..gone.len()).filter_map(|index| Some((score(&gone[index])?, index))).max();
        pairs.extend(best.map(|(_, index)| (gone.remove(index), *after)));
        best.is_none()
    });
    pairs
}
