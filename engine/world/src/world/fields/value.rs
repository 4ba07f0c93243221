//! Values of tracks in the form of the field that they are for.

use super::path::ron_options;
use super::text;

/// The value of a track for a field at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSample {
    /// Path of the field: component and fields, joined by dots.
    pub path: String,
    /// Its numbers.
    pub lanes: [f64; 4],
    /// How many of them count, 1 to 4.
    pub count: usize,
}

/// Numbers in the form of a field that now reads `present`: a number, a tuple or list of as many numbers, or a switch,
/// which is on from ½ up. A field that is `None` takes numbers as they are.
///
/// # Errors
/// If the field has another form: what it wants.
pub fn written(present: &str, numbers: &[f64]) -> Result<String, String> {
    let present = present.trim();
    let fault = || expected(present);
    match numbers {
        [number] => scalar(present, *number).ok_or_else(fault),
        _ if present == "None" => Ok(format!("({})", joined(numbers.iter().map(|n| float(*n))))),
        _ => {
            let (open, parts) = text::elements(present).filter(|(_, p)| p.len() == numbers.len()).ok_or_else(fault)?;
            let values: Option<Vec<String>> = parts.iter().zip(numbers).map(|(part, n)| scalar(part, *n)).collect();
            let close = if open == '(' { ')' } else { ']' };
            Ok(format!("{open}{}{close}", joined(values.ok_or_else(fault)?.into_iter())))
        }
    }
}

fn joined(values: impl Iterator<Item = String>) -> String {
    values.collect::<Vec<_>>().join(",")
}

/// The type of values that a field with the value `present` takes.
pub fn expected(present: &str) -> String {
    let present = present.trim();
    match text::elements(present) {
        _ if matches!(present, "true" | "false") => "true or false".to_owned(),
        _ if present.parse::<f64>().is_ok() => "one number".to_owned(),
        Some((_, parts)) if (2..=4).contains(&parts.len()) && parts.iter().all(|p| p.trim().parse::<f64>().is_ok()) => {
            let names = ["x", "y", "z", "w"][..parts.len()].join(", ");
            format!("({names})")
        }
        _ if present.contains('(') => format!("nothing as a whole, for it is `{present}`: name one of its numbers"),
        _ => format!("no keys, for it is `{present}`: numbers, vectors, colours and switches can be keyed"),
    }
}

fn scalar(present: &str, number: f64) -> Option<String> {
    let present = present.trim();
    match present {
        "true" | "false" => Some((number >= 0.5).to_string()),
        "None" => Some(float(number)),
        _ if present.parse::<i128>().is_ok() => Some((number.round() as i128).to_string()),
        _ if present.parse::<f64>().is_ok() => Some(float(number)),
        _ => None,
    }
}

/// The number in single precision, which keys have, as files write it.
fn float(number: f64) -> String {
    let number = number as f32;
    ron_options().to_string(&number).unwrap_or_else(|_| number.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_take_the_form_of_their_field() {
        let ok = |present, numbers: &[f64], text: &str| assert_eq!(written(present, numbers).as_deref(), Ok(text));
        ok("2.0", &[0.1_f32.into()], "0.1");
        assert_eq!(written("1e-7", &[2e-9]).unwrap_or_default().parse(), Ok(2e-9_f32));
        ok("7", &[2.6], "3");
        ok("true", &[0.49], "false");
        ok("None", &[3.0], "3.0");
        ok("None", &[3.0, 4.0], "(3.0,4.0)");
        ok("(1.0, 2)", &[0.5, 4.4], "(0.5,4)");
        ok("[1.0,2.0,3.0]", &[1.0, 0.5, -2.0], "[1.0,0.5,-2.0]");
        for (present, numbers, wanted) in [
            ("2.0", &[1.0, 2.0, 3.0][..], "one number"),
            ("(1.0,2.0,3.0)", &[1.0], "(x, y, z)"),
            ("(1.0,2.0,3.0)", &[1.0, 2.0], "(x, y, z)"),
            ("true", &[1.0, 0.0, 0.0], "true or false"),
            ("High", &[1.0], "no keys, for it is `High`: numbers, vectors, colours and switches can be keyed"),
            ("Count(3)", &[1.0], "nothing as a whole, for it is `Count(3)`: name one of its numbers"),
        ] {
            assert_eq!(written(present, numbers), Err(wanted.to_owned()), "{present}");
        }
    }
}
