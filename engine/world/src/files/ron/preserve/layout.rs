//! Which blanks and comments of a group belong to which of its items.
//!
//! An item owns the comments directly above it, without a blank line between, and those behind it on its line. All else
//! between the items belongs to the group: what stands on the line of the opening bracket, blank lines, and comments
//! that a blank line sets apart.

use crate::files::ron::scan::block_comment;
use crate::files::ron::tree::Group;
use std::ops::Range;

/// An item with what belongs to it, and the gap before.
pub struct Chunk<'t> {
    /// The part of the group, before the item's own comments.
    pub gap: &'t str,
    /// The item's own comments before it, with the blanks up to it.
    pub lead: &'t str,
    /// The item.
    pub core: Range<usize>,
    /// From the item to its comma.
    pub between: &'t str,
    /// Whether there is a comma.
    pub comma: bool,
    /// Its comments behind the comma.
    pub trail: &'t str,
}

/// The inside of a group.
pub struct Layout<'t> {
    pub chunks: Vec<Chunk<'t>>,
    /// The text before the closing bracket.
    pub tail: &'t str,
}

impl<'t> Layout<'t> {
    pub fn of(text: &'t str, group: &Group) -> Self {
        let mut chunks: Vec<Chunk> = Vec::new();
        let mut at = group.inside.start;
        for (index, item) in group.items.iter().enumerate() {
            let before = &text[at..item.span.start];
            let own = at + own_start(before);
            let next = group.items.get(index + 1).map(|next| next.span.start);
            let (between, rest) = match item.comma {
                Some(comma) => (item.span.end..comma, comma + 1),
                None => (item.span.end..item.span.end, item.span.end),
            };
            let end = rest + trail_length(&text[rest..next.unwrap_or(group.inside.end)], next.is_none());
            chunks.push(Chunk {
                gap: &text[at..own],
                lead: &text[own..item.span.start],
                core: item.span.clone(),
                between: &text[between],
                comma: item.comma.is_some(),
                trail: &text[rest..end],
            });
            at = end;
        }
        Self { chunks, tail: &text[at..group.inside.end] }
    }

    /// The indentation of items that begin a line; none if all stand on the line of the bracket.
    pub fn indent(&self) -> Option<&'t str> {
        self.chunks.iter().find_map(|chunk| {
            let line = chunk.gap.trim_end_matches([' ', '\t']);
            line.ends_with('\n').then(|| &chunk.gap[line.len()..])
        })
    }
}

/// The comments in what is neither value nor bracket, without the ends of their lines.
fn comments(blank: &str) -> Vec<Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 0);
    loop {
        let rest = &blank[at..];
        let start = at + rest.len() - rest.trim_start().len();
        let rest = &blank[start..];
        let length = if rest.starts_with("//") {
            let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
            line.strip_suffix('\r').unwrap_or(line).len()
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else {
            // A stray sign, such as a second comma, is no comment.
            match rest.chars().next() {
                Some(sign) => {
                    at = start + sign.len_utf8();
                    continue;
                }
                None => return found,
            }
        };
        found.push(start..start + length);
        at = start + length;
    }
}

/// Where an item's own comments begin in what stands before it.
fn own_start(before: &str) -> usize {
    let mut start = before.len();
    for comment in comments(before).into_iter().rev() {
        let lines = before[comment.end..start].matches('\n').count();
        let begins_a_line = before[..comment.start].contains('\n');
        if lines > 1 || (lines == 1 && !begins_a_line) {
            break;
        }
        start = comment.start;
    }
    start
}

/// How much of what follows an item are comments on its line. Those before the next item on the same line are that one's.
fn trail_length(after: &str, is_last: bool) -> usize {
    let mut end = 0;
    for comment in comments(after) {
        if after[end..comment.start].contains('\n') {
            break;
        }
        end = comment.end;
        if after[comment].starts_with("//") {
            return end;
        }
    }
    if is_last || after[end..].contains('\n') { end } else { 0 }
}

/// Whether the text ends in a comment that only the end of the line ends.
pub fn ends_in_line_comment(blank: &str) -> bool {
    comments(blank).last().is_some_and(|last| last.end == blank.len() && blank[last.clone()].starts_with("//"))
}
