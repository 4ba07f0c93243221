//! A group put together again: items that stay in their places, and between them those that come.

use super::layout::{Layout, ends_in_line_comment};
use super::old::Old;
use super::style::{Style, indent_at, reindented};
use crate::files::ron::tree::Group;

/// The text of an item with all that belongs to it.
pub struct Body {
    /// From its comments to the end of its value.
    core: String,
    between: String,
    comma: bool,
    trail: String,
}

impl Body {
    /// An item without comments.
    pub fn bare(core: String) -> Self {
        Self { core, between: String::new(), comma: true, trail: String::new() }
    }

    fn write(&self, out: &mut String) {
        let comma = if self.comma { "," } else { "" };
        out.extend([&*self.core, &self.between, comma, &self.trail]);
    }
}

/// An item of the group as it will be.
pub struct Row {
    /// Its place among the items before, if it stays there.
    index: Option<usize>,
    /// Its key.
    pub key: Option<String>,
    body: Body,
    gap: Option<String>,
}

impl Row {
    /// An item that stays where it is.
    pub fn kept(shape: &Shape, index: usize, core: String, key: Option<String>) -> Self {
        let chunk = &shape.layout.chunks[index];
        let core = format!("{}{core}", chunk.lead);
        let (between, trail) = (chunk.between.to_owned(), chunk.trail.to_owned());
        Self { index: Some(index), key, body: Body { core, between, comma: chunk.comma, trail }, gap: None }
    }

    /// An item that comes.
    pub fn new(body: Body, key: Option<String>) -> Self {
        Self { index: None, key, body, gap: None }
    }
}

/// The shape of a group.
pub struct Shape<'t> {
    pub layout: Layout<'t>,
    /// Indentation of its items' lines; none for a group of one line.
    pub lines: Option<String>,
    /// Indentation of the line that it begins on.
    pub outer: String,
}

impl<'t> Shape<'t> {
    /// The shape of a group; an empty one `opens` for its first item, or not.
    pub fn of(old: Old<'t>, group: &Group, style: &Style, opens: bool) -> Self {
        let layout = Layout::of(old.text, group);
        let outer = indent_at(old.text, old.node.span.start).to_owned();
        let opened = layout.chunks.is_empty() && (opens || layout.tail.contains('\n'));
        let lines = layout.indent().map(str::to_owned).or(opened.then(|| format!("{outer}{}", style.unit)));
        Self { layout, lines, outer }
    }

    /// The text of the group with its new items.
    pub fn assembled(&self, old: Old, group: &Group, style: &Style, mut rows: Vec<Row>) -> String {
        let mut stays = vec![false; self.layout.chunks.len()];
        rows.iter().filter_map(|row| row.index).for_each(|index| stays[index] = true);
        let (gaps, mut tail) = gaps(&self.layout, &stays);
        for row in &mut rows {
            row.gap = row.index.map(|index| gaps[index].clone());
        }
        let fresh = self.lines.as_ref().map_or(" ".to_owned(), |lines| format!("{}{lines}", style.newline));
        self.begin(&mut rows, &mut tail, &fresh, style);
        let (last, ends_with_comma) = (rows.len().wrapping_sub(1), self.ends_with_comma());
        let mut out = old.text[old.node.span.start..group.inside.start].to_owned();
        let mut after_comment = false;
        for (index, row) in rows.iter_mut().enumerate() {
            row.body.comma = if index == last { ends_with_comma } else { true };
            let gap = row.gap.as_ref().unwrap_or(&fresh);
            self.end_line(&mut out, gap, after_comment, style);
            out.push_str(gap);
            row.body.write(&mut out);
            after_comment = ends_in_line_comment(&row.body.trail);
        }
        self.end_line(&mut out, &tail, after_comment, style);
        out + &tail + &old.text[group.inside.end..old.node.span.end]
    }

    fn ends_with_comma(&self) -> bool {
        self.layout.chunks.last().map_or(self.lines.is_some(), |chunk| chunk.comma)
    }

    /// What comes first stands where the first item stood, behind what belongs to the bracket.
    fn begin(&self, rows: &mut [Row], tail: &mut String, fresh: &str, style: &Style) {
        match rows.iter().position(|row| row.gap.is_some()) {
            Some(0) => {}
            Some(first) => rows[0].gap = rows[first].gap.take(),
            None if rows.is_empty() => {
                if tail.trim().is_empty() {
                    tail.clear();
                }
            }
            None => {
                let end = if self.lines.is_some() { last_line(tail) } else { 0 };
                let rest = tail.split_off(end);
                let before = std::mem::replace(tail, rest);
                rows[0].gap = Some(if self.lines.is_some() { before + fresh } else { before });
                if self.lines.is_some() && !tail.contains('\n') {
                    tail.extend([style.newline, &self.outer]);
                }
            }
        }
    }

    /// Only the end of a line ends a comment of that line.
    fn end_line(&self, out: &mut String, gap: &str, after_comment: bool, style: &Style) {
        let ends = gap[..gap.len() - gap.trim_start().len()].contains('\n');
        if after_comment && !ends {
            out.extend([style.newline, self.lines.as_ref().unwrap_or(&self.outer)]);
        }
    }
}

/// Where the blanks of the last line begin, with the end of the line before.
fn last_line(tail: &str) -> usize {
    let start = tail.trim_end().len();
    let end = tail[start..].rfind('\n').map_or(start, |end| start + end);
    if tail[start..end].ends_with('\r') { end - 1 } else { end }
}

/// An item of another place with all that belongs to it.
pub fn carried(layout: &Layout, list: Old, index: usize, value: &str, shape: &Shape) -> Body {
    let chunk = &layout.chunks[index];
    let from = indent_at(list.text, chunk.core.start);
    let to = shape.lines.as_deref().unwrap_or(&shape.outer);
    let moved = |text: &str| reindented(text, from, to);
    let core = moved(&format!("{}{value}", chunk.lead));
    Body { core, between: moved(chunk.between), comma: true, trail: moved(chunk.trail) }
}

/// The gaps before items that stay, where the others are gone with their lines; and what stands before the bracket.
fn gaps(layout: &Layout, stays: &[bool]) -> (Vec<String>, String) {
    let all = layout.chunks.iter().map(|chunk| chunk.gap).chain([layout.tail]);
    let mut gaps: Vec<String> = all.map(str::to_owned).collect();
    let mut is_first = true;
    for (index, stays) in stays.iter().enumerate() {
        if *stays {
            is_first = false;
        } else {
            gaps[index + 1] = closed(&gaps[index], &gaps[index + 1], is_first);
        }
    }
    let tail = gaps.pop().unwrap_or_default();
    (gaps, tail)
}

/// The gap that is left where an item between two gaps is gone.
fn closed(before: &str, after: &str, is_first: bool) -> String {
    let blanks = [' ', '\t'];
    let (kept, rest) = (before.trim_end_matches(blanks), after.trim_start_matches(blanks));
    let ends_line = rest.starts_with(['\n', '\r']);
    match kept.strip_suffix('\n') {
        // The item had lines of its own.
        Some(line) if ends_line => format!("{}{after}", line.strip_suffix('\r').unwrap_or(line)),
        Some(_) => format!("{before}{rest}"),
        None if is_first && !ends_line => format!("{before}{rest}"),
        None => format!("{kept}{after}"),
    }
}
