//! Markdown by parts.

/// A cell of a table without a value.
pub const NONE: &str = "–";

/// A table; the first column is text, the others are numbers.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let rule: Vec<String> = (0..head.len()).map(|i| if i == 0 { "---".into() } else { "---:".into() }).collect();
    let mut text = line(&head) + &line(&rule);
    rows.iter().for_each(|row| text += &line(row));
    text
}

/// A number of milliseconds with three digits or so.
pub fn ms(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v if v >= 0.1 || v == 0.0 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

/// A relative error.
pub fn error(value: f64) -> String {
    if !value.is_finite() {
        "∞".to_owned()
    } else if value >= 10.0 {
        format!("{value:.1}")
    } else {
        format!("{value:.3}")
    }
}

/// A relative error with its sign.
pub fn signed(value: f64) -> String {
    if value.is_finite() { format!("{value:+.3}") } else { "∞".to_owned() }
}

/// A share in per cent.
pub fn percent(value: f64) -> String {
    if !value.is_finite() {
        return "∞".to_owned();
    }
    let value = 100.0 * value;
    if value.abs() >= 10.0 { format!("{value:.0} %") } else { format!("{value:.1} %") }
}

/// A factor: 12×, 3.4×, 0.05×.
pub fn times(value: f64) -> String {
    match value {
        v if v >= 10.0 => format!("{v:.0}×"),
        v if v >= 1.0 => format!("{v:.1}×"),
        v => format!("{v:.2}×"),
    }
}

/// A whole number with its thousands apart.
pub fn whole(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Bytes in MiB.
pub fn mib(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / f64::from(1 << 20))
}

/// `512×512`.
pub fn size([width, height]: [u32; 2]) -> String {
    format!("{width}×{height}")
}

/// Words joined by commas and `and`.
pub fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([ms(0.0123), ms(1.234), ms(12.34), ms(1234.5)], ["0.012", "1.23", "12.3", "1234"]);
        assert_eq!([whole(7), whole(1_234), whole(1_228_800)], ["7", "1,234", "1,228,800"]);
        assert_eq!([percent(0.0423), percent(0.76), percent(f64::INFINITY)], ["4.2 %", "76 %", "∞"]);
        assert_eq!([times(0.05), times(3.44), times(30.2)], ["0.05×", "3.4×", "30×"]);
        let words = ["a", "b", "c"].map(str::to_owned);
        assert_eq!([list(&words[..1]), list(&words[..2]), list(&words)], ["a", "a and b", "a, b and c"]);
    }

    #[test]
    fn tables_have_a_rule() {
        let text = table(&["a", "b"], &[vec!["x".into(), "1".into()]]);
        assert_eq!(text, "| a | b |\n| --- | ---: |\n| x | 1 |\n");
    }
}
