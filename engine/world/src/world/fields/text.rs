//! Reads and replaces one field in the RON text of a value. Text, because `ron::Value` does not keep the names of
//! variants, and because it is all that is known of a game's components.

/// `text` with the field at the path rewritten.
///
/// # Errors
/// If there is no such field, with the fields that exist, or `value` is not one value.
pub fn replace(text: &str, path: &[&str], value: &str) -> Result<String, String> {
    let Some((field, deeper)) = path.split_first() else {
        return match split(value).as_deref() {
            Some([_]) => Ok(value.to_owned()),
            _ => Err(format!("`{value}` is not one value")),
        };
    };
    let (head, parts, tail) = open(text).ok_or_else(|| no_fields(text, field))?;
    let (index, inner) = pick(&parts, field)?;
    let prefix = &parts[index][..parts[index].len() - inner.len()];
    let changed = format!("{prefix}{}", replace(inner, deeper, value)?);
    let mut parts = parts.clone();
    parts[index] = &changed;
    Ok(format!("{head}{}{tail}", parts.join(",")))
}

/// The text of the field at the path.
///
/// # Errors
/// If there is no such field, with the fields that exist.
pub fn get<'a>(text: &'a str, path: &[&str]) -> Result<&'a str, String> {
    let Some((field, deeper)) = path.split_first() else { return Ok(text.trim()) };
    let (_, parts, _) = open(text).ok_or_else(|| no_fields(text, field))?;
    get(pick(&parts, field)?.1, deeper)
}

/// The names of the fields of a structure, or the numbers of the elements of a tuple; none for a single value.
pub fn fields(text: &str) -> Vec<String> {
    let parts = open(text).map(|(_, parts, _)| parts).unwrap_or_default();
    parts.iter().enumerate().map(|(i, part)| name_of(part).map_or(i.to_string(), str::to_owned)).collect()
}

/// The elements of a tuple or list without names; none for anything else.
pub(super) fn elements(text: &str) -> Option<(char, Vec<&str>)> {
    let text = text.trim();
    let (head, parts, _) = open(text)?;
    let is_bare = head.len() == 1 && parts.iter().all(|part| name_of(part).is_none());
    is_bare.then_some((head.chars().next()?, parts))
}

fn no_fields(text: &str, field: &str) -> String {
    format!("`{text}` has no fields, so no `{field}`")
}

/// Number and text of the part that bears a name, or whose number it is.
fn pick<'a>(parts: &[&'a str], field: &str) -> Result<(usize, &'a str), String> {
    let names: Vec<Option<&str>> = parts.iter().map(|part| name_of(part)).collect();
    let index = names.iter().position(|name| *name == Some(field)).or_else(|| {
        let number = ["x", "y", "z", "w"].iter().position(|n| *n == field).or_else(|| field.parse().ok())?;
        (names.get(number) == Some(&None)).then_some(number)
    });
    let Some(index) = index else {
        let known: Vec<String> =
            names.iter().enumerate().map(|(i, name)| name.map_or(i.to_string(), str::to_owned)).collect();
        return Err(format!("there is no field `{field}`; there are {}", known.join(", ")));
    };
    let start = names[index].map_or(0, |name| name.len() + 1);
    Ok((index, &parts[index][start..]))
}

/// Takes `Name(a,b)`, `(a:1,b:2)` or `[a,b]` apart: what stands before and in the bracket, and the closing one.
fn open(text: &str) -> Option<(&str, Vec<&str>, &str)> {
    let begin = text.find(['(', '['])? + 1;
    let end = text.rfind([')', ']'])?;
    let parts = split(text.get(begin..end)?)?;
    (!parts.is_empty()).then_some((&text[..begin], parts, &text[end..]))
}

/// The field's name in `name:value`, as the serialiser writes it; none for an element of a tuple.
fn name_of(part: &str) -> Option<&str> {
    let (name, _) = part.split_once(':')?;
    (!name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_')).then_some(name)
}

/// Splits at the commas that are in no bracket and in no string; none if brackets or quotes do not match.
fn split(text: &str) -> Option<Vec<&str>> {
    let (mut parts, mut from, mut closing, mut quoted, mut escaped) = (Vec::new(), 0, Vec::new(), false, false);
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            _ if quoted => {}
            '(' => closing.push(')'),
            '[' => closing.push(']'),
            '{' => closing.push('}'),
            ')' | ']' | '}' => (closing.pop()? == c).then_some(())?,
            ',' if closing.is_empty() => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    if quoted || !closing.is_empty() {
        return None;
    }
    if from < text.len() {
        parts.push(&text[from..]);
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_fields_are_replaced() {
        let text = "(a:1,b:Spot(inner:2,outer:3),c:(4,5),d:\"x,(\",e:[6,7])";
        let set = |path: &[&str], value| replace(text, path, value);
        assert_eq!(set(&["a"], "9"), Ok(text.replace('1', "9")));
        assert_eq!(set(&["b", "outer"], "9"), Ok(text.replace('3', "9")));
        assert_eq!(set(&["b"], "Point"), Ok(text.replace("Spot(inner:2,outer:3)", "Point")));
        assert_eq!(set(&["c", "1"], "9"), Ok(text.replace('5', "9")));
        assert_eq!(set(&["c", "x"], "9"), Ok(text.replace('4', "9")));
        assert_eq!(set(&["e", "0"], "9"), Ok(text.replace('6', "9")));
        assert_eq!(set(&["d"], "\"y\""), Ok(text.replace("x,(", "y")));
    }

    #[test]
    fn nested_fields_are_read() {
        let text = "(a:1,b:Spot(inner:2,outer:3),c:(4,5),d:\"x,(\",e:[6,7])";
        let read = |path: &[&str]| get(text, path).map(str::to_owned).map_err(|error| error.to_string());
        assert_eq!(read(&["b", "outer"]).as_deref(), Ok("3"));
        assert_eq!(read(&["c", "y"]).as_deref(), Ok("5"));
        assert_eq!(read(&["d"]).as_deref(), Ok("\"x,(\""));
        assert!(read(&["b", "width"]).is_err_and(|error| error.ends_with("there are inner, outer")));
        assert!(read(&["a", "b"]).is_err_and(|error| error.contains("no fields")));
        assert_eq!((fields("Count(3)"), fields("3").len()), (vec!["0".to_owned()], 0));
        assert_eq!(elements("[6, 7]").map(|(open, parts)| (open, parts.len())), Some(('[', 2)));
        assert_eq!((elements("Count(3)"), elements("(a:3)")), (None, None));
    }

    #[test]
    fn values_cannot_reach_out() {
        for value in ["1,b:2", "1)", "(1", "\"a", ""] {
            assert!(replace("(a:1,b:2)", &["a"], value).is_err(), "{value}");
        }
    }
}
