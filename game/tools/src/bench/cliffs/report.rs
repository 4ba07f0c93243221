//! The report of the cliffs: each room against the plain one.

use super::{Pass, Results, Room};
use crate::bench::report::markdown::{ms, table, times};
use std::collections::BTreeSet;

/// A pass that takes so many times what it does in the plain room is marked.
const CLIFF: f64 = 1.2;
/// Share of the plain room's frame below which a pass is too short to judge by its ratio.
const SHORT: f64 = 0.01;

/// The report as Markdown.
pub fn text(results: &Results) -> String {
    let Some(plain) = results.rooms.first() else { return String::new() };
    let header = &results.header;
    let mut text = format!(
        "# What one small thing costs\n\nA plain room of 6 m with four lights, and the same with one thing more: a card of two \
         triangles, a light or a fog of 0.2 m. Everything is computed in each frame; rooms take turns. {}; {}, {}; commit {}.\n\n\
         Ratios are to the plain room, of the least time over the frames. **Bold**: above {CLIFF} in a pass that takes 1 % of \
         the plain frame or more.\n\n",
        header.settings,
        header.adapter,
        header.system,
        header.commit.as_deref().unwrap_or("unknown"),
    );
    let head = ["room", "frame [ms]", "ratio", "first frame [ms]", "pipelines made", "passes above 1.2"];
    let rows: Vec<Vec<String>> = results.rooms.iter().map(|room| row(plain, room)).collect();
    text += &table(&head, &rows);
    text += "\n## Passes\n\nTime in the plain room, and ratios with each thing in it; a time where the plain room has no such pass.\n\n";
    text += &passes(results, plain);
    text += "\n## Counts\n\nCounts of work that differ from those of the plain room, summed over the frame.\n\n";
    text + &counts(results, plain)
}

fn row(plain: &Room, room: &Room) -> Vec<String> {
    let cliffs = room.passes.iter().filter(|pass| is_cliff(plain, pass)).count();
    vec![
        room.name.clone(),
        ms(room.ms()),
        marked(room.ms() / plain.ms(), room.ms() / plain.ms() > CLIFF),
        ms(room.first_ms),
        room.pipelines.to_string(),
        cliffs.to_string(),
    ]
}

fn marked(ratio: f64, is_cliff: bool) -> String {
    if is_cliff { format!("**{}**", times(ratio)) } else { times(ratio) }
}

/// Whether a pass costs too much more than in the plain room, or a long one is new.
fn is_cliff(plain: &Room, pass: &Pass) -> bool {
    let before = plain.pass(&pass.name).map_or(0.0, |pass| pass.ms);
    pass.ms > CLIFF * before && pass.ms - before > SHORT * plain.ms()
}

fn passes(results: &Results, plain: &Room) -> String {
    let mut names: Vec<&str> = Vec::new();
    for pass in results.rooms.iter().flat_map(|room| &room.passes) {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    let head: Vec<&str> = std::iter::once("pass").chain(results.rooms.iter().map(|room| room.name.as_str())).collect();
    let cell = |room: &Room, name: &str| match (plain.pass(name), room.pass(name)) {
        (_, None) => "–".to_owned(),
        (Some(before), Some(pass)) if !std::ptr::eq(before, pass) => {
            marked(pass.ms / before.ms.max(1e-6), is_cliff(plain, pass))
        }
        (None, Some(pass)) if is_cliff(plain, pass) => format!("**{} ms**", ms(pass.ms)),
        (_, Some(pass)) => format!("{} ms", ms(pass.ms)),
    };
    let row = |name: &&str| {
        std::iter::once((*name).to_owned()).chain(results.rooms.iter().map(|room| cell(room, name))).collect()
    };
    let rows: Vec<Vec<String>> = names.iter().map(row).collect();
    table(&head, &rows)
}

fn counts(results: &Results, plain: &Room) -> String {
    let sum = |room: &Room, name: &str| -> u64 { room.passes.iter().filter_map(|pass| pass.counts.get(name)).sum() };
    let names: BTreeSet<&String> =
        results.rooms.iter().flat_map(|room| &room.passes).flat_map(|pass| pass.counts.keys()).collect();
    let mut rows = Vec::new();
    for room in &results.rooms {
        for name in &names {
            let [before, now] = [sum(plain, name), sum(room, name)];
            if before != now {
                rows.push(vec![room.name.clone(), (*name).clone(), before.to_string(), now.to_string()]);
            }
        }
    }
    table(&["room", "count", "plain", "with it"], &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(name: &str, passes: &[(&str, f64)]) -> Room {
        let pass = |&(name, ms): &(&str, f64)| Pass { name: name.to_owned(), ms, ..Pass::default() };
        Room { name: name.to_owned(), passes: passes.iter().map(pass).collect(), ..Room::default() }
    }

    #[test]
    fn cliffs_are_long_passes_that_grew_or_are_new() {
        let plain = room("plain", &[("gather", 90.0), ("tone map", 0.1), ("links", 10.0)]);
        let other = room("blend", &[("gather", 100.0), ("tone map", 0.9), ("links", 13.0), ("sweep", 40.0)]);
        let cliffs: Vec<&str> =
            other.passes.iter().filter(|pass| is_cliff(&plain, pass)).map(|pass| pass.name.as_str()).collect();
        assert_eq!(cliffs, ["links", "sweep"]);
    }
}
