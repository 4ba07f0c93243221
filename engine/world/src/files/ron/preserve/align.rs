//! Which elements of a list are the same before and after: those of entities by their names, all others by what they
//! say.

use crate::files::ron::tree::{Item, Node};
use std::collections::HashMap;

/// How a list became another one.
pub struct Alignment {
    /// For each element after, the one before that became it.
    pub from: Vec<Option<usize>>,
    /// For each element after, whether it stands where it stood: the others were put elsewhere.
    pub stays: Vec<bool>,
}

impl Alignment {
    pub fn of(before: &[Item], after: &[Item]) -> Self {
        let entities = before.iter().chain(after).all(|item| name_of(&item.node).is_some());
        let key = |item: &Item| match name_of(&item.node).filter(|_| entities) {
            Some(name) => name.to_owned(),
            None => item.node.compact(),
        };
        let mut from = equal(before, after, key);
        if entities {
            pair_renamed(before, after, &mut from);
            let stays = rising(&from);
            return Self { from, stays };
        }
        let mut stays = rising(&from);
        pair_changed(before.len(), &mut from, &mut stays);
        Self { from, stays }
    }

    /// The elements that are gone.
    pub fn gone(&self, count: usize) -> Vec<usize> {
        let mut is_kept = vec![false; count];
        self.from.iter().flatten().for_each(|index| is_kept[*index] = true);
        (0..count).filter(|index| !is_kept[*index]).collect()
    }
}

/// The name of an entity as it is written.
pub fn name_of(node: &Node) -> Option<&str> {
    let group = node.group.as_ref().filter(|_| node.head.is_empty())?;
    group.items.iter().find(|item| item.key.as_deref() == Some("name")).map(|item| item.node.head.as_str())
}

/// Whether two values say the same.
pub fn same(a: &Node, b: &Node) -> bool {
    if a.head != b.head {
        return false;
    }
    match (&a.group, &b.group) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let equal = |(a, b): (&Item, &Item)| a.key == b.key && same(&a.node, &b.node);
            a.open == b.open && a.items.len() == b.items.len() && a.items.iter().zip(&b.items).all(equal)
        }
        _ => false,
    }
}

/// How many fields of two entities, besides name and place, are equal, and how many there are.
pub fn likeness(a: &Node, b: &Node) -> (usize, usize) {
    let fields = |node: &Node| -> HashMap<String, Node> {
        let items = node.group.iter().flat_map(|group| &group.items);
        let known = items.filter_map(|item| Some((item.key.clone()?, item.node.clone())));
        known.filter(|(key, _)| !matches!(key.as_str(), "name" | "transform")).collect()
    };
    let (a, b) = (fields(a), fields(b));
    let equal = a.iter().filter(|(key, node)| b.get(*key).is_some_and(|other| same(node, other))).count();
    let all = a.len() + b.keys().filter(|key| !a.contains_key(*key)).count();
    (equal, all)
}

/// Elements of equal keys, in the order in which they come.
fn equal(before: &[Item], after: &[Item], key: impl Fn(&Item) -> String) -> Vec<Option<usize>> {
    let mut places: HashMap<String, Vec<usize>> = HashMap::new();
    for (index, item) in before.iter().enumerate().rev() {
        places.entry(key(item)).or_default().push(index);
    }
    after.iter().map(|item| places.get_mut(&key(item)).and_then(Vec::pop)).collect()
}

/// An entity of another name that is much like one that is gone was renamed.
fn pair_renamed(before: &[Item], after: &[Item], from: &mut [Option<usize>]) {
    let mut gone = Alignment { from: from.to_vec(), stays: Vec::new() }.gone(before.len());
    for (slot, item) in from.iter_mut().zip(after).filter(|(slot, _)| slot.is_none()) {
        let score = |index: &usize| likeness(&before[*index].node, &item.node);
        let alike = gone.iter().filter(|index| {
            let (equal, all) = score(index);
            equal * 2 >= all && (all > 0 || place_of(&before[**index].node) == place_of(&item.node))
        });
        let best = alike.max_by_key(|index| (score(index).0, std::cmp::Reverse(**index))).copied();
        gone.retain(|index| Some(*index) != best);
        *slot = best;
    }
}

fn place_of(node: &Node) -> Option<String> {
    let items = &node.group.as_ref()?.items;
    items.iter().find(|item| item.key.as_deref() == Some("transform")).map(|item| item.node.compact())
}

/// Between elements that stay, those that changed are paired by their places.
fn pair_changed(count: usize, from: &mut [Option<usize>], stays: &mut [bool]) {
    let mut free = vec![true; count];
    from.iter().flatten().for_each(|index| free[*index] = false);
    let mut next = 0;
    for slot in 0..from.len() {
        if stays[slot] {
            next = from[slot].map_or(next, |index| index + 1);
        } else if from[slot].is_none() {
            let end = (slot..from.len()).find(|later| stays[*later]).and_then(|later| from[later]).unwrap_or(count);
            if let Some(index) = (next..end).find(|index| free[*index]) {
                (from[slot], stays[slot], next) = (Some(index), true, index + 1);
            }
        }
    }
}

/// A longest rising part of the places, by the length of the best chains that end with each (Fredman 1975).
fn rising(from: &[Option<usize>]) -> Vec<bool> {
    let mut ends: Vec<usize> = Vec::new();
    let mut previous = vec![None; from.len()];
    for (slot, index) in from.iter().enumerate().filter_map(|(slot, index)| Some((slot, (*index)?))) {
        let length = ends.partition_point(|end| from[*end].is_some_and(|other| other < index));
        previous[slot] = length.checked_sub(1).map(|shorter| ends[shorter]);
        match ends.get_mut(length) {
            Some(end) => *end = slot,
            None => ends.push(slot),
        }
    }
    let mut stays = vec![false; from.len()];
    let mut next = ends.last().copied();
    while let Some(slot) = next {
        stays[slot] = true;
        next = previous[slot];
    }
    stays
}
