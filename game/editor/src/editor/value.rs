//! A value as RON writes it, as a tree that widgets can change.

/// A literal, or a group with what stands before its bracket.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Value {
    /// A literal with its quotes, or the name before a group, which may be empty.
    pub head: String,
    /// The bracketed rest.
    pub group: Option<Group>,
}

/// What stands in brackets.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// `(`, `[` or `{`.
    pub open: char,
    /// Elements, with their keys as written where they have one.
    pub items: Vec<(Option<String>, Value)>,
}

impl Value {
    /// A literal or the name of a variant.
    pub fn literal(text: impl Into<String>) -> Self {
        Self { head: text.into(), group: None }
    }

    /// Text in quotes.
    pub fn text(text: &str) -> Self {
        let escaped: String = text.chars().flat_map(|c| escape(c).into_iter()).collect();
        Self::literal(format!("\"{escaped}\""))
    }

    /// Reads one value; none if the text is not exactly one.
    pub fn parse(text: &str) -> Option<Self> {
        let mut reader = Reader { text, at: 0 };
        let value = reader.value(0)?;
        reader.skip_blank();
        (reader.at == text.len()).then_some(value)
    }

    /// The value on one line.
    pub fn print(&self) -> String {
        let Some(group) = &self.group else { return self.head.clone() };
        let items = group.items.iter().map(|(key, value)| match key {
            Some(key) => format!("{key}:{}", value.print()),
            None => value.print(),
        });
        let items = items.collect::<Vec<_>>().join(",");
        format!("{}{}{items}{}", self.head, group.open, closing(group.open))
    }

    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<&Value> {
        let items = &self.group.as_ref()?.items;
        items.iter().find(|(key, _)| key.as_deref() == Some(name)).map(|(_, value)| value)
    }

    /// The field of that name, to change it.
    pub fn field_mut(&mut self, name: &str) -> Option<&mut Value> {
        let items = &mut self.group.as_mut()?.items;
        items.iter_mut().find(|(key, _)| key.as_deref() == Some(name)).map(|(_, value)| value)
    }

    /// Sets a field; adds it if there is none.
    pub fn set(&mut self, name: &str, value: Value) {
        let group = self.group.get_or_insert_with(|| Group { open: '(', items: Vec::new() });
        match group.items.iter_mut().find(|(key, _)| key.as_deref() == Some(name)) {
            Some((_, old)) => *old = value,
            None => group.items.push((Some(name.to_owned()), value)),
        }
    }

    /// Takes a field away.
    pub fn remove(&mut self, name: &str) {
        if let Some(group) = &mut self.group {
            group.items.retain(|(key, _)| key.as_deref() != Some(name));
        }
    }

    /// The elements; none of a literal.
    pub fn items(&self) -> &[(Option<String>, Value)] {
        self.group.as_ref().map_or(&[], |group| &group.items)
    }

    /// The number that it is.
    pub fn number(&self) -> Option<f64> {
        self.group.is_none().then(|| self.head.parse().ok()).flatten()
    }

    /// The numbers of a tuple.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        self.items().iter().map(|(key, value)| value.number().filter(|_| key.is_none())).collect()
    }

    /// A tuple of numbers, written as 32-bit floats.
    pub fn tuple(numbers: &[f32]) -> Self {
        let items = numbers.iter().map(|n| (None, Self::literal(float(f64::from(*n), true)))).collect();
        Self { head: String::new(), group: Some(Group { open: '(', items }) }
    }

    /// The text in the quotes.
    pub fn unquoted(&self) -> Option<String> {
        ron::from_str(&self.head).ok().filter(|_| self.group.is_none() && self.head.starts_with('"'))
    }
}

/// A number in the shortest form that reads back as the same 32- or 64-bit float.
pub fn float(value: f64, single: bool) -> String {
    match single {
        true => format!("{:?}", value as f32),
        false => format!("{value:?}"),
    }
}

fn escape(c: char) -> Vec<char> {
    match c {
        '"' | '\\' => vec!['\\', c],
        '\n' => vec!['\\', 'n'],
        _ => vec![c],
    }
}

fn closing(open: char) -> char {
    match open {
        '(' => ')',
        '[' => ']',
        _ => '}',
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

/// Deeper than what scene files may hold.
const MAX_DEPTH: usize = 150;

impl Reader<'_> {
    fn value(&mut self, depth: usize) -> Option<Value> {
        self.skip_blank();
        let head = self.head()?;
        self.skip_blank();
        let Some(open) = self.peek().filter(|c| matches!(c, '(' | '[' | '{')) else {
            return (!head.is_empty()).then(|| Value::literal(head));
        };
        if depth == MAX_DEPTH {
            return None;
        }
        self.at += 1;
        Some(Value { head, group: Some(Group { open, items: self.items(closing(open), depth + 1)? }) })
    }

    fn items(&mut self, close: char, depth: usize) -> Option<Vec<(Option<String>, Value)>> {
        let mut items = Vec::new();
        loop {
            self.skip_blank();
            if self.peek()? == close {
                self.at += 1;
                return Some(items);
            }
            let begin = self.at;
            let first = self.value(depth)?;
            let key = self.text[begin..self.at].trim().to_owned();
            self.skip_blank();
            if self.peek()? == ':' {
                self.at += 1;
                items.push((Some(key), self.value(depth)?));
            } else {
                items.push((None, first));
            }
            self.skip_blank();
            match self.peek()? {
                ',' => self.at += 1,
                c if c == close => {}
                _ => return None,
            }
        }
    }

    fn head(&mut self) -> Option<String> {
        let begin = self.at;
        if self.peek() == Some('"') {
            let mut escaped = false;
            let inner = &self.text[self.at + 1..];
            let end = inner.find(|c| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            })?;
            self.at += end + 2;
        } else {
            let rest = &self.text[self.at..];
            self.at += rest.find(|c: char| c.is_whitespace() || "()[]{},:\"".contains(c)).unwrap_or(rest.len());
        }
        Some(self.text[begin..self.at].to_owned())
    }

    fn skip_blank(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn values_print_as_they_were_read() {
        for text in
            ["1.5", "\"a (\\\"b\\\"), c\"", "(a:1,b:Spot(inner:2,outer:3),c:(4,5))", "{\"x/y\":(),\"z\":[1,2]}", "Off"]
        {
            assert_eq!(Value::parse(text).unwrap().print(), text);
        }
        for text in ["", "(", "(a:1", "1 2", "\"a", "(a:)", "(a b)"] {
            assert_eq!(Value::parse(text), None, "{text}");
        }
    }

    #[test]
    fn fields_change() {
        let mut value = Value::parse("(kind:Point,color:(1.0,1.0,1.0))").unwrap();
        value.set("kind", Value::literal("Directional"));
        value.set("range", Value::literal("4.0"));
        value.remove("color");
        assert_eq!(value.print(), "(kind:Directional,range:4.0)");
        assert_eq!(Value::text("a\"b\\").unquoted().as_deref(), Some("a\"b\\"));
        assert_eq!(Value::tuple(&[0.1, 2.0]).print(), "(0.1,2.0)");
    }
}
