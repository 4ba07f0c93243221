//! From a RON text to the shape of its values.

use super::tree::{Group, Item, Node, closing, unquote};
use std::ops::Range;

/// Where the strings of a text stand.
pub(in crate::files) fn strings(text: &str) -> Vec<Range<usize>> {
    let mut scanner = Scanner::new(text);
    let mut found = Vec::new();
    loop {
        scanner.skip_blank();
        let start = scanner.at;
        scanner.head();
        match (scanner.at > start, scanner.peek()) {
            (true, _) if text[start..scanner.at].contains('"') => found.push(start..scanner.at),
            (true, _) => {}
            (false, Some(sign)) => scanner.at += sign.len_utf8(),
            (false, None) => return found,
        }
    }
}

impl Node {
    /// Reads the shape of a text that `ron` has accepted. Anything else gives some tree, but never a panic.
    pub fn parse(text: &str) -> Self {
        Scanner::new(text).value(0)
    }
}

/// Reads the shape of a text.
pub(in crate::files) struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

/// Beyond what `ron` reads (128), so that only texts that it refuses are cut short.
const MAX_DEPTH: usize = 200;

impl<'a> Scanner<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    pub fn value(&mut self, depth: usize) -> Node {
        self.skip_blank();
        while self.rest().starts_with("#!") {
            let end = self.rest().find(']').map_or(self.rest().len(), |i| i + 1);
            self.at += end;
            self.skip_blank();
        }
        let start = self.at;
        let head = self.head();
        let mut end = self.at;
        self.skip_blank();
        let mut group = None;
        if let Some(open) = self.peek().filter(|c| matches!(c, '(' | '[' | '{')) {
            if depth < MAX_DEPTH {
                self.at += 1;
                let start = self.at;
                let items = self.items(closing(open), depth + 1);
                let is_closed = self.at > start && self.text[..self.at].ends_with(closing(open));
                let inside = start..self.at - usize::from(is_closed);
                group = Some(Group { open, items, inside });
            } else {
                self.at = self.text.len();
            }
            end = self.at;
        }
        Node { span: start..end.max(start), head, group }
    }

    fn items(&mut self, close: char, depth: usize) -> Vec<Item> {
        let mut items: Vec<Item> = Vec::new();
        loop {
            self.skip_blank();
            match self.peek() {
                None => return items,
                Some(c) if c == close => {
                    self.at += 1;
                    return items;
                }
                Some(c @ (',' | ')' | ']' | '}' | ':')) => {
                    if let Some(last) = items.last_mut().filter(|last| c == ',' && last.comma.is_none()) {
                        last.comma = Some(self.at);
                    }
                    self.at += c.len_utf8();
                    continue;
                }
                Some(_) => {}
            }
            let before = self.at;
            let first = self.value(depth);
            self.skip_blank();
            if self.peek() == Some(':') {
                self.at += 1;
                let key_text = self.text[first.span.clone()].to_owned();
                let key = unquote(&key_text);
                let node = self.value(depth);
                let span = first.span.start..node.span.end;
                items.push(Item { key: Some(key), key_text, node, span, comma: None });
            } else {
                let span = first.span.clone();
                items.push(Item { key: None, key_text: String::new(), node: first, span, comma: None });
            }
            if self.at == before {
                self.at += self.peek().map_or(1, char::len_utf8);
            }
        }
    }

    /// A string, number or name.
    fn head(&mut self) -> String {
        let start = self.at;
        let rest = self.rest();
        let raw = rest.strip_prefix('r').map(|r| (r.len() - r.trim_start_matches('#').len(), r));
        match raw {
            Some((hashes, r)) if r[hashes..].starts_with('"') => {
                let end = format!("\"{}", "#".repeat(hashes));
                let body = &r[hashes + 1..];
                let length = body.find(&end).map_or(body.len(), |i| i + end.len());
                self.at += 2 + hashes + length;
            }
            _ if rest.starts_with('"') => self.quoted('"'),
            _ if rest.starts_with('\'') => self.quoted('\''),
            _ => {
                let stop = |c: char| c.is_whitespace() || "()[]{},:\"/".contains(c);
                self.at += rest.find(stop).unwrap_or(rest.len());
            }
        }
        self.text[start..self.at].to_owned()
    }

    fn quoted(&mut self, quote: char) {
        let mut escaped = false;
        for (i, c) in self.rest().char_indices().skip(1) {
            if c == quote && !escaped {
                self.at += i + 1;
                return;
            }
            escaped = c == '\\' && !escaped;
        }
        self.at = self.text.len();
    }

    fn skip_blank(&mut self) {
        loop {
            let rest = self.rest();
            self.at += rest.len() - rest.trim_start().len();
            let rest = self.rest();
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.at += block_comment(rest);
            } else {
                return;
            }
        }
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }
}

/// Length of the block comment (they nest) that the text starts with.
pub fn block_comment(text: &str) -> usize {
    let (mut depth, mut i, bytes) = (0usize, 0, text.as_bytes());
    while i + 1 < bytes.len() {
        match &bytes[i..i + 2] {
            b"/*" => depth += 1,
            b"*/" if depth == 1 => return i + 2,
            b"*/" => depth = depth.saturating_sub(1),
            _ => {
                i += 1;
                continue;
            }
        }
        i += 2;
    }
    text.len()
}
