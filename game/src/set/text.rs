//! Replaces one field in the RON text of a value. Text, because `ron::Value` does not keep the names of variants.

/// `text` with the field at the path written anew.
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
    let (head, parts, tail) = open(text).ok_or_else(|| format!("`{text}` has no fields, so no `{field}`"))?;
    let names: Vec<Option<&str>> = parts.iter().map(|part| name_of(part)).collect();
    let index = names.iter().position(|name| *name == Some(field)).or_else(|| {
        let number = ["x", "y", "z", "w"].iter().position(|n| n == field).or_else(|| field.parse().ok())?;
        (names.get(number) == Some(&None)).then_some(number)
    });
    let Some(index) = index else {
        let known: Vec<String> =
            names.iter().enumerate().map(|(i, name)| name.map_or(i.to_string(), str::to_owned)).collect();
        return Err(format!("there is no field `{field}`; there are {}", known.join(", ")));
    };
    let mut parts: Vec<String> = parts.into_iter().map(str::to_owned).collect();
    let prefix = names[index].map_or(String::new(), |name| format!("{name}:"));
    let inner = parts[index][prefix.len()..].to_owned();
    parts[index] = format!("{prefix}{}", replace(&inner, deeper, value)?);
    Ok(format!("{head}{}{tail}", parts.join(",")))
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
    fn values_cannot_reach_out() {
        for value in ["1,b:2", "1)", "(1", "\"a", ""] {
            assert!(replace("(a:1,b:2)", &["a"], value).is_err(), "{value}");
        }
    }
}
