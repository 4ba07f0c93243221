//! Two changes of one text: what a file's author changed, in a value that has changed by itself since.

use super::tree::Node;

/// `present` with what differs between two versions of the file: fields that the author changed are the author's, all
/// others stay as they are. Lists and tuples count as one value.
pub(in crate::files) fn merged(before: &Node, now: &Node, present: &Node) -> Node {
    if before.compact() == now.compact() {
        return present.clone();
    }
    let (Some(old), Some(new), Some(here)) = (&before.group, &now.group, &present.group) else { return now.clone() };
    let has_keys = |node: &Node| node.group.iter().flat_map(|group| &group.items).all(|item| item.key.is_some());
    let alike = before.head == now.head && now.head == present.head && old.open == new.open && new.open == here.open;
    if !alike || ![before, now, present].into_iter().all(has_keys) {
        return now.clone();
    }
    let mut result = present.clone();
    let Some(group) = &mut result.group else { return now.clone() };
    // What the author took out goes.
    group.items.retain(|item| old.get(&item.key).is_none() || new.get(&item.key).is_some());
    for item in &new.items {
        let there = group.items.iter_mut().find(|there| there.key == item.key);
        match (old.get(&item.key), there) {
            (Some(before), Some(there)) => there.node = merged(before, &item.node, &there.node),
            (Some(before), None) if before.compact() == item.node.compact() => {}
            (None, Some(there)) => there.node = item.node.clone(),
            (_, None) => group.items.push(item.clone()),
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merge(before: &str, now: &str, present: &str) -> String {
        merged(&Node::parse(before), &Node::parse(now), &Node::parse(present)).compact()
    }

    #[test]
    fn what_the_author_changed_is_the_authors() {
        let (before, present) =
            ("(push: 9, speed: (0, 0), kind: A(x: 1, y: 2))", "(push: 9, speed: (3, 4), kind: A(x: 1, y: 7))");
        assert_eq!(merge(before, before, present), present);
        let now = "(push: 12, speed: (0, 0), kind: A(x: 5, y: 2))";
        assert_eq!(merge(before, now, present), "(push: 12, speed: (3, 4), kind: A(x: 5, y: 7))");
        let other = "(push: 9, speed: (1, 0), kind: B(x: 1))";
        assert_eq!(merge(before, other, present), "(push: 9, speed: (1, 0), kind: B(x: 1))");
    }

    #[test]
    fn fields_come_and_go() {
        assert_eq!(merge("(a: 1, b: 2)", "(b: 2, c: 3)", "(a: 1, b: 5)"), "(b: 5, c: 3)");
        assert_eq!(
            merge("{\"A\": (x: 1)}", "{\"A\": (x: 1), \"B\": ()}", "{}"),
            "{\"B\": ()}",
            "A was taken away since"
        );
    }
}
